"""Units of universal files: dataset 164, labels of axes, and what the scene says of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from solidwhirl.analyses.measured.records import MeasuredFileError
from solidwhirl.rotordyn.response.static import STANDARD_GRAVITY

_FOOT_M, _INCH_M = 0.3048, 0.0254
_POUND_N, _KILOGRAM_N, _POUNDAL_N = 4.4482216152605, STANDARD_GRAVITY, 0.138254954376
#: Metres and newtons of a unit, by what a scene calls the set.
SETS = {
    "m_n": (1.0, 1.0),
    "mm_mn": (1e-3, 1e-3),
    "mm_n": (1e-3, 1.0),
    "in_lbf": (_INCH_M, _POUND_N),
    "ft_lbf": (_FOOT_M, _POUND_N),
}
# The same of the codes of dataset 164; code 9 is the user's own.
_CODES = {
    1: (1.0, 1.0),
    2: (_FOOT_M, _POUND_N),
    3: (1.0, _KILOGRAM_N),
    4: (_FOOT_M, _POUNDAL_N),
    5: (1e-3, 1e-3),
    6: (1e-2, 1e-2),
    7: (_INCH_M, _POUND_N),
    8: (1e-3, _KILOGRAM_N),
}
# SI units of one of the labels of axes.
_MOTIONS = {
    f"{length}{per}": size
    for length, size in (("m", 1.0), ("mm", 1e-3), ("in", _INCH_M))
    for per in ("", "/s", "/s^2", "/s2", "/s**2", "/sec^2", "/sec")
} | {"g": STANDARD_GRAVITY, "gn": STANDARD_GRAVITY}
_FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": _POUND_N, "lb": _POUND_N, "kgf": _KILOGRAM_N}
# Relative difference of units that are one.
_ONE = 1e-4


class Units(NamedTuple):
    """Metres and newtons of one unit of a file, and where that is said."""

    length_m: float
    force_n: float
    said_by: str


def file_units(path: Path, sets: list[Mapping[str, Any]], asked: str | None) -> Units | None:
    """Return the units of a universal file, None where nothing says them.

    `sets`: its datasets 164; `asked`: the set that the scene names. Raises MeasuredFileError: it
    contradicts itself or the scene.
    """
    found = [_of_dataset(path, dataset) for dataset in sets]
    if any(not _same(one, found[0]) for one in found[1:]):
        raise MeasuredFileError(path, "two datasets 164 with different units; allowed is one")
    own = found[0] if found else None
    if asked is None:
        return own
    given = Units(*SETS[asked], f"units = {asked!r} of the scene")
    if own is not None and not _same(own, given):
        raise MeasuredFileError(
            path,
            f"its dataset 164 has a length of {own.length_m:g} m and a force of {own.force_n:g} N, "
            f"the scene says units = {asked!r}; leave units out, or correct the file",
        )
    return given


def _of_dataset(path: Path, dataset: Mapping[str, Any]) -> Units:
    length, force, code = dataset["length"], dataset["force"], dataset["units_code"]
    if not (0.0 < length < 1e12 and 0.0 < force < 1e12):
        raise MeasuredFileError(
            path,
            f"dataset 164: factors {length:g} of length and {force:g} of force; they must be above "
            "zero",
        )
    units = Units(1.0 / length, 1.0 / force, "dataset 164")
    known = _CODES.get(code)
    if known is not None and not _same(units, Units(*known, "")):
        raise MeasuredFileError(
            path,
            f"dataset 164: units code {code} has a length of {known[0]:g} m and a force of "
            f"{known[1]:g} N, but its factors {length:g} and {force:g} say {units.length_m:g} m "
            f"and {units.force_n:g} N; correct one of the two",
        )
    return units


def _same(one: Units, other: Units) -> bool:
    return (
        abs(one.length_m / other.length_m - 1.0) < _ONE
        and abs(one.force_n / other.force_n - 1.0) < _ONE
    )


def function_factor(path: Path, where: str, units: Units | None, labels: tuple[str, str]) -> float:
    """Return what one of a function's numbers is in SI units.

    `where`: of the block, for messages; `labels`: of its ordinate and of the denominator, which
    count before the units of the file where both are known, and must not contradict them but for
    accelerations in g. Raises MeasuredFileError: nothing says the units, or two things say others.
    """
    motion, force = labels[0].strip().lower().replace(" ", ""), labels[1].strip()
    told = None
    if motion in _MOTIONS and force in _FORCES:
        told = _MOTIONS[motion] / _FORCES[force]
    if units is None:
        if told is None:
            raise MeasuredFileError(
                path,
                f"{where}: no units: the file has no dataset 164 and its axes no labels that are "
                f"known (found {labels[0]!r} per {labels[1]!r}); give units, one of "
                f"{', '.join(SETS)}",
            )
        return told
    factor = units.length_m / units.force_n
    if told is None:
        return factor
    if motion not in ("g", "gn") and abs(told / factor - 1.0) > _ONE:
        raise MeasuredFileError(
            path,
            f"{where}: its labels say {labels[0]} per {labels[1]}, {told:g} in SI units, but "
            f"{units.said_by} says {factor:g}; one of the two is wrong",
        )
    return told
