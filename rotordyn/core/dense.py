"""Dense solvers for λ² M + λ (C + G) + K that keep their digits beside very stiff springs.

All of them work in coordinates scaled by the diagonal of K, where a spring of 1e16 N/m is a one
among ones, and find 1/λ (or 1/(λ − shift)), so that the lowest modes are the most accurate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    Matrix,
    together,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.ledger import solved

# Roundings of the eigensolver, in units of eps times the norm times the condition of a value.
_SOLVER_ROUNDINGS = 8.0


class Roots(NamedTuple):
    """Eigenvalues (m,), right vectors (n, m), left vectors (m, n), and rounding of the values."""

    values: ComplexArray
    right: ComplexArray
    left: ComplexArray
    tolerance: FloatArray


def sharpened(problem: tuple[Matrix, Matrix, Matrix], roots: Roots) -> tuple[Roots, BoolArray]:
    """Return roots after a step of Newton's method, and which of them are alive.

    `problem`: M, V and K, each (n, n). `roots`: as an eigensolver found them; those at zero stay,
    and so do defective ones. Returns `roots`: with left vectors scaled to y (V + 2λM) x = 1 (zero
    if not alive), and what rounding is left of the values. Returns `alive`: false for roots at zero
    and those whose left and right vectors have no product.

    The eigensolver errs by the rounding of the largest entry; y D(λ) x by that of its own terms,
    and by the square of the error of the vectors, which is the rounding over the distance to the
    next root. Entries are sums in which as much as (K_ii K_jj)^½ may have cancelled.
    """
    mass, velocity, stiffness = problem
    values, right, left, tolerance = roots
    product = diagonal(left, velocity @ right) + 2.0 * values * diagonal(left, mass @ right)
    alive = (values != 0) & (np.abs(product) > 0)
    left = np.where(alive[:, None], left / np.where(alive, product, 1.0)[:, None], 0.0)
    stiff = np.sqrt(np.abs(np.diag(stiffness)))
    miss, size = np.zeros_like(values), np.zeros_like(tolerance)
    for power, matrix, cancelled in (
        (2, mass, 0.0),
        (1, velocity, 0.0),
        (0, stiffness, np.outer(stiff, stiff)),
    ):
        miss += values**power * diagonal(left, matrix @ right)
        largest = np.maximum(np.abs(matrix), cancelled)
        size += np.abs(values) ** power * (np.abs(left) * (largest @ np.abs(right)).T).sum(axis=1)
    apart = np.abs(values[:, None] - values)
    # of the pairs of a real problem only one may be here
    paired = (values.imag != 0) & all(map(np.isrealobj, problem))
    np.fill_diagonal(apart, np.where(paired, 2.0 * np.abs(values.imag), np.inf))
    apart = np.maximum(apart.min(axis=1, initial=np.inf), tolerance)
    second = np.where(alive, tolerance, 0.0) ** 2 / np.where(alive, apart, 1.0)
    left_over = _SOLVER_ROUNDINGS * np.finfo(float).eps * size + second
    better = alive & (left_over < tolerance) & (np.abs(miss) <= tolerance)
    values = np.where(better, values - miss, values)
    return Roots(values, right, left, np.where(better, left_over, tolerance)), alive


def eigensolver_rounding(norm: float, dual: ComplexArray, vectors: ComplexArray) -> FloatArray:
    """Return the rounding of the eigenvalues of a matrix, shape (m,).

    `dual`, `vectors`: left vectors as rows and right ones as columns, of unit product.
    """
    condition = la.norm(dual, axis=1) * la.norm(vectors, axis=0)
    return np.asarray(_SOLVER_ROUNDINGS * np.finfo(float).eps * norm * condition)


def dual_of(vectors: ComplexArray) -> ComplexArray:
    """Return the left vectors, of unit product with the right ones."""
    try:
        return np.asarray(la.inv(vectors, check_finite=False))
    except la.LinAlgError:
        # exactly defective: the vectors that belong together are as good as any
        return np.asarray(la.pinv(vectors, rtol=np.finfo(float).eps))


def real_dual(
    values: ComplexArray,
    vectors: ComplexArray,
    inverse: Callable[[Matrix], Matrix] = dual_of,
) -> ComplexArray:
    """Return the left vectors of a real matrix, where Im λ ≥ 0; others have no meaning.

    `values`, `vectors`: as LAPACK gives them, of each pair first that of Im λ > 0. The inverse of
    their real and imaginary parts is a quarter of the work of that of complex vectors.
    """
    own = inverse(np.where(values.imag < 0, -vectors.imag, vectors.real))
    pairs = values.imag > 0
    return np.where(pairs[:, None], 0.5 * (own - 1j * np.roll(own, -1, axis=0)), own)


def diagonal(left: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Return the diagonal of a product."""
    return np.asarray((left * right.T).sum(axis=1))


