"""Critical speeds of one model of an engine found again in another, from where they were."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.assembly.operator import operator_of
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed
from solidwhirl.rotordyn.modes.damping import log_decrement
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.modes.whirl import motion_at_speed
from solidwhirl.rotordyn.paths.events import met, refined

# A mode further away than this (relative) is another one; one of opposite whirl counts that much.
_FARTHEST, _OPPOSITE = 0.25, 0.5
# Roots as near as this (relative) are equal.
_EQUAL = 1e-9


def followed_critical_speeds(
    assembled: AssembledSystem, known: Sequence[CriticalSpeed | None]
) -> list[CriticalSpeed | None]:
    """Find critical speeds of another model of an engine that are close to known ones.

    `known`: of the other model, with any excitation ratios; None stays None. Returns the same in
    this system, in their order; None where no mode is near. The mode that is nearest in eigenvalue
    and whirl at the known speed is refined alone: one eigenproblem for each, where
    `critical_speeds` searches the whole range. What is born or lost is not seen.
    """
    return [None if one is None else _followed(assembled, one) for one in known]


def _followed(assembled: AssembledSystem, known: CriticalSpeed) -> CriticalSpeed | None:
    ratio, speed = 2.0 * np.pi * known.frequency_hz / known.speed_rad_s, known.speed_rad_s
    modes = modes_at_speed(assembled, speed)
    directions = motion_at_speed(assembled, modes.shapes, modes.eigenvalues, speed).whirl
    opposite = {"forward": "backward", "backward": "forward"}.get(known.whirl)
    value = known.eigenvalue
    far = np.abs(modes.eigenvalues - value) / abs(value) + _OPPOSITE * (directions == opposite)
    if not far.size or far.min() > _FARTHEST:
        return None
    at, operator = int(far.argmin()), operator_of(assembled)
    place = met(operator, speed, complex(modes.eigenvalues[at]), ratio)
    if place is None or not abs(place.speed - speed) < _FARTHEST * speed:
        return None
    speed, value = place.speed, place.value
    # of equal modes the one that looks like that at the known speed
    twins = refined(operator.at(speed, ratio * speed), value, 2)
    alike = np.abs(twins.values - value) <= _EQUAL * abs(value)
    basis = twins.right[: assembled.size, alike]
    shape = basis @ np.linalg.lstsq(basis, modes.shapes[:, at], rcond=None)[0]
    motion = motion_at_speed(assembled, shape[:, None], np.array([value]), speed)
    return CriticalSpeed(
        speed_rad_s=speed,
        frequency_hz=ratio * speed / (2.0 * np.pi),
        whirl=str(motion.whirl[0]),
        shares=motion.shares[0],
        shape=shape / shape[np.abs(shape).argmax()],
        log_decrement=float(log_decrement(np.array([value]))[0]),
    )
