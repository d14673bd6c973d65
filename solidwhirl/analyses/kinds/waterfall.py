"""Response to harmonic motion of the ground over frequency and speed."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    model_validator,
)

from solidwhirl.analyses.base import (
    Engine,
    Frequencies,
    Points,
    refuse_falling,
    refuse_large,
)
from solidwhirl.analyses.unbalances import (
    end_of,
)
from solidwhirl.core.fields import (
    NotNegative,
    Place,
    Positive,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.response_maps import (
    draw_ground_motion,
)
from solidwhirl.rotordyn.response.map_peaks import ground_motion_peaks
from solidwhirl.rotordyn.response.maps import StepPeaks, ground_motion_map
from solidwhirl.rotordyn.response.resonance_samples import with_knots


class WaterfallSpec(Frequencies):
    """Response to harmonic motion of the ground over frequency and speed."""

    kind: Literal["waterfall"]
    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    speed_count: Points = 51
    amplitude_m: Positive = 1e-6
    direction: Literal["x", "y"] = "x"
    observe: Place

    @model_validator(mode="after")
    def _range(self) -> WaterfallSpec:
        refuse_falling(self.from_rpm, self.to_rpm)
        refuse_large("speed_count x frequency_count", self.speed_count, self.frequency_count)
        return self

    def run(self, engine: Engine) -> Outcome:
        """Response to harmonic ground motion over frequency and speed."""
        steps_rpm = np.linspace(self.from_rpm, self.to_rpm, self.speed_count)
        speeds = with_knots(steps_rpm * RAD_S_PER_RPM, engine.system.knots_rad_s)
        found = ground_motion_map(
            engine.system,
            self.amplitude_m,
            self.direction,
            speeds,
            self.frequencies_rad_s,
            end_of(self.observe),
        )
        major, steps = found.major_m(), ground_motion_peaks(engine.system, found)
        peaks = _map_peaks(steps, speeds * RPM_PER_RAD_S)
        return Outcome(
            kind=self.kind,
            document={
                "observed": self.observe,
                "ground_amplitude_m": self.amplitude_m,
                "direction": self.direction,
                "speed_rpm": (speeds * RPM_PER_RAD_S).tolist(),
                "frequency_hz": (found.frequencies_rad_s / (2.0 * np.pi)).tolist(),
                "amplitude_m": major.tolist(),
                "highest_m": steps.height_m.tolist(),
                "peaks": peaks,
            },
            files={
                f"{self.label}.png": lambda path: draw_ground_motion(
                    found, path, engine.title, steps
                )
            }
            if major.any()
            else {},
            headline="highest: "
            + ", ".join(f"{p['speed_rpm']:.0f} rpm {p['frequency_hz']:.1f} Hz" for p in peaks[:3]),
        )


def _map_peaks(steps: StepPeaks, rpm: NDArray[np.float64]) -> list[dict[str, float]]:
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
