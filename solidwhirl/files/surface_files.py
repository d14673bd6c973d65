"""Modes of a body on its outer surface, for ParaView, from its superelement alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.files import vtk_files as vtk
from solidwhirl.files.vtk_files import Grid
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.dense import scale_by_stiffness, solve_standing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.superelement.surface import Surface, beam_surface

KINDS = ("free", "fixed_interface")
_SECTORS, _MODES = 48, 12
# Fewer half planes do not show a ring.
_FEWEST = 3


class _Modes(NamedTuple):
    """Frequencies (m,) and shapes (n, m) of one kind."""

    kind: str
    frequencies_hz: FloatArray
    shapes: FloatArray


def write_surface_vtu(
    element: Superelement,
    path: Path,
    *,
    modes: int | None = None,
    shapes: Sequence[str] = ("free",),
    sectors: int = _SECTORS,
    write: Callable[[Grid, Path], None] = vtk.write_vtu,
) -> Exported:
    """Write elastic modes of a body at rest on its surface as VTU.

    `modes`: how many of each kind, the lowest ones; None: 12. `shapes`: "free" (nothing holds the
    body) and "fixed_interface" (all interfaces are held). `sectors`: points around the
    circumference of a body of revolution.
    Returns what was written. Each mode is one field of displacements, the largest of length 1;
    names hold the frequency, and the field data `frequency_hz` the frequencies in that order.
    Raises SuperelementError: if an argument has no meaning, or the body has no elastic modes or
    nothing to show.
    """
    grid, left_out = _mode_grid(element, shapes, _MODES if modes is None else modes, sectors)
    write(grid, path)
    said = "Mass, stiffness and all that depends on the speed are not written; it is for pictures."
    return Exported(
        files=(Path(path),),
        carried=(
            f"surface of {len(grid.points_m)} points",
            f"{len(grid.field_data['frequency_hz'])} modes at rest with their frequencies",
        ),
        left_out=(*left_out, said),
    )


#: The same as VTKHDF.
write_surface_vtkhdf = partial(write_surface_vtu, write=vtk.write_vtkhdf)


def _mode_grid(
    element: Superelement, kinds: Sequence[str], count: int, sectors: int
) -> tuple[Grid, tuple[str, ...]]:
    where = f"superelement {element.name!r}"
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown or not kinds:
        raise SuperelementError(f"{where}: shapes are {list(kinds)}; allowed are {list(KINDS)}")
    if count < 1 or sectors < _FEWEST:
        raise SuperelementError(
            f"{where}: modes is {count} and sectors is {sectors}; 1 and {_FEWEST} are the least"
        )
    grid, left_out = surface_grid(element, sectors)
    fields: dict[str, Any] = {}
    frequencies: list[float] = []
    unseen = 0
    for found in (_modes_of(element, kind) for kind in dict.fromkeys(kinds)):
        shown = found.frequencies_hz[:count]
        for k, frequency in enumerate(shown):
            moved = surface_displacement(element, found.shapes[:, k], sectors)
            largest = float(np.sqrt((moved**2).sum(axis=1).max(initial=0.0)))
            if largest == 0.0:  # torsion of a line
                unseen += 1
                continue
            name = f"{found.kind} {k + 1:02d}: {frequency:.6g} Hz"
            fields[name] = (moved / largest).astype(np.float32)
            frequencies.append(float(frequency))
    if not fields:
        raise SuperelementError(f"{where} has no elastic modes of the kinds {list(kinds)}")
    if unseen:
        left_out += (f"{unseen} modes move none of the points and are left out.",)
    return Grid(
        points_m=grid.points_m,
        cells=grid.cells,
        point_data=fields,
        field_data={"frequency_hz": np.array(frequencies)},
    ), left_out


def surface_grid(element: Superelement, sectors: int = _SECTORS) -> tuple[Grid, tuple[str, ...]]:
    """Return a body's surface without fields, and what is not as it should be.

    `element`: the body; without a surface its points for pictures are taken, those on the axis as a
    line. `sectors`: points around the circumference.
    Raises SuperelementError: if there is neither surface nor points.
    """
    surface = shown_surface(element)
    if surface is not None:
        faces = surface.faces(sectors)
        cells = ((vtk.QUADRANGLE, faces.quadrangles), (vtk.TRIANGLE, faces.triangles))
        text = "Cross-sections of the shaft are drawn square to its bent centre line."
        grid = Grid(points_m=faces.points_m, cells=tuple(c for c in cells if len(c[1])))
        return grid, () if element.surface is not None else (text,)
    points = element.recovery_points_m
    if not len(points):
        raise SuperelementError(
            f"superelement {element.name!r} holds neither a surface nor points for pictures"
        )
    number = np.arange(len(points))
    if np.ptp(points[:, :2], axis=0).any():
        text = "The file of the body holds no surface; points of its outline are written."
        return Grid(points_m=points, cells=((vtk.VERTEX, number[:, None]),)), (text,)
    along = np.argsort(points[:, 2], kind="stable")
    text = "The file of the body holds no surface; its centre line is written."
    return Grid(points_m=points, cells=((vtk.LINE, np.column_stack([along[:-1], along[1:]])),)), (
        text,
    )


def shown_surface(element: Superelement) -> Surface | None:
    """Return the surface of a body, that of a shaft by its radii; None where neither is known.

    A beam of this program tells its nodes and radii in its provenance.
    """
    if element.surface is not None:
        return element.surface
    nodes = element.recovery_points_m
    try:
        known, outer, inner = (
            np.asarray(element.provenance[key], dtype=float)
            for key in ("nodes_m", "outer_radius_m", "inner_radius_m")
        )
    except (KeyError, TypeError, ValueError):
        return None
    straight = len(nodes) > 1 and not nodes[:, :2].any() and np.array_equal(nodes[:, 2], known)
    fits = outer.shape == inner.shape == (len(nodes) - 1,)
    if not (straight and fits and (np.diff(known) > 0.0).all() and (outer > inner).all()):
        return None
    planes = []
    for axis in (0, 1):
        plane = np.zeros((2 * len(nodes), element.size))
        plane[0::2] = element.recovery_modes[:, axis]
        plane[1::2] = np.gradient(plane[0::2], known, axis=0)
        planes.append(plane)
    return beam_surface(known, outer, inner, (planes[0], planes[1]), element.recovery_modes[:, 2])


def surface_displacement(element: Superelement, motion: Any, sectors: int = _SECTORS) -> Any:
    """Return the displacement (p, 3) of the points of `surface_grid`."""
    surface = shown_surface(element)
    if surface is not None:
        return surface.displacement(motion, sectors)
    return element.recovery_modes @ np.asarray(motion)


def _modes_of(element: Superelement, kind: str) -> _Modes:
    """Elastic modes at rest, by rising frequency."""
    size = element.size
    if kind == "free":
        columns = np.eye(size) if element.constraint is None else element.constraint
    else:
        columns = np.eye(size)[:, [c.kind == "modal" for c in element.coordinates]]
    if not columns.shape[1]:
        return _Modes(kind, np.empty(0), np.empty((size, 0)))
    mass, stiffness = (columns.T @ a @ columns for a in (element.mass, element.stiffness))
    omega, shapes = solve_standing(scale_by_stiffness(stiffness, mass))
    return _Modes(kind, omega / (2.0 * np.pi), columns @ shapes)
