"""Steady response of a system with nonlinear forces over the speed: branches, jumps, stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

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
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.nonlinear.continuation import (
    Branch,
    Course,
    OpenEnd,
    passing,
    through,
)
from solidwhirl.rotordyn.nonlinear.forced_system import (
    ForcedSystem,
    NonlinearJoint,
    condensed,
    forced_system,
)
from solidwhirl.rotordyn.nonlinear.harmonic_balance import (
    Guess,
    Point,
    as_real,
    at_parameter,
    at_speed,
    balance,
    corrected,
    fourier,
    gaps,
    with_harmonics,
)
from solidwhirl.rotordyn.nonlinear.stability import (
    GROWS,
    SmallMotions,
    multipliers,
    small_motions,
)
from solidwhirl.rotordyn.nonlinear.starts import in_time, starts_of_one_turn
from solidwhirl.rotordyn.response.harmonic_response import check_lateral
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
from solidwhirl.rotordyn.response.unbalance import Unbalance

# Harmonics are nearly doubled, and each number checked by the next, up to these in all; per turn of
# motions of several turns at least.
_MOST, _FEWEST = 62, 3
# Longest step along a branch, and how far motions are followed beyond the largest start.
_LONGEST, _GROWN = 0.025, 1e3
# Motions that differ by less than this part are one.
_SAME = 3e-3
# Motions of a branch at which more harmonics are tried, beside turning points; starts before.
_CHECKED, _SOME = 12, 6
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
    `is_turning`: where the speed turns. `open_ends`: indices of ends that neither are ends of the
    range of speeds nor meet a motion of fewer turns, and why; `is_closed`: whether the branch
    closes.
    `period_multiple`: turns of the unbalance after which motions repeat; ω is over that many.
    """

    speeds_rad_s: FloatArray
    translation_m: ComplexArray
    largest_radius_m: FloatArray
    multiplier: ComplexArray
    is_stable: BoolArray
    is_turning: BoolArray
    open_ends: tuple[tuple[int, OpenEnd], ...] = ()
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

    `places`: observed; `branches`: those of one turn, through the lowest speed first, then those of
    more; `jumps`, `changes`: by place along the branches. `harmonics`: h that were balanced, of the
    branches of one turn; `truncation`: largest change of motions (relative to their own size) and
    speeds with twice as many. `stopped`: speeds (rad/s) at which a path of raised loads stops,
    and at which part of them: motions to which it alone leads are not known.
    """

    places: tuple[End, ...]
    branches: tuple[NonlinearBranch, ...]
    jumps: tuple[Jump, ...]
    changes: tuple[StabilityChange, ...]
    harmonics: int
    truncation: float
    stopped: tuple[tuple[float, float], ...] = ()


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
    turns of the unbalance after which motions repeat that are sought too, where motions from 144
    starts settle to them in time; 1 for more starts of those of one turn. Raises AnalysisError if
    the speeds do not rise from above 0, joints, unbalances or places do not fit the system, or no
    motion is found at all.
    """
    low, high = speeds_rad_s
    if not 0.0 < low < high < np.inf:
        raise AnalysisError(f"speeds are {low:g} and {high:g} rad/s; they must rise from above 0")
    for place in places:
        check_lateral(assembled, place, f"motion at {place.label}")
    forced = forced_system(assembled, joints, unbalances, np.sqrt(low * high), gravity_m_per_s2)
    starts, stopped = starts_of_one_turn(forced, speeds_rad_s)
    found, harmonics, truncation = _converged(forced, speeds_rad_s, starts, tolerance)
    if not found:
        raise AnalysisError(
            f"no steady motion is found from {low * RPM_PER_RAD_S:.6g} to "
            f"{high * RPM_PER_RAD_S:.6g} rpm, neither at once nor as the loads are raised from none"
        )
    rows = np.concatenate([seat_motion(assembled, place)[:2] for place in places])
    small = small_motions(forced, high)
    groups = {1: found}
    for turns in sorted(set(sought_turns)):
        own = replace(small, forced=forced.repeating_after(turns))
        more = in_time(own, speeds_rad_s, found, turns * max(harmonics, _FEWEST))
        more = [*starts, *more] if turns == 1 else more
        groups[turns], _, missed = _converged(own.forced, speeds_rad_s, more, tolerance)
        truncation = max(truncation, missed)
    told: list[NonlinearBranch] = []
    jumps: list[Jump] = []
    for turns, group in groups.items():
        own = replace(small, forced=forced.repeating_after(turns))
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
        stopped=tuple(stopped),
    )


