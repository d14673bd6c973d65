"""Keeping of what a run-up is asked for: motion, bearing forces, and the balance of energy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.coordinates import Placed, interface_row, seat_motion
from solidwhirl.rotordyn.assembly.parts import Bearing, End
from solidwhirl.rotordyn.assembly.reactions import joint_forces
from solidwhirl.rotordyn.checks.plain_checks import Miss
from solidwhirl.rotordyn.checks.plain_responses import force_balance
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.modal_truncation import project_system
from solidwhirl.rotordyn.run_up.blocks import PartMotion, RunPart, RunPlan, Stretch
from solidwhirl.rotordyn.run_up.record import EnergyBalance

# Samples that wait before their forces are computed together.
_WAITING = 4096
# A power that the steps resolve changes in one of them by less than this times its largest.
_RESOLVED = 10.0
# Records whose balance of forces is looked at.
_BALANCES = 64


class _Samples(NamedTuple):
    """Recorded instants, p of them: η, η', η'', stacked loads, frozen Ω, and Ω'."""

    places: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    loads: FloatArray
    speeds: FloatArray
    rates: FloatArray


class _Forces(NamedTuple):
    """η'' of a part by its springs, by its dampers, and in all, (B, L + 1, n) each."""

    spring: FloatArray
    damper: FloatArray
    acceleration: FloatArray


class RecordedMotion(NamedTuple):
    """Motion of the outputs and their rates, and forces of the bearings, (…, 6, s)."""

    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray

    @classmethod
    def joined(
        cls,
        motion: list[FloatArray],
        rate: list[FloatArray],
        forces: list[FloatArray],
        outputs: int,
        bearings: int,
    ) -> RecordedMotion:
        """Join pieces of records, (p, 6 outputs) of motion and (p, 6 bearings) of forces."""
        return cls(_joined(motion, outputs), _joined(rate, outputs), _joined(forces, bearings))


def checked_places(
    assembled: Placed, outputs: Sequence[End], bearings: Sequence[str]
) -> list[Bearing]:
    """Return the bearings of some names, or refuse what does not exist.

    Raises AssemblyError if an interface does not exist. Raises AnalysisError if a bearing does not.
    """
    known = {bearing.name: bearing for bearing in assembled.system.bearings}
    missing = [name for name in bearings if name not in known]
    if missing:
        raise AnalysisError(f"there are no bearings {missing}; there are {list(known)}")
    for end in outputs:  # the error of a missing place names what exists
        rotor = assembled.system.rotors.get(end.body)
        has = () if rotor is None else rotor.element.components_at(end.interface)
        interface_row(assembled, end.body, end.interface, has[0] if has else "ux")
    return [known[name] for name in bearings]


class Works(NamedTuple):
    """What changes the energy in B blocks of L steps.

    `powers_w`: of loads, drives and losses, shape (B, L + 1, 3); `slopes_w`: their changes per
    step; `loads_j`: further work of loads since the start of each block, shape (B, L + 1).
    """

    powers_w: FloatArray
    slopes_w: FloatArray
    loads_j: FloatArray


class EnergySums:
    """Sum up the works of the blocks of a run.

    `step_s`: time from one state to the next.
    """

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._kept: list[FloatArray] = []
        self._works = np.zeros(3)
        self._stored: float | None = None

    def add(self, stored_j: FloatArray, works: Works, kept: BoolArray) -> None:
        """Add B blocks of L steps in a row.

        `stored_j`: shape (B, L + 1); `kept`: which of these states are records, (B, L + 1).
        """
        works_j = self._works + self._step_s * _integrals(works.powers_w, works.slopes_w)
        works_j[..., 0] += works.loads_j + _before(works.loads_j[:, -1])
        last = stored_j[0, 0] if self._stored is None else self._stored
        # another frozen speed, another stiffness
        changes = stored_j[:, 0] - np.append(last, stored_j[:-1, -1])
        works_j[..., 1] += np.cumsum(changes)[:, None]
        self._stored, self._works = float(stored_j[-1, -1]), works_j[-1, -1].copy()
        self._kept.append(np.concatenate((stored_j[..., None], works_j), axis=-1)[kept])

    def balance(self) -> EnergyBalance:
        """Return the energy at all records."""
        stored, load, drive, dissipated = np.vstack(self._kept).T
        return EnergyBalance(
            stored_j=stored, load_work_j=load, drive_work_j=drive, dissipated_j=dissipated
        )


class Recorder:
    """Collect the stretches of a run.

    `every`: steps from one record to the next; `outputs`: interfaces whose motion is kept;
    `bearings`: names of the bearings whose force is kept. Raises AssemblyError if an interface does
    not exist. Raises AnalysisError if a bearing does not exist.
    """

    def __init__(
        self, plan: RunPlan, every: int, outputs: Sequence[End], bearings: Sequence[str]
    ) -> None:
        checked_places(plan.assembled, outputs, bearings)
        self._plan = plan
        self._every = every
        self._bearings = tuple(bearings)
        self._shapes, self._scale = plan.shapes, plan.scale
        self._modal = project_system(plan.assembled, self._shapes)
        rows = [seat_motion(self._modal, end) for end in outputs]
        self._rows = np.array(rows).reshape(6 * len(rows), self._scale.size)
        self._waiting: list[_Samples] = []
        self._waiting_count = 0
        self._motion: list[FloatArray] = []
        self._rate: list[FloatArray] = []
        self._forces: list[FloatArray] = []
        self._energy = EnergySums(plan.stride.duration_s)
        self._plain = PlainSystem.of(plan.assembled)
        self._balances: list[Miss] = []

    def add(self, stretch: Stretch) -> None:
        """Keep what a stretch has of records."""
        kept = stretch.steps % self._every == 0
        # the first state of a block is the last of the one before
        kept[0 if stretch.first_step else 1 :, 0] = False
        found = [
            _forces(part, motion, stretch.amplitudes[..., part.columns])
            for part, motion in zip(self._plan.parts, stretch.motions, strict=True)
        ]
        self._balance(stretch, found, kept)
        count = int(np.count_nonzero(kept))
        if not count or not (self._rows.size or self._bearings):
            return
        sample = _Samples(
            places=np.hstack([m.place[kept] for m in stretch.motions]) / self._scale,
            velocities=np.hstack([m.velocity[kept] for m in stretch.motions]),
            accelerations=np.hstack([forces.acceleration[kept] for forces in found]),
            loads=stretch.amplitudes[kept] @ self._plan.turning.columns.T + stretch.constant,
            speeds=np.repeat(stretch.frozen_speeds_rad_s, np.count_nonzero(kept, axis=1)),
            rates=np.full(count, stretch.acceleration_rad_s2),
        )
        self._waiting.append(sample)
        self._waiting_count += count
        if self._waiting_count >= _WAITING:
            self._flush()

    def motion(self) -> RecordedMotion:
        """Return all records."""
        self._flush()
        outputs, bearings = self._rows.shape[0] // 6, len(self._bearings)
        return RecordedMotion.joined(self._motion, self._rate, self._forces, outputs, bearings)

    def worst_balance(self) -> float:
        """Return the largest force left over at some records, over the largest force there."""
        self._flush()
        return max((one.error for one in self._balances), default=0.0)

    def _balanced(self, whole: _Samples) -> None:
        """Look at the forces of some records in the system straight from its parts."""
        count = len(whole.speeds)
        chosen = {count // 3} if self._balances else {count // 3, count - 1}
        for at in sorted(chosen) if len(self._balances) < _BALANCES else ():
            modal = (whole.places[at], whole.velocities[at], whole.accelerations[at])
            place, velocity, acceleration = (self._shapes @ part for part in modal)
            speed, rate = float(whole.speeds[at]), float(whole.rates[at])
            motion = (place, velocity, acceleration)
            miss = force_balance(self._plain, speed, rate, motion, whole.loads[at])
            self._balances.append(miss)

    def energy(self) -> EnergyBalance:
        """Return the balance of energy at all records."""
        return self._energy.balance()

    def _balance(self, stretch: Stretch, found: Sequence[_Forces], kept: BoolArray) -> None:
        """Keep stored energy and works of a stretch."""
        stored, works = np.zeros(kept.shape), []
        for part, motion, forces in zip(self._plan.parts, stretch.motions, found, strict=True):
            place, speed = motion.place / part.basis.scale, motion.velocity
            stored += 0.5 * (_dot(speed, speed) - _dot(place, forces.spring))
            given = stretch.amplitudes[..., part.columns]
            changes = stretch.amplitude_rates[..., part.columns]
            works.append(_works(part, motion, forces, given, changes))
        whole = Works(*(sum(of_parts) for of_parts in zip(*works, strict=True)))
        slopes = self._plan.stride.duration_s * whole.slopes_w
        self._energy.add(stored, whole._replace(slopes_w=slopes), kept)

    def _flush(self) -> None:
        """Work out motion and forces of the samples that wait."""
        if not self._waiting:
            return
        whole = _Samples(*(np.concatenate(part) for part in zip(*self._waiting, strict=True)))
        self._waiting, self._waiting_count = [], 0
        self._balanced(whole)
        if self._rows.size:
            self._motion.append(whole.places @ self._rows.T)
            self._rate.append(whole.velocities @ self._rows.T)
        if self._bearings:
            slices = self._modal.body_slices
            forces = joint_forces(
                self._modal,
                whole.speeds,
                whole.places,
                whole.velocities,
                whole.accelerations,
                {name: whole.loads[:, at] for name, at in slices.items()},
                whole.rates,
            ).bearings
            self._forces.append(np.hstack([forces[name] for name in self._bearings]))


def _forces(part: RunPart, motion: PartMotion, amplitudes: FloatArray) -> _Forces:
    """Return what acts on the modes of a part; `amplitudes`: of its loads, (B, L + 1, c)."""
    n, transposed = part.basis.size, motion.rates.swapaxes(1, 2)
    spring, damper = motion.place @ transposed[:, :n], motion.velocity @ transposed[:, n:]
    load = amplitudes @ part.loads.T + motion.constant
    return _Forces(spring, damper, spring + damper + load)


def _works(
    part: RunPart, motion: PartMotion, forces: _Forces, given: FloatArray, changes: FloatArray
) -> Works:
    """Return what changes the energy of a part; `slopes_w` per second.

    `given`, `changes`: factors of its loads and their rates, shape (B, L + 1, c).
    """
    n, scale = part.basis.size, part.basis.scale
    place, speed, acceleration = motion.place / scale, motion.velocity, forces.acceleration
    moved, rising = speed @ part.loads, acceleration @ part.loads
    # the part of K that is not symmetric works, with −Kᵀη beside −Kη; it is skew
    odd = 0.5 * (forces.spring - scale * (place @ motion.rates[..., :n]))
    # the part of the velocity matrix that is symmetric; −V η' is the force
    mirrored = speed @ motion.rates[..., n:]
    even = forces.damper + mirrored
    powers = (_dot(given, moved), _dot(speed, odd), -_dot(speed, forces.damper))
    slopes = (
        _dot(changes, moved) + _dot(given, rising),
        _dot(acceleration, odd),
        -_dot(acceleration, even),
    )
    # exact, also for motion that a step does not resolve
    constant = (place - place[:, :1]) @ motion.constant
    return Works(np.stack(powers, axis=-1), np.stack(slopes, axis=-1), constant)


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the products of rows, (B, L + 1) from (B, L + 1, n)."""
    return np.asarray(np.einsum("bkn,bkn->bk", first, second))


