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

from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.fixed_interface_modes import shifted_matrix
from solidwhirl.reduction.basis.free_motion import straining_part
from solidwhirl.reduction.basis.reduced_block import ReducedBlock, planes
from solidwhirl.reduction.operators import compat, forms, kinematics
from solidwhirl.reduction.operators.coupling import Coupling, couple
from solidwhirl.reduction.operators.joints.layers import layer_in, layer_on, with_layer
from solidwhirl.reduction.operators.joints.press_fits import added_matrices
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.operators.matrices import (
    BodyOperators,
    assembled,
    meridian_matrices,
    sector_matrices,
)
from solidwhirl.reduction.operators.solid_matrices import SectorStiffness, component_mass
from solidwhirl.reduction.operators.solver_choice import Solver
from solidwhirl.reduction.residuals.relaxation import relaxation
from solidwhirl.reduction.residuals.singular_cells import singular_nodes
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, factorise
from solidwhirl.reduction.solvers.vectors import apply, inner, project, symmetric
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.superelement.record import ErrorForm
from solidwhirl.rotordyn.superelement.validation import Frame

# Displacement r^α at the end of a rigid surface on a straight outline; at a re-entrant corner of
# 270° the exponent is 0.5445 (Williams, J. Appl. Mech. 19 (1952) 526-528), so this covers both.
_SINGULAR_EXPONENT = 0.5
# Ratio of the whole error to what the next order shows in elements that touch no such place.
_SMOOTH_SAFETY = 1.3
# On what the element factors give.
_RESERVE = 1.25
# Relative error of an iterative solution that only tells how large what is left out is.
_ROUGH = 1e-4
# Steps of conjugate gradients, and what they find of the energy that the next order adds: 0.83 to
# 0.92 on four rotors of 12 and of 24 sectors, whatever the size of the elements [measured].
_STEPS, _FOUND = 3, 0.85
# Columns that a finer space is solved for together: each takes some ten vectors of that space.
_BLOCK = 16
# Terms of the series behind the element factor.
_SERIES = 100_000


@dataclass(frozen=True, kw_only=True, eq=False)
class Omitted:
    """Energy of what is left out, one family of one circumferential order."""

    part: str
    #: (4 n, 4 n) Hermitian, blocks in the order K, M, G (N for two families), Kσ - S
    gram: Matrix
    safety: float  #: Factor on the energy that covers what the comparison can not see
    cutoff_rad_s: float  #: Lowest angular frequency of what is left out; inf: far away


@dataclass(frozen=True, kw_only=True, eq=False)
class FinerSpace:
    """The body on the same mesh with elements one order higher, and how V misses it."""

    space: Any
    stiffness: Any  #: Its K (û of that space), with the weights of the elements' energies
    #: (4 blocks, local û, n) the omitted displacement per unit of each term of the residual
    misses: Matrix
    coupling: Coupling
    ingredients: Any
    singular: BoolArray  #: Which vertices are at re-entrant edges or ends of rigid interfaces


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
        gram += np.trace(gram).real / np.trace(held @ held.conj().T).real * (held @ held.conj().T)
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


def _answer(operators: BodyOperators, basis: Basis, load: Matrix, inside: Matrix) -> Matrix:
    """Displacement under loads, of which the part in the basis is known."""
    if isinstance(basis.factor, ConstrainedFactor):
        return basis.factor.solve(load, None)[: len(load)]
    rest = load - apply(operators.stiffness, inside)
    return inside + basis.factor.solve(rest, None, tolerance=_ROUGH)


def residual_terms(
    operators: BodyOperators, block: Matrix, strained: int | None = None
) -> FloatArray:
    """K V, M V, G V (N V) and (Kσ - S) V, zero where a matrix is absent; (4, local û, n).

    `strained`: leading columns that K V is wanted of; None: all.
    """
    out = np.zeros((4, *block.shape), dtype=block.dtype)
    out[0, :, :strained] = apply(operators.stiffness, block[:, :strained])
    out[1] = apply(operators.mass, block)
    if operators.gyroscopic is not None:
        out[2] = apply(operators.gyroscopic, block)
    if operators.stress_stiffening is not None:
        out[3] = apply(operators.stress_stiffening, block) - apply(operators.spin_softening, block)
    return out


