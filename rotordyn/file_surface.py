"""The surface of a body in a superelement file."""

from __future__ import annotations

import h5py
import numpy as np

from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.file_checks import SuperelementFile
from solidwhirl.rotordyn.file_format import put_numbers
from solidwhirl.rotordyn.surface import GROUP, KINDS, Surface


def write_surface(file: h5py.File, surface: Surface | None) -> None:
    """Write the surface of a body; no group is made where there is none.

    Parameters
    ----------
    file
        Open for writing.
    surface
        Of the body.
    """
    if surface is None:
        return
    group = file.create_group(GROUP)
    group.attrs["kind"] = surface.kind
    solid = surface.kind == "solid"
    put_numbers(group, "points", surface.points_m, unit="m", axes="point, x,y,z or z,r")
    put_numbers(group, "cells", surface.cells, axes="cell, point")
    moved = surface.amplitudes.astype(np.float32 if solid else np.float64)
    put_numbers(group, "amplitudes", moved, axes="point, x,y,z or r,theta,z, term")
    put_numbers(group, "coordinate", surface.coordinate)
    put_numbers(group, "order", surface.order)
    put_numbers(group, "family", surface.family, enum="0 cos, 1 sin")


def read_surface(file: SuperelementFile, n: int) -> Surface | None:
    """Read the surface of a body with n coordinates.

    Parameters
    ----------
    file
        Open for reading.
    n
        Number of coordinates.

    Returns
    -------
    Surface or None
        None for a file without it, as those of older versions.

    Raises
    ------
    SuperelementError
        If the kind is unknown, a dataset is missing, or shapes and numbers are not what a surface
        needs.
    """
    if not file.has(GROUP):
        return None
    kind = file.attribute(file.group(GROUP), GROUP, "kind")
    if kind not in KINDS.values():
        raise file.error(GROUP, f"is of kind {kind!r}, allowed are {list(KINDS.values())}")
    dimension = 2 if kind == "meridian" else 3
    places = {name: f"{GROUP}/{name}" for name in ("points", "cells", "coordinate")}
    points, cells, terms = (file.length(place) for place in places.values())
    try:
        return Surface(
            points_m=file.numbers(places["points"], (points, dimension)),
            cells=file.numbers(places["cells"], (cells, dimension)),  # type: ignore[arg-type]
            amplitudes=file.numbers(f"{GROUP}/amplitudes", (points, 3, terms)),
            coordinate=np.array(file.wholes(places["coordinate"], (terms,))),
            order=np.array(file.wholes(f"{GROUP}/order", (terms,))),
            family=np.array(file.wholes(f"{GROUP}/family", (terms,))),
            size=n,
        )
    except SuperelementError as error:
        raise file.named(error) from error
