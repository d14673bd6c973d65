"""Direct solution of dynamic stiffness matrices at points of speed and frequency."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

import numpy as np

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.errors import NoSteadyResponseError
from solidwhirl.rotordyn.core.ledger import solved

MatrixTriple: TypeAlias = tuple[Matrix, Matrix, Matrix]
# Mass, velocity and stiffness matrix at a speed Ω.
PointMatrices: TypeAlias = Callable[[float], MatrixTriple]

# Bytes of the dynamic stiffness matrices solved together.
CHUNK_BYTES = 1 << 20
# (|K| + ω|V| + ω²|M|) |q| / |f| above which fewer than three digits of q are left.
_SINGULAR = 1e-3 / np.finfo(float).eps


class Solved(NamedTuple):
    """q, shape (p, n, r), and the largest |f − D q| / |f| of each point, shape (p,)."""

    displacement: ComplexArray
    relative_residual: FloatArray


def solve_points(
    matrices: PointMatrices, speeds: FloatArray, frequencies: FloatArray, loads: ComplexArray
) -> Solved:
    """Solve for the response at each point; a point without load is not solved.

    `loads`: f, shape (p, n, r). `matrices`: M, V and K at a speed, each (n, n), real or complex, M
    Hermitian. `speeds`, `frequencies`: Ω and ω of the points, shape (p,), rad/s; ω of either sign.
    Residuals are in coordinates scaled by powers of two to a diagonal near 1. Raises
    NoSteadyResponseError if a point is singular to working accuracy; the message names it.
    """
    displacement = np.zeros(loads.shape, dtype=complex)
    residual = np.zeros(speeds.size)
    for chunk in loaded_stacks(matrices, speeds, frequencies, loads, fill):
        points, scale = chunk.points, chunk.scale
        where = (speeds[points], frequencies[points])
        solved("responses", points.size)
        solution, residual[points] = _solve_stack(chunk, loads[points] * scale, *where)
        displacement[points] = solution * scale
    return Solved(displacement, residual)


class Stack(NamedTuple):
    """Scaled dynamic stiffness of some points.

    `points`: their numbers, (c,); `matrices`: D, (c, ..., n, n); `terms`: |K| + ω|V| + ω²|M|, which
    D may be a small difference of, (c,); `scale`: of the coordinates, (n, 1).
    """

    points: IntArray
    matrices: ComplexArray
    terms: FloatArray
    scale: FloatArray


def loaded_stacks(
    matrices: PointMatrices,
    speeds: FloatArray,
    frequencies: FloatArray,
    loads: ComplexArray,
    fill: Callable[[ComplexArray, MatrixTriple, float], None],
) -> Iterator[Stack]:
    """Yield the scaled dynamic stiffness of the points that are loaded."""
    loaded = np.flatnonzero(loads.any(axis=tuple(range(1, loads.ndim))))
    if not loaded.size:
        return
    scaled = ScaledMatrices(matrices, float(speeds[loaded[0]]), float(np.abs(frequencies).max()))
    shape = (*loads.shape[1:-1], loads.shape[-2])
    chunk = max(1, CHUNK_BYTES // (16 * int(np.prod(shape))))
    dynamic = np.empty((min(chunk, loaded.size), *shape), dtype=complex)
    for start in range(0, loaded.size, chunk):
        points = loaded[start : start + chunk]
        stack, terms = dynamic[: points.size], np.empty(points.size)
        for k, point in enumerate(points):
            omega, triple = float(frequencies[point]), scaled.at(float(speeds[point]))
            fill(stack[k], triple, omega)
            terms[k] = scaled.sizes @ (omega**2, abs(omega), 1.0)
        yield Stack(points, stack, terms, scaled.scale[:, None])


class ScaledMatrices:
    """Keep the scaled matrices of the last speed, as points of equal speed follow each other.

    Scales are powers of two near 1/√(K + ω²M), so that scaling rounds nothing.
    """

    def __init__(self, matrices: PointMatrices, speed: float, highest: float) -> None:
        mass, _, stiffness = matrices(speed)
        size = np.abs(np.diag(stiffness)) + highest**2 * np.diag(mass).real
        _, exponent = np.frexp(np.where(size > 0, size, 1.0))
        self.scale: FloatArray = np.ldexp(1.0, -(exponent // 2))
        self._outer = np.multiply.outer(self.scale, self.scale)
        self._matrices = matrices
        self._mass = mass * self._outer
        #: Norms of M, V and K of the last speed
        self.sizes: FloatArray = np.zeros(3)
        self._speed: float | None = None
        self._found: MatrixTriple | None = None

    def at(self, speed: float) -> MatrixTriple:
        """Return M, V and K at a speed, scaled from both sides."""
        if self._found is None or speed != self._speed:
            _, velocity, stiffness = self._matrices(speed)
            self._speed = speed
            self._found = (self._mass, velocity * self._outer, stiffness * self._outer)
            self.sizes = np.array([np.linalg.norm(matrix) for matrix in self._found])
        return self._found


def fill(place: ComplexArray, triple: MatrixTriple, omega: float) -> None:
    """Write K + iωV − ω²M to a place."""
    mass, velocity, stiffness = triple
    inertia = mass * -(omega**2)
    if all(np.isrealobj(matrix) for matrix in triple):
        np.add(inertia, stiffness, out=place.real)
        np.multiply(velocity, omega, out=place.imag)
        return
    np.multiply(velocity, 1j * omega, out=place)
    place += stiffness
    place += inertia


def _solve_stack(
    chunk: Stack, loads: ComplexArray, speeds: FloatArray, frequencies: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Solve a stack of systems and measure each solution."""
    stack = chunk.matrices
    try:
        solution = np.linalg.solve(stack, loads)
    except np.linalg.LinAlgError:
        at = next(k for k, dynamic in enumerate(stack) if not _has_inverse(dynamic))
        raise _singular(speeds, frequencies, at) from None
    error = loads - stack @ solution
    residual, growth = measured(chunk.terms, loads, solution, error)
    bad = ~(growth <= _SINGULAR)
    if bad.any():
        raise _singular(speeds, frequencies, int(bad.argmax()))
    return solution, residual


def measured(
    terms: FloatArray, loads: ComplexArray, solution: ComplexArray, error: ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Return the largest |f − D q| / |f| and |D| |q| / |f| of each point, (p,).

    `terms`: the size of D or of its terms, (p,); the others have shape (p, ..., n, r).
    """
    columns = (a.reshape(a.shape[0], -1, a.shape[-1]) for a in (loads, solution, error))
    force, motion, left = (np.sqrt((a.real**2 + a.imag**2).sum(axis=1)) for a in columns)
    force = np.where(force > 0, force, np.inf)
    return (left / force).max(axis=1), (terms[:, None] * motion / force).max(axis=1)


def _has_inverse(matrix: ComplexArray) -> bool:
    try:
        np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return False
    return True


def _singular(speeds: FloatArray, frequencies: FloatArray, at: int) -> NoSteadyResponseError:
    speed, omega = float(speeds[at]), abs(float(frequencies[at]))
    return NoSteadyResponseError(
        f"at speed {speed:.10g} rad/s and frequency {omega:.10g} rad/s "
        f"({omega / (2.0 * np.pi):.8g} Hz) the system is at an undamped resonance, or free to "
        "drift, and has no steady response; add damping or leave this point out"
    )
