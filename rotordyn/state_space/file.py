"""Files of state-space models: HDF5 to keep, npz and MAT to load in Python and Matlab.

HDF5 layout, version 1: root attributes format, format_version, generator, created_utc, form
("polynomial" or "table"), equation. Datasets speeds (rad/s), A (k, 2n, 2n), B (k, 2n, m),
C (k, p, 2n), D (k, p, m), state_scale (2n,), input/name, input/unit (m,), output/name, output/unit
(p,). A polynomial has k = 3, the powers 0, 1, 2 of Ω; a table one k for each speed.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, cast

import h5py
import numpy as np
import scipy

from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import AnalysisError, SuperelementError
from solidwhirl.rotordyn.state_space.model import StateSpace
from solidwhirl.rotordyn.storage.checked_reads import SuperelementFile
from solidwhirl.rotordyn.storage.files import program_version
from solidwhirl.rotordyn.storage.sandbox import refuse_damaged

FORMAT = "ROTOR-STATE-SPACE"
FORMAT_VERSION = "1.0.0"
MAJOR_VERSION = "1"
EQUATION = (
    "x' = A(Om) x + B(Om) u, y = C(Om) x + D(Om) u, (q, q') = state_scale * x, inertial frame; "
    "polynomial: A(Om) = A[0] + Om A[1] + Om^2 A[2]; table: A[k] at speeds[k], linear between"
)
_MATRICES = ("A", "B", "C", "D")


def write_state_space(model: StateSpace, path: str | Path) -> None:
    """Write a state-space model to an HDF5 file, which appears when it is complete.

    `path`: the file; its folder must exist. An older file is replaced. Raises OSError if the
    folder does not exist or cannot be written.
    """
    with (
        replacing(Path(path)) as temporary,
        h5py.File(temporary, "x", libver=("earliest", "v110")) as file,
    ):
        file.attrs.update(
            {
                "format": FORMAT,
                "format_version": FORMAT_VERSION,
                "generator": f"solidwhirl {program_version()}",
                "created_utc": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
                "form": model.form,
                "equation": EQUATION,
            }
        )
        file.create_dataset("speeds", data=model.speeds_rad_s, track_times=False)
        file["speeds"].attrs["unit"] = "rad/s"
        for name in _MATRICES:
            file.create_dataset(
                name,
                data=getattr(model, name.lower()),
                track_times=False,
                compression="gzip",
                shuffle=True,
                fletcher32=True,
            )
        file.create_dataset("state_scale", data=model.state_scale, track_times=False)
        for side in ("input", "output"):
            for what in ("name", "unit"):
                texts = list(getattr(model, f"{side}_{what}s"))
                file.create_dataset(f"{side}/{what}", data=texts, dtype=h5py.string_dtype("utf-8"))


def read_state_space(path: str | Path) -> StateSpace:
    """Read a state-space model from an HDF5 file.

    The model is equal to the one written, bit for bit. Raises AnalysisError if the file is
    missing, damaged, of another format or a newer major version, or holds wrong shapes or numbers
    that are not finite. The message names the file and the dataset.
    """
    try:
        refuse_damaged(Path(path), _try_path)
        return _read_path(Path(path))
    except SuperelementError as error:
        raise AnalysisError(str(error)) from error
    except AnalysisError as error:
        raise AnalysisError(f"{path}: {error}") from error


def _try_path(path: Path) -> None:
    """Read a file for what happens to the library; what its numbers mean is judged later."""
    with contextlib.suppress(AnalysisError):
        _read_path(path)


def _read_path(path: Path) -> StateSpace:
    with SuperelementFile.open(path) as file:
        return _read(file)


def _read(file: SuperelementFile) -> StateSpace:
    found, version = file.text_attribute("format"), file.text_attribute("format_version")
    if found != FORMAT:
        raise file.error("attribute 'format'", f"is {found!r}, allowed is {FORMAT!r}")
    if version.split(".")[0] != MAJOR_VERSION:
        raise file.error(
            "attribute 'format_version'",
            f"is {version!r}; this program reads {MAJOR_VERSION}.x.y",
        )
    form = file.text_attribute("form")
    if form not in ("polynomial", "table"):
        raise file.error("attribute 'form'", f"is {form!r}, allowed are ['polynomial', 'table']")
    states, speeds = file.length("state_scale"), file.length("speeds")
    inputs, outputs = file.length("input/name"), file.length("output/name")
    count = 3 if form == "polynomial" else speeds
    return StateSpace(
        form=cast(Literal["polynomial", "table"], form),
        speeds_rad_s=file.vector("speeds"),
        a=file.numbers("A", (count, states, states)),
        b=file.numbers("B", (count, states, inputs)),
        c=file.numbers("C", (count, outputs, states)),
        d=file.numbers("D", (count, outputs, inputs)),
        state_scale=file.vector("state_scale"),
        input_names=tuple(file.texts("input/name", inputs)),
        input_units=tuple(file.texts("input/unit", inputs)),
        output_names=tuple(file.texts("output/name", outputs)),
        output_units=tuple(file.texts("output/unit", outputs)),
    )


def export_npz(model: StateSpace, path: str | Path) -> None:
    """Write a state-space model to a NumPy archive, loaded with `numpy.load`.

    `path`: the file, with any suffix; its folder must exist. Raises OSError if the folder does not
    exist or cannot be written.

    Polynomial: A0, A1, A2, B0, ... with A(Ω) = A0 + Ω A1 + Ω² A2, and speed_range. Table: A, B,
    C, D with the speed as first axis, and speeds. Both: form, state_scale, input_names,
    input_units, output_names, output_units as arrays of text.
    """
    with replacing(Path(path)) as temporary, temporary.open("xb") as stream:
        np.savez_compressed(stream, **_flat(model, np.array))


def export_mat(model: StateSpace, path: str | Path) -> None:
    """Write a state-space model to a MAT file, loaded with `load` in Matlab and Octave.

    Raises AnalysisError if the model is too large for the format (a matrix of 2 GiB). Raises
    OSError if the folder does not exist or cannot be written.

    The variables of `export_npz`, in version 5 of the format; the matrices of a table have the
    speed as third axis, A(:,:,k), and texts are cell arrays. `ss(A0 + Om*A1 + Om^2*A2, ...)` is
    the model at one speed.
    """
    largest = max(term.nbytes for term in (model.a, model.b, model.c, model.d))
    if largest >= 2**31:
        raise AnalysisError(
            f"a matrix of {largest} bytes does not fit in a MAT file of version 5, which allows "
            f"{2**31 - 1}; truncate the model or use HDF5"
        )
    variables = _flat(model, lambda texts: np.array(texts, dtype=object))
    if model.form == "table":
        variables |= {name: np.moveaxis(variables[name], 0, 2) for name in _MATRICES}
    with replacing(Path(path)) as temporary, temporary.open("xb") as stream:
        scipy.io.savemat(stream, variables, do_compression=True, oned_as="column")


def _flat(model: StateSpace, texts: Any) -> dict[str, Any]:
    """Return the variables of the exported files."""
    variables: dict[str, Any] = {"form": model.form, "state_scale": model.state_scale}
    if model.form == "polynomial":
        variables["speed_range"] = model.speeds_rad_s
        for name in _MATRICES:
            terms: Mapping[int, Any] = dict(enumerate(getattr(model, name.lower())))
            variables |= {f"{name}{power}": term for power, term in terms.items()}
    else:
        variables["speeds"] = model.speeds_rad_s
        variables |= {name: getattr(model, name.lower()) for name in _MATRICES}
    for side in ("input", "output"):
        for what in ("names", "units"):
            variables[f"{side}_{what}"] = texts(getattr(model, f"{side}_{what}"))
    return variables
