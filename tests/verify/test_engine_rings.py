"""Rings of blades that the whole engine joins, against one ring on every stage of its units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn import modes_at_speed
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.scene_reading.reader import load_toml, parse_scene

pytestmark = [pytest.mark.verify, pytest.mark.solver]

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def alone(unit, rings=None):
    """A unit of the engine on its bearings, with its own rings or those of another body."""
    data = load_toml(SCENES / "uhbr_engine.toml")
    body = data["bodies"][unit]
    if rings is not None:
        nodes = [i for i in body["interfaces"] if "blades" not in i["name"]]
        rims = [i for i in rings["interfaces"] if "blades" in i["name"]]
        body = body | {"interfaces": nodes + rims, "rigid_disks": rings["rigid_disks"]}
    bearings = [b | {"second": None} for b in data["bearings"] if b["first"].startswith(unit)]
    return {
        "name": unit,
        "model": data["model"] | {"estimates": "off"},
        "speeds": data["speeds"] | {"count": 3},
        "speed_laws": data["speed_laws"],
        "bodies": {unit: body},
        "bearings": [{k: v for k, v in b.items() if v is not None} for b in bearings],
    }


@pytest.mark.parametrize("unit", ["lp", "hp"])
def test_joined_rings_keep_the_modes_of_one_ring_a_stage(unit):
    """Fewer coordinates, and no mode below 250 Hz moves by more than 0.5 %."""
    rings = load_toml(SCENES / f"uhbr_{unit}.toml")["bodies"][unit]
    joined, staged = (
        run_scene(parse_scene(data)).system for data in (alone(unit), alone(unit, rings))
    )
    assert joined.size < 0.8 * staged.size
    for rpm in (0.0, 13690.0):
        found = []
        for system in (joined, staged):
            modes = modes_at_speed(system, rpm * RAD_S_PER_RPM)
            low = modes.frequency_hz < 250.0
            # by whirl, which is none at rest
            whirl = modes.family[low] * bool(rpm)
            found.append(modes.frequency_hz[low][np.lexsort((modes.frequency_hz[low], whirl))])
        np.testing.assert_allclose(*found, rtol=5e-3)
