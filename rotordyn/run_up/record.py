"""What a run-up leaves behind: motion, forces and energy over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.core.arrays import FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.reprs import lines_of, row
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MotionState(ReadOnlyArrays):
    """Hold displacement and velocity in the independent coordinates of a system.

    `displacement`: q, shape (n,), m and rad; `velocity`: q', shape (n,), m/s and rad/s.
    """

    displacement: FloatArray
    velocity: FloatArray

    def of_size(self, size: int) -> MotionState:
        """Return the state, or refuse one that is not of n finite numbers (AnalysisError)."""
        for name in ("displacement", "velocity"):
            value = getattr(self, name)
            if value.shape != (size,) or not np.isfinite(value).all():
                raise AnalysisError(
                    f"{name} of the initial state has shape {value.shape}; {size} finite numbers "
                    "are needed"
                )
        return self


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class EnergyBalance(ReadOnlyArrays):
    """Hold the energy of a system over time and the work that changed it.

    `stored_j`: ½ q'ᵀMq' + ½ qᵀ(K + Ω²K2)q with the symmetric part of all stiffness, shape (s,), J;
    `load_work_j`: work of unbalance, gravity and drive torque since time 0, shape (s,);
    `drive_work_j`: work of what keeps the shafts at speed, through −½Ω'G q, circulatory and
    cross-coupled stiffness, and stiffness that changes with the speed, shape (s,); `dissipated_j`:
    energy lost to damping since time 0, shape (s,).
    """

    stored_j: FloatArray
    load_work_j: FloatArray
    drive_work_j: FloatArray
    dissipated_j: FloatArray

    @property
    def error_j(self) -> FloatArray:
        """Change of stored energy less all work plus losses, shape (s,); 0 for exact motion.

        The works are integrated by the trapezoidal rule over the steps, so this is also of
        second order in the step.
        """
        change = self.stored_j - self.stored_j[0]
        return np.asarray(change - self.load_work_j - self.drive_work_j + self.dissipated_j)


@dataclass(frozen=True, kw_only=True)
class Divergence:
    """Hold where a run-up was stopped.

    `time_s`, `speed_rad_s`: when, and Ω of the reference shaft then; `amplitude_m`: largest
    displacement of an interface along an axis, m; `limit_m`: size of the machine that it exceeds:
    the length of its longest body, m.
    """

    time_s: float
    speed_rad_s: float
    amplitude_m: float
    limit_m: float


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RunUp:
    """Hold the record of a run-up at s times.

    `profile`: Ω(t); `speed_ratios`: of each body by name; `unbalances`: what excited it; `step_s`:
    of the integration, s; `longest_block`: most steps that shared one frozen speed while it
    changed; `time_s`, `speed_rad_s`, `angle_rad`: time, Ω and ∫Ω dt, shape (s,); `outputs`:
    interfaces whose motion is recorded, o of them. `translation_m`, `rotation_rad`: ux, uy, uz and
    rx, ry, rz, shape (o, 3, s); zero where an interface has no such component. `velocity_m_per_s`,
    `angular_velocity_rad_per_s`: their rates, shape (o, 3, s); `bearings`: names of the bearings
    whose force is recorded, b of them; `force_n`, `moment_n_m`: what the first side of each exerts
    on its second (on the ground without one), along and about x, y, z, shape (b, 3, s); `energy`:
    balance of the energy; `final`: state at the last step, from which another run may start;
    `notes`: doubts about validity, one sentence each; `balance_error`: largest force that is left
    over at some of the records, over the largest force there, in the system straight from its
    parts; None where it was not looked at. `stopped`: where the run diverged and was stopped; None
    if it went on to the end. `wall_time_s`: of the integration, also where the run of another model
    did some of it.
    """

    profile: SpeedProfile
    speed_ratios: Mapping[str, float]
    unbalances: tuple[Unbalance, ...]
    step_s: float
    longest_block: int
    time_s: FloatArray
    speed_rad_s: FloatArray
    angle_rad: FloatArray
    outputs: tuple[End, ...]
    translation_m: FloatArray
    rotation_rad: FloatArray
    velocity_m_per_s: FloatArray
    angular_velocity_rad_per_s: FloatArray
    bearings: tuple[str, ...]
    force_n: FloatArray
    moment_n_m: FloatArray
    energy: EnergyBalance
    final: MotionState
    notes: tuple[str, ...]
    wall_time_s: float
    balance_error: float | None = None
    stopped: Divergence | None = None

    def __post_init__(self) -> None:
        # read-only in place: the arrays are long and belong to nobody else
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __repr__(self) -> str:
        pull = np.linalg.norm(self.force_n[:, :2], axis=1)
        forces = [
            f"{name}: largest force {force.max():.4g} N at {self.time_s[force.argmax()]:.4g} s"
            for name, force in zip(self.bearings, pull, strict=True)
            if force.size
        ]
        rpm = self.speed_rad_s * RPM_PER_RAD_S
        places = row(end.label for end in self.outputs) or "none"
        head = (
            f"RunUp: {self.time_s[-1] - self.time_s[0]:.4g} s, {rpm[0]:.6g} to {rpm[-1]:.6g} rpm, "
            f"{self.time_s.size} records of {places}"
        )
        return lines_of(head, forces)

    @property
    def sample_rate_hz(self) -> float:
        """Records per second."""
        return float((self.time_s.size - 1) / (self.time_s[-1] - self.time_s[0]))

    def bearing_force_n(self, bearing: str) -> FloatArray:
        """Return the force through a bearing along x, y, z.

        Returns shape (3, s), N. Raises AnalysisError if its force was not recorded.
        """
        if bearing not in self.bearings:
            raise AnalysisError(
                f"the force of bearing {bearing!r} was not recorded; there are "
                f"{list(self.bearings)}"
            )
        return np.asarray(self.force_n[self.bearings.index(bearing)])
