"""The Campbell diagram of an engine with asymmetric bodies, in the frame that turns with them.

A motion e^{λt} Σ e^{ihθ} q_h is seen in fixed axes at all frequencies |Im λ + kΩ| at once: its
lines, each with its part of the motion. That is what splits one branch into a strong line and its
sidebands.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.errors import dynamic_change
from solidwhirl.rotordyn.asymmetric.parametric.basis import search_basis
from solidwhirl.rotordyn.asymmetric.parametric.constant import ConstantMotions
from solidwhirl.rotordyn.asymmetric.parametric.exponents import PeriodicMotions
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics, PeriodicSystem
from solidwhirl.rotordyn.asymmetric.response import seen
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.kinds import family_energy, kinds, moves_laterally, shares_of

# Harmonics on either side that lines are made of.
_ORDER = 8
# Strides on either side whose lines are told.
_SHOWN = 2
# What a change of shape weighs beside one of the eigenvalue where branches are followed.
_SHAPE = 0.3
# A speed at which the turn says nothing: matrices are those of one angle.
_AT_REST = 1e-9
# Motions that are followed, over the fastest branch with a stride of the turn.
_ROOM = 2.0
# Answers of the others that are taken in.
_ANSWER = 3e-4
# Harmonics of a motion below this part of the largest add nothing to its error.
_SMALL = 1e-4
# Circles that differ by less are a line; decrements below this are rounding.
_LINE, _UNDAMPED = 1e-2, 1e-9
# Frequencies of a line change by no more than this part of the turn, and by a part of their own.
_STEEPEST, _JUMP = 2.2, 0.02
_SEEN = ("line_rad_s", "forward", "backward", "axial", "inside")


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RotatingDiagram(ReadOnlyArrays):
    """Hold the branches of an engine over the speed of the frame, and the lines they are seen at.

    `speeds_rad_s`: of the frame, (s,). `eigenvalues`: λ in the frame, 1/s, (b, s). `multiples`: k
    of the lines, (k,). `line_rad_s`: |Im λ + kΩ|, seen in fixed axes, (b, k, s). `forward`,
    `backward`, `axial`: part of each line in the motion of turning interfaces, circles about +z and
    −z, and motion along and about the axis, (b, k, s); their sum over all k is 1. `inside`: part of
    the frequency |Im λ + kΩ| in the frame, by the kinetic energy, (b, k, s). `shares`: of the
    kinetic energy by family, see `modes.kinds.energy_shares`, (b, s, 4). `errors`: estimates of
    |δλ| by part, from what bodies left out, 1/s, (b, s).
    """

    speeds_rad_s: FloatArray
    eigenvalues: ComplexArray
    multiples: IntArray
    line_rad_s: FloatArray
    forward: FloatArray
    backward: FloatArray
    axial: FloatArray
    inside: FloatArray
    shares: FloatArray
    errors: Mapping[str, FloatArray]

    @property
    def share(self) -> FloatArray:
        """Part of each line in fixed axes, (b, k, s)."""
        return np.asarray(self.forward + self.backward + self.axial)

    def strongest(self) -> IntArray:
        """Return which line of each branch is the strongest, (b, s)."""
        return np.asarray(self.share.argmax(axis=1))


def rotating_diagram(
    rotating: RotatingSystem, speeds_rad_s: npt.ArrayLike, branch_count: int
) -> RotatingDiagram:
    """Follow the slowest motions of an engine over the speed of its frame.

    `speeds_rad_s`: rising, not negative, (s,). `branch_count`: motions of lowest frequency at the
    first speed. Raises AnalysisError: speeds that are none.
    """
    speeds = np.asarray(speeds_rad_s, dtype=float)
    if speeds.ndim != 1 or not speeds.size or (speeds < 0).any() or (np.diff(speeds) <= 0).any():
        raise AnalysisError("speeds_rad_s must rise, and none be negative")
    periodic = rotating.periodic
    fastest = _fastest(periodic, float(speeds.max()), branch_count)
    basis = search_basis(periodic, fastest, float(speeds.max()), _ANSWER)
    turning = PeriodicMotions(periodic, basis, fastest) if periodic.stride else None
    states = [_motions(periodic, float(speed), turning) for speed in speeds]
    order = np.argsort(np.abs(states[0].values))
    still = _AT_REST * float(np.abs(states[0].values).max(initial=0.0))
    slow = [k for k in order if states[0].values[k].imag > still]
    columns = [np.array(slow[:branch_count], dtype=int)]
    for before, after in pairwise(states):
        columns.append(_followed(rotating.periodic, before, after, columns[-1]))
    reach = 1 + _SHOWN * periodic.stride
    multiples = np.arange(-reach, reach + 1)
    ends = rotating.turning_ends()
    lines = [
        [_lines(rotating, state, k, ends, multiples) for k in chosen]
        for state, chosen in zip(states, columns, strict=True)
    ]
    seen_at = np.array(lines).transpose(2, 1, 3, 0)
    values = np.array([state.values[c] for state, c in zip(states, columns, strict=True)]).T
    moved = [
        [_moved(rotating, state, k) for k in chosen]
        for state, chosen in zip(states, columns, strict=True)
    ]
    named = dict.fromkeys(part for column in moved for one in column for part in one)
    return RotatingDiagram(
        speeds_rad_s=speeds,
        eigenvalues=values,
        multiples=multiples,
        shares=np.stack(
            [_shares(rotating, s, c) for s, c in zip(states, columns, strict=True)], axis=1
        ),
        errors={p: np.array([[o.get(p, 0.0) for o in c] for c in moved]).T for p in named},
        **dict(zip(_SEEN, seen_at, strict=True)),
    )


class _State(NamedTuple):
    """Motions at one speed: λ, dλ/dΩ, and parts by harmonic, (h, n, m), those of left vectors too.

    `system`: whose motions they are.
    """

    speed: float
    values: ComplexArray
    slopes: ComplexArray
    harmonics: IntArray
    parts: ComplexArray
    left: ComplexArray
    system: PeriodicSystem


def _fastest(periodic: PeriodicSystem, top: float, branch_count: int) -> float:
    """Rate up to which motions are followed: that of the highest branch, with room for the turn."""
    squared = la.eigvalsh(periodic.stiffness_at_rest(), periodic.mass)
    last = np.sqrt(abs(squared[min(branch_count, len(squared) - 1)]))
    return float(_ROOM * (last + periodic.stride * top))


def _motions(periodic: PeriodicSystem, speed: float, turning: PeriodicMotions | None) -> _State:
    """Motions at a speed; at rest those of the engine at the angle 0."""
    if turning is not None and speed:
        found = turning.solve(speed)
        kept = np.flatnonzero(found.counted)
        roots = [turning.root(found, int(k), _ORDER) for k in kept]
        parts, left = (
            np.array([side @ turning.basis.T for side in sides]).transpose(1, 2, 0)
            for sides in ([r.right for r in roots], [r.left for r in roots])
        )
        harmonics = periodic.stride * np.arange(-_ORDER, _ORDER + 1)
        return _State(
            speed, found.values[kept], found.slopes[kept], harmonics, parts, left, periodic
        )
    still = periodic if speed or not periodic.stride else periodic.at_angle_zero()
    constant = ConstantMotions(still, 0.5 * speed, max(speed, 1.0))
    every = constant.with_slopes(constant.solve(speed), "both")
    parts, left, constant_part = every.right[None], every.left.T[None], np.zeros(1, dtype=int)
    return _State(speed, every.values, every.slopes, constant_part, parts, left, still)


def _moved(rotating: RotatingSystem, state: _State, mode: int) -> dict[str, float]:
    """|δλ| of one motion by part: yᴴ E x over yᴴ D'(λ) x of Hill's expansion.

    0 of one that stands still, as a rigid motion does that nothing holds.
    """
    sizes = np.abs(state.parts[:, :, mode]).max(axis=1)
    kept = np.flatnonzero(sizes > _SMALL * sizes.max(initial=0.0))
    right: Harmonics = {int(state.harmonics[k]): state.parts[k][:, mode] for k in kept}
    left: Harmonics = {int(state.harmonics[k]): state.left[k][:, mode].conj() for k in kept}
    value, speed = complex(state.values[mode]), state.speed
    change = dynamic_change(rotating, value, speed, left, right)
    if abs(value) <= _AT_REST * float(np.abs(state.values).max()):
        return dict.fromkeys(change, 0.0)
    velocity, _ = state.system.at(speed)
    slope = 0.0 + 0.0j
    for h, y in left.items():
        pushed = 2.0 * (value + 1j * h * speed) * (state.system.mass @ right[h])
        for d, v in velocity.items():
            pushed = pushed + v @ right[h - d] if h - d in right else pushed
        slope += complex(y.conj() @ pushed)
    return {part: abs(moved / slope) for part, moved in change.items()}


def _followed(
    periodic: PeriodicSystem, before: _State, after: _State, chosen: IntArray
) -> IntArray:
    """Motions at the next speed that go on with those chosen, each with another."""
    step = after.speed - before.speed
    expected = before.values[chosen] + step * before.slopes[chosen]
    arrived = after.values - step * after.slopes
    near = np.minimum(
        np.abs(expected[:, None] - after.values), np.abs(before.values[chosen][:, None] - arrived)
    )
    scale = np.abs(before.values[chosen])[:, None] + step
    overlap = _overlap(periodic, before, after, chosen)
    cost = near / scale + _SHAPE * (1.0 - overlap)
    rows, columns = scipy.optimize.linear_sum_assignment(cost)
    return np.asarray(columns[np.argsort(rows)])


def _overlap(
    periodic: PeriodicSystem, before: _State, after: _State, chosen: IntArray
) -> FloatArray:
    """MAC of the mean of harmonics near the zeroth in the metric of the mass, (c, m)."""
    first, second = _main(before)[:, chosen], _main(after)
    weighted = periodic.mass @ second
    product = np.abs(first.conj().T @ weighted) ** 2
    sizes = [
        np.einsum("im,ij,jm->m", a.conj(), periodic.mass, a).real for a in (first, second)
    ]  # fmt: skip
    return np.asarray(product / np.maximum(np.outer(*sizes), np.finfo(float).tiny))


def _main(state: _State) -> ComplexArray:
    """The part of the zeroth harmonic of every motion, (n, m)."""
    return np.asarray(state.parts[len(state.harmonics) // 2])


def _shares(rotating: RotatingSystem, state: _State, chosen: IntArray) -> FloatArray:
    """Shares of families in the kinetic energy of all harmonics together, (c, 4)."""
    return shares_of(
        np.sum([family_energy(rotating, part[:, chosen]) for part in state.parts], axis=0)
    )


def _lines(
    rotating: RotatingSystem, state: _State, mode: int, ends: list[End], multiples: IntArray
) -> FloatArray:
    """What `_SEEN` names of one motion, (5, k)."""
    motion: Harmonics = {int(h): state.parts[k][:, mode] for k, h in enumerate(state.harmonics)}
    reach = max(int(multiples[-1]), int(state.harmonics[-1]) + 1)
    every = np.arange(-reach, reach + 1)
    rate = state.values[mode].imag + state.speed * every
    circles, inside = np.zeros((3, len(every))), np.zeros(len(every))
    first = -reach
    for end in ends:
        arm = _gyration(rotating, end)
        for h, u in seen(rotating.seat(end), motion).items():
            sides = (u[0] + 1j * u[1], u[0] - 1j * u[1])
            circles[:2, h - first] += [0.5 * abs(side) ** 2 for side in sides]
            circles[2, h - first] += abs(u[2]) ** 2 + abs(arm * u[5]) ** 2
    for h, q in motion.items():
        inside[h - first] = float((q.conj() @ rotating.periodic.mass @ q).real)
    if not state.speed:
        # all lines are one
        circles[:, -first] = circles.sum(axis=1)
        circles[:, np.arange(len(every)) != -first] = 0.0
    # x + iy of a circle e^{irt} turns about +z where r > 0
    ahead = rate * rotating.sense >= 0.0
    turned = [np.where(ahead, circles[k], circles[1 - k]) for k in (0, 1)]
    total, energy = float(circles.sum()) or 1.0, float(inside.sum()) or 1.0
    shares = [part / total for part in (*turned, circles[2])]
    found = np.array([np.abs(rate), *shares, inside / energy])
    return found[:, np.isin(every, multiples)]


def _gyration(rotating: RotatingSystem, end: End) -> float:
    """Radius of gyration of a body about the axis, m: what a turn moves it by."""
    element = rotating.system.rotors[end.body].element
    return float(np.sqrt(element.inertia_kg_m2[2, 2] / element.mass_kg))


def as_campbell(
    found: RotatingDiagram, frame_ratio: float
) -> tuple[Campbell, dict[str, FloatArray]]:
    """Return the strongest line of each branch as a diagram in fixed axes.

    Over the speed of the reference shaft. Decrements are those of that line. Where another line
    becomes the strongest a branch ends, and one begins. The second are the errors of the diagram's
    eigenvalues by part, 1/s.
    """
    pick = found.strongest()[:, None, :]
    hertz, forward, backward = (
        np.take_along_axis(a, pick, axis=1)[:, 0]
        for a in (found.line_rad_s / (2.0 * np.pi), found.forward, found.backward)
    )
    straight = np.abs(forward - backward) <= _LINE * np.maximum(forward + backward, _LINE)
    whirl = np.where(forward > backward, "forward", "backward")
    whirl = np.where(straight, "straight", whirl)
    whirl = np.where(moves_laterally(found.shares), whirl, kinds(found.shares))
    growth = found.eigenvalues.real
    step = np.diff(found.speeds_rad_s) / (2.0 * np.pi)
    jumps = np.abs(np.diff(hertz)) > _STEEPEST * step + _JUMP * hertz[:, :-1]
    pieces = np.concatenate(
        [np.zeros((len(hertz), 1), dtype=int), np.cumsum(jumps, axis=1)], axis=1
    )
    decrement = np.divide(-growth, hertz, out=np.zeros_like(growth), where=hertz > 0)
    rows = [(b, p) for b, own in enumerate(pieces) for p in range(own[-1] + 1)]
    own = np.array([b for b, _ in rows], dtype=int)
    alive = np.array([pieces[b] == p for b, p in rows]).reshape(len(rows), -1)
    decrement = np.where(np.abs(decrement) <= _UNDAMPED, 0.0, decrement)
    diagram = Campbell(
        speeds_rad_s=found.speeds_rad_s / abs(frame_ratio),
        eigenvalues=np.where(alive, (growth + 2j * np.pi * hertz)[own], np.nan),
        frequency_hz=np.where(alive, hertz[own], np.nan),
        log_decrement=np.where(alive, decrement[own], np.nan),
        whirl=np.where(alive, whirl[own], ""),
        shares=np.where(alive[..., None], found.shares[own], np.nan),
        overlap=np.ones(alive.shape),
        notes=(),
    )
    return diagram, {part: np.where(alive, e[own], np.nan) for part, e in found.errors.items()}
