"""What a bearing is whose force depends on the frequency of the motion."""

from __future__ import annotations

from typing import Protocol

from solidwhirl.rotordyn.core.arrays import ComplexArray


class DynamicStiffness(Protocol):
    """A linear bearing on (ux, uy) whose stiffness depends on the spin speed and the motion."""

    def dynamic_stiffness(self, speed_rad_s: float, eigenvalue: complex) -> ComplexArray:
        """Return Z, shape (2, 2), N/m: the force on the rotor is −Z u for u e^(eigenvalue · t).

        `speed_rad_s`: spin speed of the bearing's first side, with its sign.
        """
