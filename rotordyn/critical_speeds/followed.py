"""Critical speeds of one model of an engine found again in another, from where they were."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed
from solidwhirl.rotordyn.modes.damping import log_decrement
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.modes.whirl import whirl_at_speed

# Eigenproblems at most for one of them, and its relative accuracy.
_STEPS, _ACCURACY = 12, 1e-10
# A mode further away than this (relative) is another one; one of opposite whirl counts that much.
_FARTHEST, _OPPOSITE = 0.25, 0.5


def followed_critical_speeds(
    assembled: AssembledSystem, known: Sequence[CriticalSpeed | None]
) -> list[CriticalSpeed | None]:
    """Find critical speeds of another model of an engine that are close to known ones.

    `known`: of the other model, with any excitation ratios; None stays None. Returns the same in
    this system, in their order; None where no mode is near. Im λ(Ω) = αΩ by the secant method on
    the mode that is nearest to the one before in eigenvalue and whirl: some eigenproblems for each,
    where `critical_speeds` searches the whole range. What is born or lost is not seen.
    """
    return [None if one is None else _followed(assembled, one) for one in known]


def _followed(assembled: AssembledSystem, known: CriticalSpeed) -> CriticalSpeed | None:
    ratio = 2.0 * np.pi * known.frequency_hz / known.speed_rad_s
    speed, value, whirl = known.speed_rad_s, known.eigenvalue, known.whirl
    before: tuple[float, float] | None = None
    for _ in range(_STEPS):
        modes = modes_at_speed(assembled, speed)
        directions = whirl_at_speed(assembled, modes.shapes, modes.eigenvalues, speed)
        opposite = {"forward": "backward", "backward": "forward"}.get(whirl)
        far = np.abs(modes.eigenvalues - value) / abs(value) + _OPPOSITE * (directions == opposite)
        if not far.size or far.min() > _FARTHEST:
            return None
        at = int(far.argmin())
        value = complex(modes.eigenvalues[at])
        miss = value.imag - ratio * speed
        if abs(miss) <= _ACCURACY * ratio * speed:
            shape = modes.shapes[:, at]
            return CriticalSpeed(
                speed_rad_s=speed,
                frequency_hz=ratio * speed / (2.0 * np.pi),
                whirl=str(directions[at]),
                shape=shape / shape[np.abs(shape).argmax()],
                log_decrement=float(log_decrement(np.array([value]))[0]),
            )
        slope = -ratio if before is None else (miss - before[1]) / (speed - before[0])
        if slope == 0.0:
            return None
        before, speed = (speed, miss), speed - miss / slope
        if not abs(speed - known.speed_rad_s) < _FARTHEST * known.speed_rad_s:
            return None
    return None
