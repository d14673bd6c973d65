"""Response over excitation frequency and support stiffness, and the stiffness to choose."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.unbalances import end_of, unbalance_at
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, numbers
from solidwhirl.core.fields import NotNegative, Place, Positive
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.response_maps import stiffness_chart
from solidwhirl.rotordyn.response.map_peaks import stiffness_map_peaks
from solidwhirl.rotordyn.response.maps import StepPeaks
from solidwhirl.rotordyn.response.resonance_samples import with_knots
from solidwhirl.rotordyn.response.stiffness_maps import (
    StiffnessChoice,
    StiffnessMap,
    choose_stiffness,
    stiffness_map_at_speed,
    synchronous_stiffness_map,
)
from solidwhirl.rotordyn.response.unbalance import frequency_ratio

# Frequencies of a stiffness study around the operating speed.
_FEWEST_IN_BAND = 5
# Responses that are solved for the peaks at each stiffness.
_PEAKS = 100.0


class StiffnessStudySpec(base.Stiffnesses):
    """Response over excitation frequency and support stiffness, and the stiffness to choose."""

    section = base.RESPONSE_MAPS
    turning: ClassVar = {"excite": base.UNBALANCE_TURNS}
    axes = dict.fromkeys(("amplitude_m", "highest_m"), ("stiffness_n_per_m", "frequency_hz"))

    kind: Literal["stiffness_study"]
    excite: Place
    observe: Place
    moment_kg_m: Positive
    frequency_max_hz: Positive
    frequency_count: base.Points = 500
    speed_rpm: NotNegative | None = None
    operating_speed_rpm: Positive
    margin: Annotated[float, Field(gt=0, lt=1, strict=True)] = 0.2

    @model_validator(mode="after")
    def _covered(self) -> StiffnessStudySpec:
        count, highest = self.frequency_count, self.frequency_max_hz
        base.refuse_large("stiffness_count x frequency_count", self.stiffness_count, count)
        low, high = ((1.0 + s * self.margin) * self.operating_speed_rpm / 60.0 for s in (-1, 1))
        step = highest / count
        inside = math.floor(high / step) - math.ceil(low / step) + 1
        if low < step or high > highest or inside < _FEWEST_IN_BAND:
            raise ValueError(
                f"the band of margin around operating_speed_rpm is {low:.6g} to {high:.6g} Hz; the "
                f"frequencies of the map, {step:.6g} to {highest:.6g} Hz in {count} steps, must "
                f"cover it with {_FEWEST_IN_BAND} or more inside"
            )
        return self

    def operating_named(self) -> Iterator[base.OperatingSpec]:
        """Yield the operating speed that it is drawn for."""
        rpm = self.operating_speed_rpm
        yield base.OperatingSpec(shaft=self.excite.partition(".")[0], from_rpm=rpm, to_rpm=rpm)

    def shaft_speeds(
        self, operating: Sequence[base.Operating], ratio: Callable[[str], float], where: str
    ) -> Iterator[tuple[float, str]]:
        """Yield the speed of the highest frequency, where the unbalance turns at each of them."""
        if self.speed_rpm is None:
            yield from base.synchronous_speed(self.excite, self.frequency_max_hz, ratio, where)

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        solved = self.stiffness_count * self.frequency_count
        each = Work(eigenproblems=2.0, solves=_PEAKS)
        # the map itself is a sum over the modes of each stiffness
        return each.times(self.stiffness_count).and_also(
            Work(solves=0.5 * solved, values=2.0 * solved)
        )

    def run(self, engine: base.Engine) -> Outcome:
        """Response over excitation frequency and support stiffness, and the stiffness to choose."""
        found = self._map(engine)
        steps = stiffness_map_peaks(engine.system, found)
        choice = choose_stiffness(
            found, self.operating_speed_rpm * RAD_S_PER_RPM, self.margin, steps
        )
        return Outcome(
            kind=self.kind,
            document={
                "bearings": list(self.bearings),
                "excited": self.excite,
                "observed": self.observe,
                "moment_kg_m": self.moment_kg_m,
                "speed_rpm": self.speed_rpm,
                "stiffness_n_per_m": self.stiffnesses_n_per_m.tolist(),
                "frequency_hz": (found.frequencies_rad_s / (2.0 * np.pi)).tolist(),
                "amplitude_m": found.major_m().tolist(),
                "highest_m": steps.height_m.tolist(),
                "operating_speed_rpm": self.operating_speed_rpm,
                "margin": self.margin,
                "chosen_stiffness_n_per_m": choice.stiffness_n_per_m,
                "chosen_amplitude_m": choice.amplitude_m,
                "sampling_error_estimate": _error_within(steps, choice),
                "choice_is_at_the_end_of_the_range": choice.is_at_end,
            },
            headline=f"smallest response around {self.operating_speed_rpm:.0f} rpm at "
            f"{choice.stiffness_n_per_m:.3g} N/m",
        )

    def _map(self, engine: base.Engine) -> StiffnessMap:
        """The response; where the speed is given the unbalance is a force that turns on its own."""
        unbalance = unbalance_at(self.excite, self.moment_kg_m)
        sides = np.array([1.0 - self.margin, 1.0 + self.margin])
        band = self.operating_speed_rpm * RAD_S_PER_RPM * sides
        rates = with_knots(base.equal_steps(self.frequency_max_hz, self.frequency_count), band)
        asked = engine.system, self.bearings, self.stiffnesses_n_per_m, unbalance
        if self.speed_rpm is not None:
            return stiffness_map_at_speed(
                *asked, rates, end_of(self.observe), self.speed_rpm * RAD_S_PER_RPM
            )
        knots = frequency_ratio(engine.system, unbalance) * np.array(engine.system.knots_rad_s)
        return synchronous_stiffness_map(*asked, with_knots(rates, knots), end_of(self.observe))

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The map, if anything moves."""
        moved = numbers(found.document["amplitude_m"]).any()
        return {"": lambda: [self._chart(found.document)]} if moved else {}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """The map with the chosen stiffness."""
        return [self._chart(found.document)]

    def _chart(self, document: Mapping[str, Any]) -> Chart:
        stiffness, hertz = (numbers(document[k]) for k in ("stiffness_n_per_m", "frequency_hz"))
        highest = numbers(document["highest_m"]).reshape(stiffness.size, hertz.size)
        chosen, operating = document["chosen_stiffness_n_per_m"], self.operating_speed_rpm / 60.0
        band = ((1.0 - self.margin) * operating, (1.0 + self.margin) * operating)
        where = f"{self.observe} for {self.moment_kg_m:g} kg m at {self.excite}"
        text = (
            f"Displacement of {where} over frequency, the highest in each step, and the stiffness "
            f"of {', '.join(self.bearings)}. White: the stiffness with the smallest response "
            f"within ±{100 * self.margin:g} % of {self.operating_speed_rpm:g} rpm (dashed), and "
            f"that band (dotted). It is {chosen:.4g} N/m."
        )
        if document["choice_is_at_the_end_of_the_range"]:
            text += " It lies at the end of the range: a better one may lie outside."
        return replace(
            stiffness_chart(hertz, stiffness, highest, (chosen, band)),
            caption=text,
            alt=f"Map of the response over frequency and stiffness; chosen {chosen:.4g} N/m.",
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the choice and its amplitude."""
        for key in ("chosen_stiffness_n_per_m", "chosen_amplitude_m"):
            yield key, document[key]


def _error_within(steps: StepPeaks, choice: StiffnessChoice) -> float:
    """Largest relative error of heights in the band of a choice, of all its candidates."""
    low, high = choice.band_rad_s
    inside = (steps.frequency_rad_s >= low) & (steps.frequency_rad_s <= high)
    return float(np.where(inside, steps.sampling_error, 0.0).max())
