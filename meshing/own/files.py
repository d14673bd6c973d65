"""Meshes in gmsh's own format."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from solidwhirl.meshing.records import IntArray, Mesh

# gmsh's number of a second-order element by its nodes.
_KINDS = {3: 8, 6: 9, 10: 11}
# VTK's order of nodes: the last two edges of the tetrahedron change places.
_TO_VTK = {6: [0, 1, 2, 3, 4, 5], 10: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]}
# Lines that are formatted at once.
_LINES = 4096


def write_gmsh(mesh: Mesh, path: Path) -> None:
    """Write format 2.2, sections and interfaces as named physical groups.

    A meridian is written as `Mesh.points_in_space` has it.
    """
    groups = [
        (mesh.dimension, k + 1, name, mesh.cells[mesh.cell_section == k])
        for k, name in enumerate(mesh.section_names)
    ]
    groups = [group for group in groups if len(group[3])]
    groups[:0] = [
        (mesh.dimension - 1, k + 1, f"interface_{name}", facets)
        for k, (name, facets) in enumerate(mesh.interfaces.items())
    ]
    names = "".join(f'{dimension} {k} "{name}"\n' for dimension, k, name, _ in groups)
    points = mesh.points_in_space
    numbered = np.column_stack((np.arange(1, len(points) + 1), points))
    with path.open("w", encoding="utf-8") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
        file.write(f"$PhysicalNames\n{len(groups)}\n{names}$EndPhysicalNames\n")
        file.write(f"$Nodes\n{len(points)}\n")
        file.writelines(_lines("%d %.16e %.16e %.16e\n", numbered))
        file.write(f"$EndNodes\n$Elements\n{sum(len(group[3]) for group in groups)}\n")
        first = 1
        for _, k, _, cells in sorted(groups, key=lambda group: -group[0]):
            count, nodes = cells.shape
            about = np.broadcast_to([_KINDS[nodes], 2, k, k], (count, 4))
            rows = np.column_stack((np.arange(first, first + count), about, cells + 1))
            file.writelines(_lines(" ".join(["%d"] * rows.shape[1]) + "\n", rows))
            first += count
        file.write("$EndElements\n")


def _lines(line: str, rows: npt.NDArray[np.float64] | IntArray) -> Iterator[str]:
    """Rows as text, many at once."""
    for start in range(0, len(rows), _LINES):
        some = rows[start : start + _LINES]
        yield line * len(some) % tuple(some.ravel().tolist())


def as_vtk(cells: IntArray) -> IntArray:
    """Second-order cells (c, 6 or 10) in VTK's order of nodes, from gmsh's."""
    return np.asarray(cells[:, _TO_VTK[cells.shape[1]]])
