"""Geometry from a STEP file through gmsh's CAD kernel: sizes, and a second-order mesh."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import gmsh
import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.formats import step_solids as solids
from solidwhirl.meshing.imported.records import (
    ElementBlock,
    FileMesh,
    MeshRequest,
    StepSize,
)
from solidwhirl.meshing.own.drawing import gmsh_session
from solidwhirl.meshing.own.files import as_vtk
from solidwhirl.meshing.own.meridian import TETRAHEDRON10, TRIANGLE6, element_blocks, node_table
from solidwhirl.meshing.own.prediction import PredictedMesh
from solidwhirl.meshing.records import IntArray

# Regular tetrahedra and triangles of edge 1; tetrahedra for each regular one, and what every
# triangle of the surface adds, as measured on gmsh's meshes of bodies of revolution.
_TETRAHEDRON, _TRIANGLE = np.sqrt(2.0) / 12.0, np.sqrt(3.0) / 4.0
_TETRAHEDRA, _BY_SKIN = 0.65, 2.7
# Triangles up to which the surface is meshed to count them.
_COUNTED = 2e5
_TRIANGLE3 = 2  # gmsh's number of the flat triangle
_PER_TETRAHEDRON, _PER_SURFACE = 1.0 / 5.6, 0.23


@dataclass(frozen=True, kw_only=True)
class StepGeometry:
    """What is known of a STEP file before it is meshed."""

    solids: int  #: Number of solids
    volume_m3: float  #: Of all, and of all sectors
    #: Corners of the box around it in the file's coordinates; of a body of sectors, of which the
    #: file may hold one, around the whole with its axis along z
    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]
    #: Numbers of the mesh, of one sector where there are any, with the sizes asked for, within a
    #: factor 3
    expected: PredictedMesh


def step_geometry(request: MeshRequest) -> StepGeometry:
    """Look at a STEP file without meshing it.

    `request`: file, sizes and sectors; the file's own unit of length is taken into account. Raises
    MeshingError: the file can't be read or has no solid, or has no equal sectors.
    """
    size, sectors = request.step, request.sectors
    assert size is not None
    with _imported(Path(request.path)) as volumes:
        box = np.array(gmsh.model.getBoundingBox(-1, -1)) * solids.UNIT_M
        if sectors is not None:
            box = np.concatenate(solids.extents_m(request))
            volumes = solids.sector_solids(volumes, request)
        volume = sum(gmsh.model.occ.getMass(3, tag) for tag in volumes) * solids.UNIT_M**3
        skin = sum(_triangles(tag, size) for _, tag in gmsh.model.getEntities(2))
        if skin < _COUNTED:
            _ask(size)
            gmsh.model.mesh.generate(2)
            skin = float(len(gmsh.model.mesh.getElementsByType(_TRIANGLE3)[0]))
    regular = volume / (_TETRAHEDRON * size.size_m**3)
    cells = _TETRAHEDRA * regular + _BY_SKIN * skin
    vertices = _PER_TETRAHEDRON * cells + _PER_SURFACE * skin
    return StepGeometry(
        solids=len(volumes),
        volume_m3=volume * (sectors or 1),
        low_m=tuple(float(v) for v in box[:3]),  # type: ignore[arg-type]
        high_m=tuple(float(v) for v in box[3:]),  # type: ignore[arg-type]
        expected=PredictedMesh(
            dimension=3,
            cells=max(round(cells), 1),
            vertices=max(round(vertices), 4),
            edges=max(round(vertices + cells + 0.5 * skin), 6),
            facets=max(round(2.0 * cells + 0.5 * skin), 4),
            graded_places=0,
        ),
    )


def mesh_step(request: MeshRequest) -> FileMesh:
    """Mesh a STEP file with second-order tetrahedra that follow its surfaces.

    `request`: file, unit and sizes. Solids that touch are joined. The boxes of interfaces are cut
    into the solids, so that elements end where boxes do. A body of sectors is meshed as one of
    them, with periodic cuts. Result: in the unit of the request; labels of solids and faces are
    groups. Raises MeshingError: gmsh can't read or mesh the file, or there are no equal sectors.
    """
    size = request.step
    assert size is not None
    with _imported(Path(request.path)) as volumes:
        if request.sectors is not None:
            volumes = solids.sector_solids(volumes, request)
        volumes = solids.imprint(volumes, request)
        _ask(size)
        if request.sectors is not None:
            solids.make_periodic(request)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.optimize("Netgen")
        gmsh.model.mesh.setOrder(2)
        numbering, points = node_table(solids.UNIT_M / request.unit_m)
        cells, owner = element_blocks(volumes, TETRAHEDRON10, numbering)
        faces = [tag for _, tag in gmsh.model.getEntities(2) if _has_triangles(tag)]
        facets, side = element_blocks(faces, TRIANGLE6, numbering)
        groups: dict[str, dict[int, IntArray]] = {}
        for block, (dimension, tags, rows) in enumerate(((3, volumes, owner), (2, faces, side))):
            for k, tag in enumerate(tags):
                label = solids.label(dimension, tag)
                if label:
                    own = groups.setdefault(label, {})
                    mine = np.flatnonzero(rows == k)
                    own[block] = np.concatenate([own[block], mine]) if block in own else mine
    return FileMesh(
        points=points,
        blocks=(
            ElementBlock(kind="tetra10", nodes=as_vtk(cells)),
            ElementBlock(kind="triangle6", nodes=facets),
        ),
        element_groups=groups,
    )


def _ask(size: StepSize) -> None:
    """Tell gmsh the sizes and how to mesh."""
    gmsh.option.setNumber("Mesh.MeshSizeMax", size.size_m / solids.UNIT_M)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size.smallest_m / solids.UNIT_M)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", size.around)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.Algorithm3D", 1)
    gmsh.option.setNumber("Mesh.Optimize", 1)


@contextmanager
def _imported(path: Path) -> Iterator[list[int]]:
    """Open gmsh with the solids of a file, in millimetres; gives their tags."""
    if not path.is_file():
        raise MeshingError(f"{path.name}: there is no such file")
    with gmsh_session():
        gmsh.option.setString("Geometry.OCCTargetUnit", solids.UNIT)
        gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
        try:
            gmsh.model.occ.importShapes(str(path), highestDimOnly=True, format="step")
            gmsh.model.occ.synchronize()
        except Exception as error:  # gmsh raises bare Exception
            raise MeshingError(f"{path.name}: can not be read as STEP: {error}") from error
        found = gmsh.model.getEntities(3)
        if not found:
            raise MeshingError(
                f"{path.name}: has no solid; a body needs closed volumes, no surfaces alone"
            )
        if len(found) > 1:
            solids.fragment(found, [])  # those that touch get common faces
        volumes = [tag for _, tag in gmsh.model.getEntities(3)]
        if not sum(gmsh.model.occ.getMass(3, tag) for tag in volumes) > 0.0:
            raise MeshingError(f"{path.name}: its solids have no volume")
        yield volumes


def _has_triangles(tag: int) -> bool:
    return bool(len(gmsh.model.mesh.getElementsByType(TRIANGLE6, tag)[0]))


def _triangles(tag: int, size: StepSize) -> float:
    """Triangles on a face, by its area and the curvature in its middle."""
    low, high = gmsh.model.getParametrizationBounds(2, tag)
    middle = [0.5 * (a + b) for a, b in zip(low, high, strict=True)]
    curvature = float(abs(gmsh.model.getCurvature(2, tag, middle)[0])) / solids.UNIT_M
    edge = size.size_m
    if curvature > 0.0:
        edge = min(edge, max(2.0 * np.pi / (curvature * size.around), size.smallest_m))
    area = float(gmsh.model.occ.getMass(2, tag)) * solids.UNIT_M**2
    return float(area / (_TRIANGLE * edge**2))
