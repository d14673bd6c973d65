"""Unstable ranges of systems whose bearings depend on the frequency, controllers among them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np
import scipy

from solidwhirl.rotordyn.assembly.operator import operator_of
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.core.spectrum import Spectrum, spectrum
from solidwhirl.rotordyn.modes.damping import NEUTRAL
from solidwhirl.rotordyn.paths.eigenvalue_paths import grows_below, speed_paths
from solidwhirl.rotordyn.paths.events import neutral, refined
from solidwhirl.rotordyn.paths.frequency_paths import Change, growth_changes
from solidwhirl.rotordyn.paths.frequency_roots import FrequencyRoot, frequency_roots, root_near
from solidwhirl.rotordyn.stability.unstable_windows import Window

# Speeds at which all roots are solved for at first; more where paths ask for it.
_SPEEDS = 9
# Changes of growth closer than this (relative to the range) are one.
_SAME = 1e-9

#: The root that grows most at a speed, −inf if there is none.
MostGrowing = Callable[[float], complex]
#: The root at a speed that is next to another one.
NearRoot = Callable[[float, complex], complex]


def windows_with_laws(assembled: AssembledSystem, low: float, high: float) -> list[Window]:
    """Find the ranges of speeds in which a motion of the system grows.

    `low`, `high`: range of Ω, rad/s. All roots that may come to the imaginary axis are followed
    over the speed; where one crosses it, or a pair is born or ends beyond it, growth may begin or
    end, and all roots between two such speeds say whether something grows there. Roots of index −1
    are left out: see `frequency_roots`.
    """
    operator = operator_of(assembled)
    speeds = np.linspace(low, high, _SPEEDS).tolist()
    if operator.frequency_knots:
        changes, nodes = growth_changes(operator, speeds)
        roots = {node.speed: node.roots for node in nodes}

        def near_root(speed: float, start: complex) -> complex:
            found = root_near(operator, speed, start)
            return start if found is None else found.value

        return _windows(
            changes, [*roots], lambda speed: _of_roots(operator, speed, roots), near_root
        )
    top = _highest(operator, low, high)
    wanted = grows_below(top, is_real=operator.is_real)
    paths = speed_paths(operator, speeds, top, wanted, growth=True)
    events = paths.crossings(lambda _, values: values.real, lambda _, slopes: slopes.real)
    found = [neutral(operator, event.at, event.value) for event in events]
    changes = [Change(one.speed, one.value, is_birth=False) for one in found if one is not None]
    inside = [change for change in changes if low <= change.speed <= high]
    spectra = {node.at: node.spectrum for node in paths.nodes}

    def most(speed: float) -> complex:
        return _of_spectrum(spectra.get(speed) or spectrum(operator, speed, top=top))

    def near(speed: float, start: complex) -> complex:
        return complex(refined(operator.at(speed), start).values[0])

    return _windows(inside, [*spectra], most, near)


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
    """Return the root that grows most beyond its rounding."""
    moves = found.values != 0
    values = found.values[moves]
    excess = values.real - np.maximum(found.uncertainty[moves], NEUTRAL * np.abs(values))
    return complex(values[np.argmax(excess)]) if values.size else complex(-np.inf)


def _excess(value: complex) -> float:
    return value.real - NEUTRAL * abs(value)


def _windows(
    changes: Sequence[Change], nodes: Sequence[float], most: MostGrowing, near: NearRoot
) -> list[Window]:
    """Return the ranges between changes in which the root that grows most does grow."""
    low, high = nodes[0], nodes[-1]
    # the same change may be found on two paths, as of both planes of an isotropic rotor
    apart: list[Change] = []
    for change in sorted([*changes, *_unseen(changes, nodes, most)], key=lambda one: one.speed):
        if not apart or change.speed - apart[-1].speed > _SAME * (high - low):
            apart.append(change)
    ends = [low, *(change.speed for change in apart), high]
    windows: list[Window] = []
    for place, (begin, end) in enumerate(pairwise(ends)):
        inside = [speed for speed in nodes if begin < speed < end] or [0.5 * (begin + end)]
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
    changes: Sequence[Change], nodes: Sequence[float], most: MostGrowing
) -> Iterator[Change]:
    """Yield where growth begins or ends between two nodes that no change lies between."""
    for first, second in pairwise(nodes):
        if any(first <= change.speed <= second for change in changes):
            continue
        low, high = first, second
        begins = _excess(most(low)) > 0
        if begins == (_excess(most(high)) > 0):
            continue
        while high - low > _SAME * abs(high):
            middle = 0.5 * (low + high)
            if (_excess(most(middle)) > 0) == begins:
                low = middle
            else:
                high = middle
        yield Change(high, most(low if begins else high), is_birth=True)


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
