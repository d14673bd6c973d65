"""Stepped shafts with disks: what a beam model is made from, checked, with its nodes placed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import SuperelementError

# Places closer than this fraction of the length are the same node.
_SAME_PLACE = 1e-9


@dataclass(frozen=True, kw_only=True)
class Disk:
    """Describe a rigid disk on a shaft.

    Attributes
    ----------
    position_m
        Along the axis, m.
    mass_kg, polar_kg_m2, diametral_kg_m2
        Mass, polar and diametral moment of inertia about its own centre.
    """

    name: str
    position_m: float
    mass_kg: float
    polar_kg_m2: float
    diametral_kg_m2: float


class ShaftMaterial(NamedTuple):
    """Young's modulus, Poisson's ratio (E/2G − 1 for a shear modulus G) and density."""

    youngs_modulus_pa: float
    poissons_ratio: float
    density_kg_m3: float


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Shaft(ReadOnlyArrays):
    """Hold a checked shaft whose nodes include all interfaces and disks.

    `nodes_m`: shape (N,), increasing, m.
    `outer_radius_m`, `inner_radius_m`: between the nodes, shape (N − 1,), m.
    `interfaces`: axial position by name, m.
    """

    nodes_m: FloatArray
    outer_radius_m: FloatArray
    inner_radius_m: FloatArray
    material: ShaftMaterial
    interfaces: Mapping[str, float]
    disks: tuple[Disk, ...]

    def node_at(self, position_m: float) -> int:
        """Return the index of the node nearest to a position."""
        return int(np.abs(self.nodes_m - position_m).argmin())

    def provenance(self) -> dict[str, Any]:
        """Return all that defines the shaft, in JSON types."""
        return {
            "model": "Timoshenko beam, consistent mass, shear coefficient of Cowper (1966)",
            "nodes_m": self.nodes_m.tolist(),
            "outer_radius_m": self.outer_radius_m.tolist(),
            "inner_radius_m": self.inner_radius_m.tolist(),
            **{key: float(value) for key, value in self.material._asdict().items()},
            "disks": [asdict(disk) for disk in self.disks],
        }


def checked_shaft(
    name: str,
    stations_m: FloatArray,
    outer_radius_m: FloatArray,
    inner_radius_m: FloatArray,
    material: ShaftMaterial,
    interfaces: Mapping[str, float],
    disks: tuple[Disk, ...],
) -> Shaft:
    """Check a shaft and place its nodes.

    `stations_m`: section ends, increasing, shape (N,), m; radii: shape (N − 1,) or a single number,
    m; `interfaces`: axial position by name, m. Returns a shaft with a node at each station,
    interface and disk. Raises SuperelementError for the first thing out of range.
    """
    where = f"beam {name!r}"
    if stations_m.ndim != 1 or stations_m.size < 2 or not np.isfinite(stations_m).all():
        raise SuperelementError(f"{where}: stations_m needs two or more finite numbers in a row")
    if (np.diff(stations_m) <= 0).any():
        at = int(np.argmax(np.diff(stations_m) <= 0)) + 1
        raise SuperelementError(
            f"{where}: stations_m[{at}] is {stations_m[at]}, not above {stations_m[at - 1]}"
        )
    radii = _checked_radii(where, stations_m.size - 1, outer_radius_m, inner_radius_m)
    _check_material(where, material)
    _check_places(where, stations_m, interfaces, disks)
    places = [*interfaces.values(), *(disk.position_m for disk in disks)]
    nodes = _with_nodes(stations_m, places)
    section = np.searchsorted(stations_m, 0.5 * (nodes[:-1] + nodes[1:])) - 1
    return Shaft(
        nodes_m=nodes,
        outer_radius_m=radii[0][section],
        inner_radius_m=radii[1][section],
        material=material,
        interfaces=interfaces,
        disks=disks,
    )


def _check_material(where: str, material: ShaftMaterial) -> None:
    modulus, ratio, density = material
    allowed = {
        "youngs_modulus_pa": (np.isfinite(modulus) and modulus > 0, "positive"),
        "poissons_ratio": (-1.0 < ratio <= 0.5, "in (-1, 0.5]"),
        "density_kg_m3": (np.isfinite(density) and density > 0, "positive"),
    }
    for (label, (passed, said)), value in zip(allowed.items(), material, strict=True):
        if not passed:
            raise SuperelementError(f"{where}: {label} is {value}; it must be {said}")


def _checked_radii(
    where: str, count: int, outer_radius_m: FloatArray, inner_radius_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    full = []
    named = {"outer_radius_m": outer_radius_m, "inner_radius_m": inner_radius_m}
    for label, radius in named.items():
        if radius.shape not in ((), (1,), (count,)) or not np.isfinite(radius).all():
            raise SuperelementError(
                f"{where}: {label} has shape {radius.shape}; one finite number or {count}, one "
                "for each section, are allowed"
            )
        full.append(np.broadcast_to(radius, (count,)).copy())
    outer, inner = full
    bad = (inner < 0) | (inner >= outer)
    if bad.any():
        at = int(np.argmax(bad))
        raise SuperelementError(
            f"{where}: section {at} has inner radius {inner[at]} m and outer radius {outer[at]} m;"
            " 0 <= inner < outer is needed"
        )
    return outer, inner


def _check_places(
    where: str, stations_m: FloatArray, interfaces: Mapping[str, float], disks: tuple[Disk, ...]
) -> None:
    start, stop = float(stations_m[0]), float(stations_m[-1])
    slack = _SAME_PLACE * (stop - start)
    if not interfaces:
        raise SuperelementError(f"{where}: interface_stations is empty; name at least one")
    placed = [(f"interface {key!r}", z) for key, z in interfaces.items()]
    placed += [(f"disk {disk.name!r}", disk.position_m) for disk in disks]
    for label, z in placed:
        if not start - slack <= z <= stop + slack:
            raise SuperelementError(
                f"{where}: {label} is at {z} m, off the shaft from {start} to {stop} m"
            )
    ordered = sorted(interfaces.items(), key=lambda item: item[1])
    for (first, low), (second, high) in pairwise(ordered):
        if high - low <= slack:
            raise SuperelementError(
                f"{where}: interfaces {first!r} and {second!r} are both at {low} m; use one"
            )
    for disk in disks:
        for label in ("mass_kg", "polar_kg_m2", "diametral_kg_m2"):
            value = getattr(disk, label)
            if not (np.isfinite(value) and value >= 0):
                raise SuperelementError(
                    f"{where}: disk {disk.name!r}: {label} is {value}; allowed is 0 or more"
                )


def _with_nodes(stations_m: FloatArray, places: list[float]) -> FloatArray:
    """Return the stations with the places added that are not among them yet."""
    nodes = list(stations_m)
    slack = _SAME_PLACE * (stations_m[-1] - stations_m[0])
    for place in places:
        if min(abs(place - node) for node in nodes) > slack:
            nodes.append(place)
    return np.sort(np.array(nodes))
