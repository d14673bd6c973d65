"""Surfaces of the bodies as the viewer of mode shapes draws them: few points, rigid disks too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.superelement_checks import MOTIONS
from solidwhirl.rotordyn.surface import Surface, beam_surface
from solidwhirl.surface_files import shown_surface

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Distance of points along an outline over the length of the engine, and turn [rad] at a corner.
_SPACING, _CORNER = 0.035, 0.12
# Points of a solid's surface.
MOST_POINTS = 2500
# Half the thickness of a rigid disk over its radius, as no scene tells it.
_FLAT = 0.06


class Piece(NamedTuple):
    """A surface of a body, and whether it is one of its rigid disks."""

    body: str
    surface: Surface
    is_disk: bool = False


class BeamDisk(NamedTuple):
    """A rigid disk of a beam: its place along the axis, mass and polar inertia."""

    at_m: float
    mass_kg: float
    polar_kg_m2: float


def pieces_of(
    elements: Mapping[str, Superelement], disks: Mapping[str, Sequence[BeamDisk]]
) -> tuple[Piece, ...]:
    """Return the surfaces of the bodies and of their rigid disks, with fewer points.

    Parameters
    ----------
    elements
        The bodies by name; those that know no surface have none.
    disks
        Rigid disks of beams, whose elements do not tell them, by the name of the body.
    """
    surfaces = {name: shown_surface(element) for name, element in elements.items()}
    ends = [
        s.points_m[:, 0 if s.kind == "meridian" else 2] for s in surfaces.values() if s is not None
    ]
    length = float(np.ptp(np.concatenate(ends))) if ends else 1.0
    found: list[Piece] = []
    for name, element in elements.items():
        surface = surfaces[name]
        if surface is not None:
            found.append(Piece(name, thinned(surface, _SPACING * length)))
        for disk in (*disks_at_interfaces(element), *disks_on_beam(element, disks.get(name, ()))):
            found.append(Piece(name, disk, True))
    return tuple(found)


def thinned(surface: Surface, spacing_m: float) -> Surface:
    """Return a surface with fewer points: corners of a meridian, clusters of a solid.

    Parameters
    ----------
    surface
        The surface.
    spacing_m
        Largest distance of points along the outline of a meridian.
    """
    if surface.kind == "solid":
        return _clustered(surface)
    chains = outline_chains(surface.cells)
    kept: list[IntArray] = [
        chain[_kept_of_chain(surface.points_m[chain], spacing_m)] for chain in chains
    ]
    points = np.unique(np.concatenate(kept)) if kept else np.empty(0, dtype=np.int64)
    new = np.full(len(surface.points_m), -1)
    new[points] = np.arange(points.size)
    cells = [np.column_stack([new[k[:-1]], new[k[1:]]]) for k in kept if k.size > 1]
    return replace(
        surface,
        points_m=surface.points_m[points],
        cells=np.concatenate(cells) if cells else np.empty((0, 2), dtype=np.int64),
        amplitudes=surface.amplitudes[points],
    )


def outline_chains(cells: IntArray) -> list[IntArray]:
    """Return the points of an outline in order, one array for each loop or open piece.

    Parameters
    ----------
    cells
        Edges (c, 2), each from its first to its second point.

    Returns
    -------
    list of ndarray
        A closed loop has its first point at its end again.
    """
    after: dict[int, list[int]] = {}
    arrives: dict[int, int] = {}
    for first, second in cells.tolist():
        after.setdefault(first, []).append(second)
        arrives[second] = arrives.get(second, 0) + 1
    chains = []
    # open pieces begin where nothing arrives
    starts = [p for p in after if p not in arrives] + list(after)
    for start in starts:
        while after.get(start):
            chain = [start]
            while after.get(chain[-1]):
                chain.append(after[chain[-1]].pop())
                if chain[-1] == start:
                    break
            chains.append(np.array(chain))
    return chains


def _kept_of_chain(points: FloatArray, spacing: float) -> IntArray:
    """Places along a chain that are its ends, corners, or far from the last one kept."""
    last = len(points) - 1
    step = np.diff(points, axis=0)
    angle = np.arctan2(step[:, 1], step[:, 0])
    kept, before, direction = [0], points[0], angle[0]
    for k in range(1, last):
        turn = abs((angle[k] - direction + np.pi) % (2.0 * np.pi) - np.pi)
        if turn > _CORNER or np.hypot(*(points[k + 1] - before)) > spacing:
            kept.append(k)
            before, direction = points[k], angle[k]
    return np.array([*kept, last])


def _clustered(surface: Surface) -> Surface:
    """A solid's surface with one point for each small box that has some."""
    points = surface.points_m
    if len(points) <= MOST_POINTS:
        return surface
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    box = size / 400.0
    while True:
        place = np.floor((points - low) / box).astype(np.int64)
        _, first, group = np.unique(place, axis=0, return_index=True, return_inverse=True)
        if first.size <= MOST_POINTS:
            break
        box *= 1.12
    cells = group.reshape(-1)[surface.cells]
    flat = (
        (cells[:, 0] == cells[:, 1]) | (cells[:, 1] == cells[:, 2]) | (cells[:, 2] == cells[:, 0])
    )
    return replace(
        surface,
        points_m=points[first],
        cells=cells[~flat],
        amplitudes=surface.amplitudes[first],
    )


