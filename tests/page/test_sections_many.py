"""Pages of engines with much of everything: what is shown first, folded, joined, left out."""

from __future__ import annotations

import numpy as np
from everything import everything

from solidwhirl.operating import Operating, nearest
from solidwhirl.page import shapes, summary
from solidwhirl.page.checks import _by_reason
from solidwhirl.page.margins import margin_blocks, margins_in_short
from solidwhirl.page.operating import margin_text, margin_words
from solidwhirl.page.records import Chart, Section, Table, Text
from solidwhirl.page.responses import force_chart, moving
from solidwhirl.page.sections import without_needless_names
from solidwhirl.page.stability import law_chart, stability_blocks
from solidwhirl.page.traces import line, marks, series_style


def speeds(*rpm):
    return [{"speed_rpm": float(v)} for v in rpm]


def test_summary_shows_the_critical_speeds_nearest_to_operation():
    # the second shaft turns at half the speed: 2000 rpm of its own are 4000 of the reference
    operating = (Operating("a", 900.0, 1100.0, 1.0), Operating("b", 2000.0, 2000.0, 0.5))
    found = speeds(100, 800, 1000, 1150, 2500, 3950, 5000)
    chosen, said = nearest(found, operating, 4)
    assert chosen == speeds(800, 1000, 1150, 3950)
    assert "4 of 7" in said and "nearest to the operating speeds" in said


def test_summary_shows_the_lowest_or_all():
    assert nearest(speeds(3, 1, 2), (), 3) == (speeds(3, 1, 2), "")
    chosen, said = nearest(speeds(3, 1, 2), (), 2)
    assert chosen == speeds(1, 2) and "lowest" in said


def test_amplitudes_that_are_rounding_are_left_out():
    found = moving({"fan": [0.0, 1.0, 2.0], "lp": [1e-12, 0.0, 1e-10], "hp": [1e-9, 1e-3, 0.0]})
    assert set(found) == {"fan", "hp"}
    np.testing.assert_array_equal(found["fan"], [np.nan, 1.0, 2.0])
    # 1e-9 of the largest, 2, is rounding
    np.testing.assert_array_equal(found["hp"], [np.nan, 1e-3, np.nan])
    assert moving({"still": [0.0, 0.0]}) == {}


def test_bearings_without_force_have_no_curve():
    entry = {
        "speed_rpm": [0.0, 1000.0],
        "exciters": [
            {"bodies": ["fan"], "bearing_force_n": {"A": [0.0, 2.0], "C": [0.0, 1e-14]}},
        ],
    }
    chart = force_chart("r", entry)
    assert [t["name"] for t in chart.traces] == ["A"]


def margins(count, missed):
    return {
        "operating": [{"shaft": "a", "from_rpm": 900.0, "to_rpm": 1100.0}],
        "margins": [
            {
                "shaft": "a",
                "critical_speed_rpm": 100.0 * k,
                "whirl": "forward",
                "amplification_factor": 10.0,
                "position": "below",
                "margin": -0.5,
                "required_api_617": 0.15,
                "verdict_api_617": "inside margin" if k in missed else "ok",
                "verdict_15_percent": "ok",
                "verdict_20_percent": "ok",
            }
            for k in range(count)
        ],
    }


def test_many_margins_are_folded_but_those_that_are_not_kept():
    chart, missed, every = margin_blocks("m", margins(30, {4, 7}))
    assert isinstance(chart, Chart)
    assert [row[1] for row in missed.rows] == ["400.0", "700.0"] and not missed.folded
    assert len(every.rows) == 30 and every.folded == "All separation margins (m, 30)"
    _, text, every = margin_blocks("m", margins(30, set()))
    assert isinstance(text, Text) and "all 30" in text.text
    _, table = margin_blocks("m", margins(12, {4}))
    assert isinstance(table, Table) and len(table.rows) == 12 and not table.folded


def test_margins_in_short():
    entry = margins(30, {4, 7})
    said = margins_in_short(entry)
    assert said.startswith(
        "**0 of 30 not kept** by 15 %, 2 by API 617 (nearest: 0 rpm, 50.0 % below"
    )
    assert margins_in_short(margins(30, set())).startswith("all 30 kept (nearest")
    entry["margins"][12] |= {"margin": 0.0, "verdict_15_percent": "inside margin"}
    said = margins_in_short(entry)
    assert said.startswith("**1 of 30 not kept** by 15 %, 2 by API 617")
    assert "nearest: 1200 rpm, inside the operating range of a" in said
    assert "no critical speed" in margins_in_short({"margins": []})


