"""Checks of one body's reduction while its matrices and its factor are at hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from petsc4py import PETSc

from solidwhirl.core.reduction_work import BODIES
from solidwhirl.geometry import Body, mass_properties
from solidwhirl.meshing.imported.records import AnyBody, MeshedBody
from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.fixed_interface_modes import shifted_factor
from solidwhirl.reduction.basis.merging import reference_eigenvalue, rounding_of_energies
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, bordered
from solidwhirl.reduction.solvers.vectors import apply, energies, inner, squares
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided
from solidwhirl.rotordyn.superelement.rigid_body import MassProperties

# [measured]: largest over the bodies of all scenes and of the tests, harmonic and solid level.
_RESIDUAL_LIMIT = 2e-11  # [2.6e-13]; the solvers stop at 1e-12 and 1e-11
# Slender blades: rounding of the solution is more than that. As much of it is allowed, but not more
# than what frequencies, half as wrong, have to spare [3.2e-10, titanium blades 70 times as long as
# thick].
_OF_ROUNDING, _MOST_ROUNDING = 10.0, 1e-8
# Modes without a factorisation stop at 1e-10 in the energy norm; an eigenvalue's is its square.
_ITERATIVE_RESIDUAL_LIMIT = 1e-7
# Relative error of the residual itself.
_ROUGH = 1e-2
_ORTHOGONALITY_LIMIT = 5e-13  # [6.4e-15]
_RECIPROCITY_LIMIT = 3e-7  # [1.2e-8], Young's moduli of 2e5 beside 2e11 Pa
# Forces of rigid motions of thin blades are rounding of the forces of their elements: as above
# [1.5e-5, 600 times as long as thick].
_MOST_OF_FORCES = 5e-5
_MASS_LIMIT = 5e-3  # [3.8e-4] with 8 parabolas around the circumference, [1.2e-4] with 12
# Of a mesh against its own quadrature: elements integrate curved ones to the fourth degree only.
_MESH_MASS_LIMIT = 1e-4
# Eigenvalues this far apart (relative) leave room for a shift on the same mesh.
_GAP = 1e-4
_SAME = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN

MODES = "fixed-interface modes and all frequencies of the body"
MISSING = "no fixed-interface mode is missing"


def verify_order(
    operators: BodyOperators, basis: Basis, orthogonality: float, where: str
) -> tuple[Invariant, ...]:
    """Check the basis of one circumferential order, or of the solid.

    `operators`, `basis`: of the body; the factor of the basis is used again. Result: residual of
    the fixed-interface modes at rest, M-orthonormality of them and of the basis, and reciprocity of
    the interface forces.
    """
    out = []
    if basis.fixed_vectors.shape[1]:
        residual, own = fixed_mode_errors(operators, basis)
        orthogonality = max(orthogonality, own)
        name = "residual of every fixed-interface mode"
        direct = isinstance(basis.factor, ConstrainedFactor)
        limit = _RESIDUAL_LIMIT if direct else _ITERATIVE_RESIDUAL_LIMIT
        if direct and residual > limit:
            allowed = _OF_ROUNDING * solution_rounding(operators, basis)
            limit = max(limit, min(allowed, _MOST_ROUNDING))
        out.append(compared(name, where, residual, limit, MODES))
    name = "modes of the basis are M-orthonormal"
    out.append(compared(name, where, orthogonality, _ORTHOGONALITY_LIMIT, MODES))
    if basis.interface_count:
        name = "interface forces are reciprocal"
        error, rounding = reciprocity_error(operators, basis)
        limit = max(_RECIPROCITY_LIMIT, min(_OF_ROUNDING * rounding, _MOST_OF_FORCES))
        concerns = "stiffness of the body between its bearings"
        out.append(compared(name, where, error, limit, concerns))
    return tuple(out)


def fixed_mode_errors(operators: BodyOperators, basis: Basis) -> tuple[float, float]:
    """Return the largest residual of the fixed-interface modes, and their lack of orthonormality.

    Returns residual: |x − (λ − σ)(K − σM)⁻¹M x| over |x| in the norm of M, with the interfaces
    held: a bound of the relative distance of λ − σ from an eigenvalue. Over the ratio of λ − σ to
    the lowest one, as the solution is only good to rounding of its largest part; orthogonality:
    largest entry of XᵀMX − 1, and of RᵀMX of the rigid motions that are free.
    """
    comm, vectors = operators.comm, basis.fixed_vectors
    weight = apply(operators.mass, vectors)
    values = basis.fixed_eigenvalues - basis.shift
    if isinstance(basis.factor, ConstrainedFactor):
        left = vectors - basis.factor.solve(weight, None)[: len(vectors)] * values
    else:
        force = apply(basis.factor.matrix, vectors) - weight * values
        left = basis.factor.solve(force, None, tolerance=_ROUGH)
    # a rounding of rigid motion, which the solution magnifies, is seen by orthogonality
    momentum = apply(operators.mass, basis.free)
    left -= basis.free @ inner(momentum, left, comm)
    size = energies(operators.mass, left, comm)
    gram = inner(vectors, weight, comm)
    residual = np.sqrt(np.maximum(size, 0.0) / np.diag(gram).real) * values.min() / values
    apart = np.abs(gram - np.eye(len(gram))).max()
    rigid = np.abs(inner(momentum, vectors, comm)).max(initial=0.0)
    return float(residual.max()), float(max(apart, rigid))


def solution_rounding(operators: BodyOperators, basis: Basis) -> float:
    """Return by how much a second solution for what the first one left changes it.

    In the norm and the ratio of `fixed_mode_errors`. Exact solutions would not change: what does is
    rounding, which a residual can not fall below.
    """
    weight = apply(operators.mass, basis.fixed_vectors)
    values = basis.fixed_eigenvalues - basis.shift
    found = basis.factor.solve(weight, None)[: len(weight)]
    left = weight - apply(operators.stiffness, found)
    left += basis.shift * apply(operators.mass, found)
    change = basis.factor.solve(left, None)[: len(weight)] * values
    size = energies(operators.mass, change, operators.comm)
    return float((np.sqrt(np.maximum(size, 0.0)) * values.min() / values).max())


def reciprocity_error(operators: BodyOperators, basis: Basis) -> tuple[float, float]:
    """Return how far the interface forces of the constraint modes are from reciprocal.

    Result: with (K − σM)Ψ = B F the forces F at the interfaces for unit motions Ψ: largest of F −
    Fᵀ (Betti's theorem) and of F − Ψᵀ(K − σM)Ψ (forces do the work that is stored), relative to the
    work and the inertia of the motions at the lowest held frequency; what one rounding of the
    forces of all elements is of the same.
    """
    comm = operators.comm
    modes = basis.vectors[:, : basis.interface_count]
    force = apply(operators.stiffness, modes)
    if basis.shift:
        force = force - basis.shift * apply(operators.mass, modes)
    rows = operators.coupling.held
    length = np.sqrt(squares(rows, rows, comm))
    rows = rows / length
    reaction = np.linalg.solve(inner(rows, rows, comm), inner(rows, force, comm)) / length[:, None]
    reaction = reaction[: basis.interface_count]
    work = inner(modes, force, comm)
    # statically determinate interfaces move the body without any force
    inertia = energies(operators.mass, modes, comm)
    root = np.sqrt(np.maximum(np.diag(work).real, 0.0) + _lowest(operators, basis) * inertia)
    errors = [reaction - reaction.conj().T, reaction - work]
    largest = max(float(np.abs(error / np.outer(root, root)).max()) for error in errors)
    rounded = rounding_of_energies(operators, modes) / root**2
    return largest, float(rounded.max())


def _lowest(operators: BodyOperators, basis: Basis) -> float:
    """Return the lowest held eigenvalue, or one far below all."""
    if basis.fixed_eigenvalues.size:
        return float(abs(basis.fixed_eigenvalues[0]))
    return reference_eigenvalue(operators)


def modes_below(operators: BodyOperators, eigenvalue: float) -> int:
    """Count the held eigenvalues at rest below a shift, free rigid motions included.

    `operators`: of the body; all ranks must call. `eigenvalue`: σ [1/s²]; costs one factorisation
    of K − σM under the constraints, whose negative pivots are the border's and these (Sylvester's
    law of inertia).
    """
    rows = operators.coupling.held
    factor = shifted_factor(operators, operators.stiffness, rows, eigenvalue)
    count = factor.indefinite_count
    factor.destroy()
    return count


def count_fixed_modes(operators: BodyOperators, basis: Basis, where: str) -> Invariant:
    """Check on its own mesh that no mode at rest is missing; the basis' factor is used up."""
    if not isinstance(basis.factor, ConstrainedFactor):
        return undecided(MISSING, where, MODES, "modes are counted by a factorisation only")
    shift, found = highest_gap(basis)
    if not found:
        reason = "no two neighbouring eigenvalues are far enough apart"
        return undecided(MISSING, where, MODES, reason)
    try:
        counted = _moved_factor_count(operators, basis, shift) - basis.free.shape[1]
    except ReductionError as error:
        return undecided(MISSING, where, MODES, str(error))
    text = f"{counted} modes counted, {found} found below {np.sqrt(shift) / (2.0 * np.pi):.6g} Hz"
    return compared(MISSING, where, abs(counted - found), 0.0, MODES, text)


