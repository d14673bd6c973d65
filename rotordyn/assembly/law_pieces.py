"""Speed laws of bearings as polynomials, piece by piece: values, slopes, extrema and structure.

What a law is (isotropic, symmetric, undamped) is read from its coefficients here, never from values
at some speeds.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix, ReadOnlyArrays

# Coefficients below this fraction of the largest, over the width of a piece, are rounding.
_ROUNDING = 1e-16


class BearingCoefficients(NamedTuple):
    """Stiffness in N/m and damping in N s/m on (ux, uy) at one speed, each (2, 2)."""

    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class LawPieces(ReadOnlyArrays):
    """Hold the coefficients of a bearing on (ux, uy) as polynomials of the speed.

    `starts_rad_s`: speeds at which the pieces begin, rising, the first 0; the last piece has no
    end. `polynomials`: coefficients in the speed beyond the start of a piece, lowest order first,
    of stiffness and damping, shape (pieces, degree + 1, 2, 2, 2).
    """

    starts_rad_s: tuple[float, ...]
    polynomials: FloatArray

    @property
    def knots_rad_s(self) -> tuple[float, ...]:
        """Speeds above 0 at which the polynomials change, rising."""
        return self.starts_rad_s[1:]

    @property
    def has_cross_terms(self) -> bool:
        """Whether ux and uy are coupled at any speed."""
        return bool(self.polynomials[..., 0, 1].any() or self.polynomials[..., 1, 0].any())

    @property
    def is_isotropic(self) -> bool:
        """Whether xx = yy and xy = yx = 0 at all speeds."""
        same = np.array_equal(self.polynomials[..., 0, 0], self.polynomials[..., 1, 1])
        return same and not self.has_cross_terms

    @property
    def is_symmetric(self) -> bool:
        """Whether xy = yx in stiffness and damping at all speeds."""
        return np.array_equal(self.polynomials[..., 0, 1], self.polynomials[..., 1, 0])

    @property
    def has_symmetric_stiffness(self) -> bool:
        """Whether xy = yx in the stiffness at all speeds."""
        stiffness = self.polynomials[:, :, 0]
        return np.array_equal(stiffness[..., 0, 1], stiffness[..., 1, 0])

    @property
    def is_undamped(self) -> bool:
        """Whether the damping is zero at all speeds."""
        return not self.polynomials[:, :, 1].any()

    def at(self, speed_rad_s: float) -> BearingCoefficients:
        """Return the coefficients at a speed, not negative."""
        piece = max(0, bisect_right(self.starts_rad_s, speed_rad_s) - 1)
        return _valued(self.polynomials[piece], speed_rad_s - self.starts_rad_s[piece])

    def along(self, speeds_rad_s: FloatArray) -> BearingCoefficients:
        """Return the coefficients at speeds, not negative, of shape (s,): (s, 2, 2) each."""
        starts = np.asarray(self.starts_rad_s)
        pieces = np.maximum(np.searchsorted(starts, speeds_rad_s, side="right") - 1, 0)
        beyond = (speeds_rad_s - starts[pieces]).reshape(-1, 1, 1, 1)
        rows = np.moveaxis(self.polynomials, 1, 0)[:, pieces]
        values = np.zeros(rows.shape[1:])
        for row in rows[::-1]:
            values = values * beyond + row
        return BearingCoefficients(values[:, 0], values[:, 1])

    def slopes(self, speed_rad_s: float) -> tuple[BearingCoefficients, BearingCoefficients]:
        """Return the derivatives below and above a speed, which differ at a corner only.

        `speed_rad_s`: rad/s, not negative. Returns per rad/s.
        """
        starts = self.starts_rad_s
        orders = np.arange(1, self.polynomials.shape[1]).reshape(-1, 1, 1, 1)
        sides = (bisect_left(starts, speed_rad_s), bisect_right(starts, speed_rad_s))
        pieces = [max(0, side - 1) for side in sides]
        below, above = (
            _valued(orders * self.polynomials[k, 1:], speed_rad_s - starts[k]) for k in pieces
        )
        return below, above

    def over_reference(self, speed_ratio: float) -> LawPieces:
        """Return the pieces as functions of |Ω|, for the speed |speed_ratio · Ω|."""
        ratio = abs(float(speed_ratio))
        if ratio == 1.0:
            return self
        if ratio == 0.0:
            return LawPieces(starts_rad_s=(0.0,), polynomials=self.polynomials[:1, :1])
        powers = ratio ** np.arange(self.polynomials.shape[1]).reshape(-1, 1, 1, 1)
        starts = tuple(start / ratio for start in self.starts_rad_s)
        return LawPieces(starts_rad_s=starts, polynomials=self.polynomials * powers)

    def times(self, factor: float) -> LawPieces:
        """Return all coefficients times a factor."""
        return LawPieces(starts_rad_s=self.starts_rad_s, polynomials=factor * self.polynomials)

    def of_motions(self, motions: Matrix) -> ScalarPieces:
        """Return mᴴ k m of the symmetric part of the stiffness over the speed; m: (2, s)."""
        stiffness = self.polynomials[:, :, 0]
        even = 0.5 * (stiffness + stiffness.swapaxes(-1, -2))
        rows = (motions.conj() * (even @ motions)).sum(axis=-2).real
        return ScalarPieces(np.array(self.starts_rad_s), rows)

    def between(self, low_rad_s: float, high_rad_s: float) -> Iterator[LawPiece]:
        """Yield the pieces inside a range of speeds, not negative."""
        ends = (*self.starts_rad_s[1:], np.inf)
        for start, end, rows in zip(self.starts_rad_s, ends, self.polynomials, strict=True):
            low, high = max(start, low_rad_s), min(end, high_rad_s)
            if low < high:
                yield LawPiece(start, low, high, rows)

    def turning_speeds(self, low_rad_s: float, high_rad_s: float) -> FloatArray:
        """Return where the symmetric part of stiffness or damping may change its nature.

        Returns knots, and speeds at which an entry is stationary or the determinant zero, rising.
        """
        found: list[float] = list(self.knots_rad_s)
        for piece in self.between(low_rad_s, high_rad_s):
            for which in (0, 1):
                xx, yy, xy = piece.symmetric(which)
                found += piece.roots(determinant(xx, yy, xy))
                for entry in (xx, yy, xy):
                    found += piece.roots(derivative(entry))
        speeds = np.unique(np.array(found, dtype=float))
        return np.asarray(speeds[(speeds > low_rad_s) & (speeds < high_rad_s)])


class ScalarPieces(NamedTuple):
    """Polynomials of the speed beyond the start of a piece, lowest order first.

    `starts`: (pieces,); `rows`: (pieces, degree + 1, s) of s quantities.
    """

    starts: FloatArray
    rows: FloatArray

    def at(self, speeds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return value and slope of each quantity at a speed of its own, not negative, (s,)."""
        pieces = np.maximum(np.searchsorted(self.starts, speeds, side="right") - 1, 0)
        beyond = speeds - self.starts[pieces]
        value, slope = np.zeros((2, speeds.size))
        for row in self.rows[pieces, :, range(speeds.size)].T[::-1]:
            slope = slope * beyond + value
            value = value * beyond + row
        return value, slope


