"""Steady response of a system with nonlinear forces over the speed: branches, jumps, stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import seat_motion
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    ReadOnlyArrays,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.nonlinear.continuation import Branch, BranchPoint, branches
from solidwhirl.rotordyn.nonlinear.forced_system import (
    ForcedSystem,
    NonlinearJoint,
    condensed,
    forced_system,
)
from solidwhirl.rotordyn.nonlinear.harmonic_balance import (
    Point,
    as_real,
    at_speed,
    corrected,
    fourier,
    with_harmonics,
)
from solidwhirl.rotordyn.nonlinear.sought import of_period, refined, sought_branches
from solidwhirl.rotordyn.nonlinear.stability import (
    GROWS,
    SmallMotions,
    multipliers,
    small_motions,
)
from solidwhirl.rotordyn.response.harmonic_response import check_lateral
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
from solidwhirl.rotordyn.response.unbalance import Unbalance

# Numbers of harmonics that are tried; each is checked by the next.
_LADDER = (1, 3, 7, 15, 31, 63)
# Harmonics per turn of motions that are sought, at least, how often they are doubled, and at most.
_FEWEST, _REFINED, _MOST = 3, 3, 126
# Motions of a branch at which more harmonics are tried, beside turning points.
_CHECKED = 12
# Part of the motions of a branch beside a turning point where its own stability changes, at least.
_BESIDE = 3

ChangeKind = Literal["quasi-periodic", "period doubling", "branching"]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class NonlinearBranch(ReadOnlyArrays):
    """Hold motions along a branch, p of them.

    `speeds_rad_s`: Ω, shape (p,), not always rising; `translation_m`: amplitudes of ux, uy at the
    places for e^{ikωt}, k = 0 to h, shape (p, h + 1, places, 2); `largest_radius_m`: largest
    distance from the position without loads, shape (p, places). `multiplier`: the Floquet
    multiplier furthest from 0, shape (p,); `is_stable`: whether small motions beside it die out;
    `is_turning`: where the speed turns. `is_whole`: whether the branch was followed until it left
    the range of speeds, closed, or met one of fewer turns; `is_closed`: whether it closes.
    `period_multiple`: turns of the unbalance after which motions repeat; ω is over that many.
    """

    speeds_rad_s: FloatArray
    translation_m: ComplexArray
    largest_radius_m: FloatArray
    multiplier: ComplexArray
    is_stable: BoolArray
    is_turning: BoolArray
    is_whole: bool
    is_closed: bool = False
    period_multiple: int = 1

    def major_m(self) -> FloatArray:
        """Return the major semi-axes at the frequency of the unbalance, shape (p, places)."""
        first = self.translation_m[:, self.period_multiple]
        return elliptic_orbits(first[..., 0], first[..., 1]).major_m


class Jump(NamedTuple):
    """Where a stable branch ends at a turning point.

    `direction`: "up" where it ends as the speed rises, else "down". `before_m`, `after_m`: largest
    radius at the places at the turning point, and on the stable branch that remains; nan where
    none is known.
    """

    speed_rad_s: float
    direction: Literal["up", "down"]
    before_m: FloatArray
    after_m: FloatArray


class StabilityChange(NamedTuple):
    """Where a branch changes its stability without turning, and how the other motion begins."""

    speed_rad_s: float
    kind: ChangeKind


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class NonlinearResponse:
    """Hold the steady response to unbalance over the speed.

    `places`: observed; `branches`: from the lowest speed, and from the highest if that is another,
    then those that were sought, `sought_count`; `jumps`, `changes`: by place along the branches.
    `harmonics`: h that were balanced, of the branches from the ends; `truncation`: largest change
    of motions (relative to their own size) and speeds with twice as many.
    """

    places: tuple[End, ...]
    branches: tuple[NonlinearBranch, ...]
    jumps: tuple[Jump, ...]
    changes: tuple[StabilityChange, ...]
    harmonics: int
    truncation: float
    sought_count: int = 0

    @property
    def sought(self) -> tuple[NonlinearBranch, ...]:
        """Branches that were sought besides those from the ends of the speeds."""
        return self.branches[len(self.branches) - self.sought_count :]


def nonlinear_response(
    assembled: AssembledSystem,
    joints: Sequence[NonlinearJoint],
    unbalances: Sequence[Unbalance],
    speeds_rad_s: tuple[float, float],
    places: Sequence[End],
    *,
    gravity_m_per_s2: npt.ArrayLike = (0.0, 0.0, 0.0),
    tolerance: float = 1e-3,
    sought_turns: Sequence[int] = (),
) -> NonlinearResponse:
    """Return the motion with the period of the unbalance over the speed, and what is sought beside.

    `joints`: nonlinear forces beside the bearings; `unbalances`: of one frequency;
    `speeds_rad_s`: lowest and highest Ω, above 0; `places`: interfaces with ux and uy;
    `tolerance`: harmonics are added until more of them change motions by less; `sought_turns`:
    turns of the unbalance after which motions repeat that are sought too, 1 for branches that reach
    neither end of the speeds. Those are found where motions from 144 starts settle to them in time.
    Raises AnalysisError if the speeds do not rise from above 0, joints, unbalances or places do not
    fit the system, or no motion is found at an end of the range.
    """
    low, high = speeds_rad_s
    if not 0.0 < low < high < np.inf:
        raise AnalysisError(f"speeds are {low:g} and {high:g} rad/s; they must rise from above 0")
    for place in places:
        check_lateral(assembled, place, f"motion at {place.label}")
    forced = forced_system(assembled, joints, unbalances, np.sqrt(low * high), gravity_m_per_s2)
    found, harmonics, truncation = _converged(forced, (low, high), tolerance)
    rows = np.concatenate([seat_motion(assembled, place)[:2] for place in places])
    small = small_motions(forced, high)
    groups = {1: found}
    for turns in sorted(set(sought_turns)):
        own = of_period(small, turns)
        more, missed = _sought(own, (low, high), found, (harmonics, tolerance))
        truncation = max(truncation, missed)
        groups[turns] = (*groups.get(turns, ()), *more)
    told: list[NonlinearBranch] = []
    jumps: list[Jump] = []
    for turns, group in groups.items():
        own = of_period(small, turns)
        parts = tuple(_told(own, branch, rows) for branch in group)
        jumps += _jumps(own.forced, group, parts, rows)
        told += parts
    return NonlinearResponse(
        places=tuple(places),
        branches=tuple(told),
        jumps=tuple(jumps),
        changes=tuple(change for branch in told for change in _changes(branch)),
        harmonics=harmonics,
        truncation=truncation,
        sought_count=len(told) - len(found),
    )


def _sought(
    small: SmallMotions,
    ends: tuple[float, float],
    known: Sequence[Branch],
    asked: tuple[int, float],
) -> tuple[tuple[Branch, ...], float]:
    """Return the branches of a number of turns that are not known, and what harmonics change.

    `asked`: harmonics of the known ones, and the tolerance.
    """
    (least, tolerance), forced = asked, small.forced
    harmonics = forced.period_multiple * max(least, _FEWEST)
    out, worst = [], 0.0
    for branch in sought_branches(small, ends, known, harmonics):
        count, missed = harmonics, np.inf
        for _ in range(_REFINED):
            missed = _truncation(forced, branch, 2 * count)
            better = None
            if missed > tolerance and 2 * count <= _MOST:
                better = refined(forced, branch, ends, 2 * count)
            if better is None:
                break
            branch, count = better, 2 * count
        out.append(branch)
        worst = max(worst, missed)
    return tuple(out), worst


def _converged(
    forced: ForcedSystem, ends: tuple[float, float], tolerance: float
) -> tuple[tuple[Branch, ...], int, float]:
    """Return branches with as many harmonics as needed, their number, and what more would change.

    Raises AnalysisError if no motion is found with any number of harmonics.
    """
    for harmonics, more in pairwise(_LADDER):
        found = branches(forced, *ends, harmonics)
        truncation = max(_truncation(forced, branch, more) for branch in found)
        if truncation <= tolerance:
            break
    return found, harmonics, truncation


def _truncation(forced: ForcedSystem, branch: Branch, harmonics: int) -> float:
    """Largest relative change of some motions and speeds of a branch with more harmonics."""
    every = max(1, len(branch.points) // _CHECKED)
    checked = [p for k, p in enumerate(branch.points) if k % every == 0 or p.is_turning]
    return max(_change(forced, p, harmonics) for p in checked)


def _change(forced: ForcedSystem, at: BranchPoint, harmonics: int) -> float:
    motion = with_harmonics(at.point.motion_m, harmonics)
    along = with_harmonics(at.along_motion.reshape(at.point.motion_m.shape), harmonics)
    size = float(np.abs(motion).max())
    row = along.ravel() / size**2, at.along_speed / at.point.speed_rad_s**2
    found = corrected(forced, (motion, at.point.speed_rad_s), row, size)
    if found is None:
        return np.inf
    moved = la.norm(found.motion_m - motion) / la.norm(found.motion_m)
    return max(float(moved), abs(found.speed_rad_s / at.point.speed_rad_s - 1.0))


def place_motion(forced: ForcedSystem, point: Point, rows: FloatArray) -> ComplexArray:
    """Return amplitudes of rows (m, n) of the coordinates in a motion, shape (h + 1, m)."""
    part = condensed(forced, point.speed_rad_s, len(point.motion_m) // 2, rows)
    pushed = np.einsum("kij,kj->ki", part.receptance, point.balance.force_n)
    return np.asarray(part.free_m - pushed)


def _radius(motion_m: ComplexArray) -> FloatArray:
    """Largest distance in a motion (h + 1, 2 places) at each place."""
    values = fourier(len(motion_m) - 1).values @ as_real(motion_m)
    return np.asarray(np.hypot(values[:, 0::2], values[:, 1::2]).max(axis=0))


def _told(small: SmallMotions, branch: Branch, rows: FloatArray) -> NonlinearBranch:
    forced = small.forced
    points = [p.point for p in branch.points]
    motions = [place_motion(forced, p, rows) for p in points]
    largest = np.array([multipliers(small, p.motion_m, p.speed_rad_s)[0] for p in points])
    return NonlinearBranch(
        speeds_rad_s=np.array([p.speed_rad_s for p in points]),
        translation_m=np.array(motions).reshape(len(points), -1, len(rows) // 2, 2),
        largest_radius_m=np.array([_radius(m) for m in motions]),
        multiplier=largest,
        is_stable=np.abs(largest) <= 1.0 + GROWS,
        is_turning=np.array([p.is_turning for p in branch.points]),
        is_whole=branch.is_whole,
        is_closed=branch.is_closed,
        period_multiple=forced.period_multiple,
    )


def _jumps(
    forced: ForcedSystem,
    found: Sequence[Branch],
    told: Sequence[NonlinearBranch],
    rows: FloatArray,
) -> list[Jump]:
    jumps = []
    for number, branch in enumerate(told):
        speeds = branch.speeds_rad_s
        for at in np.flatnonzero(branch.is_turning):
            if not 0 < at < speeds.size - 1:
                continue
            if branch.is_stable[at - 1] == branch.is_stable[at + 1]:
                continue
            after = _landing(forced, found, told, (number, int(at)))
            jumps.append(
                Jump(
                    speed_rad_s=float(speeds[at]),
                    direction="up" if speeds[at] > speeds[at - 1] else "down",
                    before_m=branch.largest_radius_m[at],
                    after_m=np.full(len(rows) // 2, np.nan)
                    if after is None
                    else _radius(place_motion(forced, after, rows)),
                )
            )
    return jumps


def _landing(
    forced: ForcedSystem,
    found: Sequence[Branch],
    told: Sequence[NonlinearBranch],
    turning: tuple[int, int],
) -> Point | None:
    """The stable motion at the speed of a turning point, nearest along the branches."""
    speed = told[turning[0]].speeds_rad_s[turning[1]]
    near: list[tuple[int, int, int]] = []
    for number, branch in enumerate(told):
        above = branch.speeds_rad_s > speed
        for k in np.flatnonzero(above[1:] != above[:-1]):
            apart = abs(int(k) - turning[1]) if number == turning[0] else len(above)
            if apart > 1 and branch.is_stable[k] and branch.is_stable[k + 1]:
                near.append((apart, number, int(k)))
    if not near:
        return None
    _, number, k = min(near)
    before, after = (found[number].points[j].point for j in (k, k + 1))
    share = (speed - before.speed_rad_s) / (after.speed_rad_s - before.speed_rad_s)
    motion = before.motion_m + share * (after.motion_m - before.motion_m)
    return at_speed(forced, motion, float(speed))


def _changes(branch: NonlinearBranch) -> list[StabilityChange]:
    """Changes of stability that are none of turning points."""
    turning = np.flatnonzero(branch.is_turning)
    out = []
    for k in np.flatnonzero(branch.is_stable[1:] != branch.is_stable[:-1]):
        if np.abs(turning - k).min(initial=_BESIDE) < _BESIDE:
            continue
        size = np.log(np.abs(branch.multiplier[k : k + 2]))
        share = float(np.clip(-size[0] / (size[1] - size[0]), 0.0, 1.0))
        speeds = branch.speeds_rad_s[k : k + 2]
        grows = branch.multiplier[k + int(branch.is_stable[k])]
        out.append(
            StabilityChange(float(speeds[0] + share * (speeds[1] - speeds[0])), _kind(grows))
        )
    return out


def _kind(multiplier: complex) -> ChangeKind:
    if abs(multiplier.imag) > 1e-6 * abs(multiplier):
        return "quasi-periodic"
    return "period doubling" if multiplier.real < 0.0 else "branching"
