"""Engines with asymmetric bodies at rest, at some angle of these: bodies in fixed axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.parts import Rotor
from solidwhirl.rotordyn.assembly.system import AssembledSystem, assemble
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AssemblyError
from solidwhirl.rotordyn.superelement.record import ErrorForm, Superelement

#: Motions across the axis that turn into each other.
PAIRS = (("ux", "uy"), ("rx", "ry"))


def at_rest(rotors: Mapping[str, Rotor], angle_rad: float = 0.0) -> dict[str, Rotor]:
    """Return the bodies of an engine at rest, as `assemble` takes them.

    `angle_rad`: from x towards y, by which all asymmetric bodies are turned. Forces of the spin are
    left out, and internal damping of asymmetric bodies.
    """
    out = {}
    for name, rotor in rotors.items():
        element = rotor.element
        if element.frame == "rotating":
            none = np.zeros_like(element.mass)
            still = replace(
                element,
                frame="inertial",
                gyroscopic=none,
                stress_stiffening=none,
                spin_softening=none,
            )
            still = _turned(still, angle_rad) if angle_rad else still
            rotor = replace(rotor, element=still, internal_damping=None)
        out[name] = rotor
    return out


def standing_at(
    assembled: AssembledSystem, rotors: Mapping[str, Rotor], angle_rad: float
) -> AssembledSystem:
    """Return an engine at rest with its asymmetric bodies turned from x towards y.

    `assembled`: the same at the angle 0, whose bearings and gears are taken; `rotors`: its bodies
    in their own frames.
    """
    system = assembled.system
    return assemble(at_rest(rotors, angle_rad), system.bearings, system.reference, system.gears)


def interface_turn(element: Superelement) -> FloatArray:
    """Return L of the interfaces of an asymmetric body, 0 of its modes.

    Raises AssemblyError: an interface has one motion of a pair across the axis alone.
    """
    out = np.zeros((element.size, element.size))
    for node in element.interfaces:
        has = element.components_at(node.name)
        for x, y in PAIRS:
            if (x in has) != (y in has):
                raise AssemblyError(
                    (
                        f"body {element.name!r}, interface {node.name!r} has {list(has)}; a body "
                        f"that turns needs {x} and {y}, or none of them",
                    )
                )
            if x in has:
                first, second = (element.interface_index(node.name, c) for c in (x, y))
                out[second, first], out[first, second] = 1.0, -1.0
    return out


def _turned(element: Superelement, angle_rad: float) -> Superelement:
    """A body at rest turned about its axis, its interfaces in fixed axes.

    With q = R q' of the interfaces, and as modes move along: K = R K' Rᵀ. Surface and mass moments,
    which pictures and the spin need, are left out.
    """
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    own = interface_turn(element)
    whole = np.eye(element.size) + sin * own + (1.0 - cos) * own @ own

    def seen(matrix: FloatArray) -> FloatArray:
        blocks = la.block_diag(*[whole] * (len(matrix) // element.size))
        return np.asarray(blocks @ matrix @ blocks.T)

    def seen_form(form: ErrorForm) -> ErrorForm:
        change = form.stiffness_change
        gram = seen(form.gram)
        return replace(
            form,
            gram=0.5 * (gram + gram.T),
            stiffness_change=None if change is None else seen(change),
        )

    tie = element.constraint
    return replace(
        element,
        mass=seen(element.mass),
        stiffness=seen(element.stiffness),
        rigid_body_modes=whole @ element.rigid_body_modes @ la.block_diag(turn, turn).T,
        center_of_gravity_m=turn @ element.center_of_gravity_m,
        inertia_kg_m2=turn @ element.inertia_kg_m2 @ turn.T,
        recovery_points_m=element.recovery_points_m @ turn.T,
        recovery_modes=turn @ element.recovery_modes @ whole.T,
        constraint=None if tie is None else whole @ tie,
        error_forms=tuple(seen_form(form) for form in element.error_forms),
        moments=None,
        surface=None,
    )
