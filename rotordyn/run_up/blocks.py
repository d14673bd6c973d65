"""Runs through a profile: blocks of steps that share one frozen speed, many of them at a time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg.blas import dgemv

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.run_up.loads import TurningLoads
from solidwhirl.rotordyn.run_up.modal_basis import ModalBasis, ModalPart
from solidwhirl.rotordyn.run_up.record import MotionState
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile
from solidwhirl.rotordyn.run_up.steps import (
    FrequencyRates,
    Stride,
    StrideTable,
    block_length,
    stride_table,
)

# Steps of a block at most; bounds memory only.
_LONGEST = 1024
# Numbers of the tables of all blocks of a stretch: 16 MB.
_NUMBERS = 1 << 21
# A breakpoint may miss a step by this fraction of it, and a step may be an angle up to this.
_ON_STEP = 1e-6
_LARGEST_ANGLE = 1.0
# From one state to the next the fastest unbalance turns by no more than this, or it is one step:
# the works of the loads are sums over the states.
_STRIDE_ANGLE = 0.5


class RunPart(NamedTuple):
    """A part of a system that moves by itself, and its loads.

    `coordinates`: independent coordinates of the system, shape (n,); `basis`: its modes;
    `columns`: which turning loads act on it; `loads`: these on its modes, shape (n, c).
    """

    coordinates: IntArray
    basis: ModalBasis
    columns: IntArray
    loads: FloatArray


class RunPlan(NamedTuple):
    """All that a run needs.

    `assembled`: the system; `parts`: those that move; `profile`: Ω(t); `turning`: unbalance;
    `steady`: load that never changes on the stacked coordinates, shape (N,); `torsion`: load per
    unit Ω' on the stacked coordinates, shape (N,); `stride`: from one state to the next;
    `phase_error_rad`: see `steps.block_length`.
    """

    assembled: AssembledSystem
    parts: tuple[RunPart, ...]
    profile: SpeedProfile
    turning: TurningLoads
    steady: FloatArray
    torsion: FloatArray
    stride: Stride
    phase_error_rad: float

    @property
    def shapes(self) -> FloatArray:
        """Modes of all parts in the coordinates of the system, shape (n, modes)."""
        shapes = [np.zeros((self.assembled.size, part.basis.size)) for part in self.parts]
        for part, columns in zip(self.parts, shapes, strict=True):
            columns[part.coordinates] = part.basis.shapes
        return np.hstack(shapes)

    @property
    def scale(self) -> FloatArray:
        """σ of these modes, shape (modes,)."""
        return np.concatenate([part.basis.scale for part in self.parts])

    def motion(self, states: Sequence[FloatArray]) -> MotionState:
        """Return displacement and velocity in the independent coordinates of x of the parts."""
        place, velocity = np.zeros((2, self.assembled.size))
        for part, state in zip(self.parts, states, strict=True):
            own = part.basis.motion(state)
            place[part.coordinates], velocity[part.coordinates] = own.displacement, own.velocity
        return MotionState(displacement=place, velocity=velocity)

    def modal(self, part: RunPart, load: FloatArray) -> FloatArray:
        """Return a stacked load on the modes of a part, shape (n,)."""
        independent = self.assembled.transformation.T @ load
        return np.asarray(part.basis.shapes.T @ independent[part.coordinates])


def moving_parts(
    assembled: AssembledSystem,
    parts: Sequence[ModalPart],
    turning: TurningLoads,
    steady: Sequence[FloatArray],
    start: MotionState,
) -> tuple[RunPart, ...]:
    """Return the parts that a load acts on or that move at the start; all if there is none.

    `steady`: loads that do not turn, on the stacked coordinates, shape (N,) each.
    """
    transposed = assembled.transformation.T
    columns = transposed @ turning.columns
    other = [transposed @ load for load in steady] + [start.displacement, start.velocity]
    found, moving = [], []
    for at, basis in parts:
        acting = np.flatnonzero(columns[at].any(axis=0))
        loads = basis.shapes.T @ columns[np.ix_(at, acting)]
        found.append(RunPart(at, basis, acting, np.asarray(loads)))
        moving.append(acting.size > 0 or any(vector[at].any() for vector in other))
    chosen = [part for part, moves in zip(found, moving, strict=True) if moves]
    return tuple(chosen or found)


class PartMotion(NamedTuple):
    """Motion of a part over B blocks of L strides.

    `states`: x, shape (B, L + 1, 2n), the last of a block being the first of the next; `rates`: η''
    from x without loads, shape (B, n, 2n); `constant`: loads that stay, on the modes, shape (n,).
    """

    states: FloatArray
    rates: FloatArray
    constant: FloatArray

    @property
    def place(self) -> FloatArray:
        """σ η, shape (B, L + 1, n)."""
        return self.states[..., : self.rates.shape[1]]

    @property
    def velocity(self) -> FloatArray:
        """η', shape (B, L + 1, n)."""
        return self.states[..., self.rates.shape[1] :]


