"""Readings of joints that the sources leave open, as entries of scenes by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

_GROOVE_M, _RIM_M, _BOTTOM_M, _BORE_M = 0.035 / 3.0, 0.1475, 0.1355, 0.035
#: Radii of the relief of a bore, next to what carries and at the face [m]
_RELIEF_M = (0.045, 0.055)


def _wheel(
    name: str, middle_m: float, width_m: float, groove_m: float, relief_m: tuple[float, float]
) -> Callable[[int], list[dict[str, Any]]]:
    """Return the sections of a wheel by the side of its relief: 1 right, -1 left, 0 none.

    `groove_m`: distance of the outer grooves from the middle one. `relief_m`: from the middle
    plane to where the bore is relieved, and to where it is relieved more.
    """

    def sections(side: int) -> list[dict[str, Any]]:
        grooves = [(c - _GROOVE_M / 2.0, c + _GROOVE_M / 2.0) for c in (-groove_m, 0.0, groove_m)]
        steps = {-width_m / 2.0, width_m / 2.0, *(e for pair in grooves for e in pair)}
        steps |= {side * depth for depth in relief_m if side}
        places = np.unique(np.round(sorted(steps), 9))
        found = []
        for number, (start, end) in enumerate(pairwise(places)):
            at = (start + end) / 2.0
            grooved = any(a < at < b for a, b in grooves)
            reliefs = [r for d, r in zip(relief_m, _RELIEF_M, strict=True) if side * at > d]
            found.append(
                {
                    "name": f"{name}_{number}",
                    "start_m": float(middle_m + start),
                    "end_m": float(middle_m + end),
                    "inner_radius_m": max(reliefs, default=_BORE_M) if side else _BORE_M,
                    "outer_radius_m": _BOTTOM_M if grooved else _RIM_M,
                }
            )
        return found

    return sections


_NARROW = _wheel("narrow", 0.1, 0.08, 0.025, (-0.005, 0.015))
_WIDE = _wheel("wide", 0.19, 0.1, 0.035, (0.005, 0.025))


def _bonded_disks() -> list[dict[str, Any]]:
    return [
        {
            "name": f"disk_{number}",
            "start_m": at - 0.0055,
            "end_m": at + 0.0055,
            "inner_radius_m": 0.0025,
            "outer_radius_m": 0.06,
            "material": "aluminium_of_source",
        }
        for number, at in ((1, 0.14), (2, 0.345))
    ]


_SHAFT, _ROTOR = "bodies.shaft.sections", "bodies.rotor.sections"
#: Sections that a reading adds to those at a place of the scene
READINGS: Mapping[str, tuple[str, list[dict[str, Any]]]] = {
    "one_bonded": (_SHAFT, _WIDE(0)),
    "one_relief_right": (_SHAFT, _WIDE(1)),
    "one_relief_left": (_SHAFT, _WIDE(-1)),
    "two_bonded": (_SHAFT, _NARROW(0) + _WIDE(0)),
    "two_relief_right": (_SHAFT, _NARROW(1) + _WIDE(1)),
    "two_relief_left": (_SHAFT, _NARROW(-1) + _WIDE(-1)),
    "bonded_disks": (_ROTOR, _bonded_disks()),
}
