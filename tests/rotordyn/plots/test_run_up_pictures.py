"""Pictures of a run-up are written completely and show what they are given."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import connect, hub, turning

from solidwhirl.rotordyn import AnalysisError, assemble
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.plots.run_up import (
    force_chart,
    normalised_chart,
    spectrogram_chart,
    speed_chart,
    waterfall_chart,
)
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.force_spectrum import spectrogram
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.response import normalised_response
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold


@pytest.fixture(scope="module")
def run():
    ratios = {"inner": 1.0, "outer": -1.5, "frame": 0.0}
    held = (connect(b, f"{b}.hub", stiffness=1e5, damping=50, tilt=1e5) for b in ratios)
    system = assemble({b: turning(hub(), ratio) for b, ratio in ratios.items()}, tuple(held))
    unbalances = [Unbalance(body=b, interface="hub", moment_kg_m=1e-3) for b in ("inner", "outer")]
    return run_up(
        system, ramp_and_hold(200.0, 2.0, 1.0), unbalances, step_s=1e-3, bearings=["inner", "frame"]
    )


def test_run_up_shows_speeds_and_force(run, tmp_path, drawn):
    force = run.bearing_force_n("inner")
    charts = [
        speed_chart(run.time_s, run.speed_rad_s, run.speed_ratios),
        force_chart(run.time_s, force, "inner"),
    ]
    draw_charts(charts, tmp_path / "run.png", "Two spools")
    speeds, forces = drawn[0].axes
    assert [line.get_label() for line in speeds.lines] == ["speed of inner", "speed of outer"]
    ends = sorted(float(line.get_ydata()[-1]) for line in speeds.lines)
    np.testing.assert_allclose(ends, np.array([-300.0, 200.0]) * 30 / np.pi)
    # the band reaches the largest force, in the unit of its label
    assert "inner" in forces.get_ylabel()
    factor = {"kN": 1e-3, "N": 1.0, "mN": 1e3}[forces.get_ylabel().split("[")[1].rstrip("]")]
    along_x = forces.collections[0]
    top = max(v[1] for p in along_x.get_paths() for v in p.vertices)
    assert top == pytest.approx(factor * force[0].max(), rel=1e-6)


def test_responses_show_a_curve_for_each_model(run, tmp_path, drawn):
    response = normalised_response(run, "inner")
    shown = {"all modes": response.ratio, "no modes": np.full(response.ratio.shape, np.nan)}
    chart = normalised_chart(response.frequency_hz, shown)
    draw_charts([chart], tmp_path / "r.svg", "Two models")
    (axes,) = drawn[0].axes
    assert [line.get_label() for line in axes.lines] == list(shown)
    assert len({line.get_color() for line in axes.lines}) == 2
    # the unbalance of the outer spool passes through 1.5 times 200 rad/s
    assert axes.get_xlim() == pytest.approx((0.0, 300.0 / (2 * np.pi)), abs=0.5)


def test_spectrogram_shows_the_lines_of_the_spools(run, tmp_path, drawn):
    result = spectrogram(run.time_s, run.bearing_force_n("inner")[0], 0.3)
    chart = spectrogram_chart(result, run.time_s, run.speed_rad_s, run.speed_ratios, 60.0)
    draw_charts([chart], tmp_path / "s.png", "Force")
    axes = drawn[0].axes[0]
    assert sorted(t.get_text() for t in axes.texts) == ["1/rev of inner", "1/rev of outer"]
    # names stand where the lines leave the frame
    for text in axes.texts:
        ratio = {"1/rev of inner": 1.0, "1/rev of outer": 1.5}[text.get_text()]
        speed = run.profile.speed_rad_s(np.array([text.xy[0]]))[0]
        assert text.xy[1] == pytest.approx(ratio * speed / (2 * np.pi), rel=1e-9)
    ends = sorted(float(line.get_ydata()[-1]) for line in axes.lines)
    np.testing.assert_allclose(ends, np.array([200.0, 300.0]) / (2 * np.pi))


def test_waterfall_stands_where_the_frequency_is(tmp_path, drawn):
    """A tone of 40 Hz: every spectrum is highest there."""
    time = np.arange(0.0, 6.0, 1e-3)
    pieces = spectrogram(time, 3.0 * np.cos(2 * np.pi * 40.0 * time), 0.25)
    chart = waterfall_chart(pieces, 20.0 * pieces.time_s / 6.0)
    draw_charts([chart], tmp_path / "w.png", "t")
    (axes,) = drawn[0].axes
    curves = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert len(curves) == pieces.time_s.size >= 10
    for line in curves:
        # lines of a spectrum of 0.25 s are 4 Hz apart
        assert line.get_xdata()[np.argmax(line.get_ydata())] == pytest.approx(40.0, abs=2.0)
        # none leaves the frame
        assert line.get_ydata().max() <= axes.get_ylim()[1]
    # the shaft runs up by 200 rpm in a second
    (turns,) = (line for line in axes.lines if line.get_linestyle() != "-")
    np.testing.assert_allclose(turns.get_xdata(), 200.0 / 60.0 * turns.get_ydata())


def test_a_force_that_is_zero_has_no_spectrogram(run, tmp_path):
    still = spectrogram(run.time_s, np.zeros(run.time_s.size), 0.3)
    chart = spectrogram_chart(still, run.time_s, run.speed_rad_s, run.speed_ratios, 60.0)
    with pytest.raises(AnalysisError, match="the map is zero"):
        draw_charts([chart], tmp_path / "r.png", "t")
    assert not list(tmp_path.iterdir())
