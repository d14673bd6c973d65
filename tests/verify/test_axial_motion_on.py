"""Critical speeds of lateral motion do not change where axial motion is computed beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene.records import EffectsSpec
from solidwhirl.scene_reading.reader import read_scene

pytestmark = [pytest.mark.verify, pytest.mark.solver]
SCENE = Path(__file__).parents[2] / "scenes" / "compressor.toml"


def test_compressor_with_axial_motion():
    """Tilting pads damp some branches so much that two may be taken for one, with a jump."""
    scene = read_scene(SCENE).model_copy(update={"analyses": ()})
    run = run_scene(scene)
    beside = run_scene(scene.model_copy(update={"effects": EffectsSpec(axial="on")}))
    lateral, both = (
        np.array([c.critical.speed_rad_s for c in found.critical_speeds]) for found in (run, beside)
    )
    planar = [c.critical.whirl for c in beside.critical_speeds].count("straight")
    assert both.size == lateral.size + planar
    away = np.abs(np.subtract.outer(lateral, both)).min(axis=1)
    assert (away < 1e-4 * lateral).all()  # another basis: within the estimates
    assert all(check.passed is not False for check in beside.checks)
