"""The tool that predicts measured machines: readings are scenes, wheels those of the drawing."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from solidwhirl.identify.run import read_problem
from solidwhirl.scene_reading.paths import find_target
from solidwhirl.scene_reading.reader import parse_scene

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from measured.identified import PROBLEMS, lines_of  # noqa: E402
from measured.readings import READINGS  # noqa: E402
from measured.scenes import CASES, SCENES, scene_of  # noqa: E402
from measured.spinning import SPINNING  # noqa: E402


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_readings_are_scenes(case):
    """Every measured mode has a place; sensitivities name numbers."""
    assert len(case["modes"]) == len(case["measured_hz"])
    for reading in (case, *case["variants"]):
        parse_scene(scene_of(case, reading), folder=SCENES)
    for effect in case["effects"]:
        assert isinstance(find_target(scene_of(case, case), effect["place"]).nominal, float | int)


def test_turning_blades_are_scenes():
    """Measured values and the modes that they are held against go together."""
    for case in SPINNING["cases"]:
        for run in case["runs"]:
            parse_scene(scene_of(run, run), folder=SCENES)
            assert all(len(p["modes"]) == len(p["measured_hz"]) for p in run["points"])


@pytest.mark.parametrize(
    ("reading", "mass_kg"), [("one_relief_right", 45.90), ("one_bonded", 47.40)]
)
def test_wheels_have_the_mass_of_their_drawing(reading, mass_kg):
    """By hand from rims, grooves and reliefs: the wide wheel, and with its relief filled."""
    rings = READINGS[reading][1]
    volume = sum(
        np.pi * (r["outer_radius_m"] ** 2 - r["inner_radius_m"] ** 2) * (r["end_m"] - r["start_m"])
        for r in rings
    )
    assert 7800.0 * volume == pytest.approx(mass_kg, rel=1e-3)


def test_identified_parameters_are_those_of_the_last_run():
    """The page has what its data say, of the problems as they are."""
    data = json.loads((ROOT / "docs" / "data" / "measured.json").read_text("utf-8"))["identified"]
    page = (ROOT / "docs" / "measured.md").read_text(encoding="utf-8")
    assert page.endswith("\n\n".join(lines_of(data)) + "\n")
    for name, found in data.items():
        spec = read_problem(PROBLEMS / f"{name}.toml").spec
        assert [t.value for t in spec.targets] == [t["value"] for t in found["targets"]]
        assert [p.name for p in spec.parameters] == [p["name"] for p in found["parameters"]]
