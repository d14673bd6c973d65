"""What must hold for a superelement, whoever made it; checks that need no reference data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.superelement.body_measures import (
    asymmetry,
    gyroscopic_moment_error,
    interface_error,
    lost_stiffness,
    mass_moment_error,
    modal_frequency_error,
    negative_part,
    picture_error,
    property_error,
    rigid_moment_error,
    smallest_inertia,
    tilt_error,
    turn_error,
)
from solidwhirl.rotordyn.superelement.free_body import rigid_centrifugal_energy, rigid_force
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.validation import SYMMETRIC_MATRICES, SYMMETRY_LIMIT

# Limits are 10 to 100 times the largest value measured, in brackets, over the bodies of all scenes
# and of the tests, on the levels beam, harmonic and solid, with disks and fillets, and over thin
# drums, needles, slivers and contrasts of 1e6 in stiffness; docs/checks.md has the table.
_NEGATIVE_LIMIT = 1e-11  # [1.1e-13]
_SMALLEST_INERTIA = 1e-14  # M with a unit diagonal is singular to rounding
_ELASTIC_LIMIT = 3e-11  # [3.3e-13]
_BALANCE_LIMIT = 3e-7  # [1.4e-8] with moduli of 2e5 beside 2e11 Pa; what assembly takes is 1e-6
_PROPERTY_LIMIT = 1e-8  # [1.1e-10]
_MERIDIAN_LIMIT = 1e-5  # [6.8e-7] with large fillets, each meshed as a few parabolas
_MOTION_LIMIT = 1e-8  # [2.5e-10]
_PICTURE_LIMIT = 1e-9  # [2.4e-11], a drum of 1/200
_TURN_LIMIT = 1e-11  # [8.3e-13] solid, [3.3e-16] else; the complex form asks for the same
_MASS_MOMENT_LIMIT = 1e-12  # [2.0e-14] beams with plates, [1.3e-15] else
_RIGID_MOMENT_LIMIT = 5e-11  # [7.4e-13]
_GYROSCOPIC_MOMENT_LIMIT = 1e-12  # [9.2e-15]
_GYROSCOPIC_MESH_LIMIT = 2e-2  # [1.5e-3] solid: a turn leaves the elements
_MODAL_LIMIT = 3e-7  # [2.2e-8], eps times the ratio of the largest and the lowest eigenvalue
# The body has lost its stiffness where rotation takes all of it.
_ALL_OF_IT = 1.0

_ALL = "all frequencies and responses of the body"


@dataclass(frozen=True, kw_only=True)
class Invariant:
    """Hold the result of one check.

    Attributes
    ----------
    name
        What must hold.
    where
        The body or the part of the results that was looked at.
    value
        The error found, relative or a count; for "mass positive definite" the smallest eigenvalue
        of M (scaled to a unit diagonal) with its sign turned, which must be negative. None if
        nothing was found out.
    limit
        The largest error allowed.
    passed
        Whether value ≤ limit; None if that could not be decided or does not apply.
    concerns
        Which numbers can't be trusted where it does not hold.
    reason
        Why it could not be decided; else how it was found, or empty.
    """

    name: str
    where: str = ""
    value: float | None
    limit: float | None
    passed: bool | None
    concerns: str = ""
    reason: str = ""


def compared(
    name: str, where: str, value: float, limit: float, concerns: str, reason: str = ""
) -> Invariant:
    """Return a check whose value was found; nan counts as failed."""
    return Invariant(
        name=name,
        where=where,
        value=float(value),
        limit=float(limit),
        passed=bool(value <= limit),
        concerns=concerns,
        reason=reason,
    )


def undecided(name: str, where: str, concerns: str, reason: str) -> Invariant:
    """Return a check that can not be made."""
    return Invariant(
        name=name,
        where=where,
        value=None,
        limit=None,
        passed=None,
        concerns=concerns,
        reason=reason,
    )


def check_superelement(element: Superelement) -> tuple[Invariant, ...]:
    """Check what must hold for any free or held body.

    Returns
    -------
    tuple of Invariant
        All relative, so that bodies of any size compare: symmetry and skewness; negative
        eigenvalues of M and K; eigenvalues of the modal block against the frequencies of its
        coordinates; K R = 0; Rᵀ(Kgeo − S)R = 0; rigid motion t + θ × x at the interfaces and at
        the points of pictures; RᵀMR against mass, centre of gravity and inertia; RᵀGR of the two
        tilts against the polar inertia, +Ip in row rx and column ry; all matrices the same after
        a turn about the axis; stiffness left at the top speed; moments of the displacement over
        the mass against M, against each other in rigid motion, and against G. R are the rigid
        motions present; checks of what a body does not have are left out.
    """
    where = element.name
    results = [
        symmetry_check(n, where, asymmetry(getattr(element, n), 1.0)) for n in SYMMETRIC_MATRICES
    ]
    results.append(symmetry_check("gyroscopic", where, asymmetry(element.gyroscopic, -1.0)))
    definite = compared(
        "mass positive definite", where, -smallest_inertia(element), -_SMALLEST_INERTIA, _ALL
    )
    results.append(definite)
    if not definite.passed:
        reason = "they need a mass that is positive definite"
        return (*results, undecided("all other checks", where, _ALL, reason))
    stiffness = negative_part(element, element.stiffness)
    results.append(
        compared(
            "stiffness positive semidefinite",
            where,
            stiffness,
            _NEGATIVE_LIMIT,
            "frequencies and stability of the body at rest",
        )
    )
    if element.rigid_body_present.any():
        results += _rigid_checks(element)
    # a body reduced without gyroscopic effects, for a scene at rest, has no G to check
    if element.rigid_body_present[[3, 4]].all() and element.gyroscopic.any():
        concerns = "splitting of forward and backward whirl"
        tilt = tilt_error(element)
        limit = _property_limit(element)
        results.append(compared("polar inertia of the tilts", where, tilt, limit, concerns))
    results += _moment_checks(element)
    return (*results, *_structure_checks(element), *_spectral_checks(element))


def symmetry_check(name: str, where: str, error: float) -> Invariant:
    """Return the check that a matrix is symmetric, or skew if it is the gyroscopic one.

    `error`: relative deviation.
    """
    kind, concerns = "symmetric", _ALL
    if name == "gyroscopic":
        kind, concerns = "skew", "frequencies of the body at speed"
    elif name in ("stress_stiffening", "spin_softening"):
        concerns = "frequencies of the body at speed"
    return compared(f"{name} {kind}", where, error, SYMMETRY_LIMIT, concerns)


def _rigid_checks(element: Superelement) -> list[Invariant]:
    where = element.name
    return [
        compared(
            "no elastic force in rigid motion",
            where,
            rigid_force(element),
            _ELASTIC_LIMIT,
            "low frequencies of a softly held body",
        ),
        compared(
            "stress stiffening and spin softening cancel in rigid motion",
            where,
            rigid_centrifugal_energy(element),
            _BALANCE_LIMIT,
            "low frequencies of the body at speed",
        ),
        compared(
            "rigid motion at the interfaces",
            where,
            interface_error(element),
            _MOTION_LIMIT,
            "where bearings and disks act on the body",
        ),
        _mass_properties(element),
    ]


def _mass_properties(element: Superelement) -> Invariant:
    worst = property_error(element)
    concerns = {"uz": "axial frequencies", "rz": "torsional frequencies"}.get(worst.motion, _ALL)
    reason, limit = "", _property_limit(element)
    if worst.error > limit:
        reason = f"inertia of {worst.motion}: {worst.found:.6g} instead of {worst.expected:.6g}"
    return compared("mass properties", element.name, worst.error, limit, concerns, reason)


def _property_limit(element: Superelement) -> float:
    """Harmonic bodies carry the closed form of a profile that their mesh may not hold exactly."""
    return _MERIDIAN_LIMIT if element.level == "harmonic" else _PROPERTY_LIMIT


def _moment_checks(element: Superelement) -> list[Invariant]:
    """Checks of the moments of the displacement over the mass."""
    where, results = element.name, []
    concerns = "exports to programs whose frames move with the body"
    found = (
        ("moments against the mass", mass_moment_error(element), _MASS_MOMENT_LIMIT),
        ("moments of rigid motion", rigid_moment_error(element), _RIGID_MOMENT_LIMIT),
    )
    for name, error, limit in found:
        if error is not None:
            results.append(compared(name, where, error, limit, concerns))
    error = gyroscopic_moment_error(element)
    # lumped bodies need not be bodies of revolution; some have no gyroscopic effects
    if error is not None and element.level != "lumped" and element.gyroscopic.any():
        solid = element.level == "solid"
        limit = _GYROSCOPIC_MESH_LIMIT if solid else _GYROSCOPIC_MOMENT_LIMIT
        results.append(compared("moments against G", where, error, limit, concerns))
    return results


def _structure_checks(element: Superelement) -> list[Invariant]:
    """Checks of pictures and of the turn about the axis."""
    where, results = element.name, []
    shown = picture_error(element)
    if shown is not None:
        concerns = "pictures of mode shapes"
        results.append(compared("rigid motion in pictures", where, shown, _PICTURE_LIMIT, concerns))
    turned = turn_error(element)
    if turned is not None:
        concerns = "sense of the whirl, and internal damping"
        results.append(
            compared("the same after a turn about the axis", where, turned, _TURN_LIMIT, concerns)
        )
    return results


def _spectral_checks(element: Superelement) -> list[Invariant]:
    """Checks that need M to be positive definite."""
    where, results = element.name, []
    modal = modal_frequency_error(element)
    if modal is not None:
        concerns = "frequencies that modes of the body take part in"
        results.append(compared("modal frequencies", where, modal, _MODAL_LIMIT, concerns))
    speed = element.maximum_speed_rad_s
    if np.isfinite(speed) and speed > 0:
        lost = lost_stiffness(element)
        results.append(
            compared(
                "stiffness left at the top speed",
                where,
                lost,
                _ALL_OF_IT,
                "frequencies and stability near the top speed",
                _lost_at(speed, lost),
            )
        )
    return results


def _lost_at(speed_rad_s: float, lost: float) -> str:
    """Say where rotation takes all stiffness of some motion."""
    if lost <= _ALL_OF_IT:
        return f"rotation takes {max(lost, 0.0):.1e} of the stiffness at most"
    speed = speed_rad_s / np.sqrt(lost)
    return f"all stiffness is lost at {speed:.6g} rad/s ({speed * RPM_PER_RAD_S:.6g} rpm)"