# A coordinate softer than this fraction of the stiffest of the bodies is scaled by its mass.
_SOFT = 1e-3
# An eigenvalue of the scaled K below this many roundings of the size counts as zero.
_ROUNDINGS = 64.0
# A motion whose strain holds this fraction of its kinetic energy is one of rigid bodies.
_NO_STRAIN = 1e-3
# A nutation slower than this fraction of the lowest elastic frequency is a rigid-body zero,
_ZERO_FRACTION = 1e-11
# and so is one below this fraction of the fastest: rounding in G of motions that do not tilt.
_NO_TILT = 1e-8
# Roots below this part of a shift are found again by themselves, in so many steps.
_SLOW, _ITERATIONS = 0.1, 2
# All roots are found again if the shift is off by this factor from the slowest of them,
_FAR = 1e-3
# or from this part of the fastest.
_SLOWEST = 1e-5
# |Im λ| below this fraction of |λ| is real.
_REAL_FRACTION = 1e-6
# Without a known number of zeros: |λ| below this part of the largest is zero; |Im λ| below this
# part of |λ| is.
_STILL, _REAL = 1e-12, 1e-9


class Scaled(NamedTuple):
    """K and M in coordinates x with q = scale · x, and the signature of K."""

    scale: FloatArray
    stiffness: Matrix
    mass: Matrix
    eigenvalues: FloatArray
    vectors: Matrix
    negative_count: int
    zero_count: int

    @property
    def is_definite(self) -> bool:
        """Whether K is positive definite."""
        return self.negative_count == 0 and self.zero_count == 0


class Spectrum(NamedTuple):
    """Eigenvalues with Im λ > 0 by rising Im λ, shapes (n, m), and the real non-zero rest."""

    eigenvalues: ComplexArray
    shapes: ComplexArray
    real_eigenvalues: FloatArray


class Eigenvalues(NamedTuple):
    """Eigenvalues, 0 exactly for those at zero, and shapes (n, m).

    All 2n of a complex problem; of a real one those with Im λ ≥ 0.
    """

    values: ComplexArray
    shapes: ComplexArray


def uncoupled(*matrices: Matrix, motions: Iterable[Matrix] = ()) -> list[IntArray]:
    """Return the groups of coordinates that nothing joins, each rising.

    `matrices`: an entry joins two coordinates; `motions`: relative motions of bearings, (n,) or
    (k, n) each, join all that move them.
    """
    joined = np.logical_or.reduce([matrix != 0 for matrix in matrices])
    for motion in motions:
        moved = np.atleast_2d(motion).any(axis=0)
        joined |= np.outer(moved, moved)
    return together(joined)


def hermitian_part(matrix: Matrix) -> Matrix:
    """Return ½ (A + Aᴴ), real if it has no imaginary part."""
    part = 0.5 * (matrix + matrix.conj().T)
    return np.asarray(part.real if np.iscomplexobj(part) and not part.imag.any() else part)


def scale_by_stiffness(stiffness: Matrix, mass: Matrix, body_rate: float | None = None) -> Scaled:
    """Scale the coordinates so that stiff springs become ones, and count the signs of K.

    `stiffness`, `mass`: real symmetric or Hermitian, shape (n, n); M positive definite.
    `body_rate`: largest K_ii / M_ii of the bodies without their bearings, (rad/s)²: rounding in K
    is of the order of eps times that. None takes it from the matrices given.

    Coordinates with K_ii above a thousandth of body_rate · M_ii get a unit diagonal, softer ones
    keep the scale of M. Eigenvalues of the scaled K below 64 n eps count as zero. Coordinates that
    nothing joins are looked at apart.
    """
    scale, scaled, inertia = scaled_matrices(stiffness, mass, body_rate)
    values, vectors = _eigh_apart(scaled, uncoupled(scaled, inertia))
    return _signed(scale, scaled, inertia, values, vectors)


