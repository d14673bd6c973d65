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
    ALONE,
    CERTAIN,
    DEFECT,
    EVENT,
    GROWTH,
    HALVINGS,
    NEAR_AXIS,
    OVERDAMPED,
    SHARE,
    VEERING,
)

#: Which steps from a to b are to be followed closely, (m,) each: those whose chord meets a window.
Wanted = Callable[[ComplexArray, ComplexArray], BoolArray]


class Node(NamedTuple):
    """Eigenvalues and their slopes at one value of the parameter, in the order of the paths.

    `order`: the column of the spectrum of each path.
    """

    at: float
    values: ComplexArray
    slopes: ComplexArray
    spectrum: Spectrum
    order: IntArray


class Event(NamedTuple):
    """A zero of a function on a path, or a branch point, as the cubic of the path has it."""

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
    branch_points
        Where two roots leave the real axis, or return to it, about.
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
        self._wanted = wanted or (lambda first, _: np.ones(first.size, dtype=bool))
        self._scale, self._growth = scale, growth
        self._known: dict[float, Spectrum] = {}
        self.branch_points: list[Event] = []
        self.stretches: list[tuple[Node, Node]] = []
        order = np.arange(self._spectrum(places[0]).values.size)
        for start, stop in itertools.pairwise(places):
            order = self._advance(start, order, stop)

    @property
    def nodes(self) -> list[Node]:
        """All nodes, each with the slopes towards the next one."""
        return [first for first, _ in self.stretches] + [
            second for _, second in self.stretches[-1:]
        ]

    def _spectrum(self, place: float) -> Spectrum:
        if place not in self._known:
            self._known[place] = self._solve(place)
        return self._known[place]

    def _node(self, place: float, order: IntArray | None, side: int) -> Node:
        found = self._spectrum(place)
        order = np.arange(found.values.size) if order is None else order
        slopes = found.slopes(self._change(place, side))
        return Node(place, found.values[order], slopes[order], found, order)

    def _advance(self, start: float, order: IntArray, stop: float) -> IntArray:
        """Follow all paths from one place to the next, halving where a pairing is not sure."""
        sense = 1 if stop > start else -1
        least = abs(stop - start) / 2**HALVINGS
        here, waiting = start, [stop]
        while waiting:
            first = self._node(here, order, sense)
            second = self._node(waiting[-1], None, -sense)
            partner, doubtful = self._paired(first, second)
            place = None
            if doubtful.size:
                place = 0.5 * (first.at + second.at)
            elif self._growth:
                place = self._hidden_veering(first, second, partner)
            if place is not None and min(abs(place - here), abs(second.at - place)) > 0.5 * least:
                waiting.append(place)
                continue
            middle = 0.5 * (first.at + second.at)
            self.branch_points += [Event(middle, first.values[j], int(j)) for j in doubtful[:1]]
            here, order = waiting.pop(), second.order[partner]
            values, slopes = second.values[partner], second.slopes[partner]
            self.stretches.append(
                (first, second._replace(values=values, slopes=slopes, order=order))
            )
        return order

    def _paired(self, first: Node, second: Node) -> tuple[IntArray, IntArray]:
        """Return the one-to-one pairing, and the wanted paths that are not sure yet."""
        if first.values.size != second.values.size:
            raise AnalysisError(
                f"the number of finite eigenvalues changes from {first.values.size} to "
                f"{second.values.size} between {first.at:.6g} and {second.at:.6g}"
            )
        width = second.at - first.at
        size = np.maximum(np.abs(first.values), 1e-3 * self._scale)[:, None]
        shares = first.spectrum.shares(second.spectrum)[first.order]
        step = second.values - first.values[:, None]
        defect = np.abs(step - 0.5 * width * (first.slopes[:, None] + second.slopes)) / size
        defect = np.where(np.isfinite(defect), defect, 1e6)
        alike = np.clip(np.nan_to_num(shares), 0.0, 1.0)
        cost = np.minimum(defect / DEFECT, 3.0) + 1.0 - alike + 0.1 * np.abs(step) / size
        own, order = scipy.optimize.linear_sum_assignment(cost)
        chosen, end = defect[own, order], second.values[order]
        rival = np.partition(defect, 1, axis=1)[:, 1] if defect.shape[1] > 1 else np.inf
        alone = rival > ALONE * chosen + DEFECT / ALONE
        sure = (shares[own, order] > SHARE) | alone | (chosen < CERTAIN * DEFECT)
        sure &= chosen < DEFECT
        if self._growth:
            off = end - first.values - 0.5 * width * (first.slopes + second.slopes[order])
            growth = np.maximum(np.abs(first.values.real), np.abs(end.real))
            sure &= np.abs(off.real) < GROWTH * growth + EVENT * self._scale
        return order, np.flatnonzero(self._wanted(first.values, end) & ~sure)

    def _hidden_veering(self, first: Node, second: Node, order: IntArray) -> float | None:
        """Return where paths whose frequencies cross may exchange growth unseen by both ends.

        Two levels a distance D apart turn at the rate B = yᵢᴴ P' xⱼ, so that (Bᵢⱼ Bⱼᵢ)^½ |D| / |D'|
        couples them where they cross.
        """
        end = second.values[order]
        near = np.flatnonzero(self._wanted(first.values, end))
        begin, finish = (v.imag[near][:, None] - v.imag[near] for v in (first.values, end))
        crossing = np.argwhere(np.triu(begin * finish < 0, 1))
        if not crossing.size:
            return None
        change = self._change(first.at, 1 if second.at > first.at else -1)
        right, left = (
            vectors[:, first.order[near]] for vectors in (first.spectrum.right, first.spectrum.left)
        )
        turn = left.conj().T @ change.times(right, first.values[near])
        growth = np.minimum(np.abs(first.values.real), np.abs(end.real))[near]
        for i, j in crossing:
            part = begin[i, j] / (begin[i, j] - finish[i, j])
            run = abs(begin[i, j] - finish[i, j])
            apart = abs(first.values[near[i]] - first.values[near[j]])
            turned = np.sqrt(abs(turn[i, j] * turn[j, i]))
            coupling = turned * apart * abs(second.at - first.at) / run
            if VEERING * min(growth[i], growth[j]) < coupling < 0.5 * run and 0.02 < part < 0.98:
                return float(first.at + part * (second.at - first.at))
        return None

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
            seen &= self._wanted(first.values, second.values) & np.isfinite(rise + fall)
            for j in np.flatnonzero(seen):
                cubic = (
                    2 * (low[j] - high[j]) + rise[j] + fall[j],
                    3 * (high[j] - low[j]) - 2 * rise[j] - fall[j],
                    rise[j],
                    low[j],
                )
                for root in np.roots(cubic):
                    part = float(root.real)
                    if abs(root.imag) < 1e-9 and -1e-9 <= part < 1 - 1e-9:
                        value = _on_cubic(first, second, int(j), part)
                        found.append(Event(first.at + part * width, value, int(j)))
        return found


