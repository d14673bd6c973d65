"""Fixed-interface modes of a spinning body from those at rest, with the factor at rest.

K + Ω² (Kσ - S) differs little from K in all but the lowest modes. Rayleigh-Ritz on the modes at
rest, grown by K⁻¹ times the residuals (the generalised Davidson method: Morgan and Scott, SIAM J.
Sci. Stat. Comput. 7 (1986) 817-825), needs a few blocks of solutions instead of a factorisation.

The stiffness is positive if 1 + Ω² θ > 0 for all θ of (Kσ - S) x = θ K x; the lowest θ, an end of
that spectrum, comes from a Krylov space of a random start.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from solidwhirl.reduction.basis.overspeed import centrifugal_load, softest_direction
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.operators.solver_choice import Solver
from solidwhirl.reduction.solvers.block_krylov import GrowingSpace, bordered_image
from solidwhirl.reduction.solvers.vectors import apply, inner, squares
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray

# Correction that is left of a mode, in the norm of the mass. In the energy norm rounding alone is
# 5e-9: it has the highest frequencies of the mesh, which the mass hardly sees, and directions made
# of it spoil the space.
_CORRECTION = 1e-9
# What rounding may leave of it on fine meshes; squared frequencies are then good to 1e-12.
_ROUNDING = 1e-6
_SWEEPS = 10
_LAST_CORRECTIONS = 2
# Relative error of the lowest θ; the margin has to be much larger than it.
_SOFTEST = 1e-2
#: Part of the stiffness at rest, in the softest direction, below which inertia is counted.
MARGIN = 0.2


@dataclass(frozen=True, kw_only=True, eq=False)
class Spinning:
    """The pencil of a body at speed, its interfaces held."""

    operators: BodyOperators
    speed_rad_s: float
    factor: Solver  #: Solver of K - shift M at rest
    free: FloatArray  #: (local, f) rigid motions that the interfaces leave free, M-orthonormal

    @property
    def mass(self) -> Any:
        """M, PETSc."""
        return self.operators.mass

    def times(self, block: FloatArray) -> FloatArray:
        """K + Ω² (Kσ - S) times a block."""
        centrifugal = centrifugal_load(self.operators, block)
        elastic = apply(self.operators.stiffness, block)
        return np.asarray(elastic + self.speed_rad_s**2 * centrifugal)

    def answer(self, block: FloatArray) -> FloatArray:
        """Displacement of the held body at rest under a block of loads."""
        return self.factor.solve(block, None)[: len(block)]

    @property
    def remaining_stiffness(self) -> float:
        """Least part of the stiffness at rest that the body has in any direction, at most 1.

        1 + Ω² θ of the lowest θ, less its possible error.
        """
        least = MARGIN / self.speed_rad_s**2
        theta, error = softest_direction(self.operators, self.factor, self.free, _SOFTEST, least)
        if not np.isfinite(theta):
            return -np.inf
        return float(min(1.0, 1.0 + self.speed_rad_s**2 * (theta - error)))


def modes_at_speed(
    body: Spinning, start: FloatArray, wanted: Callable[[FloatArray, FloatArray], BoolArray]
) -> tuple[FloatArray, FloatArray, int] | None:
    """Fixed-interface modes at speed.

    `start`: (local, m) modes at rest, M-orthonormal. `wanted`: which of some eigenvalues (m,) and
    vectors (local, m) are to converge. Returns eigenvalues (m,), vectors (local, m), solutions:
    rising, of which the wanted ones have converged; None if they have not, or if an eigenvalue is
    not positive. Solutions counts the columns that went through the factor.

    What differs from the modes at rest is small, and a basis of both divides the error of the
    modes by it. The last corrections, which would spoil the space, are therefore taken off the
    converged modes themselves: each leaves some hundredths of the error.
    """
    comm = body.mass.comm.tompi4py()
    f, count = body.free.shape[1], start.shape[1]
    weight_free = apply(body.mass, body.free)
    space = GrowingSpace(body.free, body.mass, comm)
    new = space.extend(np.array(start, order="F"), apply(body.mass, start))
    image, images, solutions, done = np.zeros((0, 0), dtype=start.dtype), [], 0, 0
    largest, best = [np.inf], (np.empty(0), start)
    for _ in range(_SWEEPS):
        images.append(body.times(space.columns(-new)))
        image = bordered_image(image, inner(space.columns(f), images[-1], comm))
        values, shapes = np.linalg.eigh(image)
        values, shapes = values[:count], shapes[:, :count]
        if values[0] <= 0.0:
            return None
        vectors = space.columns(f) @ shapes
        use = np.flatnonzero(wanted(values, vectors))[done:]
        product = np.hstack(images) @ shapes[:, use]
        step = _correction(body, weight_free, product, values[use], vectors[:, use])
        solutions += len(use)
        weight = apply(body.mass, step)
        squared = squares(step, weight, comm)
        open_ = squared > _CORRECTION**2
        largest.append(float(squared.max(initial=0.0)))
        if largest[-1] < min(largest[:-1]):
            best = values, vectors
        # a sweep that brought nothing, or whose directions were rounding
        is_rounding = min(largest) <= _ROUNDING**2 and largest[-1] > min(largest)
        if not open_.any() or is_rounding:
            values, vectors = best
            last = np.flatnonzero(wanted(values, vectors))
            for _ in range(_LAST_CORRECTIONS):
                shown = vectors[:, last]
                product = body.times(shown)
                vectors[:, last] -= _correction(body, weight_free, product, values[last], shown)
            return values, vectors, solutions + _LAST_CORRECTIONS * len(last)
        if len(largest) > 2 and largest[-1] >= largest[-3]:
            return None  # two sweeps that brought nothing: a factor is sooner there
        done += int(np.argmax(open_))
        new = space.extend(np.asfortranarray(step[:, open_]), weight[:, open_])
        if not new:
            return None
    return None


def _correction(
    body: Spinning,
    weight_free: FloatArray,
    product: FloatArray,
    values: FloatArray,
    vectors: FloatArray,
) -> FloatArray:
    """K⁻¹ times the residuals of modes at speed, from the product of the stiffness there."""
    residual = product - apply(body.mass, vectors) * values
    residual -= weight_free @ inner(body.free, residual, body.mass.comm.tompi4py())
    return body.answer(residual)
