"""Annular plates of a beam model: thick plates in one circumferential order, by radius.

For order 1, a plate moves by u_z = −ζ cos φ, u_r = (U + x ψ) cos φ, u_φ = −(V + x χ) sin φ with x
from its middle plane; a tilt θ about y is ζ = θ r, ψ = χ = θ, a shift w is U = V = w. For order 0
the same with cos 0, the twist being V alone.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.beams.profile import Cell, Column, Place, Plate, Skeleton, Slice
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.dense import scale_by_stiffness, solve_standing

# Fields per motion of the plate and their order; "tilt" and "shift" are of circumferential order 1.
PlateMotion = Literal["tilt", "shift", "axial", "torsion"]

# Modes with held edges that a plate keeps: those beyond are far above a shaft's.
PLATE_MODES = 3


class Edge(NamedTuple):
    """How an edge of a plate is held."""

    #: Built into a column: stiffness between its rotation and the column's, moment per angle and
    #: length, N. None at a node that holds a rim.
    root: float | None
    #: At a rim: the whole rim moves as a rigid circle; otherwise the node is its mean
    rigid: bool = False
    #: E A of the wall it is built into, which a shift stretches along its circumference, N
    hoop: float = math.inf


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

    Mindlin plate with shear factor 5/6, Lagrange elements of degree 4 along the radius.

    Parameters
    ----------
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
    """
    line = line_of(plate.cells)
    walls = [wall_of(cell, plate_center_m(plate)) for cell in plate.cells]
    spin = None if rings is None or motion != "tilt" else spin_of(plate.cells, line, *rings)
    holds = _holds(plate, line.value.shape[1], motion, edges)
    rigid = _rigid(line.node_radius, motion).ravel()
    return _reduced(holds, (*_assembled(line, walls, motion), spin), rigid, modes)


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
        elif edge.root is not None and np.isfinite(edge.hoop) and motion == "shift":
            # a thin wall passes on what is tangential; its hoop strain is (U - V) cos φ / r
            loose = np.eye(values.size)[:1]
            stiffness = np.pi * edge.hoop / radius
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


_DEGREE, _ELEMENTS = 4, 4
_SHEAR = 5.0 / 6.0
# Gauss points of a cell.
_POINTS_PER_CELL = _ELEMENTS * (_DEGREE + 2)


class Line(NamedTuple):
    """Finite elements along the radius: Gauss points with values and slopes of all nodes.

    `node_radius` is that of the nodes, the others are those of the points.
    """

    radius: FloatArray
    weight: FloatArray
    value: FloatArray
    slope: FloatArray
    cell: tuple[int, ...]
    node_radius: FloatArray


class Wall(NamedTuple):
    """Per area at a cell: in-plane stiffness (3, 3), shear stiffness, mass, rotary inertia."""

    membrane: FloatArray
    bending: FloatArray
    shear: float
    mass: float
    rotary: float


def plate_center_m(plate: Plate) -> float:
    """Return the axial place of a plate's centre of gravity, m."""
    mass = moment = 0.0
    for cell in plate.cells:
        ring = np.pi * (cell.outer_m - cell.inner_m) * (cell.outer_m + cell.inner_m)
        for s in cell.slices:
            part = ring * s.material.density_kg_per_m3 * (s.end_m - s.start_m)
            mass += part
            moment += part * 0.5 * (s.start_m + s.end_m)
    return moment / mass


def line_of(cells: tuple[Cell, ...]) -> Line:
    """Return elements of equal ratio of radii in each cell; a solid centre gets even ones."""
    ends, owner = [cells[0].inner_m], []
    for k, cell in enumerate(cells):
        low, high = cell.inner_m, cell.outer_m
        inside = (
            np.linspace(low, high, _ELEMENTS + 1)
            if low == 0.0
            else np.geomspace(low, high, _ELEMENTS + 1)
        )
        ends += list(inside[1:])
        owner += [k] * _ELEMENTS
    points, weights = np.polynomial.legendre.leggauss(_DEGREE + 2)  # type: ignore[no-untyped-call]
    local = np.linspace(-1.0, 1.0, _DEGREE + 1)
    inverse = np.linalg.inv(np.vander(local, increasing=True))
    powers = np.vander(points, _DEGREE + 1, increasing=True)
    rates = np.zeros_like(powers)
    rates[:, 1:] = powers[:, :-1] * np.arange(1, _DEGREE + 1)
    nodes = _DEGREE * len(owner) + 1
    size = len(owner) * points.size
    value, slope = np.zeros((size, nodes)), np.zeros((size, nodes))
    radius, weight, node_radius = np.zeros(size), np.zeros(size), np.zeros(nodes)
    for k in range(len(owner)):
        half = 0.5 * (ends[k + 1] - ends[k])
        rows = slice(k * points.size, (k + 1) * points.size)
        columns = slice(k * _DEGREE, (k + 1) * _DEGREE + 1)
        radius[rows] = ends[k] + half * (points + 1.0)
        node_radius[columns] = ends[k] + half * (local + 1.0)
        weight[rows] = half * weights
        value[rows, columns] = powers @ inverse
        slope[rows, columns] = rates @ inverse / half
    cells_of_points = tuple(k for k in owner for _ in range(points.size))
    return Line(radius, weight, value, slope, cells_of_points, node_radius)


