"""Unstructured grids as files that ParaView reads: VTU, VTKHDF, and series of files as PVD."""

from __future__ import annotations

import base64
import io
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from solidwhirl.meshing.own.files import as_vtk
from solidwhirl.meshing.records import Mesh
from solidwhirl.rotordyn.core.atomic import replace_text, replacing

# VTK's numbers of the cells that are used here.
VERTEX, LINE, TRIANGLE, QUADRANGLE = 1, 3, 5, 9
_SECOND_ORDER = {2: 22, 3: 24}  # triangle, tetrahedron
_VTK_NAMES = {
    np.dtype(np.float32): "Float32",
    np.dtype(np.float64): "Float64",
    np.dtype(np.int64): "Int64",
    np.dtype(np.int32): "Int32",
    np.dtype(np.uint8): "UInt8",
}
_BLOCK = 1 << 20
# The layout that VTK 9.3 and ParaView 5.12 read.
VTKHDF_VERSION = (2, 0)

Array = npt.NDArray[Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Points, cells and fields."""

    points_m: Array  # (p, 3)
    # VTK's number of a kind of cell with the points of such cells, (c, points of a cell)
    cells: tuple[tuple[int, Array], ...]
    # Fields at the points by name, (p,) or (p, components)
    point_data: Mapping[str, Array] = field(default_factory=dict)
    # Fields of the cells by name, in the order of `cells`, (c,) or (c, components)
    cell_data: Mapping[str, Array] = field(default_factory=dict)
    # Numbers of the whole by name, (k,)
    field_data: Mapping[str, Array] = field(default_factory=dict)

    @property
    def connectivity(self) -> Array:
        """Points of all cells one after the other."""
        flat = [np.asarray(cells, dtype=np.int64).ravel() for _, cells in self.cells]
        return np.concatenate(flat) if flat else np.empty(0, dtype=np.int64)

    @property
    def ends(self) -> Array:
        """Where each cell's points end in `connectivity`."""
        sizes = [np.full(len(cells), cells.shape[1]) for _, cells in self.cells]
        return np.cumsum(np.concatenate(sizes) if sizes else [], dtype=np.int64)

    @property
    def kinds(self) -> Array:
        """VTK's number of each cell."""
        found = [np.full(len(cells), kind, dtype=np.uint8) for kind, cells in self.cells]
        return np.concatenate(found) if found else np.empty(0, dtype=np.uint8)


def mesh_grid(mesh: Mesh) -> Grid:
    """Return a mesh with the numbers of section and material of its cells."""
    return Grid(
        points_m=mesh.points_in_space,
        cells=((_SECOND_ORDER[mesh.dimension], as_vtk(mesh.cells)),),
        cell_data={
            "section": mesh.cell_section.astype(np.int32),
            "material": mesh.cell_material.astype(np.int32),
        },
    )


def write_vtu(grid: Grid, path: Path) -> None:
    """Write a grid as VTK XML, compressed."""
    out = io.StringIO()
    out.write(
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
        'byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">\n'
        "<UnstructuredGrid>\n"
    )
    if grid.field_data:
        out.write("<FieldData>\n")
        for name, values in grid.field_data.items():
            _write_array(out, name, np.atleast_1d(values), field=True)
        out.write("</FieldData>\n")
    count = len(grid.kinds)
    out.write(f'<Piece NumberOfPoints="{len(grid.points_m)}" NumberOfCells="{count}">\n')
    for tag, fields in (
        ("Points", {"points": np.asarray(grid.points_m, dtype=np.float64)}),
        (
            "Cells",
            {"connectivity": grid.connectivity, "offsets": grid.ends, "types": grid.kinds},
        ),
        ("PointData", grid.point_data),
        ("CellData", grid.cell_data),
    ):
        out.write(f"<{tag}>\n")
        for name, values in fields.items():
            _write_array(out, name, values)
        out.write(f"</{tag}>\n")
    out.write("</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
    replace_text(path, out.getvalue())


def _write_array(out: io.StringIO, name: str, values: Array, *, field: bool = False) -> None:
    array = np.ascontiguousarray(values)
    kind = _VTK_NAMES[array.dtype]
    more = f' NumberOfComponents="{array.shape[1]}"' if array.ndim == 2 else ""
    if field:
        more += f' NumberOfTuples="{len(array)}"'
    out.write(f'<DataArray type="{kind}" Name="{escape(name)}"{more} format="binary">\n')
    out.write(_packed(array.tobytes()))
    out.write("\n</DataArray>\n")


def _packed(data: bytes) -> str:
    """Blocks of zlib behind a header of their sizes, in base64."""
    blocks = [data[k : k + _BLOCK] for k in range(0, len(data), _BLOCK)]
    packed = [zlib.compress(block, 3) for block in blocks]
    last = len(data) % _BLOCK
    head = np.array([len(blocks), _BLOCK, last, *map(len, packed)], dtype="<u8").tobytes()
    return base64.b64encode(head).decode() + base64.b64encode(b"".join(packed)).decode()


def write_vtkhdf(grid: Grid, path: Path) -> None:
    """Write a grid as VTKHDF, compressed."""
    counts = {
        "NumberOfPoints": len(grid.points_m),
        "NumberOfCells": len(grid.kinds),
        "NumberOfConnectivityIds": len(grid.connectivity),
    }
    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = np.array(VTKHDF_VERSION, dtype=np.int64)
        kind = b"UnstructuredGrid"
        root.attrs.create("Type", kind, dtype=h5py.string_dtype("ascii", len(kind)))
        for name, count in counts.items():
            root.create_dataset(name, data=np.array([count], dtype=np.int64))
        _put(root, "Points", np.asarray(grid.points_m, dtype=np.float64))
        _put(root, "Connectivity", grid.connectivity)
        _put(root, "Offsets", np.concatenate([[0], grid.ends]).astype(np.int64))
        _put(root, "Types", grid.kinds)
        for name, fields in (
            ("PointData", grid.point_data),
            ("CellData", grid.cell_data),
            ("FieldData", grid.field_data),
        ):
            group = root.create_group(name, track_order=True)
            for key, values in fields.items():
                _put(group, key, np.atleast_1d(values))


def _put(group: h5py.Group, name: str, values: Array) -> None:
    options = {"compression": "gzip", "shuffle": True} if values.size else {}
    group.create_dataset(name, data=values, track_times=False, **options)


def write_pvd(files: Sequence[tuple[float, str]], path: Path) -> None:
    """Write a series of files."""
    lines = [
        f'<DataSet timestep="{time:.12g}" group="" part="0" file="{escape(name)}"/>'
        for time, name in files
    ]
    replace_text(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" '
        'byte_order="LittleEndian">\n<Collection>\n'
        + "\n".join(lines)
        + "\n</Collection>\n</VTKFile>\n",
    )
