"""Parts that all exports as Python files share: names, matrices, writing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replace_text, replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import refuse_rotating
from solidwhirl.rotordyn.superelement.record import Superelement

#: What a linear body in the inertial frame carries.
LINEAR_TERMS = (
    "mass and elastic stiffness",
    "gyroscopic matrix, times the speed",
    "stress stiffening and spin softening, times the speed squared",
    "half the gyroscopic matrix, times the angular acceleration",
)


def matrices(element: Superelement) -> dict[str, FloatArray]:
    """Return M, K0, K2 = Kgeo − S and G in the independent coordinates, (r, r) each.

    Raises SuperelementError: a body in the rotating frame.
    """
    refuse_rotating(element)
    full = {
        "M": element.mass,
        "K0": element.stiffness,
        "K2": element.stress_stiffening - element.spin_softening,
        "G": element.gyroscopic,
    }
    tie = element.constraint
    return full if tie is None else {name: tie.T @ a @ tie for name, a in full.items()}


def coordinate_arrays(element: Superelement) -> dict[str, npt.NDArray[Any]]:
    """Return names of coordinates and interfaces as arrays of text, places as numbers.

    Returns interface (n,) and component (n,) of the coordinates, "" and "q" of a modal one;
    interface_name (i,), interface_xyz (i, 3) in m.
    """
    return {
        "interface": np.array([c.interface for c in element.coordinates], dtype=np.str_),
        "component": np.array([c.component for c in element.coordinates], dtype=np.str_),
        "interface_name": np.array([node.name for node in element.interfaces], dtype=np.str_),
        "interface_xyz": np.array([node.position_m for node in element.interfaces]),
    }


def write_python(
    path: str | Path, text: str, element: Superelement, arrays: Mapping[str, npt.NDArray[Any]]
) -> tuple[Path, Path]:
    """Write a Python file and the arrays beside it.

    `path`: ends with `.py`, or has no ending, which is then added; `text`: `@BODY@`, in a comment,
    becomes the names of the body and its interfaces and the largest speed. Names are literals in
    ASCII, so that none can end the comment. Returns the Python file and the `.npz` file, which is
    complete before the Python file appears. Raises SuperelementError for another ending.
    """
    place = Path(path).with_suffix(".py")
    if Path(path).suffix not in ("", ".py"):
        raise SuperelementError(
            f"the export is a Python file and ends with .py, not with {Path(path).suffix!r}: {path}"
        )
    data = place.with_suffix(".npz")
    with replacing(data) as temporary, temporary.open("xb") as file:
        np.savez_compressed(file, **arrays)
    seats = ", ".join(ascii(node.name) for node in element.interfaces)
    about = f"Body: {element.name!a}. Interfaces: {seats}."
    top = element.maximum_speed_rad_s
    if np.isfinite(top):
        about += f"\n# Its modes were chosen for speeds up to {top:g} rad/s."
    replace_text(place, text.replace("@BODY@", about))
    return place, data
