"""Zones of the vibration of shafts of ISO 20816-3 (before: ISO 7919-3)."""

from __future__ import annotations

from typing import Literal

import numpy as np

Zone = Literal["A", "B", "C", "D"]

# Borders A/B, B/C, C/D are these over √n, µm, and n is not taken below a speed.
_BORDERS, _SLOWEST_RPM = (4800.0, 9000.0, 13200.0), 600.0
# A change of the vector is significant above this part of the border B/C (criterion II).
_CHANGE = 0.25


def zone_borders_m(speed_rpm: float) -> tuple[float, float, float]:
    """Return the borders A/B, B/C and C/D of the displacement relative to bearings, m.

    `speed_rpm`: highest service speed n. Peak to peak, of the larger of two directions; 4800,
    9000 and 13200 over √n µm.
    """
    root = float(np.sqrt(max(speed_rpm, _SLOWEST_RPM)))
    first, second, third = (1e-6 * border / root for border in _BORDERS)
    return first, second, third


def vibration_zone(displacement_m: float, speed_rpm: float) -> Zone:
    """Return the zone of a displacement, peak to peak; one on a border has the better zone."""
    zones: tuple[Zone, ...] = ("A", "B", "C", "D")
    return zones[sum(displacement_m > border for border in zone_borders_m(speed_rpm))]


def significant_change_m(speed_rpm: float) -> float:
    """Return the change of the vector of vibration from which on it is significant, m.

    `speed_rpm`: as of `zone_borders_m`. A quarter of the border B/C, for better or worse (criterion
    II); the change is |A₂ − A₁| of amplitudes with their phases, peak to peak.
    """
    return _CHANGE * zone_borders_m(speed_rpm)[1]