def wall_of(cell: Cell, center_m: float) -> Wall:
    """Return the wall of a cell; rotary inertia is about the plane of a centre, m."""
    middle = _neutral_m(cell.slices)
    membrane, bending = np.zeros((3, 3)), np.zeros((3, 3))
    shear = mass = rotary = 0.0
    for s in cell.slices:
        modulus, nu = s.material.youngs_modulus_pa, s.material.poissons_ratio
        plane = (
            modulus
            / (1.0 - nu**2)
            * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
        )
        width = s.end_m - s.start_m
        membrane += plane * width
        bending += plane * ((s.end_m - middle) ** 3 - (s.start_m - middle) ** 3) / 3.0
        shear += _SHEAR * modulus / (2.0 * (1.0 + nu)) * width
        mass += s.material.density_kg_per_m3 * width
        second = ((s.end_m - center_m) ** 3 - (s.start_m - center_m) ** 3) / 3.0
        rotary += s.material.density_kg_per_m3 * second
    return Wall(membrane, bending, shear, mass, rotary)


def _neutral_m(slices: tuple[Slice, ...]) -> float:
    weights = [s.material.youngs_modulus_pa * (s.end_m - s.start_m) for s in slices]
    return float(np.average([0.5 * (s.start_m + s.end_m) for s in slices], weights=weights))


class Spin(NamedTuple):
    """Stiffening and softening at 1 rad/s in ζ of a plate's nodes, and of what holds its edges.

    The latter are tilts: of the hub with the inner edge, of the rim with the outer one.
    """

    stiffening: FloatArray
    softening: FloatArray
    edge_stiffening: tuple[float, float]
    edge_softening: tuple[float, float]


def spin_of(cells: tuple[Cell, ...], line: Line, hub: Cell | None, rim: Cell | None) -> Spin:
    """Return stiffening and softening of a plate that turns with its hub and rim.

    `hub`, `rim`: rings of the columns inside and outside of it that stretch with it. Returned:
    their difference vanishes for a rigid tilt, as d(r t σr)/dr − t σφ + ρ t r² = 0 holds in the
    weak form with the test function r.

    Plane stress from the first ring to the last, both free.
    """
    before, after = [c for c in (hub,) if c], [c for c in (rim,) if c]
    rings = (*before, *cells, *after)
    whole = line_of(rings)
    walls = [wall_of(cell, 0.0) for cell in rings]
    plane = np.array([walls[k].membrane[:2, :2] for k in whole.cell])
    mass = np.array([walls[k].mass for k in whole.cell])
    area = np.pi * whole.radius * whole.weight
    strain = np.stack((whole.slope, whole.value / whole.radius[:, None]))
    stiffness = np.einsum("agi,gab,bgj,g->ij", strain, plane, strain, area, optimize=True)
    load = whole.value.T @ (area * mass * whole.radius)
    moved = np.linalg.solve(stiffness, load)
    radial, hoop = np.einsum("gab,bgj,j->ag", plane, strain, moved, optimize=True)

    first, last = _POINTS_PER_CELL * len(before), _POINTS_PER_CELL * (len(before) + len(cells))
    own, edges = slice(first, last), (slice(0, first), slice(last, None))
    ratio = line.value / line.radius[:, None]
    pull, ring = (area * radial)[own], (area * hoop)[own]
    tension, inertia = area * (radial + hoop), area * mass * whole.radius**2
    return Spin(
        line.slope.T @ (pull[:, None] * line.slope) + ratio.T @ (ring[:, None] * ratio),
        line.value.T @ ((area * mass)[own, None] * line.value),
        (float(tension[edges[0]].sum()), float(tension[edges[1]].sum())),
        (float(inertia[edges[0]].sum()), float(inertia[edges[1]].sum())),
    )


