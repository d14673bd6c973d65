"""Families of motions of a beam model: assembly, reduction to interfaces, and all in space.

Bending in one plane, axial motion and torsion are independent in a body of revolution. Each is
assembled on the nodes and reduced to its interfaces and fixed-interface modes alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.beams.elements import Family, Segment, element_matrices
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.dense import scale_by_stiffness, solve_standing
from solidwhirl.rotordyn.superelement.record import Coordinate
from solidwhirl.rotordyn.superelement.validation import MOTIONS, Component

_FREE_MODES_LISTED = 10
# Coordinates of each family at an interface, plane by plane, with their signs.
_PLANES: Mapping[Family, tuple[tuple[tuple[Component, float], ...], ...]] = MappingProxyType(
    {
        "lateral": ((("ux", 1.0), ("ry", 1.0)), (("uy", 1.0), ("rx", -1.0))),
        "axial": ((("uz", 1.0),),),
        "torsion": ((("rz", 1.0),),),
    }
)


class Attached(NamedTuple):
    """A rigid ring fixed to a node, with moments of inertia about its own centre."""

    node: int
    z_m: float
    mass_kg: float
    polar_kg_m2: float
    diametral_kg_m2: float


class Mean(NamedTuple):
    """Surfaces of an interface at the nodes under it: area, and its second moment about y.

    The interface at `leader` follows their displacements, fitted by least squares over the area.
    """

    leader: int
    nodes: tuple[int, ...]
    area_m2: tuple[float, ...]
    second_m4: tuple[float, ...]

    def rows(self, z_m: FloatArray, family: Family) -> FloatArray:
        """Return the motion of the interface in that of the nodes, (step, nodes · step)."""
        area, second = np.array(self.area_m2), np.array(self.second_m4)
        if family != "lateral":
            weight = area if family == "axial" else second
            return np.asarray(weight[None, :] / weight.sum())
        arm = z_m[list(self.nodes)] - z_m[self.leader]
        moved = np.column_stack((area, area * arm))
        tilted = np.column_stack((0.0 * second, second))
        gram = np.column_stack((moved.sum(axis=0), arm @ moved + tilted.sum(axis=0)))
        return np.linalg.solve(gram, np.stack((moved, tilted), axis=1).reshape(-1, 2).T)


class BeamNodes(NamedTuple):
    """Places of the nodes, (N,), m; those of the interfaces; (node, leader) of rigid pieces.

    Interfaces that are not named in `means` move as their node.
    """

    z_m: FloatArray
    interfaces: tuple[int, ...]
    ties: tuple[tuple[int, int], ...] = ()
    means: tuple[Mean, ...] = ()


class FamilyMatrices(NamedTuple):
    """M, K, gyroscopic weight, Kσ and S of one family of motions, and its rigid motions.

    Lateral coordinates are w, θ of every node, others one per node; further ones may follow. The
    rigid motions are the columns of `rigid`.
    """

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    stiffening: FloatArray
    softening: FloatArray
    rigid: FloatArray


class ReducedFamily(NamedTuple):
    """One family in Craig-Bampton form: interfaces first, then modes.

    `shapes` has the rows of all coordinates of the family, also of nodes that follow others;
    `free_hz` are the elastic frequencies of the free body.
    """

    family: Family
    matrices: FamilyMatrices
    shapes: FloatArray
    frequencies_hz: FloatArray
    free_hz: FloatArray

    @property
    def planes(self) -> int:
        """Number of planes in which the family moves alike."""
        return len(_PLANES[self.family])


def per_node(family: Family) -> int:
    """Return the number of coordinates of a node."""
    return len(_PLANES[family][0])


def node_rows(nodes: Sequence[int], family: Family) -> list[int]:
    """Return the coordinates of some nodes."""
    step = per_node(family)
    return [step * node + k for node in nodes for k in range(step)]


def family_matrices(
    z_m: FloatArray,
    elements: Iterable[tuple[tuple[int, int], Segment]],
    family: Family,
    extra: int = 0,
) -> FamilyMatrices:
    """Assemble one family of motions of beams between nodes, `extra` zero rows at the end."""
    step = per_node(family)
    size = step * z_m.size + extra
    rigid = np.zeros((size, step))
    for k in range(step):
        rigid[k : step * z_m.size : step, k] = 1.0
    if family == "lateral":
        rigid[0 : step * z_m.size : step, 1] = z_m
    found = FamilyMatrices._make([*np.zeros((5, size, size)), rigid])
    for nodes, piece in elements:
        at = np.ix_(*[node_rows(nodes, family)] * 2)
        for total, local in zip(found, element_matrices(piece, family), strict=False):
            total[at] += local
    return found


def add_attached(found: FamilyMatrices, z_m: FloatArray, part: Attached, family: Family) -> None:
    """Add the inertia of a rigid ring to the assembled matrices, in place."""
    (first, *_), node = node_rows([part.node], family), part.node
    if family != "lateral":
        found.mass[node, node] += part.mass_kg if family == "axial" else part.polar_kg_m2
        return
    lever = np.array([1.0, part.z_m - z_m[node]])
    found.mass[first : first + 2, first : first + 2] += part.mass_kg * np.outer(lever, lever)
    found.mass[first + 1, first + 1] += part.diametral_kg_m2
    found.gyroscopic[first + 1, first + 1] += part.polar_kg_m2


def reduced_family(
    nodes: BeamNodes, whole: FamilyMatrices, family: Family, modes: int | None = None
) -> ReducedFamily:
    """Reduce one family of motions to the interfaces."""
    tie, kept = _tied(nodes, whole.mass.shape[0], family)
    mass, stiffness, gyroscopic, stiffening, softening = (tie.T @ m @ tie for m in whole[:5])
    boundary = np.searchsorted(kept, node_rows(nodes.interfaces, family))
    inner = np.setdiff1d(np.arange(kept.size), boundary)
    inside = np.ix_(inner, inner)
    condensed = stiffness[np.ix_(boundary, boundary)]
    omega, shapes = np.empty(0), np.empty((inner.size, 0))
    static = np.zeros((inner.size, boundary.size))
    rigid = whole.rigid[kept]
    if inner.size:
        coupling = stiffness[np.ix_(inner, boundary)]
        static = -la.solve(stiffness[inside], coupling, assume_a="pos")
        omega, shapes = solve_standing(scale_by_stiffness(stiffness[inside], mass[inside]))
        condensed = condensed + coupling.T @ static
        # rigid motions are exact, which stiff elements have rounded
        lost = rigid[inner] - static @ rigid[boundary]
        static = static + lost @ np.linalg.pinv(rigid[boundary])
    # numbers far apart can leave fewer modes than coordinates
    count = omega.size if modes is None else min(modes, omega.size)
    basis = np.zeros((kept.size, boundary.size + count))
    basis[boundary, np.arange(boundary.size)] = 1.0
    basis[inner] = np.hstack((static, shapes[:, :count]))
    reduced = np.diag(np.concatenate((np.zeros(boundary.size), omega[:count] ** 2)))
    reduced[: boundary.size, : boundary.size] = _without_rigid_part(condensed, rigid[boundary])
    free, _ = solve_standing(scale_by_stiffness(stiffness, mass))
    others = (basis.T @ m @ basis for m in (gyroscopic, stiffening, softening))
    moved = np.vstack((rigid[boundary], np.zeros((count, rigid.shape[1]))))
    return ReducedFamily(
        family,
        FamilyMatrices._make([basis.T @ mass @ basis, reduced, *others, moved]),
        tie @ basis,
        omega[:count] / (2.0 * np.pi),
        free / (2.0 * np.pi),
    )


def _tied(nodes: BeamNodes, size: int, family: Family) -> tuple[FloatArray, IntArray]:
    """Return all coordinates from the independent ones, and the indices of those."""
    kept = np.setdiff1d(np.arange(size), node_rows([node for node, _ in nodes.ties], family))
    tie = np.eye(size)
    for node, leader in nodes.ties:
        own, first = node_rows([node], family), node_rows([leader], family)
        tie[own, own], tie[own, first] = 0.0, 1.0
        if family == "lateral":
            tie[own[0], first[1]] = nodes.z_m[node] - nodes.z_m[leader]
    tie, means = tie[:, kept], np.eye(size)
    for mean in nodes.means:
        own = node_rows([mean.leader], family)
        means[own] = 0.0
        at = np.ix_(own, node_rows(mean.nodes, family))
        np.add.at(means, at, mean.rows(nodes.z_m, family))  # a node may be there twice
    return np.asarray(np.linalg.solve((means @ tie)[kept].T, tie.T).T), kept


def _without_rigid_part(condensed: FloatArray, rigid: FloatArray) -> FloatArray:
    """Return the interface stiffness with the rounding in its rigid motions removed."""
    if rigid.shape[0] == rigid.shape[1]:
        return np.zeros_like(condensed)
    metric = np.ones(condensed.shape[0])
    if rigid.shape[1] == 2:
        metric[1::2] = 1.0 / (float(np.ptp(rigid[0::2, 1])) or 1.0)
    motions = la.orth(rigid / metric[:, None])
    projector = np.eye(metric.size) - motions @ motions.T
    scaled = projector @ (metric[:, None] * condensed * metric) @ projector
    return np.asarray(scaled / np.outer(metric, metric))


def spatial_coordinates(
    interfaces: Sequence[str], families: Sequence[ReducedFamily]
) -> tuple[Coordinate, ...]:
    """Return the coordinates: ux to rz of each interface, then the modes family by family."""
    has = {c for f in families for plane in _PLANES[f.family] for c, _ in plane}
    held = [
        Coordinate(kind="interface", interface=name, component=c, frequency_hz=0.0)
        for name in interfaces
        for c in MOTIONS
        if c in has
    ]
    free = [
        Coordinate(kind="modal", interface="", component="q", frequency_hz=float(f))
        for family in families
        for f in np.repeat(family.frequencies_hz, family.planes)
    ]
    return (*held, *free)


def family_maps(
    interfaces: Sequence[str], families: Sequence[ReducedFamily]
) -> list[tuple[FloatArray, ...]]:
    """Return all coordinates from those of each family, plane by plane, (n, m) each."""
    coordinates = spatial_coordinates(interfaces, families)
    index = {(c.interface, c.component): k for k, c in enumerate(coordinates) if c.interface}
    start, found = len(index), []
    for own in families:
        planes, count = _PLANES[own.family], own.frequencies_hz.size
        maps = []
        for p, components in enumerate(planes):
            held = len(components) * len(interfaces)
            out = np.zeros((len(coordinates), held + count))
            for j, (name, (component, sign)) in enumerate(
                (name, pair) for name in interfaces for pair in components
            ):
                out[index[name, component], j] = sign
            modal = np.arange(count)
            out[start + p + len(planes) * modal, held + modal] = 1.0
            maps.append(out)
        start += len(planes) * count
        found.append(tuple(maps))
    return found


def spatial_fields(
    interfaces: Sequence[str], families: Sequence[ReducedFamily], node_count: int
) -> dict[str, Any]:
    """Return what the families tell of a superelement, by the names of its fields."""
    coordinates, maps = spatial_coordinates(interfaces, families), family_maps(interfaces, families)
    size = len(coordinates)
    mass, stiffness, gyroscopic, stiffening, softening, generator = np.zeros((6, size, size))
    rigid, nodes = np.zeros((size, 6)), np.zeros((node_count, 3, size))
    for own, planes in zip(families, maps, strict=True):
        m, k, weight, k_sigma, s, motions = own.matrices
        step = per_node(own.family)
        for plane, components in zip(planes, _PLANES[own.family], strict=True):
            for total, part in ((mass, m), (stiffness, k), (stiffening, k_sigma), (softening, s)):
                total += plane @ part @ plane.T
            for column, (component, sign) in enumerate(components):
                rigid[:, MOTIONS.index(component)] = sign * (plane @ motions[:, column])
                if component in ("ux", "uy", "uz"):
                    moved = own.shapes[: step * node_count : step]
                    nodes[:, MOTIONS.index(component)] = moved @ plane.T
        if len(planes) == 2:
            in_x, in_y = planes
            # Ip (rx ry' − ry rx'); a small turn moves the plane of x into that of y
            gyroscopic += in_x @ weight @ in_y.T - in_y @ weight @ in_x.T
            generator += in_y @ in_x.T - in_x @ in_y.T
    has = {c.component for c in coordinates}
    lateral = [np.repeat(f.free_hz, f.planes) for f in families if f.family == "lateral"]
    free = np.sort(np.concatenate([*lateral, np.empty(0)]))
    return {
        "level": "beam",
        "harmonics": (),
        "coordinates": coordinates,
        "mass": mass,
        "stiffness": stiffness,
        "gyroscopic": gyroscopic,
        "stress_stiffening": stiffening,
        "spin_softening": softening,
        "rigid_body_modes": rigid,
        "rigid_body_present": np.array([motion in has for motion in MOTIONS]),
        "full_dofs": sum(f.planes * per_node(f.family) * node_count for f in families),
        "maximum_speed_rad_s": np.inf,
        "recovery_modes": nodes,
        "free_frequencies_hz": free[:_FREE_MODES_LISTED],
        "fixed_interface_frequencies_hz": np.concatenate(
            [np.repeat(f.frequencies_hz, f.planes) for f in families]
        ),
        "frequency_error_estimate": np.empty(0),
        "spin_generator": generator,
    }
