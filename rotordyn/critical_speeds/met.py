"""Critical speeds of systems whose bearings depend on the frequency: roots with Im s = αΩ."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.operator import operator_of
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.critical_speeds.refined import Meeting
from solidwhirl.rotordyn.modes.damping import CREEPING, damping_ratio
from solidwhirl.rotordyn.paths.eigenvalue_paths import speed_paths
from solidwhirl.rotordyn.paths.events import met, refined

# Speeds at which all roots are solved for at first; more where paths ask for it.
_SPEEDS = 9
# Below this part of the limit, and with less motion of the rotor than this, nothing is met.
_STILL, _ROTOR = 1e-9, 1e-12
# Meetings of two paths closer than this (relative) in speed and root have one pair of vectors.
_SAME = 1e-9


def met_with_laws(assembled: AssembledSystem, ratio: float, limit: float) -> list[Meeting]:
    """Return where modes meet an excitation of frequency αΩ.

    `ratio`, `limit`: |α|, and the largest Ω, rad/s. All roots of the system with its laws read at
    the frequency of the excitation are followed over the speed; where one meets it that is its own
    frequency, and the law is exact.
    """
    operator = operator_of(assembled)
    speeds = np.linspace(0.0, limit, _SPEEDS).tolist()
    paths = speed_paths(operator, speeds, ratio * limit, whirl_ratio=ratio)
    events = paths.crossings(
        lambda speed, values: values.imag - ratio * speed, lambda _, slopes: slopes.imag - ratio
    )
    found: list[tuple[int, Meeting]] = []
    for event in events:
        place = met(operator, event.at, event.value, ratio)
        if place is None or not _STILL * limit < place.speed <= limit * (1.0 + _STILL):
            continue
        meeting = Meeting(place.speed, place.value, place.right)
        alike = [path for path, other in found if _is_one(meeting, other)]
        creeps = damping_ratio(np.array([place.value]))[0] > CREEPING
        if not creeps and event.path not in alike:
            found.append((event.path, meeting))
    meetings = []
    for path, meeting in found:
        equal = [number for number, other in found if _is_one(meeting, other)]
        speed, value, shape = meeting
        if len(equal) > 1:
            triple = operator.at(speed, ratio * speed)
            shape = refined(triple, value, len(equal)).right[:, equal.index(path)]
        if np.abs(shape[: assembled.size]).max() > _ROTOR * np.abs(shape).max():
            meetings.append(Meeting(speed, value, shape[: assembled.size]))
    return meetings


def _is_one(one: Meeting, other: Meeting) -> bool:
    near = abs(one.speed - other.speed) <= _SAME * one.speed
    return near and abs(one.value - other.value) <= _SAME * abs(one.value)
