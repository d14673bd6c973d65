"""Reduced bodies on other supports: numbers of a whole run, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.build import with_changes
from solidwhirl.core.errors import SceneError
from solidwhirl.pipeline.run import run_scene
from solidwhirl.reduced_scene import reduce_scene
from solidwhirl.scene_reading.reader import parse_scene


@pytest.fixture(scope="module")
def scene(small_scene):
    return parse_scene(small_scene(rpm=(0.0, 20000.0, 40000.0)))


@pytest.fixture(scope="module")
def reduced(scene):
    return reduce_scene(scene)


@pytest.fixture(scope="module")
def place(scene):
    """Name of the first bearing, and its stiffness."""
    bearing = scene.bearings[0]
    return bearing.name, np.asarray(bearing.stiffness_n_per_m, dtype=float)


def speeds(found):
    return [c.critical.speed_rad_s for c in found]


@pytest.mark.solver
def test_numbers_are_those_of_a_run(reduced, scene, place):
    name, stiffness = place
    other = reduced.with_(**{name: 0.5 * stiffness})
    changed = with_changes(
        scene, {f"bearings[{name}].stiffness_n_per_m": (0.5 * stiffness).tolist()}
    )
    run = run_scene(changed)
    assert other.scene == changed
    # the run chooses its meshes for its own supports, these have them from others
    np.testing.assert_allclose(
        speeds(other.critical_speeds()), speeds(run.critical_speeds), rtol=scene.model.accuracy
    )
    np.testing.assert_allclose(
        other.campbell().frequency_hz,
        run.campbell.frequency_hz,
        rtol=scene.model.accuracy,
        atol=1e-3,  # rigid motions
    )
    estimates = other.estimates()
    assert (estimates is None) == (run.estimates is None)
    assert other.stability().intervals == run.stability.intervals == ()


@pytest.mark.solver
def test_bodies_are_not_reduced_again(reduced, place):
    name, stiffness = place
    others = [reduced.with_(**{name: f * stiffness}) for f in (0.5, 1.0, 2.0)]
    assert all(o.reduced.elements is reduced.reduced.elements for o in others)
    first = [speeds(o.critical_speeds())[0] for o in others]
    assert first == sorted(first) and first[0] < first[-1]
    assert speeds(others[1].critical_speeds()) == speeds(reduced.critical_speeds())
    hertz = others[2].modes(1000.0).frequency_hz
    assert np.all(np.diff(hertz) >= 0.0)
    assert "ReducedScene" in repr(reduced)


@pytest.mark.solver
def test_the_diagram_is_drawn(reduced, tmp_path):
    reduced.draw_campbell(tmp_path / "campbell.svg")
    assert "<svg" in (tmp_path / "campbell.svg").read_text(encoding="utf-8")


@pytest.mark.solver
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"speeds.list_rpm": [0.0, 90000.0]}, "speeds: body 'rotor' was reduced for 40000 rpm"),
        ({"model.accuracy": 1e-4}, "model: differs from the reduced one"),
        ({"bodies.rotor.speed_ratio": 2.0}, "bodies: differs"),
        ({"effects.gyroscopic": "off"}, "effects: differs"),
    ],
)
def test_what_needs_other_bodies_is_refused(reduced, changes, said):
    with pytest.raises(SceneError, match=said):
        reduced.changed(changes)


@pytest.mark.solver
def test_bearings_that_need_more_are_refused(reduced, place):
    with pytest.raises(SceneError, match="motions of body 'rotor' that it was reduced without"):
        reduced.with_(**{place[0]: {"tilt_stiffness_n_m_per_rad": [1e4, 1e4]}})
    with pytest.raises(ValueError, match="no entry \\[q\\]"):
        reduced.with_(q=1e6)
