"""What is no body, and files that can't be read: one message each."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_makers import BDF, INP, brick, file_mesh, request

from solidwhirl.geometry import MATERIALS
from solidwhirl.meshing import MeshingError
from solidwhirl.meshing.imported.body import body_of_mesh, mesh_of
from solidwhirl.meshing.imported.formats.files import read_mesh_file
from solidwhirl.meshing.imported.records import MeshInterface
from solidwhirl.meshing.imported.split import as_tetrahedra

TITANIUM = MATERIALS["titanium"]
POINTS, HEXAHEDRA = brick((1.0, 1.0, 3.0), (2, 2, 4))


def two_parts():
    return file_mesh(np.vstack([POINTS, POINTS + 5.0]),
                     hexahedron=np.vstack([HEXAHEDRA, HEXAHEDRA + len(POINTS)]))  # fmt: skip


def unmerged():
    return file_mesh(np.vstack([POINTS, POINTS + np.array([0.0, 0.0, 3.0])]),
                     hexahedron=np.vstack([HEXAHEDRA, HEXAHEDRA + len(POINTS)]))  # fmt: skip


def without_pyramids():
    """A hexahedron under tetrahedra whose common face is cut along the other diagonal."""
    points, hexahedra = brick((1.0, 1.0, 2.0), (1, 1, 2))
    mirrored = points * [-1.0, 1.0, 1.0] + [1.0, 0.0, 0.0]
    turned = hexahedra[:, [1, 0, 3, 2, 5, 4, 7, 6]]
    cut = as_tetrahedra(file_mesh(mirrored, hexahedron=turned)).cells[:, :4]
    tetrahedra = cut[:, [1, 0, 2, 3]]
    upper = points[tetrahedra].mean(axis=1)[:, 2] > 1.0
    return file_mesh(points, hexahedron=hexahedra[:1], tetra=tetrahedra[upper])


def folded():
    points, hexahedra = brick((1.0, 1.0, 2.0), (1, 1, 2))
    points[hexahedra[0, 1]] = [1.0, 0.0, 1.4]  # above the middle of the edge that it was below
    return file_mesh(points, hexahedron=hexahedra)


def shells():
    return file_mesh(POINTS, quad=HEXAHEDRA[:, :4])


def block():
    return file_mesh(POINTS, hexahedron=HEXAHEDRA)


def seat(**where):
    return {"interfaces": (MeshInterface(name="seat", coupling="rigid", **where),)}


REFUSED = {
    "two parts": (two_parts, {}, "2 parts that share no face"),
    "nodes twice": (unmerged, {}, "9 pairs of nodes lie at one place"),
    "no pyramids": (without_pyramids, {}, "do not match"),
    "folded": (folded, {}, r"is folded|lie over their neighbours"),
    "shells": (shells, {}, "no volume elements, only quad"),
    "unknown kind": (lambda: file_mesh(POINTS, VTK_LAGRANGE_HEXAHEDRON=HEXAHEDRA), {}, "not known"),
    "no group": (block, seat(group="SEAT"), "interface 'seat': the file has no group 'SEAT'"),
    "empty box": (
        block,
        seat(box_m=((8, 8, 8), (9, 9, 9))),
        r"no facet of the surface lies in the box; .* from \[0, 0, 0\] to \[1, 1, 3\] m",
    ),
    "no material": (block, {"material": None}, "96 of 96 elements are in none of the groups"),
    "no such part": (
        block,
        {"materials": (("RIM", TITANIUM),)},
        "no group 'RIM' of volume elements; it has none",
    ),
    "no direction": (
        block,
        {"direction": (0.0, 0.0, 1.0), "x_direction": (0.0, 0.0, 2.0)},
        "x_direction lies along",
    ),
    "square": (
        block,
        {"shape": "round", "origin": (0.5, 0.5, 0.0)},
        "mass is even around the axis, but its surface is not",
    ),
    "off its axis": (
        block,
        {"shape": "round"},
        "it is no body of revolution about its axis: static unbalance 0.8",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_body_is_refused(case):
    make, changes, message = REFUSED[case]
    asked = request("a.vtu", **changes)
    with pytest.raises(MeshingError, match=message):
        body_of_mesh("block", asked, mesh_of(make(), asked, "block"))


TEXTS = {
    "other system.bdf": (BDF.replace("GRID,1,,", "GRID,1,3,"), "system 3 is used, but no CORD"),
    "few nodes.bdf": (BDF.replace("+,23,24\n", ""), "CHEXA 6 has 6 nodes; allowed are 8 or 20"),
    "lost.bdf": (BDF.replace("GRID,24,,0.,1.,2.\n", ""), "names GRID 24, which does not exist"),
    "include.bdf": (
        BDF.replace("GRID,24,", "INCLUDE '/etc/passwd'\nGRID,24,"),
        "INCLUDE names '/etc/passwd', which lies outside the folder",
    ),
    "unknown.bdf": (
        BDF.replace("GRID,24,", "CTRIAX6,9,1\nGRID,24,"),
        r"found CTRIAX6 \(1, the first in line 18",
    ),
    "no line.bdf": (
        BDF.replace("GRID,24,,0.,", "GRID,24,,x,"),
        "line [0-9]+: GRID: field 4: 'x' is no",
    ),
    "include.inp": (INP.replace("*HEADING", "*INCLUDE, INPUT=/etc/passwd"), "outside the folder"),
    "unknown.inp": (INP.replace("C3D8R", "C3D27"), "TYPE=C3D27 is not known"),
    "twice.inp": (INP.replace("\n21,", "\n14,"), "node 14 is defined twice"),
    "empty.vtu": ("<VTKFile", "can not be read as .vtu"),
    "entity.vtu": (
        '<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]><VTKFile>&e;</VTKFile>',
        "found <!DOCTYPE, allowed is an UnstructuredGrid of VTK in XML",
    ),
    "other.vtu": ("<VTKFile type='PolyData'></VTKFile>", "found what makes no mesh .*; allowed is"),
    "type.msh": (
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n"
        "$Elements\n1\n1 99 2 1 1 1\n$EndElements\n",
        "found 99, which is not known here; allowed is a mesh of gmsh.*tetrahedra",
    ),
    "script.msh": ("SystemCall 'true';", "does not begin with"),
    "binary.inp": ("\0" * 50, "has 0 nodes"),
    "wrong.xyz": ("", "no mesh format with the suffix '.xyz'"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_files_that_can_not_be_read_are_refused(tmp_path, name):
    text, message = TEXTS[name]
    (tmp_path / name).write_text(text)
    (tmp_path / "twice.txt").write_text("GRID,25,,0.,0.,0.\n")
    with pytest.raises(MeshingError, match=message):
        read_mesh_file(tmp_path / name)
