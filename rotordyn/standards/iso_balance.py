"""Permissible residual unbalance of rigid rotors of ISO 21940-11 (before: ISO 1940-1)."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM

_M_PER_MM = 1e-3
# Least and largest part of the whole in a plane between which the centre of gravity lies.
_PART = (0.3, 0.7)


def permissible_unbalance_kg_m(mass_kg: float, grade_mm_per_s: float, speed_rpm: float) -> float:
    """Return the unbalance U = m G/Ω that a balance quality grade permits, kg m.

    It is of the whole of the rotor, all planes together.
    """
    return mass_kg * grade_mm_per_s * _M_PER_MM / (speed_rpm * RAD_S_PER_RPM)


def grade_of_unbalance_mm_per_s(moment_kg_m: float, mass_kg: float, speed_rpm: float) -> float:
    """Return the grade G = U Ω/m that an unbalance uses up, mm/s."""
    return moment_kg_m * speed_rpm * RAD_S_PER_RPM / (mass_kg * _M_PER_MM)


def in_two_planes(whole_kg_m: float, to_first_m: float, to_second_m: float) -> tuple[float, float]:
    """Return the parts of a permissible unbalance in two planes at the bearings, kg m.

    `to_first_m`, `to_second_m`: distances of the planes from the centre of gravity between them.
    Each is in the inverse ratio of its distance, 0.3 to 0.7 of the whole.
    """
    share = to_second_m / (to_first_m + to_second_m)
    first, second = (whole_kg_m * float(np.clip(part, *_PART)) for part in (share, 1.0 - share))
    return first, second
