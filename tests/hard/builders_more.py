"""Dense matrices of small bodies, mirrored meshes, and elements measured point by point."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from builders_body import meshed
from numpy.typing import NDArray
from reduced import sparse
from simplex import second_order

from solidwhirl.geometry import Body, Material
from solidwhirl.meshing import Mesh, MeshSize
from solidwhirl.reduction import ReductionError
from solidwhirl.reduction.operators.matrices import BodyOperators, OperatorEffects, build_operators

FloatArray = NDArray[np.float64]

_LATERAL = ("ux", "uy", "rx", "ry")
_AXIAL = ("uz", "rz")


def material(density_kg_per_m3: float, youngs_modulus_pa: float, name: str = "own") -> Material:
    """Material with Poisson's ratio 0.3."""
    return Material(
        name=name,
        density_kg_per_m3=density_kg_per_m3,
        youngs_modulus_pa=youngs_modulus_pa,
        poissons_ratio=0.3,
    )


def operators_of(body: Body, level: str, size: MeshSize, order: int) -> BodyOperators:
    """All matrices of one circumferential order, or of that index of a sector."""
    from mpi4py import MPI

    carried = _LATERAL if order == 1 else _AXIAL
    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=True,
        components={i.name: carried for i in body.interfaces},
    )
    return build_operators(
        body,
        meshed(body, level, size),
        MPI.COMM_SELF,
        order=order,
        degree=2,
        effects=effects,
    )


def dense(matrix) -> FloatArray:
    """PETSc matrix with all its entries."""
    return np.asarray(sparse(matrix).toarray())


def held_space(operators: BodyOperators) -> FloatArray:
    """Orthonormal basis of all motions that leave the interfaces where they are, dense."""
    rows = np.hstack([operators.coupling.rows, operators.coupling.anchors])
    return scipy.linalg.qr(rows)[0][:, rows.shape[1] :] if rows.shape[1] else np.eye(len(rows))


def speed_of_loss_rad_s(body: Body, level: str, size: MeshSize, order: int) -> float:
    """Speed at which a body, held or free, has lost its stiffness, without the program's solvers.

    Lowest θ of (Kσ - S) x = θ K x by SuperLU and ARPACK, of order 1 of Kσ x = θ K x: what the spin
    takes there is held by Coriolis forces. A body without interfaces is held against rigid motions.
    """
    operators = operators_of(body, level, size, order)
    k = sparse(operators.stiffness)
    rows = np.hstack([operators.coupling.rows, operators.coupling.anchors])
    if not rows.shape[1]:
        rigid = np.column_stack(list(operators.rigid_motions.values()))
        rows = sparse(operators.mass) @ rigid
    scale = k.diagonal().mean()
    border = scipy.sparse.csr_matrix(rows / np.linalg.norm(rows, axis=0) * scale)
    whole = scipy.sparse.bmat([[k, border], [border.T, None]], format="csc")
    factor = scipy.sparse.linalg.splu(whole)
    change = sparse(operators.stress_stiffening)
    if order == 0:
        change = change - sparse(operators.spin_softening)
    operators.release()
    n, b = k.shape[0], rows.shape[1]

    def answer(x: FloatArray) -> FloatArray:
        return np.asarray(factor.solve(np.concatenate([change @ x, np.zeros(b)]))[:n])

    operator = scipy.sparse.linalg.LinearOperator((n, n), matvec=answer, dtype=float)
    start = np.random.default_rng(1).standard_normal(n)
    lowest = scipy.sparse.linalg.eigs(
        operator, k=2, which="SR", v0=start, ncv=60, tol=1e-10, return_eigenvectors=False
    ).real.min()
    return float(np.sqrt(-1.0 / lowest)) if lowest < 0.0 else np.inf


def refusal(attempt: Callable[[], object]) -> str:
    """Message of the refusal; empty if it was not refused."""
    try:
        attempt()
    except ReductionError as error:
        return str(error)
    return ""


def last_rpm(message: str) -> float:
    """Last speed that a message states; not a number if it states none."""
    found = re.findall(r"([0-9.e+]+) rpm", message)
    return float(found[-1]) if found else float("nan")


def mirrored(half: Mesh, matter: Material) -> Mesh:
    """Mesh of a body on both sides of z = 0 from that of the side z >= 0.

    Parameters
    ----------
    half
        Meridian or solid mesh of one material; its interfaces lie in z = 0.
    matter
        Material of the side z < 0.
    """
    axial = 0 if half.dimension == 2 else 2
    shared = half.points[:, axial] == 0.0
    number = np.arange(len(half.points))
    number[~shared] = len(half.points) + np.arange(np.count_nonzero(~shared))
    other = half.points[~shared].copy()
    other[:, axial] *= -1.0
    # a reflection exchanges two corners and the edge nodes that go with them, gmsh's order
    turned = [0, 2, 1, 5, 4, 3] if half.dimension == 2 else [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]
    return replace(
        half,
        points=np.vstack([half.points, other]),
        cells=np.vstack([half.cells, number[half.cells][:, turned]]),
        cell_section=np.concatenate([half.cell_section, half.cell_section]),
        cell_material=np.concatenate([half.cell_material, np.ones_like(half.cell_material)]),
        materials=(half.materials[0], matter),
        outline=np.unique(np.concatenate([half.outline, number[half.outline]])),
    )


def _lattice(dimension: int, parts: int) -> FloatArray:
    """All points of a simplex whose barycentric coordinates are multiples of 1/parts."""
    grid = np.indices((parts + 1,) * (dimension + 1)).reshape(dimension + 1, -1).T
    return np.asarray(grid[grid.sum(axis=1) == parts] / parts)


def smallest_jacobians(points: FloatArray, cells: NDArray[np.int64]) -> FloatArray:
    """Smallest Jacobian of each element over a lattice of points, corners and edges included."""
    slopes = second_order(_lattice(points.shape[1], 5))[1]
    x = points[cells]
    out = np.full(len(x), np.inf)
    for slope in slopes:
        out = np.minimum(out, np.linalg.det(np.einsum("cnd,ne->cde", x, slope)))
    return out
