"""Displacement of chosen points from the reduced coordinates, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solidwhirl.reduction.craig_bampton import Basis
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import BodyOperators
from solidwhirl.reduction.vectors import apply

FloatArray = NDArray[np.float64]


def recovery_modes(operators: BodyOperators, basis: Basis, points_m: FloatArray) -> FloatArray:
    """Displacement of points at θ = 0 and 90° per coordinate, (m, 3, families n)."""
    n, comm = basis.vectors.shape[1], operators.comm
    full = basis.vectors
    if operators.coupling.transformation is not None:
        full = apply(operators.coupling.transformation, full)
    owned = len(full) // 3
    x = operators.space.tabulate_dof_coordinates()[:owned]
    gathered = comm.gather((x, full.reshape(owned, 3, n)), root=0)
    values = None
    if comm.rank == 0:
        places = np.vstack([g[0] for g in gathered])
        nodal = np.concatenate([g[1] for g in gathered])
        wanted = points_m
        if operators.harmonic is not None:
            places = places[:, :2]
            wanted = np.column_stack([points_m[:, 2], np.hypot(points_m[:, 0], points_m[:, 1])])
        gap, nearest = cKDTree(places).query(wanted)
        if len(gap) and gap.max() > 1e-9 * max(1e-30, float(np.abs(points_m).max())):
            raise ReductionError(f"recovery points are {gap.max():.3g} m off the mesh")
        values = nodal[nearest]
    local = np.asarray(comm.bcast(values, root=0))
    if operators.harmonic is None:
        return local
    return _on_the_round(operators.harmonic, local, points_m)


def _on_the_round(order: int, amplitudes: FloatArray, points_m: FloatArray) -> FloatArray:
    """Cartesian displacement at the points from amplitudes (a, b, c) of the cos and sin family."""
    theta = np.arctan2(points_m[:, 1], points_m[:, 0])[:, None]
    a, b, c = (amplitudes[:, k] for k in range(3))
    cos, sin = np.cos(order * theta), np.sin(order * theta)
    families = [(cos, sin), (sin, -cos)] if order else [(cos, cos)]
    out = []
    for radial, tangential in families:
        u_r, u_t, u_z = a * radial, b * tangential, c * radial
        u_x = u_r * np.cos(theta) - u_t * np.sin(theta)
        u_y = u_r * np.sin(theta) + u_t * np.cos(theta)
        out.append(np.stack([u_x, u_y, u_z], axis=1))
    return np.concatenate(out, axis=2)