def scaled_matrices(
    stiffness: Matrix, mass: Matrix, body_rate: float | None = None
) -> tuple[FloatArray, Matrix, Matrix]:
    """Return the scale of the coordinates, K and M in them, as of `scale_by_stiffness`."""
    diagonal, inertia = np.diag(stiffness).real, np.diag(mass).real
    if not (inertia > 0).all():
        at = int(np.argmin(inertia))
        raise AnalysisError(
            f"coordinate {at} has mass {inertia[at]:.3e}; every coordinate needs positive inertia"
        )
    rate = float(np.max(diagonal / inertia)) if body_rate is None else body_rate
    floor = _SOFT * (rate if rate > 0 else 1.0) * inertia
    scale = 1.0 / np.sqrt(np.maximum(diagonal, floor))
    outer = np.multiply.outer(scale, scale)
    return scale, outer * stiffness, outer * mass


def is_definite(scaled_stiffness: Matrix) -> bool:
    """Whether a scaled K is positive definite, as `Scaled.is_definite`, without its vectors."""
    return bool((np.linalg.eigvalsh(scaled_stiffness) > _zero_limit(len(scaled_stiffness))).all())


def _zero_limit(size: int) -> float:
    """Eigenvalues of a scaled K up to this one count as zero."""
    return float(_ROUNDINGS * size * np.finfo(float).eps)


def _eigh_apart(matrix: Matrix, groups: list[IntArray]) -> tuple[FloatArray, Matrix]:
    """Return eigenvalues, rising, and vectors of a matrix that joins no coordinates of two groups.

    The vectors of a group are exactly zero outside of it.
    """
    if len(groups) == 1:
        return la.eigh(matrix)  # type: ignore[no-any-return]
    values, vectors, start = np.empty(len(matrix)), np.zeros_like(matrix), 0
    for at in groups:
        own = slice(start, start + at.size)
        values[own], vectors[at, own] = la.eigh(matrix[np.ix_(at, at)])
        start = own.stop
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order]


def _signed(
    scale: FloatArray, stiffness: Matrix, mass: Matrix, values: FloatArray, vectors: Matrix
) -> Scaled:
    """Return scaled matrices with their eigenvalues and the signs of these."""
    limit = _zero_limit(scale.size)
    return Scaled(
        scale=scale,
        stiffness=stiffness,
        mass=mass,
        eigenvalues=values,
        vectors=vectors,
        negative_count=int(np.count_nonzero(values < -limit)),
        zero_count=int(np.count_nonzero(np.abs(values) <= limit)),
    )


def reciprocal(inverse: FloatArray | ComplexArray) -> ComplexArray:
    """Return 1/μ of eigenvalues μ, or say that a root is beyond the range of numbers."""
    if not inverse.all():
        raise AnalysisError(
            "an eigenvalue is beyond the range of numbers; check masses, stiffnesses and damping"
        )
    return np.asarray(1.0 / inverse)


def cholesky_of_mass(mass: Matrix) -> Matrix:
    """Return the lower Cholesky factor of M, or say that M is not positive definite."""
    try:
        return np.asarray(la.cholesky(mass, lower=True))
    except la.LinAlgError as error:
        raise AnalysisError(
            f"the mass matrix is not positive definite ({error}); every coordinate needs inertia"
        ) from error


