"""What ball and roller bearings share: their elements on the pitch circle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray


class ElementForces(NamedTuple):
    """What the rolling elements do at a motion (ux, uy, uz, rx, ry) of the inner ring.

    `force`: needed to hold the ring there, N and N m, shape (5,); `stiffness`: its derivative,
    shape (5, 5); `inner_load_n`, `outer_load_n`: on the two races per element, shape (Z,);
    `inner_angle_rad`, `outer_angle_rad`: contact angles, shape (Z,).
    """

    force: FloatArray
    stiffness: FloatArray
    inner_load_n: FloatArray
    outer_load_n: FloatArray
    inner_angle_rad: FloatArray
    outer_angle_rad: FloatArray


def element_angles(count: int) -> FloatArray:
    """Return the angles of the elements from +x, the first at 0, shape (Z,)."""
    return 2.0 * np.pi * np.arange(count) / count


def element_problems(what: str, count: int, diameter_m: float, pitch_m: float) -> list[str]:
    """Return what is wrong with the number and size of balls or rollers, `what` they are called."""
    problems = []
    if count < 3:
        problems.append(f"{count} {what}s; needed are 3 or more")
    if not 0 < diameter_m < pitch_m < np.inf:
        problems.append(
            f"{what} diameter {diameter_m:g} m, pitch diameter {pitch_m:g} m; needed is "
            f"0 < {what} diameter < pitch diameter"
        )
    elif count * diameter_m > np.pi * pitch_m:
        problems.append(f"{count} {what}s do not fit on the pitch circle")
    return problems


def centrifugal_load_n(mass_kg: float, pitch_m: float, ratio: float, speed_rad_s: float) -> float:
    """Return the load that presses an element outward, N.

    It goes round with ½ Ω (1 − ratio), the ratio being Dw cos α / Dpw, at the speed of the inner
    ring Ω.
    """
    orbit = 0.5 * speed_rad_s * (1.0 - ratio)
    return float(0.5 * mass_kg * pitch_m * orbit**2)
