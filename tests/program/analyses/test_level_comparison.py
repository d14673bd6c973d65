"""The same engine on two levels: what is compared, and that a wrong solid would be noticed."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from solidwhirl.analyses.base import Found
from solidwhirl.analyses.kinds.level_comparison import LevelComparisonSpec, LevelResults
from solidwhirl.core.blocks import Table
from solidwhirl.model.at_level import at_level
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.scene_reading.reader import parse_scene

SOLID = LevelResults(
    levels={"rotor": "solid"},
    unknowns={"rotor": 9000},
    frequency_hz=np.array([100.0, 250.0]),
    frequency_error=np.array([1e-3, 2e-3]),
    critical_rad_s=np.array([600.0]),
    critical_error=np.array([1e-3]),
    excited_by=("rotor",),
)
MERIDIAN = replace(
    SOLID,
    levels={"rotor": "harmonic"},
    unknowns={"rotor": 800},
    frequency_hz=np.array([100.05, 250.1]),
    critical_rad_s=np.array([600.3, 900.0]),
    critical_error=np.array([1e-3, 1e-3]),
    excited_by=("rotor", "rotor"),
)


def asked(own, other, level="harmonic"):
    spec = LevelComparisonSpec(kind="level_comparison", level=level)
    engine = SimpleNamespace(levels=lambda level: (own, other))
    return spec, spec.run(engine)


def test_differences_beside_the_sum_of_estimates():
    spec, outcome = asked(SOLID, MERIDIAN)
    document = outcome.document
    assert [r["what"] for r in document["rows"]] == [
        *("mode 1 at rest", "mode 2 at rest", "critical speed 1"),
    ]
    found = [r["relative_difference"] for r in document["rows"]]
    assert found == pytest.approx([5e-4, 4e-4, 5e-4])
    # 5e-4 of 2e-3 is nearer to its limit than 4e-4 of 4e-3
    (check,) = document["checks"]
    assert check["passed"] and check["value"] == pytest.approx(0.25)
    assert "1 critical speeds, 2 on level harmonic" in outcome.headline
    found = Found(name="levels", outcome=outcome, engine=None)
    chart, table, bodies = spec.blocks(found)
    assert isinstance(chart, Chart) and isinstance(table, Table)
    assert [row[-1] for row in table.rows] == ["+0.05", "+0.04", "+0.05"]
    assert [*bodies.rows] == [["rotor", "solid", 9000, "harmonic", 800]]
    assert dict(spec.scalars(document)) == {"largest_relative_difference": pytest.approx(5e-4)}


def test_levels_that_differ_by_more_than_their_estimates_fail_a_check():
    wrong = replace(MERIDIAN, frequency_hz=np.array([100.05, 251.1]))
    (check,) = asked(SOLID, wrong)[1].document["checks"]
    assert not check["passed"] and check["value"] == pytest.approx(1.1)
    # beams are a theory of their own, whose estimate is a spread
    assert asked(SOLID, wrong, "beam")[1].document["checks"] == []
    unknown = replace(SOLID, frequency_error=np.full(2, np.nan), critical_error=np.full(1, np.nan))
    assert asked(unknown, wrong)[1].document["checks"] == []


def test_bodies_that_are_on_the_level_already():
    spec, outcome = asked(MERIDIAN, MERIDIAN)
    assert outcome.document["rows"] == [] and outcome.headline.startswith("nothing to compare")
    (bodies,) = spec.blocks(Found(name="levels", outcome=outcome, engine=None))
    assert bodies.rows[0][1] == bodies.rows[0][3] == "harmonic"


@pytest.mark.solver
def test_solid_beside_its_meridian(small_scene):
    """The other level is what a run on it finds by itself."""
    data = {**small_scene(), "model": {"level": "solid", "accuracy": 5e-2}}
    data["analyses"] = [{"kind": "level_comparison", "level": "harmonic"}]
    run = run_scene(parse_scene(data))
    rows = run.analyses["level_comparison"].document["rows"]
    data["analyses"] = []
    alone = run_scene(at_level(parse_scene(data), "harmonic", 5e-2))
    count = sum("frequency_hz" in row for row in rows)
    assert count == len(alone.campbell.frequency_hz)
    hertz = [row["other_frequency_hz"] for row in rows[:count]]
    assert hertz == pytest.approx(alone.at_rest.frequency_hz[:count], rel=1e-12)
    errors = [row["other_error_estimate"] for row in rows[:count]]
    assert errors == pytest.approx(alone.estimates.at_rest.total[:count], rel=1e-9)
    assert [row["frequency_hz"] for row in rows[:count]] == pytest.approx(
        run.at_rest.frequency_hz[:count], rel=1e-12
    )
    speeds = [row["other_speed_rpm"] for row in rows[count:]]
    known = [c.critical.speed_rad_s * 30.0 / np.pi for c in alone.critical_speeds]
    assert speeds == pytest.approx(known, rel=1e-12)
    named = [c for c in run.checks if c.name == "levels agree within their estimates"]
    assert len(named) == 1 and named[0].passed
