"""What must hold for imported matrices: a body of mass and stiffness, one that can turn."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.importing.rigid_motions import ImportedMotions
from solidwhirl.rotordyn.importing.rows import Report
from solidwhirl.rotordyn.superelement.body_measures import least_inertia, tilt_error, turn_error
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.rigid_body import RIGID_TURN, rigid_body_mass_matrix
from solidwhirl.rotordyn.superelement.validation import MOTIONS

SYMMETRY_REFUSED = 1e-6
_SYMMETRY_NOTED = 1e-12
_SMALLEST_INERTIA = 1e-14
# Negative eigenvalues of K over its largest that rounding of a file leaves.
_NEGATIVE = 1e-9
_PROPERTIES = 1e-6
_STATED = 1e-5
_ON_AXIS = 1e-6
_SAME_ALL_ROUND = 1e-6
# What the complex form and the checks of a run ask for.
_TURN = 1e-11


def symmetric_or_skew(
    report: Report, role: str, matrix: FloatArray, sign: float, inertia: FloatArray
) -> FloatArray:
    """Return the symmetric (sign 1) or skew (−1) part of a matrix; notes say what was evened out.

    `inertia`: diagonal of M: entries compare in coordinates of unit inertia, whatever their units.
    Raises SuperelementError if it deviates by more than 1e-6 of its largest entry.
    """
    root = np.sqrt(np.abs(inertia))
    scaled = matrix / np.outer(root, root)
    largest = float(np.abs(scaled).max(initial=0.0))
    if largest == 0.0:
        return matrix
    error = float(np.abs(scaled - sign * scaled.T).max()) / largest
    kind = "symmetric" if sign > 0 else "skew"
    if error > SYMMETRY_REFUSED:
        raise report.error(
            f"{role} is not {kind}: it deviates by {error:.2e} of its largest entry, "
            f"allowed is {SYMMETRY_REFUSED:g}"
        )
    if error > _SYMMETRY_NOTED:
        report.notes.append(f"The {role} matrix was made {kind}; it deviated by {error:.1e}.")
    return np.asarray(0.5 * (matrix + sign * matrix.T))


def check_mass(
    report: Report, labels: tuple[str, ...], mass: FloatArray, tie: FloatArray | None
) -> None:
    """Refuse a mass (n, n), tied by a constraint or not, that is not positive definite."""
    diagonal = np.diag(mass)
    if not (diagonal > 0.0).all():
        worst = int(diagonal.argmin())
        raise report.error(
            f"mass is not positive definite: {labels[worst]} has the mass "
            f"{diagonal[worst]:g}; condense coordinates without mass where the matrices come from"
        )
    free = mass if tie is None else tie.T @ mass @ tie
    smallest = least_inertia(0.5 * (free + free.T))
    if not smallest > _SMALLEST_INERTIA:
        raise report.error(
            f"mass is not positive definite: its smallest eigenvalue is {smallest:.2e} "
            "with a unit diagonal; some motion of the coordinates has no mass"
        )


def check_stiffness(
    report: Report, mass: FloatArray, stiffness: FloatArray, tie: FloatArray | None
) -> FloatArray:
    """Return the squares of the frequencies at rest, rising, (rad/s)²; refuse a negative K."""
    if tie is not None:
        mass, stiffness = tie.T @ mass @ tie, tie.T @ stiffness @ tie
    rates = la.eigvalsh(stiffness, mass)
    if rates[0] < -_NEGATIVE * max(float(rates[-1]), 0.0) - np.finfo(float).tiny:
        raise report.error(
            f"stiffness has a negative eigenvalue, {rates[0]:.3g} (rad/s)² beside "
            f"{rates[-1]:.3g}; a body's own stiffness is not negative (are there enough digits in "
            "the file, and no preload?)"
        )
    return np.asarray(rates)


def rigid_mass(
    report: Report,
    matrices: Mapping[str, FloatArray],
    motions: ImportedMotions,
    positions: Mapping[str, FloatArray],
    stated: Mapping[str, FloatArray],
) -> tuple[float, FloatArray, FloatArray]:
    """Return mass, centre of gravity and inertia about it, from RᵀMR.

    `matrices`: by role, SI units; `stated`: what the file says itself, for what the coordinates do
    not show; empty if it does not. Raises
    SuperelementError if RᵀMR of the free motions is not that of a rigid body to 1e-6, or not what
    the file states to 1e-5 (a mesh may not hold a closed form exactly).
    """
    found = motions.modes.T @ matrices["mass"] @ motions.modes
    known = None
    if stated:
        inertia = 0.5 * (stated["inertia"] + stated["inertia"].T)
        known = (float(stated["mass"]), stated["center_of_gravity"], inertia)
    properties = _derived(report, found, matrices, motions, positions, known)
    if motions.present.any():
        _check_rigid(report, found, motions, properties, _PROPERTIES)
        if known is not None:
            _check_rigid(report, found, motions, known, _STATED)
    return properties


def _derived(
    report: Report,
    found: FloatArray,
    matrices: Mapping[str, FloatArray],
    motions: ImportedMotions,
    positions: Mapping[str, FloatArray],
    stated: tuple[float, FloatArray, FloatArray] | None,
) -> tuple[float, FloatArray, FloatArray]:
    """Mass properties from RᵀMR, and from what is stated where it does not show them."""
    shown = motions.shown
    if not shown[:3].any():
        if stated is not None:
            return stated
        raise report.error(
            "no translation can be told from the nodes, so that the mass is not known; "
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
        report.notes.append(
            f"The coordinates do not show the rigid motions {missing}; mass properties that need "
            "them are assumed."
        )
    if not motions.present.any():
        said = "Mass properties are those that move with the interfaces of the held body."
        report.notes.append(said)
        inertia = _possible(inertia)
    return mass, center, inertia


def _possible(inertia: FloatArray) -> FloatArray:
    """An inertia that a body can have, none where the found one is not."""
    values = np.linalg.eigvalsh(inertia)
    fits = values[0] >= 0.0 and values[2] <= values[:2].sum() * (1.0 + _PROPERTIES)
    return inertia if fits else np.zeros((3, 3))


def _check_rigid(
    report: Report,
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
    raise report.error(
        f"the inertia {what} {named} in rigid motion is {found[row, column]:.6g} instead "
        f"of {expected[row, column]:.6g}, that of one rigid body of {properties[0]:.6g} kg; are "
        "places and components of the nodes those of the matrices, and in the same unit?"
    )


def turn_fits(report: Report, element: Superelement) -> bool:
    """Return whether the matrices stay the same in the stated turn L; true without one."""
    wrong = turn_error(element)
    if wrong is None or wrong <= _TURN:
        return True
    report.notes.append(
        f"The matrices change by {wrong:.1e} in the turn L about the axis, which is left out; "
        "internal damping and complex coordinates need it."
    )
    return False


def check_turning(report: Report, element: Superelement) -> None:
    """Refuse a body that can't turn: without G, or not the same in all directions about z."""
    if not element.gyroscopic.any():
        raise report.error(
            "the body turns (speed_ratio is not 0) and has no gyroscopic matrix; without "
            "it forward and backward whirl would not part. Give gyroscopic, or leave out "
            "speed_ratio"
        )
    for node in element.interfaces:
        away = float(np.hypot(*node.position_m[:2]))
        if away > _ON_AXIS:
            raise report.error(
                f"interface {node.name!r} is {away:g} m off the axis; those of a body "
                "that turns must be on it"
            )
        has = element.components_at(node.name)
        for first, second in (("ux", "uy"), ("rx", "ry")):
            if (first in has) != (second in has):
                raise report.error(
                    f"interface {node.name!r} has one of {first} and {second}; a body "
                    "that turns needs both or none"
                )
    _check_gyroscopic(report, element)
    error = _anisotropy(element)
    if error > _SAME_ALL_ROUND:
        raise report.error(
            f"the body turns, and is not the same in all directions about z: what its "
            f"interfaces feel changes by {error:.2e} in a turn, allowed is {_SAME_ALL_ROUND:g}"
        )


