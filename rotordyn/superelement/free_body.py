"""A free body stores no energy in rigid motion: how well a superelement keeps that, and cleaning.

Rounding in K is relative to its stiffest coordinate, so a rigid motion may be left with a small
stiffness of either sign, which shows as a slow or unstable mode of a body free to turn or slide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.record import Superelement

ELASTIC_LIMIT = 1e-9
CENTRIFUGAL_LIMIT = 1e-6


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
    """Return how far stress stiffening and spin softening miss to cancel in rigid motion.

    Returns largest entry of Rᵀ(Kgeo − S)R over the largest of RᵀKgeoR and RᵀSR, in coordinates
    where each rigid motion has unit kinetic energy; 0 if both are zero, inf if a rigid motion has
    no kinetic energy.
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
    return float(np.abs(geometric - softening).max()) / size if size > 0 else 0.0


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
            "stress stiffening and spin softening do not cancel in rigid motion, relative energy "
            f"{centrifugal:.2e}, allowed is {CENTRIFUGAL_LIMIT:g}; use both effects or none"
        )
    return tuple(problems)


def free_body_matrices(element: Superelement) -> FreeBodyMatrices:
    """Return the matrices of a body with the rounding in its rigid motions removed.

    `element`: the body, without `free_body_problems`. Returns K and Kgeo − S projected on the
    motions that are M-orthogonal to the rigid ones. Both vanish in rigid motion for the continuum;
    (Kgeo − S) R keeps a mesh error in solids.
    """
    modes = element.rigid_body_modes[:, element.rigid_body_present]
    momentum = element.mass @ modes
    projector = np.eye(element.size)
    if modes.size:
        projector -= modes @ la.solve(modes.T @ momentum, momentum.T, assume_a="pos")
    centrifugal = element.stress_stiffening - element.spin_softening
    return FreeBodyMatrices(
        mass=np.asarray(element.mass),
        stiffness=projector.T @ element.stiffness @ projector,
        gyroscopic=np.asarray(element.gyroscopic),
        centrifugal_stiffness=projector.T @ centrifugal @ projector,
    )
