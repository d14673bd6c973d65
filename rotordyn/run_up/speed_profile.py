"""Speed of the reference shaft over time, piecewise linear, with its exact angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, freeze_arrays
from solidwhirl.rotordyn.core.errors import AnalysisError


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class SpeedProfile:
    """Hold Ω(t), linear between breakpoints.

    `times_s`: breakpoints, rising from 0, shape (b,), b ≥ 2. `speeds_rad_s`: Ω there, shape (b,);
    either sign. Raises AnalysisError if shapes do not fit, numbers are not finite, or times do not
    rise from 0.
    """

    times_s: FloatArray
    speeds_rad_s: FloatArray

    def __post_init__(self) -> None:
        times = np.asarray(self.times_s, dtype=float)
        speeds = np.asarray(self.speeds_rad_s, dtype=float)
        if times.ndim != 1 or times.size < 2 or speeds.shape != times.shape:
            raise AnalysisError(
                f"a speed profile has times of shape {times.shape} and speeds of shape "
                f"{speeds.shape}; two or more of each are needed"
            )
        if not (np.isfinite(times).all() and np.isfinite(speeds).all()):
            raise AnalysisError("a speed profile has times or speeds that are not finite")
        if times[0] != 0 or (np.diff(times) <= 0).any():
            raise AnalysisError(
                f"times_s of a speed profile is {times.tolist()}; it must rise from 0"
            )
        object.__setattr__(self, "times_s", times)
        object.__setattr__(self, "speeds_rad_s", speeds)
        freeze_arrays(self)

    @property
    def duration_s(self) -> float:
        """Time of the last breakpoint, s."""
        return float(self.times_s[-1])

    @property
    def accelerations_rad_s2(self) -> FloatArray:
        """Ω' between the breakpoints, shape (b − 1,)."""
        return np.asarray(np.diff(self.speeds_rad_s) / np.diff(self.times_s))

    def speed_rad_s(self, time_s: npt.ArrayLike) -> FloatArray:
        """Return Ω at given times.

        `time_s`: times within the profile, any shape. Raises AnalysisError if one lies outside it.
        """
        piece, since = self._pieces(time_s)
        return np.asarray(self.speeds_rad_s[piece] + self.accelerations_rad_s2[piece] * since)

    def acceleration_rad_s2(self, time_s: npt.ArrayLike) -> FloatArray:
        """Return Ω' as `speed_rad_s` returns Ω; at a breakpoint that of the piece that begins."""
        return np.asarray(self.accelerations_rad_s2[self._pieces(time_s)[0]])

    def angle_rad(self, time_s: npt.ArrayLike) -> FloatArray:
        """Return the angle the reference shaft has turned since time 0, ∫ Ω dt.

        As `speed_rad_s`; the integral is exact and not reduced to one turn.
        """
        piece, since = self._pieces(time_s)
        means = 0.5 * (self.speeds_rad_s[1:] + self.speeds_rad_s[:-1])
        turned = np.concatenate(([0.0], np.cumsum(means * np.diff(self.times_s))))
        rate = self.speeds_rad_s[piece] + 0.5 * self.accelerations_rad_s2[piece] * since
        return np.asarray(turned[piece] + rate * since)

    def _pieces(self, time_s: npt.ArrayLike) -> tuple[IntArray, FloatArray]:
        """Return the piece of each time and the time since it began."""
        times = np.asarray(time_s, dtype=float)
        inside = (times >= 0) & (times <= self.duration_s)
        if not inside.all():
            raise AnalysisError(
                f"time {times[~inside].flat[0]:.6g} s is outside the speed profile, which goes "
                f"from 0 to {self.duration_s:.6g} s"
            )
        last = self.times_s.size - 2
        piece = np.clip(np.searchsorted(self.times_s, times, side="right") - 1, 0, last)
        return piece, np.asarray(times - self.times_s[piece])


def ramp_and_hold(
    speed_rad_s: float, ramp_s: float, hold_s: float = 0.0, start_speed_rad_s: float = 0.0
) -> SpeedProfile:
    """Return a linear ramp to a speed that is then held.

    `speed_rad_s`: Ω at the end of the ramp, rad/s; `ramp_s`: duration of the ramp, s, positive.
    `hold_s`: duration at constant speed, s; 0 leaves it out. `start_speed_rad_s`: Ω at time 0,
    rad/s. The source paper (Müller and Hennings, section 5.8) ramps 20 s from rest to 13690 rpm
    and holds 10 s. Raises AnalysisError if a number is not finite or a duration has no meaning.
    """
    if not (np.isfinite(ramp_s) and ramp_s > 0):
        raise AnalysisError(f"ramp_s is {ramp_s}; it must be positive")
    if not (np.isfinite(hold_s) and hold_s >= 0):
        raise AnalysisError(f"hold_s is {hold_s}; it must be 0 or more")
    held = hold_s > 0
    return SpeedProfile(
        times_s=np.array([0.0, ramp_s, ramp_s + hold_s][: 3 if held else 2]),
        speeds_rad_s=np.array([start_speed_rad_s, speed_rad_s, speed_rad_s][: 3 if held else 2]),
    )