def solve_standing(scaled: Scaled) -> tuple[FloatArray, Matrix]:
    """Solve K q = ω² M q for K positive (semi)definite.

    `scaled`: from `scale_by_stiffness`, without negative eigenvalues. Returns `frequencies`: ω of
    the elastic modes in rad/s, rising, shape (n − zero_count,). Returns `shapes`: columns q, real
    if K and M are, φᴴMφ = 1.

    With K + σ²M = LLᴴ and M = NNᴴ the singular values of L⁻¹N are (ω² + σ²)^-½: no squaring, so
    rounding is relative to the ratio of frequencies, not to its square.
    """
    zeros = scaled.zero_count
    if zeros == scaled.scale.size:
        return np.empty(0), np.empty((scaled.scale.size, 0))
    factor = cholesky_of_mass(scaled.mass)
    if zeros == 0:
        return _standing_shifted(scaled, factor, 0.0, 0)
    rough = float(np.median(1.0 / np.diag(scaled.mass).real))
    lowest = float(_standing_shifted(scaled, factor, rough, zeros)[0][0])
    # Rounding may drown the lowest frequency in the rough shift; never shift below 1e-6 of it.
    shift = max(lowest**2, 1e-12 * rough)
    return _standing_shifted(scaled, factor, shift, zeros)


def _standing_shifted(
    scaled: Scaled, factor: Matrix, shift: float, zeros: int
) -> tuple[FloatArray, Matrix]:
    """Solve with σ² = shift and drop the `zeros` lowest modes."""
    lower = la.cholesky(scaled.stiffness + shift * scaled.mass, lower=True)
    solved("eigenproblems")
    left, singular, _ = la.svd(la.solve_triangular(lower, factor, lower=True))
    squared = np.maximum(1.0 / singular[zeros:] ** 2 - shift, 0.0)
    shapes = la.solve_triangular(lower, left[:, zeros:], lower=True, trans="C")
    shapes = scaled.scale[:, None] * shapes / singular[zeros:]
    return np.sqrt(squared), shapes


def solve_gyroscopic(scaled: Scaled, gyroscopic: FloatArray, count: int) -> Spectrum:
    """Solve (K + iωG − ω²M) q = 0 for K positive (semi)definite and no damping.

    `scaled`: from `scale_by_stiffness`, without negative eigenvalues; `gyroscopic`: G at speed in
    the original coordinates, skew, shape (n, n). `count`: number of lowest modes wanted; fewer are
    returned if there are fewer. Returns λ = iω exactly on the imaginary axis.
    """
    skew = scaled.scale[:, None] * gyroscopic * scaled.scale
    solve = _gyroscopic_definite if scaled.is_definite else _gyroscopic_semidefinite
    omega, shapes = solve(scaled, skew, count)
    return Spectrum(1j * omega, scaled.scale[:, None] * shapes, np.empty(0))


def _gyroscopic_definite(
    scaled: Scaled, skew: FloatArray, count: int
) -> tuple[FloatArray, ComplexArray]:
    """Solve with K = LLᵀ, L⁻¹ML⁻ᵀ = NNᵀ, x = Lᵀq, λ = 1/μ.

    μ²x + μ L⁻¹GL⁻ᵀ x + NNᵀx = 0 is [[−G̃, −N], [Nᵀ, 0]] (x, y) = μ (x, y), a skew matrix.
    """
    n = skew.shape[0]
    lower = la.cholesky(scaled.stiffness, lower=True)
    half = la.solve_triangular(lower, cholesky_of_mass(scaled.mass), lower=True)
    inner = la.solve_triangular(lower, skew, lower=True)
    inner = la.solve_triangular(lower, inner.T, lower=True).T
    hermitian = np.zeros((2 * n, 2 * n), dtype=complex)
    hermitian[:n, :n] = -0.5j * (inner - inner.T)
    hermitian[:n, n:] = -1j * half
    hermitian[n:, :n] = 1j * half.T
    wanted = min(count, n)
    solved("eigenproblems")
    inverse, vectors = la.eigh(
        hermitian, subset_by_index=(2 * n - wanted, 2 * n - 1), overwrite_a=True
    )
    shapes = la.solve_triangular(lower, vectors[:n, ::-1], lower=True, trans="T")
    return 1.0 / inverse[::-1], shapes


