"""Curves of the page against the results: Campbell, critical speeds, responses, run-up, models."""

from __future__ import annotations

import warnings
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from everything import everything
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from solidwhirl.analyses.kinds.rotating_campbell import frames_of, own_branches
from solidwhirl.analyses.kinds.stability import stability_blocks
from solidwhirl.analyses.kinds.state_space import responses as responses_of_model
from solidwhirl.analyses.kinds.state_space import stored_model
from solidwhirl.analyses.responses.run_up import beyond, response_peaks
from solidwhirl.analyses.responses.unbalance_response import exciters_of
from solidwhirl.core.blocks import numbers
from solidwhirl.page.frame.plotly_chart import coarser, page_chart
from solidwhirl.page.modes import campbell, criticals
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.campbell import (
    CampbellView,
    campbell_chart,
    error_words,
    excitation_lines,
)
from solidwhirl.rotordyn.plots.chart import Curve, whirl_name, whirl_runs
from solidwhirl.rotordyn.plots.modes import frame_curves, with_zero
from solidwhirl.rotordyn.plots.response import (
    amplitude_chart,
    force_chart,
    orbit_chart,
    unwrapped,
)
from solidwhirl.rotordyn.plots.run_up import envelope


def _shown(kind):
    """Blocks of a kind of analysis by the name or title that they have on the page."""
    blocks = everything().results.analyses[kind].blocks()
    return {getattr(b, "name", getattr(b, "title", "")): b for b in blocks}


def _drawn(kind, name):
    """A chart of a kind of analysis as plotly is given it."""
    return page_chart(_shown(kind)[name], kind)


WHIRLS = st.sampled_from(["forward", "backward", "mixed", "straight", "torsional", "axial", None])


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(whirl=st.lists(WHIRLS, min_size=2, max_size=12))
def test_runs_of_whirl_cover_every_step_once(whirl):
    steps = [None] * (len(whirl) - 1)
    for run in whirl_runs(whirl):
        for k in range(run.first, run.last):
            assert steps[k] is None
            steps[k] = run.whirl
    # a step has the whirl of its faster end, or of the other where the branch has ended
    assert steps == [b or a for a, b in pairwise(whirl)]


def _page_campbell():
    results = everything().results
    return page_chart(campbell_chart(results.campbell, campbell.view_of(results)))


def test_campbell_has_every_point_of_every_branch_in_the_line_of_its_whirl():
    document = everything().document
    lines = {t["name"]: t for t in _page_campbell().traces}
    found = document["campbell"]
    columns = (found[key] for key in ("frequency_hz", "whirl", "critically_damped"))
    for branch in zip(*columns, strict=True):
        for k, (rpm, f, w, damped) in enumerate(zip(found["speed_rpm"], *branch, strict=True)):
            if f is None or w not in ("forward", "backward") or k == 0:
                continue
            own = lines["critically damped" if damped else whirl_name(w)]
            assert ((own["x"] == rpm) & (own["y"] == f)).any(), (rpm, f, w)


def test_critical_speeds_lie_on_the_excitation_lines():
    run = everything()
    ratios = run.results.scene.speed_ratios()
    traces = _page_campbell().traces
    (rings,) = (t for t in traces if t["name"] == "critical speed")
    (rest,) = (t for t in traces if t["name"] == "crossing, not excited")
    every = run.document["critical_speeds"]
    found = [c for c in every if c["excited"]]
    assert len(rings["x"]) == len(found) > 1
    assert len(rest["x"]) == len(every) - len(found)
    lines = [m for m in excitation_lines(ratios, 9000.0, 1000.0).marks if isinstance(m, Curve)]
    slopes = {round(c.y[1] / c.x[1] * 60.0, 9) for c in lines}
    assert slopes == {1.0, 0.4}
    for x, y, c in zip(rings["x"], rings["y"], found, strict=True):
        # to the accuracy with which the meeting is found
        assert y == pytest.approx(abs(ratios[c["shafts"][0]]) * x / 60.0, rel=1e-6)


