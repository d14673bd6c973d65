"""Growth of motions in time: its rate at one speed, and where it ends in a run-up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.asymmetric.in_time.gauss_steps import Instants, SteppedSystem, gauss_steps
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.run_up.record import RunUp

# Turns that are too few to fit a rate to, and the part of them in which other motions die away.
_FEWEST_TURNS, _SETTLING = 8, 0.25


class FittedGrowth(NamedTuple):
    """Rate of growth, and how far it moves if only a part of the turns is looked at, 1/s."""

    rate_1_s: float
    error_1_s: float


class GrowthEnd(NamedTuple):
    """When and at which Ω of the reference shaft a motion was largest, and how large, m."""

    time_s: float
    speed_rad_s: float
    amplitude_m: float


def fitted_growth(
    system: PeriodicSystem,
    speed_rad_s: float,
    turns: int = 200,
    steps_per_turn: int = 256,
    seed: int = 0,
) -> FittedGrowth:
    """Integrate from a random disturbance at constant speed and fit the rate at which it grows.

    `speed_rad_s`: of the frame. Negative rates are of motions that all die away. The size of the
    motion is taken at whole turns; a beat of two motions is no growth and is weighted away (Hann
    window). Raises AnalysisError if the speed is 0 or there are fewer than 8 turns.
    """
    if not (np.isfinite(speed_rad_s) and speed_rad_s) or turns < _FEWEST_TURNS:
        raise AnalysisError(
            f"the speed is {speed_rad_s} over {turns} turns; a rate needs a speed other than 0 and "
            f"{_FEWEST_TURNS} turns or more"
        )
    stepped, n = SteppedSystem(system), system.size
    turn_s = 2.0 * np.pi / abs(speed_rad_s)
    states = np.empty((steps_per_turn + 1, 2 * n))
    state = np.random.default_rng(seed).standard_normal(2 * n)
    state[:n] /= abs(speed_rad_s)  # as energetic as the velocities

    def unloaded(instants: Instants) -> FloatArray:
        return np.zeros((instants.angles_rad.size, n))

    logs = np.empty(turns)
    for turn in range(turns):
        size = np.hypot(abs(speed_rad_s) * la.norm(state[:n]), la.norm(state[n:]))
        states[0] = state / size
        logs[turn] = np.log(size) + (logs[turn - 1] if turn else 0.0)
        begin = (0.0, speed_rad_s, 0.0)
        gauss_steps(stepped, unloaded, begin, turn_s / steps_per_turn, states)
        state = states[-1]
    logs = logs[int(_SETTLING * turns) :]
    middle = len(logs) // 2
    rate, early, late = (_slope(part) / turn_s for part in (logs, logs[:middle], logs[middle:]))
    return FittedGrowth(rate, max(abs(early - rate), abs(late - rate)))


def growth_end(run: RunUp) -> GrowthEnd | None:
    """Return where the motion of a run-up stops growing: its largest orbit of all turns.

    `run`: with one output or more. None where the motion is largest in the first or last turn, so
    that growth has not begun or not ended. Raises AnalysisError if no motion was recorded.
    """
    if not run.outputs:
        raise AnalysisError("the run-up has no outputs; the growth of a motion needs one")
    radius = np.hypot(run.translation_m[:, 0], run.translation_m[:, 1]).max(axis=0)
    turns = np.floor(np.abs(run.angle_rad - run.angle_rad[0]) / (2.0 * np.pi))
    top = int(radius.argmax())
    if turns[top] in (turns[0], turns[-1]):
        return None
    return GrowthEnd(float(run.time_s[top]), float(run.speed_rad_s[top]), float(radius[top]))


def _slope(values: FloatArray) -> float:
    """Slope of a line through values at whole numbers, weighted by a Hann window."""
    places = np.arange(len(values)) - 0.5 * (len(values) - 1)
    weight = np.cos(np.pi * places / len(values)) ** 2
    return float((weight * places) @ values / ((weight * places) @ places))