def _gyroscopic_semidefinite(
    scaled: Scaled, skew: FloatArray, count: int
) -> tuple[FloatArray, ComplexArray]:
    """Solve with K = SSᵀ and states (Lᵀq', Sᵀq), M = LLᵀ: a skew matrix, shifted and inverted.

    H = −i[[−G̃, −L⁻¹S], [SᵀL⁻ᵀ, 0]] is Hermitian with eigenvalues ω. The blocks of (H − σ)⁻¹ need
    only Q⁻¹ with Q = K + iσG − σ²M: σLᵀQ⁻¹L, iLᵀQ⁻¹S and −(1 − SᵀQ⁻¹S)/σ.
    """
    n = skew.shape[0]
    kept = scaled.eigenvalues > 0
    kept[: scaled.zero_count] = False
    root = scaled.vectors[:, kept] * np.sqrt(scaled.eigenvalues[kept])
    lower = cholesky_of_mass(scaled.mass)
    lowest = _lowest_frequency(scaled, skew)
    for fraction in (0.5, 0.41, 0.63):
        shift = fraction * lowest
        solved("eigenproblems")
        inverse, vectors = la.eigh(_shifted_inverse(scaled, skew, lower, root, shift))
        # A shift that happens to hit a mode drowns the others; take the next one.
        if np.abs(inverse).max() * shift < 1e4:
            break
    omega = shift + 1.0 / inverse
    # the number of zeros is known, so that no tolerance has to tell a slow nutation from them
    kernel = scaled.vectors[:, : scaled.zero_count]
    positive = n - scaled.zero_count + _velocity_rank(scaled, (kernel, kernel), skew, lowest) // 2
    order = np.argsort(omega, kind="stable")[omega.size - positive :][:count]
    velocity = la.solve_triangular(lower, vectors[:n, order], lower=True, trans="T")
    shapes = velocity / (1j * omega[order])
    return _by_energy(scaled, skew, omega[order], shapes), shapes


def _by_energy(
    scaled: Scaled, skew: FloatArray, omega: FloatArray, shapes: ComplexArray
) -> FloatArray:
    """Return frequencies from the energies of their shapes, one step of Newton's method.

    The inverse shifted by σ has a frequency ω to the rounding of the slowest or fastest one; the
    error of xᴴ (K + iωG − ω²M) x is of second order in that of x, as the problem is Hermitian.
    Where motions with stiffness hold next to no energy ω is left as it is: what K does to the
    others is its rounding.
    """
    kernel = scaled.vectors[:, : scaled.zero_count]
    strained = shapes - kernel @ (kernel.T @ shapes)
    strain, stiffness, turning, inertia = (
        (moved.conj() * (matrix @ moved)).sum(axis=0)
        for matrix, moved in (
            (scaled.stiffness, strained),
            (scaled.stiffness, shapes),
            (skew, shapes),
            (scaled.mass, shapes),
        )
    )
    miss = stiffness + 1j * omega * turning - omega**2 * inertia
    slope = 1j * turning - 2.0 * omega * inertia
    free = np.abs(strain) <= _NO_STRAIN * omega**2 * np.abs(inertia)
    return np.where(free, omega, omega - (miss / slope).real)


def _velocity_rank(
    scaled: Scaled, kernel: tuple[Matrix, ...], velocity: Matrix, lowest: float
) -> int:
    """Return the rank of V between left and right motions without stiffness.

    Where no damping is negative, a motion that V does not push is one that neither damping nor a
    gyroscopic moment pushes. What is rounding differs: G comes from bodies whose rigid motions
    are not exact, C acts through bearings which the motions that it does not damp hardly move.
    """
    left, right = (_of_unit_mass(side, scaled.mass) for side in kernel)
    turning = left @ (0.5 * (velocity - velocity.conj().T)) @ right.conj().T
    limit = max(_NO_TILT * float(la.norm(turning, 2)), _ZERO_FRACTION * lowest)
    damping = 0.5 * (velocity + velocity.conj().T)
    size = np.abs(scaled.eigenvalues)
    rounding = _ROUNDINGS * size.size * np.finfo(float).eps
    rounding = rounding / size.min(where=size > rounding, initial=1.0)
    largest = float(la.norm(left, 2) * la.norm(velocity, 2) * la.norm(right, 2))
    allowed = rounding * max(largest, _ZERO_FRACTION * lowest)
    both = np.vstack((turning / limit, left @ damping @ right.conj().T / allowed))
    return int(np.count_nonzero(la.svdvals(both) > 1.0))


def _of_unit_mass(motions: Matrix, mass: Matrix) -> Matrix:
    """Return motions (n, k) as rows, conjugate, with the unit matrix for their mass."""
    root = la.cholesky(motions.conj().T @ mass @ motions, lower=True)
    return np.asarray(la.solve_triangular(root, motions.conj().T, lower=True))