def mesh_energy(
    operators: BodyOperators, basis: Basis, answers: Matrix, interfaces: Any
) -> tuple[Omitted, FinerSpace]:
    """Energy that elements one order higher would take up, on the same mesh.

    `operators`, `basis`: of one body and order, of a meridian, a sector, or a whole solid in its
    own axes. Returns energy: part "mesh"; finer: for indicators of single elements.

    The next order does not show the whole error. The energy of every element is multiplied by what
    it leaves out: `singular_factor` where the element touches a re-entrant corner or the end of a
    rigid interface, a constant elsewhere.
    """
    degree = compat.polynomial_degree(operators.space) + 1
    finer = _finer_operators(operators, operators.ingredients.kinematics, degree, interfaces)
    solver: Solver
    if operators.ingredients.kinematics.dimension == 2:
        solver, found = _factor(finer, basis.shift), 1.0
    else:
        free = _raised(operators, finer, basis.free)
        solver, found = relaxation(finer, free, operators.comm), _FOUND
    misses = _missed(operators, basis, answers, finer, solver)
    finer.stiffness.destroy()
    given = operators.ingredients
    singular = singular_nodes(
        finer.space.mesh, given.facet_tags, interfaces, given.kinematics.cyclic
    )
    weighted = _weighted_stiffness(operators, finer, singular)
    energy = _gram(weighted, misses, operators.comm) / found
    omitted = Omitted(part="mesh", gram=energy, safety=_RESERVE, cutoff_rad_s=np.inf)
    kept = FinerSpace(
        space=finer.space,
        stiffness=weighted,
        misses=_single(misses),  # they only tell where the error is
        coupling=finer.coupling,
        ingredients=finer.ingredients,
        singular=singular,
    )
    # PETSc keeps what Python merely drops
    for held in (weighted, finer.coupling.unknowns):
        weakref.finalize(kept, held.destroy)
    return omitted, kept


def joint_energy(
    operators: BodyOperators, basis: Basis, answers: Matrix, interfaces: Any
) -> Omitted:
    """Energy that the next orders would take up where stages meet their drum: part "stage_joints".

    `operators`, `basis`: of one cyclic index of a body with joints. Of index 0, whose next orders
    load nothing that bends, it is zero.
    """
    kin = operators.ingredients.kinematics
    assert kin.joined is not None
    if kin.harmonic == 0:
        size = _TERMS * basis.vectors.shape[1]
        energy: Matrix = np.zeros((size, size), dtype=basis.vectors.dtype)
    else:
        degree = compat.polynomial_degree(operators.space)
        every = replace(kin, joined=kin.joined.every_order())
        finer = _finer_operators(operators, every, degree, interfaces)
        folded = {name: getattr(finer, name).folded() for name in ("stiffness", "mass")}
        finer = replace(finer, **folded)
        solver = _factor(finer, basis.shift)
        misses = _missed(operators, basis, answers, finer, solver)
        energy = _gram(finer.stiffness, misses, operators.comm)
        finer.stiffness.destroy()
        finer.coupling.unknowns.destroy()
    return Omitted(part="stage_joints", gram=energy, safety=1.0, cutoff_rad_s=np.inf)


def lift_energy(
    operators: BodyOperators, basis: Basis, maximum_speed_rad_s: float
) -> Omitted | None:
    """Energy that faces free which lift between rest and the largest speed: part "joint_lift".

    `operators`, `basis`: of one order of a meridian, whose layer is that at rest. It is taken to
    grow with the fourth power of the speed. None where the same is closed at both.
    """
    given = operators.ingredients
    at_rest, springs = given.joints.layer, [own.at_top for own in given.joints.springs]
    lost = at_rest and at_rest.without(layer_on(at_rest.points, springs))
    if lost is None:
        return None
    change = operators.coupling.unknowns.folded(lost.stiffness(given.kinematics))
    at_top = with_layer(operators.stiffness.copy(), change.copy(), -1.0)
    shifted = shifted_matrix(operators, at_top, basis.shift)
    factor = factorise(shifted, operators.coupling.held)
    loads = balanced(apply(change, basis.vectors)[None], operators, basis.free)
    freed = factor.solve(loads[0], None)[: len(loads[0])]
    freed = _unmoved(freed[None], operators, basis.free)[0]
    n = basis.vectors.shape[1]
    energy = project(at_top, freed, operators.comm) + project(change, basis.vectors, operators.comm)
    gram: Matrix = np.zeros((_TERMS, n, _TERMS, n))
    # as a residual of the square of the speed
    gram[3, :, 3] = symmetric(energy) / maximum_speed_rad_s**4
    factor.destroy()
    for made in {id(m): m for m in (change, at_top, shifted)}.values():
        made.destroy()
    return Omitted(
        part="joint_lift", gram=gram.reshape(_TERMS * n, _TERMS * n), safety=1.0,
        cutoff_rad_s=np.inf,
    )  # fmt: skip


