"""Eigenvalues of a system as continuous paths over the speed, with their exact slopes.

A system falls apart into blocks that never couple: the complex form where it is the same in all
directions, else the coordinates that no matrix joins. Each block is solved on its own, at any
speed, for all eigenvalues of λ²M + λV(Ω) + K(Ω) with right and left vectors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import (
    Side,
)
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    Matrix,
    together,
)
from solidwhirl.rotordyn.core.dense import (
    Roots,
    diagonal,
    dual_of,
    eigensolver_rounding,
    hermitian_part,
    reciprocal,
    scale_by_stiffness,
    sharpened,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.modes.damping import NEUTRAL

# Eigenvalues of K over M below this fraction of the largest do not set the shift.
_VISIBLE = 1e-13
# The shift as a fraction of the slowest rate: a larger one takes digits from slow decay;
_SLOW = 0.3
# and at least this of the fastest rate, which else loses its own.
_SLOWEST = 1e-6
# An eigenvalue below this fraction of the shift is a motion of a free body.
_FREE = 1e-5
# Eigenvalues closer than this (relative) share a subspace.
_SAME = 1e-6
# The vectors of a subspace whose condition is beyond this are left as they are.
_DEFECTIVE = 1e6
# How much a distance of eigenvalues weighs beside the MAC of their vectors.
_NEARNESS = 0.1


class Coefficients(NamedTuple):
    """V and K of a block, or their slopes over the speed, each (n, n)."""

    velocity: Matrix
    stiffness: Matrix


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Block:
    """Hold motions of a system that couple with no others: λ²M + λV(Ω) + K(Ω).

    `mass`: M, Hermitian, shape (n, n); `at`: V and K at a speed Ω in rad/s; `slopes`: dV/dΩ and
    dK/dΩ at a speed, on one side of it; `shift`: a real rate of the order of the slowest motion,
    1/s. `is_free`: whether some motion meets no stiffness at any speed: its zeros are no
    instability. `counted`: which of vectors (n, m) are motions of the machine, where an expansion
    has others too; shape (m,).
    """

    mass: Matrix
    at: Callable[[float], Coefficients]
    slopes: Callable[[float, Side], Coefficients]
    shift: float = 1.0
    is_free: bool = False
    counted: Callable[[ComplexArray], BoolArray] = lambda right: np.ones(right.shape[1], dtype=bool)

    def solve(self, speed_rad_s: float) -> BlockSpectral:
        """Return all eigenvalues at a speed, see `solve`."""
        return solve(self, speed_rad_s)

    def with_slopes(self, spectral: BlockSpectral, side: Side) -> BlockSpectral:
        """Return eigenvalues with their slopes over the speed, see `with_slopes`."""
        return with_slopes(self, spectral, side)

    def stretch_between(self, first: BlockSpectral, second: BlockSpectral) -> Stretch:
        """Pair the eigenvalues of two speeds, see `stretch_between`."""
        return stretch_between(self, first, second)

    def alike(self, first: BlockSpectral, second: BlockSpectral) -> tuple[FloatArray, IntArray]:
        """Return the MAC of all vectors at two speeds, and no strides, both (m, m)."""
        mac = _alike(self, first, second)
        return mac, np.zeros(mac.shape, dtype=int)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Spectral:
    """Hold all eigenvalues of a system at one speed.

    `values`: λ, shape (m,); exactly 0 for motions of free bodies. `slopes`: dλ/dΩ on one side of
    the speed, shape (m,). `tolerance`: real parts below this are neutral: rounding, or growth too
    slow to be seen; shape (m,). `counted`: those that are motions of the machine, shape (m,).
    `stride`: λ and λ + i stride Ω are the same motion; 0 where each is one of its own.
    """

    speed_rad_s: float
    values: ComplexArray
    slopes: ComplexArray
    tolerance: FloatArray
    counted: BoolArray
    stride: int = 0

    @property
    def excess(self) -> FloatArray:
        """Re λ less what counts as neutral, shape (m,); −inf of what does not count."""
        return np.where(self.counted, self.values.real - self.tolerance, -np.inf)

    @property
    def own(self) -> ComplexArray:
        """Eigenvalues that count."""
        return np.asarray(self.values[self.counted])

    @property
    def grows(self) -> bool:
        """Whether any motion grows."""
        return bool((self.excess > 0).any())

    def nearest(self, value: complex) -> tuple[int, complex]:
        """Return the eigenvalue that counts nearest to a value, its index first.

        It is lifted by the whole strides that bring it nearest.
        """
        values, beat = self.values, self.stride * self.speed_rad_s
        if beat:
            values = values + 1j * beat * np.round((value - values).imag / beat)
        index = int(np.where(self.counted, np.abs(values - value), np.inf).argmin())
        return index, complex(values[index])


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class BlockSpectral(Spectral):
    """Hold all m = 2n eigenvalues of a block at one speed, and their vectors.

    `right`, `left`: vectors x (n, m) and y (m, n), y_i [(λ_i + λ_j) M + V] x_j = 1 for i = j, 0
    else. `coefficients`: V and K there.
    """

    right: ComplexArray
    left: ComplexArray
    coefficients: Coefficients


def prepared(block: Block, body_rate: float, low: float, high: float) -> Block:
    """Return the block with its shift, and whether it is free.

    `body_rate`: as of an `AssembledSystem`. `low`, `high`: range of speeds it is solved in, rad/s.
    """
    rates, zeros = [], []
    # a motion that is free at three odd places is free at all of them
    for part in (0.2357, 0.5403, 0.8189):
        stiffness = block.at(low + part * (high - low)).stiffness
        scaled = scale_by_stiffness(hermitian_part(stiffness), block.mass, body_rate)
        zeros.append(scaled.zero_count)
        rates.append(np.abs(la.eigvalsh(scaled.stiffness, scaled.mass)))
    seen = np.concatenate(rates)
    seen = np.sqrt(seen[seen > _VISIBLE * seen.max()])
    if not seen.size:
        return replace(block, shift=max(abs(low), abs(high), 1.0), is_free=True)
    if min(zeros) > 0:
        return replace(block, shift=float(seen.min()), is_free=True)
    return replace(block, shift=float(max(_SLOW * seen.min(), _SLOWEST * seen.max())))


def solve(block: Block, speed_rad_s: float) -> BlockSpectral:
    """Return all eigenvalues of a block at a speed; slopes are zero until they are asked for.

    λ = s + 1/μ with a real shift s near the slowest motion, so that slow motions keep their
    digits, also where K is singular; P, the Hermitian part of D(s), is positive definite and its
    Cholesky factor scales the problem, see `spectrum.solve_general`.
    """
    found = block.at(speed_rad_s)
    shift, lower, full, scale = _factored(block, found)
    n = scale.size
    regular = np.eye(n) + _congruent(lower, 0.5 * (full - full.conj().T))
    companion = _companion(block, found.velocity, shift, lower, regular, scale)
    norm = float(la.norm(companion))
    solved("eigenproblems")
    inverse, vectors = la.eig(companion, overwrite_a=True, check_finite=False)
    vectors = vectors.astype(complex)
    dual = dual_of(vectors)
    right = scale[:, None] * la.solve_triangular(lower, vectors[:n], lower=True, trans="C")
    left = la.solve_triangular(lower, la.solve(regular.T, dual[:, :n].T), lower=True, trans="T")
    left = left.T * scale
    values = shift + reciprocal(inverse)
    tolerance = eigensolver_rounding(norm, dual, vectors) * np.abs(values - shift) ** 2
    if block.is_free:
        values = np.where(np.abs(values) <= _FREE * block.shift, 0.0, values)
    problem = (block.mass, found.velocity, found.stiffness)
    roots, alive = sharpened(problem, Roots(values, right, left, tolerance))
    values, left, tolerance = roots.values, roots.left, roots.tolerance
    return BlockSpectral(
        speed_rad_s=speed_rad_s,
        values=values,
        slopes=np.zeros_like(values),
        right=right,
        left=left,
        tolerance=np.where(alive, np.maximum(NEUTRAL * np.abs(values), tolerance), np.inf),
        coefficients=found,
        counted=block.counted(right),
    )


def _companion(
    block: Block,
    velocity: Matrix,
    shift: float,
    lower: Matrix,
    regular: Matrix,
    scale: FloatArray,
) -> Matrix:
    """Return the matrix whose eigenvalues are 1 / (λ − s)."""
    n = scale.size
    mass = scale[:, None] * block.mass * scale
    rate = _congruent(lower, scale[:, None] * velocity * scale + 2.0 * shift * mass)
    half = la.solve_triangular(lower, la.cholesky(mass, lower=True), lower=True)
    companion = np.zeros((2 * n, 2 * n), dtype=np.result_type(rate, regular, half))
    companion[:n] = -la.solve(regular, np.hstack((rate, half)))
    companion[n:, :n] = half.conj().T
    return companion


def _factored(block: Block, found: Coefficients) -> tuple[float, Matrix, Matrix, FloatArray]:
    """Return a shift s, the factor of P(s) and D(s) in coordinates scaled to a unit diagonal."""
    shift = block.shift
    while True:
        full = found.stiffness + shift * found.velocity + shift**2 * block.mass
        even = 0.5 * (full + full.conj().T)
        diagonal = np.diag(even).real
        if (diagonal > 0).all():
            scale = 1.0 / np.sqrt(diagonal)
            outer = np.multiply.outer(scale, scale)
            try:
                # no closer to singular than the inertia at the shift
                la.cholesky(outer * (even - 0.5 * shift**2 * block.mass), lower=True)
                return shift, la.cholesky(outer * even, lower=True), outer * full, scale
            except la.LinAlgError:
                pass
        # doubling ends, because s²M outgrows any stiffness and damping
        shift *= 2.0
        if not np.isfinite(shift**2):
            raise AnalysisError("the mass matrix is not positive definite")


def _congruent(lower: Matrix, matrix: Matrix) -> Matrix:
    """Return L⁻¹ A L⁻ᴴ."""
    inner = la.solve_triangular(lower, matrix, lower=True)
    return np.asarray(la.solve_triangular(lower, inner.conj().T, lower=True).conj().T)


def with_slopes(block: Block, spectral: BlockSpectral, side: Side) -> BlockSpectral:
    """Return eigenvalues with their slopes over the speed.

    `side`: at a corner of a speed law slopes jump: "above" the speed or "below" it. Equal
    eigenvalues have their vectors turned to those that they part with.
    """
    change = block.slopes(spectral.speed_rad_s, side)
    values, right, left = spectral.values, spectral.right, spectral.left
    slopes = -diagonal(left, _moved(change, right, values))
    near = np.abs(values[:, None] - values) <= _SAME * np.abs(values)
    np.fill_diagonal(near, False)
    if near.any():
        slopes, right, left = slopes.copy(), right.copy(), left.copy()
        for group in together(near):
            if group.size == 1 or not values[group].all():
                continue
            inner = -left[group] @ _moved(change, right[:, group], values[group])
            rates, turn = la.eig(inner)
            if np.linalg.cond(turn) > _DEFECTIVE:
                continue
            slopes[group], right[:, group] = rates, right[:, group] @ turn
            left[group] = la.solve(turn, left[group])
    return replace(spectral, slopes=slopes, right=right, left=left)


def _moved(change: Coefficients, right: ComplexArray, rates: ComplexArray) -> ComplexArray:
    """Return (K + λ_j V) x_j, shape (n, m)."""
    return np.asarray(change.stiffness @ right + (change.velocity @ right) * rates)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Stretch:
    """Hold the paths of all eigenvalues of a system between two speeds.

    `first`, `second`: eigenvalues at both ends with slopes towards the inside; `partner`: index in
    `second` of each value of `first`, shape (m,); `mac`: MAC of their vectors, 0 to 1, shape (m,).
    `lifted`: strides by which each path is above its value of `second`, shape (m,). `couplings`:
    for a number s of strides W_ij W_ji at both ends, each (m, m) in the order of `first`, where W
    in 1/s is what the change of the matrices over the stretch couples the motions by, whose λ_i and
    λ_j + i s stride Ω may meet.
    """

    first: Spectral
    second: Spectral
    partner: IntArray
    mac: FloatArray
    lifted: IntArray
    couplings: Callable[[int], tuple[ComplexArray, ComplexArray]]

    @property
    def width(self) -> float:
        """Distance of both speeds, rad/s."""
        return self.second.speed_rad_s - self.first.speed_rad_s

    @property
    def counted(self) -> BoolArray:
        """Which paths count at one end at least, shape (m,)."""
        return np.asarray(self.first.counted | self.second.counted[self.partner])

    @property
    def end_values(self) -> ComplexArray:
        """λ at the second speed in the order of the first, shape (m,)."""
        rise = self.second.stride * self.lifted
        return np.asarray(self.second.values[self.partner] + 1j * rise * self.second.speed_rad_s)

    def slopes(self) -> tuple[ComplexArray, ComplexArray]:
        """Return the change over the width at the slopes of both ends, each (m,).

        Motions of free bodies begin on a straight line.
        """
        change = self.end_values - self.first.values
        start = np.where(self.first.values == 0, change, self.width * self.first.slopes)
        rise = self.second.stride * self.lifted
        end = self.width * (self.second.slopes[self.partner] + 1j * rise)
        return start, np.where(self.end_values == 0, change, end)

    def paths(self, parts: FloatArray) -> ComplexArray:
        """Return cubics through values and slopes at parts (0 to 1) of the width, (m, parts)."""
        t = np.asarray(parts, dtype=float)
        basis = (
            (1 + 2 * t) * (1 - t) ** 2,
            t**2 * (3 - 2 * t),
            t * (1 - t) ** 2,
            t**2 * (t - 1),
        )
        ends = (self.first.values, self.end_values, *self.slopes())
        return np.asarray(sum(np.outer(e, b) for e, b in zip(ends, basis, strict=True)))

    def mismatch(self) -> ComplexArray:
        """Return how far straight lines from both ends miss the other end, shape (2, m)."""
        change = self.end_values - self.first.values
        return np.array([change - slope for slope in self.slopes()])


def stretch_between(block: Block, first: BlockSpectral, second: BlockSpectral) -> Stretch:
    """Pair the eigenvalues of two speeds by the MAC of their vectors.

    `first`, `second`: its eigenvalues at two speeds, rising, with slopes. All values are paired.
    The MAC is the product of y1 E x2 and y2 E x1, which is one for the same mode and does not
    depend on how vectors are scaled; of equal ones the nearer in value are paired.
    """
    mac = _alike(block, first, second)
    partner = paired(first, second, mac, np.zeros(mac.shape))
    alike = mac[np.arange(partner.size), partner]
    # motions of free bodies have no vectors to compare
    alike = np.where((first.values == 0) | (second.values[partner] == 0), 1.0, alike)
    return Stretch(
        first=first,
        second=second,
        partner=partner,
        mac=alike,
        lifted=np.zeros_like(partner),
        couplings=partial(_couplings, first, second, partner),
    )


def _alike(block: Block, first: BlockSpectral, second: BlockSpectral) -> FloatArray:
    middle = 0.5 * (first.coefficients.velocity + second.coefficients.velocity)
    sums = np.add.outer(first.values, second.values)
    there = sums * (first.left @ block.mass @ second.right) + first.left @ middle @ second.right
    back = sums.T * (second.left @ block.mass @ first.right) + second.left @ middle @ first.right
    return np.asarray(np.minimum(np.abs(there * back.T), 1.0))


def paired(first: Spectral, second: Spectral, mac: FloatArray, lifts: Matrix) -> IntArray:
    """Return the partner in the second of each value of the first by the MAC, shape (m,).

    `mac`: shape (m, m); of equal ones the nearer in value are paired, those of `second` being
    `lifts` (m, m) strides higher.
    """
    half = 0.5 * (second.speed_rad_s - first.speed_rad_s)
    rise = 1j * second.stride * lifts
    ends = second.values + rise * second.speed_rad_s
    ahead, behind = first.values + half * first.slopes, ends - half * (second.slopes + rise)
    size = np.abs(first.values)[:, None] + np.abs(ends) + np.finfo(float).tiny
    distance = np.abs(ahead[:, None] - behind) + np.abs(first.values[:, None] - ends)
    _, partner = scipy.optimize.linear_sum_assignment(
        _NEARNESS * np.minimum(distance / size, 1.0) - mac
    )
    return np.asarray(partner)


def _couplings(
    first: BlockSpectral, second: BlockSpectral, partner: IntArray, _: int
) -> tuple[ComplexArray, ComplexArray]:
    change = Coefficients(
        second.coefficients.velocity - first.coefficients.velocity,
        second.coefficients.stiffness - first.coefficients.stiffness,
    )
    found = []
    for place in (first, second):
        w = place.left @ _moved(change, place.right, place.values)
        found.append(w * w.T)
    return found[0], found[1][np.ix_(partner, partner)]
