"""Geometry from a STEP file through gmsh's CAD kernel: sizes, and a second-order mesh."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import gmsh
import numpy as np

from solidwhirl.core.machine import available_memory_gib
from solidwhirl.geometry import Joint
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
from solidwhirl.meshing.own.meridian import (
    LINE3,
    TETRAHEDRON10,
    TRIANGLE6,
    element_blocks,
    node_table,
)
from solidwhirl.meshing.own.prediction import PredictedMesh
from solidwhirl.meshing.records import IntArray
from solidwhirl.rotordyn.core.foreign import ForeignError, in_child, regular_bytes

# Regular tetrahedra and triangles of edge 1; tetrahedra for each regular one, and what every
# triangle of the surface adds, as measured on gmsh's meshes of bodies of revolution.
_TETRAHEDRON, _TRIANGLE = np.sqrt(2.0) / 12.0, np.sqrt(3.0) / 4.0
_TETRAHEDRA, _BY_SKIN = 0.65, 2.7
# Triangles up to which the surface is meshed to count them.
_COUNTED = 2e5
# Processor time and memory for looking at a file: to begin with, and for each byte (usual are 0.5 s
# and 2e-6 s, 0.2 GiB and 200 bytes).
_FIRST_S, _S_PER_BYTE = 30, 2e-4
_FIRST_BYTES, _BYTES_PER_BYTE = 4 << 30, 5000
# Numbers with a power of ten, and the power that none has.
_POWER = re.compile(rb"[(,\s]([+-]?\d+\.?\d*[Ee]\+?0*(\d{2,}))")
_LARGEST_POWER = 30
_TRIANGLE3 = 2  # gmsh's number of the flat triangle
# Cells and facets of what is meshed, by gmsh's numbers.
_OF_SOLID, _OF_MERIDIAN = (TETRAHEDRON10, TRIANGLE6), (TRIANGLE6, LINE3)
_KINDS = {TETRAHEDRON10: "tetra10", TRIANGLE6: "triangle6", LINE3: "line3"}
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
    joints: tuple[Joint, ...]  #: Those of the request, with the interference that is drawn


def step_geometry(request: MeshRequest) -> StepGeometry:
    """Look at a STEP file without meshing it.

    `request`: file, sizes and sectors; the file's own unit of length is taken into account. Raises
    MeshingError: the file can't be read or has no solid, solids of unlike material overlap, or
    there are no equal sectors.
    """
    size = _size_of(request)
    found = json.loads(
        _guarded(
            request,
            lambda: json.dumps(asdict(_geometry(request))).encode(),
            seconds=_FIRST_S + int(_S_PER_BYTE * size),
            memory_bytes=_FIRST_BYTES + _BYTES_PER_BYTE * size,
        )
    )
    return StepGeometry(
        **found
        | {
            "low_m": tuple(found["low_m"]),
            "high_m": tuple(found["high_m"]),
            "expected": PredictedMesh(**found["expected"]),
            "joints": tuple(_joint_of(joint) for joint in found["joints"]),
        }
    )


def _joint_of(values: dict[str, Any]) -> Joint:
    own: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
    return Joint(**own)


def _size_of(request: MeshRequest) -> int:
    path = Path(request.path)
    try:
        content = regular_bytes(path)
    except ForeignError as error:
        raise MeshingError(f"{path.name}: {error}") from error
    # the kernel does not come to an end with coordinates that are beyond all measure
    for found in _POWER.finditer(content):
        if int(found[2][-4:]) >= _LARGEST_POWER:
            line = content.count(b"\n", 0, found.start(1)) + 1
            raise MeshingError(
                f"{path.name}: line {line}: {found[1].decode()[:40]} is no length or number of a "
                "solid; export the solids anew"
            )
    return len(content)


def _guarded(
    request: MeshRequest, work: Callable[[], bytes], *, seconds: int | None, memory_bytes: int
) -> bytes:
    """Let gmsh work in a child: on damaged numbers its kernel crashes or runs on for ever."""
    try:
        return in_child(work, seconds=seconds, memory_bytes=memory_bytes, refused=MeshingError)
    except ForeignError as error:
        raise MeshingError(
            f"{Path(request.path).name}: can not be read as STEP: gmsh's geometry kernel {error}; "
            "export the solids anew, or repair them in the CAD program"
        ) from error


def _geometry(request: MeshRequest) -> StepGeometry:
    size, sectors = request.step, request.sectors
    assert size is not None
    with _imported(request) as (volumes, joints):
        box = np.array(gmsh.model.getBoundingBox(-1, -1)) * solids.UNIT_M
        if sectors is not None or joints:
            box = np.concatenate(solids.extents_m(request))
        if sectors is not None:
            volumes = solids.sector_solids(volumes, request)
        count = len(volumes)
        volume = sum(gmsh.model.occ.getMass(3, tag) for tag in volumes) * solids.UNIT_M**3
        if joints:
            solids.meridian(volumes, request)
        skin = sum(_triangles(tag, size) for _, tag in gmsh.model.getEntities(2))
        if skin < _COUNTED:
            _ask(size)
            gmsh.model.mesh.generate(2)
            skin = float(len(gmsh.model.mesh.getElementsByType(_TRIANGLE3)[0]))
    regular = volume / (_TETRAHEDRON * size.size_m**3)
    cells = _TETRAHEDRA * regular + _BY_SKIN * skin
    vertices = _PER_TETRAHEDRON * cells + _PER_SURFACE * skin
    if joints:  # a layer of prisms above the triangles, of which half as many corners are
        cells, vertices = 3.0 * skin, skin
    return StepGeometry(
        solids=count,
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
        joints=joints,
    )


def mesh_step(request: MeshRequest) -> FileMesh:
    """Mesh a STEP file with second-order tetrahedra that follow its surfaces.

    `request`: file, unit and sizes. Solids that touch are joined. The boxes of interfaces are cut
    into the solids, so that elements end where boxes do. A body of sectors is meshed as one of
    them, with periodic cuts; of one with joints the meridian, with triangles. Result: in the unit
    of the request; labels of solids and faces are groups. Raises MeshingError: gmsh can't read or
    mesh the file, there are no equal sectors, or a solid with joints is not of revolution.
    """
    _size_of(request)
    memory = int(available_memory_gib() * 1024**3)
    content = _guarded(request, lambda: _meshed(request), seconds=None, memory_bytes=memory)
    with np.load(io.BytesIO(content), allow_pickle=False) as found:
        groups: dict[str, dict[int, IntArray]] = {}
        for k, (name, block) in enumerate(json.loads(str(found["names"]))):
            groups.setdefault(name, {})[block] = found[f"group_{k}"]
        kinds = _OF_MERIDIAN if request.joints else _OF_SOLID
        return FileMesh(
            points=found["points"],
            blocks=(
                ElementBlock(kind=_KINDS[kinds[0]], nodes=found["cells"]),
                ElementBlock(kind=_KINDS[kinds[1]], nodes=found["facets"]),
            ),
            element_groups=groups,
        )


def _meshed(request: MeshRequest) -> bytes:
    """The mesh as the bytes of an npz file."""
    size = request.step
    assert size is not None
    with _imported(request) as (pieces, joints):
        dimension, kinds = (2, _OF_MERIDIAN) if joints else (3, _OF_SOLID)
        if request.sectors is not None:
            pieces = solids.sector_solids(pieces, request)
        pieces = solids.imprint(pieces, request)
        if joints:
            pieces = solids.meridian(pieces, request)
        _ask(size)
        if request.sectors is not None:
            solids.make_periodic(request)
        gmsh.model.mesh.generate(dimension)
        if dimension == 3:
            gmsh.model.mesh.optimize("Netgen")
        gmsh.model.mesh.setOrder(2)
        numbering, points = node_table(solids.UNIT_M / request.unit_m)
        cells, owner = element_blocks(pieces, kinds[0], numbering)
        sides = [tag for _, tag in gmsh.model.getEntities(dimension - 1) if _is_meshed(tag, kinds)]
        facets, side = element_blocks(sides, kinds[1], numbering)
        groups: dict[str, dict[int, IntArray]] = {}
        for block, (tags, rows) in enumerate(((pieces, owner), (sides, side))):
            for k, tag in enumerate(tags):
                label = solids.label(dimension - block, tag)
                if label:
                    own = groups.setdefault(label, {})
                    mine = np.flatnonzero(rows == k)
                    own[block] = np.concatenate([own[block], mine]) if block in own else mine
    named = [(name, block, rows) for name, own in groups.items() for block, rows in own.items()]
    content = io.BytesIO()
    np.savez(
        content,
        points=points,
        cells=as_vtk(cells) if dimension == 3 else cells,
        facets=facets,
        names=json.dumps([(name, block) for name, block, _ in named]),
        **{f"group_{k}": rows for k, (_, _, rows) in enumerate(named)},
    )
    return content.getvalue()


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
def _imported(request: MeshRequest) -> Iterator[tuple[list[int], tuple[Joint, ...]]]:
    """Open gmsh with the solids of a file, in millimetres; gives their tags, and its joints."""
    path = Path(request.path)
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
        joints = solids.join(request) if len(found) > 1 or request.joints else ()
        volumes = [tag for _, tag in gmsh.model.getEntities(3)]
        if not sum(gmsh.model.occ.getMass(3, tag) for tag in volumes) > 0.0:
            raise MeshingError(f"{path.name}: its solids have no volume")
        yield volumes, joints


def _is_meshed(tag: int, kinds: tuple[int, int]) -> bool:
    return bool(len(gmsh.model.mesh.getElementsByType(kinds[1], tag)[0]))


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
