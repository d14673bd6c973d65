"""Critical speeds with damping: where the roots of a system meet Im s = αΩ."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.modes.damping import CREEPING, damping_ratio
from solidwhirl.rotordyn.modes.operator_blocks import OperatorBlock, operator_blocks
from solidwhirl.rotordyn.paths.eigenvalue_paths import Event, meets_lines, speed_paths
from solidwhirl.rotordyn.paths.events import Located, met, refined

# Intervals between the speeds at which all roots are solved for at first; more where paths ask.
_INTERVALS = 2
# Below this part of the limit, and with less motion of the rotor than this, nothing is met.
_STILL, _ROTOR = 1e-9, 1e-12
# Meetings of two paths closer than this (relative) in speed and root have one pair of vectors.
_SAME = 1e-9


def met_by_excitation(assembled: AssembledSystem, ratio: float, limit: float) -> list[Located]:
    """Return where modes meet an excitation of frequency αΩ, shapes as independent coordinates.

    `ratio`, `limit`: |α|, and the largest Ω, rad/s. All roots of the system with its laws read at
    the frequency of the excitation are followed over the speed; where one meets it that is its own
    frequency, and the law is exact.
    """
    found = []
    for block in operator_blocks(assembled):
        found += _met_by_block(block, ratio, limit)
    return found


def _met_by_block(block: OperatorBlock, ratio: float, limit: float) -> list[Located]:
    operator = block.operator
    speeds = np.linspace(0.0, limit, _INTERVALS + 1).tolist()
    senses = (1.0,) if operator.is_real else (1.0, -1.0)
    lines = [sense * ratio for sense in senses]
    paths = speed_paths(operator, speeds, ratio * limit, meets_lines(lines), whirl_ratio=ratio)
    out = []
    for line in lines:
        events = paths.crossings(
            lambda speed, values, line=line: values.imag - line * speed,
            lambda _, slopes, line=line: slopes.imag - line,
        )
        for place in _located(operator, events, line, limit):
            shape = block.lift @ place.right
            if np.abs(shape).max() > _ROTOR * np.abs(place.right).max():
                if line < 0:
                    shape = shape.conj()
                value = complex(place.value.real, abs(place.value.imag))
                out.append(place._replace(value=value, right=shape))
    return out


def _located(
    operator: SecondOrder, events: list[Event], line: float, limit: float
) -> list[Located]:
    found: list[tuple[int, Located]] = []
    for event in events:
        if event.at <= _STILL * limit:
            continue
        place = met(operator, event.at, event.value, line)
        if place is None or not _STILL * limit < place.speed <= limit * (1.0 + _STILL):
            continue
        alike = [path for path, other in found if _is_one(place, other)]
        creeps = damping_ratio(np.array([place.value]))[0] > CREEPING
        if not creeps and event.path not in alike:
            found.append((event.path, place))
    out = []
    for path, place in found:
        equal = [number for number, other in found if _is_one(place, other)]
        if len(equal) > 1:
            triple = operator.at(place.speed, abs(line) * place.speed)
            right = refined(triple, place.value, len(equal)).right[:, equal.index(path)]
            place = place._replace(right=right)
        out.append(place)
    return out


def _is_one(one: Located, other: Located) -> bool:
    near = abs(one.speed - other.speed) <= _SAME * one.speed
    return near and abs(one.value - other.value) <= _SAME * abs(one.value)