def count_found_modes(operators: BodyOperators, basis: Basis, where: str) -> Invariant:
    """Check on its own mesh that no fixed-interface mode is missing; the basis' factor is used up.

    `operators`, `basis`: of a solid on a mesh of any kind.
    """
    found = basis.found_eigenvalues
    if len(found) < 2:
        return undecided(MISSING, where, MODES, "fewer than two modes were looked for")
    every = replace(basis, fixed_eigenvalues=found[:-1], omitted_eigenvalue=float(found[-1]))
    return count_fixed_modes(operators, every, where)


def _moved_factor_count(operators: BodyOperators, basis: Basis, eigenvalue: float) -> int:
    """As `modes_below`, from the factor at rest moved to another shift: its ordering is kept."""
    factor = basis.factor
    assert isinstance(factor, ConstrainedFactor)
    local = operators.mass.getLocalSize()[0]
    weight = bordered(operators.mass, np.zeros((local, factor.border)))
    factor.matrix.axpy(basis.shift - eigenvalue, weight, _SAME)
    weight.destroy()
    factor.solver.setOperators(factor.matrix)
    BODIES.add("factorisations")
    factor.solver.setUp()
    result = factor.solver.getPC().getFactorMatrix()
    state, negative = int(result.getMumpsInfog(1)), int(result.getMumpsInfog(12))
    result.destroy()  # this reference to it
    if state < 0:
        raise ReductionError(f"the factorisation failed: MUMPS INFOG(1) = {state}")
    return (negative - factor.border) // factor.parts


