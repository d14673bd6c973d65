"""Annular plates of a beam model: thick plates in one circumferential order, by radius.

For order 1, a plate moves by u_z = −ζ cos φ, u_r = (U + x ψ) cos φ, u_φ = −(V + x χ) sin φ with x
from its middle plane; a tilt θ about y is ζ = θ r, ψ = χ = θ, a shift w is U = V = w. For order 0
the same with cos 0, the twist being V alone.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.beam_level_profile import Cell, Plate
from solidwhirl.beam_level_radial import Line, Wall, line_of, plate_center_m, wall_of
from solidwhirl.beam_level_stress import Spin, spin_of
from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.spectrum import scale_by_stiffness, solve_standing

# Fields per motion of the plate and their order; "tilt" and "shift" are of circumferential order 1.
PlateMotion = Literal["tilt", "shift", "axial", "torsion"]

# Modes with held edges that a plate keeps: those beyond are far above a shaft's.
PLATE_MODES = 3


class Edge(NamedTuple):
    """How an edge of a plate is held.

    Attributes
    ----------
    root
        Built into a column: stiffness between its rotation and the column's, moment per angle and
        length, N. None at a node that holds a rim.
    rigid
        At a rim: the whole rim moves as a rigid circle; otherwise the node is its mean.
    """

    root: float | None
    rigid: bool = False


class PlateMatrices(NamedTuple):
    """Matrices of one motion in (inner edge, outer edge, modes), edges only if they are held.

    `gyroscopic` is the symmetric weight that couples the two planes; `stiffening` and `softening`
    are those of the centrifugal load at 1 rad/s. `fields` has the values of the motion's fields at
    the nodes of its elements, field by field, shape (fields · nodes, coordinates).
    """

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    stiffening: FloatArray
    softening: FloatArray
    frequencies_hz: FloatArray
    fields: FloatArray


def plate_matrices(
    plate: Plate,
    motion: PlateMotion,
    edges: tuple[Edge | None, Edge | None],
    modes: int = PLATE_MODES,
    rings: tuple[Cell | None, Cell | None] | None = None,
) -> PlateMatrices:
    """Return one motion of a plate in those of its inner and outer edge, and its modes.

    Parameters
    ----------
    plate
        The plate.
    motion
        "tilt" (bending with one wave along the circumference), "shift" (in its plane, likewise),
        "axial" (bending without waves) or "torsion".
    edges
        How inner and outer edge are held; None is free. At least one is not.
    modes
        How many modes with the edges at rest are kept.
    rings
        What stretches with the plate when it turns inside and outside of it, for stiffening and
        softening. None leaves these out.

    Returns
    -------
    PlateMatrices
        Exact for rigid motion.

    Notes
    -----
    Mindlin plate with shear factor 5/6, Lagrange elements of degree 4 along the radius.
    """
    line = line_of(plate.cells)
    walls = [wall_of(cell, plate_center_m(plate)) for cell in plate.cells]
    spin = None if rings is None or motion != "tilt" else spin_of(plate.cells, line, *rings)
    holds = _holds(plate, line.value.shape[1], motion, edges)
    rigid = _rigid(line.node_radius, motion).ravel()
    return _reduced(holds, (*_assembled(line, walls, motion), spin), rigid, modes)


def disk_frequencies_hz(plate: Plate, count: int = 3) -> FloatArray:
    """Return the frequencies of bending with one nodal diameter, inner edge clamped, rim free."""
    return plate_matrices(plate, "tilt", (Edge(root=np.inf), None), count).frequencies_hz[:count]


def _assembled(
    line: Line, walls: list[Wall], motion: PlateMotion
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mass, stiffness and gyroscopic weight in the fields of a motion, field by field."""
    order = 1 if motion in ("tilt", "shift") else 0
    angle = np.pi if order else 2.0 * np.pi
    n, r = line.value, line.radius[:, None]
    zero = np.zeros_like(n)
    bends = motion in ("tilt", "axial")
    # rows ψ', (ψ − nχ)/r, twist, and the two shear angles, for the fields ζ, ψ, χ
    ratio = n / r
    strain = np.array(
        [
            [zero, line.slope, zero],
            [zero, ratio, -order * ratio],
            [zero, -order * ratio, ratio - line.slope],
            [-line.slope, n, zero],
            [order * ratio, zero, -n],
        ]
    )
    kept = {"tilt": [0, 1, 2], "shift": [1, 2], "axial": [0, 1], "torsion": [2]}[motion]
    if order == 0:
        strain[[2, 4] if bends else [0, 1, 3]] = 0.0
    joined = np.concatenate([strain[:, k] for k in kept], axis=2)
    area = angle * line.radius * line.weight
    elastic = np.zeros((line.radius.size, 5, 5))
    inertia = np.zeros((line.radius.size, 3))
    for g, k in enumerate(line.cell):
        wall = walls[k]
        elastic[g, :3, :3] = wall.bending if bends else wall.membrane
        if bends:
            elastic[g, 3:, 3:] = wall.shear * np.eye(2)
        inertia[g] = (wall.mass, *[wall.rotary if bends else wall.mass] * 2)
    stiffness = np.einsum("agi,gab,bgj,g->ij", joined, elastic, joined, area, optimize=True)
    blocks = [n.T @ ((area * inertia[:, k])[:, None] * n) for k in kept]
    spin = 2.0 * blocks[0] if motion == "tilt" else np.zeros((0, 0))
    gyroscopic = np.zeros_like(stiffness)
    if order:
        cross = 2.0 * n.T @ ((area * inertia[:, 1])[:, None] * n)
        gyroscopic = la.block_diag(spin, np.kron([[1.0, -1.0], [-1.0, 1.0]], cross))
    return la.block_diag(*blocks), stiffness, gyroscopic


