"""The engine let go at its mount, as a wing sees it."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.state_space.file import read_state_space
from solidwhirl.scene_reading.reader import parse_scene


@pytest.mark.solver
def test_slow_force_at_the_mount_moves_the_mass_of_the_engine(scene_data, tmp_path):
    data = scene_data("uhbr_engine_free")
    # a mass needs no mesh, and no estimate
    data["model"] |= {"level": "beam", "estimates": "off"}
    data["analyses"] = [a for a in data["analyses"] if a["kind"] == "state_space"]
    results = run_scene(parse_scene(data))
    results.analyses["state_space"].files["state_space.h5"](tmp_path / "engine.h5")
    model = read_state_space(tmp_path / "engine.h5")
    a, b, c, d = model.at_speed(0.0)
    omega = 2 * np.pi * 0.2
    response = c @ np.linalg.solve(1j * omega * np.eye(len(a)) - a, b) + d
    force = model.input_names.index("force casing.P.ux")
    motion = model.output_names.index("acceleration casing.P.ux")
    # Table 4 of Müller and Hennings: 2021.42 kg, P in the centre of gravity. The softest mode, at
    # 12 Hz, adds (0.2 / 12)² of a part of the mass.
    assert 1 / response[motion, force].real == pytest.approx(2021.42, rel=1e-4)
