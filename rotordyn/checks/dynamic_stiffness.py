"""The dynamic stiffness of a system at one speed: how nearly singular it is, and its signs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.complex_form import complex_form
from solidwhirl.rotordyn.modes.eigen import scaled_stiffness
from solidwhirl.rotordyn.modes.split_spectrum import planes_apart

# A pivot of the scaled stiffness below this many roundings of the size is none.
_ROUNDINGS = 64.0
# Coordinates softer than this part of the stiffest are scaled by their mass.
_SOFT = 1e-3
# A free rigid motion whose whirl is slower than this part of the spin is at rest.
_STILL = 1e-9
# Shifts that are tried, each four times the last.
_SHIFTS = 80

Planes = tuple[IntArray, IntArray]


@cache
def _start(size: int) -> FloatArray:
    """Return a unit vector to begin inverse iteration with."""
    vector = np.random.default_rng(size).standard_normal(size)
    vector /= la.norm(vector)
    vector.setflags(write=False)
    return np.asarray(vector)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class DynamicStiffness:
    """Hold D(λ) = λ²M + λV + B in coordinates y = Pᵀq, P Pᵀ = K + s²M, K the symmetric part of B.

    `to_scaled`: Pᵀ, shape (n, n); `mass`, `velocity`, `stiffness`: P⁻¹ A P⁻ᵀ of M, V and B;
    `sizes`: bounds of their 2-norms; `rounding`: relative error of the lowest eigenvalues that
    rounding in K may cause. `is_definite`: whether s = 0: K is positive definite. `turning`: T,
    real and symmetric, if D(iω) is similar to K + ωT − ω²M; else None.
    """

    to_scaled: FloatArray
    mass: FloatArray
    velocity: Matrix
    stiffness: Matrix
    sizes: tuple[float, float, float]
    rounding: float
    is_definite: bool
    turning: FloatArray | None = None

    def at(self, value: complex) -> Matrix:
        """Return a matrix similar to D(λ), real where that can be."""
        if value.real == 0.0 and self.turning is not None:
            frequency = value.imag
            matrix = self.stiffness.real - frequency**2 * self.mass
            return np.asarray(matrix + frequency * self.turning)
        return np.asarray(self.stiffness + value * self.velocity + value**2 * self.mass)

    def scale(self, value: complex) -> float:
        """Return the size of the terms of D(λ), |λ|²|M| + |λ||V| + |B|."""
        mass, velocity, stiffness = self.sizes
        return stiffness + abs(value) * velocity + abs(value) ** 2 * mass

    def backward_error(self, value: complex) -> float:
        """Return how far λ is from an eigenvalue: a bound of the smallest singular value of D(λ).

        Returns relative to `scale`; from two steps of inverse iteration, which err upwards only.
        """
        matrix = self.at(value)
        if matrix.dtype == np.float64:
            factorise, solve = la.lapack.dgetrf, la.lapack.dgetrs
        else:
            factorise, solve = la.lapack.zgetrf, la.lapack.zgetrs
        factors, pivots, info = factorise(matrix)
        if info > 0:
            return 0.0
        left = solve(factors, pivots, _start(len(matrix)), trans=2)[0]
        right = solve(factors, pivots, left / la.norm(left))[0]
        return float(1.0 / la.norm(right)) / self.scale(value)

    def residuals(self, values: ComplexArray, shapes: ComplexArray) -> FloatArray:
        """Return |D(λ)φ| / (|φ| scale) of eigenpairs in the scaled coordinates.

        `values`: λ, shape (m,); `shapes`: φ in the coordinates before scaling, shape (n, m).
        """
        scaled = self.to_scaled @ shapes
        left = self.stiffness @ scaled + self.velocity @ (scaled * values)
        left = left + self.mass @ (scaled * values**2)
        sizes = np.array([self.scale(complex(value)) for value in values])
        return np.asarray(la.norm(left, axis=0) / (la.norm(scaled, axis=0) * sizes))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class SplitStiffness:
    """Hold the dynamic stiffness of a system in parts that do not couple.

    Attributes
    ----------
    assembled, speed_rad_s
        The system, and Ω.
    parts
        Each with whether it is taken at the conjugate of λ: whirl against +z in the complex form.
    """

    assembled: AssembledSystem
    speed_rad_s: float
    parts: tuple[tuple[DynamicStiffness, bool], ...]

    @property
    def is_definite(self) -> bool:
        """Whether K is positive definite."""
        return all(part.is_definite for part, _ in self.parts)

    @property
    def rounding(self) -> float:
        """Return the relative error of the lowest eigenvalues that rounding in K may cause."""
        return max(part.rounding for part, _ in self.parts)

    def backward_error(self, value: complex) -> float:
        """Return how far λ is from an eigenvalue, of the part that it belongs to."""
        return min(
            part.backward_error(value.conjugate() if against else value)
            for part, against in self.parts
        )

    def modes_below(self, frequency_rad_s: float) -> int:
        """Count the modes 0 < ω < σ of a conservative system by the signs of D(iσ).

        `frequency_rad_s`: σ; no eigenvalue.

        K ≥ 0, M > 0: every form xᴴD(iω)x = k + ωg − ω²m falls through zero once on ω > 0, so each
        negative eigenvalue of D(iσ) is a mode below σ (Sylvester's law of inertia). On the kernel
        Z of K half of the rank of ZᵀGZ turns negative at once and is no mode, and so is what that
        rank lacks.
        """
        value = 1j * frequency_rad_s
        below = sum(
            negative_eigenvalues(part.at(value.conjugate() if against else value))
            for part, against in self.parts
        )
        return below if self.is_definite else below - self._still()

    def _still(self) -> int:
        """Count the negative eigenvalues of D(iω) as ω goes to zero."""
        matrices = matrices_at_speed(self.assembled, self.speed_rad_s)
        scaled = scaled_stiffness(self.assembled, matrices)
        if not scaled.zero_count:
            return 0
        kernel = scaled.scale[:, None] * scaled.vectors[:, : scaled.zero_count]
        lower = la.cholesky(kernel.T @ matrices.mass @ kernel, lower=True)
        rates = la.svdvals(_congruent(lower, kernel.T @ matrices.gyroscopic @ kernel))
        spin = max(abs(r.speed_ratio) for r in self.assembled.system.rotors.values())
        whirling = int(np.count_nonzero(rates > _STILL * spin * abs(self.speed_rad_s)))
        return scaled.zero_count - whirling // 2


def dynamic_stiffness(
    assembled: AssembledSystem, speed_rad_s: float, slowest_rad_s: float
) -> DynamicStiffness:
    """Return the dynamic stiffness of a system at one speed in its own coordinates, scaled.

    `slowest_rad_s`: a low frequency of the system, for bodies that are free: s.
    """
    matrices = matrices_at_speed(assembled, speed_rad_s)
    velocity = matrices.damping + matrices.gyroscopic
    parts = (matrices.mass, velocity, matrices.stiffness)
    return _scaled(assembled, parts, slowest_rad_s, planes_apart(assembled))


def split_stiffness(
    assembled: AssembledSystem, speed_rad_s: float, slowest_rad_s: float
) -> SplitStiffness:
    """Return the dynamic stiffness of a system at one speed, whirl by its sense where it can be.

    `assembled`, `speed_rad_s`, `slowest_rad_s`: as for `dynamic_stiffness`.
    """
    form = complex_form(assembled)
    if form is None:
        whole = dynamic_stiffness(assembled, speed_rad_s, slowest_rad_s)
        return SplitStiffness(assembled=assembled, speed_rad_s=speed_rad_s, parts=((whole, False),))
    turning = _scaled(assembled, form.at_speed(speed_rad_s), slowest_rad_s, None)
    parts = [(turning, False), (turning, True)]
    if form.rest.size:
        matrices, block = matrices_at_speed(assembled, speed_rad_s), np.ix_(form.rest, form.rest)
        velocity = (matrices.damping + matrices.gyroscopic)[block]
        rest = (matrices.mass[block], velocity, matrices.stiffness[block])
        parts.append((_scaled(assembled, rest, slowest_rad_s, None), False))
    return SplitStiffness(assembled=assembled, speed_rad_s=speed_rad_s, parts=tuple(parts))


def _scaled(
    assembled: AssembledSystem,
    parts: tuple[FloatArray, Matrix, Matrix],
    slowest: float,
    planes: Planes | None,
) -> DynamicStiffness:
    """Scale M, V and B."""
    even = 0.5 * (parts[2] + parts[2].T).real
    floor = _SOFT * (assembled.body_rate or 1.0) * np.diag(parts[0])
    scale = 1.0 / np.sqrt(np.maximum(np.diag(even), floor))
    outer = np.outer(scale, scale)
    lower, shift = _factor(outer * even, outer * parts[0], slowest)
    mass = np.asarray(_congruent(lower, outer * parts[0]).real)
    velocity, stiffness = (_congruent(lower, outer * part) for part in parts[1:])
    sizes = [np.sqrt(la.norm(a, 1) * la.norm(a, np.inf)) for a in (mass, velocity, stiffness)]
    return DynamicStiffness(
        to_scaled=lower.T / scale,
        mass=mass,
        velocity=velocity,
        stiffness=stiffness,
        sizes=(float(sizes[0]), float(sizes[1]), float(sizes[2])),
        rounding=float(np.finfo(float).eps / np.diag(lower).min() ** 2),
        is_definite=shift == 0.0,
        turning=_turning(velocity, stiffness, planes),
    )


def _turning(velocity: Matrix, stiffness: Matrix, planes: Planes | None) -> FloatArray | None:
    """Return T of a system without damping that has a complex form or two planes."""
    if planes is not None:
        # with i times the second plane, iωG is real and symmetric
        turning = np.zeros(velocity.shape)
        first, second = (np.ix_(a, b) for a, b in (planes, planes[::-1]))
        turning[first], turning[second] = -velocity[first].real, velocity[second].real
        return turning
    if np.abs(velocity.real).max() or np.abs(stiffness.imag).max():
        return None
    return np.asarray(-velocity.imag)


def _factor(stiffness: FloatArray, mass: FloatArray, slowest: float) -> tuple[FloatArray, float]:
    """Return the Cholesky factor of K + s²M, and s² that makes it positive, 0 if it can be."""
    least = np.sqrt(_ROUNDINGS * len(mass) * np.finfo(float).eps)
    for step in range(_SHIFTS):
        shift = slowest**2 * 4.0 ** (step - 1) if step else 0.0
        try:
            lower = la.cholesky(stiffness + shift * mass, lower=True)
        except la.LinAlgError:
            continue
        if (np.diag(lower) > least).all():
            return np.asarray(lower), shift
    raise AnalysisError("the mass matrix is not positive definite; every coordinate needs inertia")


def _congruent(lower: FloatArray, matrix: Matrix) -> Matrix:
    """Return P⁻¹ A P⁻ᵀ."""
    inner = la.solve_triangular(lower, matrix, lower=True)
    return np.asarray(la.solve_triangular(lower, inner.T, lower=True).T)


def negative_eigenvalues(matrix: Matrix) -> int:
    """Return the number of negative eigenvalues of a Hermitian matrix.

    `matrix`: shape (n, n).

    LDLᴴ with blocks of one and two rows (Bunch and Kaufman 1977); a block of two has one negative
    eigenvalue.
    """
    factorise = la.lapack.dsytrf if matrix.dtype == np.float64 else la.lapack.zhetrf
    factors, pivots, _ = factorise(matrix, lower=1)
    single = pivots > 0
    negative = np.count_nonzero(np.diag(factors).real[single] < 0)
    return int(negative + np.count_nonzero(~single) // 2)
