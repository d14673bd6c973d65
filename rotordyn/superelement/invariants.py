"""What must hold for a superelement, whoever made it; checks that need no reference data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.superelement import body_measures as measures
from solidwhirl.rotordyn.superelement.free_body import rigid_centrifugal_energy, rigid_force
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.validation import SYMMETRIC_MATRICES, SYMMETRY_LIMIT

_SMALLEST_INERTIA = 1e-14  # M with a unit diagonal is singular to rounding
_ALL = "all frequencies and responses of the body"


@dataclass(frozen=True, kw_only=True)
class Invariant:
    """Hold the result of one check.

    `name`: what must hold.
    `where`: the body or the part of the results that was looked at.
    `value`: the error found, relative or a count; for "mass positive definite" the smallest
    eigenvalue of M (scaled to a unit diagonal) with its sign turned, which must be negative. None
    if nothing was found out.
    `limit`: the largest error allowed.
    `passed`: whether value ≤ limit; None if that could not be decided or does not apply.
    `concerns`: which numbers can't be trusted where it does not hold.
    `reason`: why it could not be decided; else how it was found, or empty.
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
    checked = compared(name, where, np.nan, np.nan, concerns, reason)
    return replace(checked, value=None, limit=None, passed=None)


def check_superelement(element: Superelement) -> tuple[Invariant, ...]:
    """Check what must hold for any free or held body.

    Returns
    -------
    tuple of Invariant
        All relative, so that bodies of any size compare: symmetry and skewness; negative
        eigenvalues of M and K; eigenvalues of the modal block against the frequencies of its
        coordinates; K R = 0; Rᵀ(Kgeo − S)R of rigid motions; rigid motion t + θ × x at interfaces
        and the points of pictures; RᵀMR against mass, centre of gravity and inertia; RᵀGR of
        tilts against the polar inertia, +Ip in row rx and column ry; all matrices the same after
        a turn about the axis; stiffness left at the top speed; moments of the displacement over
        the mass against M, against each other in rigid motion, and against G. R are the rigid
        motions present; checks of what a body does not have are left out.
    """
    where = element.name
    results = [
        symmetry_check(n, where, measures.asymmetry(getattr(element, n), 1.0))
        for n in SYMMETRIC_MATRICES
    ]
    skewness = measures.asymmetry(element.gyroscopic, -1.0)
    results.append(symmetry_check("gyroscopic", where, skewness))
    smallest = measures.smallest_inertia(element)
    definite = compared("mass positive definite", where, -smallest, -_SMALLEST_INERTIA, _ALL)
    results.append(definite)
    if not definite.passed:
        reason = "they need a mass that is positive definite"
        return (*results, undecided("all other checks", where, _ALL, reason))
    return (*results, *_checks(element))


def symmetry_check(name: str, where: str, error: float) -> Invariant:
    """Return the check that a matrix is symmetric, or skew if it is the gyroscopic one."""
    kind, concerns = "symmetric", _ALL
    if name == "gyroscopic":
        kind, concerns = "skew", "frequencies of the body at speed"
    elif name in ("stress_stiffening", "spin_softening"):
        concerns = "frequencies of the body at speed"
    return compared(f"{name} {kind}", where, error, SYMMETRY_LIMIT, concerns)


