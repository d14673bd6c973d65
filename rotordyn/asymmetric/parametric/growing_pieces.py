"""Ranges of speed in which a block of motions grows: every crossing of the axis is bracketed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np
import scipy

from solidwhirl.rotordyn.assembly.system import Side
from solidwhirl.rotordyn.asymmetric.parametric.block_paths import Spectral, Stretch
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.modes.damping import ROUNDING

# Pieces the range is cut into at least; segments of speed laws are never joined.
_PIECES = 12
# No piece is halved below this fraction of the range; nor cut beside a meeting below that one.
_FLOOR = 1e-6
_MEETING_FLOOR = 1e-10
# Accuracy of an end, relative or as a part of the narrowest window that is looked for.
_ACCURACY, _OF_NARROWEST = 1e-13, 0.1
# What grows at an end of a window is looked up inside, at these parts of it.
_INSIDE = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
# The growth left at a root may be this fraction of that at the ends.
_JUMP = 1e-6
# Parts of a window that are looked at for its largest growth at least.
_LOOKS = 16
# Maxima of the growth among them that are followed up.
_PEAKS = 2
# Places at which paths are read.
_PARTS = np.linspace(0.0, 1.0, 17)
# A part that is larger than this is no nearer to a meeting than the stretch that it was cut from.
_AS_LARGE = 0.9
# Share of the mismatch of straight lines that cubics may err by before a middle has been seen,
_UNSEEN = 0.5
# and afterwards, beside what the middle has shown.
_SEEN = 0.05
# and at least this part of what a middle has shown of growth and frequency together.
_BY_CHANCE = 0.25
# Modes less alike than this are not known to be the same.
_UNLIKE = 0.5
# Only modes that are more alike are one that grows from one speed to the other.
_ONE = 0.9
# A root is taken where the error is below this share of the change of growth.
_CLEAR = 0.25
# Frequencies that meet count as looked at from this share of the width of the meeting.
_NEAR = 0.25
# What two modes drive may be wider than it looks from afar: by the inverse of this.
_SURE = 0.1
# Growth that a meeting may add for every 1/s of coupling, whatever its phase is found to be.
_PHASE = 0.2


S = TypeVar("S", bound=Spectral)


class Motions(Protocol[S]):
    """What is followed over the speed: a block of a system, or the motions of a periodic one."""

    def solve(self, speed_rad_s: float) -> S:
        """Return all eigenvalues at a speed; slopes are zero until they are asked for."""

    def with_slopes(self, spectral: S, side: Side) -> S:
        """Return eigenvalues with their slopes over the speed on one side of it."""

    def stretch_between(self, first: S, second: S) -> Stretch:
        """Pair the eigenvalues of two speeds, rising, with slopes."""


class Piece(NamedTuple):
    """A range of speeds in which something grows throughout, or nowhere."""

    low: float
    high: float
    grows: bool


class Search(Generic[S]):
    """Follow all eigenvalues, solving once at each speed.

    `narrowest`: two modes that meet are not followed up where what they drive is narrower, rad/s,
    and pieces are found to a part of it only.
    """

    def __init__(
        self,
        motions: Motions[S],
        knots: Iterable[float],
        speed_low: float,
        speed_high: float,
        narrowest: float = 0.0,
    ) -> None:
        self.motions, self.narrowest = motions, narrowest
        self.low, self.high = speed_low, speed_high
        inside = {0.0, *knots, *(-k for k in knots)}
        self.corners = sorted(
            {speed_low, speed_high, *(k for k in inside if speed_low < k < speed_high)}
        )
        self._known: dict[float, S] = {}

    def at(self, speed: float) -> S:
        """Return the eigenvalues at a speed, solved once."""
        if speed not in self._known:
            self._known[speed] = self.motions.solve(speed)
        return self._known[speed]

    def stretch(self, low: float, high: float) -> Stretch:
        """Return the paths between two speeds of one segment."""
        first = self.motions.with_slopes(self.at(low), "above")
        second = self.motions.with_slopes(self.at(high), "below")
        return self.motions.stretch_between(first, second)

    def ends_inside(self, piece: Piece) -> tuple[bool, bool]:
        """Return whether growth begins and ends at the ends of a piece, or the search does."""
        opens = piece.low > self.low or not self.at(self.low).grows
        closes = piece.high < self.high or not self.at(self.high).grows
        return opens, closes

    def pieces(self) -> list[Piece]:
        """Return all pieces that grow."""
        widest = (self.high - self.low) / _PIECES
        pieces: list[Piece] = []
        for start, stop in pairwise(self.corners):
            count = int(np.ceil((stop - start) / widest - 1e-9))
            for low, high in pairwise(np.linspace(start, stop, max(count, 1) + 1).tolist()):
                pieces += self._looked(self.stretch(low, high), None)
        return [piece for piece in _joined(pieces) if piece.grows]

    def _looked(
        self, stretch: Stretch, seen: ComplexArray | None, *, halved: bool = False
    ) -> list[Piece]:
        """Return the pieces of a stretch.

        `seen`: the error of each path in its middle. `halved`: it is cut in the middle, if at all:
        that a meeting stands beside its end again, as where modes are defective, says nothing.
        """
        low, high = stretch.first.speed_rad_s, stretch.second.speed_rad_s
        error = _error(stretch, seen)
        grid = stretch.paths(_PARTS)
        tolerance = np.minimum(stretch.first.tolerance, stretch.second.tolerance[stretch.partner])
        excess = grid.real - np.where(np.isfinite(tolerance), tolerance, 0.0)[:, None]
        excess[~stretch.counted] = -np.inf
        # two modes that grow at either end need not be one that grows in between
        known = np.where(stretch.mac < _ONE, np.inf, error)
        throughout = stretch.first.counted & stretch.second.counted[stretch.partner]
        if ((excess.min(axis=1) > known) & throughout).any():
            return [Piece(low, high, True)]
        narrow = high - low <= max(_FLOOR * (self.high - self.low), 0.2 * self.narrowest)
        doubtful = excess.max(axis=1) + error > 0
        least = _SURE * self.narrowest
        place = _meeting(stretch, grid, tolerance, least)
        room = min(place, 1.0 - place) * (high - low) > _MEETING_FLOOR * (self.high - self.low)
        if not (np.isfinite(place) and room):
            if not narrow and _may_touch(stretch, grid, tolerance, _drift(stretch, seen), least):
                return self._cut(stretch, 0.5)
            if not doubtful.any():
                return [Piece(low, high, False)]
            if narrow or _crosses_once(excess[doubtful], error[doubtful]):
                return self._bracketed(stretch, np.flatnonzero(doubtful))
            place = 0.5
        return self._cut(stretch, 0.5 if halved else place)

    def _cut(self, stretch: Stretch, place: float) -> list[Piece]:
        """Look at both parts of a stretch, with the error that its paths show at the cut."""
        low, high = stretch.first.speed_rad_s, stretch.second.speed_rad_s
        middle = low + place * (high - low)
        left, right = self.stretch(low, middle), self.stretch(middle, high)
        miss = stretch.paths(np.array([place]))[:, 0] - left.end_values
        seen = np.abs(miss.real) + 1j * np.abs(miss.imag)
        after = np.empty_like(seen)
        after[left.partner] = seen
        return [
            *self._looked(left, seen, halved=place > _AS_LARGE),
            *self._looked(right, after, halved=1.0 - place > _AS_LARGE),
        ]

    def _bracketed(self, stretch: Stretch, paths: IntArray) -> list[Piece]:
        """Return the pieces of a stretch with one crossing, or too narrow for more."""
        low, high = stretch.first.speed_rad_s, stretch.second.speed_rad_s
        before, after = stretch.first.grows, stretch.second.grows
        if before == after:
            return [Piece(low, high, before)]

        def growth(speed: float) -> float:
            if speed in (low, high):
                values = stretch.first.values if speed == low else stretch.end_values
                return float(values[paths].real.max())
            near = stretch.paths(np.array([(speed - low) / (high - low)]))[paths, 0]
            return max(self.at(speed).nearest(v)[1].real for v in near)

        calm, loud = (low, high) if after else (high, low)
        still = self.at(calm)
        chosen = paths if after else stretch.partner[paths]
        values = still.values[chosen]
        damped = (values.real < -ROUNDING * np.abs(values)).all()
        if damped and growth(calm) < 0 < growth(loud):
            size = abs(growth(low)) + abs(growth(high))
            root = self._root(growth, low, high)
            # beside a meeting of modes the nearest value may jump from one to another
            if max(self.leading(root).real, abs(growth(root))) > _JUMP * size:
                root = self._halved(calm, loud)
        else:
            root = self._halved(calm, loud)
        return [Piece(low, root, before), Piece(root, high, after)]

    def accuracy(self, first: float, second: float) -> float:
        """Return how well an end between two speeds is to be known, rad/s."""
        return max(_ACCURACY * max(abs(first), abs(second)), _OF_NARROWEST * self.narrowest)

    def _root(self, growth: Callable[[float], float], first: float, second: float) -> float:
        accuracy = self.accuracy(first, second)
        return float(scipy.optimize.brentq(growth, first, second, xtol=accuracy, rtol=_ACCURACY))

    def _halved(self, calm: float, loud: float) -> float:
        """Return where growth begins between a speed without and one with it."""
        while abs(loud - calm) > self.accuracy(loud, calm):
            middle = 0.5 * (calm + loud)
            if middle in (calm, loud):
                break
            calm, loud = (calm, middle) if self.at(middle).grows else (middle, loud)
        return loud

    def at_end(self, speed: float, other: float) -> complex:
        """Return the eigenvalue at an end of a window, followed from where it is seen to grow."""
        places = [speed + part * (other - speed) for part in _INSIDE]
        seen = next((k for k, v in enumerate(places) if self.at(v).grows), len(places) - 1)
        value = self.leading(places[seen])
        for place in (*reversed(places[:seen]), speed):
            value = self.at(place).nearest(value)[1]
        return value

    def leading(self, speed: float) -> complex:
        """Return the eigenvalue with the largest growth that is none of rounding."""
        found = self.at(speed)
        return complex(found.values[found.excess.argmax()])

    def highest(self, piece: Piece) -> float:
        """Return the speed of the largest growth in a window."""
        inside = {s for s in self._known if piece.low <= s <= piece.high}
        for left, right in pairwise(sorted({piece.low, *inside, piece.high})):
            parts = int((right - left) / (piece.high - piece.low) * _LOOKS) + 1
            inside |= set(np.linspace(left, right, parts + 1).tolist())
        known = sorted(inside)
        rates = [self.leading(s).real for s in known]
        around = np.array([-np.inf, *rates, -np.inf])
        peaks = np.flatnonzero((around[1:-1] >= around[:-2]) & (around[1:-1] >= around[2:]))
        peaks = peaks[np.argsort(-np.array(rates)[peaks], kind="stable")][:_PEAKS]
        places = [(rates[k], known[k]) for k in peaks]
        for k in peaks.tolist():
            for other in (k - 1, k + 1):
                if 0 <= other < len(known) and self._rises(known[k], known[other]):
                    places.append(self._summit(*sorted((known[k], known[other]))))
        return float(max(places)[1])

    def _rises(self, speed: float, other: float) -> bool:
        """Whether the largest growth at a speed rises towards another."""
        found = self.at(speed)
        side: Side = "above" if other > speed else "below"
        slope = self.motions.with_slopes(found, side).slopes[found.excess.argmax()].real
        return bool(slope * (other - speed) > 0)

    def _summit(self, low: float, high: float) -> tuple[float, float]:
        """Return the largest growth between two speeds, and its speed."""
        found = scipy.optimize.minimize_scalar(
            lambda speed: -self.leading(float(speed)).real,
            bounds=(low, high),
            method="bounded",
            options={
                "xatol": max(1e-5 * (high - low), _OF_NARROWEST * self.narrowest),
                "maxiter": 20,
            },
        )
        return -float(found.fun), float(found.x)


def _error(stretch: Stretch, seen: ComplexArray | None) -> FloatArray:
    """Return how far each path may be from the true growth rate, shape (m,)."""
    miss = stretch.mismatch()
    growth = np.abs(miss.real).max(axis=0)
    unlike = np.where(stretch.mac < _UNLIKE, np.abs(miss).max(axis=0), 0.0)
    coarse = np.asarray(_UNSEEN * (growth + unlike))
    if seen is None:
        return coarse
    # growth may be right in a middle by chance where the frequency is not
    shown = np.maximum(seen.real, _BY_CHANCE * np.abs(seen))
    return np.asarray(np.minimum(coarse, np.maximum(shown, _SEEN * coarse)))


def _drift(stretch: Stretch, seen: ComplexArray | None) -> FloatArray:
    """Return how far each path may be from the true frequency, shape (m,), rad/s."""
    coarse = _UNSEEN * np.abs(stretch.mismatch()).max(axis=0)
    return coarse if seen is None else np.minimum(coarse, np.maximum(seen.imag, _SEEN * coarse))


def _crosses_once(excess: FloatArray, error: FloatArray) -> bool:
    """Whether all doubtful paths rise, or all fall, clearly, from one side to the other."""
    change = excess[:, -1] - excess[:, 0]
    direction = np.sign(change[0])
    steps = direction * np.diff(excess, axis=1)
    clear = error <= _CLEAR * np.abs(change)
    other = np.sign(excess[:, 0]) != np.sign(excess[:, -1])
    return bool((steps >= 0).all() and clear.all() and other.all())


def _meeting(
    stretch: Stretch, grid: ComplexArray, tolerance: FloatArray, narrowest: float
) -> float:
    """Return the part of a stretch at which two modes meet that may drive each other, nan if none.

    `narrowest`: width of what they may make unstable, rad/s, below which they are left alone.

    Two modes with λ1 − λ2 = iΔ and a coupling p = W12 W21 have λ = mean ± √(p − Δ²/4): they grow
    by Re √p at most, within |Δ| < 2 √|p|. From the change W of the matrices over the stretch,
    √p = √(W12 W21) Δ_end / (Δ_1 − Δ_2).
    """
    i, j, beats = _crossings(stretch, grid)
    if not i.size:
        return float("nan")
    rise = stretch.first.stride * (stretch.first.speed_rad_s + _PARTS * stretch.width)
    gap = grid.imag[i] - grid.imag[j] - np.outer(beats, rise)
    closing = gap[:, 0] - gap[:, -1]
    shares = np.array([gap[:, 0], gap[:, -1]]) / closing
    able, strength = _driven(stretch, grid, (i, j, beats), shares, tolerance)
    able &= 2.0 * strength / np.abs(closing) * stretch.width > narrowest
    if not able.any():
        return float("nan")
    strength, closing, gap = strength[able], closing[able], gap[able]
    at = (gap[:, :-1] * gap[:, 1:] <= 0).argmax(axis=1)
    rows = np.arange(at.size)
    before, after = gap[rows, at], gap[rows, at + 1]
    inner = np.where(before == after, 0.5, before / np.where(before == after, 1.0, before - after))
    place = _PARTS[at] + inner * (_PARTS[at + 1] - _PARTS[at])
    wide = 2.0 * strength / np.abs(closing)
    far = np.minimum(place, 1.0 - place) - _NEAR * wide
    worst = int(far.argmax())
    return float(place[worst]) if far[worst] > 0 else float("nan")


def _driven(
    stretch: Stretch,
    grid: ComplexArray,
    pairs: tuple[IntArray, IntArray, IntArray],
    shares: FloatArray,
    tolerance: FloatArray,
) -> tuple[BoolArray, FloatArray]:
    """Return which pairs may grow by what couples them, and its size |√p| in 1/s.

    `pairs`: i, j and strides; `shares`: of the change of the matrices, as seen from both ends, that
    is there where they meet, shape (2, pairs).
    """
    i, j, beats = pairs
    strength, gain = np.zeros((2, i.size))
    for beat in np.unique(beats):
        at = np.flatnonzero(beats == beat)
        for product, share in zip(stretch.couplings(int(beat)), shares, strict=True):
            root = np.sqrt(product[i[at], j[at]] * share[at] ** 2 + 0j)
            strength[at] = np.maximum(strength[at], np.abs(root))
            gain[at] = np.maximum(gain[at], np.abs(root.real) + _PHASE * np.abs(root))
    highest = np.maximum(grid.real.max(axis=1)[i], grid.real.max(axis=1)[j])
    return highest + gain > np.maximum(tolerance[i], tolerance[j]), strength


def _crossings(stretch: Stretch, grid: ComplexArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return pairs i, j of paths that count and the strides s by which λ_i − λ_j is i s stride Ω.

    Each is of the sign at one end of the stretch that it has not at the other.
    """
    i, j = np.nonzero(np.triu(stretch.counted & stretch.counted[:, None], 1))
    gaps = [v[i] - v[j] for v in (grid.imag[:, 0], grid.imag[:, -1])]
    if not stretch.first.stride:
        met = gaps[0] * gaps[1] < 0
        return i[met], j[met], np.zeros(int(met.sum()), dtype=int)
    ends = (stretch.first, stretch.second)
    strides = [g / (e.stride * e.speed_rad_s) for g, e in zip(gaps, ends, strict=True)]
    least = np.floor(np.minimum(*strides)).astype(int) + 1
    count = np.maximum(np.ceil(np.maximum(*strides)).astype(int) - least, 0)
    first = np.repeat(np.cumsum(count) - count, count)
    beats = np.repeat(least, count) + np.arange(count.sum()) - first
    return np.repeat(i, count), np.repeat(j, count), beats