def difference_slopes(values: FloatArray) -> FloatArray:
    """Return the changes of rows (s, k) per step by differences, where nothing else is known."""
    if len(values) < 3:
        return np.zeros_like(values)
    return np.asarray(np.gradient(values, axis=0, edge_order=2))


def _before(amounts: FloatArray) -> FloatArray:
    """Return the sum of all amounts before each, as a column."""
    return np.asarray(np.cumsum(amounts) - amounts)[:, None]


def _integrals(values: FloatArray, slopes: FloatArray) -> FloatArray:
    """Integrals from the first of B blocks in a row to every row, in steps, (B, L + 1, k).

    The trapezoidal rule with the correction of Euler and Maclaurin by the slopes at both ends: an
    error of fourth order, of which one block leaves what the next takes. `values`, `slopes`: at
    every row and their changes per step, shape (B, L + 1, k).
    """
    sums = np.zeros_like(values)
    np.cumsum(0.5 * (values[:, 1:] + values[:, :-1]), axis=1, out=sums[:, 1:])
    # what changes faster is not resolved: its slope would only add its rounding, many times over
    limits = _RESOLVED * np.abs(values).max(axis=1, keepdims=True)
    slopes = np.clip(slopes, -limits, limits)
    sums -= (slopes - slopes[:, :1]) / 12.0
    sums[1:] += np.cumsum(sums[:-1, -1], axis=0)[:, None]
    return sums


def _joined(parts: list[FloatArray], count: int) -> FloatArray:
    """Return (count, 6, s) from pieces (p, 6 count)."""
    whole = np.concatenate(parts) if parts else np.zeros((0, 6 * count))
    return np.ascontiguousarray(whole.T).reshape(count, 6, whole.shape[0])