def _on_cubic(first: Node, second: Node, path: int, part: float) -> complex:
    """Return s on the cubic of a path at a part of the way between two nodes."""
    width, rest = second.at - first.at, 1.0 - part
    near = (1.0 + 2.0 * part) * first.values[path] + part * width * first.slopes[path]
    far = (3.0 - 2.0 * part) * second.values[path] - rest * width * second.slopes[path]
    return complex(rest**2 * near + part**2 * far)


def meets_band(low: float, high: float) -> Wanted:
    """Return the steps whose chord meets a band of Im s, with those at its rim."""
    return lambda first, second: (
        (np.maximum(first.imag, second.imag) > low) & (np.minimum(first.imag, second.imag) < high)
    )


def near_axis(first: ComplexArray, second: ComplexArray) -> BoolArray:
    """Return the steps that may come to the imaginary axis."""
    reach = np.abs(first.real - second.real) + NEAR_AXIS * np.maximum(abs(first), abs(second))
    return np.asarray(np.maximum(first.real, second.real) + reach > 0)


def speed_paths(
    operator: SecondOrder,
    speeds: Sequence[float],
    top: float,
    *,
    whirl_ratio: float = 0.0,
    growth: bool = False,
) -> EigenvaluePaths:
    """Return the paths over the speed, laws over the frequency read at |whirl_ratio · Ω|.

    `speeds`: where nodes are wanted, monotonic, rad/s; knots of the laws between them are added.
    `top`: roots with |Im s| below it are followed, overdamped ones are only counted; with `growth`
    those that may come to the imaginary axis.
    """
    ratio = abs(whirl_ratio)
    knots = [*operator.speed_knots]
    if ratio:
        knots += [knot / ratio for knot in operator.frequency_knots]
    low, high = min(speeds), max(speeds)
    inner = {sign * knot for knot in knots for sign in (-1.0, 1.0) if low < sign * knot < high}
    places = sorted(inner | {*speeds}, reverse=speeds[-1] < speeds[0])

    # of conjugate pairs one is followed
    least = -EVENT * top if operator.is_real else -1.2 * top

    def lively(values: ComplexArray) -> BoolArray:
        inside = (values.imag > least) & (values.imag < 1.2 * top)
        return np.asarray(inside & (values.real > -OVERDAMPED * np.abs(values)))

    def wanted(first: ComplexArray, second: ComplexArray) -> BoolArray:
        either = lively(first) | lively(second)
        return either & near_axis(first, second) if growth else either

    return EigenvaluePaths(
        lambda speed: spectrum(operator, speed, ratio * abs(speed), top),
        lambda speed, side: operator.along(speed, ratio, side),
        places,
        wanted=wanted,
        scale=top,
        growth=growth,
    )
