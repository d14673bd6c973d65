"""Keeping of what a run-up is asked for: motion, bearing forces, and the balance of energy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.coordinates import Placed, interface_row, seat_motion
from solidwhirl.rotordyn.assembly.parts import Bearing, End
from solidwhirl.rotordyn.assembly.reactions import joint_forces
from solidwhirl.rotordyn.checks.plain_checks import Miss
from solidwhirl.rotordyn.checks.plain_responses import force_balance
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.run_up.record import EnergyBalance
from solidwhirl.rotordyn.run_up.steps import Block, RunPlan

# Samples that wait before their forces are computed together.
_WAITING = 4096
# Records whose balance of forces is looked at.
_BALANCES = 64


class _Samples(NamedTuple):
    """Recorded instants, p of them: x, η'', stacked loads, frozen Ω, and Ω'."""

    states: FloatArray
    accelerations: FloatArray
    loads: FloatArray
    speeds: FloatArray
    rates: FloatArray


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


class EnergySums:
    """Sum up the works of the blocks of a run."""

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._kept: list[FloatArray] = []
        self._works = np.zeros(3)
        self._stored: float | None = None

    def add(
        self, stored_j: FloatArray, powers_w: FloatArray, work_j: npt.ArrayLike, kept: IntArray
    ) -> None:
        """Add a block.

        `stored_j`: shape (K + 1,); `powers_w`: of loads, drives and losses, shape (K + 1, 3);
        `work_j`: further work of loads since its start, shape (K + 1,); `kept`: places of records.
        """
        if self._stored is not None:
            # another frozen speed, another stiffness
            self._works[1] += stored_j[0] - self._stored
        works = self._works + self._step_s * _integrals(powers_w)
        works[:, 0] += work_j
        self._stored, self._works = float(stored_j[-1]), works[-1].copy()
        self._kept.append(np.column_stack((stored_j, works))[kept])

    def balance(self) -> EnergyBalance:
        """Return the energy at all records."""
        stored, load, drive, dissipated = np.vstack(self._kept).T
        return EnergyBalance(
            stored_j=stored, load_work_j=load, drive_work_j=drive, dissipated_j=dissipated
        )


