"""A surface that no coordinate moves."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.superelement.surface import Surface


def still_surface(points_m, cells):
    none = np.empty(0, dtype=int)
    return Surface(
        points_m=points_m,
        cells=cells,
        amplitudes=np.zeros((len(points_m), 3, 0)),
        coordinate=none,
        order=none,
        family=none,
        size=1,
    )
