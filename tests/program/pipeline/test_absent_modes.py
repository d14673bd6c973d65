"""Scenes whose modes begin at a speed, or never: every result is there and consistent."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
from engine_parts import RIGID

from solidwhirl.datasets.results import datasets
from solidwhirl.output.documents import write_results
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.solver

SCENE = {
    "name": "rotor",
    "speeds": {"list_rpm": [0.0, 3000.0, 6000.0, 9000.0]},
    "campbell": {"branches": 4},
    "rigid_bodies": {"r": RIGID},
    "analyses": [
        {"kind": "mode_shapes", "speeds_rpm": [0.0, 4321.0, 6000.0], "modes": 6},
        {"kind": "rotating_campbell", "bodies": ["r"]},
        {"kind": "stability", "to_rpm": 9000.0},
    ],
}


def _bearings(ends, stiffness, damping):
    values = {"stiffness_n_per_m": stiffness, "damping_n_s_per_m": damping}
    return [{"name": end.upper(), "first": f"r.{end}", **values} for end in ends]


CASES = {
    "free": [],
    "held once": _bearings("a", 1e6, 0.0),
    "held once, damped": _bearings("a", 1e6, 100.0),
    "dampers alone": _bearings("ab", 0.0, 1e3),
    "overdamped at rest": _bearings("ab", 1e5, 2e3),
    "no mode at all": _bearings("ab", 1e5, [[1e6, 0.0], [0.0, 8e5]]),
}


@pytest.mark.parametrize("name", CASES)
def test_modes_that_are_absent_at_rest(name, tmp_path):
    results = run_scene(parse_scene({**copy.deepcopy(SCENE), "bearings": CASES[name]}))
    folder = write_results(results, tmp_path / "out", pictures=name in ("free", "no mode at all"))
    document = json.loads((folder / "results.json").read_text())  # no NaN: it would not be JSON
    assert not [c for c in document["invariants"] if c["passed"] is False]
    hertz = document["campbell"]["frequency_hz"]
    tree = datasets(folder)
    assert tree["campbell"]["frequency_hz"].shape == (len(hertz), 4)
    assert any(branch[0] is None for branch in hertz) or name == "no mode at all"
    kinds = {note["kind"] for note in document["campbell"]["notes"]}
    assert ("empty" if name == "no mode at all" else "begun") in kinds
    # all modes have the number and the frequency of their branch
    for speed in document["analyses"]["mode_shapes"]["speeds"]:
        numbers = speed["branch"]
        assert None not in numbers and len(set(numbers)) == len(numbers)
        if speed["speed_rpm"] == 6000.0:
            column = np.array([branch[2] for branch in hertz], dtype=float)
            found = column[np.array(numbers, dtype=int) - 1]
            np.testing.assert_allclose(speed["frequency_hz"], found, rtol=1e-9)
            assert len(numbers) == np.isfinite(column).sum()
    if name == "free":
        np.testing.assert_allclose(hertz[0][1:], 1.5 * np.array([50.0, 100.0, 150.0]), rtol=1e-9)
    if name.startswith("held once"):
        assert hertz[0][2] == pytest.approx(40.1, abs=0.05)
