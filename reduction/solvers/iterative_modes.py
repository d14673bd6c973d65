"""Lowest modes under linear constraints by a preconditioned block iteration (LOBPCG).

Knyazev, SIAM J. Sci. Comput. 23 (2001) 517-541; the basis is kept orthonormal as Hetmaniuk and
Lehoucq do (J. Comp. Phys. 218 (2006) 324-332), without which it fails near convergence. Modes that
have converged stay in the basis and make no new directions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.solvers.multigrid import ConstrainedIteration
from solidwhirl.reduction.solvers.vectors import apply, inner, symmetric
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray

#: Error of a mode in the energy norm, relative; an eigenvalue's is about the square of it.
MODE = 1e-10
_ITERATIONS = 300
# Modes beyond those wanted, which take the slow end of the convergence: at least, and as a part.
_GUARD, _GUARD_PART = 4, 0.25
# Directions shorter than this, after the others are taken out, are round-off.
_LOST = 1e-10


def iterative_pairs(
    iteration: ConstrainedIteration,
    mass: Any,
    *,
    count: int,
    tolerance: float = MODE,
    start: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Lowest eigenpairs of K u = λ M u under the constraints of an iteration.

    `iteration`: with A = K - σ M. `tolerance`: error of a mode in the energy norm. `start`: (local,
    s) fields to begin with. Returns eigenvalues (count,), vectors (local, count): rising, of K;
    M-orthonormal. Raises ReductionError: fewer pairs than asked converged.
    """
    comm, local = iteration.comm, mass.getLocalSize()[0]
    width = count + max(_GUARD, int(_GUARD_PART * count))
    random = np.random.default_rng(comm.rank).standard_normal((local, width))
    first = iteration.preconditioned(apply(mass, random))
    if start is not None:
        first = np.hstack([iteration.cleaned(start), first])[:, : max(width, start.shape[1])]
    x = _orthonormal(first, np.empty((local, 0)), mass, comm)
    ax = apply(iteration.matrix, x)
    values, turn = np.linalg.eigh(symmetric(inner(x, ax, comm)))
    x, ax = x @ turn[:, :width], ax @ turn[:, :width]
    values = values[:width]
    p, ap = np.empty((local, 0)), np.empty((local, 0))
    for _ in range(_ITERATIONS):
        left = ax - apply(mass, x) * values
        w = iteration.preconditioned(left)
        energy = comm.allreduce(np.einsum("ij,ij->j", left, w))
        going = energy > tolerance**2 * np.abs(values)
        if not going[:count].any():
            x = iteration.cleaned(x[:, :count])
            x = _orthonormal(x, np.empty((local, 0)), mass, comm)
            values, turn = np.linalg.eigh(symmetric(inner(x, apply(iteration.matrix, x), comm)))
            return values + iteration.shift, x @ turn
        w = _orthonormal(w[:, going], np.hstack([x, p]), mass, comm)
        aw = apply(iteration.matrix, w)
        values, x, ax, p, ap = _projected((x, p, w), (ax, ap, aw), going, comm)
    done = int(np.argmax(going))
    raise ReductionError(f"{done} of {count} fixed-interface modes converged")


def _projected(
    basis: tuple[FloatArray, ...], images: tuple[FloatArray, ...], going: BoolArray, comm: Any
) -> tuple[FloatArray, ...]:
    """Rayleigh-Ritz on [X, P, W]: values, X, A X, and P, A P of the modes that go on."""
    m = basis[0].shape[1]
    whole, image = np.hstack(basis), np.hstack(images)
    values, shapes = np.linalg.eigh(symmetric(inner(whole, image, comm)))
    shapes = shapes[:, :m]
    # what the new modes have beyond the old ones, orthonormal to the new ones
    last = shapes[:, going].copy()
    last[:m] = 0.0
    for _ in range(2):
        last -= shapes @ (shapes.T @ last)
        u, s, _ = np.linalg.svd(last, full_matrices=False)
        last = u[:, s > _LOST * s.max(initial=0.0)]
    both = np.hstack([shapes, last])
    new, moved = whole @ both, image @ both
    return values[:m], new[:, :m], moved[:, :m], new[:, m:], moved[:, m:]


def _orthonormal(block: FloatArray, basis: FloatArray, mass: Any, comm: Any) -> FloatArray:
    """What a block has beyond an M-orthonormal basis, M-orthonormal."""
    for _ in range(3):
        weight = apply(mass, block)
        size = np.sqrt(comm.allreduce(np.einsum("ij,ij->j", block, weight)))
        block, weight = block / size, weight / size
        part = inner(basis, weight, comm)
        block = block - basis @ part
        gram = symmetric(inner(block, apply(mass, block), comm))
        s, q = np.linalg.eigh(gram)
        keep = s > _LOST**2 * s.max(initial=1.0)
        block = block @ (q[:, keep] / np.sqrt(s[keep]))
    return block
