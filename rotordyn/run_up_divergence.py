"""Where a run-up diverges: motion grows and has outgrown the machine."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.damping import NEUTRAL
from solidwhirl.rotordyn.eigen import modes_at_speed
from solidwhirl.rotordyn.run_up_blocks import Block, RunPlan
from solidwhirl.rotordyn.run_up_record import Divergence
from solidwhirl.rotordyn.speed_profile import SpeedProfile
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.whirl import interface_rows_of_all, rotor_length


class Watch:
    """Look at the blocks of a run for motion that grows beyond the size of the machine.

    A linear system has no other end: below, its displacement may be wrong, but is not absurd.

    Parameters
    ----------
    plan
        The run.
    """

    def __init__(self, plan: RunPlan) -> None:
        self._plan = plan
        assembled = plan.basis.assembled
        moved = interface_rows_of_all(assembled).reshape(-1, 6, assembled.size)[:, :3]
        self._rows = moved.reshape(-1, assembled.size) @ plan.basis.displacement
        self._limit = rotor_length(assembled)

    def divergence(self, block: Block) -> tuple[Block, Divergence] | None:
        """Return a block up to the step at which the run has diverged; None if it has not."""
        # one instant tells it: what has not outgrown the machine at the end has not before
        if self._largest(block.states[-1:])[0] <= self._limit:
            return None
        if not _grows(self._plan.basis.assembled, block.frozen_speed_rad_s):
            return None
        sizes = self._largest(block.states)
        last = max(int(np.flatnonzero(~(sizes <= self._limit))[0]), 1)
        cut = block._replace(
            speeds_rad_s=block.speeds_rad_s[: last + 1],
            states=block.states[: last + 1],
            amplitudes=block.amplitudes[: last + 1],
        )
        return cut, Divergence(
            time_s=(block.first_step + last) * self._plan.step_s,
            speed_rad_s=float(block.speeds_rad_s[last]),
            amplitude_m=float(sizes[last]),
            limit_m=self._limit,
        )

    def _largest(self, states: FloatArray) -> FloatArray:
        motion = states[:, : self._plan.basis.size] @ self._rows.T
        return np.asarray(np.abs(motion).max(axis=1, initial=0.0))


def shortened(profile: SpeedProfile, time_s: float) -> SpeedProfile:
    """Return a profile up to a time, s."""
    before = profile.times_s[profile.times_s < time_s]
    times = np.append(before, time_s)
    return SpeedProfile(times_s=times, speeds_rad_s=profile.speed_rad_s(times))


def _grows(assembled: AssembledSystem, speed_rad_s: float) -> bool:
    modes = modes_at_speed(assembled, speed_rad_s)
    values = np.concatenate((modes.eigenvalues, modes.real_eigenvalues.astype(complex)))
    return bool((values.real > NEUTRAL * np.abs(values)).any())
