"""What differs where a body comes from a mesh of its own and not from a profile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody, MeshedBody
from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.pairing import evenly_turned, turn_generator
from solidwhirl.reduction.body.verification import MISSING, MODES, count_held_modes
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided
from solidwhirl.rotordyn.superelement.rigid_body import MassProperties

# Mass and inertia of the finite elements against those of the mesh's own quadrature: the elements
# integrate curved ones to the fourth degree only.
_MASS_LIMIT = 1e-4
# Quarter turn of the rigid motions: ux to uy, rx to ry.
_TURN = np.zeros((6, 6))
_TURN[1, 0] = _TURN[4, 3] = 1.0
_TURN[0, 1] = _TURN[3, 4] = -1.0
_TURN.setflags(write=False)
# Entries of the matrices that averaging over quarter turns may change, over the diagonal.
_UNEVEN_LIMIT = 5e-2


def shape_of(body: AnyBody) -> str:
    """Return what the reduction may assume of a solid, see `OperatorEffects.shape`."""
    return body.request.shape if isinstance(body, MeshedBody) else "quartered"


def mesh_properties(rigid_mass: FloatArray, shape: str) -> MassProperties:
    """Mass properties from the rigid mass matrix of a mesh.

    `rigid_mass`: (6, 6) for ux, uy, uz, rx, ry, rz about the origin. `shape`: "round": the mean
    over quarter turns is taken, as of all matrices.
    """
    even = evenly_turned(rigid_mass, _TURN) if shape == "round" else rigid_mass
    mass = float(even[0, 0])
    centre = np.array([even[1, 5], -even[0, 5], even[0, 4]]) / mass
    about = mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    inertia = even[3:, 3:] - about
    return MassProperties(mass, centre, 0.5 * (inertia + inertia.T))


def check_mesh_mass(body: MeshedBody, properties: MassProperties) -> Invariant:
    """Check the mass of the finite elements against the integrals over the mesh."""
    exact = body.mass
    if exact is None:
        return undecided("mass properties of the mesh", body.name, _CONCERNS, "not integrated")
    inertia = np.array(exact.inertia_kg_m2)
    size = np.trace(inertia)
    length = np.sqrt(size / exact.mass_kg)
    errors = [
        np.abs(properties.mass_kg / exact.mass_kg - 1.0),
        np.abs(properties.inertia_kg_m2 - inertia).max() / size,
        np.abs(properties.center_of_gravity_m - np.array(exact.center_of_gravity_m)).max() / length,
    ]
    limit, reason = _MASS_LIMIT, "against the integrals over the elements"
    if body.roundness is not None:
        # the mean over turns moves them by what the mesh is off a body of revolution
        limit += body.roundness.static_unbalance + body.roundness.uneven_mass
    return compared(
        "mass properties of the mesh", body.name, float(np.max(errors)), limit, _CONCERNS, reason
    )


_CONCERNS = "mass, and all frequencies of the body"


def check_evenness(name: str, value: float) -> Invariant:
    """Check that averaging over turns changed little.

    `value`: largest change of M and K over their diagonals, see `pairing.evenness`.
    """
    return compared(
        "the mesh is the same in all directions",
        name,
        value,
        _UNEVEN_LIMIT,
        "frequencies of the body",
        "mass and stiffness were averaged over turns about the axis, which moves the mean "
        "frequency of a pair by the square of this",
    )


def known_turn(
    operators: BodyOperators, basis: Basis, mass: FloatArray
) -> tuple[FloatArray | None, FloatArray]:
    """Return generator and signs of a solid's coordinates, see `turn_generator`.

    `operators`, `basis`: of the solid; the basis of a round body has its generator. `mass`: (n, n)
    reduced mass matrix.
    """
    if operators.ingredients.effects.shape == "quartered":
        return turn_generator(operators, basis, mass)
    return basis.generator, np.ones(len(mass))


def count_found_modes(operators: BodyOperators, basis: Basis, where: str) -> Invariant:
    """Check on its own mesh that no fixed-interface mode is missing; the basis' factor is used up.

    `operators`, `basis`: of a solid on a mesh of any kind.
    """
    found = basis.found_eigenvalues
    if len(found) < 2:
        return undecided(MISSING, where, MODES, "fewer than two modes were looked for")
    every = replace(basis, fixed_eigenvalues=found[:-1], omitted_eigenvalue=float(found[-1]))
    return count_held_modes(operators, every, where)


def shown_points(body: AnyBody, mesh: Mesh | None) -> FloatArray | None:
    """Points of the surface that pictures of a body from a mesh are drawn from, else None."""
    if not isinstance(body, MeshedBody) or mesh is None:
        return None
    return np.array(mesh.points[mesh.outline])
