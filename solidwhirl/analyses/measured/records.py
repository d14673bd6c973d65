"""Measured functions and modes in SI units, and the places where they were measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from solidwhirl.core.errors import clean
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray

#: Units of functions by their quantity, as keys and columns end with them.
UNITS = {"receptance": "m_per_n", "mobility": "m_per_s_n", "accelerance": "m_per_s2_n"}


#: Of a file of measurements
MOST_BYTES = 500_000_000


class MeasuredFileError(ValueError):
    """A file of measurements that can not be taken; the message names it and what is allowed."""

    def __init__(self, path: Path | str, text: str) -> None:
        super().__init__(f"{Path(path).name}: {clean(text)}")


class Freedom(NamedTuple):
    """A node of a universal file and the signed number of a direction of it, 1 for +x to 3."""

    node: int
    direction: int


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredFunction:
    """A measured frequency response function."""

    hammer: str
    sensor: str
    #: "receptance", "mobility" or "accelerance"
    quantity: str
    #: Rising, without 0, shape (f,)
    frequency_hz: FloatArray
    #: Displacement, velocity or acceleration per force in SI units, shape (f,)
    values: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredMode:
    """A measured mode."""

    frequency_hz: float
    #: None where it was not measured
    damping_ratio: float | None = None
    #: Standard deviation; None where it is not told
    uncertainty_hz: float | None = None
    #: Motion of the sensors by name, in any scale; None of a frequency alone
    shape: Mapping[str, complex] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """What files of measurements hold."""

    functions: tuple[MeasuredFunction, ...] = ()
    #: By rising frequency
    modes: tuple[MeasuredMode, ...] = ()
    #: What was left out, and which units were taken
    notes: tuple[str, ...] = ()
