"""Differences between the results of two models of one engine, matched one to one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, ReadOnlyArrays, StringArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed

# Speeds of two diagrams, or excitation ratios, closer than this (relative) are equal.
_SAME = 1e-9
# Results further apart than this (relative, in the mean) are not the same one.
_FARTHEST = 0.25
# Weight of the speeds at which two branches whirl in opposite sense.
_OPPOSITE = 0.5


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CampbellDifferences(ReadOnlyArrays):
    """Hold how the branches of one Campbell diagram differ from those of another.

    `partner`: branch of the second diagram for each of the first, −1 for none, shape (b,);
    `frequency`: (f₁ − f₂) / f₁, shape (b, s); nan where a branch has no partner or one of both is
    absent.
    """

    partner: IntArray
    frequency: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CriticalSpeedDifferences(ReadOnlyArrays):
    """Hold how the critical speeds of one model differ from those of another.

    `partner`: critical speed of the second model for each of the first, −1 for none, shape (k,);
    `speed`: (Ω₁ − Ω₂) / Ω₁, shape (k,), nan without a partner.
    """

    partner: IntArray
    speed: FloatArray


def campbell_differences(first: Campbell, second: Campbell) -> CampbellDifferences:
    """Compare the branches of two Campbell diagrams over the same speeds.

    `first`, `second`: of two models of one engine; give the second some branches more, so that
    those of the first that lie on its upper edge find their partners, of which each has one at
    most. Raises AnalysisError if the speeds differ.

    Branches are paired for the least sum (assignment problem) of the mean relative difference of
    their frequencies along the speeds, plus half the share of the speeds at which one whirls
    forward and the other backward. A pair that costs 0.25 or more is no pair.
    """
    speeds = first.speeds_rad_s, second.speeds_rad_s
    if speeds[0].shape != speeds[1].shape or not np.allclose(*speeds, rtol=_SAME, atol=_SAME):
        raise AnalysisError(
            f"the diagrams have other speeds ({speeds[0].size} and {speeds[1].size} from "
            f"{speeds[0][0]:.6g} and {speeds[1][0]:.6g} to {speeds[0][-1]:.6g} and "
            f"{speeds[1][-1]:.6g} rad/s); compute both over the same ones"
        )
    cost = np.array(
        [
            [_branch_cost(first, i, second, j) for j in range(second.frequency_hz.shape[0])]
            for i in range(first.frequency_hz.shape[0])
        ]
    ).reshape(len(first.frequency_hz), len(second.frequency_hz))
    partner = _partners(cost)
    frequency = np.full(first.frequency_hz.shape, np.nan)
    found = partner >= 0
    mine = first.frequency_hz[found]
    frequency[found] = (mine - second.frequency_hz[partner[found]]) / mine
    return CampbellDifferences(partner=partner, frequency=frequency)


def frequency_partners(
    first_hz: FloatArray, first_whirl: StringArray, second_hz: FloatArray, second_whirl: StringArray
) -> IntArray:
    """Pair modes of two models at one speed by frequency and whirl.

    `first_hz`, `first_whirl`: nan and any whirl where a mode is absent, shape (b,). Returns the
    mode of the second model for each of the first, −1 for none, as for branches.
    """
    f, g = first_hz[:, None], second_hz[None, :]
    larger = np.maximum(f, g)
    apart = np.abs(f - g) / np.where(larger == 0.0, 1.0, larger)
    opposite = np.multiply.outer(_sense(first_whirl), _sense(second_whirl)) < 0
    cost = apart + _OPPOSITE * opposite
    return _partners(np.where(np.isfinite(cost), cost, _FARTHEST))


def critical_speed_differences(
    first: Sequence[CriticalSpeed], second: Sequence[CriticalSpeed]
) -> CriticalSpeedDifferences:
    """Compare the critical speeds of two models.

    `first`, `second`: of two models of one engine, with any excitation ratios. The result is of the
    first model's, each with one partner at most: of the same excitation ratio and whirl, and nearer
    than 0.25 of its speed, for the least sum of relative differences.
    """
    cost = np.array([[_speed_cost(a, b) for b in second] for a in first])
    partner = _partners(cost.reshape(len(first), len(second)))
    speed = np.full(len(first), np.nan)
    for place, other in enumerate(partner):
        if other >= 0:
            mine = first[place].speed_rad_s
            speed[place] = (mine - second[other].speed_rad_s) / mine
    return CriticalSpeedDifferences(partner=partner, speed=speed)


def _branch_cost(first: Campbell, branch: int, second: Campbell, other: int) -> float:
    mine, theirs = first.frequency_hz[branch], second.frequency_hz[other]
    both = np.isfinite(mine) & np.isfinite(theirs)
    if not both.any():
        return _FARTHEST
    apart = np.abs(mine[both] - theirs[both]) / np.maximum(mine[both], theirs[both])
    opposite = _sense(first.whirl[branch, both]) * _sense(second.whirl[other, both]) < 0
    return float(apart.mean() + _OPPOSITE * opposite.mean())


def _sense(whirl: StringArray) -> IntArray:
    """1 of forward whirl, −1 of backward, 0 of others."""
    return np.asarray((whirl == "forward").astype(int) - (whirl == "backward"))


def _speed_cost(first: CriticalSpeed, second: CriticalSpeed) -> float:
    ratios = [c.frequency_hz / c.speed_rad_s for c in (first, second)]
    if first.whirl != second.whirl or abs(ratios[0] - ratios[1]) > _SAME * ratios[0]:
        return _FARTHEST
    return abs(first.speed_rad_s - second.speed_rad_s) / first.speed_rad_s


def _partners(cost: FloatArray) -> IntArray:
    """Return the column of each row, one to one, −1 where all that is left is too far."""
    partner = np.full(cost.shape[0], -1)
    limited = np.minimum(cost, _FARTHEST)
    rows, columns = scipy.optimize.linear_sum_assignment(limited)
    near = limited[rows, columns] < _FARTHEST
    partner[rows[near]] = columns[near]
    return partner
