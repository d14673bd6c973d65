"""Small meshes and mesh files for tests: bricks of hexahedra and prisms of wedges."""

from __future__ import annotations

import re

import gmsh
import numpy as np

from solidwhirl.geometry import MATERIALS
from solidwhirl.meshing.imported.records import ElementBlock, FileMesh, MeshRequest
from solidwhirl.meshing.own.drawing import gmsh_session

STEEL = MATERIALS["steel"]


def brick(lengths, counts, origin=(0.0, 0.0, 0.0)):
    """Nodes and hexahedra of a box."""
    axes = [np.linspace(o, o + x, n + 1) for o, x, n in zip(origin, lengths, counts, strict=True)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    i = np.arange(len(points)).reshape([n + 1 for n in counts])
    a, b = slice(None, -1), slice(1, None)
    corners = [i[a, a, a], i[b, a, a], i[b, b, a], i[a, b, a]]
    corners += [i[a, a, b], i[b, a, b], i[b, b, b], i[a, b, b]]
    return points, np.column_stack([c.ravel() for c in corners])


def prism(sides, layers, radius, length):
    """Nodes and wedges of a prism over a regular polygon, with a line of nodes on its axis."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    plane = np.vstack([[[0.0, 0.0]], ring])
    z = np.linspace(0.0, length, layers + 1)
    points = np.vstack([np.column_stack([plane, np.full(len(plane), v)]) for v in z])
    n = len(plane)
    low = np.column_stack(
        [np.zeros(sides, int), 1 + np.arange(sides), 1 + np.roll(np.arange(sides), -1)]
    )
    wedges = np.vstack([np.hstack([low + n * k, low + n * (k + 1)]) for k in range(layers)])
    return points, wedges


def request(path, **changes):
    """A standing steel body in metres, on its axis."""
    asked = {
        "path": str(path),
        "digest": "0" * 64,
        "unit_m": 1.0,
        "origin": (0.0, 0.0, 0.0),
        "direction": (0.0, 0.0, 1.0),
        "material": STEEL,
        "shape": "any",
    }
    return MeshRequest(**(asked | changes))


def file_mesh(points, **kinds):
    """What a file with these elements and no groups would hold."""
    blocks = [ElementBlock(kind=k, nodes=np.asarray(n)) for k, n in kinds.items()]
    return FileMesh(
        points=np.asarray(points, dtype=float),
        blocks=tuple(blocks),
        element_groups={},
        node_groups={},
        face_groups={},
    )


def drawn(path, bore_mm, hub="hub", beyond_mm=40):
    """A shaft of radius 10 mm through a hub of 20 mm with a bore, as a STEP file.

    `beyond_mm`: by how much the shaft is longer on both sides.
    """
    with gmsh_session():
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")  # that of a session before stays
        occ = gmsh.model.occ
        occ.addCylinder(0, 0, 40 - beyond_mm, 0, 0, 20 + 2 * beyond_mm, 10)
        ring = occ.addCylinder(0, 0, 40, 0, 0, 20, 30)
        if bore_mm:
            occ.cut([(3, ring)], [(3, occ.addCylinder(0, 0, 40, 0, 0, 20, bore_mm))])
        occ.synchronize()
        gmsh.write(str(path))
    text = path.read_text()
    for number, name in (("1", "shaft"), ("2", hub)):
        text = re.sub(rf"'Open CASCADE STEP translator [\d. ]*\.{number}'", f"'{name}'", text)
    path.write_text(text)


INP = """*HEADING
** two bricks
*Node, nset=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
11, 0., 0., 1.
12, 1., 0., 1.
13, 1., 1., 1.
14, 0., 1., 1.
*NODE
21, 0., 0., 2.
22, 1., 0., 2.
23, 1., 1., 2.
24, 0., 1., 2.
*ELEMENT, TYPE=C3D8R, ELSET=LOW
5, 1, 2, 3, 4, 11, 12,
13, 14
*Element, type=C3D8, elset=HIGH
6, 11, 12, 13, 14, 21, 22, 23, 24
*ELSET, ELSET=BOTH
LOW, 6
*NSET, NSET=FOOT, GENERATE
1, 4, 1
*SURFACE, NAME=ROOF, TYPE=ELEMENT
HIGH, S2
*SURFACE, NAME=WALL
5, S3
HIGH, S3
*SOLID SECTION, ELSET=LOW, MATERIAL=STEEL
*STEP
*STATIC
*END STEP
"""

BDF = """SOL 101
CEND
BEGIN BULK
$ two bricks
GRID,1,,0.,0.,0.
GRID,2,,1.+0,0.,0.
GRID           3              1.      1.      0.
GRID           4              0.      1.      0.
GRID*                 11                              0.              0.
*                     1.
GRID*                 12                         10.D-01              0.
*                   1.-0
GRID          13              1.      1.      1.
GRID          14              0.      1.      1.
GRID,21,,0.,0.,2.
GRID,22,,1.,0.,2.
GRID,23,,1.,1.,2.
GRID,24,,0.,1.,2.
CHEXA          5       7       1       2       3       4      11      12
              13      14
CHEXA,6,8,11,12,13,14,21,22,+
+,23,24
CQUAD4         9      40       1       2       3       4
CQUAD4,10,41,21,22,23,24
ENDDATA
"""
