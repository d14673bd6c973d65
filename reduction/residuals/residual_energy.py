"""What a reduced body leaves out: modes that were truncated, and what its elements can't follow.

For motion q e^{st} in the reduced coordinates the residual of the full problem is

    R(s, Ω) q = (K + s² M + s Ω G + Ω² (Kσ - S)) V q .

Its energy in the inverse of the elastic stiffness, with the interfaces held, is what eliminating
the omitted displacement would take from the reduced dynamic stiffness (Schur complement). The
residual is a combination of K V, M V, G V and (Kσ - S) V, so one Gram matrix of these four blocks
holds that energy for every motion and every speed.
"""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg
import ufl
from dolfinx import fem
from scipy.special import gammaln

from solidwhirl.meshing.own.drawing import chain_ends
from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.fixed_interface_modes import shifted_matrix
from solidwhirl.reduction.basis.free_motion import straining_part
from solidwhirl.reduction.basis.reduced_block import ReducedBlock
from solidwhirl.reduction.operators import compat, forms, kinematics
from solidwhirl.reduction.operators.coupling import Coupling, couple
from solidwhirl.reduction.operators.matrices import BodyOperators, assembled
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, factorise
from solidwhirl.reduction.solvers.vectors import apply, inner, project, symmetric
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.superelement.record import ErrorForm

# Displacement r^α at the end of a rigid surface on a straight outline; at a re-entrant corner of
# 270° the exponent is 0.5445 (Williams, J. Appl. Mech. 19 (1952) 526-528), so this covers both.
_SINGULAR_EXPONENT = 0.5
# Ratio of the whole error to what the next order shows in elements that touch no such place.
_SMOOTH_SAFETY = 1.3
# On what the element factors give.
_RESERVE = 1.25
# Interior angle beyond which a vertex of the outline is a corner and no point of an arc [rad].
_REENTRANT = np.radians(215.0)
# Two facets whose directions add up to less than this are one straight line.
_STRAIGHT = 1e-3
# Relative error of an iterative solution that only tells how large what is left out is.
_ROUGH = 1e-4
# Terms of the series behind the element factor.
_SERIES = 100_000


@dataclass(frozen=True, kw_only=True, eq=False)
class Omitted:
    """Energy of what is left out, one family of one circumferential order."""

    part: str
    #: (4 n, 4 n) symmetric, blocks in the order K, M, G (N for two families), Kσ - S
    gram: FloatArray
    safety: float  #: Factor on the energy that covers what the comparison can not see
    cutoff_rad_s: float  #: Lowest angular frequency of what is left out; inf: far away


@dataclass(frozen=True, kw_only=True, eq=False)
class FinerSpace:
    """The body on the same mesh with elements one order higher, and how V misses it."""

    space: Any
    stiffness: Any  #: Its K (û of that space)
    #: (4 blocks, local û, n) the omitted displacement per unit of each term of the residual
    misses: FloatArray
    coupling: Coupling
    ingredients: Any


def truncation_energy(operators: BodyOperators, basis: Basis) -> tuple[Omitted, FloatArray]:
    """Energy of the modes that the basis lacks.

    `operators`, `basis`: of one body and order; the factor of the basis is used again. Returns
    energy: part "mode_truncation"; answers: (4, local û, n) displacement of the held body under the
    terms K V, M V, G V, (Kσ - S) V as loads, in the whole space of the mesh.
    """
    comm, v, b = operators.comm, basis.vectors, basis.interface_count
    interior = v[:, b:]
    loads = balanced(residual_terms(operators, v), operators, basis.free)
    # what lies in V is no error: take it out in the metric of K; rigid motions, which balanced
    # loads do not move, only need to be kept from a division by zero
    gram = symmetric(project(operators.stiffness, interior, comm))
    if basis.free.shape[1]:
        held = inner(interior, apply(operators.mass, basis.free), comm)
        gram += np.trace(gram) / np.trace(held @ held.T) * (held @ held.T)
    answers, outside = np.zeros_like(loads), np.zeros_like(loads)
    answers[0, :, b:] = interior
    for k in range(1, 4):
        if not comm.allreduce(int(loads[k].any())):
            continue
        inside = np.zeros_like(loads[k])
        if interior.shape[1]:
            inside = interior @ np.linalg.solve(gram, inner(interior, loads[k], comm))
        answers[k] = _answer(operators, basis, loads[k], inside)
        outside[k] = answers[k] - inside
    energy = _gram(operators.stiffness, outside, comm)
    cutoff = float(np.sqrt(max(basis.omitted_eigenvalue, 0.0)))
    omitted = Omitted(part="mode_truncation", gram=energy, safety=1.1, cutoff_rad_s=cutoff)
    return omitted, answers