def test_excitation_lines_end_at_the_frame_and_one_ratio_is_drawn_once():
    marks = excitation_lines({"a": 1.0, "b": -1.0, "c": 10.0, "d": 0.0}, 6000.0, 200).marks
    assert [(c.x[1], c.y[1]) for c in marks[::2]] == [(6000.0, 100.0), (1200.0, 200.0)]
    assert [label.text for label in marks[1::2]] == ["1× a, b", "10× c"]


def _branches(hertz, whirl, decrement=0.1):
    """Branches over 0, 1000, ... rpm."""
    hertz = np.array(hertz, dtype=float)
    decrement = np.broadcast_to(decrement, hertz.shape)
    rates = 2.0 * np.pi * hertz * (1j - decrement / (2.0 * np.pi))
    return Campbell(
        speeds_rad_s=1000.0 / RPM_PER_RAD_S * np.arange(hertz.shape[1]),
        eigenvalues=rates,
        frequency_hz=hertz,
        log_decrement=decrement,
        whirl=np.array(whirl),
        shares=np.broadcast_to([1.0, 0.0, 0.0, 0.0], (*hertz.shape, 4)),
        overlap=np.ones(hertz.shape),
        notes=(),
    )


def _view(**changes):
    return CampbellView(excitation_ratios={"a": 1.0}, operating_rad_s={}, **changes)


def test_error_band_is_the_branch_times_one_plus_minus_its_error():
    diagram = _branches([[10, 12, np.nan], [20, 19, 18]], [["forward"] * 3] * 2)
    error = np.array([[0.01, 0.02, np.nan], [0.1, 0.1, 0.1]])
    chart = page_chart(campbell_chart(diagram, _view(errors=error)))
    band = next(t for t in chart.traces if t["name"] == "error band, 10 times as wide")
    first, second = np.split(band["y"], np.flatnonzero(np.isnan(band["y"])))
    np.testing.assert_allclose(first, [11.0, 14.4, 9.6, 9.0, 11.0])
    # ten times 10 % reaches zero, not below
    np.testing.assert_allclose(second[1:], [40.0, 38.0, 36.0, 0.0, 0.0, 0.0, 40.0])
    # errors below rounding are not given digits
    assert error_words(3e-11) == "below ±0.0001 %"
    assert error_words(0.0123) == "±1.2 %"
    assert error_words(None) == "not known"


def test_frames_are_the_shifted_frequencies_of_the_diagram():
    """A circle of order μ at f is seen at |f sign(μ) − |μ| n Ω/60| from a body that turns n Ω."""
    document = everything().document
    entry = document["analyses"]["rotating_campbell"]
    inertial = {key: numbers(document["campbell"][key]) for key in ("speed_rpm", "frequency_hz")}
    found = zip(entry["bodies"].values(), frames_of(entry), strict=True)
    for frame, curves in found:
        ratio = frame["speed_ratio"]
        for curve in frame_curves(curves):
            with_spin = curve.name == "turns with the spin"
            for rpm, f, text in zip(curve.x, curve.y, curve.texts, strict=True):
                at = np.flatnonzero(np.isclose(ratio * inertial["speed_rpm"], rpm, rtol=1e-12))
                if not np.isfinite(f) or not at.size or f == 0.0:
                    continue
                order = int(text.rsplit(" ", 1)[1])
                branch = int(text.split()[1].rstrip(",")) - 1
                own = inertial["frequency_hz"][branch, at[0]]
                signed = own if order == 0 else np.sign(order) * own - abs(order) * rpm / 60.0
                assert f == pytest.approx(abs(signed), rel=1e-9)
                assert with_spin == (signed > 0.0)


def test_frames_draw_the_lowest_own_branches_at_first():
    """The others wait in the legend; without numbers of branches nothing waits."""
    entry = everything().document["analyses"]["rotating_campbell"]
    assert not any(c.is_quiet for f in frames_of(entry) for c in frame_curves(f))
    lp, hp = frames_of({**entry, "branches": [2, 1]})
    energy = np.array(
        [
            np.nanmean(numbers(b["share_of_kinetic_energy"]), axis=1)
            for b in entry["bodies"].values()
        ]
    )
    for frame, own, count in ((lp, energy[0] >= energy[1], 2), (hp, energy[1] > energy[0], 1)):
        wanted = np.flatnonzero(own)[:count]
        shown = {int(c.texts[0].split()[1].rstrip(",")) - 1 for c in frame_curves(frame)
                 if not c.is_quiet}  # fmt: skip
        assert shown <= set(wanted.tolist()) and shown


