"""Ranges of speeds in which a motion grows: where roots cross the imaginary axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.core.spectrum import Spectrum, spectrum
from solidwhirl.rotordyn.modes.damping import NEUTRAL
from solidwhirl.rotordyn.modes.operator_blocks import operator_blocks
from solidwhirl.rotordyn.paths.eigenvalue_paths import grows_below, speed_paths
from solidwhirl.rotordyn.paths.events import neutral, refined
from solidwhirl.rotordyn.paths.frequency_paths import Change, growth_changes
from solidwhirl.rotordyn.paths.frequency_roots import FrequencyRoot, frequency_roots, root_near

# Speeds at which all roots are solved for at first; more where paths ask for it.
_SPEEDS = 9
# Changes of growth closer than this (relative to the range) are one.
_SAME = 1e-9
# Accuracy (relative) to which a change is bracketed that no path shows.
_ENDS = 1e-12
# Distance (relative to the range) at which a crossing shows on both sides.
_BESIDE = 1e-6
# Halvings towards where growth ends that is hidden by rounding.
_HALVINGS = 60
# Steps from a root to the one that it becomes at another speed.
_FOLLOWED = 8


class Window(NamedTuple):
    """A range of speeds in which something grows, and the eigenvalues at its ends and top.

    `opens` and `closes` tell whether growth begins and ends there; else the range searched does.
    """

    low: float
    high: float
    opens: bool
    closes: bool
    onset: complex
    end: complex
    top: complex
    top_speed: float


#: The root that grows most at a speed, −inf if there is none.
MostGrowing = Callable[[float], complex]
#: The root at a speed that is next to another one.
NearRoot = Callable[[float, complex], complex]
#: Where a root beside a speed crosses the imaginary axis, None if it does not.
Crossing = Callable[[float, complex], Change | None]


def unstable_windows(assembled: AssembledSystem, low: float, high: float) -> list[Window]:
    """Find the ranges of speeds in which a motion of the system grows.

    `low`, `high`: range of Ω, rad/s. All roots that may come to the imaginary axis are followed
    over the speed; where one crosses it, or a pair is born or ends beyond it, growth may begin or
    end, and all roots between two such speeds say whether something grows there. Roots of index −1
    are left out: see `frequency_roots`.
    """
    found = [_of_block(block.operator, low, high) for block in operator_blocks(assembled)]
    return [window for windows in found for window in windows]


def _of_block(operator: SecondOrder, low: float, high: float) -> list[Window]:
    speeds = np.linspace(low, high, _SPEEDS).tolist()
    if operator.frequency_knots:
        changes, nodes = growth_changes(operator, speeds)
        roots = {node.speed: node.roots for node in nodes}

        def near_root(speed: float, start: complex) -> complex:
            found = root_near(operator, speed, start)
            return start if found is None else found.value

        return _windows(
            changes,
            [*roots],
            lambda speed: _of_roots(operator, speed, roots),
            near_root,
            lambda *_: None,
        )
    top = _highest(operator, low, high)
    if top == 0.0:
        return []
    wanted = grows_below(top, is_real=operator.is_real)
    paths = speed_paths(operator, speeds, top, wanted, growth=True)

    def most(speed: float) -> complex:
        return _of_spectrum(paths.at(speed))

    def near(speed: float, start: complex) -> complex:
        triple = operator.at(speed)
        for _ in range(_FOLLOWED):
            before, start = start, complex(refined(triple, start).values[0])
            if abs(start - before) <= _SAME * abs(start):
                break
        return start

    def crossing(speed: float, value: complex) -> Change | None:
        found = neutral(operator, speed, value)
        if found is None or not low <= found.speed <= high:
            return None
        # undamped roots have no real part at all, and what grows like the root of a distance none
        # that changes its sign: on both sides the real part is that of the slope
        width = _BESIDE * (high - low)
        for place in (found.speed - width, found.speed + width):
            expected = found.rate * (place - found.speed)
            beside = near(place, found.value).real if low <= place <= high else expected
            if not abs(beside - expected) < 0.5 * abs(expected):
                return None
        return Change(found.speed, found.value, is_birth=False)

    events = paths.crossings(lambda _, values: _excess(values), lambda _, slopes: slopes.real)
    met = [change for event in events if (change := crossing(event.at, event.value)) is not None]
    return _windows(met, [node.at for node in paths.nodes], most, near, crossing)


def _highest(operator: SecondOrder, low: float, high: float) -> float:
    """Return a frequency above all modes in a range of speeds, rad/s."""
    ends = (spectrum(operator, speed).values.imag for speed in (low, high))
    return 2.0 * max(float(np.abs(values).max()) for values in ends)


def _of_roots(
    operator: SecondOrder, speed: float, known: Mapping[float, Sequence[FrequencyRoot]]
) -> complex:
    """Return the root of index 1, or the real one, that grows most."""
    roots = known.get(speed) or frequency_roots(operator, speed)
    still = spectrum(operator, speed, 0.0).values
    values = [root.value for root in roots if root.sign > 0]
    values += [complex(value) for value in still if value.imag == 0 and value != 0]
    return max(values, key=_excess, default=complex(-np.inf))


def _of_spectrum(found: Spectrum) -> complex:
    """Return the root that grows most; growth that may be rounding is none."""
    values = found.values[found.values != 0]
    seen = values.real > found.uncertainty[found.values != 0]
    values = np.where(seen, values, np.minimum(values.real, 0.0) + 1j * values.imag)
    return complex(values[np.argmax(_excess(values))]) if values.size else complex(-np.inf)


def _excess(value: Any) -> Any:
    return value.real - NEUTRAL * np.abs(value)


def _windows(
    changes: Sequence[Change],
    nodes: Sequence[float],
    most: MostGrowing,
    near: NearRoot,
    crossing: Crossing,
) -> list[Window]:
    """Return the ranges between changes in which the root that grows most does grow."""
    low, high = nodes[0], nodes[-1]
    # the same change may be found on two paths, as of both planes of an isotropic rotor
    apart: list[Change] = []
    unseen = _unseen(changes, nodes, most, near, crossing)
    for change in sorted([*changes, *unseen], key=lambda one: one.speed):
        if not apart or change.speed - apart[-1].speed > _SAME * (high - low):
            apart.append(change)
    ends = [low, *(change.speed for change in apart), high]
    windows: list[Window] = []
    for place, (begin, end) in enumerate(pairwise(ends)):
        # ends of the range too, but no places where growth begins or ends
        around = [speed for speed in nodes if begin <= speed <= end]
        inside = [speed for speed in around if speed not in ends[1:-1]] or [0.5 * (begin + end)]
        tops = {speed: most(speed) for speed in inside}
        at = max(tops, key=lambda speed: _excess(tops[speed]))
        if _excess(tops[at]) <= 0:
            continue
        at, top = _largest(near, inside, at, tops[at], begin, end)
        opens, closes = place > 0, place < len(apart)
        window = Window(
            low=begin,
            high=end,
            opens=opens,
            closes=closes,
            onset=apart[place - 1].value if opens else most(begin),
            end=apart[place].value if closes else most(end),
            top=top,
            top_speed=at,
        )
        if windows and windows[-1].high == begin:
            before = windows.pop()
            higher = max(before, window, key=lambda one: one.top.real)
            window = window._replace(
                low=before.low,
                opens=before.opens,
                onset=before.onset,
                top=higher.top,
                top_speed=higher.top_speed,
            )
        windows.append(window)
    return windows


def _unseen(
    changes: Sequence[Change],
    nodes: Sequence[float],
    most: MostGrowing,
    near: NearRoot,
    crossing: Crossing,
) -> Iterator[Change]:
    """Yield where growth begins or ends between two nodes that no change lies between."""
    for first, second in pairwise(nodes):
        if any(first <= change.speed <= second for change in changes):
            continue
        low, high = first, second
        begins = _excess(most(low)) > 0
        if begins == (_excess(most(high)) > 0):
            continue
        while high - low > _ENDS * abs(high):
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            if (_excess(most(middle)) > 0) == begins:
                low = middle
            else:
                high = middle
        place, calm = (low, second) if begins else (high, first)
        value = most(place)
        found = crossing(place, value)
        if found is not None and first <= found.speed <= second:
            yield found
            continue
        # growth like a root of the distance is hidden by rounding before it ends
        for _ in range(_HALVINGS):
            closer = 0.5 * (place + calm)
            there = near(closer, value)
            if _excess(there) <= 0:
                break
            place, value = closer, there
        yield Change(place, value, is_birth=True)


def _largest(
    near: NearRoot, places: Sequence[float], at: float, top: complex, low: float, high: float
) -> tuple[float, complex]:
    """Return where the growth is largest about the place at which it is seen to be."""
    around = sorted({low, *places, high})
    place = around.index(at)
    found = scipy.optimize.minimize_scalar(
        lambda speed: -near(float(speed), top).real,
        bounds=(around[max(place - 1, 0)], around[min(place + 1, len(around) - 1)]),
        method="bounded",
        options={"xatol": 1e-4 * (high - low), "maxiter": 20},
    )
    if -found.fun > top.real:
        return float(found.x), near(float(found.x), top)
    return at, top