def _answer(
    operators: BodyOperators, basis: Basis, load: FloatArray, inside: FloatArray
) -> FloatArray:
    """Displacement under loads, of which the part in the basis is known."""
    if isinstance(basis.factor, ConstrainedFactor):
        return basis.factor.solve(load, None)[: len(load)]
    rest = load - apply(operators.stiffness, inside)
    return inside + basis.factor.solve(rest, None, tolerance=_ROUGH)


def residual_terms(operators: BodyOperators, block: FloatArray) -> FloatArray:
    """K V, M V, G V (N V) and (Kσ - S) V, zero where a matrix is absent; (4, local û, n)."""
    out = np.zeros((4, *block.shape))
    out[0] = apply(operators.stiffness, block)
    out[1] = apply(operators.mass, block)
    if operators.gyroscopic is not None:
        out[2] = apply(operators.gyroscopic, block)
    if operators.stress_stiffening is not None:
        out[3] = apply(operators.stress_stiffening, block) - apply(operators.spin_softening, block)
    return out


def mesh_energy(
    operators: BodyOperators, basis: Basis, answers: FloatArray, interfaces: Any
) -> tuple[Omitted, FinerSpace]:
    """Energy that elements one order higher would take up, on the same meridian mesh.

    `operators`, `basis`: of one body and order, harmonic level. Returns energy: part "mesh"; finer:
    for indicators of single elements.

    The next order does not show the whole error. The energy of every element is multiplied by what
    it leaves out: `singular_factor` where the element touches a re-entrant corner or the end of a
    rigid interface, a constant elsewhere.
    """
    degree = compat.polynomial_degree(operators.space) + 1
    finer = _finer_operators(operators, degree, interfaces)
    v, b = basis.vectors, basis.interface_count
    loads = residual_terms(finer, _raised(operators, finer, v))
    free = _raised(operators, finer, basis.free)
    loads = balanced(loads, finer, free)
    rows = finer.coupling.held
    shifted = shifted_matrix(finer, finer.stiffness, basis.shift)
    factor = factorise(shifted, rows)
    if shifted is not finer.stiffness:
        shifted.destroy()
    for k in range(1, 4):  # in place of the loads, which are not needed any more
        if loads[k].any():
            moved = factor.solve(loads[k], None)[: loads.shape[1]]
            loads[k] = moved - _raised(operators, finer, answers[k])
    loads[0, :, :b] = factor.solve(loads[0][:, :b], None)[: loads.shape[1]]
    loads[0, :, b:] = 0.0
    factor.destroy()
    loads = _unmoved(loads, finer, free)
    misses = loads
    weighted = _weighted_stiffness(operators, finer, interfaces)
    energy = _gram(weighted, misses, operators.comm)
    weighted.destroy()
    for unused in (finer.mass, finer.gyroscopic, finer.stress_stiffening, finer.spin_softening):
        if unused is not None:
            unused.destroy()
    omitted = Omitted(part="mesh", gram=energy, safety=_RESERVE, cutoff_rad_s=np.inf)
    kept = FinerSpace(
        space=finer.space,
        stiffness=finer.stiffness,
        misses=misses.astype(np.float32),  # they only tell where the error is
        coupling=finer.coupling,
        ingredients=finer.ingredients,
    )
    # PETSc keeps what Python merely drops
    for matrix in (finer.stiffness, finer.coupling.transformation):
        if matrix is not None:
            weakref.finalize(kept, matrix.destroy)
    return omitted, kept


def balanced(loads: FloatArray, operators: BodyOperators, free: FloatArray) -> FloatArray:
    """Loads without what only accelerates the body as a whole, (..., local û, n) like them.

    The residual of a motion in the basis does no work on rigid motions that the basis holds, but
    its terms do, and a stiffness without supports would answer them without bounds.
    """
    inertia = apply(operators.mass, free)
    return _without(loads, inertia, free, operators)


def _unmoved(fields: FloatArray, operators: BodyOperators, free: FloatArray) -> FloatArray:
    """Answers to balanced loads without the motion as a whole that rounding gives them.

    The stiffness without supports answers rounding of the loads with one over its tiny shift.
    """
    inertia = apply(operators.mass, free)
    return _without(fields, free, inertia, operators)


def _without(
    blocks: FloatArray, taken: FloatArray, seen: FloatArray, operators: BodyOperators
) -> FloatArray:
    """Blocks of columns less what of `taken` makes them orthogonal to `seen`."""
    if not taken.shape[1]:
        return blocks
    gram = inner(seen, taken, operators.comm)
    out = blocks.copy()
    for block in out:
        block -= taken @ np.linalg.solve(gram, inner(seen, block, operators.comm))
    return out


