"""Pairs of directions that turn into each other, on a mesh that no turn leaves as it is.

A body of revolution on a mesh of any kind has its modes in pairs that are nearly the same, turned
by nearly 90°. Here its interior vectors become exact pairs (first, second) with L first = second:
the projected generator of turns P = ∫ρ v·Ju of the modes, which are M-orthonormal, has eigenvalues
near ±i and near 0, and its eigenvectors x + iy are the pairs. Matrices are then averaged over
quarter turns in these coordinates (`evenly_turned`); what that changes is of the order of the error
of the mesh, and is measured.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg as la

from solidwhirl.reduction.basis.craig_bampton import Basis, orthogonality_error
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.solvers.vectors import apply, inner, project, skew, symmetric
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.superelement.rigid_body import RIGID_TURN

# Eigenvalues of the generator above this belong to fields that turn, the others to axial ones.
_TURNS = 0.5
# Interface motions and what they turn into.
_TURNED = {"ux": ("uy", 1.0), "uy": ("ux", -1.0), "rx": ("ry", 1.0), "ry": ("rx", -1.0)}
# Fields of the plane of x and their turns: rigid motions and signs.
_RIGID = ((("ux", 1.0), ("uy", 1.0)), (("ry", 1.0), ("rx", -1.0)))
_HELD = 1e-9
# Modes at rest and at speed, over the highest squared frequency of those at rest.
_ABOVE = 1.05
# Squared frequencies below this part of the lowest with all interfaces held are rounding.
_RIGID_BELOW = 1e-5
# Motions whose frequencies count in any case: two pairs.
_FIRST = 4


def paired(operators: BodyOperators, basis: Basis, orders: tuple[int, ...]) -> Basis:
    """Return the basis with its interior vectors in pairs, with the generator of turns in it.

    `operators`, `basis`: of a solid that is a body of revolution, but whose mesh is the same after
    no turn. `orders`: circumferential orders that are kept; without 0 the vectors that do not turn
    are left out. Result: interface columns first and as they are, then rigid motions that are
    free, then modes; its generator has entries -1, 0, 1. Raises ReductionError: an interface
    carries a motion but not what it turns into.
    """
    b, f = basis.interface_count, basis.free.shape[1]
    constraint, elastic = basis.vectors[:, :b], basis.vectors[:, b + f :]
    rigid, still = _free_motions(operators)
    pairs, rest = _elastic_pairs(operators, elastic)
    columns = [constraint, *rigid, pairs]
    turning = (sum(r.shape[1] for r in rigid) + pairs.shape[1]) // 2
    if 0 in orders:
        columns += [*still, rest]
    vectors = np.hstack(columns)
    generator = np.zeros((vectors.shape[1],) * 2)
    generator[:b, :b] = _interface_generator(operators.coupling.coordinates)
    for k in range(turning):
        first = b + 2 * k
        generator[first + 1, first], generator[first, first + 1] = 1.0, -1.0
    values = np.diag(project(operators.stiffness, vectors[:, b:], operators.comm))
    values = np.maximum(values, 0.0)
    return replace(
        basis,
        vectors=vectors,
        eigenvalues=values,
        generator=generator,
        orthogonality=orthogonality_error(operators, basis),
    )


def even_gyroscopic(operators: BodyOperators, basis: Basis, mass: FloatArray) -> FloatArray:
    """Return G of a round body from its mass and the turn of its coordinates.

    `mass`: (n, n) reduced mass, averaged over turns.

    With D u = e_z × u - L u the matrix is 2 ∫ρ v·Du = 2 (∫ρ v·(e_z × u) - M L): the derivative
    along the spin of the field on the mesh, which mixes circumferential orders, is not needed.
    """
    full = operators.coupling.unknowns.displacement(basis.vectors)
    x, y = (np.ascontiguousarray(full[i::3]) for i in range(2))
    crossed = inner(y, apply(operators.ingredients.component_mass, x), operators.comm)
    across = evenly_turned(crossed - crossed.T, basis.generator)
    assert basis.generator is not None
    return skew(2.0 * (across - mass @ basis.generator))


def averaging_change(operators: BodyOperators, basis: Basis, speed_rad_s: float) -> float:
    """Return how far averaging over turns moves frequencies of the free body, relative; the most.

    `operators`, `basis`: of a body of revolution, the basis in pairs. `speed_rad_s`: up to which
    frequencies count, and those of the first two pairs. Half of what pairs are apart is in it, and
    half of what the inertia of rigid motions is unlike in two directions.
    """
    assert basis.generator is not None
    kept = basis.fixed_eigenvalues[basis.fixed_eigenvalues > 0.0]
    highest = float(kept[-1]) if len(kept) else np.inf
    # static corrections above the modes mix what the mesh has of all circumferential orders
    chosen = np.abs(basis.generator).any(axis=0)
    chosen[basis.interface_count :] &= basis.eigenvalues <= _ABOVE * highest
    vectors = basis.vectors[:, chosen]
    turns = basis.generator[np.ix_(chosen, chosen)]
    stiffness, mass = (
        symmetric(project(matrix, vectors, operators.comm))
        for matrix in (operators.stiffness, operators.mass)
    )
    even = evenly_turned(mass, turns)
    values, shapes = la.eigh(evenly_turned(stiffness, turns), even)
    elastic = values > _RIGID_BELOW * float(kept[0] if len(kept) else values[-1])
    rigid = shapes[:, ~elastic]
    moved = 0.5 * np.abs(np.linalg.eigvalsh(rigid.T @ mass @ rigid) - 1.0)
    counts = elastic & ((np.cumsum(elastic) <= _FIRST) | (values <= speed_rad_s**2))
    own = np.maximum(la.eigvalsh(stiffness, mass), 0.0)
    bent = np.abs(np.sqrt(own[counts] / values[counts]) - 1.0)
    return float(max(moved.max(initial=0.0), bent.max(initial=0.0)))


def _interface_generator(coordinates: tuple[tuple[str, str], ...]) -> FloatArray:
    out = np.zeros((len(coordinates),) * 2)
    for k, (interface, component) in enumerate(coordinates):
        if component not in _TURNED:
            continue
        other, sign = _TURNED[component]
        if (interface, other) not in coordinates:
            raise ReductionError(
                f"interface {interface!r} carries {component} but not {other}; a body of "
                "revolution needs both"
            )
        out[coordinates.index((interface, other)), k] = sign
    return out


def _free_motions(operators: BodyOperators) -> tuple[list[FloatArray], list[FloatArray]]:
    """Rigid motions that no interface holds: lateral ones in pairs, and those along the axis.

    The pairs are exact motions, orthonormal in the mean over turns.
    """
    comm, motions = operators.comm, operators.rigid_motions
    rows = operators.coupling.held

    def held(motion: FloatArray) -> FloatArray:
        seen = inner(rows, motion[:, None], comm)[:, 0]
        return np.asarray(seen / np.maximum(np.sqrt(np.diag(inner(rows, rows, comm))), 1e-300))

    firsts = np.column_stack([motions[a[0]] * a[1] for a, _ in _RIGID])
    seconds = np.column_stack([motions[b[0]] * b[1] for _, b in _RIGID])
    mass = [inner(v, apply(operators.mass, v), comm) for v in (firsts, seconds)]
    even = 0.5 * (mass[0] + mass[1])
    root = np.linalg.inv(np.linalg.cholesky(even)).T
    lateral: list[FloatArray] = []
    free = root
    if rows.shape[1]:
        seen = np.column_stack([held(firsts @ c) for c in root.T])
        _, s, vt = np.linalg.svd(seen)
        rank = int(np.sum(s > _HELD * max(s.max(initial=0.0), 1e-300)))
        free = root @ vt[rank:].T
    for c in free.T:
        lateral.append(np.column_stack([firsts @ c, seconds @ c]))
    axial: list[FloatArray] = []
    for name in ("uz", "rz"):
        motion = motions[name]
        if not rows.shape[1] or np.abs(held(motion)).max() <= _HELD * np.abs(motion).max():
            size = float(inner(motion[:, None], apply(operators.mass, motion[:, None]), comm)[0, 0])
            axial.append(motion[:, None] / np.sqrt(size))
    return lateral, axial


def _elastic_pairs(operators: BodyOperators, elastic: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Elastic vectors in pairs by rising frequency, and those that do not turn."""
    comm = operators.comm
    if not elastic.shape[1]:
        return elastic, elastic
    change = skew(project(operators.turn, elastic, comm))
    stiffness = symmetric(project(operators.stiffness, elastic, comm))
    values, vectors = np.linalg.eigh(1j * change)
    turning = vectors[:, values > _TURNS]
    # their conjugates have the eigenvalues of opposite sign: real and imaginary parts are
    # orthogonal and equally long
    first, second = np.sqrt(2.0) * turning.real, np.sqrt(2.0) * turning.imag
    _, shape = np.linalg.eigh(_complex_form(stiffness, first, second))
    ones, others = (
        first @ shape.real + second @ shape.imag,
        second @ shape.real - first @ shape.imag,
    )
    pairs = np.empty((elastic.shape[1], 2 * shape.shape[1]))
    pairs[:, 0::2], pairs[:, 1::2] = ones, others
    basis, _ = np.linalg.qr(np.hstack([pairs, np.eye(len(pairs))]))
    rest = basis[:, pairs.shape[1] : elastic.shape[1]]
    _, turn = np.linalg.eigh(symmetric(rest.T @ stiffness @ rest))
    return elastic @ pairs, elastic @ (rest @ turn)