class _Hold(NamedTuple):
    """An edge: the fields in its unit motion, what it leaves free, and springs on that."""

    motion: FloatArray
    fixed: tuple[int, ...]
    freed: FloatArray
    springs: FloatArray
    outer: bool


def _rigid(radius: FloatArray, motion: PlateMotion) -> FloatArray:
    """Return the fields of a unit rigid motion at some radii, shape (fields, radii)."""
    one = np.ones_like(radius)
    fields = {
        "tilt": [radius, one, one],
        "shift": [one, one],
        "axial": [one, 0.0 * one],
        "torsion": [radius],
    }
    return np.array(fields[motion])


def _holds(
    plate: Plate, nodes: int, motion: PlateMotion, edges: tuple[Edge | None, Edge | None]
) -> list[_Hold]:
    """Return what each held edge fixes of the fields at its node, and what it leaves free."""
    found = []
    radii = (plate.cells[0].inner_m, plate.cells[-1].outer_m)
    for edge, at, radius in zip(edges, (0, nodes - 1), radii, strict=True):
        if edge is None:
            continue
        values = _rigid(np.array([radius]), motion)[:, 0]
        loose, stiffness = np.zeros((0, values.size)), 0.0
        if edge.root is None and not edge.rigid:
            # the mean of a thin rim: its own roll and stretch are free
            loose = {
                "tilt": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
                "shift": np.array([[1.0, -1.0]]),
                "axial": np.array([[0.0, 1.0]]),
                "torsion": loose,
            }[motion]
        elif edge.root is not None and np.isfinite(edge.root) and motion in ("tilt", "axial"):
            loose = np.eye(values.size)[1:2]
            stiffness = (np.pi if motion == "tilt" else 2.0 * np.pi) * radius * edge.root
        own = at + nodes * np.arange(values.size)
        whole, freed = np.zeros(nodes * values.size), np.zeros((nodes * values.size, len(loose)))
        whole[own], freed[own] = values, loose.T
        springs = np.full(len(loose), stiffness)
        found.append(_Hold(whole, tuple(own.tolist()), freed, springs, at > 0))
    return found


def _reduced(
    holds: list[_Hold],
    matrices: tuple[FloatArray, FloatArray, FloatArray, Spin | None],
    rigid: FloatArray,
    modes: int,
) -> PlateMatrices:
    mass, stiffness, gyroscopic, spin = matrices
    size = mass.shape[0]
    inside = np.setdiff1d(np.arange(size), [k for hold in holds for k in hold.fixed])
    free = np.hstack((np.eye(size)[:, inside], *(hold.freed for hold in holds)))
    springs = np.concatenate((np.zeros(inside.size), *(hold.springs for hold in holds)))
    boundary = np.array([hold.motion for hold in holds]).T
    soft = free.T @ stiffness @ free + np.diag(springs)
    static = -la.solve(soft, free.T @ stiffness @ boundary, assume_a="pos")
    # all edges together move the plate rigidly; a thin plate loses digits of that in K
    exact = np.concatenate((rigid[inside], np.zeros(springs.size - inside.size)))
    static += (exact - static.sum(axis=1))[:, None] / len(holds)
    omega, shapes = solve_standing(scale_by_stiffness(soft, free.T @ mass @ free))
    whole = np.hstack((boundary + free @ static, free @ shapes[:, :modes]))
    count = boundary.shape[1]
    reduced = np.diag(np.concatenate((np.zeros(count), omega[:modes] ** 2)))
    if count == 2:
        # equal motion of both edges is rigid and costs nothing
        shared = whole[:, 0] @ stiffness @ whole[:, 1] + (springs * static[:, 0]) @ static[:, 1]
        reduced[:2, :2] = -float(shared) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    stiffening, softening = np.zeros_like(reduced), np.zeros_like(reduced)
    if spin is not None:
        deflection = whole[: spin.stiffening.shape[0]]
        stiffening = deflection.T @ spin.stiffening @ deflection
        softening = deflection.T @ spin.softening @ deflection
        for row, hold in enumerate(holds):
            stiffening[row, row] += spin.edge_stiffening[hold.outer]
            softening[row, row] += spin.edge_softening[hold.outer]
    return PlateMatrices(
        whole.T @ mass @ whole,
        reduced,
        whole.T @ gyroscopic @ whole,
        stiffening,
        softening,
        omega / (2.0 * np.pi),
        whole,
    )