def test_margins_are_those_of_the_exciting_shaft():
    """Shaft b turns at half the speed of the reference shaft and runs at 400 to 500 rpm."""
    operating = (Operating("a", 2000.0, 2000.0, 1.0), Operating("b", 400.0, 500.0, 0.5))
    assert margin_text(1500.0, ["a"], operating) == "25.0 % below a"
    assert margin_text(900.0, ["b"], operating) == "**inside** b"
    assert margin_text(1500.0, ["b"], operating) == "50.0 % above b"
    assert margin_text(1500.0, ["a", "b"], operating) == "25.0 % below a"
    assert margin_text(1500.0, ["c"], operating) is None
    assert margin_words(1e-5) == "less than 0.1 % above"


def test_summary_has_the_margins(laval):
    run = everything()
    tables = {b.head[0]: b for b in summary.section(run).blocks if isinstance(b, Table)}
    rows = dict(tables["at a glance"].rows)
    assert "not kept" in rows["Separation margins"]
    table = tables["speed [rpm]"]
    assert table.head[-1] == "margin"
    assert any("below lp" in row[-1] for row in table.rows)
    # without operating speeds there is no such column
    plain = {b.head[0]: b for b in summary.section(laval).blocks if isinstance(b, Table)}
    assert "margin" not in plain["speed [rpm]"].head


def test_bearings_with_the_same_law_share_a_curve():
    rpm = [0.0, 1000.0]
    same, other = [[1e7, 1e7], [2e7, 2e7]], [[1e7, 3e7], [2e7, 4e7]]
    bearings = {
        name: {"law": "lee", "speed_of_its_rotor_rpm": rpm, "stiffness_n_per_m": values}
        for name, values in {"A": same, "B": same, "C": other}.items()
    }
    chart = law_chart("laws", bearings, "Stiffness", "stiffness_n_per_m", "N/m")
    assert [t["name"] for t in chart.traces] == [
        "A xx and yy, B xx and yy, C xx (lee)",
        "C yy (lee)",
    ]
    np.testing.assert_allclose(chart.traces[1]["y"], [30.0, 40.0])


def test_no_curve_of_decrements_that_are_all_zero():
    entry = {
        "speed_rpm": [0.0, 1000.0],
        "smallest_log_decrement": [0.0, 1e-14],
        "frequency_hz": [10.0, 10.0],
        "largest_growth_rate_per_s": [0.0, 0.0],
        "growing_motions": [0, 0],
        "threshold": None,
    }
    (text,) = stability_blocks("s", entry)
    assert "No motion grows up to 1000 rpm" in text.text and "nothing damps" in text.text
    entry["smallest_log_decrement"] = [0.0, 1e-3]
    assert len(stability_blocks("s", entry)) == 2


def test_what_was_not_decided_is_said_once_for_each_reason():
    checks = [
        {"name": "a", "where": "rest", "reason": "damping"},
        {"name": "b", "where": "rest", "reason": "no factor"},
        {"name": "c", "where": "speed", "reason": "damping"},
    ]
    assert list(_by_reason(checks)) == ["- damping: a (rest); c (speed)", "- no factor: b (rest)"]


def test_names_that_say_no_more_than_the_kind_are_left_out():
    chart = Chart(name="c", title="Orbits (stability)", caption="", alt="", traces=[], layout={})
    table = Table(head=["a"], rows=[], title="T (second)", folded="Peaks (stability, 12)")
    section = Section(name="s", title="S", blocks=[chart, table, Text(text="(stability)")])
    kept = without_needless_names(section, {"stability": "stability", "second": "stability"})
    assert [b.title for b in kept.blocks[:2]] == ["Orbits (stability)", "T (second)"]
    kinds = {"stability": "stability", "second": "run_up"}
    told = without_needless_names(section, kinds)
    assert [b.title for b in told.blocks[:2]] == ["Orbits", "T (second)"]
    assert told.blocks[1].folded == "Peaks (12)" and told.blocks[2].text == "(stability)"


def test_one_body_has_no_chart_of_kinetic_energy(laval):
    charts = {b.name for b in shapes.section(laval).blocks if isinstance(b, Chart)}
    assert "shares-strain" in charts and "shares-kinetic" not in charts
    charts = {b.name for b in shapes.section(everything()).blocks if isinstance(b, Chart)}
    assert {"shares-strain", "shares-kinetic"} <= charts


def test_marks_at_the_edge_are_whole():
    style = series_style(0)
    assert marks([0.0], [1.0], "m", style)["cliponaxis"] is False
    assert line([0.0], [1.0], "l", style, mode="lines+markers")["cliponaxis"] is False
    assert "cliponaxis" not in line([0.0], [1.0], "l", style)
