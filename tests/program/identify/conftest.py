"""The cylinder as a problem file."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from cylinder import CYLINDER, LENGTH, MASS, POLAR, RADIUS

from solidwhirl.identify.scene import scene_text


@pytest.fixture
def problem(tmp_path):
    """Function: path of a problem file, with its scene beside it."""

    def write(parameters=(RADIUS, LENGTH), targets=(MASS, POLAR), scene=CYLINDER, **more):
        data = {
            "name": "problem",
            "scene": scene if isinstance(scene, str) else "base.toml",
            "parameters": [dict(p) for p in parameters],
            "targets": [dict(t) for t in targets],
            **more,
        }
        (tmp_path / "base.toml").write_text(
            scene_text(CYLINDER if isinstance(scene, str) else scene, {}), encoding="utf-8"
        )
        path = tmp_path / "problem.toml"
        path.write_text(scene_text(data, {}), encoding="utf-8")
        return path

    return write
