"""Unbalances of a scene, the places they act at, and the peaks of the responses to them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from solidwhirl.core.blocks import numbers
from solidwhirl.core.fields import Finite, Place, Positive, Record
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

if TYPE_CHECKING:
    from solidwhirl.rotordyn import AssembledSystem, End
    from solidwhirl.rotordyn.response.unbalance import Unbalance
    from solidwhirl.rotordyn.response.unbalance_peaks import ResonancePeak

_T = TypeVar("_T")
# Part of the largest motion at a speed below which a motion is the solution's rounding.
ROUNDING = 1e-9
# Unbalances turn together if their ratios differ by less than this.
_SAME_RATIO = 1e-9


class UnbalanceSpec(Record):
    """An unbalance at an interface of a body that turns, by its moment or a grade of ISO 21940."""

    at: Place
    moment_kg_m: Positive = 0.0  # stays 0 where there is a grade, until masses are known
    phase_deg: Finite = 0.0
    grade: Positive | None = None
    at_rpm: Positive | None = None
    share: Annotated[float, Field(gt=0, le=1, strict=True)] = 1.0

    @model_validator(mode="after")
    def _one_size(self) -> UnbalanceSpec:
        by_moment = self.moment_kg_m > 0.0
        graded = {"grade": self.grade, "at_rpm": self.at_rpm}
        given = [key for key, value in graded.items() if value is not None]
        given += ["share"] if "share" in self.model_fields_set else []
        if by_moment and given:
            raise ValueError(f"has moment_kg_m and {given[0]}; one of them says how large it is")
        if not by_moment and None in graded.values():
            raise ValueError("needs moment_kg_m, or both grade and at_rpm")
        return self

    @model_serializer(mode="wrap")
    def _as_given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Without the keys of the other way to say it."""
        absent = ("moment_kg_m",) if self.grade else ("grade", "at_rpm", "share")
        return {key: value for key, value in handler(self).items() if key not in absent}


def end_of(place: str) -> End:
    """Interface of a text "body.interface"."""
    from solidwhirl.rotordyn.assembly.parts import End

    body, _, interface = place.partition(".")
    return End(body=body, interface=interface)


def unbalance_of(spec: UnbalanceSpec) -> Unbalance:
    """Unbalance of a scene's entry."""
    return unbalance_at(spec.at, spec.moment_kg_m, spec.phase_deg)


def unbalance_at(place: str, moment_kg_m: float, phase_deg: float = 0.0) -> Unbalance:
    """Unbalance at "body.interface"."""
    from solidwhirl.rotordyn.response.unbalance import Unbalance

    at, phase = end_of(place), float(np.radians(phase_deg))
    return Unbalance(body=at.body, interface=at.interface, moment_kg_m=moment_kg_m, phase_rad=phase)


def amplitudes_of(motion: Mapping[str, Any]) -> ComplexArray:
    """Complex amplitudes along x and y of a place of an unbalance response, shape (s, 2)."""
    return np.stack(
        [
            numbers(motion[f"amplitude_{axis}_m"])
            * np.exp(1j * np.radians(numbers(motion[f"phase_{axis}_deg"])))
            for axis in "xy"
        ],
        axis=1,
    )


def turning_at(
    system: AssembledSystem, unbalances: list[Unbalance], ratio: float
) -> list[Unbalance]:
    """Those unbalances whose frequency over the reference speed is `ratio`."""
    from solidwhirl.rotordyn.response.unbalance import frequency_ratio

    return [u for u in unbalances if abs(frequency_ratio(system, u) - ratio) <= _SAME_RATIO * ratio]


def peak_documents(peaks: tuple[ResonancePeak, ...], ratio: float) -> list[dict[str, Any]]:
    """Peaks as plain data; `ratio` is frequency over reference speed."""
    return [
        {
            "frequency_hz": p.position_rad_s / (2.0 * np.pi),
            "speed_rpm": p.position_rad_s / ratio * RPM_PER_RAD_S,
            "amplitude_m": p.amplitude,
            "amplification": p.amplification,
        }
        for p in peaks
    ]


def listed_peaks(peaks: list[dict[str, Any]]) -> str:
    """Speeds and frequencies of peaks in one line."""
    said = (f"{p['speed_rpm']:.0f} rpm ({p['frequency_hz']:.2f} Hz)" for p in peaks)
    return ", ".join(said) or "none"


#: Columns of a table of peaks behind the place.
PEAK_HEAD = (
    *("reference shaft [rpm]", "frequency [Hz]", "amplitude [m]", "amplification factor [1]"),
    "estimated error of the speed",
)


def peak_row(peak: Mapping[str, Any]) -> list[Any]:
    """Cells of a peak under `PEAK_HEAD`."""
    from solidwhirl.rotordyn.plots.campbell import error_words

    return [
        f"{peak['speed_rpm']:.1f}",
        f"{peak['frequency_hz']:.5g}",
        peak["amplitude_m"],
        peak["amplification"],
        error_words(peak.get("frequency_error_estimate")),
    ]


def parts(items: list[_T], most: int) -> list[list[_T]]:
    """Pieces of a list with so many items at most."""
    return [items[k : k + most] for k in range(0, len(items), most)]


def numbered(items: list[_T]) -> list[tuple[str, _T]]:
    """Suffixes of file names: none for the first, then _2, _3 and so on."""
    return [(f"_{k + 1}" if k else "", item) for k, item in enumerate(items)]
