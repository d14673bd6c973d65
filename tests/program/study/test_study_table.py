"""Fronts, slopes and errors of a study on numbers whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solidwhirl.scene_reading.reader import parse_scene
from solidwhirl.study.cases import StudyCase, graded_sizes
from solidwhirl.study.report import Study, study_document, summary
from solidwhirl.study.table import Outcome, fitted, held_branches, pareto_front, study_table

FLOOR = 1e-7


@pytest.fixture
def outcome(small_scene, measurement):
    """Function: an outcome of a case with a known error."""
    scene = parse_scene(small_scene())

    def make(name, ladder, level="harmonic", **known):
        settings = {"level": level, "order": 2, "accuracy": 1e-6}
        case = StudyCase(name=name, ladder=ladder, settings=settings, scene=scene)
        return Outcome(case=case, status="done", measured=measurement(**known))

    return make


@pytest.fixture
def ladder(outcome):
    """Error, time and memory as power laws of the unknowns; the estimate twice the error."""
    out = [outcome("reference", "reference", estimate=FLOOR)]
    for k in range(4):
        ratio = 4.0**k
        error = 1e-2 * ratio**-1.5
        out.append(
            outcome(
                f"rung {k}",
                "graded",
                error=error,
                estimate=2.0 * error,
                unknowns=int(1000 * ratio),
                cpu_s=1.0 + 0.1 * ratio**1.2,
                memory_gib=0.1 + 0.02 * ratio**1.1,
            )
        )
    return out


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), max_size=30))
def test_front_by_its_definition(points):
    """Everything is beaten or equalled by a point of the front, and none of those by another."""
    cost, error = np.array(points, dtype=float).reshape(-1, 2).T
    front = pareto_front(cost, error)
    for k in range(len(points)):
        assert ((cost[front] <= cost[k]) & (error[front] <= error[k])).any()
    for k in front:
        others = [o for o in front if o != k]
        assert not ((cost[others] <= cost[k]) & (error[others] <= error[k])).any()


@pytest.mark.parametrize("slope", [-2.0, -0.5445, 1.15])
def test_slope_of_a_power_law(slope):
    points = [(x, 7.0 * x**slope) for x in (1e3, 3e3, 2e4, 1e5)]
    found = fitted("s", "error", points, 0)
    # rounding of the logarithms
    assert found.slope == pytest.approx(slope, rel=1e-12)
    assert found.factor == pytest.approx(7.0, rel=1e-10)
    assert found.scatter_log10 < 1e-12
    assert found.points == 4


def test_no_slope_without_three_points_over_a_factor_four():
    assert fitted("s", "error", [(1e3, 1.0), (1e5, 0.1)], 0) is None
    assert fitted("s", "error", [(1e3, 1.0), (2e3, 0.5), (3.9e3, 0.2)], 0) is None
    assert fitted("s", "error", [(1e3, 1.0), (2e3, 0.5), (4.1e3, 0.2)], 0) is not None


def test_table_finds_the_known_laws(ladder):
    """Errors relative to the truth, slopes as made, every rung on both fronts."""
    table = study_table(ladder)
    assert table.floor == FLOOR
    assert table.spans == {"harmonic": 64.0}
    names = tuple(f"rung {k}" for k in range(4))
    assert set(table.time_front) == set(table.memory_front) == set(names)
    for row, true in zip(table.rows[1:], 1e-2 * 4.0 ** (-1.5 * np.arange(4)), strict=True):
        assert row.campbell.true == pytest.approx(true, rel=1e-9)
        assert row.campbell.effectivity == pytest.approx(2.0, rel=1e-9)
        assert row.critical_speeds.true == pytest.approx(true, rel=1e-9)
        assert table.shown(row)
    slopes = {s.quantity: s.slope for s in table.slopes}
    expected = {"error": -1.5, "cpu_s": 1.2, "memory_gib": 1.1}
    assert slopes == pytest.approx(expected, rel=1e-6)


def test_short_ladder_is_shown_only_where_there_is_no_other(ladder, outcome, small_scene):
    def notes(outcomes):
        scene, table = parse_scene(small_scene()), study_table(outcomes)
        return Study(scene=scene, quick=True, outcomes=outcomes, table=table).notes

    alone = tuple(ladder[:3])
    table = study_table(alone)
    assert table.spans == {"harmonic": 4.0}
    assert all(table.shown(row) for row in table.rows[1:])
    assert notes(alone)[0].startswith("Level harmonic: its unknowns span a factor 4")
    beside = (*ladder, outcome("one", "graded", level="solid"))
    assert not study_table(beside).shown(study_table(beside).rows[-1])
    assert notes(beside)[0].startswith("Level solid is not shown: its unknowns span a factor 1")


def test_branch_that_is_far_off_has_no_error(ladder, outcome):
    table = study_table([*ladder, outcome("lost", "beam", "beam", error=0.5)])
    assert table.rows[-1].campbell.unmatched > 0
    assert not table.rows[-1].comparable


def test_errors_below_the_floor_are_not_told_apart(ladder, outcome):
    row = study_table([*ladder, outcome("fine", "graded", error=2e-7, estimate=1e-6)]).rows[-1]
    assert np.isnan(row.campbell.effectivity)
    assert row.campbell.true == pytest.approx(2e-7, rel=1e-6)


def test_free_motions_have_no_error(measurement):
    diagram = measurement().campbell
    frequency = np.array(diagram.frequency_hz)
    frequency[0] = 1e-9
    free = type(diagram)(
        **{n: getattr(diagram, n) for n in ("speeds_rad_s", "eigenvalues", "log_decrement")},
        **{n: getattr(diagram, n) for n in ("whirl", "shares", "overlap", "notes")},
        frequency_hz=frequency,
    )
    assert held_branches(free).tolist() == [False, True, True, True]


def test_document_and_summary_hold_what_the_table_does(ladder, small_scene):
    failed = Outcome(case=ladder[1].case, status="failed", message="no memory")
    outcomes = (*ladder, failed)
    scene = parse_scene(small_scene())
    study = Study(scene=scene, quick=False, outcomes=outcomes, table=study_table(outcomes))
    document = study_document(study)
    assert [c["status"] for c in document["cases"]] == ["done"] * 5 + ["failed"]
    assert document["cases"][1]["series"] == "harmonic, order 2, graded"
    assert document["notes"] == ["rung 0: failed, no memory"]
    assert {s["quantity"] for s in document["slopes"]} == {"error", "cpu_s", "memory_gib"}
    assert "| rung 3 | 64000 |" in summary(study, document)


def test_graded_sizes_halve_corner_errors_like_smooth_ones():
    """Corner error ~ h^1.089 falls by √2^2p where the smooth error h^2p does."""
    first, second = graded_sizes(1.0, 2, 0), graded_sizes(1.0, 2, 1)
    assert first["size_m"] / second["size_m"] == pytest.approx(2.0**0.5)
    ratio = first["corner_size_m"] / second["corner_size_m"]
    assert ratio**1.089 == pytest.approx(4.0, rel=2e-3)
