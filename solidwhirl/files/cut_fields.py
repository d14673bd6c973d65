"""Fields of a recovered state on half of its body, cut open along the axis."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.core.blocks import CutBody

# What is shown, the first of these that the file has, with its name and unit.
_STRESSES = (
    ("von_mises_total", "largest von Mises stress over the cycle"),
    ("von_mises_dynamic", "largest dynamic von Mises stress over the cycle"),
    ("von_mises_steady", "von Mises stress of the centrifugal load"),
)
# How it moves, likewise.
_MOTIONS = ("displacement_0deg", "displacement", "displacement_steady")


class StateField(NamedTuple):
    """A body as pyvista has it, not deformed."""

    #: Cells with the point fields "shown" and "moved" [m], (p,) and (p, 3)
    grid: Any
    #: What "shown" is, and its unit
    label: str
    unit: str
    #: Largest of "shown"
    largest: float


def state_field(record: Callable[[Path], None]) -> StateField:
    """Return the stress of a recovered state, without one its displacement.

    `record`: writes the VTU file of the state.
    """
    import pyvista  # loads VTK

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "state.vtu"
        record(file)
        grid = pyvista.read(file)
    moved = np.asarray(next(grid[name] for name in _MOTIONS if name in grid.point_data))
    found = next(((f, label) for f, label in _STRESSES if f in grid.point_data), None)
    if found is None:
        label, unit, values = "displacement", "mm", 1e3 * np.linalg.norm(moved, axis=1)
    else:
        label, unit, values = found[1], "MPa", 1e-6 * np.asarray(grid[found[0]])
    grid.clear_data()
    grid["shown"], grid["moved"] = values.astype(float), moved.astype(float)
    return StateField(grid=grid, label=label, unit=unit, largest=float(np.nanmax(values)) or 1.0)


def half_of(grid: Any) -> Any:
    """Return the half x >= 0 of a body, whose cut face looks along -x."""
    return grid.clip(normal=(-1.0, 0.0, 0.0), origin=(0.0, 0.0, 0.0))


def cut_body(record: Callable[[Path], None], state: str, body: str) -> CutBody:
    """Return the surface of half a body in a state; its elements have straight edges there."""
    field = state_field(record)
    surface = half_of(_straight(field.grid)).extract_surface(algorithm=None).triangulate()
    return CutBody(
        label=f"{state}, {body}",
        points_m=np.asarray(surface.points, dtype=float),
        triangles=np.asarray(surface.faces).reshape(-1, 4)[:, 1:],
        values=np.asarray(surface["shown"], dtype=float),
        quantity=field.label,
        unit=field.unit,
        largest=field.largest,
    )


def _straight(grid: Any) -> Any:
    """The grid with the corners alone of its tetrahedra of second order."""
    import pyvista

    second, first = pyvista.CellType.QUADRATIC_TETRA, pyvista.CellType.TETRA
    cells = dict(grid.cells_dict)
    if second in cells:
        cells[first] = cells.pop(second)[:, :4]
    found = pyvista.UnstructuredGrid(cells, grid.points)
    found["shown"] = grid["shown"]
    return found
