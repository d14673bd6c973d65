"""Fronts, slopes and errors of a study on numbers whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solidwhirl.scene_file import parse_scene
from solidwhirl.study_document import Study, coupling_document, study_document, summary
from solidwhirl.study_fit import fit_slope, pareto_front
from solidwhirl.study_map import map_rows, map_scene
from solidwhirl.study_runner import CaseOutcome
from solidwhirl.study_settings import StudyCase, graded_sizes
from solidwhirl.study_styles import map_grid
from solidwhirl.study_table import study_table

TRUE_HZ = np.array([[100.0, 90.0], [100.0, 110.0], [300.0, 280.0], [300.0, 320.0]])
WHIRL = [["planar", "backward"], ["planar", "forward"]] * 2
FLOOR = 1e-7


def diagram(error, rows=4):
    return {
        "speed_rad_s": [0.0, 500.0],
        "frequency_hz": (TRUE_HZ[:rows] * (1.0 + error)).tolist(),
        "whirl": WHIRL[:rows],
    }


def critical(error):
    speed = 600.0 * (1.0 + error)
    return [{"speed_rad_s": speed, "frequency_hz": speed / (2.0 * np.pi), "whirl": "forward"}]


def outcome(name, group, error, *, estimate, series=("harmonic", 2, "graded"), **measured):
    level, order, ladder = series
    case = StudyCase(
        name=name,
        group=group,
        level=level,
        ladder=ladder,
        order=order,
        settings=measured.pop("settings", {"accuracy": 1e-6}),
        payload={},
    )
    result = {
        "campbell": diagram(error),
        "critical_speeds": critical(error),
        "estimates": {
            "campbell": np.full((4, 2), estimate).tolist(),
            "campbell_parts": {"mesh": estimate, "mode_truncation": 0.0},
            "critical_speeds": [estimate],
        },
        "startup_cpu_s": 1.0,
        "startup_memory_gib": 0.1,
        **measured,
    }
    return CaseOutcome(case=case, status="done", result=result)


def reference():
    truth = {"campbell": diagram(0.0), "critical_speeds": critical(0.0)}
    return outcome(
        "reference", "reference", 0.0, estimate=FLOOR, truth=truth, unknowns=1e6, cpu_s=100.0,
        peak_memory_gib=5.0, series=("harmonic", None, "adaptive"),
    )  # fmt: skip


def ladder(count=4):
    """Error, time and memory as power laws of the unknowns; the estimate twice the error."""
    out = [reference()]
    for k in range(count):
        unknowns = 1e3 * 4.0**k
        error = 1e-2 * (unknowns / 1e3) ** -1.5
        out.append(
            outcome(
                f"rung {k}",
                "mesh",
                error,
                estimate=2.0 * error,
                unknowns=unknowns,
                cpu_s=1.0 + 0.1 * (unknowns / 1e3) ** 1.2,
                peak_memory_gib=0.1 + 0.02 * (unknowns / 1e3) ** 1.1,
            )
        )
    return out


def test_front_is_what_no_other_point_beats():
    cost, error = [1.0, 2.0, 3.0, 4.0, 2.5, 5.0], [1e-1, 1e-2, 1e-2, 1e-4, 1e-3, np.nan]
    assert pareto_front(cost, error).tolist() == [0, 1, 4, 3]
    assert pareto_front([], []).tolist() == []


@given(
    st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), min_size=1, max_size=30),
)
def test_front_by_its_definition(points):
    """Everything is beaten or equalled by a point of the front, and none of those by another."""
    cost, error = np.array(points, dtype=float).T
    front = pareto_front(cost, error)
    for k in range(len(points)):
        assert ((cost[front] <= cost[k]) & (error[front] <= error[k])).any()
    for k in front:
        others = front[front != k]
        assert not ((cost[others] <= cost[k]) & (error[others] <= error[k])).any()


@pytest.mark.parametrize("slope", [-2.0, -0.5445, 1.15])
def test_slope_of_a_power_law(slope):
    x = np.array([1e3, 3e3, 2e4, 1e5])
    found = fit_slope(x, 7.0 * x**slope)
    # rounding of the logarithms
    assert found.slope == pytest.approx(slope, rel=1e-12)
    assert found.factor == pytest.approx(7.0, rel=1e-10)
    assert found.scatter_log10 < 1e-12
    assert found.points == 4


def test_spread_of_a_slope_against_numpy():
    """Standard error from the covariance that numpy's polynomial fit gives."""
    generator = np.random.default_rng(4)
    x = np.logspace(3, 5, 12)
    y = x**-1.5 * 10.0 ** generator.normal(0.0, 0.1, 12)
    found = fit_slope(x, y)
    fitted, covariance = np.polyfit(np.log10(x), np.log10(y), 1, cov=True)
    assert found.slope == pytest.approx(fitted[0], rel=1e-10)
    assert found.standard_error == pytest.approx(np.sqrt(covariance[0, 0]), rel=1e-10)
    assert abs(found.slope + 1.5) < 3.0 * found.standard_error


def test_no_slope_from_two_points_or_one_place():
    assert fit_slope([1.0, 2.0], [1.0, 2.0]) is None
    assert fit_slope([2.0, 2.0, 2.0], [1.0, 2.0, 3.0]) is None


