"""A hammer test: computed and measured functions and modes beside each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, WrapValidator, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.measured.comparison import compared
from solidwhirl.analyses.measured.export import ComputedTest, exported
from solidwhirl.analyses.measured.pictures import (
    frequency_table,
    function_charts,
    mac_table,
    mode_chart,
    natural_table,
    paired_modes,
)
from solidwhirl.analyses.measured.reading import read_measured
from solidwhirl.analyses.measured.records import UNITS, Measured, MeasuredFileError
from solidwhirl.analyses.measured.spec import MeasuredSpec, MeasuringPointSpec, point_problems
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Text
from solidwhirl.core.fields import MOST, NotNegative, several
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.modal_test.families import families_at_speed, mode_families
from solidwhirl.rotordyn.modal_test.functions import ORDERS, receptances, with_modal_damping
from solidwhirl.rotordyn.modal_test.places import interface_direction, place_direction

_Points = Annotated[tuple[MeasuringPointSpec, ...], Field(min_length=1, max_length=200)]
_Ratio = Annotated[float, Field(ge=0, lt=1, allow_inf_nan=False, strict=True)]


class ImpactTestSpec(base.Frequencies):
    """A hammer test at rest or of a turning rotor: functions and modes, computed and measured."""

    section = PageSection(
        "impact-test",
        "Hammer tests",
        "What a hammer and sensors find on the machine, computed and measured.",
        115,
    )
    suffixes = (".png", "_modes.png", ".unv")
    axes = {  # noqa: RUF012
        f"{part}_{unit}": ("hammer", "sensor", "frequency_hz")
        for unit in UNITS.values()
        for part in ("real", "imaginary")
    }

    kind: Literal["impact_test"]
    hammers: _Points
    sensors: _Points
    quantity: Literal["receptance", "mobility", "accelerance"] = "accelerance"
    damping_ratio: Annotated[
        tuple[_Ratio, ...], Field(min_length=1, max_length=MOST), WrapValidator(several)
    ] = (0.0,)
    speed_rpm: NotNegative = 0.0
    measured: MeasuredSpec | None = None

    @model_validator(mode="after")
    def _not_too_large(self) -> ImpactTestSpec:
        functions = len(self.hammers) * len(self.sensors)
        base.refuse_large("functions x frequencies", functions, self.frequency_count)
        return self

    @property
    def axial_places(self) -> tuple[str, ...]:
        """Interfaces that are hit or watched along the axis."""
        return tuple(str(p.at) for p in self.hammers + self.sensors if p.is_axial)

    def problems(self, ends_m: Mapping[str, tuple[float, float]]) -> Iterator[str]:
        """Yield what can not be had of points and files, each line beginning with a key.

        `ends_m`: lowest and highest place of bodies that are drawn.
        """
        found = [
            *point_problems("hammers", self.hammers, ends_m),
            *point_problems("sensors", self.sensors, ends_m),
        ]
        yield from found
        if not found:
            try:
                self.read()
            except MeasuredFileError as error:
                yield f"measured: {error}"

    def read(self) -> Measured | None:
        """Return what was measured, None without any.

        Raises MeasuredFileError: a file can not be taken.
        """
        if self.measured is None:
            return None
        return read_measured(self.measured, self.hammers, self.sensors)

    def shaft_speeds(
        self, operating: Sequence[base.Operating], ratio: Callable[[str], float], where: str
    ) -> Iterator[tuple[float, str]]:
        """Yield its own speed."""
        if self.speed_rpm:
            yield self.speed_rpm, f"{where}.speed_rpm"

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        return Work(eigenproblems=1.0, solves=float(self.frequency_count), results=10.0)

    def run(self, engine: base.Engine) -> Outcome:
        """Functions between all hammers and sensors, and modes beside the measured ones."""
        system = engine.system
        kinds = frozenset("axial" if p.is_axial else "lateral" for p in self.hammers + self.sensors)
        families = mode_families(system, kinds).with_damping(self.damping_ratio)
        damped = with_modal_damping(system, families)
        speed = self.speed_rpm * RAD_S_PER_RPM
        if speed:
            families = families_at_speed(damped, speed, kinds)
        hammers, sensors = (_rows(system, points) for points in (self.hammers, self.sensors))
        omega = self.frequencies_rad_s
        moved = receptances(damped, sensors, hammers, omega, speed)
        values = moved.T * (1j * omega) ** ORDERS[self.quantity]  # (hammer, sensor, frequency)
        highest, measured = self.frequency_max_hz, self.read()
        if measured is not None and measured.modes:
            highest = max(highest, 1.5 * measured.modes[-1].frequency_hz)
        count = int((families.family_hz <= highest).sum())
        unit = UNITS[self.quantity]
        hertz = families.family_hz[:count].tolist()
        ratios = families.family_damping[:count].tolist()
        motions = [families.motion(sensors, k) for k in range(count)]
        document = {
            "quantity": self.quantity,
            "speed_rpm": self.speed_rpm,
            "hammer": [point.name for point in self.hammers],
            "sensor": [point.name for point in self.sensors],
            "frequency_hz": (omega / (2.0 * np.pi)).tolist(),
            f"real_{unit}": values.real.tolist(),
            f"imaginary_{unit}": values.imag.tolist(),
            "modes": {
                "frequency_hz": hertz,
                "count": families.sizes[:count].tolist(),
                "damping_ratio": ratios,
            },
        }
        if measured is not None:
            document["measured"] = compared(
                measured, families, motions, [p.name for p in self.sensors], self.quantity
            )
        test = ComputedTest(
            hammers=self.hammers,
            sensors=self.sensors,
            quantity=self.quantity,
            frequency_hz=omega / (2.0 * np.pi),
            values=values,
            natural_hz=hertz,
            damping_ratio=ratios,
            motions=motions,
        )
        return Outcome(
            kind=self.kind,
            document=document,
            files={f"{self.label}.unv": partial(exported, test, system, self.measured)},
            headline=_headline(document),
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """Functions of the first hammer and sensor, and frequencies beside each other."""
        pictures: dict[str, base.Charts] = {"": partial(function_charts, found.document)}
        modes = mode_chart(found.document)
        return pictures if modes is None else {**pictures, "_modes": lambda: [modes]}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Functions, natural frequencies, measured ones beside them, and the MAC table."""
        document = found.document
        notes = (document.get("measured") or {}).get("notes") or []
        said = [Text(text="\n".join(f"- {note}" for note in notes))] if notes else []
        tables = (natural_table, frequency_table, mac_table)
        parts = (*(table(document) for table in tables), mode_chart(document))
        return [*function_charts(document), *(part for part in parts if part is not None), *said]

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """The largest difference of paired frequencies, and their least MAC."""
        pairs = paired_modes(document)
        differences = [abs(pair["relative_difference"]) for pair in pairs]
        yield "largest_relative_difference", base.largest_of(differences)
        yield "least_mac", base.smallest_of(pair["mac"] for pair in pairs)


def _rows(system: AssembledSystem, points: Sequence[MeasuringPointSpec]) -> FloatArray:
    """Return what points see of the coordinates of a system, (p, n).

    Raises AnalysisError: a point lies off its body.
    """
    rows = []
    for point in points:
        if point.at is not None:
            end = end_of(point.at)
            rows.append(interface_direction(system, end.body, end.interface, point.vector))
            continue
        assert point.body is not None and point.at_m is not None
        try:
            rows.append(place_direction(system, point.body, point.at_m, point.vector[:2]))
        except AnalysisError as error:
            raise AnalysisError(f"impact_test: {point.name!r}: {error}") from error
    return np.array(rows)


def _headline(document: Mapping[str, Any]) -> str:
    pairs = paired_modes(document)
    if not pairs:
        lowest = ", ".join(f"{f:.4g}" for f in document["modes"]["frequency_hz"][:4])
        return f"lowest natural frequencies {lowest} Hz"
    percent = [100.0 * pair["relative_difference"] for pair in pairs]
    return (
        f"{len(pairs)} of {len(document['measured']['modes'])} measured modes found, computed "
        f"frequencies {min(percent):+.1f} to {max(percent):+.1f} %"
    )
