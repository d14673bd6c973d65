"""Roots of laws over the frequency as paths over the speed, with their births and ends.

Roots pass a knot of a law, and pairs of index ±1 are born or end, where Im s_j(Ω; ω_k) = ω_k of the
problem frozen at the knot, or where two paths of one strip meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.core.tolerances import ALONE, CERTAIN, DEFECT, GROWTH, NEAR_AXIS, SHARE
from solidwhirl.rotordyn.paths.eigenvalue_paths import near_axis
from solidwhirl.rotordyn.paths.events import located, refined
from solidwhirl.rotordyn.paths.frequency_roots import FrequencyRoot, frequency_roots

# Halvings of a first interval, after which unpaired roots are born or end inside.
_HALVINGS = 12
# Cost of pairing roots of unlike index: they are no path.
_UNLIKE = 10.0
# A born root passes a knot that is nearer than this part of its frequency.
_AT_KNOT = 1e-2
# Newton's steps for an end of growth, its relative accuracy, and the growth left there over |s|.
_STEPS, _AT_REST, _LEFT = 20, 1e-12, 1e-9
# A frequency that falls to this part of where it began belongs to no oscillation.
_STILL = 1e-6


class RootNode(NamedTuple):
    """Roots at a speed with their slopes ds/dΩ on one side of it, laws going with |Im s|."""

    speed: float
    roots: tuple[FrequencyRoot, ...]
    values: ComplexArray
    slopes: ComplexArray
    signs: IntArray

    @property
    def growth(self) -> FloatArray:
        """Re s beyond its rounding of the roots of index 1, −inf of others."""
        rounding = _LEFT * np.abs(self.values)
        return np.where(self.signs > 0, self.values.real - rounding, -np.inf)


class Change(NamedTuple):
    """A speed at which growth begins or ends, and the root there; `is_birth`: of a whole pair."""

    speed: float
    value: complex
    is_birth: bool


def slope_of(operator: SecondOrder, speed: float, root: FrequencyRoot, side: int = 0) -> complex:
    """Return ds/dΩ of a root whose laws go with |Im s|; infinite where it is born."""
    change = operator.by_speed(speed, root.value.imag, side)
    frozen = -complex(root.left.conj() @ change.value(root.value) @ root.right)
    rest = 1.0 - root.turned.imag
    return frozen + root.turned * (frozen.imag / rest if rest else np.inf)


def growth_changes(
    operator: SecondOrder, speeds: Sequence[float]
) -> tuple[list[Change], list[RootNode]]:
    """Return where the growth of a root begins or ends over the speed, and all nodes on the way.

    `speeds`: rising, rad/s; knots of laws between them are added. Roots that may come to the
    imaginary axis are followed closely, others are not.
    """
    low, high = speeds[0], speeds[-1]
    inner = {s * knot for knot in operator.speed_knots for s in (-1.0, 1.0)}
    places = sorted({*speeds, *(knot for knot in inner if low < knot < high)})
    changes: list[Change] = []
    nodes: list[RootNode] = []
    roots_at = cache(lambda speed: frequency_roots(operator, speed))

    @cache
    def node(speed: float, side: int) -> RootNode:
        roots = roots_at(speed)
        return RootNode(
            speed,
            tuple(roots),
            np.array([root.value for root in roots], dtype=complex),
            np.array([slope_of(operator, speed, root, side) for root in roots], dtype=complex),
            np.array([root.sign for root in roots], dtype=int),
        )

    nodes.append(node(places[0], 1))
    for start, stop in pairwise(places):
        here, waiting, least = start, [stop], (stop - start) / 2**_HALVINGS
        while waiting:
            first, second = node(here, 1), node(waiting[-1], -1)
            pairs, doubtful = _paired(first, second)
            middle = 0.5 * (first.speed + second.speed)
            if doubtful and middle - first.speed > 0.5 * least:
                waiting.append(middle)
                continue
            changes += _changes(operator, first, second, pairs)
            here = waiting.pop()
            nodes.append(second)
    return sorted(changes), nodes


def _paired(first: RootNode, second: RootNode) -> tuple[list[tuple[int, int]], bool]:
    """Return the pairs of roots that are one path, and whether one near the axis is in doubt."""
    width = second.speed - first.speed
    size = np.maximum(np.abs(first.values)[:, None], np.abs(second.values)) + np.finfo(float).tiny
    step = second.values - first.values[:, None]
    with np.errstate(invalid="ignore"):
        defect = np.abs(step - 0.5 * width * (first.slopes[:, None] + second.slopes)) / size
    defect = np.where(np.isfinite(defect), defect, 1e6)
    shares = _shares(first, second)
    unlike = first.signs[:, None] != second.signs
    cost = np.minimum(defect / DEFECT, 3.0) + 1.0 - shares + np.abs(step) / size
    rows, columns = scipy.optimize.linear_sum_assignment(cost + _UNLIKE * unlike)
    pairs, sure_rows, sure_columns = [], set(), set()
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        one = defect[row, column]
        others = np.delete(defect[row], column)
        alone = others.min(initial=np.inf) > ALONE * one + DEFECT / ALONE
        off = abs(
            (step[row, column] - 0.5 * width * (first.slopes[row] + second.slopes[column])).real
        )
        growth = max(abs(first.values[row].real), abs(second.values[column].real))
        sure = one < DEFECT and (shares[row, column] > SHARE or alone or one < CERTAIN * DEFECT)
        if sure and not unlike[row, column]:
            pairs.append((row, column))
            near = near_axis(first.values[[row]], second.values[[column]])[0]
            if near and off > GROWTH * growth + _LEFT * size[row, column]:
                continue
            sure_rows.add(row)
            sure_columns.add(column)
    left = [first.values[k] for k in range(first.values.size) if k not in sure_rows]
    left += [second.values[k] for k in range(second.values.size) if k not in sure_columns]
    doubtful = any(value.real > -3.0 * NEAR_AXIS * abs(value) for value in left)
    return pairs, doubtful


def _shares(first: RootNode, second: RootNode) -> FloatArray:
    """Return the MAC of the right vectors, (m, k)."""
    one, other = (
        np.array([root.right / np.linalg.norm(root.right) for root in node.roots]).T
        for node in (first, second)
    )
    if not one.size or not other.size:
        return np.zeros((first.values.size, second.values.size))
    return np.asarray(np.abs(one.conj().T @ other) ** 2)


def _changes(
    operator: SecondOrder, first: RootNode, second: RootNode, pairs: list[tuple[int, int]]
) -> list[Change]:
    """Return the beginnings and ends of growth between two nodes."""
    found = []
    for row, column in pairs:
        begin, end = first.values[row], second.values[column]
        width = second.speed - first.speed
        low, high = begin.real, end.real
        rise, fall = width * first.slopes[row].real, width * second.slopes[column].real
        cubic = (2 * (low - high) + rise + fall, 3 * (high - low) - 2 * rise - fall, rise, low)
        if first.signs[row] < 0 or not np.isfinite(cubic).all():
            continue
        for root in np.roots(cubic):
            part = float(root.real)
            if abs(root.imag) < 1e-9 and -1e-9 <= part < 1.0 - 1e-9:
                start = begin + part * (end - begin)
                between = first.speed, second.speed
                place = neutral_root(operator, first.speed + part * width, complex(start), between)
                if place is not None and first.speed <= place.speed <= second.speed:
                    found.append(place)
    for node, taken, ends in (
        (first, {row for row, _ in pairs}, second),
        (second, {column for _, column in pairs}, first),
    ):
        for at in np.flatnonzero(node.growth > 0):
            if int(at) not in taken:
                found.append(_birth(operator, node, int(at), ends.speed))
    return found


def neutral_root(
    operator: SecondOrder, speed: float, start: complex, between: tuple[float, float]
) -> Change | None:
    """Return where s = iω with the laws at ω, by Newton's method for Ω and ω.

    `between`: speeds that it lies between. None if it does not, by more than their distance.
    """
    low, high = (2.0 * one - other for one, other in (between, between[::-1]))
    omega, step = start.imag, np.inf
    least = _STILL * omega
    for _ in range(_STEPS):
        triple = operator.at(speed, omega)
        values, right, left = refined(triple, complex(0.0, omega) if step < 1e-3 * omega else start)
        value, x, y = complex(values[0]), right[:, 0], left[:, 0]
        by_speed = -complex(y.conj() @ operator.by_speed(speed, omega).value(value) @ x)
        turned = -complex(y.conj() @ operator.by_frequency(speed, omega).value(value) @ x)
        # Re s = 0 and Im s = ω
        jacobian = np.array([[by_speed.real, turned.real], [by_speed.imag, turned.imag - 1.0]])
        miss = np.array([value.real, value.imag - omega])
        if not (np.isfinite(jacobian).all() and np.isfinite(miss).all()):
            return None
        if np.abs(miss).max() <= _AT_REST * omega:
            return Change(float(speed), complex(value.real, omega), is_birth=False)
        try:
            change = np.linalg.solve(jacobian, -miss)
        except np.linalg.LinAlgError:
            return None
        speed, omega, start = speed + change[0], omega + change[1], value
        step = abs(change[1])
        if not (omega > least and low <= speed <= high):
            return None
    return Change(float(speed), value, is_birth=False) if abs(miss).max() <= _LEFT * omega else None


def _birth(operator: SecondOrder, node: RootNode, at: int, other_rad_s: float) -> Change:
    """Return where a growing root is born or ends between its node and another speed."""
    value = complex(node.values[at])
    knots = np.array(operator.frequency_knots)
    nearest = float(knots[np.argmin(np.abs(knots - value.imag))])
    if abs(nearest - value.imag) <= _AT_KNOT * value.imag:
        place = located(
            operator,
            node.speed,
            value,
            lambda _, root: root.imag - nearest,
            lambda slope: slope.imag,
            frequency=nearest,
        )
        low, high = sorted((node.speed, other_rad_s))
        if place is not None and low <= place.speed <= high:
            return Change(place.speed, place.value, is_birth=True)
    return Change(0.5 * (node.speed + other_rad_s), value, is_birth=True)
