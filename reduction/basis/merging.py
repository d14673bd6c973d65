"""Many vectors into few: an M-orthonormal basis of all that they span."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.solvers.vectors import (
    apply,
    diagonal,
    inner,
    project,
    squares,
    symmetric,
    uncancelled,
)
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, Matrix

# New directions shorter than this are the same vector twice: what is dropped changes the elastic
# energy by its square, what is kept has its round-off divided by it. The kinetic energy of a mode
# changes by more, as the square of its frequency over the lowest one, which for a slender body is
# thousands: of vectors that are solved to rounding no more is dropped than rounding asks for.
_SAME_VECTOR, _SAME_EXACT = 3e-4, 1e-6
# Directions whose mass is this small beside the others' are stiff beyond any frequency of use.
_WEIGHTLESS = 1e-12
# Inertia in the energy of the merge, for rigid motions that are free, over a reference eigenvalue.
_INERTIA = 1e3
# Roundings of its energy beyond which a vector has some.
_BENT = 10.0
# A Rayleigh quotient whose root is this near to n counts as order n; a mesh mixes orders a little.
# A mesh that is the same after a quarter turn mixes order 0 with order 4, whose J² is 16, and no
# other order lies between 0 and 1.
_ORDER_TOLERANCE, _ORDER_ZERO = 0.25, 0.7


def is_of_order(squared: FloatArray, orders: tuple[int, ...]) -> BoolArray:
    """Whether Rayleigh quotients of J² belong to one of the circumferential orders."""
    order = np.sqrt(np.maximum(squared, 0.0))
    near = {n: _ORDER_ZERO if n == 0 else _ORDER_TOLERANCE for n in orders}
    return np.any([np.abs(order - n) < near[n] for n in orders], axis=0)  # type: ignore[no-any-return]


def reference_eigenvalue(operators: BodyOperators) -> float:
    """A small squared frequency: 1e-9 of a mean of K_ii/M_ii, far below the elastic modes.

    It is the harmonic mean: one stiff part must not lift it to the modes of the rest.
    """
    real = np.empty((0, 0))
    rates = diagonal(operators.mass, real) / diagonal(operators.stiffness, real)
    comm = operators.comm
    return float(1e-9 * comm.allreduce(len(rates)) / comm.allreduce(float(rates.sum())))


def rounding_of_energies(operators: BodyOperators, block: Matrix) -> FloatArray:
    """One rounding of the elastic energy of every column, of which that of all elements is made."""
    return np.finfo(float).eps * uncancelled(operators.stiffness, block, operators.comm)


def merged(
    operators: BodyOperators,
    free: Matrix,
    blocks: list[Matrix],
    orders: tuple[int, ...] | None,
    *,
    exact: int = 0,
) -> tuple[Matrix, FloatArray]:
    """M-orthonormal interior vectors without duplicates, and their Rayleigh-Ritz eigenvalues.

    The rigid motions that the interfaces leave free, M-orthonormal, come first and as they are:
    they have no stiffness, and a trace of other vectors would give them some.

    Block by block what is new is taken in, in the energy of K and of M times a low eigenvalue: a
    small difference of two vectors can be stiff. On a solid mesh, directions that are not of the
    wanted circumferential orders are dropped: a trace of other orders, which the mesh mixes in,
    would come out as modes of no accuracy. The first `exact` blocks are solved to rounding.
    """
    comm = operators.comm
    f = free.shape[1]
    basis = _independent(operators, [free, *blocks], 1 + exact)[:, f:]
    if not basis.shape[1]:
        return free, np.zeros(f)
    inertia = apply(operators.mass, free)
    gram = symmetric(project(operators.mass, basis, comm))
    s, q = np.linalg.eigh(gram)
    heavy = s > _WEIGHTLESS * s.max()
    basis = basis @ (q[:, heavy] / np.sqrt(s[heavy]))
    # a second pass takes out the round-off of the first
    basis -= free @ inner(inertia, basis, comm)
    gram = symmetric(project(operators.mass, basis, comm))
    basis = basis @ np.linalg.inv(np.linalg.cholesky(gram)).conj().T
    if orders is not None:
        squared, turn = np.linalg.eigh(symmetric(project(operators.circulation, basis, comm)))
        basis = basis @ turn[:, is_of_order(squared, orders)]
    values, turn = np.linalg.eigh(symmetric(project(operators.stiffness, basis, comm)))
    basis = np.hstack([free, _turned_columns(basis, turn)])
    return basis, np.concatenate([np.zeros(f), values])


def _independent(operators: BodyOperators, blocks: list[Matrix], exact: int) -> Matrix:
    """Directions of all blocks, orthonormal in energy; block Gram-Schmidt, each twice."""
    comm = operators.comm
    low = _small_eigenvalue(operators, blocks[1:])

    def energy(block: Matrix) -> Matrix:
        return np.asarray(apply(operators.stiffness, block) + low * apply(operators.mass, block))

    basis = blocks[0][:, :0]
    loaded = basis
    for at, block in enumerate(blocks):
        if not block.shape[1]:
            continue
        size = np.sqrt(np.maximum(squares(block, energy(block), comm), 0.0))
        new = block[:, size > 0.0] / size[size > 0.0]
        for _ in range(2):
            new = new - basis @ inner(loaded, new, comm)
        s, q = np.linalg.eigh(symmetric(inner(new, energy(new), comm)))
        other = s > (_SAME_EXACT if at < exact else _SAME_VECTOR) ** 2
        new = new @ (q[:, other] / np.sqrt(s[other]))
        basis, loaded = np.hstack([basis, new]), np.hstack([loaded, energy(new)])
    return basis


def _small_eigenvalue(operators: BodyOperators, blocks: list[Matrix]) -> float:
    """A squared frequency for the inertia in the energy, no larger than the lowest of the vectors.

    With finer elements the reference rises, and of slender bodies it passes the lowest modes: what
    bends them would then be light beside their motion, and dropped. Vectors without energy of their
    own do not count.
    """
    comm = operators.comm
    low = _INERTIA * reference_eigenvalue(operators)
    for block in (b for b in blocks if b.shape[1]):
        forces = [apply(m, block) for m in (operators.stiffness, operators.mass)]
        k, m = (squares(block, f, comm) for f in forces)
        bent = k > _BENT * rounding_of_energies(operators, block)
        low = min(low, float((k[bent] / m[bent]).min(initial=low)))
    return low


def _turned_columns(basis: Matrix, turn: Matrix) -> FloatArray:
    """Rotate columns and fix their sign (largest entry of the turn positive)."""
    largest = turn[np.abs(turn).argmax(axis=0), np.arange(turn.shape[1])]
    return np.asarray(basis @ (turn * (largest.conj() / np.abs(largest))))


#: Modes this near in λ are one cluster: their directions are not determined.
CLUSTER = 1e-6


def whole_clusters(values: FloatArray, wanted: int, highest: float) -> int:
    """Number of leading modes near the wanted one that cuts no repeated mode in half.

    The last cluster may lack a member unless a mode of another order was found beyond it.

    `values`: (m,) rising eigenvalues of the wanted orders. `highest`: highest eigenvalue of all
    orders.
    """
    beyond = np.append(values[1:], highest)
    ends = [k + 1 for k in range(len(values)) if beyond[k] - values[k] > CLUSTER * abs(beyond[k])]
    enough = [k for k in ends if k >= wanted]
    return enough[0] if enough else (ends[-1] if ends else 0)


def modes_of_orders(
    operators: BodyOperators, values: FloatArray, vectors: Matrix, orders: tuple[int, ...]
) -> tuple[FloatArray, FloatArray]:
    """Modes of the wanted circumferential orders, by the Rayleigh quotient of J².

    `values`, `vectors`: (m,) rising and (local û, m) M-orthonormal eigenpairs of all orders.
    Returns values, vectors: those of the wanted orders, rising.
    """
    squared = project(operators.circulation, vectors, operators.comm)
    gram = project(operators.mass, vectors, operators.comm)
    start = 0
    found, turned = [np.empty(0)], [vectors[:, :0]]
    for stop in range(1, len(values) + 1):
        if stop < len(values) and values[stop] - values[stop - 1] <= CLUSTER * abs(values[stop]):
            continue
        span = slice(start, stop)
        n2, turn = scipy.linalg.eigh(squared[span, span], gram[span, span])
        for order in sorted(set(orders)):
            own = turn[:, is_of_order(n2, (order,))]
            # members of a cluster are near each other, not equal: each gets its own value again
            own_values, again = np.linalg.eigh(own.T * values[span] @ own)
            found.append(own_values)
            turned.append(vectors[:, span] @ own @ again)
        start = stop
    kept, rotated = np.concatenate(found), np.hstack(turned)
    rising = np.argsort(kept, kind="stable")
    return kept[rising], rotated[:, rising]
