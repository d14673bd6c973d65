"""A diagram that ends below all operating speeds is doubted: its speeds may be in rad/s."""

from __future__ import annotations

import pytest
from beam_scene import beam_scene as scene
from beam_scene import margins

from solidwhirl.plausibility.units import implausible


def doubts(found):
    return [d for d in implausible(found, {}) if d.key.startswith("speeds.")]


def test_operating_speeds_above_the_diagram_are_doubted():
    """1884 rad/s are 17 991 rpm, what was meant."""
    (doubt,) = doubts(scene([margins(12_000, 15_000)], to_rpm=1884.0))
    assert doubt.key == "speeds.list_rpm"
    assert "1884 rpm, and the operating speeds of 'rotor' are 12000 to 15000 rpm;" in doubt.message
    assert "rad/s (17990.9 rpm)?" in doubt.message
    (doubt,) = doubts(scene([margins(12_000, 12_000)], to_rpm=1000.0))
    assert "are 12000 rpm;" in doubt.message and "rad/s" not in doubt.message
    (doubt,) = doubts(scene([margins(12_000, 15_000)], to_rpm=7000.0, ratio=-1.5))
    assert "from 8000 rpm of the reference shaft on" in doubt.message
    (doubt,) = doubts(scene([margins(12_000, 15_000)], speeds={"to_rpm": 1884.0, "count": 2}))
    assert doubt.key == "speeds.to_rpm"


@pytest.mark.parametrize(
    ("analyses", "to_rpm", "ratio"),
    [
        ([margins(12_000, 15_000)], 12_000.0, 1.0),  # the diagram reaches the lowest
        ([margins(12_000, 15_000)], 6000.0, 2.0),
        ([margins(12_000, 15_000), margins(1000, 2000, name="idle")], 5000.0, 1.0),
        ([margins(12_000, 15_000)], 0.0, 1.0),  # at rest on purpose
        ([], 1884.0, 1.0),
    ],
)
def test_operating_speeds_in_the_diagram_are_not(analyses, to_rpm, ratio):
    assert doubts(scene(analyses, to_rpm=to_rpm, ratio=ratio)) == []
