"""What must hold for imported matrices before they become a body."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.body_measures import least_inertia
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.imported_motions import ImportedMotions
from solidwhirl.rotordyn.rigid_body import rigid_body_mass_matrix
from solidwhirl.rotordyn.superelement_checks import MOTIONS

SYMMETRY_REFUSED = 1e-6
_SYMMETRY_NOTED = 1e-12
_SMALLEST_INERTIA = 1e-14
# Negative eigenvalues of K over its largest that rounding of a file leaves.
_NEGATIVE = 1e-9
_PROPERTIES = 1e-6
_STATED = 1e-5


def even_or_odd(
    where: str,
    role: str,
    matrix: FloatArray,
    sign: float,
    inertia: FloatArray,
    notes: list[str],
) -> FloatArray:
    """Return the symmetric (sign 1) or skew (sign −1) part of a matrix.

    Parameters
    ----------
    where, role
        For messages.
    matrix
        Shape (n, n).
    sign
        1 or −1.
    inertia
        Diagonal of M: entries compare in coordinates of unit inertia, whatever their units.
    notes
        Gets a sentence where more than rounding was evened out.

    Raises
    ------
    SuperelementError
        If it deviates by more than 1e-6 of its largest entry.
    """
    root = np.sqrt(np.abs(inertia))
    scaled = matrix / np.outer(root, root)
    largest = float(np.abs(scaled).max(initial=0.0))
    if largest == 0.0:
        return matrix
    error = float(np.abs(scaled - sign * scaled.T).max()) / largest
    kind = "symmetric" if sign > 0 else "skew"
    if error > SYMMETRY_REFUSED:
        raise SuperelementError(
            f"{where}: {role} is not {kind}: it deviates by {error:.2e} of its largest entry, "
            f"allowed is {SYMMETRY_REFUSED:g}"
        )
    if error > _SYMMETRY_NOTED:
        notes.append(f"The {role} matrix was made {kind}; it deviated by {error:.1e}.")
    return np.asarray(0.5 * (matrix + sign * matrix.T))


def check_mass(
    where: str, labels: tuple[str, ...], mass: FloatArray, tie: FloatArray | None
) -> None:
    """Refuse a mass that is not positive definite.

    Parameters
    ----------
    where, labels
        For messages; names of the coordinates.
    mass
        Shape (n, n).
    tie
        Constraint of the coordinates, or None.

    Raises
    ------
    SuperelementError
        The message names a coordinate without mass.
    """
    diagonal = np.diag(mass)
    if not (diagonal > 0.0).all():
        worst = int(diagonal.argmin())
        raise SuperelementError(
            f"{where}: mass is not positive definite: {labels[worst]} has the mass "
            f"{diagonal[worst]:g}; condense coordinates without mass where the matrices come from"
        )
    free = mass if tie is None else tie.T @ mass @ tie
    smallest = least_inertia(0.5 * (free + free.T))
    if not smallest > _SMALLEST_INERTIA:
        raise SuperelementError(
            f"{where}: mass is not positive definite: its smallest eigenvalue is {smallest:.2e} "
            "with a unit diagonal; some motion of the coordinates has no mass"
        )


def check_stiffness(
    where: str, mass: FloatArray, stiffness: FloatArray, tie: FloatArray | None
) -> FloatArray:
    """Return the squares of the frequencies of the body at rest, rising, (rad/s)².

    Parameters
    ----------
    where
        For messages.
    mass, stiffness
        Shape (n, n).
    tie
        Constraint of the coordinates, or None.

    Raises
    ------
    SuperelementError
        If K has a negative eigenvalue.
    """
    if tie is not None:
        mass, stiffness = tie.T @ mass @ tie, tie.T @ stiffness @ tie
    rates = la.eigvalsh(stiffness, mass)
    if rates[0] < -_NEGATIVE * max(float(rates[-1]), 0.0) - np.finfo(float).tiny:
        raise SuperelementError(
            f"{where}: stiffness has a negative eigenvalue, {rates[0]:.3g} (rad/s)² beside "
            f"{rates[-1]:.3g}; a body's own stiffness is not negative (are there enough digits in "
            "the file, and no preload?)"
        )
    return np.asarray(rates)


def rigid_mass(
    where: str,
    matrices: Mapping[str, FloatArray],
    motions: ImportedMotions,
    positions: Mapping[str, FloatArray],
    stated: Mapping[str, FloatArray],
    notes: list[str],
) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre of gravity and inertia about it, from RᵀMR.

    Parameters
    ----------
    where
        For messages.
    matrices
        By role, SI units.
    motions
        R.
    positions
        Of the interfaces.
    stated
        What the file says itself, for what the coordinates do not show; empty if it does not.
    notes
        Gets a sentence for what is not known.

    Raises
    ------
    SuperelementError
        If RᵀMR of the free motions is not that of a rigid body to 1e-6, or not what the file states
        to 1e-5 (a mesh may not hold a closed form exactly).
    """
    found = motions.modes.T @ matrices["mass"] @ motions.modes
    known = None
    if stated:
        inertia = 0.5 * (stated["inertia"] + stated["inertia"].T)
        known = (float(stated["mass"]), stated["center_of_gravity"], inertia)
    properties = _derived(where, found, matrices, motions, positions, known, notes)
    if motions.present.any():
        _check_rigid(where, found, motions, properties, _PROPERTIES)
        if known is not None:
            _check_rigid(where, found, motions, known, _STATED)
    return properties


