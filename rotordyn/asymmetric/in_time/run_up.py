"""Run-up of engines with asymmetric bodies, in the frame that turns with them.

The frame turns by θ = |m| ∫Ω dt at p = |m| Ω, m the speed ratio of these bodies.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.in_time.frame_loads import FrameLoads, frame_loads
from solidwhirl.rotordyn.asymmetric.in_time.gauss_steps import (
    Instants,
    SteppedSystem,
    gauss_steps,
    instants_after,
)
from solidwhirl.rotordyn.asymmetric.parametric.floquet import floquet_multipliers
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics
from solidwhirl.rotordyn.asymmetric.response import held_where_free, steady_motion
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response.static import static_equilibrium
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.blocks import profile_pieces
from solidwhirl.rotordyn.run_up.integration import (
    RunSettings,
    Watch,
    run_record,
    shortened,
    speed_limit_notes,
)
from solidwhirl.rotordyn.run_up.record import MotionState, RunUp
from solidwhirl.rotordyn.run_up.recorder import (
    EnergySums,
    RecordedMotion,
    Works,
    checked_places,
    difference_slopes,
)
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile

# Steps of a block; bounds memory only.
_LONGEST = 1024
# Growth in a period, and rate over the fastest one, of more than a free body that drifts, whose two
# equal zeros are off by the root of the rounding.
_GROWS, _DRIFT = 1e-4, 1e-6


class _Plan(NamedTuple):
    """The system and its loads in coordinates of unit mass, and the profile of the frame."""

    rotating: RotatingSystem
    system: SteppedSystem
    loads: FrameLoads
    profile: SpeedProfile
    step_s: float


class _Block(NamedTuple):
    """K steps: number of the first, all instants, and (w, w') at them, shape (K + 1, 2n)."""

    first_step: int
    instants: Instants
    states: FloatArray

    def until(self, steps: int) -> _Block:
        angles, speeds, rise = self.instants
        some = slice(steps + 1)
        cut = Instants(angles[some], speeds[some], rise)
        return _Block(self.first_step, cut, self.states[some])


def run_up_rotating(
    rotating: RotatingSystem,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    *,
    own_unbalance: bool = True,
    **settings: Any,
) -> RunUp:
    """Integrate the motion of an engine with asymmetric bodies while its speed follows a profile.

    M q'' + V(p, θ) q' + [K(p, θ) + p' E] q = f, by Gauss' method of two stages: the error falls
    with the fourth power of the step, at any number of steps to a turn.

    `profile`: Ω(t) of the reference shaft; its breakpoints must be whole steps. `unbalances`: at
    fixed angles on their bodies; may be empty. `own_unbalance`: whether the asymmetric bodies are
    loaded by their own centrifugal forces, of masses off the axis and of a bow. `settings`: fields
    of `RunSettings`, of which `step_s` must be given; `phase_error_rad` has no meaning here.
    Without `initial` the run begins in the steady motion under the weight, at rest at Ω = 0;
    `initial` and `final` are in the coordinates of the frame. Motions and forces of the record are
    in fixed axes, energies in the frame. A run that diverges stops as in `run_up`. The balance of
    forces and the ranges of speed laws are not looked at.

    Raises AnalysisError if an argument has no meaning, the step is too long for the speed, or a
    bearing that is recorded is rigid; AssemblyError if a place does not exist or lacks a component.
    """
    begun = time.perf_counter()
    how = RunSettings(**settings)
    plan = _plan(rotating, profile, unbalances, how, own_unbalance)
    shapes, n = plan.system.shapes, plan.system.size
    recorder = _Recorder(plan, how)
    watch = Watch(rotating, shapes, plan.step_s, partial(_grows, rotating))
    state, stopped = _start(plan, how), None
    for block in _blocks(plan, state):
        speeds = block.instants.speeds_rad_s / abs(rotating.frame_ratio)
        stopped = watch.divergence(block.first_step, speeds, block.states[:, :n])
        if stopped is not None:
            block = block.until(watch.steps_until(stopped, block.first_step))
        recorder.add(block)
        state = block.states[-1]
        if stopped is not None:
            profile = shortened(profile, stopped.time_s)
            break
    return run_record(
        rotating.system,
        profile,
        unbalances,
        how,
        recorder.motion(),
        longest_block=1,
        energy=recorder.energy.balance(),
        final=MotionState(displacement=shapes @ state[:n], velocity=shapes @ state[n:]),
        notes=speed_limit_notes(plan.profile, rotating.speed_limit_rad_s),
        stopped=stopped,
        wall_time_s=time.perf_counter() - begun,
    )


def _plan(
    rotating: RotatingSystem,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    how: RunSettings,
    own_unbalance: bool,
) -> _Plan:
    system = SteppedSystem(rotating.periodic)
    loads = frame_loads(rotating, unbalances, how.gravity_m_per_s2, how.drives, own_unbalance)
    frame = SpeedProfile(
        times_s=profile.times_s, speeds_rad_s=abs(rotating.frame_ratio) * profile.speeds_rad_s
    )
    return _Plan(rotating, system, loads.on(system.shapes), frame, float(how.step_s))


def _start(plan: _Plan, how: RunSettings) -> FloatArray:
    """Return (w, w') of the given state, else of rest under the weight."""
    system = plan.system
    if how.initial is not None:
        given = how.initial.of_size(system.size)
        return np.concatenate([system.root @ part for part in (given.displacement, given.velocity)])
    speed, weight = float(plan.profile.speeds_rad_s[0]), plan.loads.weight
    if not weight:
        return np.zeros(2 * system.size)
    if speed:
        loads = {h: system.root.T @ part[:, 0] for h, part in weight.items()}
        held = held_where_free(plan.rotating, abs(speed))
        found = steady_motion(held, speed, loads)
        place = np.sum(list(found.values()), axis=0).real
        rate = np.sum([1j * h * speed * part for h, part in found.items()], axis=0).real
        return np.concatenate((system.root @ place, system.root @ rate))
    load = np.sum([part[:, 0].real for part in weight.values()], axis=0)
    begin = Instants(np.zeros(1), np.zeros(1), 0.0)
    stiffness = system.stiffness.transposed(system.weights(begin)[1])
    place = static_equilibrium(stiffness[0].T, speed, load)
    return np.concatenate((place, np.zeros(system.size)))


def _grows(rotating: RotatingSystem, speed_rad_s: float) -> bool:
    """Whether a motion grows at a speed Ω."""
    periodic, speed = rotating.periodic, abs(rotating.frame_ratio) * speed_rad_s
    if periodic.stride and speed:
        found = floquet_multipliers(periodic, speed)
        return found.growth_1_s * found.period_s > _GROWS
    velocity, stiffness = (sum(parts.values()) for parts in periodic.at(speed))
    n, inverse = periodic.size, la.inv(periodic.mass)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ velocity]])
    values = la.eigvals(state)
    return bool(values.real.max() > _DRIFT * np.abs(values).max())