def _check_gyroscopic(report: Report, element: Superelement) -> None:
    present = element.rigid_body_present
    shift = element.rigid_body_modes[:, :3][:, present[:3]]
    mass = element.mass_kg
    pushed = float(np.abs(shift.T @ element.gyroscopic @ shift).max(initial=0.0))
    if pushed > _PROPERTIES * mass:
        raise report.error(
            f"gyroscopic acts on a rigid translation ({pushed / mass:.2e} of the mass); "
            "it looks like the Coriolis matrix of a rotating frame, the inertial one is needed"
        )
    if not present[[3, 4]].all():
        return
    error = tilt_error(element)
    if error > _PROPERTIES:
        tilts = element.rigid_body_modes[:, [3, 4]]
        found = float((tilts.T @ element.gyroscopic @ tilts)[0, 1])
        raise report.error(
            f"gyroscopic gives row rx, column ry of rigid tilts {found:.6g} kg m², the "
            f"polar inertia +{element.inertia_kg_m2[2, 2]:.6g} is needed (a negative one belongs "
            "to a spin about -z)"
        )


def _anisotropy(element: Superelement) -> float:
    """How much compliances of the interfaces change in a turn, over the largest.

    K + s²(M + G) is regular for every s > 0, as K and M have no negative and G no own energy.
    """
    seats = [k for k, c in enumerate(element.coordinates) if c.kind == "interface"]
    turn = _interface_turn(element, seats)
    tie = np.eye(element.size) if element.constraint is None else element.constraint
    matrices = {
        name: tie.T @ getattr(element, name) @ tie
        for name in ("mass", "gyroscopic", "stiffness", "stress_stiffening", "spin_softening")
    }
    rates = la.eigvalsh(matrices["stiffness"], matrices["mass"])
    elastic = rates[rates > 1e-6 * max(float(rates[-1]), 0.0)]
    chosen = elastic[[0, len(elastic) // 4, len(elastic) // 2]] if elastic.size else np.ones(1)
    change = matrices["stress_stiffening"] - matrices["spin_softening"]
    seen = tie[seats]
    worst = 0.0
    for rate in chosen:
        dynamic = matrices["stiffness"] + rate * (matrices["mass"] + matrices["gyroscopic"])
        forward = la.solve(dynamic, seen.T)
        backward = la.solve(dynamic.T, seen.T)
        for compliance in (seen @ forward, backward.T @ change @ forward):
            worst = max(worst, _commutes(compliance, turn))
    return worst


def _commutes(matrix: FloatArray, turn: FloatArray) -> float:
    """Largest entry of A L − L A over the largest of A, both scaled to a unit diagonal."""
    root = np.sqrt(np.abs(np.diag(matrix)))
    if not root.all():
        root = np.ones_like(root)
    scaled = matrix / np.outer(root, root)
    largest = float(np.abs(scaled).max())
    if largest == 0.0:
        return 0.0
    change = (matrix @ turn - turn @ matrix) / np.outer(root, root)
    return float(np.abs(change).max()) / largest


def _interface_turn(element: Superelement, seats: list[int]) -> FloatArray:
    """Rate of the interface coordinates in a turn of the whole field about the axis."""
    own = [element.coordinates[k] for k in seats]
    motions = [MOTIONS.index(c.component) for c in own]
    same = np.array([[a.interface == b.interface for b in own] for a in own])
    return np.where(same, RIGID_TURN[np.ix_(motions, motions)], 0.0)
