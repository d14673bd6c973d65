"""Mirror planes that the features of a body have in common."""

from __future__ import annotations

import math

import numpy as np

from solidwhirl.geometry.features import Blade, sector_count
from solidwhirl.geometry.profile import Body

# Angles [rad] nearer than this are one: far below what a drawing says, far above round-off.
_SAME = 1e-9


def mirror_angle(body: Body) -> float | None:
    """Return the angle θ0 [rad] of a plane of symmetry through the axis, None if there is none.

    With N sectors the planes θ = θ0 + k π/N are all that the features have in common; θ0 is the
    least that is not negative. Blades with stagger have none. Raises GeometryError: no features.
    """
    sectors = sector_count(body.features)
    if any(isinstance(f, Blade) and f.stagger_deg != (0.0, 0.0) for f in body.features):
        return None
    # A set of n has the planes φ + k π/n; those of the first are tried on all others.
    first = body.features[0]
    pitch = math.pi / first.count
    tried = math.radians(first.angle_deg) % pitch + pitch * np.arange(first.count // sectors)
    for feature in body.features[1:]:
        pitch = math.pi / feature.count
        off = (tried - math.radians(feature.angle_deg) + pitch / 2.0) % pitch - pitch / 2.0
        tried = tried[np.abs(off) < _SAME]
    if not tried.size:
        return None
    least = float(tried.min())
    return 0.0 if math.pi / sectors - least < _SAME else least