def _complex_form(matrix: FloatArray, first: FloatArray, second: FloatArray) -> ComplexArray:
    """Hermitian matrix of c, q = first Re c + second Im c, of the mean over quarter turns."""
    a, b = first.T @ matrix @ first, second.T @ matrix @ second
    c, d = second.T @ matrix @ first, first.T @ matrix @ second
    return np.asarray(0.5 * (a + b) + 0.5j * (c - d))


def evenly_turned_motions(rigid: FloatArray, generator: FloatArray | None) -> FloatArray:
    """Return the rigid motions of a body of revolution without the rounding that tells x from y.

    `rigid`: (n, 6) ux, uy, uz, rx, ry, rz in reduced coordinates. `generator`: (n, n) L with
    entries -1, 0, 1; None leaves the motions as they are.

    A turn takes ux to uy and rx to ry: L R = R T, hence R = -L R T, and the mean of both is taken.
    """
    if generator is None:
        return rigid
    lateral = np.abs(generator).any(axis=0)
    out = rigid.copy()
    even = 0.5 * (rigid - generator @ rigid @ RIGID_TURN)
    columns = RIGID_TURN.any(axis=0)
    out[np.ix_(lateral, columns)] = even[np.ix_(lateral, columns)]
    out[np.ix_(~lateral, columns)] = 0.0
    return out


def evenly_turned(matrix: FloatArray, generator: FloatArray | None) -> FloatArray:
    """Return a matrix of a body of revolution without the rounding that tells x from y.

    `matrix`: (n, n) in reduced coordinates. `generator`: (n, n) L with entries -1, 0, 1; None
    leaves the matrix as it is.
    """
    if generator is None:
        return matrix
    lateral = np.abs(generator).any(axis=0)
    even = 0.5 * (matrix + generator.T @ matrix @ generator)
    out = np.zeros_like(matrix)
    out[np.ix_(lateral, lateral)] = even[np.ix_(lateral, lateral)]
    out[np.ix_(~lateral, ~lateral)] = matrix[np.ix_(~lateral, ~lateral)]
    return out
