"""What the surface of an interface is: its area, its place, and the facets that its box cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solidwhirl.meshing.records import FloatArray, IntArray, Mesh
from solidwhirl.meshing.user_mesh_groups import in_box, points_in_box
from solidwhirl.meshing.user_mesh_records import MeshInterface
from solidwhirl.meshing.user_mesh_roundness import flat_pieces


def measured(interface: MeshInterface, mesh: Mesh, outside: IntArray) -> MeshInterface:
    """Return an interface with its area and centre, and with what its box cuts.

    Parameters
    ----------
    interface
        Of the mesh.
    mesh
        Second-order tetrahedra, with the facets of the interface.
    outside
        (f, 6) facets of the whole surface.
    """
    area, centre = facet_areas(mesh.points, mesh.interfaces[interface.name])
    mean = area @ centre / area.sum()
    size = float(np.abs(mesh.points).max())
    mean[np.abs(mean) < 1e-9 * size] = 0.0
    told = replace(interface, area_m2=float(area.sum()), mean_m=tuple(mean.tolist()))
    if interface.box_m is None:
        return told
    left = outside[~in_box(mesh.points, outside, interface)]
    if not len(left):
        return told
    area, centre = facet_areas(mesh.points, left)
    inside = points_in_box(centre, interface, size).reshape(len(left), -1)
    return replace(
        told,
        cut_facets=int(inside.any(axis=1).sum()),
        cut_area_m2=float(area[inside.ravel()].sum()),
    )


def facet_areas(points: FloatArray, facets: IntArray) -> tuple[FloatArray, FloatArray]:
    """Areas (16 f,) and middles (16 f, 3) of the pieces of curved facets, 16 of each.

    Parameters
    ----------
    points, facets
        (n, 3) [m], and (f, 6) nodes.
    """
    corner = flat_pieces(points, facets)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return 0.5 * np.linalg.norm(normal, axis=1), corner.mean(axis=1)