class Stretch(NamedTuple):
    """B blocks of L strides of steps, each with one frozen speed.

    `first_step`: number of the step at which it begins; `stride_steps`: steps from one state to
    the next; `frozen_speeds_rad_s`: Ω in the middle of each block, shape (B,);
    `acceleration_rad_s2`: Ω'; `speeds_rad_s`: Ω at the states, shape (B, L + 1); `amplitudes`,
    `amplitude_rates`: factors of the unbalance columns there and their rates, shape (B, L + 1, c);
    `motions`: of each part that moves;
    `constant`: loads that stay, on the stacked coordinates, shape (N,).
    """

    first_step: int
    stride_steps: int
    frozen_speeds_rad_s: FloatArray
    acceleration_rad_s2: float
    speeds_rad_s: FloatArray
    amplitudes: FloatArray
    amplitude_rates: FloatArray
    motions: tuple[PartMotion, ...]
    constant: FloatArray

    @property
    def steps_of_block(self) -> int:
        """Steps that share one frozen speed."""
        return (self.speeds_rad_s.shape[1] - 1) * self.stride_steps

    @property
    def steps(self) -> IntArray:
        """Numbers of the steps of the states, shape (B, L + 1)."""
        blocks, states = self.speeds_rad_s.shape
        within = self.stride_steps * np.arange(states)
        return np.asarray(
            self.first_step + self.steps_of_block * np.arange(blocks)[:, None] + within
        )

    @property
    def final(self) -> list[FloatArray]:
        """The last state of each part, shape (2n,)."""
        return [motion.states[-1, -1] for motion in self.motions]

    def blocks(self, first: int, last: int, strides: int) -> Stretch:
        """Return the blocks from one to another one, and the first strides of each."""
        rows, some = slice(first, last), slice(strides + 1)
        return self._replace(
            first_step=self.first_step + first * self.steps_of_block,
            frozen_speeds_rad_s=self.frozen_speeds_rad_s[rows],
            speeds_rad_s=self.speeds_rad_s[rows, some],
            amplitudes=self.amplitudes[rows, some],
            amplitude_rates=self.amplitude_rates[rows, some],
            motions=tuple(
                m._replace(states=m.states[rows, some], rates=m.rates[rows]) for m in self.motions
            ),
        )