# Rotation of the surface of a half-plane under a moment M per length: this times M / (E' t²).
_ROOT = 16.67 / math.pi
# Ratio of the radii of a tube from which its wall bends as a shell, and below which it is solid.
_THICK, _THIN = 0.5, 0.75


def root_stiffness(skeleton: Skeleton, cell: Cell, place: Place) -> float:
    """Return the moment per angle and length of circumference at the root of a plate, N.

    Result: a half-plane's surface (O'Donnell, J. Appl. Mech. 27, 1960) in series with the wall of
    the tube on both sides, a long cylindrical shell (Timoshenko and Woinowsky-Krieger, Theory of
    Plates and Shells, section 117): 2βD each.
    """
    width = cell.end_m - cell.start_m
    surface = float(wall_of(cell, 0.0).membrane[0, 0]) * width / _ROOT
    walls = [_neighbour(skeleton, cell, place.column, step) for step in (-1, 1)]
    shells = [
        _shell(column, plane)
        for column, plane in zip(walls, (cell.start_m, cell.end_m), strict=True)
        if column is not None
    ]
    solid = [share for _, share in shells]
    total = sum(stiffness for stiffness, _ in shells)
    if not shells or min(solid) >= 1.0:
        return surface
    return 1.0 / (1.0 / surface + (1.0 - min(solid)) / total)


def hoop_stiffness(skeleton: Skeleton, cell: Cell, place: Place) -> float:
    """Return E A of the wall that holds the edge of a plate, infinite for a solid shaft, N.

    Result: the width of the plate and 1/β on each side where the wall goes on, which follows as a
    long cylindrical shell that does not turn at the plate (as in `root_stiffness`).
    """
    column = skeleton.columns[place.column]
    inner, outer = column.inner_m(place.z_m), column.outer_m(place.z_m)
    _, solid = _shell(column, place.z_m)
    if solid >= 1.0:
        return math.inf
    sides = sum(_neighbour(skeleton, cell, place.column, step) is not None for step in (-1, 1))
    reach = math.sqrt(0.5 * (inner + outer) * (outer - inner)) / 1.3
    width = cell.end_m - cell.start_m + sides * reach
    return column.layers[0].material.youngs_modulus_pa * (outer - inner) * width / (1.0 - solid)


def held_ring(skeleton: Skeleton, cell: Cell, place: Place, *, outer: bool) -> Cell:
    """Return the ring of a column that stretches with a plate which turns.

    `outer`: whether the column lies outside the plate. Result: the plate's width of a shaft; of a
    drum, a thin wall, also the 1/β on both sides that follow as a shell.
    """
    column = skeleton.columns[place.column]
    inner, top = column.inner_m(place.z_m), column.outer_m(place.z_m)
    start, end = cell.start_m, cell.end_m
    if outer:
        inner = cell.outer_m
        reach = 0.0 if inner / top < _THIN else math.sqrt(0.5 * (inner + top) * (top - inner)) / 1.3
        before, after = (_neighbour(skeleton, cell, place.column, step) for step in (-1, 1))
        start, end = start - reach * (before is not None), end + reach * (after is not None)
    else:
        top = cell.inner_m
    slices = (Slice(start_m=start, end_m=end, material=column.layers[0].material),)
    return Cell(inner_m=inner, outer_m=top, slices=slices)


def _neighbour(skeleton: Skeleton, cell: Cell, column: int, step: int) -> Column | None:
    """Return the column that goes on beyond the face of a plate."""
    columns = skeleton.columns
    current: int | None = column
    while current is not None:
        own = columns[current]
        if (step > 0 and own.start_m >= cell.end_m) or (step < 0 and own.end_m <= cell.start_m):
            return own
        found = [
            (b if step > 0 else a) for a, b in skeleton.contacts if (a, b)[step < 0] == current
        ]
        current = found[0] if found else None
    return None


def _shell(column: Column, plane_m: float) -> tuple[float, float]:
    """Return 2βD of a tube's wall (N) and how far it counts as solid, from 0 to 1."""
    inner, outer = column.inner_m(plane_m), column.outer_m(plane_m)
    material = column.layers[0].material
    nu, wall, mean = material.poissons_ratio, outer - inner, 0.5 * (inner + outer)
    plate = material.youngs_modulus_pa * wall**3 / (12.0 * (1.0 - nu**2))
    beta = (3.0 * (1.0 - nu**2)) ** 0.25 / math.sqrt(mean * wall)
    share = (_THIN - inner / outer) / (_THIN - _THICK)
    return 2.0 * beta * plate, min(max(share, 0.0), 1.0)
