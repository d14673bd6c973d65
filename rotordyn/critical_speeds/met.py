"""Critical speeds with damping: where the roots of a system meet Im s = αΩ."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.modes.damping import CREEPING, damping_ratio
from solidwhirl.rotordyn.modes.operator_blocks import OperatorBlock, operator_blocks
from solidwhirl.rotordyn.paths.eigenvalue_paths import (
    EigenvaluePaths,
    Node,
    Wanted,
    meets_lines,
    speed_paths,
)
from solidwhirl.rotordyn.paths.events import Located, met, refined

# Intervals between the speeds at which all roots are solved for at first; more where paths ask.
_INTERVALS = 2
# How often a stretch is halved in which fewer or more roots meet the line than its ends tell.
_HALVINGS = 12
# Below this part of the limit, and with less motion of the rotor than this, nothing is met.
_STILL, _ROTOR = 1e-9, 1e-12
# Meetings closer than this (relative) in speed and root are one, or as many as there are vectors.
_SAME = 1e-9
# Part of a stretch at its ends that is not looked at where its ends tell how many roots meet.
_RIM = 1e-7


def met_by_excitation(assembled: AssembledSystem, ratio: float, limit: float) -> list[Located]:
    """Return where modes meet an excitation of frequency αΩ, shapes in independent coordinates.

    `ratio`, `limit`: |α|, and the largest Ω, rad/s. All roots of the system with its laws read at
    the frequency of the excitation are followed over the speed; where one meets it that is its own
    frequency, and the law is exact. How many meet it between two speeds is known from the roots
    there. Raises AnalysisError if it is not the number that is found.
    """
    return [
        found
        for block in operator_blocks(assembled)
        for found in _met_by_block(block, ratio, limit)
    ]


def _met_by_block(block: OperatorBlock, ratio: float, limit: float) -> list[Located]:
    """Return where the motions of a block meet the line, forward and backward."""
    operator = block.operator
    lines = (ratio,) if operator.is_real else (ratio, -ratio)
    speeds = np.linspace(0.0, limit, _INTERVALS + 1).tolist()
    wanted = meets_lines(lines)
    paths = speed_paths(operator, speeds, ratio * limit, wanted, whirl_ratio=ratio)
    for _ in range(_HALVINGS):
        places = {line: _places(operator, paths, line) for line in lines}
        doubtful = [
            stretch
            for stretch in paths.stretches
            if any(_disagrees(stretch, wanted, *found) for found in places.items())
        ]
        if not doubtful:
            break
        paths = paths.halved(doubtful)
    else:
        raise AnalysisError(
            f"critical speeds between {doubtful[0][0].at:.6g} and {doubtful[0][1].at:.6g} rad/s "
            "can't be told apart; change the speeds or the bearings a little"
        )
    out = []
    for line, found in places.items():
        for place in found:
            shape = block.lift @ place.right
            creeps = damping_ratio(np.array([place.value]))[0] > CREEPING
            if creeps or np.abs(shape).max() <= _ROTOR * np.abs(place.right).max():
                continue
            turned = (place.value, shape) if line > 0 else (place.value.conjugate(), shape.conj())
            out.append(place._replace(value=turned[0], right=turned[1]))
    return [place for place in out if place.speed <= limit * (1.0 + _STILL)]


def _places(operator: SecondOrder, paths: EigenvaluePaths, line: float) -> list[Located]:
    """Return where roots are on the line Im s = αΩ, equal ones with vectors of their own."""
    events = paths.crossings(
        lambda speed, values: values.imag - line * speed, lambda _, slopes: slopes.imag - line
    )
    least = _STILL * paths.nodes[-1].at
    groups: list[dict[int, Located]] = []
    for event in events:
        place = met(operator, event.at, event.value, line) if event.at > least else None
        if place is None or place.speed <= least:
            continue
        group = next((g for g in groups if _is_one(place, *list(g.values())[:1])), None)
        if group is None:
            groups.append({event.path: place})
        else:
            group.setdefault(event.path, place)
    out = []
    for group in groups:
        first = next(iter(group.values()))
        if len(group) == 1:
            out.append(first)
            continue
        triple = operator.at(first.speed, abs(line) * first.speed)
        found = refined(triple, first.value, len(group))
        equal = np.abs(found.values - first.value) <= _SAME * abs(first.value)
        each = zip(group.values(), found.right[:, equal].T, strict=False)
        out += [place._replace(right=right) for place, right in each]
    return out


def _is_one(one: Located, other: Located) -> bool:
    near = abs(one.speed - other.speed) <= _SAME * one.speed
    return near and abs(one.value - other.value) <= _SAME * abs(one.value)


def _disagrees(
    stretch: tuple[Node, Node], wanted: Wanted, line: float, places: list[Located]
) -> bool:
    """Whether the roots above the line change by others than those that meet it in between."""
    first, second = stretch
    rim = _RIM * (second.at - first.at)
    followed = wanted(first, second)
    low, high = (
        (node.values + side * rim * node.slopes).imag[followed] > line * (node.at + side * rim)
        for node, side in ((first, 1.0), (second, -1.0))
    )
    inside = [p.rate for p in places if first.at + rim < p.speed <= second.at - rim]
    return int(high.sum() - low.sum()) != int(np.sign(inside).sum())
