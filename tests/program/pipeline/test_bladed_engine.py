"""Every kind of analysis on an engine whose shaft carries staggered blades, as a solid."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from engine_of_all_kinds import ENGINE, KINDS

from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = [pytest.mark.verify, pytest.mark.solver]

COUNT, LENGTH, CHORD, THICKNESS, RIM, DENSITY = 5, 0.03, 0.015, 0.006, 0.12, 7800.0
BLADES = {
    "name": "row", "on": "disk", "count": COUNT, "length_m": LENGTH, "chord_m": CHORD,
    "thickness_m": THICKNESS, "stagger_deg": 30,
}  # fmt: skip
SOLID = {
    "material": "own",
    "internal_damping": {"modal_ratio": 1e-4},
    "sections": [
        {"name": "left", "start_m": 0.0, "end_m": 0.49, "outer_radius_m": 0.03},
        {"name": "disk", "start_m": 0.49, "end_m": 0.51, "outer_radius_m": RIM},
        {"name": "right", "start_m": 0.51, "end_m": 1.0, "outer_radius_m": 0.03},
    ],
    "interfaces": [
        {"name": "a", "kind": "section", "at_m": 0.0},
        {"name": "m", "kind": "section", "at_m": 0.49},
        {"name": "b", "kind": "section", "at_m": 1.0},
    ],
}


def engine(**more):
    """The engine of all kinds with a solid in the place of its first beam."""
    data = copy.deepcopy(ENGINE)
    del data["beams"]["lp"]
    data["bodies"] = {"lp": SOLID | more}
    data["materials"] = {
        "own": {
            "density_kg_per_m3": DENSITY, "youngs_modulus_pa": 2.1e11, "poissons_ratio": 0.3,
        }
    }  # fmt: skip
    data["model"] = {"level": "solid", "size_m": 0.05, "corner_size_m": 0.01, "modes": 6}
    recovery = {"kind": "recovery", "bodies": ["lp"]}
    recovery["states"] = [{"name": "whirl", "mode": 1, "speed_rpm": 6000.0, "amplitude_m": 1e-5}]
    diameters = {"kind": "nodal_diameters", "body": "lp", "held": ["a", "b"]}
    diameters |= {"to_rpm": 6000.0, "count": 3, "nodal_diameters": [0, 1]}
    data["analyses"] += [recovery, diameters]
    return data


def smeared():
    """Mass and inertia of the blades as a ring on the disk."""
    mass = COUNT * DENSITY * LENGTH * CHORD * THICKNESS
    polar = mass * ((RIM + 0.5 * LENGTH) ** 2 + LENGTH**2 / 12.0)
    return {
        "name": "ring", "interface": "m", "offset_m": 0.01, "mass_kg": mass,
        "polar_inertia_kg_m2": polar, "diametral_inertia_kg_m2": 0.5 * polar,
    }  # fmt: skip


def cylinder(radius_m, start_m, end_m, bore_m=0.0):
    """Polar inertia, and the transverse one about the mount, of a piece of shaft."""
    length, squares = end_m - start_m, radius_m**2 + bore_m**2
    mass = np.pi * (radius_m**2 - bore_m**2) * length * DENSITY
    away = (end_m**3 - start_m**3) / (3.0 * length)
    return 0.5 * mass * squares, mass * (0.25 * squares + away)


def precession_hz(ring):
    """Of the whole engine about its only mount: angular momentum over transverse inertia.

    Both shafts turn against each other: what is left of the momentum is 1/23 of one of them.
    """
    lp = [cylinder(0.03, 0.0, 0.49), cylinder(RIM, 0.49, 0.51), cylinder(0.03, 0.51, 1.0)]
    lp += [(ring["polar_inertia_kg_m2"], ring["diametral_inertia_kg_m2"] + ring["mass_kg"] * 0.25)]
    hp = cylinder(0.06, 0.3, 0.7, 0.045)
    casing = 20.0 + 100.0 * 0.5**2
    momentum = 1.5 * hp[0] - sum(p for p, _ in lp)
    return momentum / (casing + hp[1] + sum(t for _, t in lp)) * np.array([3000.0, 6000.0]) / 60.0


@pytest.fixture(scope="module")
def runs():
    blades, ring = {"blades": [BLADES]}, {"rigid_disks": [smeared()]}
    return [run_scene(parse_scene(engine(**more))) for more in (blades, ring)]


def test_stiff_blades_are_a_ring_to_every_analysis(runs):
    """A blade's first mode is a hundred times above the engine's: what is left is 5e-5."""
    bladed, ring = runs
    for run in runs:
        assert set(run.analyses) == {*KINDS, "recovery", "nodal_diameters"}
        assert [c for c in run.checks if c.passed is False] == []
    found, known = ([c.critical.speed_rad_s for c in r.critical_speeds] for r in runs)
    assert found == pytest.approx(known, rel=5e-5)
    found, known = (r.campbell.frequency_hz for r in runs)
    assert found[:4] == pytest.approx(known[:4], rel=5e-5)
    # the last branch begins at nothing, and multiplies what is left by 23
    assert np.isnan([found[4, 0], known[4, 0]]).all()
    for own in (found, known):
        assert own[4, 1:] == pytest.approx(precession_hz(smeared()), rel=23 * 5e-5)
    assert (bladed.campbell.whirl == ring.campbell.whirl).all()
    # what an engineer reads is the same to the last digit, but for what only one of them has
    own = {"state_space", "recovery", "nodal_diameters"}
    told = [{k: a.headline for k, a in r.analyses.items() if k not in own} for r in runs]
    told[0].pop("run_up"), told[1].pop("run_up")  # ends with the time that it took
    assert told[0] == told[1]
    force = [r.analyses["run_up"].document["largest_mount_force_n"] for r in runs]
    assert force[0] == pytest.approx(force[1], rel=1e-3)


def test_nodal_diameters_are_without_the_ring_of_a_free_interface(runs):
    bladed, ring = (r.analyses["nodal_diameters"].document for r in runs)
    assert "nodal diameters 0 and 1 are without the rigid disks ring" in ring["notes"]
    assert bladed["notes"] == []
