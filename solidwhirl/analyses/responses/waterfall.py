"""Response to harmonic motion of the ground over frequency and speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, numbers
from solidwhirl.core.fields import NotNegative, Place, Positive
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.asymmetric import RotatingSystem
from solidwhirl.rotordyn.asymmetric.ground_motion import rotating_ground_map, rotating_ground_peaks
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.response_maps import ground_chart, ridge_chart, with_sidebands
from solidwhirl.rotordyn.response.map_peaks import ground_motion_peaks
from solidwhirl.rotordyn.response.maps import StepPeaks, ground_motion_map
from solidwhirl.rotordyn.response.resonance_samples import with_knots


class WaterfallSpec(base.Frequencies):
    """Response to harmonic motion of the ground over frequency and speed."""

    section = base.RESPONSE_MAPS
    # at the frequencies of a map, and the highest in the step around each
    axes = dict.fromkeys(("amplitude_m", "highest_m"), ("speed_rpm", "frequency_hz"))
    of_bodies = "any"

    kind: Literal["waterfall"]
    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    speed_count: base.Points = 51
    amplitude_m: Positive = 1e-6
    direction: Literal["x", "y"] = "x"
    observe: Place

    @model_validator(mode="after")
    def _range(self) -> WaterfallSpec:
        base.refuse_falling(self.from_rpm, self.to_rpm)
        base.refuse_large("speed_count x frequency_count", self.speed_count, self.frequency_count)
        return self

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        solved = float(self.speed_count * self.frequency_count)
        if size.kind in ("asymmetric", "periodic"):  # with the neighbours of each frequency
            return Work(solves=3.0 * solved, eigenproblems=self.speed_count, values=6.0 * solved)
        modes = 5.0 * self.speed_count
        return Work(solves=0.3 * solved, eigenproblems=modes, values=6.0 * solved)

    def run(self, engine: base.Engine) -> Outcome:
        """Response to harmonic ground motion over frequency and speed."""
        steps_rpm = np.linspace(self.from_rpm, self.to_rpm, self.speed_count)
        speeds = with_knots(steps_rpm * RAD_S_PER_RPM, engine.system.knots_rad_s)
        if engine.rotating is None:
            found = self._round(engine.system, speeds)
        else:
            found = self._asymmetric(engine.rotating, speeds)
        peaks = _map_peaks(found.steps, speeds * RPM_PER_RAD_S)
        return Outcome(
            kind=self.kind,
            document={
                "observed": self.observe,
                "ground_amplitude_m": self.amplitude_m,
                "direction": self.direction,
                "speed_rpm": (speeds * RPM_PER_RAD_S).tolist(),
                "frequency_hz": (self.frequencies_rad_s / (2.0 * np.pi)).tolist(),
                "amplitude_m": found.height_m.tolist(),
                "highest_m": found.steps.height_m.tolist(),
                "peaks": peaks,
                **found.more,
            },
            headline="highest: "
            + ", ".join(f"{p['speed_rpm']:.0f} rpm {p['frequency_hz']:.1f} Hz" for p in peaks[:3]),
        )

    def _round(self, system: AssembledSystem, speeds: FloatArray) -> _Solved:
        """The map of bodies that are the same in all directions."""
        found = ground_motion_map(
            system,
            self.amplitude_m,
            self.direction,
            speeds,
            self.frequencies_rad_s,
            end_of(self.observe),
        )
        return _Solved(found.major_m(), ground_motion_peaks(system, found), {})

    def _asymmetric(self, rotating: RotatingSystem, speeds: FloatArray) -> _Solved:
        """The map in the frame of asymmetric bodies, and its parts by multiple of the speed."""
        found = rotating_ground_map(
            rotating,
            self.amplitude_m,
            self.direction,
            speeds * abs(rotating.frame_ratio),
            self.frequencies_rad_s,
            end_of(self.observe),
        )
        major = found.major_m()
        sidebands = {
            str(k): major[:, :, at].tolist() for at, k in enumerate(found.multiples.tolist()) if k
        }
        steps = rotating_ground_peaks(rotating, found)
        return _Solved(found.height_m(), steps, {"sidebands_m": sidebands})

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The map, if anything moves."""
        moved = numbers(found.document["amplitude_m"]).any()
        return {"": lambda: [self._charts(found)[0]]} if moved else {}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """The map, and the same as lines in space."""
        return self._charts(found)

    def _charts(self, found: base.Found) -> list[Chart]:
        document, rotating = found.document, found.engine.rotating
        rpm, hertz = numbers(document["speed_rpm"]), numbers(document["frequency_hz"])
        highest = numbers(document["highest_m"]).reshape(rpm.size, hertz.size)
        peaks = [(p["frequency_hz"], p["speed_rpm"], p["amplitude_m"]) for p in document["peaks"]]
        ground = f"{self.amplitude_m:g} m of the ground along {self.direction}"
        flat = replace(
            ground_chart(hertz, rpm, highest, peaks),
            caption=f"Absolute displacement of {self.observe} for {ground}, over the frequency of "
            "the ground and the speed, the highest in each step of frequency. Rings mark the "
            "highest peaks.",
            alt=f"Map of the response of {self.observe} over frequency and speed.",
        )
        if rotating is not None:
            flat = with_sidebands(flat, hertz, rpm, 2.0 * abs(rotating.frame_ratio))
            flat = replace(
                flat,
                caption=f"Absolute displacement of {self.observe} over its frequency and the "
                f"speed, for {ground} at every frequency: the root of the sum of squares of what "
                "comes from the ground at the same frequency and, by the asymmetry, from the "
                "ground at whole multiples of the speed above and below it. The highest in each "
                "step of frequency; rings mark the highest peaks.",
            )
        space = replace(
            ridge_chart(hertz, rpm, highest),
            alt=f"Waterfall of the response of {self.observe} over frequency and speed.",
        )
        return [flat, space]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """The maps, and their parts over the multiple of the speed."""
        found = super().labels(document)
        parts = document.get("sidebands_m", {})
        if not parts:
            return found
        over = ("multiple", "speed_rpm", "frequency_hz")
        return found._replace(
            variables={**found.variables, "sidebands_m": (over, list(parts.values()))},
            coordinates={**found.coordinates, "multiple": ("multiple", [int(k) for k in parts])},
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the largest amplitude."""
        largest = base.largest_of(a for row in document["highest_m"] for a in row)
        yield f"{document['observed']}.largest_amplitude_m", largest


class _Solved(NamedTuple):
    """Heights of a map, (s, f), the highest in its steps, and what else the document has."""

    height_m: FloatArray
    steps: StepPeaks
    more: Mapping[str, Any]


def _map_peaks(steps: StepPeaks, rpm: FloatArray) -> list[dict[str, float]]:
    """Steps of a map that are higher than their eight neighbours, the highest first."""
    major, hertz = steps.height_m, steps.frequency_rad_s / (2.0 * np.pi)
    padded = np.pad(major, 1, constant_values=-np.inf)
    highest = np.ones(major.shape, dtype=bool)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            if down or right:
                part = padded[1 + down :, 1 + right :][: major.shape[0], : major.shape[1]]
                highest &= major > part
    order = sorted(np.argwhere(highest).tolist(), key=lambda at: -float(major[tuple(at)]))
    return [
        {
            "speed_rpm": rpm[i],
            "frequency_hz": hertz[i, j],
            "amplitude_m": major[i, j],
            "sampling_error_estimate": steps.sampling_error[i, j],
        }
        for i, j in order[:10]
    ]
