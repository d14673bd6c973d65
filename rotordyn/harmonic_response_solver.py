"""Dense solutions of [K + iωV − ω²M] q = f at many points, in chunks that fit a cache."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.errors import AnalysisError

MatrixTriple: TypeAlias = tuple[FloatArray, FloatArray | ComplexArray, FloatArray | ComplexArray]
# Mass, velocity and stiffness matrix at a speed Ω.
PointMatrices: TypeAlias = Callable[[float], MatrixTriple]

# Bytes of the dynamic stiffness matrices solved together.
CHUNK_BYTES = 1 << 20
# |D| |q| / |f| above which fewer than three digits of q are left.
_SINGULAR = 1e-3 / np.finfo(float).eps


class Solved(NamedTuple):
    """q, shape (p, n, r), and the largest |f − D q| / |f| of each point, shape (p,)."""

    displacement: ComplexArray
    relative_residual: FloatArray


def solve_points(
    matrices: PointMatrices, speeds: FloatArray, frequencies: FloatArray, loads: ComplexArray
) -> Solved:
    """Solve for the response at each point; a point without load is not solved.

    Parameters
    ----------
    matrices
        M, V and K at a speed, each (n, n); V and K may be complex.
    speeds, frequencies
        Ω and ω of the points, shape (p,), rad/s; ω of either sign.
    loads
        f, shape (p, n, r).

    Returns
    -------
    Solved
        Residuals are in coordinates scaled by powers of two to a diagonal near 1.

    Raises
    ------
    AnalysisError
        If a point is singular to working accuracy; the message names it.
    """
    count, n, _ = loads.shape
    displacement = np.zeros(loads.shape, dtype=complex)
    residual = np.zeros(count)
    loaded = np.flatnonzero(loads.any(axis=(1, 2)))
    if not loaded.size:
        return Solved(displacement, residual)
    at_speed = ScaledMatrices(matrices, float(speeds[loaded[0]]), np.abs(frequencies).max())
    scale = at_speed.scale[:, None]
    chunk = max(1, CHUNK_BYTES // (16 * n * n))
    dynamic = np.empty((min(chunk, loaded.size), n, n), dtype=complex)
    work = np.empty((n, n))
    for start in range(0, loaded.size, chunk):
        points = loaded[start : start + chunk]
        stack = dynamic[: points.size]
        for place, point in zip(stack, points, strict=True):
            fill_dynamic_stiffness(
                place, at_speed.at(float(speeds[point])), float(frequencies[point]), work
            )
        where = (speeds[points], frequencies[points])
        solution, residual[points] = _solve_stack(stack, loads[points] * scale, *where)
        displacement[points] = solution * scale
    return Solved(displacement, residual)


class ScaledMatrices:
    """Keep the scaled matrices of the last speed, as points of equal speed follow each other.

    Scales are powers of two near 1/√(K + ω²M), so that scaling rounds nothing.
    """

    def __init__(self, matrices: PointMatrices, speed: float, highest: float) -> None:
        mass, _, stiffness = matrices(speed)
        size = np.abs(np.diag(stiffness)) + highest**2 * np.diag(mass)
        _, exponent = np.frexp(np.where(size > 0, size, 1.0))
        self.scale: FloatArray = np.ldexp(1.0, -(exponent // 2))
        self._outer = np.multiply.outer(self.scale, self.scale)
        self._matrices = matrices
        self._mass = mass * self._outer
        self._speed: float | None = None
        self._found: MatrixTriple | None = None

    def at(self, speed: float) -> MatrixTriple:
        """Return M, V and K at a speed, scaled from both sides."""
        if self._found is None or speed != self._speed:
            _, velocity, stiffness = self._matrices(speed)
            self._speed = speed
            self._found = (self._mass, velocity * self._outer, stiffness * self._outer)
        return self._found


def fill_dynamic_stiffness(
    place: ComplexArray, triple: MatrixTriple, omega: float, work: FloatArray
) -> None:
    """Write K + iωV − ω²M to a place."""
    mass, velocity, stiffness = triple
    np.multiply(mass, -(omega**2), out=work)
    if np.isrealobj(velocity) and np.isrealobj(stiffness):
        np.add(work, stiffness, out=place.real)
        np.multiply(velocity, omega, out=place.imag)
        return
    np.multiply(velocity, 1j * omega, out=place)
    place += stiffness
    place += work


def _solve_stack(
    stack: ComplexArray, loads: ComplexArray, speeds: FloatArray, frequencies: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Solve a stack of systems and measure each solution."""
    try:
        solution = np.linalg.solve(stack, loads)
    except np.linalg.LinAlgError:
        at = next(k for k, dynamic in enumerate(stack) if not _has_inverse(dynamic))
        raise _singular(speeds, frequencies, at) from None
    error = loads - stack @ solution
    flat = stack.view(float).reshape(stack.shape[0], -1)
    size = np.sqrt(np.einsum("pi,pi->p", flat, flat))
    force, motion, left = (column_norms(a) for a in (loads, solution, error))
    force = np.where(force > 0, force, np.inf)
    growth = (size[:, None] * motion / force).max(axis=1)
    bad = ~(growth <= _SINGULAR)
    if bad.any():
        raise _singular(speeds, frequencies, int(bad.argmax()))
    return solution, (left / force).max(axis=1)


def _has_inverse(matrix: ComplexArray) -> bool:
    try:
        np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return False
    return True


def column_norms(vectors: ComplexArray) -> FloatArray:
    """Return the lengths of the columns, shape (p, r)."""
    squares = vectors.real**2 + vectors.imag**2
    return np.asarray(np.sqrt(squares.sum(axis=1)))


def _singular(speeds: FloatArray, frequencies: FloatArray, at: int) -> AnalysisError:
    speed, omega = float(speeds[at]), abs(float(frequencies[at]))
    return AnalysisError(
        f"at speed {speed:.10g} rad/s and frequency {omega:.10g} rad/s "
        f"({omega / (2.0 * np.pi):.8g} Hz) the system is at an undamped resonance, or free to "
        "drift, and has no steady response; add damping or leave this point out"
    )
