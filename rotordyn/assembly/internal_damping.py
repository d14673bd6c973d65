"""Damping of the material of a spinning body, which turns with it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.parts import Rotor
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.dense import scale_by_stiffness, solve_standing
from solidwhirl.rotordyn.core.errors import AssemblyError
from solidwhirl.rotordyn.superelement.free_body import FreeBodyMatrices


class BodyDamping(NamedTuple):
    """C on q' and the circulatory stiffness −C L per unit spin of the body, each (n, n)."""

    damping: FloatArray
    circulatory: FloatArray


def body_damping(rotor: Rotor, matrices: FreeBodyMatrices) -> BodyDamping:
    """Return the internal damping of one body.

    `rotor`: the body; without internal damping both matrices are zero. The force is C (q' − Ω L q):
    the material sees the velocity less that of the spin. Raises AssemblyError if a damped body that
    turns does not know its spin generator.
    """
    n = rotor.element.size
    wanted = rotor.internal_damping
    if wanted is None or (wanted.stiffness_coefficient_s == 0 and wanted.modal_ratio == 0):
        return BodyDamping(np.zeros((n, n)), np.zeros((n, n)))
    damping = wanted.stiffness_coefficient_s * matrices.stiffness
    if wanted.modal_ratio != 0:
        frequencies, shapes = solve_standing(scale_by_stiffness(matrices.stiffness, matrices.mass))
        momentum = matrices.mass @ shapes
        damping = damping + (2.0 * wanted.modal_ratio * frequencies * momentum) @ momentum.T
    if rotor.speed_ratio == 0:
        return BodyDamping(damping, np.zeros((n, n)))
    # 0 of axes that turn with the material, which see its velocity as it is
    turn = rotor.element.turn
    if turn is None:
        raise AssemblyError(
            (
                f"body {rotor.element.name!r} turns and has internal damping, but its superelement "
                "does not say how it turns (spin_generator); reduce it again",
            )
        )
    return BodyDamping(damping, -damping @ turn)
