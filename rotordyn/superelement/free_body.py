"""A free body stores no energy in rigid motion: how well a superelement keeps that, and cleaning.

Rounding in K is relative to its stiffest coordinate, so a rigid motion may be left with a small
stiffness of either sign, which shows as a slow or unstable mode of a body free to turn or slide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray, cross_matrix
from solidwhirl.rotordyn.superelement.mass_moments import projected_moments, rigid_motion_moments
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.rigid_body import (
    RIGID_TURN,
    interface_motion,
    rigid_body_mass_matrix,
)

ELASTIC_LIMIT = 1e-9
CENTRIFUGAL_LIMIT = 1e-6
# Rigid motion that turns a body about its axis.
_ABOUT_AXIS = 5


class FreeBodyMatrices(NamedTuple):
    """M, K, G and K2 = Kgeo − S of one body at unit spin, each (n, n)."""

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray
    centrifugal_stiffness: FloatArray


def rigid_force(element: Superelement) -> float:
    """Return the relative elastic force of a body in its rigid motions.

    Returns largest |K r| / (|K| |r|) over the rigid motions r, in coordinates scaled by the
    diagonal of M so that metres and radians compare; 0 if K is zero, inf if M has a diagonal entry
    that is not positive.
    """
    if not (np.diag(element.mass) > 0).all():
        return float("inf")
    root = np.sqrt(np.diag(element.mass))
    modes = root[:, None] * element.rigid_body_modes[:, element.rigid_body_present]
    scaled = element.stiffness / np.outer(root, root)
    size = float(la.norm(scaled, 2))
    if size == 0 or modes.size == 0:
        return 0.0
    return float(np.max(la.norm(scaled @ modes, axis=0) / la.norm(modes, axis=0)) / size)


def rigid_centrifugal_energy(element: Superelement) -> float:
    """Return how far stress stiffening and spin softening miss what rigid motion makes of them.

    Returns largest entry of Rᵀ(Kgeo − S)R less that of a rigid body (0 in the inertial frame, see
    `rigid_centrifugal`) over the largest of RᵀKgeoR and RᵀSR, in coordinates where each rigid
    motion has unit kinetic energy; 0 if both are zero, inf if a rigid motion has no kinetic energy.
    """
    modes = element.rigid_body_modes[:, element.rigid_body_present]
    if modes.size == 0:
        return 0.0
    kinetic = np.einsum("ij,ik,kj->j", modes, element.mass, modes)
    if not (kinetic > 0).all():
        return float("inf")
    modes = modes / np.sqrt(kinetic)
    geometric = modes.T @ element.stress_stiffening @ modes
    softening = modes.T @ element.spin_softening @ modes
    size = max(float(np.abs(geometric).max()), float(np.abs(softening).max()))
    known = modes.T @ rigid_centrifugal(element) / np.sqrt(kinetic)
    missed = geometric - softening - known
    return float(np.abs(missed).max()) / size if size > 0 else 0.0


def rigid_centrifugal(element: Superelement) -> FloatArray:
    """Return (Kgeo − S) R of the rigid motions present as a continuum has it, shape (n, r).

    A motion that stands still in space needs no force. In the inertial frame that is q = R c, in
    the rotating one q = R e^{−ΩtT} c with the turn T of rigid motions, so that there
    (Kgeo − S) R = G R T − M R T² for a body that is balanced. The stress of any other is in
    equilibrium with the centrifugal load less the inertia of the rigid motion that this would
    cause; a tilt turns both.
    """
    present = element.rigid_body_present
    modes = element.rigid_body_modes
    if element.frame == "inertial" or not element.spin_softening.any():
        return np.zeros_like(modes[:, present])
    turned = modes @ RIGID_TURN
    found = element.gyroscopic @ turned - element.mass @ turned @ RIGID_TURN
    found[:, 3:] -= _turned_relief(element)
    return np.asarray(found[:, present])


def _turned_relief(element: Superelement) -> FloatArray:
    """∫ φ · θ × ρ (a + α × x) of tilts θ, (n, 3): a rigid motion takes up the centrifugal load."""
    mass, simple, first = _without_disks(element)
    about = mass[3:, 3:]
    second = 0.5 * np.trace(about) * np.eye(3) - about  # ∫ρ x xᵀ
    pull = np.array([mass[1, 5], mass[2, 3], 0.0, -second[1, 2], second[0, 2], 0.0])
    caused = np.linalg.solve(mass, pull)
    columns = []
    for tilt in np.eye(3):
        gradient = cross_matrix(tilt) @ cross_matrix(caused[3:])
        columns.append(
            np.cross(tilt, caused[:3]) @ simple + np.einsum("ba,abn->n", gradient, first)
        )
    return np.column_stack(columns)


def _without_disks(element: Superelement) -> tuple[FloatArray, FloatArray, FloatArray]:
    """RᵀMR about the origin, ∫ φ dm and ∫ x φ dm of what has stress: rigid disks have none."""
    moments = element.moments
    assert moments is not None  # elements in the rotating frame have them
    own = (element.mass_kg, element.center_of_gravity_m, element.inertia_kg_m2)
    mass = rigid_body_mass_matrix(*own)
    simple, first = moments.displacement_kg.copy(), moments.first_kg_m.copy()
    for disk in element.provenance.get("rigid_disks", ()):
        node = element.interface_node(disk["interface"])
        center = node.position_m + np.array([0.0, 0.0, disk["offset_m"]])
        across, about = disk["diametral_kg_m2"], disk["polar_kg_m2"]
        ring = (disk["mass_kg"], center, np.diag([across, across, about]))
        placed = interface_motion(element, node.name)
        lost = projected_moments(rigid_motion_moments(*ring, node.position_m), placed)
        assert lost is not None
        mass = mass - rigid_body_mass_matrix(*ring)
        simple, first = simple - lost.displacement_kg, first - lost.first_kg_m
    return mass, simple, first


def free_body_problems(element: Superelement) -> tuple[str, ...]:
    """Return what contradicts the rigid motions of a body: K R to 1e-9, Rᵀ(Kgeo − S)R to 1e-6."""
    if not (np.diag(element.mass) > 0).all():
        return ("the mass matrix has a diagonal entry that is not positive",)
    elastic, centrifugal = rigid_force(element), rigid_centrifugal_energy(element)
    problems = []
    if elastic > ELASTIC_LIMIT:
        problems.append(
            f"the stiffness resists rigid motion, relative force {elastic:.2e}, allowed is "
            f"{ELASTIC_LIMIT:g}; a body held to the ground must clear rigid_body_present"
        )
    if centrifugal > CENTRIFUGAL_LIMIT:
        problems.append(
            "stress stiffening and spin softening are not those of a rigid motion, relative energy "
            f"{centrifugal:.2e}, allowed is {CENTRIFUGAL_LIMIT:g}; use both effects or none; "
            "of both, rounding leaves this where a lumped mass or inertia is far above the body's"
        )
    return tuple(problems)


def free_body_matrices(element: Superelement) -> FreeBodyMatrices:
    """Return the matrices of a body with the rounding in its rigid motions removed.

    `element`: the body, without `free_body_problems`. Returns K and Kgeo − S projected on the
    motions that are M-orthogonal to the rigid ones, where K R = 0 and (Kgeo − S) R is
    `rigid_centrifugal`, which keeps a mesh error in solids. In a turn about the axis it is 0:
    centrifugal load and reactions turn with the body.
    """
    modes = element.rigid_body_modes[:, element.rigid_body_present]
    momentum = element.mass @ modes
    projector = np.eye(element.size)
    centrifugal = element.stress_stiffening - element.spin_softening
    if modes.size:
        onto = la.solve(modes.T @ momentum, momentum.T, assume_a="pos")
        projector -= modes @ onto
        centrifugal = projector.T @ centrifugal @ projector
        known = rigid_centrifugal(element)
        turn = np.flatnonzero(element.rigid_body_present) == _ABOUT_AXIS
        known -= onto[turn].T @ (modes[:, turn].T @ known)
        known[:, turn] = 0.0
        both = known @ onto
        centrifugal += both + both.T - onto.T @ (modes.T @ known) @ onto
    return FreeBodyMatrices(
        mass=np.asarray(element.mass),
        stiffness=projector.T @ element.stiffness @ projector,
        gyroscopic=np.asarray(element.gyroscopic),
        centrifugal_stiffness=centrifugal,
    )
