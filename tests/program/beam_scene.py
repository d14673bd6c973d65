"""A scene of one beam on two bearings, and an entry with its operating speeds."""

from __future__ import annotations

from solidwhirl.scene_reading.reader import parse_scene

BEAM = {
    "material": "steel",
    "stations_m": [0.0, 0.4],
    "outer_radius_m": [0.02],
    "interfaces": {"a": 0.0, "b": 0.4},
}


def beam_scene(analyses, to_rpm=0.0, ratio=1.0, speeds=None):
    """Beam "rotor" with speeds from 0 to one, at rest alone, or as given."""
    return parse_scene(
        {
            "name": "scene",
            "speeds": speeds or {"list_rpm": [0.0, to_rpm] if to_rpm else [0.0]},
            "beams": {"rotor": BEAM | {"speed_ratio": ratio}},
            "bearings": [
                {"name": n, "first": f"rotor.{n}", "stiffness_n_per_m": 1e7} for n in "ab"
            ],
            "analyses": analyses,
        }
    )


def margins(low, high, **more):
    """Separation margins of the beam's operating speeds [rpm]."""
    return {
        "kind": "separation_margins",
        "operating": [{"shaft": "rotor", "from_rpm": low, "to_rpm": high}],
        **more,
    }
