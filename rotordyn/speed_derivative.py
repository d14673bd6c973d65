"""How the matrices of a system change with the speed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.system import AssembledSystem

# Step of the central difference of a speed law, relative to the speed and at least, rad/s.
_STEP = 1e-5
_SMALLEST_STEP = 1e-3


class SpeedDerivative(NamedTuple):
    """Derivatives of C + ΩG and of K with respect to Ω, each (n, n)."""

    velocity: FloatArray
    stiffness: FloatArray

    def at_rate(self, rate: complex) -> ComplexArray:
        """Return ∂D/∂Ω at a fixed s."""
        return np.asarray(self.stiffness + rate * self.velocity)


def speed_derivative(assembled: AssembledSystem, speed_rad_s: float) -> SpeedDerivative:
    """Return the derivatives of the matrices of a system with respect to the speed.

    Parameters
    ----------
    assembled
        The system.
    speed_rad_s
        Ω, rad/s.

    Returns
    -------
    SpeedDerivative
        G and 2 Ω K2 + N, plus the slopes of bearings with a speed law by central differences (at
        a corner of a table the mean of both sides).
    """
    stiffness = 2.0 * speed_rad_s * assembled.centrifugal_stiffness
    stiffness = stiffness + assembled.circulatory_stiffness
    velocity = assembled.gyroscopic
    step = max(_STEP * abs(speed_rad_s), _SMALLEST_STEP)
    for joint in assembled.law_joints:
        below, above = (joint.coefficients(speed_rad_s + side * step) for side in (-1.0, 1.0))
        slopes = [(b - a) / (2.0 * step) for a, b in zip(below, above, strict=True)]
        stiffness = stiffness + joint.motion.T @ slopes[0] @ joint.motion
        velocity = velocity + joint.motion.T @ slopes[1] @ joint.motion
    return SpeedDerivative(velocity=np.asarray(velocity), stiffness=np.asarray(stiffness))
