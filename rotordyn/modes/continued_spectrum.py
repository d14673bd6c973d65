"""Lowest modes of damped systems at a speed near one whose whole spectrum is known.

In the modes of the known speed, A(Ω) = Λ + E(Ω). The subspace of the lowest ones is followed: with
the others' part P of it, E21 + (Λ2 + E22) P − P (Λ1 + E11) − P E12 P = 0 (Stewart and Sun 1990,
Matrix Perturbation Theory, section V.2), and their eigenvalues are those of Λ1 + E11 + E12 P. All
others are eigenvalues of Λ2 + E22 − P E12, which lie in Gershgorin's discs: that none of them is as
low proves that none is missing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.linalg as nla
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, SpeedMatrices, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, real_times
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.modes.eigen import Modes, normalised
from solidwhirl.rotordyn.modes.left_vectors import dynamic_stiffness
from solidwhirl.rotordyn.modes.whirl import separated_whirl

# Modes beyond the needed ones among which the widest gap of frequency is looked for.
_FEWEST_MORE, _MOST_MORE = 5, 12
# A part of the modes beyond this saves no time.
_MOST = 0.5
# Iterations at most, the relative change of P at rest, and what factor of convergence is too slow.
_STEPS, _AT_REST, _SLOW = 30, 1e-11, 0.6
# Places that P is expected from at most, no nearer than this part of the way from the known speed.
_MOST_PLACES, _SIDE_BY_SIDE = 10, 1e-2
# |Im λ| below this fraction of |λ| is real.
_REAL_FRACTION = 1e-6
# Modes of a known speed are as good as this (relative) where they serve as a basis.
_GOOD = 1e-9
# Inverse iterations for the vector of a real eigenvalue, and how far beside it.
_REAL_STEPS, _BESIDE = 3, 1e-11


class _Basis(NamedTuple):
    """Real basis of states: of pairs Re x, then Im x; then of real eigenvalues x.

    `rates`: λ of pairs, `reals`: real λ; `shapes`, `moving`: x and λx, (n, columns).
    """

    rates: ComplexArray
    reals: FloatArray
    shapes: FloatArray
    moving: FloatArray


class Known(NamedTuple):
    """A speed with its whole spectrum: lowest modes, the others, and E per cause.

    `dual`: what maps forces to the coordinates of states, (2n, n), lowest first; `by_spin`: E per
    rad/s of the gyroscopic matrix, `by_square`: per (rad/s)² of the centrifugal stiffness.
    """

    speed_rad_s: float
    matrices: SpeedMatrices
    lowest: _Basis
    others: _Basis
    dual: FloatArray
    by_spin: FloatArray
    by_square: FloatArray | None


def known_spectrum(assembled: AssembledSystem, modes: Modes, needed: int) -> Known | None:
    """Return what modes at other speeds are found from.

    `modes`: all of a system at a speed; `needed`: of how many lowest ones. None if the system tells
    families of modes apart or has motions without stiffness, its modes are no basis, or few would
    be left out.
    """
    n, count = assembled.size, modes.eigenvalues.size
    if (
        modes.family is not None
        or modes.zero_count
        or modes.negative_stiffness_count
        or assembled.depends_on_frequency
        or assembled.is_conservative
        or 2 * count + modes.real_eigenvalues.size != 2 * n
    ):
        return None
    kept = _cut(modes.eigenvalues.imag, needed)
    if kept is None or 2 * kept + modes.real_eigenvalues.size > _MOST * 2 * n:
        return None
    matrices = matrices_at_speed(assembled, modes.speed_rad_s)
    reals = modes.real_eigenvalues
    real_shapes = np.empty((n, reals.size))
    for at, value in enumerate(reals):
        real_shapes[:, at] = _real_shape(matrices, float(value))
    lowest = _basis(matrices, modes, np.arange(kept), reals, real_shapes)
    none = np.empty(0), np.empty((n, 0))
    others = _basis(matrices, modes, np.arange(kept, count), *none)
    top = np.hstack((lowest.shapes, others.shapes))
    bottom = np.hstack((lowest.moving, others.moving))
    try:
        inverse = nla.inv(np.vstack((top, bottom)))
        dual = la.cho_solve(la.cho_factor(matrices.mass), inverse[:, n:].T).T
    except la.LinAlgError:
        return None
    square = assembled.centrifugal_stiffness
    known = Known(
        speed_rad_s=modes.speed_rad_s,
        matrices=matrices,
        lowest=lowest,
        others=others,
        dual=dual,
        by_spin=-dual @ (assembled.gyroscopic @ bottom + assembled.circulatory_stiffness @ top),
        by_square=-dual @ (square @ top) if square.any() else None,
    )
    # the basis reproduces the matrices: W A V = Λ
    velocity = matrices.damping + matrices.gyroscopic
    found = inverse[:, :n] @ bottom - dual @ (matrices.stiffness @ top + velocity @ bottom)
    size = lowest.shapes.shape[1]
    miss = found[:size, :size] - _diagonal(lowest)
    if not la.norm(miss) <= _GOOD * la.norm(_diagonal(lowest)):
        return None
    return known


def _cut(frequencies: FloatArray, needed: int) -> int | None:
    """Return how many modes to keep: the needed ones and those up to the widest gap beyond."""
    first, last = needed + _FEWEST_MORE, min(needed + _MOST_MORE, frequencies.size - 1)
    if first > last:
        return None
    ratios = frequencies[first : last + 1] / frequencies[first - 1 : last]
    return first + int(ratios.argmax())


def _real_shape(matrices: SpeedMatrices, value: float) -> FloatArray:
    """Return the vector of a real eigenvalue by inverse iteration."""
    factors = la.lu_factor(dynamic_stiffness(matrices, value * (1.0 + _BESIDE)).real)
    shape = np.ones(len(matrices.mass))
    for _ in range(_REAL_STEPS):
        shape = la.lu_solve(factors, shape)
        shape = shape / la.norm(shape)
    return np.asarray(shape)


def _basis(
    matrices: SpeedMatrices,
    modes: Modes,
    at: IntArray,
    reals: FloatArray,
    real_shapes: FloatArray,
) -> _Basis:
    """Return the states of some modes at unit kinetic energy, so that entries of E compare."""
    rates, shapes = modes.eigenvalues[at], modes.shapes[:, at]
    shapes = shapes / np.abs(rates)
    inertia = np.sqrt((real_shapes * (matrices.mass @ real_shapes)).sum(axis=0))
    real_shapes = real_shapes / (inertia * np.abs(reals))
    moving = rates * shapes
    return _Basis(
        rates=rates,
        reals=reals,
        shapes=np.hstack((shapes.real, shapes.imag, real_shapes)),
        moving=np.hstack((moving.real, moving.imag, reals * real_shapes)),
    )


def _diagonal(basis: _Basis) -> FloatArray:
    """Return Λ in a real basis: A Re x = σ Re x − ω Im x, A Im x = ω Re x + σ Im x."""
    pairs = basis.rates.size
    matrix = np.diag(np.concatenate((basis.rates.real, basis.rates.real, basis.reals)))
    at = np.arange(pairs)
    matrix[at, pairs + at], matrix[pairs + at, at] = basis.rates.imag, -basis.rates.imag
    return matrix


class NearModes:
    """Find the lowest modes at speeds around a known one, each from those before."""

    def __init__(self, assembled: AssembledSystem, known: Known) -> None:
        self.assembled, self.known = assembled, known
        none = np.zeros((known.others.shapes.shape[1], known.lowest.shapes.shape[1]))
        self._places: dict[float, FloatArray] = {known.speed_rad_s: none}

    def at(self, speed_rad_s: float) -> Modes | None:
        """Return the lowest modes at a speed, and all real eigenvalues.

        As `modes_at_speed` returns them, but those alone that lie below all others for certain.
        None where the subspace does not come to rest, the others may be as low, or K is not
        positive definite.
        """
        known = self.known
        matrices = matrices_at_speed(self.assembled, speed_rad_s)
        # K of the known speed is positive definite
        same = np.array_equal(matrices.stiffness, known.matrices.stiffness)
        if not same and not _is_definite(matrices.stiffness):
            return None
        change = _change(known, self.assembled, speed_rad_s)
        found = _followed(known, change, self._expected(speed_rad_s))
        if found is None:
            return None
        # a polynomial through places side by side magnifies their rounding
        nearest = min(abs(speed_rad_s - place) for place in self._places)
        if nearest > _SIDE_BY_SIDE * abs(speed_rad_s - known.speed_rad_s):
            self._places[speed_rad_s] = found[0]
        return _modes(known, self.assembled, matrices, speed_rad_s, change, found)

    def _expected(self, speed_rad_s: float) -> FloatArray:
        """Return P as a polynomial through the nearest places."""
        places = np.array(sorted(self._places, key=lambda at: abs(at - speed_rad_s))[:_MOST_PLACES])
        apart = places[:, None] - places
        away = speed_rad_s - places
        expected = np.zeros_like(self._places[self.known.speed_rad_s])
        for k, place in enumerate(places):
            others = np.arange(places.size) != k
            expected += np.prod(away[others] / apart[k, others]) * self._places[float(place)]
        return expected


def _modes(
    known: Known,
    assembled: AssembledSystem,
    matrices: SpeedMatrices,
    speed_rad_s: float,
    change: FloatArray,
    found: tuple[FloatArray, float],
) -> Modes:
    """Return the modes of a subspace that lie below a bound."""
    part, bound = found
    size = known.lowest.shapes.shape[1]
    low = _diagonal(known.lowest) + change[:size, :size] + change[:size, size:] @ part
    solved("continued")
    values, vectors = nla.eig(low)
    is_real = np.abs(values.imag) <= _REAL_FRACTION * np.abs(values)
    at = np.flatnonzero(~is_real & (values.imag > 0) & (values.imag < bound))
    at = at[np.argsort(values.imag[at], kind="stable")]
    rates = values[at]
    shapes = real_times(known.lowest.shapes + known.others.shapes @ part, vectors[:, at])
    if speed_rad_s != 0:
        shapes = separated_whirl(assembled, rates, shapes)
    return Modes(
        speed_rad_s=speed_rad_s,
        eigenvalues=rates,
        shapes=normalised(shapes, matrices.mass),
        real_eigenvalues=np.sort(values.real[is_real]),
        zero_count=0,
        negative_stiffness_count=0,
    )


def _is_definite(stiffness: FloatArray) -> bool:
    try:
        la.cholesky(0.5 * (stiffness + stiffness.T), check_finite=False)
    except la.LinAlgError:
        return False
    return True


def _change(known: Known, assembled: AssembledSystem, speed: float) -> FloatArray:
    """Return E at a speed, (2n, 2n)."""
    change = (speed - known.speed_rad_s) * known.by_spin
    if known.by_square is not None:
        change += (speed**2 - known.speed_rad_s**2) * known.by_square
    for joint in assembled.law_joints:
        there, here = joint.coefficients(speed), joint.coefficients(known.speed_rad_s)
        k, c = (a - b for a, b in zip(there, here, strict=True))
        moved = [
            np.hstack([joint.motion @ getattr(b, name) for b in (known.lowest, known.others)])
            for name in ("shapes", "moving")
        ]
        change -= (known.dual @ joint.motion.T) @ (k @ moved[0] + c @ moved[1])
    return change


class _Rows:
    """Complex coordinates of a real matrix whose rows are those of pairs, columns of any basis."""

    def __init__(self, rows: _Basis, columns: _Basis) -> None:
        self._half, self._pairs = rows.rates.size, columns.rates.size

    def complex(self, matrix: FloatArray) -> ComplexArray:
        """Return columns of λ, of λ*, and of real λ."""
        h, p = self._half, self._pairs
        even, odd = matrix[:h], matrix[h:]
        out = np.empty((h, matrix.shape[1]), dtype=complex)
        np.add(even[:, :p], odd[:, p : 2 * p], out=out.real[:, :p])
        np.subtract(even[:, p : 2 * p], odd[:, :p], out=out.imag[:, :p])
        np.subtract(even[:, :p], odd[:, p : 2 * p], out=out.real[:, p : 2 * p])
        np.add(even[:, p : 2 * p], odd[:, :p], out=out.imag[:, p : 2 * p])
        out.real[:, 2 * p :], out.imag[:, 2 * p :] = even[:, 2 * p :], odd[:, 2 * p :]
        np.negative(out.imag[:, p:], out=out.imag[:, p:])
        return out

    def real(self, matrix: ComplexArray) -> FloatArray:
        """Return the real matrix of complex coordinates."""
        h, p = self._half, self._pairs
        one, other, reals = matrix[:, :p], matrix[:, p : 2 * p], matrix[:, 2 * p :]
        out = np.empty((2 * h, matrix.shape[1]))
        np.add(one.real, other.real, out=out[:h, :p])
        np.subtract(one.imag, other.imag, out=out[:h, p : 2 * p])
        np.add(one.imag, other.imag, out=out[h:, :p])
        np.subtract(one.real, other.real, out=out[h:, p : 2 * p])
        np.negative(out[h:, :p], out=out[h:, :p])
        out[:, : 2 * p] *= 0.5
        out[:h, 2 * p :], out[h:, 2 * p :] = reals.real, -reals.imag
        return out


def _rates(basis: _Basis, own: FloatArray) -> ComplexArray:
    """Return λ, λ* and real λ with the diagonal of E in a real basis, (columns,)."""
    p, at = basis.rates.size, np.arange(basis.rates.size)
    even = own[at, at] + own[p + at, p + at]
    shift = 0.5 * (even + 1j * (own[at, p + at] - own[p + at, at]))
    pairs = basis.rates + shift
    real = basis.reals + np.diag(own)[2 * p :]
    return np.concatenate((pairs, pairs.conj(), real))


def _followed(
    known: Known, change: FloatArray, part: FloatArray
) -> tuple[FloatArray, float] | None:
    """Return P, and a frequency below which no other mode lies; None if there is none.

    `part`: about P.
    """
    size = known.lowest.shapes.shape[1]
    own, across = change[:size, :size], change[:size, size:]
    back, rest = change[size:, :size], change[size:, size:]
    rows = _Rows(known.others, known.lowest)
    count = known.others.rates.size
    inverse = 1.0 / (_rates(known.others, rest)[:count, None] - _rates(known.lowest, own))
    low, high = own + _diagonal(known.lowest), rest + _diagonal(known.others)
    before = 1.0
    for step in range(_STEPS):
        miss = high @ part
        miss += back
        miss -= part @ (low + across @ part)
        move = rows.real(rows.complex(miss) * inverse)
        part = part - move
        moved, whole = float(nla.norm(move)), float(nla.norm(part))
        rate = moved / before if step else 1.0
        if not np.isfinite(moved) or (step > 3 and rate > _SLOW):
            return None
        # what the next iterations would move
        if moved * min(1.0, rate / (1.0 - _SLOW)) <= _AT_REST * whole:
            break
        before = moved or 1.0
    else:
        return None
    bound = _lowest_other(known, rest - part @ across)
    return (part, bound) if bound > 0 else None


def _lowest_other(known: Known, rest: FloatArray) -> float:
    """Return the smallest |Im λ| in Gershgorin's discs of the others."""
    count = known.others.rates.size
    entries = 0.5 * _Rows(known.others, known.others).complex(rest)
    at = np.arange(count)
    centre = (known.others.rates + entries[at, at]).imag
    sizes = np.sqrt(entries.real**2 + entries.imag**2)
    radius = sizes.sum(axis=1) - sizes[at, at]
    return float((np.abs(centre) - radius).min())
