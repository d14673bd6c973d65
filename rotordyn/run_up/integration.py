"""Transient run-up of an assembled system: exponential integration with a slowly varying speed."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.bearing_notes import bearing_notes, note_lines
from solidwhirl.rotordyn.assembly.coordinates import Placed
from solidwhirl.rotordyn.assembly.parts import End, System
from solidwhirl.rotordyn.assembly.system import AssembledSystem, gravity_load, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.damping import NEUTRAL
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.modes.uncoupled import uncoupled_groups
from solidwhirl.rotordyn.modes.whirl import interface_rows_of_all, rotor_length
from solidwhirl.rotordyn.response.static import static_equilibrium
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.blocks import (
    ProfilePiece,
    RunPlan,
    Stretch,
    chosen_stride,
    moving_parts,
    profile_pieces,
    shortest_block,
    stretches,
)
from solidwhirl.rotordyn.run_up.loads import TurningLoads, torsion_load, turning_loads
from solidwhirl.rotordyn.run_up.modal_basis import modal_parts
from solidwhirl.rotordyn.run_up.record import Divergence, EnergyBalance, MotionState, RunUp
from solidwhirl.rotordyn.run_up.recorder import RecordedMotion, Recorder
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold
from solidwhirl.rotordyn.run_up.steps import FrequencyRates, frequency_rates

__all__ = ["ramp_and_hold", "run_up"]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RunSettings:
    """Say how a run-up is integrated and what of it is recorded.

    `step_s`: h, s. Bodies with unbalance may turn by one radian in a step. `record_every`: steps
    from one record to the next; `outputs`: interfaces whose motion is recorded; `bearings`: names
    of the bearings whose force is recorded. `gravity_m_per_s2`: along x, y, z, shape (3,); None
    without. `drives`: interfaces with rz where the torque enters that accelerates each train of
    bodies turning together. Without any, bodies are driven where their inertia is, and Ω' excites
    no torsion. `initial`: state at time 0; None for rest, in static equilibrium with gravity.
    `phase_error_rad`: bound of the error in the phase of a free vibration within a block of steps
    that share one frozen speed. Errors of amplitude are smaller still. Raises AnalysisError if a
    number has no meaning.
    """

    step_s: float
    record_every: int = 1
    outputs: Sequence[End] = ()
    bearings: Sequence[str] = ()
    gravity_m_per_s2: npt.ArrayLike | None = None
    drives: Sequence[End] = ()
    initial: MotionState | None = None
    phase_error_rad: float = 3e-4

    def __post_init__(self) -> None:
        every, error = self.record_every, self.phase_error_rad
        if not (isinstance(every, (int, np.integer)) and every >= 1):
            raise AnalysisError(f"record_every is {every}; it must be a whole number, 1 or more")
        if not (np.isfinite(error) and error > 0):
            raise AnalysisError(f"phase_error_rad is {error}; it must be positive")


class Watch:
    """Look at the blocks of a run for motion that grows beyond the size of the machine.

    A linear system has no other end: below, its displacement may be wrong, but is not absurd.
    `shapes`: from the coordinates of the blocks to those of the system, shape (n, m); `grows`:
    whether a motion grows at a speed Ω.
    """

    def __init__(
        self,
        system: Placed,
        shapes: FloatArray,
        step_s: float,
        grows: Callable[[float], bool],
    ) -> None:
        rows = interface_rows_of_all(system).reshape(-1, 6, len(shapes))[:, :3]
        self._rows = rows.reshape(-1, len(shapes)) @ shapes
        self._limit = rotor_length(system.system)
        self._step_s, self._grows = step_s, grows

    def divergence(
        self, first_step: int, speeds_rad_s: FloatArray, places: FloatArray
    ) -> Divergence | None:
        """Return where a run has diverged within a block; None if it has not.

        `first_step`: number of its first step; `speeds_rad_s`: Ω at its times, shape (K + 1,);
        `places`: its displacements, shape (K + 1, n).
        """
        # one instant tells it: what has not outgrown the machine at the end has not before
        if not self.outgrown(places[-1:]):
            return None
        if not self._grows(0.5 * float(speeds_rad_s[0] + speeds_rad_s[-1])):
            return None
        sizes = self._largest(places)
        last = max(int(np.flatnonzero(~(sizes <= self._limit))[0]), 1)
        return Divergence(
            time_s=(first_step + last) * self._step_s,
            speed_rad_s=float(speeds_rad_s[last]),
            amplitude_m=float(sizes[last]),
            limit_m=self._limit,
        )

    def outgrown(self, places: FloatArray) -> list[int]:
        """Return which of some displacements (s, n) are larger than the machine, rising."""
        large = ~(self._largest(places) <= self._limit)
        return [int(k) for k in np.flatnonzero(large)]

    def steps_until(self, stopped: Divergence, first_step: int) -> int:
        """Return how many steps of a block are left of it."""
        return round(stopped.time_s / self._step_s) - first_step

    def _largest(self, places: FloatArray) -> FloatArray:
        return np.asarray(np.abs(places @ self._rows.T).max(axis=1, initial=0.0))


def shortened(profile: SpeedProfile, time_s: float) -> SpeedProfile:
    """Return a profile up to a time, s."""
    before = profile.times_s[profile.times_s < time_s]
    times = np.append(before, time_s)
    return SpeedProfile(times_s=times, speeds_rad_s=profile.speed_rad_s(times))


def _grows(assembled: AssembledSystem, speed_rad_s: float) -> bool:
    modes = modes_at_speed(assembled, speed_rad_s)
    values = np.concatenate((modes.eigenvalues, modes.real_eigenvalues.astype(complex)))
    return bool((values.real > NEUTRAL * np.abs(values)).any())


def run_up(
    assembled: AssembledSystem,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    *,
    known: dict[Hashable, PartRun] | None = None,
    **settings: Any,
) -> RunUp:
    """Integrate the motion of a system while its speed follows a profile.

    M q'' + (C(Ω) + ΩG) q' + (K(Ω) + Ω²K2 + ΩN + ½Ω'G) q = f, with the unbalance force u [ω² (cos
    φ, sin φ) + ω' (sin φ, −cos φ)] on each body, ω = ratio Ω, φ = ratio ∫Ω dt + phase.

    `profile`: Ω(t) of the reference shaft; its breakpoints must be whole steps. `unbalances`: may
    be empty. `known`: parts of other runs of the same machine, and of models of it with the same
    bearings and speeds: what is the same is taken from there, what is not is put there. `settings`:
    fields of `RunSettings`, of which `step_s` must be given. At a breakpoint forces are those just
    before it. A run that diverges stops: where a mode grows and an interface has moved by more than
    the length of the longest body. Its profile, times and records end there. Raises AnalysisError
    if an argument has no meaning, or the step is too long for the profile or the unbalance;
    AssemblyError if a body or interface does not exist or lacks a component.

    In a block of steps Ω is frozen at its middle (exponential midpoint rule, the Magnus method of
    second order: Hochbruck and Ostermann 2010, Acta Numerica 19, section 5; Iserles, Munthe-Kaas,
    Nørsett and Zanna 2000, Acta Numerica 9). Within it steps are exact but for the load, a Hermite
    cubic in each step, so that the error falls with the square of the block and the fourth power
    of the step, and at constant speed no frequency, damping or energy is falsified. The step
    operators are tabulated over the speed by Chebyshev interpolation; each profile piece of its
    own slope costs some matrix exponentials.

    ½Ω'G belongs to a driving torque that stays halfway between the axis fixed in space and the
    tilted one (semitangential).

    Parts of the system that nothing couples are integrated each by itself, in blocks as long as its
    own frequencies allow.
    """
    case, parts = _apart(assembled, profile, unbalances, RunSettings(**settings))
    runs = _runs(case, parts, {} if known is None else known)
    stopped = min((r.stopped for r in runs if r.stopped is not None), key=_time, default=None)
    if stopped is not None:
        case = case._replace(profile=shortened(profile, stopped.time_s))
        runs = [
            run if run.stopped is stopped else _integrated(case, part)
            for run, part in zip(runs, parts, strict=True)
        ]
    return _record(case, unbalances, parts, runs, stopped)


def parts_to_run(
    assembled: AssembledSystem,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    *,
    known: dict[Hashable, RunSettings],
    **settings: Any,
) -> list[IntArray]:
    """Return the coordinates of each part that `run_up` would integrate, rising.

    `known`: what is recorded of parts that are known; those that would be integrated are put there.
    Other arguments and errors as of `run_up`.
    """
    case, parts = _apart(assembled, profile, unbalances, RunSettings(**settings))
    todo = []
    for part in parts:
        key = _key(case, part)
        if not _records(known.get(key), case.how):
            known[key] = case.how
            todo.append(part.coordinates)
    return todo


def _records(found: PartRun | RunSettings | None, how: RunSettings) -> bool:
    """Whether what is known of a part holds all that is to be recorded."""
    if found is None:
        return False
    return {*how.outputs} <= {*found.outputs} and {*how.bearings} <= {*found.bearings}


def _apart(
    assembled: AssembledSystem,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    how: RunSettings,
) -> tuple[_Case, list[_LoadedPart]]:
    """Return what is common to the parts of a run, and these."""
    case = _Case(assembled, profile, how, _start(assembled, profile, how))
    loads = _loads(assembled, unbalances, how)
    profile_pieces(profile, float(how.step_s), loads.turning.ratios)  # refused for the whole
    return case, _loaded_parts(assembled, loads, case.start)


class _Case(NamedTuple):
    """What is common to the parts of a run."""

    assembled: AssembledSystem
    profile: SpeedProfile
    how: RunSettings
    start: MotionState


def _time(stopped: Divergence) -> float:
    return stopped.time_s


def _runs(
    case: _Case, parts: Sequence[_LoadedPart], known: dict[Hashable, PartRun]
) -> list[PartRun]:
    """Return the run of each part; what is known is taken, what is not is put there."""
    runs = []
    for part in parts:
        key = _key(case, part)
        found = known.get(key)
        if found is None or not _records(found, case.how):
            found = known[key] = _integrated(case, part)
        runs.append(found.of(case.how))
    return runs


def _record(
    case: _Case,
    unbalances: Sequence[Unbalance],
    parts: Sequence[_LoadedPart],
    runs: Sequence[PartRun],
    stopped: Divergence | None,
) -> RunUp:
    """Return the record of all parts together."""
    return run_record(
        case.assembled.system,
        case.profile,
        unbalances,
        case.how,
        _motion(runs),
        longest_block=max(run.longest_block for run in runs),
        energy=_energy(runs),
        balance_error=max(run.balance_error for run in runs),
        final=_final(case.assembled.transformation, parts, runs),
        notes=_notes(case.assembled, case.profile),
        stopped=stopped,
        wall_time_s=sum(run.wall_time_s for run in runs),
    )


def _motion(runs: Sequence[PartRun]) -> RecordedMotion:
    """Return the motion and the forces of all parts."""
    return RecordedMotion(*(sum(parts) for parts in zip(*(r.motion for r in runs), strict=True)))


def _energy(runs: Sequence[PartRun]) -> EnergyBalance:
    """Return the energy of all parts."""
    names = [field.name for field in fields(EnergyBalance)]
    return EnergyBalance(**{n: sum(getattr(run.energy, n) for run in runs) for n in names})


def _final(
    transformation: FloatArray, parts: Sequence[_LoadedPart], runs: Sequence[PartRun]
) -> MotionState:
    """Return the last state of all parts in the independent coordinates."""
    state = np.zeros((2, transformation.shape[1]))
    for part, run in zip(parts, runs, strict=True):
        stacked = np.stack((run.final.displacement, run.final.velocity), axis=1)
        state[:, part.coordinates] = la.lstsq(transformation[:, part.coordinates], stacked)[0].T
    return MotionState(displacement=state[0], velocity=state[1])


def _key(case: _Case, part: _LoadedPart) -> Hashable:
    """Return what tells a part from those of other runs and models of a machine.

    Bodies that move in it, which of their coordinates do, and in how many ways, its loads and its
    start, and how it is integrated: joints and speeds are those of the machine.
    """
    assembled, profile, how, start = case
    at, (turning, steady, torsion) = part.coordinates, part.loads
    rows = assembled.transformation[:, at].any(axis=1)
    bodies = tuple(
        (name, rotor.element)
        for name, rotor in assembled.system.rotors.items()
        if rows[assembled.body_slices[name]].any()
    )
    numbers = (
        *(profile.times_s, profile.speeds_rad_s, turning.ratios, turning.columns, steady, torsion),
        *(start.displacement[at], start.velocity[at], rows),
    )
    steps = float(how.step_s), int(how.record_every), float(how.phase_error_rad)
    return at.size, bodies, steps, *(tuple(np.ravel(array).tolist()) for array in numbers)


class _Loads(NamedTuple):
    """Loads on the stacked coordinates: turning ones, that which stays, (N,), and per Ω', (N,)."""

    turning: TurningLoads
    steady: FloatArray
    torsion: FloatArray

    def on(self, rows: BoolArray) -> _Loads:
        """Return the loads on some of the coordinates, (N,), without those that are none there."""
        columns = self.turning.columns * rows[:, None]
        acts = columns.reshape(len(rows), -1, 2).any(axis=(0, 2))
        turning = TurningLoads(self.turning.ratios[acts], columns[:, np.repeat(acts, 2)])
        return _Loads(turning, self.steady * rows, self.torsion * rows)


def _loads(assembled: AssembledSystem, unbalances: Sequence[Unbalance], how: RunSettings) -> _Loads:
    turning = turning_loads(assembled, unbalances)
    torsion = torsion_load(assembled, assembled.stiffness, how.drives)
    return _Loads(turning, _weight(assembled, how), torsion)


class _LoadedPart(NamedTuple):
    """Groups of coordinates that move by themselves, and the loads on them."""

    groups: Sequence[IntArray]
    loads: _Loads

    @property
    def coordinates(self) -> IntArray:
        """All of them, rising."""
        return np.sort(np.concatenate(self.groups))


def _loaded_parts(
    assembled: AssembledSystem, loads: _Loads, start: MotionState
) -> list[_LoadedPart]:
    """Return the parts that a load acts on or that move at the start; all as one if none does.

    What no part moves counts to the first one.
    """
    every = np.column_stack((loads.turning.columns, loads.steady, loads.torsion))
    moves = (assembled.transformation.T @ every).any(axis=1)
    moves |= (start.displacement != 0) | (start.velocity != 0)
    every_group = uncoupled_groups(assembled)
    groups = [at for at in every_group if moves[at].any()]
    if not groups:
        return [_LoadedPart(every_group, loads)]
    rows = [assembled.transformation[:, at].any(axis=1) for at in groups]
    rows[0] |= ~np.logical_or.reduce(rows)
    return [_LoadedPart([at], loads.on(own)) for at, own in zip(groups, rows, strict=True)]


class PartRun(NamedTuple):
    """What a part adds to a run.

    `outputs`, `bearings`: what `motion` holds; `final`: its last state on the stacked coordinates,
    (N,) each; `stopped`: where it diverged; `wall_time_s`: of its integration.
    """

    outputs: tuple[End, ...]
    bearings: tuple[str, ...]
    motion: RecordedMotion
    longest_block: int
    energy: EnergyBalance
    balance_error: float
    final: MotionState
    stopped: Divergence | None
    wall_time_s: float

    def of(self, how: RunSettings) -> PartRun:
        """Return it with that alone."""
        outputs, bearings = tuple(how.outputs), tuple(how.bearings)
        if (outputs, bearings) == (self.outputs, self.bearings):
            return self
        ends = [self.outputs.index(end) for end in outputs]
        held = [self.bearings.index(name) for name in bearings]
        places, rates, forces = self.motion
        motion = RecordedMotion(_some(places, ends), _some(rates, ends), _some(forces, held))
        return self._replace(outputs=outputs, bearings=bearings, motion=motion)


def _some(records: FloatArray, at: list[int]) -> FloatArray:
    """Return some of the records (…, 6, s), with no instants where there are none."""
    return records[at] if at else records[:0, :, :0]


def _integrated(case: _Case, part: _LoadedPart) -> PartRun:
    """Integrate the motion of a part."""
    begun = time.perf_counter()
    assembled, how = case.assembled, case.how
    run = _prepared(case, part)
    plan, stride = run.plan, run.plan.stride
    recorder = Recorder(plan, int(how.record_every), how.outputs, how.bearings)
    shapes = plan.shapes / plan.scale
    watch = Watch(assembled, shapes, stride.duration_s, partial(_grows, assembled))
    longest, stopped, states = 1, None, []
    for stretch in stretches(plan, run.pieces, run.rates, case.start):
        found = _until_divergence(stretch, watch)
        for piece in found.parts:
            recorder.add(piece)
        states, stopped = found.parts[-1].final, found.stopped
        if stretch.acceleration_rad_s2 != 0:
            longest = max(longest, stretch.steps_of_block)
        if stopped is not None:
            break
    final = plan.motion(states)
    return PartRun(
        outputs=tuple(how.outputs),
        bearings=tuple(how.bearings),
        motion=recorder.motion(),
        longest_block=longest,
        energy=recorder.energy(),
        balance_error=recorder.worst_balance(),
        final=MotionState(
            displacement=assembled.transformation @ final.displacement,
            velocity=assembled.transformation @ final.velocity,
        ),
        stopped=stopped,
        wall_time_s=time.perf_counter() - begun,
    )


class _Prepared(NamedTuple):
    """A plan, the pieces of its profile, and how fast frequencies change."""

    plan: RunPlan
    pieces: list[ProfilePiece]
    rates: FrequencyRates


def _prepared(case: _Case, part: _LoadedPart) -> _Prepared:
    assembled, profile, how, start = case
    step_s, (turning, steady, torsion) = float(how.step_s), part.loads
    pieces = profile_pieces(profile, step_s, turning.ratios)
    parts = moving_parts(
        assembled, modal_parts(assembled, part.groups), turning, (steady, torsion), start
    )
    speeds = profile.speeds_rad_s
    bases = [moving.basis for moving in parts]
    rates = frequency_rates(bases, float(speeds.min()), float(speeds.max()))
    fastest = float(np.abs(speeds).max() * np.abs(turning.ratios).max(initial=0.0))
    shortest = shortest_block(pieces, rates, step_s, float(how.phase_error_rad))
    plan = RunPlan(
        assembled=assembled,
        parts=parts,
        profile=profile,
        turning=turning,
        steady=steady,
        torsion=torsion,
        stride=chosen_stride(pieces, step_s, int(how.record_every), fastest, shortest),
        phase_error_rad=float(how.phase_error_rad),
    )
    return _Prepared(plan, pieces, rates)


class _Watched(NamedTuple):
    """A stretch, or whole blocks of it and the one that diverges up to there."""

    parts: Sequence[Stretch]
    stopped: Divergence | None


def _until_divergence(stretch: Stretch, watch: Watch) -> _Watched:
    """Return what a stretch has up to where it diverges."""
    places = np.concatenate([motion.place for motion in stretch.motions], axis=-1)
    strides = stretch.speeds_rad_s.shape[1] - 1
    for k in watch.outgrown(places[:, -1]):
        first = stretch.first_step // stretch.stride_steps + k * strides
        stopped = watch.divergence(first, stretch.speeds_rad_s[k], places[k])
        if stopped is not None:
            before = [stretch.blocks(0, k, strides)] if k else []
            last = stretch.blocks(k, k + 1, watch.steps_until(stopped, first))
            return _Watched([*before, last], stopped)
    return _Watched([stretch], None)


def _weight(assembled: AssembledSystem, how: RunSettings) -> FloatArray:
    """Return gravity on the stacked coordinates, shape (N,)."""
    if how.gravity_m_per_s2 is None:
        return np.zeros(assembled.transformation.shape[0])
    return gravity_load(assembled, how.gravity_m_per_s2)


def _start(assembled: AssembledSystem, profile: SpeedProfile, how: RunSettings) -> MotionState:
    """Return the given state, else rest under the constant load."""
    if how.initial is not None:
        return how.initial.of_size(assembled.size)
    still, weight = np.zeros(assembled.size), _weight(assembled, how)
    if not weight.any():
        return MotionState(displacement=still, velocity=still)
    speed = float(profile.speeds_rad_s[0])
    stiffness = matrices_at_speed(assembled, speed).stiffness
    place = static_equilibrium(stiffness, speed, assembled.transformation.T @ weight)
    return MotionState(displacement=place, velocity=still)


def _notes(assembled: AssembledSystem, profile: SpeedProfile) -> tuple[str, ...]:
    """Say where bodies and bearings run beyond what they were made for."""
    limits = speed_limit_notes(profile, assembled.speed_limit_rad_s)
    return (*limits, *note_lines(bearing_notes(assembled, profile.speeds_rad_s)))


def run_record(
    system: System,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    how: RunSettings,
    motion: RecordedMotion,
    **rest: Any,
) -> RunUp:
    """Return the record of a run over a profile; `rest`: fields of `RunUp` that no other gives."""
    count = round(profile.duration_s / how.step_s)
    steps = np.arange(0, count + 1, int(how.record_every))
    # the last breakpoint may miss the last step by rounding
    times = np.minimum(steps * float(how.step_s), profile.duration_s)
    return RunUp(
        profile=profile,
        speed_ratios={name: r.speed_ratio for name, r in system.rotors.items()},
        unbalances=tuple(unbalances),
        step_s=float(how.step_s),
        time_s=times,
        speed_rad_s=profile.speed_rad_s(times),
        angle_rad=profile.angle_rad(times),
        outputs=tuple(how.outputs),
        translation_m=motion.displacement[:, :3],
        rotation_rad=motion.displacement[:, 3:],
        velocity_m_per_s=motion.velocity[:, :3],
        angular_velocity_rad_per_s=motion.velocity[:, 3:],
        bearings=tuple(how.bearings),
        force_n=motion.force[:, :3],
        moment_n_m=motion.force[:, 3:],
        **rest,
    )


def speed_limit_notes(profile: SpeedProfile, limit_rad_s: float) -> tuple[str, ...]:
    """Say whether a body runs beyond what it was made for."""
    fastest = float(np.abs(profile.speeds_rad_s).max())
    if fastest <= limit_rad_s:
        return ()
    return (
        f"above {limit_rad_s:.6g} rad/s a body runs faster than its basis was made for; the run "
        f"goes to {fastest:.6g} rad/s",
    )
