"""All critical speeds of undamped systems whose bearings depend on the speed, by counting signs.

D(Ω) = K(Ω) − Ω² N is singular at a critical speed, so the number of its negative eigenvalues
changes there (Sylvester). E = D/Ω² has the same signs and falls with Ω, in the order of Hermitian
matrices, as long as k(Ω)/Ω² of each bearing falls: then the numbers at two speeds tell exactly how
many critical speeds lie between. Elsewhere bounds of E over an interval either prove that there is
none, or the interval is halved. Both follow from the polynomials of the laws: k(Ω)/Ω² is stationary
where Ω k' − 2 k is zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.law_pieces import LawPieces, derivative, determinant
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, Matrix
from solidwhirl.rotordyn.core.dense import Scaled, scale_by_stiffness
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.critical_speeds.held_modes import SpeedMatrix, held_modes, refined_roots
from solidwhirl.rotordyn.critical_speeds.whirl_pencils import (
    Pencil,
    PencilLaw,
    negative_count_at_rest,
    scaled_at,
)

# Intervals are halved down to this width, relative to their upper end or to the whole region.
_SMALLEST, _PARTS = 1e-3, 64
# First speed looked at, as a fraction of the limit or the first speed at which a law turns, but
# not below the last fraction of the limit; quartered while something lies below it.
_START, _QUARTERINGS, _LOWEST = 1e-3, 5, 1e-6
# A fall of k(Ω)/Ω² counts as one up to this rise, relative.
_ROUNDING = 1e-13
# An extremum of an eigenvalue nearer to zero than this, relative to the largest, touches it.
_TOUCH = 1e-11
# Roots closer than this (relative) take their shapes from one eigenproblem; of those with vectors
# as parallel as this there is one.
_SAME_SPEED, _PARALLEL = 1e-8, 0.99
# Between roots further apart than this (relative) eigenvalues are counted.
_APART = 1e-5
# Parts of an interval in which bearings are held as in the middle for first guesses, and how far
# beyond its part (in Ω²) a guess may lie.
_HELD, _BEYOND = 3, 1.5


class SpeedRoots(NamedTuple):
    """Hold the critical speeds of one pencil.

    `speeds_rad_s`: rising, shape (k,); `shapes`: x, shape (m, k); `falls`: whether an eigenvalue of
    D turns negative there, as it does for a constant stiffness, or positive, shape (k,); `counts`:
    number of negative eigenvalues of D at rest and at the limit. `unresolved`: intervals in rad/s
    in which an eigenvalue touches zero to rounding: none or two.
    """

    speeds_rad_s: FloatArray
    shapes: Matrix
    falls: BoolArray
    counts: tuple[int, int]
    unresolved: tuple[tuple[float, float], ...]


class _Root(NamedTuple):
    """A speed, and the place of the eigenvalue of E that is zero there, by rising order.

    `vector`: the eigenvector in the basis of the search, where it is known already.
    """

    speed: float
    place: int
    falls: bool
    vector: Matrix | None = None


def speed_roots(pencil: Pencil, body_rate: float, limit_rad_s: float) -> SpeedRoots:
    """Find all speeds up to a limit at which D(Ω) is singular.

    `pencil`: with a positive (semi)definite constant part of K; the bearings with a law may have
    any stiffness. `limit_rad_s`: finite. Where k(Ω)/Ω² falls complete by the counts alone,
    elsewhere down to intervals of 1e-3 of the speed, and 1/64 of a piece of a law, in which an
    eigenvalue is taken to have one extremum at most. Raises AnalysisError if the constant part has
    a negative eigenvalue, the pieces of a law are not known, or the counts do not come to rest.
    """
    laws = _known(pencil.laws)
    _check_constant_part(pencil, body_rate)
    scaled = scaled_at(pencil, 0.0, body_rate)
    search = _Search(pencil, scaled, limit_rad_s)
    start, at_rest = _start(search, negative_count_at_rest(pencil, scaled), limit_rad_s)
    roots = []
    for low, high, falling in _regions(laws, start, limit_rad_s):
        roots += search.monotonic(low, high) if falling else search.bounded(low, high)
    search.note_touching_kinks(start, roots)
    roots.sort()
    falls = np.array([root.falls for root in roots], dtype=bool)
    at_limit = search.count(limit_rad_s)
    if np.count_nonzero(falls) - np.count_nonzero(~falls) != at_limit - at_rest:
        raise AnalysisError(
            f"{np.count_nonzero(falls)} modes were found to fall below the excitation and "
            f"{np.count_nonzero(~falls)} to rise above it, but the counts at rest and at the limit "
            f"are {at_rest} and {at_limit}"
        )
    speeds = np.array([root.speed for root in roots])
    shapes = search.shapes(roots)
    return SpeedRoots(speeds, shapes, falls, (at_rest, at_limit), tuple(search.unresolved))


def _check_constant_part(pencil: Pencil, body_rate: float) -> None:
    """Refuse a constant part of the stiffness that has a negative eigenvalue."""
    try:  # a positive definite one is told at a fraction of the work
        la.cholesky(pencil.stiffness, check_finite=False)
    except la.LinAlgError:
        found = scale_by_stiffness(pencil.stiffness, pencil.mass, body_rate).negative_count
        if found:
            raise AnalysisError(
                f"the constant part of the stiffness has {found} negative "
                "eigenvalues; give the bearing that has them a speed law, or damping"
            ) from None


def _start(search: _Search, at_rest: int, limit: float) -> tuple[float, int]:
    """Return a speed below which there is nothing, and the number of negative eigenvalues there.

    That number is the one at rest, unless a bearing that is soft at rest stiffens more quickly
    than the speed to the square; then it settles as the speed goes to zero.
    """
    turns = [limit, *(speed for law in search.pieces for speed in law.turning_speeds(0.0, limit))]
    first = max(_START * min(turns), _LOWEST * limit)
    speeds = [first * 0.25**step for step in range(_QUARTERINGS + 1)]
    counts = []
    for speed in speeds:
        counts.append(search.count(speed))
        if counts[-1] == at_rest:
            return speed, at_rest
    if len(set(counts[1:])) == 1:
        return speeds[1], counts[1]
    raise AnalysisError(
        f"from {speeds[0]:.3g} down to {speeds[-1]:.3g} rad/s {counts} modes lie below the "
        f"excitation, and {at_rest} at rest; a bearing changes too quickly with the speed there"
    )


def _known(laws: tuple[PencilLaw, ...]) -> tuple[LawPieces, ...]:
    """Return the pieces of all laws, refusing a law that does not tell them."""
    unknown = [law.bearing for law in laws if law.pieces is None]
    if unknown:
        raise AnalysisError(
            f"the speed laws of the bearings {unknown} do not tell their polynomials (`pieces` of "
            "`SpeedLaw`), so that undamped critical speeds are not found with certainty"
        )
    return tuple(law.pieces for law in laws if law.pieces is not None)


def _regions(
    laws: tuple[LawPieces, ...], low: float, high: float
) -> Iterator[tuple[float, float, bool]]:
    """Split a range of speed by whether k(Ω)/Ω² of all bearings falls, and at kinks of a law."""
    kinks = _kinks(laws, low, high)
    turns = [_stationary(pieces, low, high) for pieces in laws]
    speeds = np.unique(np.concatenate(([low, high], kinks, *turns)))
    middles = 0.5 * (speeds[1:] + speeds[:-1])
    falling = np.ones(middles.size, dtype=bool)
    for pieces in laws:
        falling &= np.array([_falls(pieces, float(speed)) for speed in middles])
    changes = np.flatnonzero(falling[1:] != falling[:-1]) + 1
    ends = np.flatnonzero(np.isin(speeds[1:-1], kinks) & ~(falling[1:] & falling[:-1])) + 1
    cuts = np.unique(np.concatenate(([0], changes, ends, [falling.size])))
    bounds = speeds[cuts].copy()
    for at in (int(np.searchsorted(cuts, change)) for change in changes):
        # Where an eigenvalue turns it may touch zero: that is no place to count at.
        if not np.isin(bounds[at], kinks):
            sign, side = (-1, at - 1) if falling[cuts[at - 1]] else (1, at + 1)
            room = 0.5 * abs(speeds[cuts[side]] - bounds[at])
            bounds[at] += sign * min(_SMALLEST * bounds[at], room)
    for begin, stop, cut in zip(bounds[:-1], bounds[1:], cuts[:-1], strict=True):
        yield float(begin), float(stop), bool(falling[cut])


def _kinks(laws: tuple[LawPieces, ...], low: float, high: float) -> FloatArray:
    """Return the speeds inside a range at which a law changes its polynomials, rising."""
    found = np.array([speed for law in laws for speed in law.knots_rad_s if low < speed < high])
    return np.asarray(np.unique(found), dtype=float)


# of one law at many stiffnesses of other bearings
@lru_cache(maxsize=64)
def _stationary(pieces: LawPieces, low: float, high: float) -> FloatArray:
    """Return where entries of k(Ω)/Ω² are stationary or its derivative is singular."""
    found: list[float] = []
    for piece in pieces.between(low, high):
        slopes = [_slope(entry, piece.start) for entry in piece.symmetric(0)]
        for numerator in (*slopes, determinant(*slopes)):
            found += piece.roots(numerator)
    return np.asarray(np.unique(np.array(found, dtype=float)), dtype=float)


def _slope(entry: FloatArray, start: float) -> FloatArray:
    """Return Ω k' − 2 k, the derivative of k/Ω² times Ω³, of a polynomial in Ω − start."""
    rate = start * derivative(entry) + np.arange(entry.size) * entry
    return np.asarray(rate - 2.0 * entry)


