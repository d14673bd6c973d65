"""How far the edge of a plate gives way where it is built into a shaft or drum."""

from __future__ import annotations

import math

from solidwhirl.beam_level_profile import Cell, Column, Place, Skeleton, Slice
from solidwhirl.beam_level_radial import wall_of

# Rotation of the surface of a half-plane under a moment M per length: this times M / (E' t²).
_ROOT = 16.67 / math.pi
# Ratio of the radii of a tube from which its wall bends as a shell, and below which it is solid.
_THICK, _THIN = 0.5, 0.75


def root_stiffness(skeleton: Skeleton, cell: Cell, place: Place) -> float:
    """Return the moment per angle and length of circumference at the root of a plate, N.

    Parameters
    ----------
    skeleton
        Columns.
    cell
        Part of the plate at its root.
    place
        Where the root is.

    Returns
    -------
    float
        A half-plane's surface (O'Donnell, J. Appl. Mech. 27, 1960) in series with the wall of
        the tube on both sides, a long cylindrical shell (Timoshenko and Woinowsky-Krieger, Theory
        of Plates and Shells, section 117): 2βD each.
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


def held_ring(skeleton: Skeleton, cell: Cell, place: Place, *, outer: bool) -> Cell:
    """Return the ring of a column that stretches with a plate which turns.

    Parameters
    ----------
    skeleton
        Columns.
    cell
        Part of the plate at that edge.
    place
        Where the column holds the plate.
    outer
        Whether the column lies outside the plate.

    Returns
    -------
    Cell
        The plate's width of a shaft; of a drum, a thin wall, also the 1/β on both sides that
        follow as a shell.
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