def singular_factor(degree: int, exponent: float = _SINGULAR_EXPONENT) -> float:
    """Ratio of the energy error of an element at a singular point to what the next order shows.

    `exponent`: α of the displacement r^α at the point. Result: Σ_{n ≥ p} c_n² / c_p² with the
    coefficients c_n of r^(α-1) in the polynomials that are orthogonal on (0, 1) with weight r
    (Jacobi): c_n² ~ (n + 1) [Γ(n+1-α) / Γ(n+2+α)]². For large p this is 1 / (1 - (p / (p +
    1))^(4α)), the rate of Babuška and Suri, SIAM Review 36 (1994) 578-632.
    """
    n = np.arange(degree, degree + _SERIES, dtype=float)
    ratio = gammaln(n + 1.0 - exponent) - gammaln(n + 2.0 + exponent)
    squares = np.exp(2.0 * (ratio - ratio[0])) * (n + 1.0) / (degree + 1.0)
    # the rest of the series is that of n^(-4α-1)
    rest = squares[-1] * n[-1] / (4.0 * exponent)
    return float(squares.sum() + rest)


def _weighted_stiffness(operators: BodyOperators, finer: BodyOperators, interfaces: Any) -> Any:
    """K of the finer space, every element times what the next order leaves out there."""
    given, domain = finer.ingredients, finer.space.mesh
    degree = compat.polynomial_degree(operators.space)
    factor = fem.Function(compat.scalar_space(domain, "DG", 0))
    singular = _singular_cells(domain, given.facet_tags, interfaces)
    values = np.where(singular, singular_factor(degree), _SMOOTH_SAFETY)
    compat.owned_values(factor)[:] = values
    kin = replace(given.kinematics, weight=factor * given.kinematics.weight)
    u, v = ufl.TrialFunction(finer.space), ufl.TestFunction(finer.space)
    dx = forms.measure(domain, kin, degree + 1)
    return assembled(forms.stiffness_form(kin, given.matter, u, v, dx), finer.coupling)


def _singular_cells(domain: Any, facet_tags: Any, interfaces: Any) -> BoolArray:
    """Cells of a meridian mesh that touch a re-entrant corner or the end of a rigid interface."""
    points, cells = compat.straight_cells(domain)
    sides = points[np.roll(cells, -1, axis=1)] - points[cells]
    sides /= np.linalg.norm(sides, axis=2, keepdims=True)
    angles = np.arccos(np.clip(-(sides * np.roll(sides, 1, axis=1)).sum(axis=2), -1.0, 1.0))
    around = np.zeros(len(points))
    np.add.at(around, cells, angles)
    # inside the material the angles add up to a full turn
    singular = (around > _REENTRANT) & (around < 2.0 * np.pi - 1e-3)
    for interface in interfaces:
        if interface.coupling == "rigid":
            facets = _facet_nodes(domain, cells, facet_tags[interface.name])
            singular[chain_ends(points, facets, _STRAIGHT)] = True
    return np.asarray(singular[cells].any(axis=1))


def _facet_nodes(domain: Any, cells: IntArray, tags: Any) -> IntArray:
    """Nodes of the mesh at the two ends of the facets of an interface."""
    topology = domain.topology
    topology.create_connectivity(1, 0)
    corners = topology.connectivity(2, 0).array.reshape(-1, 3)[: len(cells)]
    node = np.zeros(int(corners.max()) + 1, dtype=np.int64)
    node[corners] = cells
    ends = topology.connectivity(1, 0).array.reshape(-1, 2)
    return np.asarray(node[ends[tags.indices]])


def _gram(stiffness: Any, blocks: FloatArray, comm: Any) -> FloatArray:
    """Energy products of all columns of all blocks."""
    k, _, n = blocks.shape
    out = np.zeros((k, n, k, n))
    there = [bool(comm.allreduce(int(block.any()))) for block in blocks]
    for a in np.flatnonzero(there):
        loaded = apply(stiffness, blocks[a])
        for b in np.flatnonzero(there):
            out[b, :, a] = inner(blocks[b], loaded, comm)
    return symmetric(out.reshape(k * n, k * n))


