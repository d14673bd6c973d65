"""Mesh files of other programs as `FileMesh`: gmsh and VTU through meshio, and by suffix."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.formats.inp import read_inp
from solidwhirl.meshing.imported.formats.nastran import read_nastran
from solidwhirl.meshing.imported.records import ElementBlock, FileMesh
from solidwhirl.meshing.records import IntArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.foreign import ForeignError, refuse_irregular

#: Suffixes of mesh files that are read.
MESH_SUFFIXES = (".msh", ".inp", ".bdf", ".nas", ".dat", ".vtu")
# Data of cells with more values than this are fields and no groups.
_MOST_GROUPS = 1000
_ELEMENTS = (
    "lines, triangles, quadrangles, tetrahedra, hexahedra, prisms and pyramids of first or second "
    "order"
)
# What a file of a suffix may hold.
_ALLOWED = {
    ".msh": f"a mesh of gmsh, format 2.2 or 4.1, of {_ELEMENTS}",
    ".vtu": f"an UnstructuredGrid of VTK in XML, of {_ELEMENTS}",
    ".inp": "a mesh of Abaqus or CalculiX",
    **dict.fromkeys((".bdf", ".nas", ".dat"), "a mesh of Nastran in bulk data"),
}
_MSH_HEAD = b"$MeshFormat"


def read_mesh_file(path: str | Path) -> FileMesh:
    """Read gmsh .msh (2.2, 4.1), Abaqus or CalculiX .inp, Nastran .bdf (.nas, .dat), VTK .vtu.

    Raises MeshingError: the file can't be read, or has what this program does not know.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshingError(
            f"{path.name}: no mesh format with the suffix {path.suffix!r}; known are "
            f"{', '.join(MESH_SUFFIXES)}"
        )
    try:
        refuse_irregular(path)
        mesh = reader(path)
    except MeshingError as error:
        raise MeshingError(f"{path.name}: {error}") from error
    except ForeignError as error:
        raise MeshingError(f"{path.name}: {error}") from error
    except SuperelementError as error:  # of a card, with file and line
        raise MeshingError(str(error)) from error
    except OSError as error:
        raise MeshingError(f"{path.name}: can not be read: {error.strerror or error}") from error
    except MemoryError:
        raise
    except Exception as error:  # parsers fail on damaged files in many ways
        raise MeshingError(
            f"{path.name}: can not be read as {path.suffix}: found {_finding(error)}; allowed is "
            f"{_ALLOWED[path.suffix.lower()]}"
        ) from error
    return _checked(mesh, path.name)


def _finding(error: BaseException) -> str:
    """What a parser stumbled over, in words: some name only a key, or nothing."""
    if isinstance(error, KeyError) and error.args:
        return f"{error.args[0]!r}, which is not known here"
    said = " ".join(str(error).split())
    if not said and (error.__cause__ or error.__context__):
        return _finding(error.__cause__ or error.__context__)  # type: ignore[arg-type]
    kind = type(error).__name__
    return f"what makes no mesh ({said[:300] or kind})"


def _checked(mesh: FileMesh, name: str) -> FileMesh:
    """Refuse coordinates and node numbers that are none."""
    if not len(mesh.points) or not mesh.blocks:
        raise MeshingError(f"{name}: has {len(mesh.points)} nodes and {len(mesh.blocks)} elements")
    if mesh.points.shape[1] != 3:
        raise MeshingError(f"{name}: nodes have {mesh.points.shape[1]} coordinates; 3 are needed")
    if not np.isfinite(mesh.points).all():
        raise MeshingError(f"{name}: a coordinate is not a finite number")
    for block in mesh.blocks:
        n = block.nodes
        if n.size and (n.min() < 0 or n.max() >= len(mesh.points)):
            raise MeshingError(f"{name}: {block.kind} elements name nodes that do not exist")
    return mesh


def _read_msh(path: Path) -> FileMesh:
    """gmsh: physical groups by name, or by number where they have none."""
    with path.open("rb") as file:
        head = file.read(len(_MSH_HEAD))
    if head != _MSH_HEAD:
        raise MeshingError("does not begin with $MeshFormat, as gmsh's meshes do")
    import meshio

    mesh = meshio.gmsh.read(str(path))
    names = {(int(tag), int(dim)): name for name, (tag, dim) in mesh.field_data.items()}
    groups: dict[str, dict[int, IntArray]] = {}
    tags = mesh.cell_data.get("gmsh:physical", [])
    for k, own in enumerate(tags):
        dimension = mesh.cells[k].dim
        for tag in np.unique(own):
            name = names.get((int(tag), dimension), str(int(tag)))
            groups.setdefault(name, {})[k] = np.flatnonzero(np.asarray(own) == tag)
    # where entities are in several groups, meshio has them all in its sets (format 4.1 only)
    for name, sets in mesh.cell_sets.items():
        if name.startswith("gmsh:"):
            continue
        for k, rows in enumerate(sets):
            if rows is not None and len(rows):
                groups.setdefault(name, {})[k] = np.asarray(rows, dtype=np.int64)
    return _from_meshio(mesh, groups)


def _read_vtu(path: Path) -> FileMesh:
    """VTU: integers at cells and nodes are groups, named "array:value"."""
    text = path.read_bytes()
    for word in (b"<!DOCTYPE", b"<!ENTITY"):
        if word in text:
            raise MeshingError(
                f"found {word.decode()}, allowed is {_ALLOWED['.vtu']}, without declarations and "
                "entities"
            )
    import meshio

    mesh = meshio.vtu.read(str(path))
    groups: dict[str, dict[int, IntArray]] = {}
    for array, blocks in mesh.cell_data.items():
        for k, own in enumerate(blocks):
            for value, rows in _by_value(own):
                groups.setdefault(f"{array}:{value}", {})[k] = rows
    nodes = {
        f"{array}:{value}": rows
        for array, own in mesh.point_data.items()
        for value, rows in _by_value(own)
    }
    return _from_meshio(mesh, groups, nodes)


def _by_value(data: Any) -> list[tuple[int, IntArray]]:
    values = np.asarray(data)
    if values.ndim != 1 or values.dtype.kind not in "iu":
        return []
    found = np.unique(values)
    if len(found) > _MOST_GROUPS:
        return []
    return [(int(v), np.flatnonzero(values == v)) for v in found]


def _from_meshio(
    mesh: Any,
    groups: Mapping[str, Mapping[int, IntArray]],
    nodes: Mapping[str, IntArray] | None = None,
) -> FileMesh:
    return FileMesh(
        points=np.array(mesh.points, dtype=float),
        blocks=tuple(
            ElementBlock(kind=b.type, nodes=np.asarray(b.data, dtype=np.int64)) for b in mesh.cells
        ),
        element_groups=groups,
        node_groups=nodes or {},
    )


_READERS: dict[str, Callable[[Path], FileMesh]] = {
    ".msh": _read_msh,
    ".vtu": _read_vtu,
    ".inp": read_inp,
    ".bdf": read_nastran,
    ".nas": read_nastran,
    ".dat": read_nastran,
}