def highest_gap(basis: Basis) -> tuple[float, int]:
    """Return a shift [1/s²] in the highest gap of fixed-interface modes, and the modes below it.

    The list is that of the modes at rest and the eigenvalue that follows them; zero modes if there
    is no gap of relative size `_GAP`.
    """
    values = np.sort(np.append(basis.fixed_eigenvalues, basis.omitted_eigenvalue))
    gaps = np.flatnonzero(np.diff(values) > _GAP * values[1:])
    return _between(values, int(gaps[-1])) if gaps.size else (0.0, 0)


def _between(values: FloatArray, place: int) -> tuple[float, int]:
    return float(np.sqrt(values[place] * values[place + 1])), place + 1


def meshed_part_properties(body: Body) -> MassProperties:
    """Mass properties in closed form of what is meshed of a body: without its rigid disks."""
    bare = replace(body, interfaces=(), rigid_disks=())
    exact = mass_properties(bare)
    return MassProperties(exact.mass_kg, exact.center_of_gravity_m, exact.inertia_kg_m2)


def check_mass(body: Body, properties: MassProperties) -> Invariant:
    """Check mass, centre of gravity and inertia of a mesh of tetrahedra against closed form."""
    exact = meshed_part_properties(body)
    inertia = np.diag(exact.inertia_kg_m2)
    length = np.sqrt(inertia[0] / exact.mass_kg)
    errors = [
        properties.mass_kg / exact.mass_kg - 1.0,
        (properties.center_of_gravity_m[2] - exact.center_of_gravity_m[2]) / length,
        *(np.diag(properties.inertia_kg_m2) / inertia - 1.0),
    ]
    return _mass_check(body, errors, _MASS_LIMIT, "against the profile in closed form")


def check_mesh_mass(body: MeshedBody, properties: MassProperties) -> Invariant:
    """Check the mass of the finite elements against the integrals over the mesh."""
    exact = body.mass
    if exact is None:
        return undecided(_MASS, body.name, _MASS_CONCERNS, "not integrated")
    inertia = np.array(exact.inertia_kg_m2)
    size = np.trace(inertia)
    length = np.sqrt(size / exact.mass_kg)
    errors = [
        properties.mass_kg / exact.mass_kg - 1.0,
        np.abs(properties.inertia_kg_m2 - inertia).max() / size,
        np.abs(properties.center_of_gravity_m - np.array(exact.center_of_gravity_m)).max() / length,
    ]
    limit = _MESH_MASS_LIMIT
    if body.roundness is not None:
        # the mean over turns moves them by what the mesh is off a body of revolution
        limit += body.roundness.static_unbalance + body.roundness.uneven_mass
    return _mass_check(body, errors, limit, "against the integrals over the elements")


_MASS, _MASS_CONCERNS = "mass properties of the mesh", "mass, and all frequencies of the body"


def _mass_check(body: AnyBody, errors: list[float], limit: float, reason: str) -> Invariant:
    worst = float(np.abs(errors).max())
    return compared(_MASS, body.name, worst, limit, _MASS_CONCERNS, reason)


def check_evenness(name: str, change: float, accuracy: float) -> Invariant:
    """Check what averaging over turns changes of frequencies against what is asked of them."""
    return compared(
        "the mesh is the same in all directions",
        name,
        change,
        accuracy,
        "frequencies of the body",
        "mass and stiffness were averaged over turns about the axis; half of what two frequencies "
        'of a pair are apart, relative; symmetry = "none" keeps them apart',
    )
