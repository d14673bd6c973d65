"""Finite elements along the radius of a plate: Gauss points, shape functions, walls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.beam_level_profile import Cell, Plate, Slice
from solidwhirl.rotordyn.arrays import FloatArray

_DEGREE, _ELEMENTS = 4, 4
_SHEAR = 5.0 / 6.0
# Gauss points of a cell.
POINTS_PER_CELL = _ELEMENTS * (_DEGREE + 2)


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