def _lowest_frequency(scaled: Scaled, skew: Matrix) -> float:
    """Return a positive frequency of the order of the lowest mode, rad/s."""
    standing, _ = solve_standing(scaled)
    if standing.size:
        return float(standing[0])
    lower = cholesky_of_mass(scaled.mass)
    largest = float(np.abs(_congruent(lower, skew)).max())
    return largest if largest > 0 else 1.0


def _shifted_inverse(
    scaled: Scaled, skew: FloatArray, lower: FloatArray, root: FloatArray, shift: float
) -> ComplexArray:
    """Return (H − σ)⁻¹, shape (n + r, n + r)."""
    dynamic = scaled.stiffness + 1j * shift * skew - shift**2 * scaled.mass
    balance = 1.0 / np.sqrt(np.abs(scaled.stiffness.diagonal()) + shift**2 * scaled.mass.diagonal())
    factors = la.lu_factor(balance[:, None] * dynamic * balance)
    right = balance[:, None] * np.hstack((lower, root)).astype(complex)
    flexible = right.T @ la.lu_solve(factors, right)
    n, r = lower.shape[0], root.shape[1]
    result = np.empty((n + r, n + r), dtype=complex)
    result[:n, :n] = shift * flexible[:n, :n]
    result[:n, n:] = 1j * flexible[:n, n:]
    result[n:, :n] = -1j * flexible[n:, :n]
    result[n:, n:] = (flexible[n:, n:] - np.eye(r)) / shift
    return np.asarray(0.5 * (result + result.conj().T))


def solve_general(
    scaled: Scaled, stiffness: FloatArray, velocity: FloatArray, count: int
) -> Spectrum:
    """Solve (λ²M + λC + K) q = 0 for any real C and K.

    `scaled`: of the symmetric part of K; `stiffness`: K with its skew part, original coordinates,
    shape (n, n); `velocity`: damping plus gyroscopic matrix, original coordinates, shape (n, n);
    `count`: number of lowest oscillatory modes wanted. Returns oscillatory pairs once (Im λ > 0),
    and all real eigenvalues other than zeros.

    With λ = s + 1/μ and Q = K + sC + s²M = P + Z, P symmetric and positive definite for the real
    shift s (0 if K is definite), P = LLᵀ, M = NNᵀ after L: the eigenvalues μ belong to
    [[−(1+Z̃)⁻¹C̃, −(1+Z̃)⁻¹N], [Nᵀ, 0]] with C̃ of C + 2sM. 1 + Z̃ is regular as Z̃ is skew.
    """
    outer = np.multiply.outer(scaled.scale, scaled.scale)
    found = general_eigenvalues(scaled, outer * stiffness, outer * velocity)
    shapes = scaled.scale[:, None] * found.shapes
    return _sorted_spectrum(found.values, shapes, count)


def general_eigenvalues(scaled: Scaled, stiffness: Matrix, velocity: Matrix) -> Eigenvalues:
    """Return all eigenvalues of λ²M + λV + K, see `solve_general`.

    `scaled`: of the Hermitian part of K; `stiffness`, `velocity`: K and V, real or complex, in the
    scaled coordinates, shape (n, n). Returns unsorted, shapes in the scaled coordinates; of the
    pairs of a real problem one. Coordinates that no entry joins are solved apart.
    """
    groups = uncoupled(scaled.mass, stiffness, velocity)
    solved("eigenproblems")
    if len(groups) == 1:
        return _coupled_eigenvalues(scaled, stiffness, velocity)
    found = []
    for at in groups:
        block = np.ix_(at, at)
        part = _coupled_eigenvalues(_scaled_part(scaled, at), stiffness[block], velocity[block])
        shapes = np.zeros((scaled.scale.size, part.values.size), dtype=complex)
        shapes[at] = part.shapes
        found.append(Eigenvalues(part.values, shapes))
    values = np.concatenate([part.values for part in found])
    return Eigenvalues(values, np.hstack([part.shapes for part in found]))


