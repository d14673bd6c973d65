"""Which nodal diameter an engine order excites: the zigzag of the interference diagram.

A pattern that stands still with E waves around the circumference is seen by the turning body as a
wave of E·Ω that runs backward. N sectors can not tell E from E + N: E = kN + h excites backward
modes of the index h, E = kN - h its forward ones (Singh et al., SAFE diagram, ASME 1988; Wildheim,
J. Appl. Mech. 46 (1979) 878-882).
"""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.nodal_diameters.modes import HZ_PER_RAD_S, Direction


def excited_index(order: int, sectors: int | None) -> tuple[int, Direction]:
    """Return index and direction of what an engine order excites.

    `sectors`: N, or None for a body of revolution.
    """
    if sectors is None:
        return order, "standing" if order == 0 else "backward"
    wave = order % sectors
    if wave == 0 or 2 * wave == sectors:
        return wave, "standing"
    return (wave, "backward") if 2 * wave < sectors else (sectors - wave, "forward")


def zigzag(sectors: int | None, highest_order: int, speed_rad_s: float) -> FloatArray:
    """Return index and frequency of the engine orders 0, 1, ... at a speed, (orders, 2) [1, Hz].

    Every point between two neighbours lies on a straight line, as those of half sectors are there.
    """
    orders = np.arange(highest_order + 1.0)
    if sectors is not None and sectors % 2:
        orders = np.union1d(orders, np.arange(0.5 * sectors, highest_order + 1.0, sectors))
    index = (
        orders if sectors is None else np.abs((orders + 0.5 * sectors) % sectors - 0.5 * sectors)
    )
    return np.column_stack([index, orders * speed_rad_s * HZ_PER_RAD_S])
