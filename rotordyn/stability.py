"""Stability: the least damping over the speed, and the speed from which a mode grows by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq, minimize_scalar

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray, freeze_arrays
from solidwhirl.rotordyn.damping import NEUTRAL
from solidwhirl.rotordyn.eigen import Modes, modes_at_speed
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.tracking import POOR_OVERLAP, match_modes
from solidwhirl.rotordyn.whirl import whirl_direction

# Relative accuracy of a threshold, and the width at which one mode alone is followed to it.
_ACCURACY = 1e-12
_NARROW = 1e-7
_HALVINGS = 60
# A maximum of Re λ is looked into if it stands out by more than one part in this of |Re λ|.
_PROMINENT = 10.0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StabilityThreshold:
    """Hold the lowest speed at which a motion stops decaying.

    Attributes
    ----------
    speed_rad_s
        Ω, rad/s; 0 if the system is unstable at rest.
    kind
        "flutter" (an oscillation grows) or "divergence" (a motion grows without oscillating).
    eigenvalue
        λ there, 1/s; Re λ = 0 to rounding unless the system is unstable at rest.
    frequency_hz
        Im λ / 2π, Hz; 0 for a divergence.
    whirl
        Of the mode, "forward", "backward", "mixed" or "planar"; empty for a divergence.
    shape
        Mode in the independent coordinates, shape (n,), largest entry 1; empty for a divergence.
    """

    speed_rad_s: float
    kind: Literal["flutter", "divergence"]
    eigenvalue: complex
    frequency_hz: float
    whirl: str
    shape: ComplexArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "shape")


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StabilityChart:
    """Hold the least damped motion of a system over the speed.

    Attributes
    ----------
    speeds_rad_s
        Ω, shape (s,).
    log_decrement
        Smallest of the oscillatory modes looked at, shape (s,); nan where there is none.
    frequency_hz
        Of that mode, shape (s,), Hz.
    growth_rate_1_s
        Largest Re λ of all motions, oscillating or not, shape (s,); zeros of rigid motion aside.
    unstable_count
        Number of eigenvalues that grow, an oscillation counting once, shape (s,).
    """

    speeds_rad_s: FloatArray
    log_decrement: FloatArray
    frequency_hz: FloatArray
    growth_rate_1_s: FloatArray
    unstable_count: npt.NDArray[np.int_]

    def __post_init__(self) -> None:
        freeze_arrays(
            self,
            "speeds_rad_s",
            "log_decrement",
            "frequency_hz",
            "growth_rate_1_s",
            "unstable_count",
        )


def stability_chart(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    frequency_max_hz: float = np.inf,
) -> StabilityChart:
    """Compute the least damped motion of a system over a range of speeds.

    Parameters
    ----------
    assembled
        The system.
    speeds_rad_s
        Ω, shape (s,), in any order.
    frequency_max_hz
        Leave oscillatory modes above this out of `log_decrement`; high modes that move no damped
        place are neutral and hide the others. All count for `unstable_count`.

    Returns
    -------
    StabilityChart
        For the damping of each branch use `campbell`.

    Raises
    ------
    AnalysisError
        If a speed is not finite or there is none.
    """
    speeds = np.array(speeds_rad_s, dtype=float)
    if speeds.ndim != 1 or not speeds.size or not np.isfinite(speeds).all():
        raise AnalysisError(f"speeds_rad_s needs one or more finite speeds; found {speeds.shape}")
    rows = []
    for speed in speeds:
        modes = modes_at_speed(assembled, float(speed))
        decrement, frequency = np.nan, np.nan
        low = np.flatnonzero(modes.frequency_hz <= frequency_max_hz)
        if low.size:
            at = int(low[modes.log_decrement[low].argmin()])
            decrement, frequency = modes.log_decrement[at], modes.frequency_hz[at]
        rates = _rates(modes)
        largest = float(rates.rates.max()) if rates.rates.size else np.nan
        rows.append((decrement, frequency, largest, rates.growing.sum()))
    columns = np.array(rows, dtype=float).T
    return StabilityChart(
        speeds_rad_s=speeds,
        log_decrement=columns[0],
        frequency_hz=columns[1],
        growth_rate_1_s=columns[2],
        unstable_count=columns[3].astype(int),
    )


def stability_threshold(
    assembled: AssembledSystem, speed_max_rad_s: float, speed_count: int = 41
) -> StabilityThreshold | None:
    """Find the lowest speed at which a motion of the system stops decaying.

    Parameters
    ----------
    assembled
        The system.
    speed_max_rad_s
        Search from rest up to this Ω, rad/s.
    speed_count
        Speeds looked at first, evenly spaced. An unstable range between two of them is found if
        three neighbours show a maximum of Re λ of an oscillation that stands out by a tenth.

    Returns
    -------
    StabilityThreshold or None
        None if nothing grows. Growth below 1e-8 of the eigenvalue counts as neutral.

    Raises
    ------
    AnalysisError
        If the speed is not positive and finite, or fewer than 3 speeds are asked for.

    Notes
    -----
    The growth of any mode brackets the threshold, whatever the order of the modes; then Re λ = 0
    is solved on the mode that grows. An undamped system whose modes meet and split has no Re λ
    that changes its sign; there the place where growth begins is bisected.
    """
    if not (np.isfinite(speed_max_rad_s) and speed_max_rad_s > 0):
        raise AnalysisError(f"speed_max_rad_s is {speed_max_rad_s}; it must be positive, finite")
    if speed_count < 3:
        raise AnalysisError(f"speed_count is {speed_count}; 3 or more are needed")
    if _never_grows(assembled, speed_max_rad_s):
        return None
    search = _Search(assembled)
    speeds = np.linspace(0.0, speed_max_rad_s, speed_count)
    for index, speed in enumerate(speeds):
        # A range between the last speeds comes first, even if something grows at this one.
        peak = search.peak(speeds[: index + 1])
        if peak is not None:
            return search.threshold(float(speeds[index - 2]), peak)
        if search.grows(float(speed)):
            if index == 0:
                return search.record(0.0)
            return search.threshold(float(speeds[index - 1]), float(speed))
    return None


class _Rates(NamedTuple):
    """All eigenvalues that are not zero, oscillating first, with their growth."""

    values: ComplexArray
    rates: FloatArray
    growing: npt.NDArray[np.bool_]


def _rates(modes: Modes) -> _Rates:
    values = np.concatenate((modes.eigenvalues, modes.real_eigenvalues.astype(complex)))
    return _Rates(values, values.real, values.real > NEUTRAL * np.abs(values))


def _never_grows(assembled: AssembledSystem, speed_max_rad_s: float) -> bool:
    """Whether there is no damping and the stiffness, linear in Ω², is not negative at the ends."""
    if not (assembled.is_conservative and assembled.has_constant_bearings):
        return False
    ends = (modes_at_speed(assembled, speed, 1) for speed in (0.0, speed_max_rad_s))
    return all(modes.negative_stiffness_count == 0 for modes in ends)


class _Search:
    """Look for growth in a system, computing the modes at each speed once."""

    def __init__(self, assembled: AssembledSystem) -> None:
        self.assembled = assembled
        self._known: dict[float, Modes] = {}

    def modes(self, speed: float) -> Modes:
        """Return all modes at a speed."""
        if speed not in self._known:
            self._known[speed] = modes_at_speed(self.assembled, speed)
        return self._known[speed]

    def grows(self, speed: float) -> bool:
        """Whether any motion grows at a speed."""
        return bool(_rates(self.modes(speed)).growing.any())

    def nearest(self, speed: float, value: complex) -> complex:
        """Return the eigenvalue at a speed that is nearest to a value."""
        values = _rates(self.modes(speed)).values
        return complex(values[np.abs(values - value).argmin()])

    def peak(self, speeds: FloatArray) -> float | None:
        """Return a speed between the last three at which a damped mode grows, None if none."""
        if speeds.size < 3:
            return None
        left, middle, right = (float(v) for v in speeds[-3:])
        for before, here, after in self._triples(left, middle, right):
            rise, fall = (here - before).real, (here - after).real
            steep = here.real + _PROMINENT * max(rise, fall) > NEUTRAL * abs(here)
            if min(rise, fall) <= 0 or not steep:
                continue
            best = self._highest((left, middle, right), (before, here, after))
            if self.grows(best):
                return best
        return None

    def _triples(
        self, left: float, middle: float, right: float
    ) -> list[tuple[complex, complex, complex]]:
        """Return the eigenvalue of each mode at three speeds, where it is recognised."""
        here = self.modes(middle)
        back = match_modes(self.assembled, here, self.modes(left))
        forth = match_modes(self.assembled, here, self.modes(right))
        known = np.minimum(back.likeness, forth.likeness) > POOR_OVERLAP
        return [
            (
                complex(back.second.eigenvalues[back.partner[k]]),
                complex(here.eigenvalues[k]),
                complex(forth.second.eigenvalues[forth.partner[k]]),
            )
            for k in np.flatnonzero(known & (back.partner >= 0) & (forth.partner >= 0))
        ]

    def _highest(
        self, speeds: tuple[float, float, float], values: tuple[complex, complex, complex]
    ) -> float:
        """Return the speed of the largest growth rate of one mode between three speeds."""
        path = np.polyfit(np.array(speeds) - speeds[1], np.array(values), 2)

        def decay(speed: float) -> float:
            return -self.nearest(speed, complex(np.polyval(path, speed - speeds[1]))).real

        found = minimize_scalar(decay, bounds=(speeds[0], speeds[2]), method="bounded")
        return float(found.x)

    def threshold(self, stable: float, unstable: float) -> StabilityThreshold:
        """Return the threshold between a speed without growth and one with it."""
        low, high = self._halved(stable, unstable, _NARROW)
        crossing = self._sign_change(low, high)
        if crossing is None:
            return self.record(self._halved(low, high, _ACCURACY)[1])
        ends = crossing, high
        values = [self._growing(high)]
        values.insert(0, self.nearest(crossing, values[0]))

        def growth(speed: float) -> float:
            part = (speed - ends[0]) / (ends[1] - ends[0])
            return self.nearest(speed, values[0] + part * (values[1] - values[0])).real

        root = float(brentq(growth, *ends, xtol=_ACCURACY * high, rtol=_ACCURACY))
        return self.record(root, values[1])

    def _halved(self, low: float, high: float, width: float) -> tuple[float, float]:
        """Return a narrower pair of a speed without growth and one with it."""
        for _ in range(_HALVINGS):
            if high - low <= width * high:
                break
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.grows(middle) else (middle, high)
        return low, high

    def _growing(self, speed: float) -> complex:
        """Return the eigenvalue with the largest growth for its size."""
        found = _rates(self.modes(speed))
        return complex(found.values[(found.rates / np.abs(found.values)).argmax()])

    def _sign_change(self, low: float, high: float) -> float | None:
        """Return the nearest speed below at which the growing mode is damped, None if neutral."""
        value, speed, step = self._growing(high), high, max(high - low, _ACCURACY * high)
        while speed > 0:
            speed = max(0.0, speed - step)
            value = self.nearest(speed, value)
            if value.real < -NEUTRAL * abs(value):
                return speed
            step *= 2.0
        return None

    def record(self, speed: float, near: complex | None = None) -> StabilityThreshold:
        """Return the record of the threshold at a speed."""
        modes = self.modes(speed)
        value = self._growing(speed) if near is None else self.nearest(speed, near)
        if value.imag == 0:
            return StabilityThreshold(
                speed_rad_s=speed,
                kind="divergence",
                eigenvalue=value,
                frequency_hz=0.0,
                whirl="",
                shape=np.empty(0, dtype=complex),
            )
        at = int(np.abs(modes.eigenvalues - value).argmin())
        shape = modes.shapes[:, at]
        return StabilityThreshold(
            speed_rad_s=speed,
            kind="flutter",
            eigenvalue=value,
            frequency_hz=value.imag / (2.0 * np.pi),
            whirl=str(whirl_direction(self.assembled, shape[:, None])[0]),
            shape=shape / shape[np.abs(shape).argmax()],
        )
