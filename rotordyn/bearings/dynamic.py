"""What a bearing is whose force depends on the frequency of the motion."""

from __future__ import annotations

from typing import Protocol

from solidwhirl.rotordyn.core.arrays import ComplexArray


class DynamicStiffness(Protocol):
    """A linear bearing whose force depends on the spin speed and the motion."""

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z(Ω, s), N/m: the force on the first side is −Z u for a motion u e^{st}.

        `speed_rad_s`: spin speed Ω of the bearing's first side; `rate`: s, 1/s. On (ux, uy), shape
        (2, 2), or (ux, uy, rx, ry), (4, 4).
        """
