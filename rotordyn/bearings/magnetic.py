"""Active magnetic bearings, linear about their bias."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.bearings.controllers import Controller
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MagneticBearing:
    """A magnetic bearing on (ux, uy): force = ks u + ki i, i = −H(s) y of the sensors.

    `current_stiffness_n_per_a`: ki; `negative_stiffness_n_per_m`: ks > 0, by which the bias pulls
    the rotor outward; `controller`: H from displacement (m) at the sensors to current (A), two
    signals in and out, amplifiers, filters and delays included.

    Schweitzer and Maslen (2009), Magnetic Bearings, chapters 4 and 8.
    """

    current_stiffness_n_per_a: float
    negative_stiffness_n_per_m: float
    controller: Controller

    def __post_init__(self) -> None:
        problems = []
        if self.controller.d.shape != (2, 2):
            problems.append(f"its controller is {self.controller.d.shape}; needed is (2, 2)")
        if not 0 < abs(self.current_stiffness_n_per_a) < np.inf:
            problems.append("current_stiffness_n_per_a must be finite and not 0")
        if not 0 <= self.negative_stiffness_n_per_m < np.inf:
            problems.append("negative_stiffness_n_per_m must be 0 or more")
        if problems:
            raise AnalysisError("magnetic bearing: " + "; ".join(problems))

    def sensor_stiffness(self, eigenvalue: complex) -> ComplexArray:
        """Return ki H(s), shape (2, 2): force at the magnet per motion at the sensors, negative."""
        return self.current_stiffness_n_per_a * self.controller.response(eigenvalue)

    def slow_stiffness(self) -> tuple[FloatArray, FloatArray]:
        """Return ki H and its derivative by s for slow motions, see `Controller.slow_gain`."""
        gain, slope = self.controller.slow_gain()
        return self.current_stiffness_n_per_a * gain, self.current_stiffness_n_per_a * slope

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z, shape (2, 2), of a bearing whose sensors are at the magnets."""
        held = self.negative_stiffness_n_per_m * np.eye(2)
        return self.sensor_stiffness(rate) - held
