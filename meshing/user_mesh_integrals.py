"""Integrals over a tetrahedral mesh: mass, inertia, and how far it is from a body of revolution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.special import eval_legendre, roots_jacobi

from solidwhirl.meshing.quality import EDGES
from solidwhirl.meshing.records import FloatArray, IntArray, Mesh
from solidwhirl.meshing.user_mesh_records import MassIntegrals, Roundness
from solidwhirl.meshing.user_mesh_roundness import surface_deviation

# Gauss points in each direction: exact for degree 7, which inertia on curved elements has, 5 (of
# the moments of roundness on straight ones) and 3, which volume has.
_OF_INERTIA, _OF_MOMENTS, _OF_VOLUME = 4, 3, 2
# Polynomials along the axis that weight the moments of the mass.
_ALONG = 4
_CHUNK = 4000


@lru_cache(maxsize=4)
def _rule(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights, shape functions (q, 10) and gradients (q, 10, 3): conical product of Gauss rules."""
    nodes, weights = zip(*(roots_jacobi(count, k, 0) for k in range(3)), strict=True)
    unit = [0.5 * (n + 1.0) for n in nodes]
    scaled = [w / 2.0 ** (k + 1) for k, w in enumerate(weights)]
    a, b, c = np.meshgrid(unit[0], unit[1], unit[2], indexing="ij")
    x = np.stack([(a * (1.0 - b) * (1.0 - c)), b * (1.0 - c), c], axis=-1).reshape(-1, 3)
    weight = np.einsum("i,j,k->ijk", *scaled).ravel()
    bary = np.column_stack([1.0 - x.sum(axis=1), x])
    of_bary = np.vstack([-np.ones(3), np.eye(3)])
    shape = [bary[:, k] * (2.0 * bary[:, k] - 1.0) for k in range(4)]
    slope = [(4.0 * bary[:, k] - 1.0)[:, None] * of_bary[k] for k in range(4)]
    for i, j in EDGES[3]:
        shape.append(4.0 * bary[:, i] * bary[:, j])
        slope.append(4.0 * (bary[:, [i]] * of_bary[j] + bary[:, [j]] * of_bary[i]))
    return weight, np.array(shape).T, np.array(slope).transpose(1, 0, 2)


def volume_m3(mesh: Mesh) -> float:
    """Volume of the curved elements.

    Parameters
    ----------
    mesh
        Second-order tetrahedra.
    """
    ones = tuple(replace(m, density_kg_per_m3=1.0) for m in mesh.materials)
    volumes = _masses(replace(mesh, materials=ones), _OF_VOLUME)
    return float(sum(v.sum() for _, v in volumes))


def _masses(mesh: Mesh, count: int) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Places (m, 3) and masses (m,) of the points of the quadrature, piece by piece."""
    weight, shape, slope = _rule(count)
    density = np.array([m.density_kg_per_m3 for m in mesh.materials])[mesh.cell_material]
    for start in range(0, len(mesh.cells), _CHUNK):
        own = mesh.points[mesh.cells[start : start + _CHUNK]]
        jacobian = np.einsum("cnd,qne->cqde", own, slope)
        volume = np.linalg.det(jacobian) * weight
        mass = density[start : start + _CHUNK, None] * volume
        yield np.einsum("cnd,qn->cqd", own, shape).reshape(-1, 3), mass.ravel()


def mass_integrals(mesh: Mesh) -> MassIntegrals:
    """Integrate mass, centre of gravity and inertia over the curved elements.

    Parameters
    ----------
    mesh
        Second-order tetrahedra.
    """
    total, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for x, mass in _masses(mesh, _OF_INERTIA):
        total += float(mass.sum())
        first += mass @ x
        second += x.T @ (mass[:, None] * x)
    centre = first / total
    second -= total * np.outer(centre, centre)
    inertia = np.trace(second) * np.eye(3) - second
    return MassIntegrals(
        mass_kg=total,
        center_of_gravity_m=tuple(float(v) for v in centre),  # type: ignore[arg-type]
        inertia_kg_m2=tuple((float(a), float(b), float(c)) for a, b, c in inertia),
    )


def roundness(mesh: Mesh, surface: IntArray) -> Roundness:
    """Measure how far a mesh is from a body of revolution about z.

    Parameters
    ----------
    mesh
        Second-order tetrahedra.
    surface
        (f, 6) faces that must be of revolution: the surface, and faces between materials.

    Notes
    -----
    Gyroscopic and inertia forces of motions of circumferential order 1 depend on the mass through
    its circumferential orders 0 and 2, unbalance on order 1: ∫ρ (x+iy)^m P_k(z) dV, m = 1, 2, is
    looked at for the first Legendre polynomials along the body, against ∫ρ r^m dV. What has
    other orders is seen by the surface alone.
    """
    low, high = mesh.points[:, 2].min(), mesh.points[:, 2].max()
    uneven = np.zeros((2, _ALONG), dtype=complex)
    even, total = np.zeros(2), 0.0
    for x, mass in _masses(mesh, _OF_MOMENTS):
        around = x[:, 0] + 1j * x[:, 1]
        along = (2.0 * x[:, 2] - low - high) / (high - low)
        weights = np.array([eval_legendre(k, along) for k in range(_ALONG)])
        for m in (1, 2):
            uneven[m - 1] += weights @ (mass * around**m)
            even[m - 1] += float(mass @ np.abs(around) ** m)
        total += float(mass.sum())
    gyration = np.sqrt(even[1] / total)
    return Roundness(
        static_unbalance=float(abs(uneven[0, 0]) / total / gyration),
        uneven_mass=float((np.abs(uneven) / even[:, None]).max()),
        surface=surface_deviation(mesh.points, surface),
    )