def _scaled_part(scaled: Scaled, at: IntArray) -> Scaled:
    """Return some coordinates, which nothing joins to the others."""
    block, own = np.ix_(at, at), scaled.vectors[at].any(axis=0)
    return _signed(
        scaled.scale[at],
        scaled.stiffness[block],
        scaled.mass[block],
        scaled.eigenvalues[own],
        scaled.vectors[at][:, own],
    )


def _coupled_eigenvalues(scaled: Scaled, stiffness: Matrix, velocity: Matrix) -> Eigenvalues:
    """Return all eigenvalues of λ²M + λV + K, unsorted."""
    shift, reference = _real_shift(scaled, stiffness, velocity)
    zeros = _zero_count(scaled, stiffness, velocity, reference)
    found = _solved(scaled, stiffness, velocity, shift, zeros)
    size = np.abs(found.values[found.values != 0])
    better = max(size.min(initial=np.inf), _SLOWEST * size.max(initial=0.0))
    if shift > 0 and size.size and not _FAR < shift / better < 1.0 / _FAR:
        # roots far below the shift are blurred by its rounding, those far above it by their own
        shift = _definite_shift(stiffness, velocity, scaled.mass, better)
        solved("eigenproblems")
        found = _solved(scaled, stiffness, velocity, shift, zeros)
    return found


def _solved(
    scaled: Scaled, stiffness: Matrix, velocity: Matrix, shift: float, zeros: int
) -> Eigenvalues:
    """Return all eigenvalues by their distance from a shift, so many of them at zero."""
    n = scaled.scale.size
    shifted = stiffness + shift * velocity + shift**2 * scaled.mass
    lower = la.cholesky(0.5 * (shifted + shifted.conj().T), lower=True)
    regular = np.eye(n) + _congruent(lower, 0.5 * (shifted - shifted.conj().T))
    rate = _congruent(lower, velocity + 2.0 * shift * scaled.mass)
    half = la.solve_triangular(lower, cholesky_of_mass(scaled.mass), lower=True)
    companion = np.zeros((2 * n, 2 * n), dtype=np.result_type(rate, half))
    companion[:n] = -la.solve(regular, np.hstack((rate, half)))
    companion[n:, :n] = half.conj().T
    is_real, norm = np.isrealobj(companion), float(la.norm(companion))
    inverse, vectors = la.eig(companion, overwrite_a=True, check_finite=False)
    values = shift + reciprocal(inverse)
    values[np.argsort(np.abs(values), kind="stable")[:zeros]] = 0.0
    if is_real:
        upper = inverse.imag >= 0
        dual = real_dual(inverse, vectors)[upper].conj()
        values, vectors = values[upper].conj(), vectors[:, upper].conj().astype(complex)
    else:
        dual = dual_of(vectors)
    right = la.solve_triangular(lower, vectors[:n], lower=True, trans="C")
    left = la.solve_triangular(lower, la.solve(regular.T, dual[:, :n].T), lower=True, trans="T")
    tolerance = eigensolver_rounding(norm, dual, vectors) * np.abs(values - shift) ** 2
    problem = (scaled.mass, velocity, stiffness)
    roots, _ = sharpened(problem, Roots(values, right, left.T, tolerance))
    # a real root of a real problem stays real
    real = is_real & (values.imag == 0)
    values = np.where(real, roots.values.real, roots.values)
    turning = values.imag != 0
    for at in np.flatnonzero(turning & (np.abs(values) < _SLOW * shift)):
        values[at], right[:, at] = iterated(complex(values[at]), right[:, at], problem)
    return Eigenvalues(values, right)


def iterated(
    value: complex, shape: ComplexArray, problem: tuple[Matrix, Matrix, Matrix]
) -> tuple[complex, ComplexArray]:
    """Return a root and its vector by inverse iteration, which needs no left vector.

    Zeros near a root spoil that. `problem`: M, V and K, each (n, n).
    """
    mass, velocity, stiffness = problem
    for _ in range(_ITERATIONS):
        dynamic = stiffness + value * velocity + value**2 * mass
        slope = velocity @ shape + 2.0 * value * (mass @ shape)
        _, _, grown, singular = la.lapack.zgesv(dynamic, slope)
        if singular:
            break
        value = value - complex(np.vdot(shape, shape) / np.vdot(shape, grown))
        shape = grown / la.norm(grown)
    return value, shape


