"""Scenes of rigid rotors and of disks on massless shafts, which several tests build."""

from __future__ import annotations

import numpy as np

from solidwhirl.model.effects import make_plan
from solidwhirl.model.system_parts import bearings, gears, rotors, simple_elements
from solidwhirl.rotordyn import assemble
from solidwhirl.scene_reading.reader import parse_scene

RPM = np.pi / 30.0
E_PA, NU = 2e11, 0.3
# Next to no mass: what is on a shaft of it moves as on a spring.
MATERIALS = {
    "light": {"density_kg_per_m3": 1e-2, "youngs_modulus_pa": E_PA, "poissons_ratio": NU},
    "plain": {"density_kg_per_m3": 7800.0, "youngs_modulus_pa": E_PA, "poissons_ratio": NU},
}
MASS, POLAR, DIAMETRAL = 12.0, 0.9, 0.5
RISING = {
    "kind": "polynomial",
    "argument_unit": "rad/s",
    "argument_range": [0.0, 2000.0],
    "stiffness_x": [1.0, 0.0, 4e-7],
    "stiffness_y": [1.0, 0.0, 4e-7],
}
TABLE = {
    "kind": "table",
    "speed_rpm": [0.0, 9549.296585513721],  # 1000 rad/s
    "stiffness_n_per_m": [2e6, 5e6],
    "damping_n_s_per_m": [0.0, 0.0],
}


# A rotor whose bearings are at 0.1 m and 0.2 m from its centre of gravity.
RIGID = {
    "speed_ratio": 1.0,
    "mass_kg": 10.0,
    "center_of_gravity_m": [0.0, 0.0, 0.1],
    "inertia_kg_m2": [0.1, 0.1, 0.15],
    "interfaces": {"a": 0.0, "b": 0.3},
}


def rigid_rotor(first=2e6, second=2e6, a=-0.4, b=0.4, rpm=(0.0,), polar=POLAR, **changes):
    """A rigid rotor on two bearings, its centre of gravity at 0."""
    return {
        "name": "rigid",
        "speeds": {"list_rpm": list(rpm)},
        "campbell": {"branches": 4},
        "rigid_bodies": {
            "rotor": {
                "speed_ratio": 1.0,
                "mass_kg": MASS,
                "center_of_gravity_m": [0.0, 0.0, 0.0],
                "inertia_kg_m2": [DIAMETRAL, DIAMETRAL, polar],
                "interfaces": {"a": a, "m": 0.0, "b": b},
            }
        },
        "bearings": [
            {"name": "A", "first": "rotor.a", "stiffness_n_per_m": first},
            {"name": "B", "first": "rotor.b", "stiffness_n_per_m": second},
        ],
        **changes,
    }


def rotor_on_shaft(**changes):
    """A disk in the middle of a pinned shaft that weighs next to nothing."""
    disk = {"name": "d", "at_m": 0.5, "mass_kg": MASS}
    disk |= {"polar_inertia_kg_m2": POLAR, "diametral_inertia_kg_m2": DIAMETRAL}
    shaft = {
        "material": "light",
        "stations_m": [0.0, 0.25, 0.5, 0.75, 1.0],
        "outer_radius_m": [0.02],
        "interfaces": {"a": 0.0, "m": 0.5, "b": 1.0},
        "disks": [disk],
    }
    return {
        "name": "flexible",
        "materials": MATERIALS,
        "speeds": {"list_rpm": [0.0, 3000.0]},
        "beams": {"rotor": shaft},
        "bearings": [
            {"name": "A", "first": "rotor.a", "rigid": ["ux", "uy"]},
            {"name": "B", "first": "rotor.b", "rigid": ["ux", "uy"]},
        ],
        **changes,
    }


def joined(data):
    """The assembled system of a scene without solids."""
    scene = parse_scene(data)
    plan = make_plan(scene, {})
    parts = rotors(scene, plan, simple_elements(scene, plan))
    return assemble(parts, bearings(scene, plan), gears=gears(scene, plan))
