"""Whether imported matrices can turn: gyroscopic matrix, and the same in all directions."""

from __future__ import annotations

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.body_measures import tilt_error, turn_error
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.superelement import Superelement

_PROPERTIES = 1e-6
_ON_AXIS = 1e-6
_SAME_ALL_ROUND = 1e-6
# What the complex form and the checks of a run ask for.
_TURN = 1e-11


def turn_fits(element: Superelement, notes: list[str]) -> bool:
    """Return whether the matrices stay the same in the stated turn L; true without one.

    Parameters
    ----------
    element
        The body.
    notes
        Gets a sentence if not.
    """
    wrong = turn_error(element)
    if wrong is None or wrong <= _TURN:
        return True
    notes.append(
        f"The matrices change by {wrong:.1e} in the turn L about the axis, which is left out; "
        "internal damping and complex coordinates need it."
    )
    return False


def check_turning(where: str, element: Superelement) -> None:
    """Refuse a body that can't turn: without G, or not the same in all directions about z.

    Parameters
    ----------
    where
        For messages.
    element
        The body.

    Raises
    ------
    SuperelementError
        With the reason.
    """
    if not element.gyroscopic.any():
        raise SuperelementError(
            f"{where}: the body turns (speed_ratio is not 0) and has no gyroscopic matrix; without "
            "it forward and backward whirl would not part. Give gyroscopic, or leave out "
            "speed_ratio"
        )
    for node in element.interfaces:
        away = float(np.hypot(*node.position_m[:2]))
        if away > _ON_AXIS:
            raise SuperelementError(
                f"{where}: interface {node.name!r} is {away:g} m off the axis; those of a body "
                "that turns must be on it"
            )
        has = element.components_at(node.name)
        for first, second in (("ux", "uy"), ("rx", "ry")):
            if (first in has) != (second in has):
                raise SuperelementError(
                    f"{where}: interface {node.name!r} has one of {first} and {second}; a body "
                    "that turns needs both or none"
                )
    _check_gyroscopic(where, element)
    error = _unevenness(element)
    if error > _SAME_ALL_ROUND:
        raise SuperelementError(
            f"{where}: the body turns, and is not the same in all directions about z: what its "
            f"interfaces feel changes by {error:.2e} in a turn, allowed is {_SAME_ALL_ROUND:g}"
        )


def _check_gyroscopic(where: str, element: Superelement) -> None:
    present = element.rigid_body_present
    shift = element.rigid_body_modes[:, :3][:, present[:3]]
    mass = element.mass_kg
    pushed = float(np.abs(shift.T @ element.gyroscopic @ shift).max(initial=0.0))
    if pushed > _PROPERTIES * mass:
        raise SuperelementError(
            f"{where}: gyroscopic acts on a rigid translation ({pushed / mass:.2e} of the mass); "
            "it looks like the Coriolis matrix of a rotating frame, the inertial one is needed"
        )
    if not present[[3, 4]].all():
        return
    error = tilt_error(element)
    if error > _PROPERTIES:
        tilts = element.rigid_body_modes[:, [3, 4]]
        found = float((tilts.T @ element.gyroscopic @ tilts)[0, 1])
        raise SuperelementError(
            f"{where}: gyroscopic gives row rx, column ry of rigid tilts {found:.6g} kg m², the "
            f"polar inertia +{element.inertia_kg_m2[2, 2]:.6g} is needed (a negative one belongs "
            "to a spin about -z)"
        )


def _unevenness(element: Superelement) -> float:
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
    turn = np.zeros((len(seats), len(seats)))
    index = {
        (element.coordinates[k].interface, element.coordinates[k].component): place
        for place, k in enumerate(seats)
    }
    for (name, component), place in index.items():
        partner = {"ux": "uy", "rx": "ry"}.get(component)
        if partner is not None:
            other = index[name, partner]  # type: ignore[index]
            turn[other, place], turn[place, other] = 1.0, -1.0
    return turn