def _zero_count(scaled: Scaled, stiffness: Matrix, velocity: Matrix, lowest: float) -> int:
    """Return the number of zeros among the 2n roots of λ²M + λV + K.

    λ = 0 has an eigenvector for each motion without stiffness, and a second state for each that no
    velocity forces push to another such motion.
    """
    if scaled.is_definite:
        return 0
    # a negative stiffness may be far above the ones that the coordinates are scaled by
    balance = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(stiffness)), 1.0))
    left, size, right = la.svd(balance[:, None] * stiffness * balance)
    at = size <= _ROUNDINGS * size.size * np.finfo(float).eps
    if not at.any():
        return 0
    kernel = tuple(balance[:, None] * side for side in (left[:, at], right[at].conj().T))
    return 2 * int(np.count_nonzero(at)) - _velocity_rank(scaled, kernel, velocity, lowest)


def _congruent(lower: Matrix, matrix: Matrix) -> Matrix:
    """Return L⁻¹ A L⁻ᴴ."""
    inner = la.solve_triangular(lower, matrix, lower=True)
    return np.asarray(la.solve_triangular(lower, inner.conj().T, lower=True).conj().T)


def _real_shift(scaled: Scaled, full: Matrix, damping: Matrix) -> tuple[float, float]:
    """Return s ≥ 0 with a positive definite Q(s), and a low frequency of the system."""
    if scaled.is_definite:
        return 0.0, 1.0
    least = 0.0
    if scaled.negative_count:  # which may be rounding: over the mass it need not be negative
        least = float(la.eigh(scaled.stiffness, scaled.mass, eigvals_only=True)[0])
    if least < 0.0:
        reference = 2.0 * float(np.sqrt(-least))
    else:
        reference = _lowest_frequency(scaled, 0.5 * (damping - damping.conj().T))
    return _definite_shift(full, damping, scaled.mass, reference), reference


def _definite_shift(full: Matrix, damping: Matrix, mass: Matrix, least: float) -> float:
    """Return a shift s, not below a least one, with a positive definite Q(s)."""
    shift = least
    limit = _ROUNDINGS * mass.shape[0] * np.finfo(float).eps
    # Doubling ends, because s²M outgrows any negative damping.
    while _smallest_scaled_eigenvalue(full + shift * damping + shift**2 * mass) <= limit:
        shift *= 2.0
    return shift


def _smallest_scaled_eigenvalue(matrix: Matrix) -> float:
    """Return the smallest eigenvalue of the symmetric part, scaled to a unit diagonal."""
    symmetric = 0.5 * (matrix + matrix.conj().T)
    balance = 1.0 / np.sqrt(np.abs(symmetric.diagonal()))
    return float(la.eigvalsh(balance[:, None] * symmetric * balance)[0])


def apart_from_zeros(values: ComplexArray, shapes: ComplexArray, least: float = 0.0) -> Spectrum:
    """Separate oscillatory pairs, real eigenvalues and zeros, whose number is not known.

    `values`, `shapes`: of all eigenvalues, (m,) and (n, m); `least`: |λ| below this is zero, as it
    is below a part of the largest.
    """
    still = np.abs(values) < max(_STILL * np.abs(values).max(), least)
    real = ~still & (np.abs(values.imag) <= _REAL * np.abs(values))
    turning = np.flatnonzero(~still & ~real & (values.imag > 0))
    turning = turning[np.argsort(values[turning].imag, kind="stable")]
    return Spectrum(values[turning], shapes[:, turning], np.sort(values[real].real))


def are_real(values: ComplexArray) -> BoolArray:
    """Tell which eigenvalues are real: equal real ones split into pairs by rounding."""
    return np.asarray(np.abs(values.imag) <= _REAL_FRACTION * np.abs(values))


def _sorted_spectrum(values: ComplexArray, shapes: ComplexArray, count: int) -> Spectrum:
    """Separate oscillatory pairs, real eigenvalues and zeros."""
    nonzero, is_real = values != 0, are_real(values)
    order = np.flatnonzero(nonzero & ~is_real & (values.imag > 0))
    order = order[np.argsort(values.imag[order], kind="stable")][:count]
    return Spectrum(values[order], shapes[:, order], np.sort(values.real[nonzero & is_real]))
