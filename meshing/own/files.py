"""Meshes in gmsh's own format, through meshio."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solidwhirl.meshing.records import IntArray, Mesh

_CELL = {2: ("triangle6", "line3"), 3: ("tetra10", "triangle6")}
# VTK's order of nodes, which meshio has: the last two edges of the tetrahedron change places.
_TO_VTK = {6: [0, 1, 2, 3, 4, 5], 10: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8], 3: [0, 1, 2]}


def write_gmsh(mesh: Mesh, path: Path) -> None:
    """Write format 2.2, sections and interfaces as named physical groups.

    A meridian is written as `Mesh.points_in_space` has it.
    """
    import meshio  # reads and writes many formats: as long as all the rest here

    kind, facet = _CELL[mesh.dimension]
    blocks: list[tuple[str, IntArray]] = []
    groups, names = [], {}
    for k, name in enumerate(mesh.section_names):
        chosen = mesh.cells[mesh.cell_section == k]
        if len(chosen):
            blocks.append((kind, as_vtk(chosen)))
            groups.append(np.full(len(chosen), k + 1))
            names[name] = np.array([k + 1, mesh.dimension])
    for k, (name, facets) in enumerate(mesh.interfaces.items()):
        blocks.append((facet, as_vtk(facets)))
        groups.append(np.full(len(facets), k + 1))
        names[f"interface_{name}"] = np.array([k + 1, mesh.dimension - 1])
    out = meshio.Mesh(
        mesh.points_in_space,
        blocks,
        cell_data={"gmsh:physical": groups, "gmsh:geometrical": groups},
        field_data=names,
    )
    meshio.gmsh.write(path, out, fmt_version="2.2", binary=False)


def as_vtk(cells: IntArray) -> IntArray:
    """Second-order cells (c, 3, 6 or 10) in VTK's order of nodes, from gmsh's."""
    return np.asarray(cells[:, _TO_VTK[cells.shape[1]]])
