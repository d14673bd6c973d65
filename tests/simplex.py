"""Integrals over second-order triangles and tetrahedra, without the code under test."""

from __future__ import annotations

import numpy as np

# corners that the nodes in the middle of edges lie between, gmsh's order
EDGES = {2: ((0, 1), (1, 2), (2, 0)), 3: ((0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1))}


def second_order(bary):
    """Shape functions (p, nodes) and their derivatives (p, nodes, d) at barycentric points."""
    d = bary.shape[1] - 1
    slope = np.vstack([-np.ones(d), np.eye(d)])
    shapes = [bary[:, i] * (2.0 * bary[:, i] - 1.0) for i in range(d + 1)]
    slopes = [(4.0 * bary[:, i, None] - 1.0) * slope[i] for i in range(d + 1)]
    for i, j in EDGES[d]:
        shapes.append(4.0 * bary[:, i] * bary[:, j])
        slopes.append(4.0 * (bary[:, i, None] * slope[j] + bary[:, j, None] * slope[i]))
    return np.stack(shapes, axis=1), np.stack(slopes, axis=1)


def gauss_rule(dimension, points):
    """Points (barycentric) and weights, exact to the degree 2 points − `dimension`."""
    x, w = np.polynomial.legendre.leggauss(points)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    bary, weight = np.empty((1, 0)), np.ones(1)
    left = np.ones(1)  # of the sum of the barycentric coordinates
    for _ in range(dimension):
        bary = np.column_stack([np.repeat(bary, points, axis=0), np.outer(left, x).ravel()])
        weight = np.outer(weight * left, w).ravel()
        left = np.outer(left, 1.0 - x).ravel()
    return np.column_stack([left, bary]), weight


def mesh_mass_kg(mesh):
    """Mass of the solid that a mesh, of the meridian or of the solid, stands for."""
    bary, weight = gauss_rule(mesh.dimension, 3)
    shape, slope = second_order(bary)
    nodes = mesh.points[mesh.cells]
    size = np.linalg.det(np.einsum("cnd,qne->cqde", nodes, slope))
    if mesh.dimension == 2:
        size = size * 2.0 * np.pi * np.einsum("cn,qn->cq", nodes[:, :, 1], shape)
    density = np.array([m.density_kg_per_m3 for m in mesh.materials])[mesh.cell_material]
    return float(density @ size @ weight)
