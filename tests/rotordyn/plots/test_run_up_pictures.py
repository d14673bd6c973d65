"""Pictures of a run-up are written completely and show what they are given."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn import AnalysisError, Bearing, End, Rotor, assemble
from solidwhirl.rotordyn.plots.run_up import (
    draw_normalised_responses,
    draw_run_up,
    draw_spectrogram,
)
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.force_spectrum import spectrogram
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.response import NormalisedResponse, normalised_response
from solidwhirl.rotordyn.run_up.speed_profile import ramp_and_hold


@pytest.fixture(scope="module")
def run(hub):
    def held(body):
        return Bearing(
            name=body,
            first=End(body=body, interface="hub"),
            stiffness_n_per_m=1e5 * np.eye(2),
            damping_n_s_per_m=50 * np.eye(2),
            tilt_stiffness_n_m_per_rad=1e5 * np.eye(2),
        )

    rotors = {
        "inner": Rotor(element=hub(), speed_ratio=1.0),
        "outer": Rotor(element=hub(), speed_ratio=-1.5),
        "frame": Rotor(element=hub(), speed_ratio=0.0),
    }
    system = assemble(rotors, tuple(held(body) for body in rotors))
    unbalances = [Unbalance(body=b, interface="hub", moment_kg_m=1e-3) for b in ("inner", "outer")]
    return run_up(
        system, ramp_and_hold(200.0, 2.0, 1.0), unbalances, step_s=1e-3, bearings=["inner", "frame"]
    )


def test_run_up_shows_speeds_and_force(run, tmp_path, drawn):
    path = tmp_path / "run.png"
    draw_run_up(run, "inner", path, "Two spools")
    assert path.read_bytes()[:4] == b"\x89PNG"
    assert [p.name for p in tmp_path.iterdir()] == ["run.png"]
    speeds, in_x, _ = drawn[0].axes
    names = [line.get_label() for line in speeds.lines]
    assert names == ["speed of inner", "speed of outer"]
    ends = sorted(float(line.get_ydata()[-1]) for line in speeds.lines)
    np.testing.assert_allclose(ends, np.array([-300.0, 200.0]) * 30 / np.pi)
    # the band reaches the largest force, in the unit of its label
    assert "inner" in in_x.get_ylabel()
    factor = {"kN": 1e-3, "N": 1.0, "mN": 1e3}[in_x.get_ylabel().split("[")[1].rstrip("]")]
    top = max(v[1] for c in in_x.collections for p in c.get_paths() for v in p.vertices)
    assert top == pytest.approx(factor * run.bearing_force_n("inner")[0].max(), rel=1e-6)


def test_responses_show_a_curve_for_each_model(run, tmp_path, drawn):
    response = normalised_response(run, "inner")
    shown = {"all modes": response, "no modes": response}
    draw_normalised_responses(shown, tmp_path / "r.svg", "Two models", 40.0)
    (axes,) = drawn[0].axes
    assert [line.get_label() for line in axes.lines] == list(shown)
    assert len({line.get_color() for line in axes.lines}) == 2
    assert axes.get_xlim() == (0.0, 40.0)


def test_spectrogram_shows_the_lines_of_the_spools(run, tmp_path, drawn):
    result = spectrogram(run.time_s, run.bearing_force_n("inner")[0], 0.3)
    draw_spectrogram(result, run, tmp_path / "s.png", "Force", 60.0)
    axes = drawn[0].axes[0]
    assert sorted(t.get_text() for t in axes.texts) == ["1/rev of inner", "1/rev of outer"]
    # names stand where the lines leave the frame
    for text in axes.texts:
        ratio = {"1/rev of inner": 1.0, "1/rev of outer": 1.5}[text.get_text()]
        speed = run.profile.speed_rad_s(np.array([text.xy[0]]))[0]
        assert text.xy[1] == pytest.approx(ratio * speed / (2 * np.pi), rel=1e-9)
    ends = sorted(float(line.get_ydata()[-1]) for line in axes.lines)
    np.testing.assert_allclose(ends, np.array([200.0, 300.0]) / (2 * np.pi))


def test_pictures_of_nothing_are_refused(run, tmp_path):
    empty = NormalisedResponse(frequency_hz=np.arange(3.0), ratio=np.full(3, np.nan))
    with pytest.raises(AnalysisError, match="no response to draw"):
        draw_normalised_responses({"a": empty}, tmp_path / "r.png", "t")
    still = spectrogram(run.time_s, np.zeros(run.time_s.size), 0.3)
    with pytest.raises(AnalysisError, match="spectrogram is zero"):
        draw_spectrogram(still, run, tmp_path / "r.png", "t")
    with pytest.raises(AnalysisError, match="'nose' was not recorded"):
        draw_run_up(run, "nose", tmp_path / "r.png", "t")
    with pytest.raises(AnalysisError, match=r"suffix '.bmp'; allowed are"):
        draw_run_up(run, "inner", tmp_path / "r.bmp", "t")
    assert not list(tmp_path.iterdir())
