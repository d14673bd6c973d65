"""Resonances of asymmetric rotors as plain data."""

from __future__ import annotations

from typing import Any

from solidwhirl.rotordyn.asymmetric.resonances import Resonance
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.kinds import shares_document


def resonance_document(found: Resonance, frame_ratio: float) -> dict[str, Any]:
    """Return a resonance as plain data; speeds are those of the reference shaft.

    `frame_ratio`: |speed ratio| of the frame.
    """
    return {
        "speed_rpm": found.speed_rad_s / frame_ratio * RPM_PER_RAD_S,
        "motion": found.motion,
        "kind": found.kind,
        "shares": shares_document(found.shares),
        "multiple": found.multiple,
        "share": found.share,
        "damping_ratio": found.damping_ratio,
        "error_estimate": found.error if found.is_estimated else None,
        "error_parts": dict(found.errors) if found.is_estimated else {},
    }