class Recorder:
    """Collect the blocks of a run.

    `every`: steps from one record to the next; `outputs`: interfaces whose motion is kept;
    `bearings`: names of the bearings whose force is kept. Raises AssemblyError if an interface does
    not exist. Raises AnalysisError if a bearing does not exist.
    """

    def __init__(
        self, plan: RunPlan, every: int, outputs: Sequence[End], bearings: Sequence[str]
    ) -> None:
        assembled = plan.basis.assembled
        checked_places(assembled, outputs, bearings)
        self._plan = plan
        self._every = every
        self._bearings = tuple(bearings)
        rows = [seat_motion(assembled, end) for end in outputs]
        self._rows = np.array(rows).reshape(6 * len(rows), assembled.size)
        self._modal_columns = plan.modal(plan.turning.columns)
        self._waiting: list[_Samples] = []
        self._waiting_count = 0
        self._motion: list[FloatArray] = []
        self._rate: list[FloatArray] = []
        self._forces: list[FloatArray] = []
        self._energy = EnergySums(plan.step_s)
        self._plain = PlainSystem.of(assembled)
        self._balances: list[Miss] = []

    def add(self, block: Block) -> None:
        """Keep what a block has of records."""
        n = self._plan.basis.size
        # without loads: η'' = spring + damper
        spring = block.states[:, :n] @ block.rates[:, :n].T
        damper = block.states[:, n:] @ block.rates[:, n:].T
        begins = 0 if block.first_step == 0 else 1
        steps = block.first_step + np.arange(begins, block.states.shape[0])
        kept = begins + np.flatnonzero(steps % self._every == 0)
        self._balance(block, spring, damper, kept)
        if not kept.size or not (self._rows.size or self._bearings):
            return
        amplitudes = block.amplitudes[kept]
        modal = amplitudes @ self._modal_columns.T + block.modal_constant
        sample = _Samples(
            states=block.states[kept],
            accelerations=spring[kept] + damper[kept] + modal,
            loads=amplitudes @ self._plan.turning.columns.T + block.constant,
            speeds=np.full(kept.size, block.frozen_speed_rad_s),
            rates=np.full(kept.size, block.acceleration_rad_s2),
        )
        self._waiting.append(sample)
        self._waiting_count += kept.size
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
        basis = self._plan.basis
        n, count = basis.size, len(whole.speeds)
        for at in sorted({count // 3, count - 1}) if len(self._balances) < _BALANCES else ():
            motion = (
                basis.displacement @ whole.states[at, :n],
                basis.shapes @ whole.states[at, n:],
                basis.shapes @ whole.accelerations[at],
            )
            speed, rate = float(whole.speeds[at]), float(whole.rates[at])
            miss = force_balance(self._plain, speed, rate, motion, whole.loads[at])
            self._balances.append(miss)

    def energy(self) -> EnergyBalance:
        """Return the balance of energy at all records."""
        return self._energy.balance()

    def _balance(
        self, block: Block, spring: FloatArray, damper: FloatArray, kept: IntArray
    ) -> None:
        """Keep stored energy and works of a block."""
        n, scale = self._plan.basis.size, self._plan.basis.scale
        place, speed = block.states[:, :n] / scale, block.states[:, n:]
        stored = 0.5 * (np.einsum("kn,kn->k", speed, speed) - np.einsum("kn,kn->k", place, spring))
        # spring is −K η; the part of K that is not symmetric works, with −Kᵀη beside it
        mirrored = scale * (place @ block.rates[:, :n])
        powers = np.stack(
            (
                np.einsum("kc,kc->k", block.amplitudes, speed @ self._modal_columns),
                0.5 * np.einsum("kn,kn->k", speed, spring - mirrored),
                -np.einsum("kn,kn->k", speed, damper),
            ),
            axis=1,
        )
        # exact, also for motion that a step does not resolve
        self._energy.add(stored, powers, (place - place[0]) @ block.modal_constant, kept)

    def _flush(self) -> None:
        """Work out motion and forces of the samples that wait."""
        if not self._waiting:
            return
        whole = _Samples(*(np.concatenate(part) for part in zip(*self._waiting, strict=True)))
        self._waiting, self._waiting_count = [], 0
        self._balanced(whole)
        basis = self._plan.basis
        n = basis.size
        if self._rows.size:
            self._motion.append(whole.states[:, :n] @ (self._rows @ basis.displacement).T)
            self._rate.append(whole.states[:, n:] @ (self._rows @ basis.shapes).T)
        if self._bearings:
            forces = joint_forces(
                basis.assembled,
                whole.speeds,
                whole.states[:, :n] @ basis.displacement.T,
                whole.states[:, n:] @ basis.shapes.T,
                whole.accelerations @ basis.shapes.T,
                {name: whole.loads[:, at] for name, at in basis.assembled.body_slices.items()},
                whole.rates,
            ).bearings
            self._forces.append(np.hstack([forces[name] for name in self._bearings]))


def _integrals(values: FloatArray) -> FloatArray:
    """Integrals from the first row to every row, in steps, by the corrected trapezoidal rule.

    The rule of Euler and Maclaurin with slopes by differences; an error of fourth order.
    """
    sums = np.vstack((np.zeros(values.shape[1]), np.cumsum(values[1:] + values[:-1], axis=0)))
    if values.shape[0] < 3:
        return np.asarray(0.5 * sums)
    slopes = np.gradient(values, axis=0, edge_order=2)
    return np.asarray(0.5 * sums - (slopes - slopes[0]) / 12.0)


def _joined(parts: list[FloatArray], count: int) -> FloatArray:
    """Return (count, 6, s) from pieces (p, 6 count)."""
    whole = np.concatenate(parts) if parts else np.zeros((0, 6 * count))
    return np.ascontiguousarray(whole.T).reshape(count, 6, whole.shape[0])