def _finer_operators(operators: BodyOperators, degree: int, interfaces: Any) -> BodyOperators:
    """The same matrices with elements of another order; the prestress is that of the first."""
    given = operators.ingredients
    kin, matter = given.kinematics, given.matter
    space = compat.vector_space(operators.space.mesh, degree, 3)
    coupling = couple(space, kin, dict(given.facet_tags), interfaces, given.effects.components)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    dx = forms.measure(space.mesh, kin, degree)
    wanted = {
        "stiffness": forms.stiffness_form(kin, matter, u, v, dx),
        "mass": forms.mass_form(kin, matter, u, v, dx),
    }
    if given.effects.gyroscopic:
        wanted["gyroscopic"] = forms.gyroscopic_form(kin, matter, u, v, dx)
    if given.effects.centrifugal:
        around = kin if kin.harmonic == 0 else kinematics.harmonic(space.mesh, 0)
        prestress = forms.stress(around, matter, given.centrifugal_field)
        wanted["stress_stiffening"] = forms.stiffening_form(kin, prestress, u, v, dx)
        wanted["spin_softening"] = forms.softening_form(kin, matter, u, v, dx)
    matrices = {name: assembled(form, coupling) for name, form in wanted.items()}
    return replace(operators, coupling=coupling, space=space, **matrices)


def _raised(operators: BodyOperators, finer: BodyOperators, block: FloatArray) -> FloatArray:
    """Columns û of the body's space as û of the finer space."""
    source, target = fem.Function(operators.space), fem.Function(finer.space)
    given, wanted = operators.coupling, finer.coupling
    full = given.displacement(block)
    kept = wanted.kept
    rows = len(kept) + len(block) - len(given.kept)
    out = np.empty((rows, block.shape[1]))
    out[len(kept) :] = block[len(given.kept) :]
    for k in range(block.shape[1]):
        compat.owned_values(source)[:] = full[:, k]
        source.x.scatter_forward()
        target.interpolate(source)
        out[: len(kept), k] = compat.owned_values(target)[kept]
    return out


_TERMS = 4  # K, M, G, Kσ - S
# Of these, what a rigid motion feels nothing of: it strains nothing, and the prestress turns with
# the body (K R = 0 and (Kσ - S) R = 0 of the full problem on any mesh).
_OF_STRAIN = (0, 3)


def joined_forms(
    blocks: Sequence[ReducedBlock], omitted: Sequence[tuple[Omitted, ...]], order: IntArray
) -> tuple[ErrorForm, ...]:
    """Error forms of a superelement.

    `omitted`: what every block leaves out, the same parts for all; () for none. `order`: order of
    the superelement's coordinates among those of the stacked blocks.
    """
    out = []
    for parts in zip(*omitted, strict=True):
        grams = [_of_block(part, block) for part, block in zip(parts, blocks, strict=True)]
        out.append(
            ErrorForm(
                part=parts[0].part,
                gram=_direct_sum(grams, order),
                stiffness_change=None,
                safety=max(part.safety for part in parts),
                cutoff_rad_s=min(part.cutoff_rad_s for part in parts),
            )
        )
    return tuple(out)


def _of_block(omitted: Omitted, block: ReducedBlock) -> FloatArray:
    """Gram matrix (4, n, 4, n) in the coordinates of a block.

    Two families have the same K, M and Kσ - S, and G = [[0, 2N], [-2N, 0]]. Of motions that strain
    nothing the terms of K and Kσ - S are zero by construction: rounding there, of the size of K,
    would be an error without bounds of a slow motion.
    """
    size = len(omitted.gram) // _TERMS
    families = len(block.signs) // size
    single = omitted.gram.reshape(_TERMS, size, _TERMS, size)
    whole = np.zeros((_TERMS, families * size, _TERMS, families * size))
    same, crossed = np.eye(families), 2.0 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    for a in range(_TERMS):
        for b in range(_TERMS):
            left = crossed if (a == 2 and families == 2) else same
            right = crossed if (b == 2 and families == 2) else same
            whole[a, :, b] = np.kron(left.T @ right, single[a, :, b])
    whole *= block.signs[:, None, None] * block.signs
    whole = whole[:, block.order][..., block.order]
    strain = straining_part(block.matrices["mass"], block.rigid)
    for a in _OF_STRAIN:
        whole[a] = np.einsum("ki,kbj->ibj", strain, whole[a])
        whole[:, :, a] = whole[:, :, a] @ strain
    return np.asarray(whole)


def _direct_sum(grams: list[FloatArray], order: IntArray) -> FloatArray:
    """(4 n, 4 n) of several blocks that do not couple."""
    n = len(order)
    out = np.empty((_TERMS, n, _TERMS, n))
    for a in range(_TERMS):
        for b in range(_TERMS):
            joined = scipy.linalg.block_diag(*[g[a, :, b] for g in grams])
            out[a, :, b] = joined[np.ix_(order, order)]
    return symmetric(out.reshape(_TERMS * n, _TERMS * n))