def _blocks(plan: _Plan, state: FloatArray) -> Iterator[_Block]:
    """Run through the profile; the last state of a block is the first of the next."""
    h = plan.step_s
    ratios = np.append(plan.loads.turning.ratios, 1.0)
    for piece in profile_pieces(plan.profile, h, ratios):
        begin = (piece.start_angle, piece.speeds[0], piece.acceleration)
        for first in range(piece.first_step, piece.last_step, _LONGEST):
            last = min(first + _LONGEST, piece.last_step)
            instants = instants_after(begin, h * (np.arange(first, last + 1) - piece.first_step))
            states = np.empty((last - first + 1, state.size))
            states[0] = state
            at_first = float(instants.angles_rad[0]), float(instants.speeds_rad_s[0]), begin[2]
            gauss_steps(plan.system, plan.loads.at, at_first, h, states)
            yield _Block(first, instants, states)
            state = states[-1]


class _Place(NamedTuple):
    """Motion of an interface or of a joint in fixed axes, (6, n) by harmonic per w."""

    motion: Harmonics

    def at(self, instants: Instants, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return motion and velocity, (s, 6) each."""
        n = states.shape[1] // 2
        place, rate = np.zeros((2, len(states), 6))
        for harmonic, rows in self.motion.items():
            if harmonic < 0:  # conjugate to that of −h
                continue
            turn = (2.0 if harmonic else 1.0) * np.exp(1j * harmonic * instants.angles_rad)[:, None]
            moved = states[:, :n] @ rows.T
            turning = 1j * harmonic * instants.speeds_rad_s[:, None] * moved
            place += (turn * moved).real
            rate += (turn * (states[:, n:] @ rows.T + turning)).real
        return place, rate


class _Recorder:
    """Collect the blocks of a run: motion and forces in fixed axes, energy in the frame."""

    def __init__(self, plan: _Plan, how: RunSettings) -> None:
        rotating, shapes = plan.rotating, plan.system.shapes
        self._plan, self._every = plan, int(how.record_every)
        bearings = checked_places(rotating, how.outputs, how.bearings)
        for bearing in bearings:
            if bearing.rigid:
                raise AnalysisError(
                    f"bearing {bearing.name!r} is rigid in {list(bearing.rigid)}; give it a "
                    "stiffness to record its force"
                )
        self._laws = {law.joint.bearing: law.joint for law in rotating.periodic.laws}
        self._outputs = [_on(rotating.seat(end), shapes) for end in how.outputs]
        self._bearings = [(b, _on(rotating.relative(b), shapes)) for b in bearings]
        self._motion: list[FloatArray] = []
        self._rate: list[FloatArray] = []
        self._forces: list[FloatArray] = []
        self.energy = EnergySums(plan.step_s)

    def add(self, block: _Block) -> None:
        """Keep what a block has of records."""
        begins = 0 if block.first_step == 0 else 1
        steps = block.first_step + np.arange(begins, len(block.states))
        kept = begins + np.flatnonzero(steps % self._every == 0)
        self._balance(block, kept)
        angles, speeds, rise = block.instants
        instants, states = Instants(angles[kept], speeds[kept], rise), block.states[kept]
        found = [place.at(instants, states) for place in self._outputs]
        shape = (len(kept), 0)
        self._motion.append(np.hstack([np.empty(shape), *(moved for moved, _ in found)]))
        self._rate.append(np.hstack([np.empty(shape), *(rate for _, rate in found)]))
        forces = [self._force(b, place, instants, states) for b, place in self._bearings]
        self._forces.append(np.hstack([np.empty(shape), *forces]))

    def motion(self) -> RecordedMotion:
        """Return all records."""
        outputs, bearings = len(self._outputs), len(self._bearings)
        return RecordedMotion.joined(self._motion, self._rate, self._forces, outputs, bearings)

    def _force(
        self, bearing: Bearing, place: _Place, instants: Instants, states: FloatArray
    ) -> FloatArray:
        """Force of the first side of a bearing on its second, (s, 6)."""
        moved, rate = place.at(instants, states)
        spring, drag = bearing.matrices()
        law = self._laws.get(bearing.name)
        if law is not None:
            spring[:2, :2] = drag[:2, :2] = 0.0
        force = moved @ spring.T + rate @ drag.T
        if law is not None:
            found = np.array([law.coefficients(float(p)) for p in instants.speeds_rad_s])
            force[:, :2] += np.einsum("sij,sj->si", found[:, 0], moved[:, :2])
            force[:, :2] += np.einsum("sij,sj->si", found[:, 1], rate[:, :2])
        return np.asarray(force)

    def _balance(self, block: _Block, kept: IntArray) -> None:
        """Keep stored energy and works of a block.

        With K = Ks + Ka the energy ½ w'² + ½ wᵀ Ks w rises by f w' − w' V w' − w' Ka w + ½ wᵀ Ks' w
        in a time, Ks' by angle and speed; p' E is skew and belongs to Ka.
        """
        system, instants = self._plan.system, block.instants
        n = system.size
        place, speed = block.states[:, :n], block.states[:, n:]
        factors, rates = system.factors.at(instants)
        weights = system.stiffness.weights(factors, instants.angles_rad)
        changes = system.stiffness.weight_rates(factors, rates, instants)
        pulls = np.tensordot(place, system.stiffness.matrices, axes=(1, 2))
        along, across = (np.einsum("stn,sn->st", pulls, x) for x in (place, speed))
        pushed = np.tensordot(place, system.stiffness.matrices, axes=(1, 1))
        mirrored = np.einsum("stn,sn->st", pushed, speed)
        drags = np.tensordot(speed, system.velocity.matrices, axes=(1, 2))
        lost = np.einsum("stn,sn->st", drags, speed)
        dissipated = system.velocity.weights(factors, instants.angles_rad) * lost
        drive = 0.5 * (changes * along - weights * (across - mirrored)).sum(axis=1)
        stored = 0.5 * ((weights * along).sum(axis=1) + np.einsum("sn,sn->s", speed, speed))
        load = np.einsum("sn,sn->s", self._plan.loads.at(instants), speed)
        powers = np.stack((load, drive, dissipated.sum(axis=1)), axis=1)
        records = np.isin(np.arange(stored.size), kept)
        works = Works(powers[None], difference_slopes(powers)[None], np.zeros((1, stored.size)))
        self.energy.add(stored[None], works, records[None])


def _on(motion: Harmonics, shapes: FloatArray) -> _Place:
    return _Place({h: part @ shapes for h, part in motion.items()})