def test_torsion_is_apart_from_branches_that_bend():
    def frame(energy, share):
        return {
            "orders": [1, -1, 0],
            "share_of_kinetic_energy": [[e, e] for e in energy],
            "share": [[[s, s] for s in row] for row in share],
        }

    lp = frame([0.9, 0.7, 0.2], [[0.8, 0.0, 0.1], [0.2, 0.0, 0.9], [0.0, 1.0, 0.0]])
    hp = frame([0.1, 0.3, 0.8], [[0.5, 0.0, 0.6], [0.5, 0.0, 0.4], [0.0, 1.0, 0.0]])
    found = own_branches({"lp": lp, "hp": hp})
    assert {body: [own.tolist() for own in two] for body, two in found.items()} == {
        "lp": [[0], [1]],
        "hp": [[2], []],
    }


def test_a_line_through_zero_has_a_point_there():
    x, y = with_zero(np.array([0.0, 1.0, 2.0, 3.0]), np.array([3.0, 1.0, -1.0, np.nan]))
    np.testing.assert_allclose(x, [0.0, 1.0, 1.5, 2.0, 3.0])
    np.testing.assert_allclose(y, [3.0, 1.0, 0.0, -1.0, np.nan])


def test_critical_speed_table_gives_the_speed_of_the_exciting_shaft():
    run = everything()
    table = criticals.critical_speed_table(
        run.document["critical_speeds"], run.results.scene.speed_ratios()
    )
    at = list(table.head).index("exciting shaft [rpm]")
    for row in table.rows:
        # 60 f is the speed of a shaft whose unbalance meets f
        assert float(row[at]) == pytest.approx(60.0 * float(row[at + 1]), rel=1e-3)


def test_maps_have_the_numbers_of_the_document():
    analyses = everything().document["analyses"]
    rigid = next(
        t["y"]
        for t in _drawn("critical_speed_map", "map").traces
        if t["name"] == "with rigid bearings"
    )
    lowest = min(
        b[-1] for b in analyses["critical_speed_map"]["shaft_speed_rpm"] if b[-1] is not None
    )
    # 1e9 N/m is some ten times stiffer than the shaft: near the limit with rigid bearings
    assert np.nanmin(np.abs(rigid / lowest - 1.0)) < 0.05
    space = _drawn("waterfall", "waterfall")
    unit = {"nm": 1e9, "µm": 1e6, "mm": 1e3}[space.layout["scene"]["zaxis"]["title"]["text"][-3:-1]]
    highest = unit * np.max(analyses["waterfall"]["highest_m"])
    assert np.nanmax(space.traces[0]["z"]) == pytest.approx(highest)
    chosen = analyses["stiffness_study"]["chosen_stiffness_n_per_m"]
    _, line, band = _drawn("stiffness_study", "stiffness").traces[:3]
    assert set(line["y"]) == {chosen}
    # 20 % around 8000 rpm
    ends = np.nanmin(band["x"]), np.nanmax(band["x"])
    assert ends == pytest.approx((0.8 * 8000.0 / 60.0, 1.2 * 8000.0 / 60.0))


def test_amplitudes_and_forces_are_those_of_the_document():
    entry = everything().document["analyses"]["unbalance_response"]
    exciters = exciters_of(entry)
    chart = page_chart(amplitude_chart(exciters), "r")
    factor = {"µm": 1e6, "mm": 1e3, "nm": 1e9}[chart.layout["yaxis"]["title"]["text"][-3:-1]]
    curves = [t for t in chart.traces if t["mode"] == "lines"]
    wanted = [p for e in entry["exciters"] for p in e["places"].values()]
    assert len(curves) == len(wanted) == 4
    for curve, place in zip(curves, wanted, strict=True):
        np.testing.assert_allclose(curve["y"][1:], factor * np.array(place["major_m"][1:]))
        assert np.isnan(curve["y"][0])  # nothing moves at rest, and zero has no logarithm
    forces = page_chart(force_chart(exciters), "r")
    shown = [t for t in forces.traces if t["mode"] == "lines"]
    assert len(shown) == sum(len(e["bearing_force_n"]) for e in entry["exciters"])