def _falls(pieces: LawPieces, speed: float) -> bool:
    """Whether Ω k' − 2 k is negative semidefinite at a speed that is no knot."""
    k, (_, slope) = pieces.at(speed)[0], pieces.slopes(speed)
    rate = speed * slope[0] - 2.0 * k
    even = 0.5 * (rate + rate.T)
    size = max(float(np.abs(k).max()), float(np.abs(speed * slope[0]).max()))
    return bool(la.eigvalsh(even)[-1] <= _ROUNDING * size)


def _placed(found: list[tuple[float, Matrix]], counts: tuple[int, int]) -> list[_Root] | None:
    """Return rising roots and vectors of a range with their places, from the counts at its ends.

    One root for each place: as many distinct ones as there are places are all; else None.
    """
    begin, end = counts
    places = range(min(counts), max(counts))
    if len(found) != len(places):
        return None
    order = places if end > begin else reversed(places)
    return [_Root(speed, at, end > begin, x) for at, (speed, x) in zip(order, found, strict=True)]


class _Search:
    """E(Ω) = K(Ω)/Ω² − N of one pencil in a basis in which K(0) is about one.

    Parameters
    ----------
    pencil, limit
        As for `speed_roots`.
    scaled
        K(0) and M, as `scaled_at` returns them.
    """

    def __init__(self, pencil: Pencil, scaled: Scaled, limit: float) -> None:
        self.basis = basis = _basis(scaled, limit)
        self.laws = tuple(law._replace(motion=law.motion @ basis) for law in pencil.laws)
        self.pieces = _known(pencil.laws)
        self.free = SpeedMatrix(
            stiffness=basis.conj().T @ pencil.stiffness @ basis,
            inertia=basis.conj().T @ pencil.inertia @ basis,
            motions=np.vstack([law.motion for law in self.laws]),
            laws=self.pieces,
        )
        self.turns = tuple(
            np.union1d(_stationary(pieces, 0.0, limit), pieces.knots_rad_s)
            for pieces in self.pieces
        )
        self.unresolved: list[tuple[float, float]] = []
        self._known: dict[float, FloatArray] = {}

    def matrix(self, speed: float) -> Matrix:
        """Return E."""
        return self._assembled(speed, [law.stiffness(speed) / speed**2 for law in self.laws])

    def _assembled(self, speed: float, over_squares: list[FloatArray]) -> Matrix:
        """Return E with K/Ω² at a speed and k/Ω² of the bearings as given."""
        even = np.zeros((2 * len(over_squares), 2 * len(over_squares)))
        for at, k in enumerate(over_squares):
            even[2 * at : 2 * at + 2, 2 * at : 2 * at + 2] = 0.5 * (k + k.T)
        bearings = self.free.motions.conj().T @ (even @ self.free.motions)
        return np.asarray(self.free.stiffness / speed**2 + bearings - self.free.inertia)

    def eigenvalues(self, speed: float) -> FloatArray:
        """Return the eigenvalues of E, rising, computed once."""
        if speed not in self._known:
            solved("eigenproblems")
            self._known[speed] = la.eigvalsh(self.matrix(speed))
        return self._known[speed]

    def count(self, speed: float) -> int:
        """Return the number of negative eigenvalues of E."""
        if speed in self._known:
            return int(np.count_nonzero(self._known[speed] < 0))
        return _negative_count(self.matrix(speed))

    def monotonic(self, low: float, high: float) -> list[_Root]:
        """Return the roots of an interval in which every eigenvalue is monotonic."""
        counts = self.count(low), self.count(high)
        found = self._refined(low, high)
        roots = _placed(found, counts)
        return self._counted(found, (low, high), counts) if roots is None else roots

    def _counted(
        self, found: list[tuple[float, Matrix]], ends: tuple[float, float], at_ends: tuple[int, int]
    ) -> list[_Root]:
        """Return all roots of an interval from some of them, by counts between those."""
        groups: list[list[tuple[float, Matrix]]] = []
        for root in found:
            if groups and root[0] - groups[-1][-1][0] <= _APART * root[0]:
                groups[-1].append(root)
            else:
                groups.append([root])
        middles = [0.5 * (one[-1][0] + other[0][0]) for one, other in pairwise(groups)]
        edges = [ends[0], *middles, ends[1]]
        counts = [at_ends[0], *(self.count(speed) for speed in middles), at_ends[1]]
        roots = []
        # without any root there is one range all the same
        for own, between, both in zip(
            groups or [[]], pairwise(edges), pairwise(counts), strict=True
        ):
            placed = _placed(own, both)
            if placed is None:
                placed = [self._root(p, *between) for p in range(min(both), max(both))]
            roots += placed
        return roots

    def _refined(self, low: float, high: float) -> list[tuple[float, Matrix]]:
        """Return distinct roots of an interval and their vectors, from bearings held as they are.

        In each part of the interval E with the bearings as in its middle gives speeds and vectors
        by one eigenproblem. What comes twice or leaves the interval is left out.
        """
        found: list[tuple[float, Matrix]] = []
        edges = np.geomspace(low, high, _HELD + 1)
        for begin, end in pairwise(edges.tolist()):
            held = held_modes(self.free, float(np.sqrt(begin * end)))
            if held is None:
                return []
            guesses = held.inverse_squares
            near = (guesses > end**-2 / _BEYOND) & (guesses < begin**-2 * _BEYOND)
            roots = refined_roots(self.free, held, np.flatnonzero(near))
            found += [root for root in roots if low < root[0] <= high]
        found.sort(key=lambda root: root[0])
        kept: list[tuple[float, Matrix]] = []
        for speed, vector in found:
            if not any(
                speed - other <= _SAME_SPEED * speed and abs(np.vdot(one, vector)) > _PARALLEL
                for other, one in kept[-4:]
            ):
                kept.append((speed, vector))
        return kept

    def bounded(self, low: float, high: float) -> list[_Root]:
        """Return the roots of an interval without kinks, halving it where bounds do not decide."""
        roots, waiting, part = [], [(low, high)], (high - low) / _PARTS
        while waiting:
            begin, end = waiting.pop()
            least, most = self._count_bounds(begin, end)
            if least == most:
                continue
            if end - begin > min(_SMALLEST * end, part):
                middle = 0.5 * (begin + end)
                waiting += [(begin, middle), (middle, end)]
                continue
            for place in range(least, most):
                roots += self._roots_of_one(place, begin, end)
        return roots

    def _count_bounds(self, low: float, high: float) -> tuple[int, int]:
        """Return bounds of the number of negative eigenvalues over an interval."""
        upper, lower = [], []
        for law, turns in zip(self.laws, self.turns, strict=True):
            inside = turns[(turns > low) & (turns < high)]
            values = np.array([law.stiffness(float(v)) / v**2 for v in (low, *inside, high)])
            over = 0.5 * (values + values.transpose(0, 2, 1))
            beyond = _ROUNDING * np.abs(over).max(axis=0)
            top, bottom = over.max(axis=0) + beyond, over.min(axis=0) - beyond
            # Diagonal entries take up what the cross term may vary.
            spread = 0.5 * (top[0, 1] - bottom[0, 1]) * np.eye(2)
            cross = 0.5 * (top[0, 1] + bottom[0, 1]) * np.array([[0.0, 1.0], [1.0, 0.0]])
            upper.append(np.diag(np.diag(top)) + cross + spread)
            lower.append(np.diag(np.diag(bottom)) + cross - spread)
        fewest, most = self._assembled(low, upper), self._assembled(high, lower)
        return _negative_count(fewest), _negative_count(most)

    def _roots_of_one(self, place: int, low: float, high: float) -> list[_Root]:
        """Return the roots of one eigenvalue that has one extremum at most."""
        begin, end = (float(self.eigenvalues(speed)[place]) for speed in (low, high))
        if (begin < 0) != (end < 0):
            return [self._root(place, low, high)]
        sign = -1.0 if begin < 0 else 1.0
        found = scipy.optimize.minimize_scalar(
            lambda speed: sign * self.eigenvalues(float(speed))[place],
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-6 * (high - low)},
        )
        turn = float(found.x)
        if found.fun < 0:
            return [self._root(place, low, turn), self._root(place, turn, high)]
        if found.fun <= _TOUCH * np.abs(self.eigenvalues(turn)).max():
            self.unresolved.append((low, high))
        return []

    def note_touching_kinks(self, low: float, roots: list[_Root]) -> None:
        """Keep in mind kinks at which an eigenvalue touches zero without a root."""
        for kink in _kinks(self.pieces, low, np.inf):
            values = np.abs(self.eigenvalues(float(kink)))
            known = any(abs(root.speed - kink) <= _SAME_SPEED * kink for root in roots)
            if values.min() <= _TOUCH * values.max() and not known:
                self.unresolved.append((float(kink), float(kink)))

    def _root(self, place: int, low: float, high: float) -> _Root:
        """Return where one eigenvalue changes its sign, which it does once."""

        def value(inverse_square: float) -> float:
            return float(self.eigenvalues(float(inverse_square**-0.5))[place])

        # What is known from other roots narrows the bracket.
        falls = bool(self.eigenvalues(low)[place] >= 0)
        for speed in sorted(speed for speed in self._known if low < speed < high):
            if (self._known[speed][place] >= 0) == falls:
                low = speed
            else:
                high = speed
                break
        # In 1/Ω² the eigenvalues of a constant stiffness are straight lines.
        ends = low**-2, high**-2
        if value(ends[0]) == 0:
            return _Root(low, place, falls)
        if (value(ends[0]) < 0) == (value(ends[1]) < 0):
            # The change lies within the rounding of the two ends.
            return _Root(low, place, falls)
        root = scipy.optimize.brentq(value, ends[1], ends[0], xtol=1e-15 * ends[1], rtol=1e-15)
        return _Root(float(root**-0.5), place, falls)

    def shapes(self, roots: list[_Root]) -> Matrix:
        """Return the shapes at the roots; those of equal speeds are independent."""
        columns: list[Matrix] = []
        start = 0
        for stop in range(1, len(roots) + 1):
            if stop < len(roots):
                step = roots[stop].speed - roots[stop - 1].speed
                if step <= _SAME_SPEED * roots[stop].speed:
                    continue
            group = roots[start:stop]
            if len(group) == 1 and group[0].vector is not None:
                columns.append(self.basis @ group[0].vector)
                start = stop
                continue
            speed = float(np.mean([root.speed for root in group]))
            solved("eigenproblems")
            vectors = la.eigh(self.matrix(speed))[1]
            columns += [self.basis @ vectors[:, root.place] for root in group]
            start = stop
        if not columns:
            return np.empty((self.basis.shape[0], 0))
        return np.hstack([column[:, None] for column in columns])


def _negative_count(matrix: Matrix) -> int:
    """Return the number of negative eigenvalues of a Hermitian matrix, by LDLᴴ (Sylvester)."""
    name = "hetrf" if np.iscomplexobj(matrix) else "sytrf"
    (factorise,) = la.get_lapack_funcs((name,), (matrix,))
    factors, pivots, _ = factorise(matrix, lower=True)
    # a block of two has one negative eigenvalue (Bunch and Kaufman 1977)
    alone = np.diag(factors).real[pivots > 0]
    return int(np.count_nonzero(alone < 0)) + int(np.count_nonzero(pivots < 0)) // 2


def _basis(scaled: Scaled, limit: float) -> Matrix:
    """Return P with Pᴴ(K(0) + σ²M)P = 1; σ = 0 if K(0) is positive definite."""
    shift = 0.0 if scaled.is_definite else limit**2
    while True:
        try:
            lower = la.cholesky(scaled.stiffness + shift * scaled.mass, lower=True)
            break
        except la.LinAlgError:
            shift = max(4.0 * shift, limit**2)
    inverse = la.solve_triangular(lower, np.eye(scaled.scale.size), lower=True, trans="C")
    return np.asarray(scaled.scale[:, None] * inverse)