def _derived(
    where: str,
    found: FloatArray,
    matrices: Mapping[str, FloatArray],
    motions: ImportedMotions,
    positions: Mapping[str, FloatArray],
    stated: tuple[float, FloatArray, FloatArray] | None,
    notes: list[str],
) -> tuple[float, FloatArray, FloatArray]:
    """Mass properties from RᵀMR, and from what is stated where it does not show them."""
    shown = motions.shown
    if not shown[:3].any():
        if stated is not None:
            return stated
        raise SuperelementError(
            f"{where}: no translation can be told from the nodes, so that the mass is not known; "
            "the file needs translations at its nodes, or its mass properties"
        )
    mass = float(np.diag(found)[:3][shown[:3]].mean())
    center = np.array([0.0, 0.0, np.mean([place[2] for place in positions.values()])])
    if stated is not None:
        center = np.array(stated[1])
    # moment m (e_b × c)_a in row a, column b
    for axis, pairs in enumerate((((1, 5, 1.0), (2, 4, -1.0)), ((2, 3, 1.0), (0, 5, -1.0)),
                                  ((0, 4, 1.0), (1, 3, -1.0)))):  # fmt: skip
        known = [s * found[a, b] / mass for a, b, s in pairs if shown[a] and shown[b]]
        if known:
            center[axis] = float(np.mean(known))
    about = found[3:, 3:] - mass * (center @ center * np.eye(3) - np.outer(center, center))
    turning = shown[3:]
    inertia = np.where(np.outer(turning, turning), about, 0.0)
    largest = float(np.diag(inertia).max())
    for axis in np.flatnonzero(~turning):
        inertia[axis, axis] = largest if stated is None else stated[2][axis, axis]
    if stated is not None:
        return mass, center, inertia
    if not turning[2] and turning[:2].all() and "gyroscopic" in matrices:
        tilts = motions.modes[:, [3, 4]]
        polar = float((tilts.T @ matrices["gyroscopic"] @ tilts)[0, 1])
        inertia[2, 2] = polar if 0.0 < polar <= inertia[0, 0] + inertia[1, 1] else largest
    if not shown.all():
        missing = ", ".join(m for m, s in zip(MOTIONS, shown, strict=True) if not s)
        notes.append(
            f"The coordinates do not show the rigid motions {missing}; mass properties that need "
            "them are assumed."
        )
    if not motions.present.any():
        notes.append("Mass properties are those that move with the interfaces of the held body.")
        inertia = _possible(inertia)
    return mass, center, inertia


def _possible(inertia: FloatArray) -> FloatArray:
    """An inertia that a body can have, none where the found one is not."""
    values = np.linalg.eigvalsh(inertia)
    fits = values[0] >= 0.0 and values[2] <= values[:2].sum() * (1.0 + _PROPERTIES)
    return inertia if fits else np.zeros((3, 3))


def _check_rigid(
    where: str,
    found: FloatArray,
    motions: ImportedMotions,
    properties: tuple[float, FloatArray, FloatArray],
    limit: float,
) -> None:
    """Refuse RᵀMR of free motions that is not that of one rigid body."""
    free = np.flatnonzero(motions.present)
    expected = rigid_body_mass_matrix(*properties)
    root = np.sqrt(np.diag(found).clip(1e-300))
    error = np.abs(found - expected) / np.outer(root, root)
    error = error[np.ix_(free, free)]
    if error.max() <= limit:
        return
    row, column = (free[k] for k in np.unravel_index(int(error.argmax()), error.shape))
    what = "of" if row == column else "that couples"
    named = MOTIONS[row] if row == column else f"{MOTIONS[row]} and {MOTIONS[column]}"
    raise SuperelementError(
        f"{where}: the inertia {what} {named} in rigid motion is {found[row, column]:.6g} instead "
        f"of {expected[row, column]:.6g}, that of one rigid body of {properties[0]:.6g} kg; are "
        "places and components of the nodes those of the matrices, and in the same unit?"
    )
