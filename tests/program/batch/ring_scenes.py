"""Scene of a rigid, turning ring on two equal springs, whose modes are known in closed form."""

from solidwhirl.build import bearing
from solidwhirl.identify.scene import scene_text

ENDS = ("left", "right")
STIFFNESS = {
    "name": "stiffness_n_per_m",
    "places": [f"bearings[{end}].stiffness_n_per_m" for end in ENDS],
}


def ring_scene(sweep, **more):
    return {
        "name": "ring",
        "speeds": {"to_rpm": 6000, "count": 4},
        "campbell": {"branches": 4},
        "rigid_bodies": {
            "ring": {
                "speed_ratio": 1.0,
                "mass_kg": 20.0,
                "center_of_gravity_m": [0, 0, 0],
                "inertia_kg_m2": [0.2, 0.2, 0.3],
                "interfaces": {"left": -0.1, "right": 0.1},
            }
        },
        "bearings": [bearing(end, f"ring.{end}", stiffness_n_per_m=1e6) for end in ENDS],
        **more,
        "sweep": sweep,
    }


def written(folder, data):
    path = folder / "ring.toml"
    path.write_text(scene_text(data, {}), encoding="utf-8")
    return path