def test_orbits_are_the_ellipses_of_the_document():
    entry = everything().document["analyses"]["unbalance_response"]
    row = int(np.abs(np.array(entry["speed_rpm"]) - 3000.0).argmin())
    record = orbit_chart([(e, [row]) for e in exciters_of(entry)])
    assert record is not None
    chart = page_chart(record, "r")
    option = chart.controls[0].options[0]
    assert option.label.startswith("3000 rpm, unbalance of fan")
    for name, place in entry["exciters"][0]["places"].items():
        own = [chart.traces[k] for k in option.traces]
        at = next(k for k, t in enumerate(own) if t["name"].startswith(name))
        path, mark = own[at : at + 2]
        radius = np.hypot(path["x"], path["y"])
        # the path has points every 5°
        unit = place["major_m"][row] / radius.max()
        assert radius.min() * unit == pytest.approx(abs(place["minor_m"][row]), rel=5e-3)
        assert round(-np.log10(unit)) % 3 == 0
        turn = path["x"][0] * path["y"][1] - path["y"][0] * path["x"][1]
        assert (turn > 0.0) == (place["orbit"][row] == "forward")
        assert (mark["x"][0], mark["y"][0]) == (path["x"][0], path["y"][0])
        assert path["line"]["dash"] == {"forward": "solid", "backward": "dash"}[place["orbit"][row]]


def test_phase_has_no_line_across_its_range():
    x, phase = unwrapped(np.arange(4.0), np.array([170.0, -175.0, -100.0, 90.0]))
    np.testing.assert_allclose(phase, [170.0, np.nan, -175.0, -100.0, np.nan, 90.0])
    np.testing.assert_allclose(x, [0.0, np.nan, 1.0, 2.0, np.nan, 3.0])


@settings(max_examples=40, deadline=None)
@given(
    values=st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=400),
    columns=st.integers(2, 60),
)
def test_envelope_holds_the_whole_signal(values, columns):
    signal = np.array(values)
    times = np.linspace(0.0, 1.0, signal.size)
    middle, low, high = envelope(times, signal, columns)
    assert high.max() == signal.max() and low.min() == signal.min()
    assert (low <= high).all() and (np.diff(middle) > 0.0).all()
    # neighbours meet: a line drawn through the signal lies inside
    assert (np.maximum(low[1:], low[:-1]) <= np.minimum(high[1:], high[:-1])).all()


def test_run_up_shows_its_largest_force_and_peaks():
    entry, force = everything().document["analyses"]["run_up"], _drawn("run_up", "mount")
    unit = force.layout["yaxis"]["title"]["text"].split("[")[1].rstrip("]")
    factor = {"N": 1.0, "kN": 1e-3}[unit]
    drawn = max(np.abs(t["y"]).max() for t in force.traces[:2])
    # the largest force along one direction is at most that of both together
    assert drawn <= factor * entry["largest_mount_force_n"] * (1 + 1e-12)
    assert drawn >= factor * entry["largest_mount_force_n"] / np.sqrt(2.0)
    lines, rings = _drawn("run_up", "spectrum").traces
    step = lines["x"][1] - lines["x"][0]
    for at, height in zip(rings["x"], rings["y"], strict=True):
        near = lines["y"][np.abs(lines["x"] - at) <= 2.0 * step]
        # a peak lies between lines, of which the highest is not much lower
        assert 0.7 * height < near.max() <= 1.05 * height
    ends = [t["y"][-1] for t in _drawn("run_up", "spectrogram").traces[1:]]
    assert ends == pytest.approx([6000.0 / 60.0, 0.4 * 6000.0 / 60.0])


@settings(max_examples=30, deadline=None)
@given(rows=st.integers(1, 500), columns=st.integers(1, 1500), seed=st.integers(0, 99))
def test_coarser_maps_keep_their_largest_value(rows, columns, seed):
    values = np.random.default_rng(seed).random((rows, columns))
    x, y, found = coarser(np.arange(columns * 1.0), np.arange(rows * 1.0), values)
    assert found.shape == (len(y), len(x)) and found.size <= 600 * 200
    assert found.max() == values.max()
    assert x[0] == 0.0 and y[0] == 0.0