class LawPiece(NamedTuple):
    """A polynomial of the speed beyond a start, (degree + 1, 2, 2, 2), on a range of speeds."""

    start: float
    low: float
    high: float
    rows: FloatArray

    def symmetric(self, which: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the polynomials xx, yy and (xy + yx)/2 of stiffness (0) or damping (1)."""
        entries = self.rows[:, which]
        return entries[:, 0, 0], entries[:, 1, 1], 0.5 * (entries[:, 0, 1] + entries[:, 1, 0])

    def roots(self, coefficients: FloatArray) -> list[float]:
        """Return the speeds inside the range where a polynomial beyond the start is zero.

        Pairs of complex roots give their real part: near it a double root may be, by rounding.
        """
        offset, width = self.low - self.start, self.high - self.low
        if not np.isfinite(width):
            speeds = [self.start + x for x in _real_parts(np.asarray(coefficients))]
            return [speed for speed in speeds if self.low < speed]
        shifted = np.zeros(1)
        for value in np.asarray(coefficients)[::-1]:
            shifted = np.convolve(shifted, (offset, width))
            shifted[0] += value
        return [self.low + width * x for x in _real_parts(shifted) if 0.0 < x < 1.0]


def _valued(rows: FloatArray, beyond: float) -> BearingCoefficients:
    values = np.zeros(rows.shape[1:])
    for row in rows[::-1]:
        values = values * beyond + row
    return BearingCoefficients(values[0], values[1])


def determinant(xx: FloatArray, yy: FloatArray, xy: FloatArray) -> FloatArray:
    """Return xx · yy − xy² of polynomials, lowest order first, entries of a symmetric matrix."""
    return np.asarray(np.convolve(xx, yy) - np.convolve(xy, xy))


def derivative(coefficients: FloatArray) -> FloatArray:
    """Return the derivative of a polynomial, lowest order first, with a zero of highest order."""
    return np.append(np.arange(1, coefficients.size) * coefficients[1:], 0.0)


def _real_parts(coefficients: FloatArray) -> FloatArray:
    """Return the real parts of all roots of a polynomial, lowest order first."""
    size = float(np.abs(coefficients).max(initial=0.0))
    if size == 0.0:
        return np.empty(0)
    scaled = coefficients / size
    orders = np.flatnonzero(np.abs(scaled) > _ROUNDING)
    return np.asarray(np.roots(scaled[orders[-1] :: -1]).real, dtype=float)