def _missed(
    operators: BodyOperators, basis: Basis, answers: Matrix, finer: BodyOperators, solver: Solver
) -> Matrix:
    """Displacement that a wider space has beyond the answers to the terms of the residual.

    `solver`: of the wider space with the interfaces held; it is used up. Result: (4, local û of the
    wider space, n). Of its matrices only the stiffness is left.
    """
    v, b = basis.vectors, basis.interface_count
    free = _raised(operators, finer, basis.free)
    misses: Matrix = np.zeros((_TERMS, len(free), v.shape[1]), dtype=v.dtype)
    for start in range(0, v.shape[1], _BLOCK):
        span = slice(start, start + _BLOCK)
        # the modes answer their own strain in the space they are of
        strained = max(b - start, 0)
        loads = residual_terms(finer, _raised(operators, finer, v[:, span]), strained)
        loads = balanced(loads, finer, free)
        for k in range(1, _TERMS):
            if loads[k].any():
                known = _raised(operators, finer, answers[k][:, span])
                left = loads[k] - apply(finer.stiffness, known)
                if basis.shift:
                    left += basis.shift * apply(finer.mass, known)
                loads[k] = _answers(solver, left)
        if strained:
            loads[0, :, :strained] = _answers(solver, loads[0, :, :strained])
        misses[:, :, span] = _unmoved(loads, finer, free)
    solver.destroy()
    for unused in (finer.mass, finer.gyroscopic, finer.stress_stiffening, finer.spin_softening):
        if unused is not None:
            unused.destroy()
    return misses


def _answers(solver: Solver, load: Matrix) -> Matrix:
    """Displacement under loads, to what an estimate needs."""
    if isinstance(solver, ConstrainedFactor):
        return solver.solve(load, None)[: len(load)]
    return solver.relaxed(load, _STEPS)


def _factor(finer: BodyOperators, shift: float) -> ConstrainedFactor:
    """Factor of a wider space."""
    shifted = shifted_matrix(finer, finer.stiffness, shift)
    factor = factorise(shifted, finer.coupling.held)
    if shifted is not finer.stiffness:
        shifted.destroy()
    return factor


def _single(values: Matrix) -> Matrix:
    """In single precision."""
    return values.astype(np.complex64 if np.iscomplexobj(values) else np.float32)


def balanced(loads: Matrix, operators: BodyOperators, free: Matrix) -> FloatArray:
    """Take from loads (..., local û, n), in their place, what only accelerates the whole body.

    The residual of a motion in the basis does no work on rigid motions that the basis holds, but
    its terms do, and a stiffness without supports would answer them without bounds.
    """
    inertia = apply(operators.mass, free)
    return _without(loads, inertia, free, operators)


def _unmoved(fields: Matrix, operators: BodyOperators, free: Matrix) -> FloatArray:
    """Answers to balanced loads without the motion as a whole that rounding gives them.

    The stiffness without supports answers rounding of the loads with one over its tiny shift.
    """
    inertia = apply(operators.mass, free)
    return _without(fields, free, inertia, operators)


def _without(blocks: Matrix, taken: Matrix, seen: Matrix, operators: BodyOperators) -> FloatArray:
    """Blocks of columns less what of `taken` makes them orthogonal to `seen`, in their place."""
    if taken.shape[1]:
        gram = inner(seen, taken, operators.comm)
        for block in blocks:
            block -= taken @ np.linalg.solve(gram, inner(seen, block, operators.comm))
    return blocks


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


def _weighted_stiffness(operators: BodyOperators, finer: BodyOperators, singular: BoolArray) -> Any:
    """K of the finer space, every element times what the next order leaves out there."""
    given, domain = finer.ingredients, finer.space.mesh
    degree = compat.polynomial_degree(operators.space)
    factor = fem.Function(compat.scalar_space(domain, "DG", 0))
    at_edge = singular[compat.straight_cells(domain)[1]].any(axis=1)
    values = np.where(at_edge, singular_factor(degree), _SMOOTH_SAFETY)
    compat.owned_values(factor)[:] = values
    kin = replace(given.kinematics, weight=factor * given.kinematics.weight)
    u, v = ufl.TrialFunction(finer.space), ufl.TestFunction(finer.space)
    dx = forms.measure(domain, kin, degree + 1)
    form = forms.stiffness_form(kin, given.matter, u, v, dx)
    layer = layer_in(finer.space, given.facet_tags, given.joints.springs)
    springs = layer and layer.stiffness(given.kinematics, _SMOOTH_SAFETY)
    matrix = with_layer(assembled(form), springs)
    if given.kinematics.dimension == 2:
        return finer.coupling.unknowns.folded(matrix)
    return SectorStiffness(unknowns=finer.coupling.unknowns, matrix=matrix)


def _gram(stiffness: Any, blocks: Matrix, comm: Any) -> FloatArray:
    """Energy products of all columns of all blocks."""
    k, _, n = blocks.shape
    out = np.zeros((k, n, k, n), dtype=blocks.dtype)
    there = [bool(comm.allreduce(int(block.any()))) for block in blocks]
    for a in np.flatnonzero(there):
        loaded = apply(stiffness, blocks[a])
        for b in np.flatnonzero(there):
            out[b, :, a] = inner(blocks[b], loaded, comm)
    return symmetric(out.reshape(k * n, k * n))


