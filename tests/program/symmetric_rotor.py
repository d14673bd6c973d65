"""A rigid rotor on two equal bearings, whose responses are closed forms."""

from __future__ import annotations

import copy

import numpy as np
from engine_parts import MASS, rigid_rotor

from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene

POLAR, ARM = 0.3, 0.4
STIFFNESS, DAMPING, MOMENT = 2e6, 400.0, 1e-4  # of each of two bearings; of the unbalance
LATERAL_RAD_S = np.sqrt(2 * STIFFNESS / MASS)
SPAN = {"stiffness_from_n_per_m": 1e6, "stiffness_to_n_per_m": 4e6, "stiffness_count": 3}


def rotor(damping=DAMPING, rpm=(0.0, 9e3), **changes):
    """A rigid rotor on two bearings, the same on both sides: translation and tilt are apart."""
    data = rigid_rotor(STIFFNESS, STIFFNESS, -ARM, ARM, rpm, POLAR)
    bearings = [b | {"damping_n_s_per_m": damping} for b in data["bearings"]]
    return data | {"bearings": bearings} | changes


def compliance(omega, stiffness=STIFFNESS, damping=DAMPING):
    """Translation per force."""
    return 1.0 / (2 * stiffness - MASS * omega**2 + 2j * damping * omega)


def run(data, *analyses):
    return run_scene(parse_scene({**copy.deepcopy(data), "analyses": list(analyses)}))


def outcome(data, kind, **analysis):
    """What results.json holds for one analysis."""
    return run(data, {"kind": kind, **analysis}).analyses[kind].document
