"""Which modes the unbalance of a shaft can excite."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.modes.whirl import interface_orbits, moves_laterally

# Circles below this fraction of the largest orbit of the mode are rounding.
_NO_CIRCLE = 1e-6


class Excitation(NamedTuple):
    """Whether an unbalance can excite a mode, and why or why not."""

    excited: bool
    why: str


def unbalance_excitation(
    assembled: AssembledSystem, shape: ComplexArray, bodies: Sequence[str]
) -> Excitation:
    """Tell whether the unbalance of bodies can excite a mode.

    `shape`: mode φ of q = φ e^{iωt}, ω > 0, in its independent coordinates, shape (n,). Returns an
    unbalance turns with its body. In an isotropic system orbits of modes are circles, and those
    that turn the other way take no energy from it; otherwise orbits are ellipses, which hold a
    circle of either direction.

    The work of the rotating force on q = φ e^{iωt} is proportional to the part of the orbit that
    turns with it, |X + iY|/2 for a body that turns with the reference shaft and |X − iY|/2 for
    one that turns against it (Genta 2005, Dynamics of Rotating Systems, section 5.7).
    """
    if not moves_laterally(assembled, shape):
        return Excitation(False, "no lateral motion")
    turning = [b for b in bodies if assembled.system.rotors[b].speed_ratio != 0]
    if any(_circle(assembled, shape, body, 1.0) for body in turning):
        return Excitation(True, "orbits have a part that turns with the shaft")
    if any(_circle(assembled, shape, body, -1.0) for body in turning):
        return Excitation(False, "orbits are circles that turn against the shaft")
    return Excitation(False, "the mode does not move the shaft")


def _circle(assembled: AssembledSystem, shape: ComplexArray, body: str, turn: float) -> bool:
    """Whether the orbits of a body have a part that turns with it (turn 1) or against it (−1)."""
    orbits = interface_orbits(assembled, shape[:, None])
    rotors = assembled.system.rotors
    owners = [name for name, rotor in rotors.items() for _ in rotor.element.interfaces]
    own = np.array([name == body for name in owners])
    sense = turn * np.sign(rotors[body].speed_ratio)
    circles = 0.5 * np.abs(orbits.x + 1j * sense * orbits.y)[own]
    largest = np.maximum(np.abs(orbits.x), np.abs(orbits.y)).max()
    return bool(circles.max(initial=0.0) > _NO_CIRCLE * largest)