# The radius of gyration of a body over its shortest piece, such as a thin plate on a long shaft.
_SHORTEST = 256.0
_EXPORTS = "exports to programs whose frames move with the body"
# Limits are 10 to 100 times the largest value measured, in brackets, over the bodies of all scenes
# and of the tests, on the levels beam, harmonic and solid, with disks and fillets, and over thin
# drums, needles, slivers and contrasts of 1e6 in stiffness; docs/checks.md has the table. Beside
# them: which numbers can't be trusted.
_LIMITS = {
    # [1.1e-13]
    "stiffness positive semidefinite": (1e-11, "frequencies and stability of the body at rest"),
    # [3.3e-13]
    "no elastic force in rigid motion": (3e-11, "low frequencies of a softly held body"),
    # [1.4e-8] with moduli of 2e5 beside 2e11 Pa; what assembly takes is 1e-6
    "stress stiffening and spin softening cancel in rigid motion": (
        3e-7,
        "low frequencies of the body at speed",
    ),
    # [2.5e-10]
    "rigid motion at the interfaces": (1e-8, "where bearings and disks act on the body"),
    # [1.1e-10]
    "mass properties": (1e-8, _ALL),
    "polar inertia of the tilts": (1e-8, "splitting of forward and backward whirl"),
    "moments against the mass": (1e-12, _EXPORTS),  # [2.0e-14] beams with plates, [1.3e-15] else
    "moments of rigid motion": (5e-11, _EXPORTS),  # [7.4e-13]
    "moments against G": (1e-12, _EXPORTS),  # [9.2e-15]
    # [1.2e-9], blades 600 times as long as thick; [2.4e-11], a drum of 1/200
    "rigid motion in pictures": (2e-8, "pictures of mode shapes"),
    # [8.3e-13] solid, [3.3e-16] else; the complex form asks for the same
    "the same after a turn about the axis": (1e-11, "sense of the whirl, and internal damping"),
    # [2.2e-8], eps times the ratio of the largest and the lowest eigenvalue
    "modal frequencies": (3e-7, "frequencies that modes of the body take part in"),
    # the body has lost its stiffness where rotation takes all of it
    "stiffness left at the top speed": (1.0, "frequencies and stability near the top speed"),
}
_OF_LEVEL = {
    # [6.8e-7] with large fillets, each meshed as a few parabolas: harmonic bodies carry the closed
    # form of a profile that their mesh may not hold exactly
    ("harmonic", "mass properties"): 1e-5,
    ("harmonic", "polar inertia of the tilts"): 1e-5,
    # [1.5e-3]: a turn leaves the elements
    ("solid", "moments against G"): 2e-2,
}


def _rounding_of_places(element: Superelement) -> float:
    """Part by which pieces of a body may be longer or shorter as their ends are rounded.

    A place is known to eps of its distance from the origin, and the shortest piece is that part of
    the body's radius of gyration.
    """
    away = float(np.linalg.norm(element.center_of_gravity_m))
    size = float(np.sqrt(np.max(element.inertia_kg_m2) / element.mass_kg)) if element.mass_kg else 0
    return _SHORTEST * float(np.finfo(float).eps) * away / size if size > 0.0 else 0.0


def _checks(element: Superelement) -> Iterator[Invariant]:
    """Give all checks that need a mass that is positive definite."""

    def held(name: str, value: float, concerns: str = "", reason: str = "") -> Invariant:
        limit, known = _LIMITS[name]
        limit = _OF_LEVEL.get((element.level, name), limit)
        if known == _EXPORTS:
            limit += _rounding_of_places(element)
        return compared(name, element.name, value, limit, concerns or known, reason)

    rigid, turning = element.rigid_body_present, element.gyroscopic.any()
    negative = measures.negative_part(element, element.stiffness)
    yield held("stiffness positive semidefinite", negative)
    if rigid.any():
        yield held("no elastic force in rigid motion", rigid_force(element))
        yield held(
            "stress stiffening and spin softening cancel in rigid motion",
            rigid_centrifugal_energy(element),
        )
        yield held("rigid motion at the interfaces", measures.interface_error(element))
        worst = measures.property_error(element)
        concerns = {"uz": "axial frequencies", "rz": "torsional frequencies"}.get(worst.motion, "")
        found = held("mass properties", worst.error, concerns)
        said = f"inertia of {worst.motion}: {worst.found:.6g} instead of {worst.expected:.6g}"
        yield found if found.passed else replace(found, reason=said)
    # a body reduced without gyroscopic effects, for a scene at rest, has no G to check
    if rigid[[3, 4]].all() and turning:
        yield held("polar inertia of the tilts", measures.tilt_error(element))
    # lumped bodies need not be bodies of revolution
    around = element.level != "lumped" and turning
    for name, error in (
        ("moments against the mass", measures.mass_moment_error(element)),
        ("moments of rigid motion", measures.rigid_moment_error(element)),
        ("moments against G", measures.gyroscopic_moment_error(element) if around else None),
        ("rigid motion in pictures", measures.picture_error(element)),
        ("the same after a turn about the axis", measures.turn_error(element)),
        ("modal frequencies", measures.modal_frequency_error(element)),
    ):
        if error is not None:
            yield held(name, error)
    speed = element.maximum_speed_rad_s
    if np.isfinite(speed) and speed > 0:
        lost = measures.lost_stiffness(element)
        yield held("stiffness left at the top speed", lost, reason=_lost_at(speed, lost))


def _lost_at(speed_rad_s: float, lost: float) -> str:
    """Say where rotation takes all stiffness of some motion."""
    if lost <= 1.0:
        return f"rotation takes {max(lost, 0.0):.1e} of the stiffness at most"
    speed = speed_rad_s / np.sqrt(lost)
    return f"all stiffness is lost at {speed:.6g} rad/s ({speed * RPM_PER_RAD_S:.6g} rpm)"
