"""Time stepping of a run-up in blocks of steps that share one frozen speed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dgemv

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.run_up_basis import ModalBasis
from solidwhirl.rotordyn.run_up_loads import TurningLoads
from solidwhirl.rotordyn.run_up_steps import (
    FrequencyRates,
    StepMatrices,
    block_length,
    frequency_rates,
    step_table,
)
from solidwhirl.rotordyn.speed_profile import SpeedProfile

# Steps of a block at constant speed; bounds memory only.
_LONGEST = 1024
# A breakpoint may miss a step by this fraction of it, and a step may be an angle up to this.
_ON_STEP = 1e-6
_LARGEST_ANGLE = 1.0


class RunPlan(NamedTuple):
    """All that a run needs.

    Attributes
    ----------
    basis
        Of the state.
    profile
        Ω(t).
    turning
        Unbalance.
    steady
        Load that never changes on the stacked coordinates, shape (N,).
    torsion
        Load per unit Ω' on the stacked coordinates, shape (N,).
    step_s
        h.
    phase_error_rad
        See `run_up_steps.block_length`.
    """

    basis: ModalBasis
    profile: SpeedProfile
    turning: TurningLoads
    steady: FloatArray
    torsion: FloatArray
    step_s: float
    phase_error_rad: float

    def modal(self, columns: FloatArray) -> FloatArray:
        """Return stacked loads on the modes, (n, ...) from (N, ...)."""
        transformation = self.basis.assembled.transformation
        return np.asarray(self.basis.shapes.T @ (transformation.T @ columns))


class Block(NamedTuple):
    """K steps with one frozen speed.

    Attributes
    ----------
    first_step
        Number of the step at which it begins.
    frozen_speed_rad_s, acceleration_rad_s2
        Ω in its middle, and Ω'.
    speeds_rad_s
        Ω at its K + 1 times.
    states
        x at its K + 1 times, shape (K + 1, 2n).
    amplitudes
        Factors of the unbalance columns, shape (K + 1, c).
    constant
        Loads that stay, on the stacked coordinates, shape (N,).
    modal_constant
        The same on the modes, shape (n,).
    rates
        η'' from x without loads, shape (n, 2n).
    """

    first_step: int
    frozen_speed_rad_s: float
    acceleration_rad_s2: float
    speeds_rad_s: FloatArray
    states: FloatArray
    amplitudes: FloatArray
    constant: FloatArray
    modal_constant: FloatArray
    rates: FloatArray


class _Piece(NamedTuple):
    """A linear piece of the profile in whole steps."""

    first_step: int
    last_step: int
    speeds: tuple[float, float]
    acceleration: float
    start_angle: float


def blocks(plan: RunPlan, state: FloatArray) -> Iterator[Block]:
    """Run through the profile.

    Parameters
    ----------
    plan
        What to do.
    state
        x at time 0, shape (2n,).

    Yields
    ------
    Block
        In order, the last state of one being the first of the next.

    Raises
    ------
    AnalysisError
        If the step does not fit the profile, the unbalance or the acceleration.
    """
    pieces = _pieces(plan)
    speeds = plan.profile.speeds_rad_s
    rates = frequency_rates(plan.basis, float(speeds.min()), float(speeds.max()))
    loads = plan.modal(plan.turning.columns)
    for piece in pieces:
        for block in _piece_blocks(plan, piece, rates, loads, state):
            yield block
            state = block.states[-1]


def step_count(plan: RunPlan) -> int:
    """Return the number of steps of the whole profile."""
    return _pieces(plan)[-1].last_step


def _pieces(plan: RunPlan) -> list[_Piece]:
    """Cut the profile into pieces of whole steps, refusing a step that does not fit."""
    h, profile = plan.step_s, plan.profile
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
    fastest *= float(np.abs(plan.turning.ratios).max(initial=0.0))
    if fastest * h > _LARGEST_ANGLE:
        raise AnalysisError(
            f"step_s is {h:.6g}, in which a body with unbalance turns by {fastest * h:.3g} rad; "
            f"take a step of at most {_LARGEST_ANGLE / fastest:.3g} s"
        )
    speeds = profile.speeds_rad_s.tolist()
    angles = profile.angle_rad(profile.times_s).tolist()
    slopes = profile.accelerations_rad_s2.tolist()
    return [
        _Piece(int(whole[i]), int(whole[i + 1]), (speeds[i], speeds[i + 1]), slopes[i], angles[i])
        for i in range(len(slopes))
    ]


def _piece_blocks(
    plan: RunPlan, piece: _Piece, rates: FrequencyRates, loads: FloatArray, state: FloatArray
) -> Iterator[Block]:
    """Run through one linear piece of the profile."""
    h = plan.step_s
    constant = plan.steady + piece.acceleration * plan.torsion
    modal_constant = plan.modal(constant)
    longest = block_length(rates, piece.speeds, piece.acceleration, h, plan.phase_error_rad)
    width = abs(piece.acceleration) * h * min(longest, _LONGEST)
    table = step_table(
        plan.basis, loads, modal_constant[:, None], h, piece.acceleration, piece.speeds, width
    )
    size = int(min(longest, _LONGEST))
    fixed = table.at(piece.speeds[0])
    for first in range(piece.first_step, piece.last_step, size):
        last = min(first + size, piece.last_step)
        since = h * (np.arange(first, last + 1) - piece.first_step)
        speeds = piece.speeds[0] + piece.acceleration * since
        angles = piece.start_angle + 0.5 * (piece.speeds[0] + speeds) * since
        middle = 0.5 * float(speeds[0] + speeds[-1])
        matrices = fixed if piece.acceleration == 0 else table.at(middle)
        values, changes = plan.turning.amplitudes(angles, speeds, piece.acceleration)
        states = _stepped(matrices, state, values, h * changes)
        yield Block(
            first_step=first,
            frozen_speed_rad_s=middle,
            acceleration_rad_s2=piece.acceleration,
            speeds_rad_s=speeds,
            states=states,
            amplitudes=values,
            constant=constant,
            modal_constant=modal_constant,
            rates=matrices.acceleration,
        )
        state = states[-1]


def _stepped(
    matrices: StepMatrices, state: FloatArray, values: FloatArray, changes: FloatArray
) -> FloatArray:
    """Return the states of a block from its first one and its loads, (K + 1, 2n)."""
    ends = (values[:-1], values[1:], changes[:-1], changes[1:])
    states = np.empty((values.shape[0], state.size))
    states[0] = state
    states[1:] = np.hstack(ends) @ matrices.load_rows + matrices.constant_rows.sum(axis=0)
    propagate(matrices.propagator, states)
    return states


def propagate(propagator: FloatArray, states: FloatArray) -> None:
    """Replace row k of the states by P · row k−1 + row k, k = 1 … K, in place.

    Parameters
    ----------
    propagator
        P, shape (m, m), Fortran order.
    states
        Start in row 0, the loads of each step below, shape (K + 1, m), C order.
    """
    state = states[0]
    for row in states[1:]:
        # y = P x + y in one call of BLAS: alpha, a, x, beta, y, offsets, strides, no transpose,
        # overwrite y
        state = dgemv(1.0, propagator, state, 1.0, row, 0, 1, 0, 1, 0, 1)