class ProfilePiece(NamedTuple):
    """A linear piece of the profile in whole steps: Ω at both ends, Ω', and ∫Ω dt before it."""

    first_step: int
    last_step: int
    speeds: tuple[float, float]
    acceleration: float
    start_angle: float

    def at(self, times_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return Ω and ∫Ω dt at times since its beginning."""
        speeds = self.speeds[0] + self.acceleration * times_s
        return speeds, self.start_angle + 0.5 * (self.speeds[0] + speeds) * times_s


def profile_pieces(
    profile: SpeedProfile, step_s: float, ratios: npt.ArrayLike
) -> list[ProfilePiece]:
    """Cut a profile into linear pieces of whole steps.

    `ratios`: speeds of what must turn by no more than a radian in a step, over that of the profile.
    Raises AnalysisError if the step does not fit.
    """
    h = step_s
    if not (np.isfinite(h) and h > 0):
        raise AnalysisError(f"step_s is {h}; it must be positive")
    steps = profile.times_s / h
    whole = np.rint(steps).astype(int)
    missed = np.abs(steps - whole)
    if (missed > _ON_STEP).any() or (np.diff(whole) < 1).any():
        at = float(profile.times_s[int(missed.argmax())])
        raise AnalysisError(
            f"step_s is {h:.9g}, but the breakpoint of the profile at {at:.9g} s is not a whole "
            "number of steps; change one of them"
        )
    fastest = float(np.abs(profile.speeds_rad_s).max())
    fastest *= float(np.abs(ratios).max(initial=0.0))
    if fastest * h > _LARGEST_ANGLE:
        raise AnalysisError(
            f"step_s is {h:.6g}, in which a body with unbalance turns by {fastest * h:.3g} rad; "
            f"take a step of at most {_LARGEST_ANGLE / fastest:.3g} s"
        )
    speeds = profile.speeds_rad_s.tolist()
    angles = profile.angle_rad(profile.times_s).tolist()
    slopes = profile.accelerations_rad_s2.tolist()
    return [
        ProfilePiece(
            int(whole[i]), int(whole[i + 1]), (speeds[i], speeds[i + 1]), slopes[i], angles[i]
        )
        for i in range(len(slopes))
    ]


def chosen_stride(
    pieces: Sequence[ProfilePiece],
    step_s: float,
    record_every: int,
    fastest_rad_s: float,
    shortest_block: float,
) -> Stride:
    """Return how many steps lie between states: up to a record, a breakpoint, the end of a block.

    `fastest_rad_s`: largest speed of a body with unbalance; `shortest_block`: in steps.
    """
    common = math.gcd(record_every, *(piece.last_step for piece in pieces))
    most = shortest_block
    if fastest_rad_s > 0:
        most = min(most, _STRIDE_ANGLE / (fastest_rad_s * step_s))
    fitting = (d for d in range(1, common + 1) if common % d == 0 and d <= most)
    return Stride(max(fitting, default=1), step_s)


class _BlockRun(NamedTuple):
    """Blocks of equal length in a row: their first step, their number, steps of each."""

    first_step: int
    blocks: int
    steps: int


def _block_runs(
    plan: RunPlan, piece: ProfilePiece, rates: FrequencyRates, most: int
) -> Iterator[_BlockRun]:
    """Cut a piece into blocks, as long as the rates where they lie allow; `most` to a run."""
    m, h = plan.stride.steps, plan.stride.step_s
    ends = [piece.first_step, piece.last_step]
    if piece.acceleration:
        times = (rates.edges_rad_s - piece.speeds[0]) / piece.acceleration
        inside = piece.first_step + m * np.rint(times / plan.stride.duration_s).astype(int)
        inside = inside[(inside > ends[0]) & (inside < ends[1])]
        ends = sorted({*ends, *inside.tolist()})
    for begin, end in pairwise(ends):
        speeds, _ = piece.at(h * (np.array([begin, end]) - piece.first_step))
        longest = _longest_block(plan, piece, rates, (float(speeds[0]), float(speeds[1])))
        size, count = longest, (end - begin) // longest
        at_once = most if piece.acceleration else 1
        for k in range(0, count, at_once):
            yield _BlockRun(begin + k * size, min(at_once, count - k), size)
        if count * size < end - begin:
            yield _BlockRun(begin + count * size, 1, end - begin - count * size)


def _longest_block(
    plan: RunPlan, piece: ProfilePiece, rates: FrequencyRates, speeds: tuple[float, float]
) -> int:
    """Return the steps of the blocks between two speeds, whole strides."""
    m = plan.stride.steps
    longest = block_length(
        rates, speeds, piece.acceleration, plan.stride.step_s, plan.phase_error_rad
    )
    return int(max(m, min(longest, max(_LONGEST, m)) // m * m))


def shortest_block(
    pieces: Sequence[ProfilePiece], rates: FrequencyRates, step_s: float, phase_error_rad: float
) -> float:
    """Return the steps of the shortest block anywhere; inf at constant speed."""
    lengths = (
        block_length(rates, piece.speeds, piece.acceleration, step_s, phase_error_rad)
        for piece in pieces
    )
    return min(lengths, default=np.inf)


def stretches(
    plan: RunPlan, pieces: Sequence[ProfilePiece], rates: FrequencyRates, start: MotionState
) -> Iterator[Stretch]:
    """Run through the profile, from a state at time 0.

    The result is in order, the last state of one being the first of the next.
    """
    parts = [ModalPart(part.coordinates, part.basis) for part in plan.parts]
    states = [part.state(start) for part in parts]
    for piece in pieces:
        constant = plan.steady + piece.acceleration * plan.torsion
        on_parts = [plan.modal(part, constant) for part in plan.parts]
        width = abs(piece.acceleration) * plan.stride.step_s
        width *= _longest_block(plan, piece, rates, piece.speeds)
        tables = [
            stride_table(
                part.basis, part.loads, load[:, None], plan.stride, piece.acceleration,
                piece.speeds, width,
            )
            for part, load in zip(plan.parts, on_parts, strict=True)
        ]  # fmt: skip
        most = max(1, _NUMBERS // sum(table.entries for table in tables))
        for run in _block_runs(plan, piece, rates, most):
            times = _Times.of(plan, piece, run)
            frozen = 0.5 * (times.speeds[:, 0] + times.speeds[:, -1])
            motions = []
            for k, part in enumerate(plan.parts):
                motion = _moved(part, tables[k], frozen, times, states[k])
                motions.append(PartMotion(*motion, on_parts[k]))
                states[k] = motion[0][-1, -1]
            yield Stretch(
                first_step=run.first_step,
                stride_steps=plan.stride.steps,
                frozen_speeds_rad_s=frozen,
                acceleration_rad_s2=piece.acceleration,
                speeds_rad_s=times.speeds,
                amplitudes=times.values,
                amplitude_rates=times.rates,
                motions=tuple(motions),
                constant=constant,
            )


class _Times(NamedTuple):
    """What the turning loads are over a run of blocks.

    `speeds`, `values`, `rates`: Ω, the factors of the columns and their rates at the states, (B, L
    + 1) and (B, L + 1, c); `given`: factors at all times of the steps of each stride, and h times
    their rates, shape (2, B, L, m + 1, c).
    """

    speeds: FloatArray
    values: FloatArray
    rates: FloatArray
    given: FloatArray

    @classmethod
    def of(cls, plan: RunPlan, piece: ProfilePiece, run: _BlockRun) -> _Times:
        m, h = plan.stride.steps, plan.stride.step_s
        first = run.first_step - piece.first_step
        speeds, angles = piece.at(h * (first + np.arange(run.blocks * run.steps + 1)))
        values, changes = plan.turning.amplitudes(angles, speeds, piece.acceleration)
        begins = run.steps * np.arange(run.blocks)[:, None] + np.arange(0, run.steps, m)
        steps = begins[..., None] + np.arange(m + 1)
        ends = run.steps * np.arange(run.blocks)[:, None] + np.arange(0, run.steps + 1, m)
        given = np.stack((values[steps], h * changes[steps]))
        return cls(speeds[ends], values[ends], changes[ends], given)


def _moved(
    part: RunPart, table: StrideTable, frozen: FloatArray, times: _Times, state: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the states of a part from its first one, and η'' from x: see `PartMotion`."""
    matrices = table.at(frozen)
    given = np.moveaxis(times.given[..., part.columns], 0, 2)
    blocks, strides = given.shape[:2]
    states = np.empty((blocks, strides + 1, state.size))
    states[:, 1:] = given.reshape(blocks, strides, -1) @ matrices.load_rows
    states[:, 1:] += matrices.constant_rows.sum(axis=1)[:, None]
    for transposed, rows in zip(matrices.propagators, states, strict=True):
        rows[0] = state
        propagate(transposed.T, rows)
        state = rows[-1]
    return states, matrices.accelerations


def propagate(propagator: FloatArray, states: FloatArray) -> None:
    """Replace row k of the states by P · row k−1 + row k, k = 1 … K, in place.

    `propagator`: P, shape (m, m), Fortran order; `states`: start in row 0, the loads of each step
    below, shape (K + 1, m), C order.
    """
    state = states[0]
    for row in states[1:]:
        # y = P x + y in one call of BLAS: alpha, a, x, beta, y, offsets, strides, no transpose,
        # overwrite y
        state = dgemv(1.0, propagator, state, 1.0, row, 0, 1, 0, 1, 0, 1)
