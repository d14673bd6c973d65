"""Displacement of chosen points from the reduced coordinates, for pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solidwhirl.reduction.craig_bampton import Basis
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import BodyOperators
from solidwhirl.reduction.vectors import apply
from solidwhirl.rotordyn.surface import family_factors

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
# Points are nodes of the mesh, or turned into each other, up to this part of its size.
_NEAR = 1e-9


def recovery_modes(operators: BodyOperators, basis: Basis, points_m: FloatArray) -> FloatArray:
    """Displacement of points at θ = 0 and 90° per coordinate, (m, 3, families n)."""
    if operators.harmonic is None:
        return nodal_amplitudes(operators, basis, points_m)
    radius = np.hypot(points_m[:, 0], points_m[:, 1])
    places = np.column_stack([points_m[:, 2], radius])
    amplitudes = nodal_amplitudes(operators, basis, places)
    return _on_the_round(operators.harmonic, amplitudes, points_m)


def nodal_amplitudes(operators: BodyOperators, basis: Basis, places: FloatArray) -> FloatArray:
    """Return the values of the basis at nodes of the mesh.

    Parameters
    ----------
    operators, basis
        Of one body and order.
    places
        (m, 2) z, r on a meridian, (m, 3) x, y, z on a solid, all of it, also where half of it is
        worked on.

    Returns
    -------
    ndarray
        (m, 3, n): amplitudes of one family, or displacements, per column of the basis; the same
        on every rank.

    Raises
    ------
    ReductionError
        A place is no node.
    """
    n, comm = basis.vectors.shape[1], operators.comm
    full = basis.vectors
    if operators.coupling.transformation is not None:
        full = apply(operators.coupling.transformation, full)
    owned = len(full) // 3
    x = operators.space.tabulate_dof_coordinates()[:owned]
    kin, size = operators.ingredients.kinematics, float(np.abs(places).max(initial=1e-30))
    wanted, away = places, np.zeros(len(places), dtype=bool)
    if kin.copies == 2:
        away = places[:, 1] < -_NEAR * size
        wanted = np.where(away[:, None], places * [-1.0, -1.0, 1.0], places)
    mine, node = _own_places(x[:, : places.shape[1]], wanted, _NEAR * size, comm)
    values = np.zeros((len(places), 3, n))
    values[mine] = full.reshape(owned, 3, n)[node]
    if comm.size > 1:
        comm.Allreduce(MPI.IN_PLACE, values)
    if away.any():
        values[away] = np.einsum("ij,mjn->min", kin.symmetry.power(1), values[away])
    return values


def _own_places(
    nodes: FloatArray, wanted: FloatArray, near: float, comm: Any
) -> tuple[IntArray, IntArray]:
    """Which places are nodes of this rank, each of one rank only, and which nodes they are."""
    gap = np.full(len(wanted), np.inf)
    nearest = np.zeros(len(wanted), dtype=np.int64)
    if len(nodes) and len(wanted):
        gap, nearest = cKDTree(nodes).query(wanted)
    least = np.empty_like(gap)
    comm.Allreduce(gap, least, op=MPI.MIN)
    if len(least) and least.max() > near:
        raise ReductionError(f"recovery points are {least.max():.3g} m off the mesh")
    first = np.empty(len(wanted), dtype=np.int64)
    claim = np.where(gap <= least, comm.rank, comm.size).astype(np.int64)
    comm.Allreduce(claim, first, op=MPI.MIN)
    mine = np.flatnonzero(first == comm.rank)
    return mine, nearest[mine]


def _on_the_round(order: int, amplitudes: FloatArray, points_m: FloatArray) -> FloatArray:
    """Cartesian displacement at the points from amplitudes (a, b, c) of the cos and sin family."""
    theta = np.arctan2(points_m[:, 1], points_m[:, 0])
    a, b, c = (amplitudes[:, k] for k in range(3))
    cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
    out = []
    for family in range(2 if order else 1):
        along, across = (f[:, None] for f in family_factors(order, family, theta))
        u_r, u_t, u_z = a * along, b * across, c * along
        out.append(np.stack([u_r * cos - u_t * sin, u_r * sin + u_t * cos, u_z], axis=1))
    return np.concatenate(out, axis=2)
