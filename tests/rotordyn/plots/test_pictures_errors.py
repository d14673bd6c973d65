"""Pictures of error estimates show what they are given."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from solidwhirl.rotordyn import AnalysisError, campbell, critical_speeds
from solidwhirl.rotordyn.estimates.campbell_errors import campbell_errors
from solidwhirl.rotordyn.estimates.critical_speed_errors import critical_speed_errors
from solidwhirl.rotordyn.plots.errors import draw_campbell_errors, draw_critical_speed_errors
from solidwhirl.rotordyn.superelement.residual_energy import PARTS

RPM = 30.0 / np.pi


@pytest.fixture(scope="module")
def results(three_disk_element, truncated, one_rotor, ground):
    held = [ground("rotor", end, 7e7, 5e7, 100.0, 100.0) for end in ("left", "right")]
    system = one_rotor(truncated(three_disk_element(), 8), held)
    branches = campbell_errors(system, campbell(system, np.linspace(0, 1000, 6), branch_count=4))
    speeds = critical_speeds(system, 1.0, 1000.0)
    return branches, speeds, critical_speed_errors(system, speeds, branches)


def test_bands_and_parts_of_a_campbell_diagram(results, drawn, tmp_path):
    branches = results[0]
    draw_campbell_errors(branches, tmp_path / "c.png", "Rotor", {"rotor": 1.0, "still": 0.0})
    assert [p.name for p in tmp_path.iterdir()] == ["c.png"]
    axes, strip = drawn[0].axes
    frequency = branches.campbell.frequency_hz
    bands = [band for band in axes.collections if band.get_label() == "error band"]
    ends = np.concatenate([band.get_paths()[0].vertices for band in bands])
    wanted = np.concatenate([frequency * (1 - branches.total), frequency * (1 + branches.total)])
    assert ends[:, 1].max() == pytest.approx(wanted.max(), rel=1e-12)
    assert ends[:, 1].min() == pytest.approx(wanted.min(), rel=1e-12)
    lines = {line.get_label(): line.get_ydata() for line in strip.lines}
    np.testing.assert_allclose(lines["total"], branches.total.max(axis=0))
    shown = lines["mode truncation"]
    np.testing.assert_allclose(shown, branches.parts["mode_truncation"].max(axis=0))
    assert strip.get_yscale() == "log" and "rpm" in strip.get_xlabel()
    assert any("1× rotor" in text.get_text() for text in axes.texts)


def test_every_part_has_a_look_that_can_be_drawn(results, drawn, tmp_path):
    branches, shown = results[0], [part for part in PARTS if part != "sampling"]  # of peaks alone
    parts = {part: (k + 1) * 1e-3 + 0.0 * branches.total for k, part in enumerate(shown)}
    draw_campbell_errors(dataclasses.replace(branches, parts=parts), tmp_path / "c.png", "Rotor")
    lines = [line for line in drawn[0].axes[1].lines if line.get_marker() not in ("", "None")]
    named = {line.get_label(): (line.get_color(), line.get_marker()) for line in lines}
    looks = [named[name] for part in shown for name in named if name.startswith(part.split("_")[0])]
    assert len(set(looks)) == len(looks) == len(shown)


def test_absent_branches_and_bodies_without_estimate(results, drawn, tmp_path):
    branches = results[0]
    parts = {name: values.copy() for name, values in branches.parts.items()}
    for values in parts.values():
        values[3, 4:] = values[0] = np.nan
    lame = dataclasses.replace(branches, parts=parts, bodies_without_estimate=("fan", "casing"))
    draw_campbell_errors(lame, tmp_path / "c.svg", "Rotor")
    assert "no estimate for fan, casing" in drawn[0].axes[1].get_xlabel()


def test_bars_of_critical_speeds(results, drawn, tmp_path):
    _, speeds, errors = results
    draw_critical_speed_errors(speeds, errors, tmp_path / "s.png", "Rotor")
    axes, side = drawn[0].axes
    places = [line.get_xdata()[0] for line in axes.lines if line.get_marker() in "osD"]
    np.testing.assert_allclose(places, [c.speed_rad_s * RPM for c in speeds])
    halves = [np.ptp(bar.lines[2][0].get_segments()[0][:, 0]) / 2 for bar in axes.containers]
    np.testing.assert_allclose(halves, np.array(places) * errors.total, rtol=1e-9)
    lines = {line.get_label(): line.get_xdata() for line in side.lines}
    np.testing.assert_allclose(lines["total"], errors.total)
    assert side.get_xscale() == "log"


def test_pictures_without_content_are_refused(results, tmp_path):
    branches, speeds, errors = results
    for few in ((), speeds[:1]):
        with pytest.raises(AnalysisError, match="with an estimate each are needed"):
            draw_critical_speed_errors(few, errors, tmp_path / "s.png", "Rotor")
    with pytest.raises(AnalysisError, match="suffix"):
        draw_campbell_errors(branches, tmp_path / "c.txt", "Rotor")
    assert not list(tmp_path.iterdir())
