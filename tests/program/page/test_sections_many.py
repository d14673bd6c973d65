"""Pages of engines with much of everything: what is shown first, folded, joined, left out."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest
from everything import everything

from solidwhirl.analyses.base import Operating
from solidwhirl.analyses.kinds.bearing_laws import Law, law_chart
from solidwhirl.analyses.kinds.separation_margins import margin_blocks
from solidwhirl.core.blocks import margin_words
from solidwhirl.drawing.engine import matrix_text, stiffness_text
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Chart, Picture, Row
from solidwhirl.page.modes import shapes
from solidwhirl.page.run import summary
from solidwhirl.page.run.checks import reasons
from solidwhirl.page.run.summary import margin_text
from solidwhirl.page.sections import entitled, page_of, sections_of
from solidwhirl.rotordyn.plots.chart import Axis, Curve, Look, Span
from solidwhirl.rotordyn.plots.chart import Chart as ChartRecord
from solidwhirl.rotordyn.plots.response import ExciterCurves, force_chart, moving
from solidwhirl.rotordyn.superelement.invariants import undecided
from solidwhirl.scene.joints import BearingSpec
from solidwhirl.scene_checks.operating import margin_of, nearest


def speeds(*rpm):
    return [{"speed_rpm": float(v)} for v in rpm]


def test_summary_shows_the_critical_speeds_nearest_to_operation():
    # the second shaft turns at half the speed: 2000 rpm of its own are 4000 of the reference
    operating = (Operating("a", 900.0, 1100.0, 1.0), Operating("b", 2000.0, 2000.0, 0.5))
    found = speeds(100, 800, 1000, 1150, 2500, 3950, 5000)
    chosen, said = nearest(found, operating, 4)
    assert chosen == speeds(800, 1000, 1150, 3950)
    assert "4 of 7" in said and "nearest to the operating speeds" in said
    # without operating speeds the lowest, or all
    assert nearest(speeds(3, 1, 2), (), 3) == (speeds(3, 1, 2), "")
    chosen, said = nearest(speeds(3, 1, 2), (), 2)
    assert chosen == speeds(1, 2) and "lowest" in said


def test_amplitudes_that_are_rounding_are_left_out():
    curves = {"fan": [0.0, 1.0, 2.0], "lp": [1e-12, 0.0, 1e-10], "hp": [1e-9, 1e-3, 0.0]}
    found = moving({name: np.array(values) for name, values in curves.items()})
    assert set(found) == {"fan", "hp"}
    np.testing.assert_array_equal(found["fan"], [np.nan, 1.0, 2.0])
    # 1e-9 of the largest, 2, is rounding
    np.testing.assert_array_equal(found["hp"], [np.nan, 1e-3, np.nan])
    assert moving({"still": np.zeros(2)}) == {}


def test_bearings_without_force_have_no_curve():
    curves = ExciterCurves(
        bodies=["fan"],
        frequency_ratio=1.0,
        speed_rpm=np.array([0.0, 1000.0]),
        motion_m={},
        force_n={"A": np.array([0.0, 2.0]), "C": np.array([0.0, 1e-14])},
    )
    assert [curve.name for curve in force_chart([curves]).marks(Curve)] == ["A"]


MARGIN = {
    "shaft": "a",
    "whirl": "forward",
    "amplification_factor": 10.0,
    "position": "below",
    "margin": -0.5,
    "required": 0.15,
    "verdict_15_percent": "ok",
    "verdict_20_percent": "ok",
}


def margins(count, missed):
    rows = []
    for k in range(count):
        exciters = [] if k == 3 else ["unbalance"]
        own = {"critical_speed_rpm": 100.0 * k, "exciters": exciters, "kind": "lateral"}
        own["excited_why"] = "orbits are circles that turn against the shaft"
        rows.append(MARGIN | own | {"verdict_api_617": "inside margin" if k in missed else "ok"})
    return {
        "operating": [{"shaft": "a", "from_rpm": 900.0, "to_rpm": 1100.0}],
        "verdict": {"method": "api617", "passed": not missed, "why": "because", "percent": None},
        "margins": rows,
        "critically_damped": [MARGIN | {"critical_speed_rpm": 5.0, "whirl": None}],
    }


def test_margins_begin_with_the_verdict_of_the_chosen_method():
    text, chart, table, rest, damped = margin_blocks("m", margins(30, {4, 7}))
    assert isinstance(chart, ChartRecord)
    assert text.kind == "warning" and text.text == "**FAIL by API 617** (`m`): because."
    assert len(table.rows) == 29 and table.folded == "Separation margins (29)"
    assert [row[1] for row in rest.rows] == ["300.0"] and "not judged (1)" in rest.folded
    assert "against the shaft" in rest.rows[0][-1]
    assert len(damped.rows) == 1 and damped.folded
    text, _, table, *_ = margin_blocks("m", margins(12, set()))
    assert text.kind == "plain" and text.text.startswith("**Pass by API 617**")
    assert len(table.rows) == 11 and not table.folded
    none = margins(0, set()) | {"critically_damped": []}
    none["verdict"] |= {"method": "percent", "percent": 15.0}
    (text,) = margin_blocks("m", none)
    assert text.text.startswith("**Pass by a margin of 15 %**")


def test_margins_are_those_of_the_exciting_shaft():
    """Shaft b turns at half the speed of the reference shaft and runs at 400 to 500 rpm."""
    operating = (Operating("a", 2000.0, 2000.0, 1.0), Operating("b", 400.0, 500.0, 0.5))
    assert margin_text(1500.0, ["a"], operating) == "25.0 % below a"
    assert margin_text(900.0, ["b"], operating) == "**inside** b"
    assert margin_text(1500.0, ["b"], operating) == "50.0 % above b"
    assert margin_text(1500.0, ["a", "b"], operating) == "25.0 % below a"
    assert margin_of(1500.0, ("a", "b"), operating) == (pytest.approx(-0.25), "a")
    assert margin_of(900.0, ("b",), operating) == (0.0, "b")
    assert margin_text(1500.0, ["c"], operating) is None
    assert margin_words(1e-5) == "less than 0.1 % above"


def test_summary_has_the_verdict_and_the_margins(laval):
    run = everything()
    found = summary.section(run)
    row = next(b for b in found.blocks if isinstance(b, Row))
    table, chart, picture = row.blocks
    assert isinstance(chart, Chart) and isinstance(picture, Picture)
    assert picture.data.startswith("<svg")
    about = [cells[0] for cells in table.rows]
    assert about[0] == "Stability" and {"Accuracy", "Checks", "Separation margins"} <= {*about}
    table = next(b for b in found.every_block if getattr(b, "title", "") == "Critical speeds")
    assert table.head[-1] == "margin"
    assert any("below lp" in row[-1] for row in table.rows)
    # without operating speeds there is no such column
    blocks = summary.section(laval).every_block
    assert (
        "margin" not in next(b for b in blocks if getattr(b, "title", "") == "Critical speeds").head
    )


def test_first_screen_comes_before_notes_and_inputs(laval):
    names = [s.name for s in sections_of(laval)]
    assert names[0] == "summary"
    assert names.index("inputs") > names.index("critical-speeds") > names.index("campbell")
    html = page_of(laval)
    assert html.index("<strong>Notes</strong>") > html.index('id="critical-speeds"')
    # nothing of the verdict is computed for the page: it shows what stands in the document
    document = copy.deepcopy(laval.document)
    document["verdict"]["unstable_intervals"] = [
        {"from_rpm": 1234.0, "to_rpm": 2000.0, "closes": False, "kind": "divergence",
         "whirl": None, "frequency_hz": 0.0}
    ]  # fmt: skip
    assert "unstable from 1234 rpm" in page_of(replace(laval, document=document))


def law(name, xx, yy, cross=0.0, damping=1.0):
    """A bearing with a law from 0 to 1000 rpm, straight between the values at the ends."""
    stiffness = np.array([[[x, cross], [-cross, y]] for x, y in zip(xx, yy, strict=True)])
    whole = np.zeros((len(xx), 6, 6))
    whole[:, :2, :2] = stiffness
    return Law(
        bearing=name,
        law="lee",
        speed_rpm=np.array([0.0, 1000.0]),
        stiffness=stiffness,
        damping=np.array([np.eye(2), damping * np.eye(2)]),
        range_rpm=(100.0, 5000.0),
        whole=whole,
    )


def test_bearings_with_the_same_law_share_a_curve():
    same, other = ([1e7, 2e7], [1e7, 2e7]), ([1e7, 2e7], [3e7, 4e7])
    laws = [law("A", *same), law("B", *same), law("C", *other)]
    chart = law_chart([(own, own.stiffness) for own in laws], "Stiffness", "N/m")
    curves = chart.marks(Curve)
    assert [curve.name for curve in curves] == [
        "A xx and yy, B xx and yy, C xx (lee)",
        "C yy (lee)",
    ]
    np.testing.assert_allclose(curves[1].y, [30.0, 40.0])


def test_a_law_shows_cross_terms_its_range_and_negative_damping():
    own = law("A", [1e7, 1e7], [1e7, 1e7], cross=2e6, damping=-1.0)
    stiffness = law_chart([(own, own.stiffness)], "Stiffness", "N/m")
    names = [curve.name for curve in stiffness.marks(Curve)]
    assert names == ["A xx and yy (lee)", "A xy (lee)", "A yx (lee)"]
    assert len({curve.look.dash for curve in stiffness.marks(Curve)}) == 3
    (span,) = stiffness.marks(Span)
    assert (span.name, span.low, span.high) == ("range of lee", 100.0, 1000.0)
    _, negative = law_chart([(own, own.damping)], "Damping", "N s/m").marks(Span)
    assert negative.is_hatched and negative.low == negative.high == 1000.0


def test_what_is_not_applicable_is_said_once_for_each_reason():
    checks = [
        undecided(name, where, "", reason)
        for name, where, reason in (
            ("a", "rest", "damping"), ("b", "rest", "no factor"), ("c", "speed", "damping"),
        )
    ]  # fmt: skip
    assert list(reasons(checks)) == ["- damping: a (rest); c (speed)", "- no factor: b (rest)"]
    # names stand in brackets before a number
    assert entitled("Orbits", "second") == "Orbits (second)"
    assert entitled("Peaks (12)", "second") == "Peaks (second, 12)"
    assert entitled("Orbits", "") == "Orbits" and entitled("", "second") == ""


def test_one_body_has_no_chart_of_kinetic_energy(laval):
    charts = {b.name for b in shapes.section(laval).blocks if isinstance(b, Chart)}
    assert "shares-strain" in charts and "shares-kinetic" not in charts
    charts = {b.name for b in shapes.section(everything()).blocks if isinstance(b, Chart)}
    assert {"shares-strain", "shares-kinetic"} <= charts


def test_marks_at_the_edge_are_whole():
    points = {"x": np.zeros(1), "y": np.ones(1)}
    looks = [Look("@ink", "", "circle"), Look("@ink", "solid", "circle"), Look("@ink")]
    axis = Axis(label="x")
    curves = [Curve(**points, look=look) for look in looks]
    chart = page_chart(ChartRecord(name="c", title="", x=axis, y=axis, parts=curves))
    assert [t.get("cliponaxis") for t in chart.traces] == [False, False, None]


def test_coefficients_of_a_bearing_are_told_with_its_cross_terms():
    said = {
        "2e7 N/m": [[2e7, 0.0], [0.0, 2e7]],
        "2e7, 3e7 N/m": [[2e7, 0.0], [0.0, 3e7]],
        "±1.2e6 N/m cross": [[0.0, 1.2e6], [-1.2e6, 0.0]],
        "∓1.2e6 N/m cross": [[0.0, -1.2e6], [1.2e6, 0.0]],
        "2e7 N/m, 3e6 N/m cross": [[2e7, 3e6], [3e6, 2e7]],
        "2e7 N/m, 3e6, 1e6 N/m cross": [[2e7, 3e6], [1e6, 2e7]],
    }
    assert {text: matrix_text(np.array(m), "N/m") for text, m in said.items()} == {
        text: text for text in said
    }
    # a seal that only damps
    seal = BearingSpec(name="s", first="a.b", damping_n_s_per_m=600.0)
    assert stiffness_text(seal) == "600 N s/m"
