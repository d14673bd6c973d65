"""How the matrices of a system change with the speed."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.system import AssembledSystem, LawJoint

# Step of the central difference of a law without known pieces, relative to the speed and at least,
# rad/s.
_STEP = 1e-5
_SMALLEST_STEP = 1e-3

Side = Literal["below", "above", "both"]


class SpeedDerivative(NamedTuple):
    """Derivatives of C + ΩG and of K with respect to Ω, each (n, n)."""

    velocity: FloatArray
    stiffness: FloatArray

    def at_rate(self, rate: complex) -> ComplexArray:
        """Return ∂D/∂Ω at a fixed s."""
        return np.asarray(self.stiffness + rate * self.velocity)


def speed_derivative(
    assembled: AssembledSystem, speed_rad_s: float, side: Side = "both"
) -> SpeedDerivative:
    """Return the derivatives of the matrices of a system with respect to the speed.

    Parameters
    ----------
    assembled
        The system.
    speed_rad_s
        Ω, rad/s.
    side
        At a corner of a table the slope below or above the speed, or the mean of both.

    Returns
    -------
    SpeedDerivative
        G and 2 Ω K2 + N, plus the slopes of bearings with a speed law; of a law without known
        pieces by central differences.
    """
    stiffness = 2.0 * speed_rad_s * assembled.centrifugal_stiffness
    stiffness = stiffness + assembled.circulatory_stiffness
    velocity = assembled.gyroscopic
    for joint in assembled.law_joints:
        slopes = _slopes(joint, speed_rad_s, side)
        stiffness = stiffness + joint.motion.T @ slopes[0] @ joint.motion
        velocity = velocity + joint.motion.T @ slopes[1] @ joint.motion
    return SpeedDerivative(velocity=np.asarray(velocity), stiffness=np.asarray(stiffness))


def _slopes(joint: LawJoint, speed: float, side: Side) -> tuple[FloatArray, FloatArray]:
    """Return dk/dΩ and dc/dΩ, (2, 2) each."""
    if joint.pieces is None:
        step = max(_STEP * abs(speed), _SMALLEST_STEP)
        ends = [joint.coefficients(speed + sign * step) for sign in (-1.0, 1.0)]
        below = above = [(b - a) / (2.0 * step) for a, b in zip(*ends, strict=True)]
    else:
        below, above = ([*slopes] for slopes in joint.pieces.slopes(abs(speed)))
        # a law goes by |Ω|
        if speed < 0:
            below, above = [-part for part in above], [-part for part in below]
        elif speed == 0:
            below = [-part for part in above]
    weights = {"below": (1.0, 0.0), "above": (0.0, 1.0), "both": (0.5, 0.5)}[side]
    stiffness, damping = (
        weights[0] * a + weights[1] * b for a, b in zip(below, above, strict=True)
    )
    return stiffness, damping
