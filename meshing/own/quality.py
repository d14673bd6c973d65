"""Guaranteed quality of second-order simplices: Bernstein bounds of the Jacobian."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from math import factorial

import numpy as np

from solidwhirl.meshing.records import FloatArray, IntArray

# Vertex pairs of the edge nodes in gmsh's order.
EDGES: dict[int, tuple[tuple[int, int], ...]] = {
    2: ((0, 1), (1, 2), (2, 0)),
    3: ((0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3)),
}
# det of the ideal simplex over the product of its edge lengths to the power d, so that it scores 1.
_IDEAL = {2: np.sqrt(3.0) / 2.0, 3: np.sqrt(2.0) / 2.0}


def doubled_areas(corners: FloatArray) -> FloatArray:
    """Twice the signed areas of plane triangles (n, 3, 2)."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _exponents(dimension: int, degree: int) -> IntArray:
    """All multi-indices of barycentric exponents with the given sum."""
    rows = [e for e in product(range(degree + 1), repeat=dimension + 1) if sum(e) == degree]
    return np.array(rows, dtype=np.int64)


@lru_cache(maxsize=4)
def _jacobian_tables(dimension: int) -> tuple[FloatArray, FloatArray]:
    """Gradients of the P2 basis at the sample points, and the map from samples to Bernstein.

    The determinant has degree d (each column of the Jacobian is linear), so the lattice of
    degree d determines it.
    """
    exponents = _exponents(dimension, dimension)
    lattice = exponents / dimension
    bernstein = np.ones((len(lattice), len(exponents)))
    for j, e in enumerate(exponents):
        scale = factorial(dimension) / np.prod([float(factorial(k)) for k in e])
        bernstein[:, j] = scale * np.prod(lattice**e, axis=1)
    # barycentric gradients of the reference simplex
    bary = np.vstack([-np.ones(dimension), np.eye(dimension)])
    nodes = dimension + 1 + len(EDGES[dimension])
    gradients = np.zeros((len(lattice), nodes, dimension))
    for i in range(dimension + 1):
        gradients[:, i] = (4.0 * lattice[:, i] - 1.0)[:, None] * bary[i]
    for k, (i, j) in enumerate(EDGES[dimension]):
        gradients[:, dimension + 1 + k] = (
            4.0 * lattice[:, i, None] * bary[j] + 4.0 * lattice[:, j, None] * bary[i]
        )
    return gradients, np.linalg.inv(bernstein)


def scaled_jacobians(points: FloatArray, cells: IntArray) -> FloatArray:
    """Lower bound of the scaled Jacobian of second-order simplices.

    The determinant of the Jacobian is a polynomial of degree d; its Bernstein coefficients bound
    it from below over the whole element (Johnen, Remacle, Geuzaine, J. Comput. Phys. 233 (2013)
    359-372). It is scaled by the cube (square) of the longest straight edge such that the
    equilateral simplex scores 1.

    `points`: (n, d) coordinates [m]. `cells`: (c, 6) or (c, 10) nodes in gmsh's order. Returns (c,)
    bounds; a value <= 0 means that the element may be folded.
    """
    dimension = points.shape[1]
    gradients, to_bernstein = _jacobian_tables(dimension)
    bounds = np.empty(len(cells))
    for start in range(0, len(cells), 20000):
        x = points[cells[start : start + 20000]]
        jacobians = np.einsum("cnd,pne->cpde", x, gradients)
        coefficients = np.linalg.det(jacobians) @ to_bernstein.T
        edges = np.array([x[:, i] - x[:, j] for i, j in EDGES[dimension]])
        longest = np.sqrt((edges**2).sum(axis=2)).max(axis=0)
        bounds[start : start + 20000] = coefficients.min(axis=1) / (
            _IDEAL[dimension] * longest**dimension
        )
    return bounds


def straighten(points: FloatArray, cells: IntArray, threshold: float) -> tuple[FloatArray, int]:
    """Move edge nodes of badly curved elements back to the middle of their edges.

    `threshold`: elements with a bound below this, that are better when straight, are straightened.
    Returns points, count: new coordinates and the number of elements that were straightened.
    """
    dimension = points.shape[1]
    vertices = dimension + 1
    moved = points.copy()
    straightened: set[int] = set()
    for _ in range(10):
        bad = np.flatnonzero(scaled_jacobians(moved, cells) < threshold)
        fresh = [int(c) for c in bad if int(c) not in straightened]
        if not fresh:
            break
        straightened.update(fresh)
        for c in fresh:
            for k, (i, j) in enumerate(EDGES[dimension]):
                moved[cells[c, vertices + k]] = 0.5 * (moved[cells[c, i]] + moved[cells[c, j]])
    return moved, len(straightened)
