"""Mass properties of rigid bodies: the six-motion mass matrix and the sum of two bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray


class MassProperties(NamedTuple):
    """Mass (kg), centre of gravity (3,) (m) and inertia about it (3, 3) (kg m²)."""

    mass_kg: float
    center_of_gravity_m: FloatArray
    inertia_kg_m2: FloatArray


def rigid_body_mass_matrix(
    mass_kg: float, center_of_gravity_m: FloatArray, inertia_kg_m2: FloatArray
) -> FloatArray:
    """Return the mass matrix of a rigid body for its six motions about the origin.

    Parameters
    ----------
    mass_kg
        Mass, kg.
    center_of_gravity_m
        Centre of gravity, shape (3,), m.
    inertia_kg_m2
        Inertia tensor about the centre of gravity, shape (3, 3), kg m².

    Returns
    -------
    ndarray
        Shape (6, 6), order ux, uy, uz, rx, ry, rz. A point moves by t + θ × x.
    """
    x, y, z = (float(value) for value in center_of_gravity_m)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = mass_kg * np.eye(3)
    matrix[:3, 3:] = -mass_kg * cross
    matrix[3:, :3] = mass_kg * cross
    matrix[3:, 3:] = inertia_kg_m2 - mass_kg * cross @ cross
    return matrix


def joined_mass_properties(parts: Sequence[MassProperties]) -> MassProperties:
    """Return the mass properties of several rigid parts taken as one body.

    Parameters
    ----------
    parts
        At least one part with mass.

    Returns
    -------
    MassProperties
        Inertia about the common centre of gravity (parallel axis theorem).
    """
    total = sum(part.mass_kg for part in parts)
    moment = sum((p.mass_kg * p.center_of_gravity_m for p in parts), np.zeros(3))
    center = moment / total
    tensor = np.zeros((3, 3))
    for part in parts:
        arm = part.center_of_gravity_m - center
        tensor += part.inertia_kg_m2
        tensor += part.mass_kg * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return MassProperties(total, center, tensor)
