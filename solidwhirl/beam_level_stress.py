"""Centrifugal stress of a disk, and what it does to bending with one nodal diameter."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.beam_level_profile import Cell
from solidwhirl.beam_level_radial import POINTS_PER_CELL, Line, line_of, wall_of
from solidwhirl.rotordyn.arrays import FloatArray


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

    Parameters
    ----------
    cells, line
        The plate and its elements.
    hub, rim
        Rings of the columns inside and outside of it that stretch with it.

    Returns
    -------
    Spin
        Their difference vanishes for a rigid tilt, as d(r t σr)/dr − t σφ + ρ t r² = 0 holds in
        the weak form with the test function r.

    Notes
    -----
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

    first, last = POINTS_PER_CELL * len(before), POINTS_PER_CELL * (len(before) + len(cells))
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