def _may_touch(
    stretch: Stretch,
    grid: ComplexArray,
    tolerance: FloatArray,
    drift: FloatArray,
    narrowest: float,
) -> bool:
    """Whether two paths may meet where they do not seem to, and drive each other.

    They do not cross, or so near to an end that the meeting may lie on either side of it.

    `drift`: as of `_drift`; the others as of `_meeting`, and at most what it takes for growth.
    """
    i, j = np.nonzero(np.triu(stretch.counted & stretch.counted[:, None], 1))
    rise = stretch.first.stride * (stretch.first.speed_rad_s + _PARTS * stretch.width)
    gap = grid.imag[i] - grid.imag[j]
    beats = np.zeros(i.size, dtype=int)
    if stretch.first.stride:
        away = np.abs(gap - rise * np.round(gap / rise)).argmin(axis=1)
        beats = np.round(gap[np.arange(i.size), away] / rise[away]).astype(int)
    gap = gap - np.outer(beats, rise)
    least, most = np.abs(gap).min(axis=1), np.abs(gap).max(axis=1)
    crossed = gap[:, 0] * gap[:, -1] < 0
    clear = np.where(crossed, np.abs(gap[:, [0, -1]]).min(axis=1), least)
    near = clear <= drift[i] + drift[j]
    i, j, beats, spread = i[near], j[near], beats[near], (most - least)[near]
    able, strength = _driven(stretch, grid, (i, j, beats), np.ones((2, i.size)), tolerance)
    return bool((able & (2.0 * strength * stretch.width > narrowest * spread)).any())


def _joined(pieces: list[Piece]) -> list[Piece]:
    """Join neighbours that both grow, or both do not."""
    joined: list[Piece] = []
    for piece in pieces:
        if joined and joined[-1].grows == piece.grows:
            joined[-1] = joined[-1]._replace(high=piece.high)
        else:
            joined.append(piece)
    return joined
