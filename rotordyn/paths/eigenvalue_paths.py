"""All eigenvalues over one real parameter: speed, frequency, stiffness, part of a law.

Every root of one end is paired with one of the other: the number of finite roots does not change,
so that none is lost. What can be wrong is the shape of a path in between; its slopes, which are
exact, say so, and the interval is halved.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.second_order import SecondOrder, Triple
from solidwhirl.rotordyn.core.spectrum import Spectrum, spectrum
from solidwhirl.rotordyn.core.tolerances import (
    ALIKE,
    ALONE,
    CERTAIN,
    DEFECT,
    DEFECT_ALIKE,
    EPS,
    EVENT,
    GROWTH,
    HALVINGS,
    NEAR_AXIS,
    OVERDAMPED,
    SHARE,
    UNRESOLVED,
    VEERING,
)


class Node(NamedTuple):
    """Eigenvalues and their slopes at one value of the parameter, in the order of the paths.

    `order`: the column of the spectrum of each path.
    """

    at: float
    values: ComplexArray
    slopes: ComplexArray
    spectrum: Spectrum
    order: IntArray


# −Re s over |Im s| of a motion that is just overdamped.
_STEEPEST = OVERDAMPED / np.sqrt(1.0 - OVERDAMPED**2)
# Of roots beyond this part of the rate that matters no vectors are compared.
_NEAR = 10.0

#: Which paths between two nodes are to be followed closely, (m,): those that may come to a window.
Wanted = Callable[[Node, Node], BoolArray]


class Event(NamedTuple):
    """A zero of a function on a path, as the cubic of the path has it."""

    at: float
    value: complex
    path: int


class EigenvaluePaths:
    """All eigenvalues over one real parameter p, refined until each path between nodes is known.

    Parameters
    ----------
    solve
        The spectrum at p.
    change
        ∂P/∂p at p from one side, −1 or 1.
    places
        Where nodes are wanted, monotonic; knots of laws belong among them.
    wanted
        Steps to be followed closely, see `Wanted`; others are only counted.
    scale
        A rate above which differences matter, 1/s.
    growth
        Whether the sign of Re s matters: then its error is kept below it, and veerings that both
        ends do not show are looked into.

    Attributes
    ----------
    stretches
        Pairs of neighbouring nodes, each with its slopes towards the inside.
    """

    def __init__(
        self,
        solve: Callable[[float], Spectrum],
        change: Callable[[float, int], Triple],
        places: Sequence[float],
        *,
        wanted: Wanted | None = None,
        scale: float = 1.0,
        growth: bool = False,
    ) -> None:
        self._solve, self._change = solve, change
        self._wanted = wanted or (lambda first, _: np.ones(first.values.size, dtype=bool))
        self._scale, self._growth = scale, growth
        self._known: dict[float, Spectrum] = {}
        self._slopes: dict[tuple[float, int], ComplexArray] = {}
        self.stretches: list[tuple[Node, Node]] = []
        order = np.arange(self.at(places[0]).values.size)
        for start, stop in itertools.pairwise(places):
            order = self._advance(start, order, stop)

    @property
    def nodes(self) -> list[Node]:
        """All nodes, each with the slopes towards the next one."""
        return [first for first, _ in self.stretches] + [
            second for _, second in self.stretches[-1:]
        ]

    def halved(self, stretches: Sequence[tuple[Node, Node]]) -> EigenvaluePaths:
        """Return the paths with a node in the middle of some stretches."""
        places = {node.at for node in self.nodes} | {0.5 * (a.at + b.at) for a, b in stretches}
        return EigenvaluePaths(
            self.at,
            self._change,
            sorted(places, reverse=self.stretches[0][0].at > self.stretches[0][1].at),
            wanted=self._wanted,
            scale=self._scale,
            growth=self._growth,
        )

    def at(self, place: float) -> Spectrum:
        """Return the spectrum at any p, solved once."""
        if place not in self._known:
            found = self._solve(place)
            # motions that are free but for what is no more than the error of the eigensolver
            free = np.abs(found.values) < UNRESOLVED * found.uncertainty
            self._known[place] = found._replace(values=np.where(free, 0.0, found.values))
        return self._known[place]

    def _node(self, place: float, order: IntArray | None, side: int) -> Node:
        found = self.at(place)
        order = np.arange(found.values.size) if order is None else order
        if (place, side) not in self._slopes:
            self._slopes[place, side] = found.slopes(self._change(place, side))
        slopes = self._slopes[place, side]
        return Node(place, found.values[order], slopes[order], found, order)

    def _advance(self, start: float, order: IntArray, stop: float) -> IntArray:
        """Follow all paths from one place to the next, halving where a pairing is not sure."""
        sense = 1 if stop > start else -1
        least = abs(stop - start) / 2**HALVINGS
        here, waiting = start, [stop]
        while waiting:
            first = self._node(here, order, sense)
            second = self._node(waiting[-1], None, -sense)
            first, end, doubtful = self._paired(first, second)
            place = None
            if doubtful.size:
                place = 0.5 * (first.at + second.at)
            elif self._growth:
                place = self._hidden_veering(first, end)
                if place is None and not self._grows_as_told(first, end):
                    place = 0.5 * (first.at + second.at)
            if place is not None and min(abs(place - here), abs(second.at - place)) > 0.5 * least:
                waiting.append(place)
                continue
            here, order = waiting.pop(), end.order
            self.stretches.append((first, end))
        return order

    def _paired(self, first: Node, second: Node) -> tuple[Node, Node, IntArray]:
        """Return both nodes in the order of the paths, and the wanted ones that are not sure yet.

        A root that leaves zero, or comes to it, does so on a ray: a pair of zeros has no slope.
        """
        if first.values.size != second.values.size:
            raise AnalysisError(
                f"the number of finite eigenvalues changes from {first.values.size} to "
                f"{second.values.size} between {first.at:.6g} and {second.at:.6g}"
            )
        width = second.at - first.at
        size = np.maximum(np.abs(first.values), 1e-3 * self._scale)[:, None]
        shares = np.zeros((first.values.size, second.values.size))
        near = [np.flatnonzero(np.abs(n.values) < _NEAR * self._scale) for n in (first, second)]
        one, other = (
            node.spectrum.part(node.order[at])
            for node, at in zip((first, second), near, strict=True)
        )
        shares[np.ix_(*near)] = one.shares(other)
        step = second.values - first.values[:, None]
        begin = np.where(first.values[:, None] == 0, step / width, first.slopes[:, None])
        finish = np.where(second.values == 0, step / width, second.slopes)
        defect = np.abs(step - 0.5 * width * (begin + finish)) / size
        defect = np.where(np.isfinite(defect), defect, 1e6)
        alike = np.clip(np.nan_to_num(shares), 0.0, 1.0)
        cost = np.minimum(defect / DEFECT, 3.0) + 1.0 - alike + 0.1 * np.abs(step) / size
        own, order = scipy.optimize.linear_sum_assignment(cost)
        chosen = defect[own, order]
        begun = first._replace(slopes=begin[own, order])
        end = Node(
            second.at,
            second.values[order],
            finish[own, order],
            second.spectrum,
            second.order[order],
        )
        rival = np.partition(defect, 1, axis=1)[:, 1] if defect.shape[1] > 1 else np.inf
        alone = rival > ALONE * chosen + DEFECT / ALONE
        sure = (shares[own, order] > SHARE) | alone | (chosen < CERTAIN * DEFECT)
        sure &= (chosen < DEFECT) | ((chosen < DEFECT_ALIKE) & (shares[own, order] > ALIKE))
        if self._growth:
            off = end.values - begun.values - 0.5 * width * (begun.slopes + end.slopes)
            growth = np.maximum(np.abs(begun.values.real), np.abs(end.values.real))
            sure &= np.abs(off.real) < GROWTH * growth + EVENT * size[:, 0]
        return begun, end, np.flatnonzero(self._wanted(begun, end) & ~sure)

    def _hidden_veering(self, first: Node, second: Node) -> float | None:
        """Return where paths whose frequencies cross may exchange growth unseen by both ends.

        Two levels a distance D apart turn at the rate B = yᵢᴴ P' xⱼ, so that (Bᵢⱼ Bⱼᵢ)^½ |D| / |D'|
        couples them where they cross.
        """
        near = np.flatnonzero(self._wanted(first, second))
        begin, finish = (
            node.values.imag[near][:, None] - node.values.imag[near] for node in (first, second)
        )
        crossing = np.argwhere(np.triu(begin * finish < 0, 1))
        if not crossing.size:
            return None
        change = self._change(first.at, 1 if second.at > first.at else -1)
        right, left = (
            vectors[:, first.order[near]] for vectors in (first.spectrum.right, first.spectrum.left)
        )
        turn = left.conj().T @ change.times(right).value(first.values[near])
        growth = np.minimum(np.abs(first.values.real), np.abs(second.values.real))[near]
        for i, j in crossing:
            part = begin[i, j] / (begin[i, j] - finish[i, j])
            run = abs(begin[i, j] - finish[i, j])
            apart = abs(first.values[near[i]] - first.values[near[j]])
            turned = np.sqrt(abs(turn[i, j] * turn[j, i]))
            coupling = turned * apart * abs(second.at - first.at) / run
            if VEERING * min(growth[i], growth[j]) < coupling < 0.5 * run and 0.02 < part < 0.98:
                return float(first.at + part * (second.at - first.at))
        return None

    def _grows_as_told(self, first: Node, second: Node) -> bool:
        """Whether cubics have Re s in the middle: a bump that both ends see alike shows there.

        Of the paths that are wanted, and of what is near the axis in the middle alone.
        """
        told = _on_cubic(first, second, slice(None), 0.5)
        values = self.at(0.5 * (first.at + second.at)).values
        asked = told[self._wanted(first, second)]
        seen = values[(values.real > -NEAR_AXIS * np.abs(values)) & (values != 0)]
        for own, others in ((asked, values), (seen, told)):
            nearest = others[np.abs(others[:, None] - own).argmin(axis=0)]
            size = np.maximum(np.abs(own), 1e-3 * self._scale)
            off = np.abs((nearest - own).real)
            if not (off < GROWTH * np.abs(own.real) + EVENT * size).all():
                return False
        return True

    def crossings(
        self,
        function: Callable[[float, ComplexArray], FloatArray],
        derivative: Callable[[float, ComplexArray], FloatArray],
    ) -> list[Event]:
        """Return all zeros of a real function of (p, s) on the cubics, two in one interval too.

        `derivative`: of the function along a path, from (p, ds/dp).
        """
        found = []
        for first, second in self.stretches:
            width = second.at - first.at
            low, high = function(first.at, first.values), function(second.at, second.values)
            rise = width * derivative(first.at, first.slopes)
            fall = width * derivative(second.at, second.slopes)
            near = np.minimum(np.abs(low), np.abs(high))
            reach = np.abs(rise) + np.abs(fall) + EVENT * self._scale
            seen = (low * high <= 0) | (near <= reach)
            end = 1.0 + 1e-9 if second is self.stretches[-1][1] else 1.0 - 1e-9
            seen &= self._wanted(first, second) & np.isfinite(rise + fall)
            for j in np.flatnonzero(seen):
                cubic = np.array(
                    [
                        2 * (low[j] - high[j]) + rise[j] + fall[j],
                        3 * (high[j] - low[j]) - 2 * rise[j] - fall[j],
                        rise[j],
                        low[j],
                    ]
                )
                cubic[np.abs(cubic) <= EPS * np.abs(cubic).max()] = 0.0
                for root in np.roots(cubic):
                    part = float(root.real)
                    if abs(root.imag) < 1e-9 and -1e-9 <= part < end:
                        value = complex(_on_cubic(first, second, int(j), part))
                        found.append(Event(first.at + part * width, value, int(j)))
        return found


def _on_cubic(first: Node, second: Node, path: int | slice, part: float) -> ComplexArray:
    """Return s on the cubic of a path, or of several, at a part of the way between two nodes."""
    width, rest = second.at - first.at, 1.0 - part
    near = (1.0 + 2.0 * part) * first.values[path] + part * width * first.slopes[path]
    far = (3.0 - 2.0 * part) * second.values[path] - rest * width * second.slopes[path]
    return np.asarray(rest**2 * near + part**2 * far)


def meets_band(low: float, high: float) -> Wanted:
    """Return the steps whose chord meets a band of Im s, with those at its rim."""

    def wanted(first: Node, second: Node) -> BoolArray:
        ends = first.values.imag, second.values.imag
        return np.asarray((np.maximum(*ends) > low) & (np.minimum(*ends) < high))

    return wanted


def meets_lines(whirl_ratios: Sequence[float]) -> Wanted:
    """Return the paths that may meet a line Im s = αΩ and are not overdamped there.

    The cubic of a path lies within its four control points; as far as the trapezoid rule misses its
    end it may lie beyond.
    """

    def wanted(first: Node, second: Node) -> BoolArray:
        width = second.at - first.at
        rise, fall = width * first.slopes, width * second.slopes
        beyond = second.values - first.values - 0.5 * (rise + fall)
        points = np.array(
            [first.values, first.values + rise / 3.0, second.values - fall / 3.0, second.values]
        )
        places = first.at + width * np.array([0.0, 1.0, 2.0, 3.0])[:, None] / 3.0
        least = points.real.max(axis=0) + np.abs(beyond.real)
        meets = np.zeros(first.values.size, dtype=bool)
        for ratio in whirl_ratios:
            above = points.imag - ratio * places
            near = (above.min(axis=0) <= np.abs(beyond.imag)) & (
                above.max(axis=0) >= -np.abs(beyond.imag)
            )
            meets |= near & (least > -_STEEPEST * np.abs(ratio * places).max())
        return np.asarray(meets & ((first.values != 0) | (second.values != 0)))

    return wanted


def grows_below(top: float, *, is_real: bool) -> Wanted:
    """Return the paths with |Im s| below a frequency that may come to the imaginary axis.

    Of conjugate pairs of a real operator one is followed.
    """
    least = -EVENT * top if is_real else -1.2 * top

    def lively(values: ComplexArray) -> BoolArray:
        inside = (values.imag > least) & (values.imag < 1.2 * top)
        return np.asarray(inside & _oscillates(values))

    def wanted(first: Node, second: Node) -> BoolArray:
        either = lively(first.values) | lively(second.values)
        return either & near_axis(first.values, second.values)

    return wanted


def _oscillates(values: ComplexArray) -> BoolArray:
    return np.asarray(values.real > -OVERDAMPED * np.abs(values))


def near_axis(first: ComplexArray, second: ComplexArray) -> BoolArray:
    """Return the steps that may come to the imaginary axis."""
    reach = np.abs(first.real - second.real) + NEAR_AXIS * np.maximum(abs(first), abs(second))
    return np.asarray(np.maximum(first.real, second.real) + reach > 0)


def speed_paths(
    operator: SecondOrder,
    speeds: Sequence[float],
    top: float,
    wanted: Wanted,
    *,
    whirl_ratio: float = 0.0,
    growth: bool = False,
) -> EigenvaluePaths:
    """Return the paths over the speed, laws over the frequency read at |whirl_ratio · Ω|.

    `speeds`: where nodes are wanted, monotonic, rad/s; knots of the laws between them are added.
    `top`: the highest frequency of the question; `wanted`, `growth`: as of `EigenvaluePaths`.
    """
    ratio = abs(whirl_ratio)
    knots = [*operator.speed_knots]
    if ratio:
        knots += [knot / ratio for knot in operator.frequency_knots]
    low, high = min(speeds), max(speeds)
    inner = {sign * knot for knot in knots for sign in (-1.0, 1.0) if low < sign * knot < high}
    places = sorted(inner | {*speeds}, reverse=speeds[-1] < speeds[0])
    return EigenvaluePaths(
        lambda speed: spectrum(operator, speed, ratio * abs(speed), None if growth else top),
        lambda speed, side: operator.along(speed, ratio, side),
        places,
        wanted=wanted,
        scale=top,
        growth=growth,
    )
