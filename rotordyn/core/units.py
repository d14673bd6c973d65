"""Factors between the units that people read and SI."""

from __future__ import annotations

import math

#: Revolutions per minute in one radian per second: rpm = RPM_PER_RAD_S * rad/s.
RPM_PER_RAD_S = 30.0 / math.pi
#: And back: rad/s = RAD_S_PER_RPM * rpm, without the rounding of a quotient.
RAD_S_PER_RPM = math.pi / 30.0