def _stability(**more):
    first = {"log_decrement": [None, 0.2, -0.1], "frequency_hz": [40.0, 41.0, 42.0]}
    none = {"log_decrement": [None] * 3, "frequency_hz": [None] * 3}
    return {
        "speed_rpm": [0.0, 1000.0, 2000.0],
        "frequency_max_hz": 100.0,
        "smallest_log_decrement": [0.1, 0.1, -0.1],
        "frequency_hz": [40.0, 41.0, 42.0],
        "largest_growth_rate_per_s": [-1.0, -1.0, 1.0],
        "first_forward": first,
        "first_backward": none,
        "at_operating": [],
        "unstable_intervals": [],
    } | more


UNSTABLE = {
    "from_rpm": 1500.0, "to_rpm": 2000.0, "opens": True, "closes": False, "kind": "flutter",
    "largest_growth_rate_per_s": 1.0, "largest_growth_at_rpm": 2000.0, "frequency_hz": 41.0,
    "whirl": "forward",
}  # fmt: skip


def test_stability_is_told_by_speed():
    """A mode without damping is drawn at zero; where there is no such mode there is no point."""
    table, record = stability_blocks(_stability(unstable_intervals=[UNSTABLE]))
    chart = page_chart(record)
    assert table.rows[0][:4] == ["1500.0", "beyond the range", "flutter", "● forward"]
    shape, zero = chart.layout["shapes"]
    assert (shape["x0"], shape["x1"]) == pytest.approx((1500.0, 2000.0)) and zero["y0"] == 0.0
    text, record = stability_blocks(_stability())
    assert text.text == "Stable from 0 to 2000 rpm."
    chart = page_chart(record)
    assert len(chart.layout["shapes"]) == 1
    forward, backward, *_ = chart.traces
    np.testing.assert_array_equal(forward["y"], [0.0, 0.2, -0.1])
    assert np.isnan(backward["y"]).all()
    assert forward["name"] == "first forward mode" and "40" in forward["text"][0]
    assert chart.controls[0].options[0].traces == [0, 1]
    mode = {"log_decrement": 0.3, "frequency_hz": 40.0}
    own = {"shaft": "a", "shaft_speed_rpm": 1800.0, "stable": True}
    own |= {"first_forward": mode, "first_backward": {"log_decrement": None, "frequency_hz": 39.0}}
    _, table, _ = stability_blocks(_stability(at_operating=[own]))
    assert table.rows == [["a", "1800", True, 0.3, 40.0, None, 39.0]]


GAPPED = _branches(
    [[10, 11, np.nan, 13], [50, 60, 70, 900], [np.nan, np.nan, 5, 6]],
    [["forward", "forward", "", "forward"], ["backward"] * 4, ["", "", "forward", "forward"]],
)
DAMPED = np.array([[False] * 4, [False, True, True, True], [False] * 4])
ERRORS = np.where(DAMPED, 0.5, 1e-3) * np.where(np.isfinite(GAPPED.frequency_hz), 1.0, np.nan)


def test_what_is_critically_damped_has_a_faint_line():
    shown = _view(damped=DAMPED, errors=ERRORS, unstable_rad_s=[(1500.0 / RPM_PER_RAD_S, 200.0)])
    chart = page_chart(campbell_chart(GAPPED, shown))
    lines = {t["name"]: t["y"][np.isfinite(t["y"])] for t in chart.traces}
    np.testing.assert_array_equal(lines["critically damped"], [50.0, 60.0, 70.0, 900.0])
    assert lines["backward whirl"].max() == 50.0
    # neither the axis nor the largest error is theirs
    assert chart.layout["yaxis"]["range"][1] < 60.0
    assert "0.1 % at most" in chart.caption and "no resonance" in chart.caption
    assert chart.layout["shapes"][-1]["x0"] == pytest.approx(1500.0)
    assert "critically damped" in [c.label for c in chart.controls]


