"""The twin rotor at full convergence, on even meshes, and on the solid level."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import read_scene, with_model

pytestmark = [pytest.mark.verify, pytest.mark.solver]
SCENE = Path(__file__).parents[2] / "scenes" / "ferraris.toml"


def frequencies(level="harmonic", accuracy=None, **model):
    scene = with_model(read_scene(SCENE), level=level, accuracy=accuracy)
    changed = scene.model.model_copy(update=model)
    results = run_scene(scene.model_copy(update={"model": changed, "analyses": ()}))
    return results.campbell.frequency_hz[:4][:, [0, 10, 20]].T


@pytest.fixture(scope="module")
def converged():
    return frequencies(accuracy=1e-5)


def test_even_meshes_approach_the_converged_values_from_above(converged):
    """Corner singularity: halving an even mesh leaves 2^-1.09 = 0.47 of the error."""
    errors = [
        frequencies(order=2, size_m=h, corner_size_m=h) / converged - 1.0
        for h in (0.01, 0.005, 0.0025)
    ]
    assert np.all(np.array(errors) > 0.0)
    for coarse, fine in pairwise(errors):
        assert np.median(fine / coarse) == pytest.approx(0.47, abs=0.12)


def test_accuracy_of_the_scene_is_kept(converged):
    assert np.abs(frequencies() / converged - 1.0).max() < 5e-3
    assert np.abs(frequencies(accuracy=1e-3) / converged - 1.0).max() < 1e-3


def test_solid_level_meets_the_published_figures_and_the_meridian(converged):
    """At rest 170.9 and 192.85 Hz within 0.5 %; the converged meridian at the scene's accuracy.

    Published figures at speed are of an even mesh, 0.6 % above its limit; test_scenes.py makes one.
    """
    found = frequencies(level="solid")
    np.testing.assert_allclose(found[0, :2], [170.9, 192.85], rtol=5e-3)
    above = found / converged - 1.0
    assert above.min() > 0.0
    assert above.max() < 5e-3
