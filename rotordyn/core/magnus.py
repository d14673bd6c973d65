"""Steps of linear differential equations with changing coefficients: Magnus, of fourth order.

Iserles, Munthe-Kaas, Nørsett and Zanna 2000, Lie-group methods, Acta Numerica 9.
"""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray

#: Gauss points of a step.
GAUSS = (0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0)


def magnus_exponent(early: FloatArray, late: FloatArray) -> FloatArray:
    """Return the exponent of a step from h A at its Gauss points, one or many (k, m, m)."""
    both = late @ early - early @ late
    return np.asarray(0.5 * (early + late) + np.sqrt(3.0) / 12.0 * both)
