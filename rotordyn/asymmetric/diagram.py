"""The Campbell diagram of an engine with asymmetric bodies, in the frame that turns with them.

A motion e^{λt} Σ e^{ihθ} q_h is seen in fixed axes at all frequencies |Im λ + kΩ| at once: its
lines, each with its part of the motion. That is what splits one branch into a strong line and its
sidebands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
from scipy.optimize import linear_sum_assignment

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics, PeriodicSystem
from solidwhirl.rotordyn.asymmetric.response import seen
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.stability.eigenvalue_paths import Spectral, prepared, solve, with_slopes

# Harmonics on either side of an expansion; lines that are kept are two fewer.
_ORDER = 3
# What a change of shape weighs beside one of the eigenvalue where branches are followed.
_SHAPE = 0.3
# A speed at which the turn says nothing: matrices are those of one angle.
_AT_REST = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RotatingDiagram(ReadOnlyArrays):
    """Hold the branches of an engine over the speed of the frame, and the lines they are seen at.

    `speeds_rad_s`: of the frame, (s,). `eigenvalues`: λ in the frame, (b, s), in 1/s; Im λ < 0: the
    motion turns backward there. `multiples`: k of the lines, (k,). `fixed_rad_s`: Im λ + kΩ with
    its sign, positive where the circle turns about +z in fixed axes, (b, k, s). `fixed_share`: part
    of each line in the motion of turning interfaces, (b, k, s). `rotating_share`: the same of Im λ
    + hΩ in the frame, by the kinetic energy, for the same multiples, (b, k, s).
    """

    speeds_rad_s: FloatArray
    eigenvalues: ComplexArray
    multiples: IntArray
    fixed_rad_s: FloatArray
    fixed_share: FloatArray
    rotating_share: FloatArray

    def strongest(self) -> tuple[FloatArray, FloatArray]:
        """Return the signed frequency of the strongest line of each branch, and its share, (b, s).

        rad/s; positive: forward.
        """
        best = np.nanargmax(np.where(np.isnan(self.fixed_share), -1.0, self.fixed_share), axis=1)
        pick = best[:, None, :]
        signed, share = (
            np.take_along_axis(a, pick, axis=1)[:, 0] for a in (self.fixed_rad_s, self.fixed_share)
        )
        return signed, share


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
    states = [_motions(rotating.periodic, float(speed)) for speed in speeds]
    order = np.argsort(np.abs(states[0].values))
    slow = [k for k in order if states[0].values[k].imag >= 0.0]
    columns = [np.array(slow[:branch_count], dtype=int)]
    for before, after in zip(states[:-1], states[1:], strict=True):
        columns.append(_followed(rotating.periodic, before, after, columns[-1]))
    multiples = np.arange(-_ORDER - 1, _ORDER + 2)
    ends = _turning_ends(rotating)
    lines = [
        [_lines(rotating, state, k, ends, multiples) for k in chosen]
        for state, chosen in zip(states, columns, strict=True)
    ]
    signed, fixed, turning = np.array(lines).transpose(2, 1, 3, 0)
    values = np.array([state.values[c] for state, c in zip(states, columns, strict=True)]).T
    return RotatingDiagram(
        speeds_rad_s=speeds,
        eigenvalues=values,
        multiples=multiples,
        fixed_rad_s=signed,
        fixed_share=fixed,
        rotating_share=turning,
    )


class _State(NamedTuple):
    """All motions at one speed: λ, dλ/dΩ, and parts by harmonic (h, n, m)."""

    speed: float
    values: ComplexArray
    slopes: ComplexArray
    harmonics: IntArray
    parts: ComplexArray


def _motions(periodic: PeriodicSystem, speed: float) -> _State:
    """Motions that count at a speed; near rest those of the engine at one angle."""
    own = periodic.at(0.0)[1][0]
    rate = float((np.diag(own).real / np.diag(periodic.mass)).max())
    turning = periodic if speed > _AT_REST * np.sqrt(rate) else _frozen(periodic)
    order = _ORDER if turning.stride else 0
    block = prepared(hill_block(turning, order), rate, 0.5 * speed, max(speed, 1.0))
    found: Spectral = with_slopes(block, solve(block, speed), "both")
    kept = np.flatnonzero(found.counted)
    harmonics = turning.stride * np.arange(-order, order + 1)
    parts = found.right[:, kept].reshape(len(harmonics), periodic.size, -1)
    return _State(speed, found.values[kept], found.slopes[kept], harmonics, parts)


def _frozen(periodic: PeriodicSystem) -> PeriodicSystem:
    """The system at the angle 0, at rest."""
    velocity, stiffness = periodic.at(0.0)
    summed = [sum(parts.values()).real for parts in (velocity, stiffness) if parts]  # type: ignore[attr-defined]
    from solidwhirl.rotordyn.asymmetric.periodic import Term

    if not velocity:
        summed.insert(0, np.zeros_like(periodic.mass))
    return PeriodicSystem(
        mass=periodic.mass,
        velocity=(Term(0, 0, summed[0]),),
        stiffness=(Term(0, 0, summed[1]),),
    )


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
    rows, columns = linear_sum_assignment(cost)
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


def _lines(
    rotating: RotatingSystem, state: _State, mode: int, ends: list[End], multiples: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Signed frequencies in fixed axes, shares there, and shares in the frame of one motion."""
    motion: Harmonics = {int(h): state.parts[k][:, mode] for k, h in enumerate(state.harmonics)}
    turn = state.speed * multiples
    rate = state.values[mode].imag + turn
    forward, backward = np.zeros(len(multiples)), np.zeros(len(multiples))
    inside = np.zeros(len(multiples))
    first = int(multiples[0])
    for end in ends:
        for h, u in seen(rotating.seat(end), motion).items():
            if first <= h <= -first:
                forward[h - first] += abs(u[0] + 1j * u[1]) ** 2
                backward[h - first] += abs(u[0] - 1j * u[1]) ** 2
    for h, q in motion.items():
        if first <= h <= -first:
            inside[h - first] = float((q.conj() @ rotating.periodic.mass @ q).real)
    total, energy = float(forward.sum() + backward.sum()), float(inside.sum())
    share = (forward + backward) / total if total else np.full(len(multiples), np.nan)
    sign = rotating.sense * np.where(forward >= backward, 1.0, -1.0)
    return rate * sign, share, inside / energy if energy else inside


def _turning_ends(rotating: RotatingSystem) -> list[End]:
    return [
        End(body=name, interface=node.name)
        for name, rotor in rotating.system.rotors.items()
        if rotor.speed_ratio != 0
        for node in rotor.element.interfaces
        if {"ux", "uy"} <= set(rotor.element.components_at(node.name))
    ]
