"""Loads on a system in the frame that turns with it: its own unbalance, others', weight, bow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import body_rows, interface_row
from solidwhirl.rotordyn.assembly.system import weights
from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices


@dataclass(frozen=True, kw_only=True)
class Bow:
    """Bend the axis of a body at rest.

    `body`, `interface`: where the bow is measured, from the line through the interfaces `between`
    (two of them). `bow_m`, `phase_rad`: its size, and its direction from x towards y of the body.
    Between them the body has the shape of least strain energy.
    """

    body: str
    interface: str
    between: tuple[str, str]
    bow_m: float
    phase_rad: float = 0.0


def own_unbalance(rotating: RotatingSystem) -> FloatArray:
    """Return the centrifugal force of the asymmetric bodies on their own coordinates at unit speed.

    Shape (n,), kg m. ∫ρ (x φ_x + y φ_y) dV: mass off the axis, products of inertia, and what bends
    a body that is balanced as a whole.
    """
    out = np.zeros(rotating.periodic.size)
    for name, rotor in rotating.system.rotors.items():
        moments = rotor.element.moments
        if rotor.element.frame == "rotating" and moments is not None:
            force = moments.first_kg_m[0, 0] + moments.first_kg_m[1, 1]
            out += body_rows(rotating, name).T @ force
    return out


def unbalance_force(rotating: RotatingSystem, unbalances: Sequence[Unbalance]) -> FloatArray:
    """Return the force of unbalance at unit speed of the frame, shape (n,), kg m.

    Its phase is fixed to its body, whose size of motion depends on it. Raises AnalysisError: a body
    that does not turn with the frame.
    """
    out = np.zeros(rotating.periodic.size)
    for one in unbalances:
        body_rows(rotating, one.body)  # says what exists if it does not
        if not rotating.keeps_step(one.body):
            ratio = rotating.system.rotors[one.body].speed_ratio
            raise AnalysisError(
                f"unbalance at {one.end.label}: the body turns at {ratio:g} times the reference "
                f"speed, the asymmetric bodies at {rotating.frame_ratio:g}; the response is "
                "periodic only to unbalance that turns with these"
            )
        for component, part in (("ux", np.cos(one.phase_rad)), ("uy", np.sin(one.phase_rad))):
            row = interface_row(rotating, one.body, one.interface, component)
            out += one.moment_kg_m * part * row
    return out


def gravity_force(rotating: RotatingSystem, gravity_m_per_s2: npt.ArrayLike) -> Harmonics:
    """Return the weight of all bodies by harmonic of the turn, (n,) each, N.

    `gravity_m_per_s2`: acceleration along the fixed x, y, z, shape (3,). Raises AnalysisError as
    `gravity_load`.
    """
    rows = np.zeros((6, len(rotating.transformation)))
    rows[:3] = weights(rotating, gravity_m_per_s2).T
    found = {h: np.asarray(gravity_m_per_s2) @ at[:3] for h, at in rotating.fixed(rows).items()}
    return {h: force for h, force in found.items() if force.any()}


def bow_force(rotating: RotatingSystem, bows: Sequence[Bow]) -> FloatArray:
    """Return the force that bent bodies put on their coordinates, shape (n,), N.

    Raises AnalysisError: a body that does not turn with the frame, or places that do not tell a
    bow.
    """
    out = np.zeros(rotating.periodic.size)
    for bow in bows:
        if bow.body not in rotating.turned:
            raise AnalysisError(f"bow of {bow.body!r}: the body does not turn with the frame")
        element = rotating.system.rotors[bow.body].element
        stiffness = free_body_matrices(element).stiffness
        places = (bow.interface, *bow.between)
        if len(set(places)) < len(places):
            raise AnalysisError(f"bow of {bow.body!r}: its three places {places} must differ")
        rows, values = [], []
        for place in places:
            given = bow.bow_m if place == bow.interface else 0.0
            for component, part in (("ux", np.cos(bow.phase_rad)), ("uy", np.sin(bow.phase_rad))):
                rows.append(element.interface_index(place, component))
                values.append(given * part)
        held = np.zeros((len(rows), element.size))
        held[np.arange(len(rows)), rows] = 1.0
        shape = _least_energy(stiffness, held, np.array(values))
        out += body_rows(rotating, bow.body).T @ (stiffness @ shape)
    return out


def _least_energy(stiffness: FloatArray, rows: FloatArray, values: FloatArray) -> FloatArray:
    """Shape of least strain energy with given motions; of what is free to move no more."""
    count = len(rows)
    scale = float(np.abs(stiffness).max())
    whole = np.block([[stiffness / scale, rows.T], [rows, np.zeros((count, count))]])
    answer = la.lstsq(whole, np.concatenate([np.zeros(len(stiffness)), values]))[0]
    return np.asarray(answer[: len(stiffness)])