def _converged(
    forced: ForcedSystem, ends: tuple[float, float], starts: Sequence[Guess], tolerance: float
) -> tuple[tuple[Branch, ...], int, float]:
    """Return branches through starts, their number of harmonics, and what more would change."""
    turns = forced.period_multiple
    harmonics = max((len(motion) // 2 for motion, _ in starts), default=turns)

    def point(guess: Guess, count: int) -> Point | None:
        return at_speed(forced, with_harmonics(guess[0], count), guess[1])

    while True:
        more = 2 * harmonics + turns
        points = [p for start in starts if (p := point(start, harmonics))]
        some = points[:: len(points) // _SOME + 1]
        moved = [gaps(p[0], o.motion_m)[0] for p in some if (o := point(p[:2], more))]
        truncation = max(moved, default=0.0)
        found: tuple[Branch, ...] = ()
        if truncation <= tolerance or more > _MOST:
            course = Course(
                equations=partial(balance, forced),
                low=ends[0],
                high=ends[1],
                unit=ends[1] - ends[0],
                longest=_LONGEST,
                bound_m=_GROWN * max((np.abs(p.motion_m).max() for p in points), default=1.0),
                turns=turns,
            )
            found = _through(course, points)
            truncation = max((_truncation(forced, b, more) for b in found), default=0.0)
        if truncation <= tolerance or more > _MOST:
            return found, harmonics, truncation
        amid = [b.points[len(b.points) * k // 4].point for b in found for k in (1, 2, 3)]
        starts, harmonics = [p[:2] for p in amid or points], more


def _through(course: Course, points: Sequence[Point]) -> tuple[Branch, ...]:
    """Return the branches through points, each once."""
    found: list[Branch] = []
    for point in points:
        if any(_is_on(course, branch, point) for branch in found):
            continue
        branch = through(course, point)
        found = [  # one with an open end may be a part of it
            b for b in found
            if not (b.open_ends and _is_on(course, branch, b.points[len(b.points) // 2].point))
        ]  # fmt: skip
        found.append(branch)
    return tuple(found)


def _is_on(course: Course, branch: Branch, point: Point) -> bool:
    """Whether a motion, or the same some turns later, is on a branch."""
    for _, motion in passing(branch.points, point.parameter):
        if gaps(motion, point.motion_m, course.turns).min() > 30.0 * _SAME:
            continue
        exact = at_parameter(course.equations, motion, point.parameter)
        if exact and gaps(exact.motion_m, point.motion_m, course.turns).min() <= _SAME:
            return True
    return False


def _truncation(forced: ForcedSystem, branch: Branch, harmonics: int) -> float:
    """Largest relative change of some motions and speeds of a branch with more harmonics."""
    every, worst = max(1, len(branch.points) // _CHECKED), 0.0
    for k, at in enumerate(branch.points):
        if k % every and not at.is_turning:
            continue
        motion, speed = with_harmonics(at.point.motion_m, harmonics), at.point.parameter
        along = with_harmonics(at.along[:-1].reshape(at.point.motion_m.shape), harmonics)
        size = float(np.abs(motion).max())
        row = along.ravel() / size**2, float(at.along[-1]) / speed**2
        found = corrected(partial(balance, forced), (motion, speed), row, size)
        if found is None:
            return np.inf
        moved = float(gaps(motion, found.motion_m)[0])
        worst = max(worst, moved, abs(found.parameter / speed - 1.0))
    return worst


def place_motion(forced: ForcedSystem, point: Point, rows: FloatArray) -> ComplexArray:
    """Return amplitudes of rows (m, n) of the coordinates in a motion, shape (h + 1, m)."""
    part = condensed(forced, point.parameter, len(point.motion_m) // 2, rows)
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
    largest = np.array([multipliers(small, p.motion_m, p.parameter)[0] for p in points])
    return NonlinearBranch(
        speeds_rad_s=np.array([p.parameter for p in points]),
        translation_m=np.array(motions).reshape(len(points), -1, len(rows) // 2, 2),
        largest_radius_m=np.array([_radius(m) for m in motions]),
        multiplier=largest,
        is_stable=np.abs(largest) <= 1.0 + GROWS,
        is_turning=np.array([p.is_turning for p in branch.points]),
        open_ends=branch.open_ends,
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
        changing = np.flatnonzero(branch.is_stable[1:] != branch.is_stable[:-1])
        for at in np.flatnonzero(branch.is_turning):
            if at == 0 or np.abs(changing - at).min(initial=_BESIDE) >= _BESIDE:
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
    speed = float(told[turning[0]].speeds_rad_s[turning[1]])
    near: list[tuple[int, FloatArray]] = []
    for number, branch in enumerate(told):
        for k, motion in passing(found[number].points, speed):
            apart = abs(k - turning[1]) if number == turning[0] else branch.speeds_rad_s.size
            if apart > _BESIDE and branch.is_stable[k] and branch.is_stable[k + 1]:
                near.append((apart, motion))
    return at_speed(forced, min(near, key=lambda n: n[0])[1], speed) if near else None


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
