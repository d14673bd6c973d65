"""A solid cylinder whose mass and polar inertia follow from radius and length by hand."""

from __future__ import annotations

CYLINDER = {
    "name": "cylinder",
    "bodies": {
        "rotor": {
            "material": "steel",
            "sections": [{"name": "shaft", "start_m": 0.0, "end_m": 0.5, "outer_radius_m": 0.05}],
        }
    },
}
RADIUS = {
    "name": "radius",
    "start": 0.05,
    "lower": 0.02,
    "upper": 0.2,
    "places": ["bodies.rotor.sections[shaft].outer_radius_m"],
}
LENGTH = {
    "name": "length",
    "start": 0.5,
    "lower": 0.1,
    "upper": 2.0,
    "places": ["bodies.rotor.sections[shaft].end_m"],
}
MASS = {"name": "mass", "quantity": "mass_kg", "body": "rotor", "value": 30.0}
POLAR = {"name": "polar", "quantity": "polar_inertia_kg_m2", "body": "rotor", "value": 0.09}