def _finer_operators(
    operators: BodyOperators, kin: Kinematics, degree: int, interfaces: Any
) -> BodyOperators:
    """The same matrices in a wider space; the prestress is that of the first."""
    given = operators.ingredients
    matter = given.matter
    space = compat.vector_space(operators.space.mesh, degree, 3)
    coupling = couple(
        space,
        kin,
        dict(given.facet_tags),
        interfaces,
        given.effects.components,
        given.effects.shape,
    )
    prestress = None
    if given.effects.centrifugal:
        whole = kin.dimension == 3 or kin.harmonic == 0
        around = kin if whole else kinematics.harmonic(space.mesh, 0)
        prestress = forms.stress(around, matter, given.centrifugal_field)
    layer = layer_in(space, given.facet_tags, given.joints.springs)
    if layer is not None and prestress is not None:
        steady = compat.owned_values(given.centrifugal_field)[:, None]
        layer = layer.loaded(_interpolated(operators.space, space, steady)[:, 0])
    added = added_matrices(space, kin, matter, layer, given.joints.fit)
    if kin.dimension == 2:
        matrices = meridian_matrices(
            space, kin, matter, given.effects, prestress, coupling.unknowns, added
        )
    else:
        dx = forms.measure(space.mesh, kin, degree)
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
        stiffness = assembled(forms.stiffness_form(kin, matter, u, v, dx))
        parts = (stiffness, component_mass(space, kin, matter, dx))
        matrices = sector_matrices(
            space, kin, parts, dx, given.effects, prestress, coupling.unknowns, added
        )
    return replace(operators, coupling=coupling, space=space, **matrices)


def _raised(operators: BodyOperators, finer: BodyOperators, block: Matrix) -> Matrix:
    """Columns û of the body's space as û of the finer space."""
    given, wanted = operators.coupling.unknowns, finer.coupling.unknowns
    full = given.displacement(block)
    raised = _interpolated(operators.space, finer.space, full.real)
    if np.iscomplexobj(full):
        raised = raised + 1j * _interpolated(operators.space, finer.space, full.imag)
    return wanted.raised(given, block, raised)


def _interpolated(source_space: Any, target_space: Any, full: FloatArray) -> FloatArray:
    """Nodal values of columns of fields in another space on the same mesh."""
    source, target = fem.Function(source_space), fem.Function(target_space)
    out = np.empty((len(compat.owned_values(target)), full.shape[1]))
    for k in range(full.shape[1]):
        compat.owned_values(source)[:] = full[:, k]
        source.x.scatter_forward()
        target.interpolate(source)
        out[:, k] = compat.owned_values(target)
    return out


_TERMS = 4  # K, M, G, Kσ - S
# Of these, what a rigid motion feels nothing of: it strains nothing, and in the inertial frame the
# prestress turns with the body (K R = 0 and (Kσ - S) R = 0 of the full problem on any mesh).
_OF_STRAIN = {"inertial": (0, 3), "rotating": (0,)}


def joined_forms(
    blocks: Sequence[ReducedBlock],
    omitted: Sequence[tuple[Omitted, ...]],
    order: IntArray,
    frame: Frame,
) -> tuple[ErrorForm, ...]:
    """Error forms of a superelement.

    `omitted`: what every block leaves out, the same parts for all; () for none. `order`: order of
    the superelement's coordinates among those of the stacked blocks. `frame`: of its matrices.
    """
    out = []
    for parts in zip(*omitted, strict=True):
        grams = [_of_block(part, block, frame) for part, block in zip(parts, blocks, strict=True)]
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


def _of_block(omitted: Omitted, block: ReducedBlock, frame: Frame) -> FloatArray:
    """Gram matrix (4, n, 4, n) in the coordinates of a block.

    Two families have the terms K c, M c, 2i N c and (Kσ - S) c, c = q1 - i q2. Of motions that
    strain nothing the terms of K and Kσ - S are zero by construction: rounding there, of the size
    of K, would be an error without bounds of a slow motion.
    """
    size = len(omitted.gram) // _TERMS
    families = len(block.signs) // size
    single = omitted.gram.reshape(_TERMS, size, _TERMS, size)
    whole = np.zeros((_TERMS, families * size, _TERMS, families * size))
    factor = np.array([1.0, 1.0, 2.0j, 1.0])
    for a in range(_TERMS):
        for b in range(_TERMS):
            gram = single[a, :, b]
            if families == 2:
                gram = planes(factor[a].conj() * factor[b] * gram)
            whole[a, :, b] = gram
    whole *= block.signs[:, None, None] * block.signs
    whole = whole[:, block.order][..., block.order]
    strain = straining_part(block.matrices["mass"], block.rigid)
    for a in _OF_STRAIN[frame]:
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
