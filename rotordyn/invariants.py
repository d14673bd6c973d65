"""Checks of a superelement that need no reference data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.free_body import ELASTIC_LIMIT, rigid_centrifugal_energy, rigid_force
from solidwhirl.rotordyn.rigid_body import rigid_body_mass_matrix
from solidwhirl.rotordyn.superelement import Superelement
from solidwhirl.rotordyn.superelement_checks import (
    MOTIONS,
    SYMMETRIC_MATRICES,
    SYMMETRY_LIMIT,
)

_NEGATIVE_LIMIT = 1e-10
_SMALLEST_INERTIA = 1e-14
_BALANCE_LIMIT = 1e-8
_PROPERTY_LIMIT = 1e-6
_MOTION_LIMIT = 1e-8


@dataclass(frozen=True, kw_only=True)
class Invariant:
    """Hold the result of one check.

    Attributes
    ----------
    name
        What must hold.
    value
        The relative error found; for "mass positive definite" the smallest eigenvalue of M
        (scaled to a unit diagonal) with its sign turned, which must be negative.
    limit
        The largest error allowed.
    passed
        Whether value ≤ limit.
    """

    name: str
    value: float
    limit: float
    passed: bool


def check_superelement(element: Superelement) -> tuple[Invariant, ...]:
    """Check what must hold for any free or held body of revolution.

    Parameters
    ----------
    element
        The body.

    Returns
    -------
    tuple of Invariant
        All relative, so that bodies of any size compare: symmetry and skewness; negative
        eigenvalues of M and K; K R = 0; Rᵀ(Kgeo − S)R = 0; rigid motion at the interfaces is
        t + θ × x; RᵀMR against mass, centre of gravity and inertia; RᵀGR of the two tilts
        against the polar inertia, +Ip in row rx and column ry. R are the rigid motions present;
        checks of motions that are absent are left out.
    """
    results = [_result(f"{n} symmetric", _asymmetry(element, n, 1.0)) for n in SYMMETRIC_MATRICES]
    results.append(_result("gyroscopic skew", _asymmetry(element, "gyroscopic", -1.0)))
    results.append(
        _result("mass positive definite", -_smallest_inertia(element), -_SMALLEST_INERTIA)
    )
    stiffness = _negative_part(element, element.stiffness)
    results.append(_result("stiffness positive semidefinite", stiffness, _NEGATIVE_LIMIT))
    if element.rigid_body_present.any():
        results += [
            _result("no elastic force in rigid motion", rigid_force(element), ELASTIC_LIMIT),
            _result(
                "stress stiffening and spin softening cancel in rigid motion",
                rigid_centrifugal_energy(element),
                _BALANCE_LIMIT,
            ),
            _result("rigid motion at the interfaces", _interface_error(element), _MOTION_LIMIT),
            _result("mass properties", _property_error(element), _PROPERTY_LIMIT),
        ]
    # a body reduced without gyroscopic effects, for a scene at rest, has no G to check
    if element.rigid_body_present[[3, 4]].all() and element.gyroscopic.any():
        results.append(_result("polar inertia of the tilts", _tilt_error(element), _PROPERTY_LIMIT))
    return tuple(results)


def _result(name: str, value: float, limit: float = SYMMETRY_LIMIT) -> Invariant:
    return Invariant(name=name, value=value, limit=limit, passed=bool(value <= limit))


def _asymmetry(element: Superelement, name: str, sign: float) -> float:
    matrix: FloatArray = getattr(element, name)
    largest = float(np.abs(matrix).max())
    return float(np.abs(matrix - sign * matrix.T).max()) / largest if largest > 0 else 0.0


def _smallest_inertia(element: Superelement) -> float:
    """Return the smallest eigenvalue of M scaled to a unit diagonal."""
    mass = element.mass
    if element.constraint is not None:
        # the coordinates of a tied body are no independent ones; its free motions are
        mass = element.constraint.T @ mass @ element.constraint
    diagonal = np.diag(mass)
    if not (diagonal > 0).all():
        return float(diagonal.min())
    root = np.sqrt(diagonal)
    return float(la.eigvalsh(mass / np.outer(root, root))[0])


def _negative_part(element: Superelement, matrix: FloatArray) -> float:
    """Return the most negative eigenvalue over the largest, scaled by the diagonal of M."""
    diagonal = np.diag(element.mass)
    if not (diagonal > 0).all():
        return float("inf")
    root = np.sqrt(diagonal)
    values = la.eigvalsh(matrix / np.outer(root, root))
    largest = float(np.abs(values).max())
    return max(0.0, -float(values[0])) / largest if largest > 0 else 0.0


def _interface_error(element: Superelement) -> float:
    """Return the largest deviation from t + θ × x, tilts compared over the body's size."""
    size = max((float(np.abs(n.position_m).max()) for n in element.interfaces), default=0.0) or 1.0
    error = 0.0
    for row, coordinate in enumerate(element.coordinates):
        if coordinate.kind != "interface":
            continue
        x, y, z = element.interface_node(coordinate.interface).position_m
        expected = np.eye(6)
        expected[:3, 3:] = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        difference = element.rigid_body_modes[row] - expected[MOTIONS.index(coordinate.component)]
        scale = np.array([1.0, 1.0, 1.0, size, size, size])
        present = element.rigid_body_present
        unit = 1.0 if coordinate.component in MOTIONS[:3] else 1.0 / size
        error = max(error, float(np.abs(difference / scale / unit)[present].max()))
    return error


def _property_error(element: Superelement) -> float:
    """Return the largest difference of RᵀMR from the rigid body's, scaled by its diagonal."""
    present = np.flatnonzero(element.rigid_body_present)
    modes = element.rigid_body_modes[:, present]
    expected = rigid_body_mass_matrix(
        element.mass_kg, element.center_of_gravity_m, element.inertia_kg_m2
    )[np.ix_(present, present)]
    root = np.sqrt(np.diag(expected))
    difference = modes.T @ element.mass @ modes - expected
    return float(np.abs(difference / np.outer(root, root)).max())


def _tilt_error(element: Superelement) -> float:
    """Return the relative difference of RᵀGR from [[0, Ip], [−Ip, 0]] on rx and ry."""
    tilts = element.rigid_body_modes[:, [3, 4]]
    polar = float(element.inertia_kg_m2[2, 2])
    expected = polar * np.array([[0.0, 1.0], [-1.0, 0.0]])
    return float(np.abs(tilts.T @ element.gyroscopic @ tilts - expected).max()) / polar