def disks_at_interfaces(element: Superelement) -> list[Surface]:
    """Return the surfaces of the rigid disks at the interfaces of a body.

    Parameters
    ----------
    element
        The body, whose provenance tells its disks.
    """
    found = []
    for record in element.provenance.get("rigid_disks", ()):
        mass, polar = float(record["mass_kg"]), float(record["polar_kg_m2"])
        node = element.interface_node(record["interface"])
        rows: dict[str, FloatArray] = {c: np.zeros(element.size) for c in MOTIONS}
        for component in element.components_at(node.name):
            rows[component][element.interface_index(node.name, component)] = 1.0
        at = float(node.position_m[2])
        if mass > 0.0 and polar > 0.0:
            place = at + float(record["offset_m"])
            found.append(disk_surface(place, place - at, float(np.sqrt(2.0 * polar / mass)), rows))
    return found


def disks_on_beam(element: Superelement, disks: Sequence[BeamDisk]) -> list[Surface]:
    """Return the surfaces of the rigid disks of a beam.

    Parameters
    ----------
    element
        The beam; its points lie on the axis.
    disks
        Its disks.
    """
    places = element.recovery_points_m[:, 2]
    if places.size < 2 or not (np.diff(places) > 0.0).all():
        return []
    moved = element.recovery_modes
    slopes = np.gradient(moved, places, axis=0)
    found = []
    for disk in disks:
        if not (disk.mass_kg > 0.0 and disk.polar_kg_m2 > 0.0):
            continue
        at = int(np.abs(places - disk.at_m).argmin())
        rows: dict[str, FloatArray] = dict(zip(MOTIONS[:3], moved[at], strict=True))
        rows |= {"rx": -slopes[at, 1], "ry": slopes[at, 0], "rz": np.zeros(element.size)}
        radius = float(np.sqrt(2.0 * disk.polar_kg_m2 / disk.mass_kg))
        found.append(disk_surface(disk.at_m, disk.at_m - float(places[at]), radius, rows))
    return found


def disk_surface(
    place_m: float, arm_m: float, radius_m: float, rows: Mapping[str, FloatArray]
) -> Surface:
    """Return the surface of a rigid disk: that of a uniform one of the same mass and inertia.

    Parameters
    ----------
    place_m
        Of its centre along the axis.
    arm_m
        Distance of the centre from the point that carries it.
    radius_m
        √(2 I/m) of a uniform disk.
    rows
        Motions "ux" to "rz" of that point per coordinate of the body, shape (n,) each.
    """
    half = _FLAT * radius_m * np.array([-1.0, 1.0])
    planes = []
    for moved, slope in ((rows["ux"], rows["ry"]), (rows["uy"], -rows["rx"])):
        plane = np.zeros((4, moved.size))
        plane[0::2] = moved + np.outer(arm_m + half, slope)
        plane[1::2] = slope
        planes.append(plane)
    return beam_surface(
        place_m + half,
        np.array([radius_m]),
        np.array([0.0]),
        (planes[0], planes[1]),
        np.tile(rows["uz"], (2, 1)),
        np.tile(rows["rz"], (2, 1)),
    )