def test_critically_damped_speeds_are_folded_away(laval):
    names = ("speed_rpm", "frequency_hz", "whirl", "log_decrement", "amplification_factor")
    rows = [(600.0, 10.5, "forward", 0.1, 31.0), (2500.0, 60.0, "backward", 9.0, 0.5)]
    speeds = [
        {
            **dict(zip(names, row, strict=True)),
            "critically_damped": k == 1,
            "excited": True,
            "shafts": ["rotor"],
            "excited_by": ["rotor"],
            "shares": {"lateral": 1.0, "torsional": 0.0, "axial": 0.0, "disk": 0.0},
        }
        for k, row in enumerate(rows)
    ]
    document = laval.document | {"critical_speeds": speeds, "operating": [], "analyses": {}}
    chart, table, folded = criticals.section(replace(laval, document=document)).blocks
    assert [len(t["x"]) for t in chart.traces] == [1]
    assert [row[0] for row in table.rows] == ["600.0"] and not table.folded
    assert [row[0] for row in folded.rows] == ["2500.0"] and "no resonances (1)" in folded.folded


def test_gaps_of_branches_are_gaps_of_lines_and_bands():
    chart = page_chart(campbell_chart(GAPPED, _view(damped=DAMPED, errors=ERRORS)))
    lines = {t["name"]: t for t in chart.traces}
    forward = lines["forward whirl"]
    assert forward["connectgaps"] is False
    np.testing.assert_array_equal(np.isfinite(forward["y"][:4]), [True, True, False, True])
    band = lines["error band"]
    # from 1000 to 3000 rpm and back no band reaches over the gap
    pieces = np.split(band["x"], np.flatnonzero(np.isnan(band["x"])))
    spans = sorted((np.nanmin(p), np.nanmax(p)) for p in pieces)
    np.testing.assert_allclose(spans, [(0, 0), (0, 1000), (2000, 3000), (3000, 3000)])


def test_small_diagram_reaches_as_far_as_unbalance_does(laval):
    small = campbell.small_chart(replace(laval.results, campbell=GAPPED, estimates=None))
    assert small.layout["yaxis"]["range"][1] == pytest.approx(2.5 * 50.0)
    assert small.controls == () and "Higher modes" in small.caption


def test_model_responses_agree_with_those_by_solving():
    outcome = everything().results.analyses["state_space"]
    model = stored_model("state_space", outcome)
    hertz = np.array([3.0, 40.0, 75.0, 200.0])
    speed = float(model.speeds_rad_s[-1])
    found = responses_of_model(model, speed, hertz)
    a, b, c, d = model.at_speed(speed)
    rates = 2j * np.pi * np.asarray(hertz)
    exact = np.array([c @ np.linalg.solve(rate * np.eye(len(a)) - a, b) + d for rate in rates])
    # eigenvectors of a lightly damped engine are well conditioned
    np.testing.assert_allclose(found, exact, rtol=1e-6, atol=1e-9 * np.abs(exact).max())


def test_a_mass_free_to_drift():
    """x'' = f / m: |H| = 1 / (m ω²), from a matrix with one eigenvector."""
    mass = 2.0
    parts = (
        np.array([[0.0, 1.0], [0.0, 0.0]]),
        np.array([[0.0], [1.0 / mass]]),
        np.array([[1.0, 0.0]]),
        np.zeros((1, 1)),
    )
    hertz = np.array([0.5, 1.0, 20.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = responses_of_model(SimpleNamespace(at_speed=lambda speed: parts), 0.0, hertz)
    np.testing.assert_allclose(found[:, 0, 0], -1.0 / (mass * (2.0 * np.pi * hertz) ** 2))


def test_run_up_ends_at_the_fastest_excitation():
    """6000 rpm are 100 Hz: no peak is beyond, and the band from 60 to 140 Hz is said to be cut."""
    entry = everything().document["analyses"]["run_up"]
    response = entry["normalised_response"]
    assert all(p["frequency_hz"] < 100.5 for p in response["peaks"])
    table = response_peaks(response)
    assert len(table.rows) == len(response["peaks"]) > 1 and "to 100 Hz" in table.caption
    assert "no peak" in response_peaks({"peaks": [], "excited_hz": [1.0, 100.0]}).text
    said = beyond(entry["complexity"])
    assert "above 100 Hz: the band 60 to 140 Hz is compared" in said
    assert not beyond({"bands_hz": [[20, 60]], "excited_to_hz": 100.0})