def test_table_finds_rates_and_effectivity():
    table = study_table(ladder())
    rates = {s.quantity: s.slope for s in table.slopes}
    assert rates["error"].slope == pytest.approx(-1.5, abs=1e-6)
    # without the second and the 0.1 GiB of the program's start
    assert rates["cpu_s"].slope == pytest.approx(1.2, abs=1e-6)
    assert rates["memory_gib"].slope == pytest.approx(1.1, abs=1e-6)
    assert table.floor == FLOOR
    for row in table.rows[1:]:
        assert row.campbell.effectivity == pytest.approx(2.0, rel=1e-6)
        assert row.critical_speeds.effectivity == pytest.approx(2.0, rel=1e-6)
    assert table.time_front == ("rung 0", "rung 1", "rung 2", "rung 3")


def test_errors_at_the_floor_are_left_out_of_slopes_and_effectivity():
    """A case that is better than the reference can not be judged by it."""
    better = outcome(
        "better", "mesh", 0.5 * FLOOR, estimate=1e-6, unknowns=1e6, cpu_s=50.0, peak_memory_gib=3.0
    )
    worse_cost = outcome(
        "dearer", "mesh", 0.1 * FLOOR, estimate=1e-6, unknowns=2e6, cpu_s=60.0, peak_memory_gib=4.0
    )
    table = study_table([*ladder(), better, worse_cost])
    slope = next(s for s in table.slopes if s.quantity == "error")
    assert slope.left_out == 2
    assert slope.slope.slope == pytest.approx(-1.5, abs=1e-6)
    assert np.isnan(table.rows[-1].campbell.effectivity)
    # both are as good as the reference, so the cheaper one is on the front
    assert "better" in table.time_front
    assert "dearer" not in table.time_front


def test_no_slope_from_two_rungs():
    assert not study_table(ladder(2)).slopes


def test_branches_that_are_far_off_leave_a_case_out():
    far = outcome("far", "mesh", 0.6, estimate=0.1, unknowns=1e2, cpu_s=1.01, peak_memory_gib=0.11)
    row = study_table([*ladder(), far]).rows[-1]
    assert row.campbell.unmatched > 0
    assert not row.comparable


def test_documents_hold_the_table(small_scene):
    scene = parse_scene(small_scene())
    outcomes = ladder()
    skipped = CaseOutcome(
        case=StudyCase(
            name="huge", group="mesh", level="solid", ladder="graded", order=2, settings={},
            payload={},
        ),
        status="skipped",
        message="it would need about 900 GiB",
        result={},
    )  # fmt: skip
    outcomes.append(skipped)
    table = study_table(outcomes)
    study = Study(
        scene=scene, quick=False, outcomes=tuple(outcomes), table=table, notes=("a note",)
    )
    document = study_document(study)
    assert document["cases"][-1]["status"] == "skipped"
    assert document["cases"][-1]["campbell"]["relative_error"] is None
    assert document["cases"][1]["campbell"]["relative_error"] == pytest.approx(1e-2, rel=1e-9)
    text = summary(study, document)
    assert "- a note" in text
    assert "| harmonic, order 2, graded | error | -1.50 |" in text


def test_coupling_is_a_difference_of_models():
    pair = [
        outcome(
            f"coupling {c}", "coupling", e, estimate=1e-4, unknowns=1e3, cpu_s=2.0,
            peak_memory_gib=0.2, settings={"coupling": c, "interfaces": "a.left, a.right"},
        )
        for c, e in (("distributing", 0.0), ("rigid", 2e-2))
    ]  # fmt: skip
    table = study_table([reference(), *pair])
    found = coupling_document(table)
    assert np.allclose(found["rigid_over_distributing_minus_1"], 2e-2, rtol=1e-9)
    assert found["interfaces"] == ["a.left", "a.right"]
    assert not table.time_front  # a choice of model is on no front


def test_graded_sizes_fall_together():
    """Two rungs halve the largest size, and the corner's by 2 to the power 2p / 1.089."""
    first, third = graded_sizes(0.01, 3, 0), graded_sizes(0.01, 3, 2)
    assert third["size_m"] == pytest.approx(first["size_m"] / 2.0, rel=1e-12)
    assert first["corner_size_m"] / third["corner_size_m"] == pytest.approx(
        2.0 ** (6.0 / 1.0889), rel=1e-12
    )
    assert graded_sizes(0.01, 4, 40)["corner_size_m"] == pytest.approx(1e-7, rel=1e-12)


def test_map_points_are_where_they_say():
    rows = map_rows("webbed disk", 3)
    assert [r["y"] for r in rows] == pytest.approx([0.1, np.sqrt(0.08), 0.8], rel=1e-4)
    scene = map_scene("webbed disk", 0.02, 0.4, "beam")
    _, web, rim = scene["bodies"]["rotor"]["sections"]
    assert web["end_m"] - web["start_m"] == pytest.approx(0.02 * rim["outer_radius_m"])
    assert rim["end_m"] - rim["start_m"] == pytest.approx(0.4 * rim["outer_radius_m"])
    assert map_scene("webbed disk", 0.4, 0.2, "beam") is None


def test_map_grid_puts_points_into_cells():
    points = [
        {"x": 1.0, "y": 5.0, "status": "done", "relative_error": 0.02},
        {"x": 2.0, "y": 5.0, "status": "done", "relative_error": None},
        {"x": 1.0, "y": 6.0, "status": "absent"},
        {"x": 2.0, "y": 6.0, "status": "failed", "level": "beam", "message": "no"},
    ]
    x, y, error = map_grid(points)
    assert (x, y) == ([1.0, 2.0], [5.0, 6.0])
    assert error[0].tolist() == [0.02, 0.25]
    assert np.isnan(error[1]).all()
