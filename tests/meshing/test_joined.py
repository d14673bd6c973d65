"""Drum and stages of unlike counts: what of the drum is copied, and how many elements to expect."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from solidwhirl.meshing import MeshSize
from solidwhirl.meshing.own.joined import mesh_joined, without_copies
from solidwhirl.meshing.own.prediction import predict_mesh
from solidwhirl.model.bodies import build_bodies
from solidwhirl.scene_reading.reader import read_scene

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "drum_stages.toml"
SIZE = MeshSize(size_m=0.03, corner_size_m=0.008, growth=0.8, through_thickness=0.4)


@pytest.fixture(scope="module")
def drum():
    return build_bodies(read_scene(SCENE))["drum"]


@pytest.fixture(scope="module")
def mesh(drum):
    return mesh_joined(drum, SIZE)


def test_the_drum_is_copied_near_the_stages_of_an_order(mesh):
    """Two pitches from ring 1 of 24 blades are 63 mm, so that the back of the drum has no copy."""
    parts = mesh.parts
    assert {s for s in parts.shifts if s} == {24, -24, 31, -31, 37, -37}
    ends = {}
    for number, shift in enumerate(parts.shifts):
        if shift:
            z = mesh.points[mesh.cells[parts.cell_part == number].ravel(), 2]
            low, high = ends.get(shift, (np.inf, -np.inf))
            ends[shift] = min(low, z.min()), max(high, z.max())
    # rings from 0.13 to 0.17, 0.20 to 0.24 and 0.27 to 0.31 m; spacers and cones lie between them
    assert ends[24][0] < 0.13 and ends[24][1] == pytest.approx(0.20)
    assert ends[31] == (pytest.approx(0.17), pytest.approx(0.27))
    assert ends[37][0] == pytest.approx(0.24) and ends[37][1] > 0.31
    assert ends[24] == ends[-24]
    assert ends[37][1] < 0.40  # of a drum that ends at 0.44 m


def test_the_number_of_elements_is_predicted_by_part(drum, mesh):
    found = len(without_copies(mesh).cells)
    assert predict_mesh(drum, SIZE, "solid").cells == pytest.approx(found, rel=0.5)
