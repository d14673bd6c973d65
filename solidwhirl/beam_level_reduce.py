"""From the matrices of a beam model to interface motions and fixed-interface modes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.beam_level_nodes import Layout
from solidwhirl.beam_level_planes import Family, FamilyMatrices
from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.spectrum import scale_by_stiffness, solve_standing
from solidwhirl.rotordyn.superelement import Coordinate
from solidwhirl.rotordyn.superelement_checks import MOTIONS, Component

IntArray = npt.NDArray[np.int_]

# Coordinates of one family at an interface in the plane of x, and in that of y with their signs.
_IN_X: dict[Family, tuple[tuple[Component, float], ...]] = {
    "lateral": (("ux", 1.0), ("ry", 1.0)),
    "axial": (("uz", 1.0),),
    "torsion": (("rz", 1.0),),
}
_IN_Y: tuple[tuple[Component, float], ...] = (("uy", 1.0), ("rx", -1.0))
# Matrices that are the same in both planes; the gyroscopic one couples them.
_EVEN = (0, 1, 3, 4)
_RIGID: dict[Family, tuple[int, ...]] = {"lateral": (0, 4), "axial": (2,), "torsion": (5,)}


class ReducedFamily(NamedTuple):
    """One family in Craig-Bampton form: interfaces first, then modes.

    `basis` has the rows of the nodes, also of those that follow others, `shapes` those of the
    plates as well; `free_hz` are the elastic frequencies of the free body.
    """

    family: Family
    matrices: FamilyMatrices
    basis: FloatArray
    shapes: FloatArray
    frequencies_hz: FloatArray
    free_hz: FloatArray


class FamilyMap(NamedTuple):
    """Coordinates of a family among those of the body, in the planes of x and y, (n, m) each.

    `in_y` is None where the family has one plane.
    """

    in_x: FloatArray
    in_y: FloatArray | None


class SpatialMatrices(NamedTuple):
    """M, K, G, Kσ, S in all coordinates, rigid motions (n, 6), spin generator, node motion."""

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    stiffening: FloatArray
    softening: FloatArray
    rigid: FloatArray
    generator: FloatArray
    nodes: FloatArray


def reduced_family(
    layout: Layout, whole: FamilyMatrices, family: Family, modes: int | None
) -> ReducedFamily:
    """Reduce one family of motions to the interfaces.

    Parameters
    ----------
    layout
        Nodes, with those that follow others.
    whole
        Matrices in all nodes.
    family
        Which motions.
    modes
        Fixed-interface modes kept; None keeps all.

    Returns
    -------
    ReducedFamily
    """
    per_node = 2 if family == "lateral" else 1
    tie, kept = _tied(layout, whole.mass.shape[0], per_node)
    mass, stiffness, gyroscopic, stiffening, softening = (tie.T @ m @ tie for m in whole[:5])
    position = {old: new for new, old in enumerate(kept)}
    boundary = np.array(
        [position[per_node * node + k] for node in layout.seats for k in range(per_node)]
    )
    inner = np.setdiff1d(np.arange(kept.size), boundary)
    inside = np.ix_(inner, inner)
    condensed = stiffness[np.ix_(boundary, boundary)]
    omega, shapes = np.empty(0), np.empty((inner.size, 0))
    static = np.zeros((inner.size, boundary.size))
    if inner.size:
        coupling = stiffness[np.ix_(inner, boundary)]
        static = -la.solve(stiffness[inside], coupling, assume_a="pos")
        omega, shapes = solve_standing(scale_by_stiffness(stiffness[inside], mass[inside]))
        condensed = condensed + coupling.T @ static
        static = _moving_rigidly(static, whole.rigid[kept], inner, boundary)
    count = omega.size if modes is None else min(modes, omega.size)
    # numbers far apart can leave fewer modes than coordinates
    basis = np.zeros((kept.size, boundary.size + count))
    basis[boundary, np.arange(boundary.size)] = 1.0
    basis[inner] = np.hstack((static, shapes[:, :count]))
    reduced = np.diag(np.concatenate((np.zeros(boundary.size), omega[:count] ** 2)))
    rigid = whole.rigid[kept][boundary]
    reduced[: boundary.size, : boundary.size] = _without_rigid_part(condensed, rigid, per_node)
    free, _ = solve_standing(scale_by_stiffness(stiffness, mass))
    motions = np.vstack((rigid, np.zeros((count, per_node))))
    shown = tie @ basis
    return ReducedFamily(
        family,
        FamilyMatrices(
            basis.T @ mass @ basis,
            reduced,
            basis.T @ gyroscopic @ basis,
            basis.T @ stiffening @ basis,
            basis.T @ softening @ basis,
            motions,
        ),
        shown[: per_node * layout.nodes_m.size],
        shown,
        omega[:count] / (2.0 * np.pi),
        free / (2.0 * np.pi),
    )


def _moving_rigidly(
    static: FloatArray, rigid: FloatArray, inner: IntArray, boundary: IntArray
) -> FloatArray:
    """Return static shapes whose rigid motions are exact, which stiff elements have rounded."""
    lost = rigid[inner] - static @ rigid[boundary]
    return np.asarray(static + lost @ np.linalg.pinv(rigid[boundary]))


def _tied(layout: Layout, size: int, per_node: int) -> tuple[FloatArray, FloatArray]:
    """Return all coordinates from the independent ones, and the indices of those."""
    followers = {node for node, _ in layout.ties}
    gone = [per_node * node + k for node in followers for k in range(per_node)]
    kept = np.setdiff1d(np.arange(size), gone)
    tie = np.eye(size)
    for node, leader in layout.ties:
        for k in range(per_node):
            tie[per_node * node + k, per_node * node + k] = 0.0
            tie[per_node * node + k, per_node * leader + k] = 1.0
        if per_node == 2:
            arm = layout.nodes_m[node] - layout.nodes_m[leader]
            tie[2 * node, 2 * leader + 1] = arm
    return tie[:, kept], kept


def _without_rigid_part(condensed: FloatArray, rigid: FloatArray, per_node: int) -> FloatArray:
    """Return the interface stiffness with the rounding in its rigid motions removed."""
    metric = np.ones(condensed.shape[0])
    if per_node == 2:
        length = float(np.ptp(rigid[0::2, 1])) or 1.0
        metric[1::2] = 1.0 / length
    motions = la.orth(rigid / metric[:, None])
    projector = np.eye(metric.size) - motions @ motions.T
    scaled = projector @ (metric[:, None] * condensed * metric) @ projector
    return np.asarray(scaled / np.outer(metric, metric))


def coordinates_of(
    interfaces: tuple[str, ...], families: tuple[ReducedFamily, ...]
) -> tuple[Coordinate, ...]:
    """Return the coordinates: ux to rz of each interface, then the modes family by family."""
    has = {c for f in families for c, _ in _IN_X[f.family]} | {"uy", "rx"}
    held = [
        Coordinate(kind="interface", interface=name, component=c, frequency_hz=0.0)
        for name in interfaces
        for c in MOTIONS
        if c in has
    ]
    free = [
        Coordinate(kind="modal", interface="", component="q", frequency_hz=float(f))
        for family in families
        for f in np.repeat(family.frequencies_hz, 2 if family.family == "lateral" else 1)
    ]
    return (*held, *free)


def family_maps(
    interfaces: tuple[str, ...],
    coordinates: tuple[Coordinate, ...],
    families: tuple[ReducedFamily, ...],
) -> tuple[FamilyMap, ...]:
    """Return where the coordinates of each family are among those of the body.

    Parameters
    ----------
    interfaces
        Names in the order of the boundary coordinates.
    coordinates
        From `coordinates_of`.
    families
        Lateral, and axial or torsion.

    Returns
    -------
    tuple of FamilyMap
        In the plane of x (w, θ) = (ux, ry), in that of y (uy, −rx).
    """
    size = len(coordinates)
    index = {(c.interface, c.component): k for k, c in enumerate(coordinates) if c.interface}
    start = sum(c.kind == "interface" for c in coordinates)
    found = []
    for own in families:
        pair = own.family == "lateral"
        step = 2 if pair else 1
        modal = start + step * np.arange(own.frequencies_hz.size)
        start += step * own.frequencies_hz.size
        in_x = _map(size, index, interfaces, _IN_X[own.family], modal)
        in_y = _map(size, index, interfaces, _IN_Y, modal + 1) if pair else None
        found.append(FamilyMap(in_x, in_y))
    return tuple(found)


def spatial_matrices(
    families: tuple[ReducedFamily, ...], maps: tuple[FamilyMap, ...]
) -> SpatialMatrices:
    """Put the families together in space; a body of revolution has equal planes of x and y.

    Parameters
    ----------
    families
        Lateral, and axial or torsion.
    maps
        From `family_maps`.

    Returns
    -------
    SpatialMatrices
        `nodes` is the displacement of the nodes, shape (N, 3, n).
    """
    size = len(maps[0].in_x)
    zero = np.zeros((size, size))
    found = SpatialMatrices(
        mass=zero.copy(),
        stiffness=zero.copy(),
        gyroscopic=zero.copy(),
        stiffening=zero.copy(),
        softening=zero.copy(),
        rigid=np.zeros((size, 6)),
        generator=zero.copy(),
        nodes=np.zeros((_node_count(families), 3, size)),
    )
    for own, (in_x, in_y) in zip(families, maps, strict=True):
        for k in _EVEN:
            found[k][...] += in_x @ own.matrices[k] @ in_x.T
        for column, motion in enumerate(_RIGID[own.family]):
            found.rigid[:, motion] = in_x @ own.matrices.rigid[:, column]
        if in_y is None:
            if own.family == "axial":
                found.nodes[:, 2] = own.basis @ in_x.T
            continue
        for k in _EVEN:
            found[k][...] += in_y @ own.matrices[k] @ in_y.T
        weight = own.matrices.gyroscopic
        found.gyroscopic[...] = in_x @ weight @ in_y.T - in_y @ weight @ in_x.T
        found.generator[...] = in_y @ in_x.T - in_x @ in_y.T
        found.rigid[:, 1] = in_y @ own.matrices.rigid[:, 0]
        found.rigid[:, 3] = -(in_y @ own.matrices.rigid[:, 1])
        found.nodes[:, 0], found.nodes[:, 1] = own.basis[0::2] @ in_x.T, own.basis[0::2] @ in_y.T
    return found


def _node_count(families: tuple[ReducedFamily, ...]) -> int:
    return families[0].basis.shape[0] // 2


def _map(
    size: int,
    index: dict[tuple[str, Component], int],
    interfaces: tuple[str, ...],
    components: tuple[tuple[Component, float], ...],
    modal: npt.NDArray[np.int_],
) -> FloatArray:
    """Return all coordinates from those of one family in one plane."""
    held = len(components) * len(interfaces)
    out = np.zeros((size, held + modal.size))
    for j, name in enumerate(interfaces):
        for k, (component, sign) in enumerate(components):
            out[index[name, component], len(components) * j + k] = sign
    out[modal, held + np.arange(modal.size)] = 1.0
    return out
