"""A table of coefficients over load, speed and frequency."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from solidwhirl.core.errors import SceneError
from solidwhirl.rotordyn.core.arrays import FloatArray, freeze_arrays
from solidwhirl.rotordyn.core.foreign import ForeignError, regular_bytes

#: Axes of the arrays of a table, in their order.
AXES = ("loads_n", "speeds_rad_s", "frequencies_rad_s")
_MOST_BYTES = 50_000_000


class TableFileError(SceneError):
    """A file of coefficients that can't be read, or a table that can't be used as asked."""

    def __init__(self, path: Path | str, problem: str) -> None:
        super().__init__(path, [problem])

    def __reduce__(self) -> tuple[Any, ...]:
        """Let an error cross from one process to another."""
        return type(self), (self.path, self.problems[0])


def text_of(path: Path) -> str:
    """Return the text of a file of coefficients.

    Raises TableFileError: it is no regular file, can't be read, or has more than 50 MB.
    """
    try:
        content = regular_bytes(path, _MOST_BYTES)
    except ForeignError as error:
        raise TableFileError(path, str(error)) from error
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:  # as spreadsheets write it where that is the system's own
        return content.decode("cp1252", errors="replace")


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CoefficientTable:
    """Coefficients of the force on a rotor, −(K q + C q' + M q''), on (ux, uy).

    The first index is the force, the second the motion; z is along the shaft and the spin turns x
    towards y. All arrays have the shape (loads, speeds, frequencies, 2, 2), with 1 for an axis
    that the table does not have.

    `loads_n`, `speeds_rad_s`, `frequencies_rad_s`: rising, None where the coefficients do not
    depend on it; `frequencies_rad_s` are those of the motion, not the speed of the rotor;
    `stiffness_n_per_m`, `damping_n_s_per_m`, `mass_kg`; `source`: file and element; `notes`: what
    the reader left out or took for something; `assumed`: coefficients that the file does not give,
    and what they are taken as. Raises ValueError if the shapes do not fit.
    """

    loads_n: FloatArray | None
    speeds_rad_s: FloatArray | None
    frequencies_rad_s: FloatArray | None
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray
    mass_kg: FloatArray
    source: str
    notes: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self)
        axes = [getattr(self, name) for name in AXES]
        shape = (*(1 if axis is None else axis.size for axis in axes), 2, 2)
        for name in ("stiffness_n_per_m", "damping_n_s_per_m", "mass_kg"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}, not {shape}")


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class AxialCoefficients:
    """Coefficients along z of a thrust bearing at speeds, which no law of a scene has.

    `speeds_rad_s`: of the rotor, shape (s,); `stiffness_n_per_m`, `damping_n_s_per_m`: likewise;
    `source`: file and model.
    """

    speeds_rad_s: FloatArray
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray
    source: str

    def __post_init__(self) -> None:
        freeze_arrays(self)
