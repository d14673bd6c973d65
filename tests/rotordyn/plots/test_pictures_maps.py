"""Pictures of maps, laws and margins are written completely and show what they are given."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn import AnalysisError, Bearing, End
from solidwhirl.rotordyn.assembly.bearing_laws import LEE_ANISOTROPIC
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.plots.maps import draw_bearing_law, draw_critical_speed_map
from solidwhirl.rotordyn.plots.margins import draw_separation_margins
from solidwhirl.rotordyn.response.separation_margins import (
    OperatingRange,
    Resonance,
    separation_margins,
)

RPM = np.pi / 30.0
WHIRLS = ("forward whirl", "backward whirl")


@pytest.fixture(scope="module")
def result(three_disk):
    names = ["rotor.left", "rotor.right"]
    return critical_speed_map(three_disk(), names, np.geomspace(1e5, 1e11, 7), branch_count=2)


@pytest.fixture
def lee():
    return Bearing(
        name="front",
        first=End(body="LP", interface="seat"),
        stiffness_n_per_m=4.53e7 * np.eye(2),
        damping_n_s_per_m=1000.0 * np.eye(2),
        speed_law=LEE_ANISOTROPIC,
    )


@pytest.fixture
def margins():
    operating = OperatingRange(shaft="LP", speed_low_rad_s=900.0, speed_high_rad_s=1000.0)
    resonances = [
        Resonance(speed_rad_s=600.0, amplification_factor=20.0, whirl="backward"),
        Resonance(speed_rad_s=850.0, amplification_factor=11.5, whirl="forward"),
        Resonance(speed_rad_s=950.0, amplification_factor=2.0),
        Resonance(speed_rad_s=1300.0, amplification_factor=-40.0),
        Resonance(speed_rad_s=2500.0, amplification_factor=np.inf),
    ]
    return separation_margins(operating, resonances)


def _labels(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_pictures_are_written(result, lee, margins, tmp_path, suffix):
    draw_critical_speed_map(result, tmp_path / f"map.{suffix}", "Map", {"cruise": 500.0})
    draw_bearing_law(lee, [0.0, 1900.0], tmp_path / f"law.{suffix}", "Law", {"LP": 1434.0})
    draw_separation_margins(margins, tmp_path / f"margins.{suffix}", "Margins")
    assert len(list(tmp_path.iterdir())) == 3
    for path in tmp_path.iterdir():
        start = path.read_bytes()[:8]
        assert start == b"\x89PNG\r\n\x1a\n" if suffix == "png" else start.startswith(b"<?xml")


def test_map_shows_branches_operating_speeds_and_the_chosen_stiffness(result, tmp_path, drawn):
    draw_critical_speed_map(result, tmp_path / "m.png", "Map", {"cruise": 500.0, "dash": 900.0})
    (figure,) = drawn
    (axes,) = figure.axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    curves = [line for line in axes.lines if line.get_label() in WHIRLS]
    reached = sorted(float(line.get_ydata()[-1]) for line in curves)
    np.testing.assert_allclose(reached, np.sort(result.speed_rad_s[:, -1] / RPM), rtol=1e-12)
    texts = {text.get_text() for text in axes.texts}
    names = ("operating speed of cruise, 4775 rpm", "operating speed of dash, 8594 rpm")
    assert {*names, "rotor.left (x), rotor.right (x)", "rotor.left (y), rotor.right (y)"} <= texts
    assert set(_labels(figure)) == {
        *WHIRLS,
        "operating speed",
        "operating speed ±15 %",
        "operating speed ±20 %",
        "stiffness as chosen",
        "without these bearings",
        "with rigid bearings",
    }
    # The bands: 15 and 20 % on both sides.
    ends = np.unique(np.round([p.get_extents().intervaly for p in _band_boxes(axes)], 6))
    expected = np.array([0.8, 0.85, 1.15, 1.2])[:, None] * np.array([500.0, 900.0]) / RPM
    np.testing.assert_allclose(ends, np.sort(expected.ravel()), rtol=1e-6)


def _band_boxes(axes):
    return [
        patch.get_path().transformed(patch.get_patch_transform())
        for patch in axes.patches
        if str(patch.get_label()).startswith("operating")
    ]


def test_law_shows_range_and_negative_damping(lee, tmp_path, drawn):
    draw_bearing_law(lee, [0.0, 2500.0], tmp_path / "l.png", "Law", {"LP": 1434.0})
    (figure,) = drawn
    (axes,) = figure.axes
    labels = _labels(figure)
    assert "range of lee_anisotropic" in labels
    assert "negative damping" in labels
    assert "k_xx (4.53e+07 N/m)" in labels
    curves = {str(line.get_label())[:4]: line for line in axes.lines}
    at = np.array([0.0, 100.0, 1000.0])
    for name, factors in (("k_xx", LEE_ANISOTROPIC.stiffness_x), ("d_yy",
                          LEE_ANISOTROPIC.damping_y)):  # fmt: skip
        rpm, values = (np.asarray(data) for data in curves[name].get_data())
        # 400 points over 2500 rad/s, straight between them.
        found = np.interp(at / RPM, rpm, values)
        np.testing.assert_allclose(found, np.polyval(factors[::-1], at), atol=1e-4)


def test_law_without_negative_damping_is_not_hatched(lee, tmp_path, drawn):
    draw_bearing_law(lee, [0.0, 1000.0], tmp_path / "l.png", "Law", {})
    (figure,) = drawn
    assert "negative damping" not in _labels(figure)


def test_margins_show_verdicts_and_count_what_is_far_away(margins, tmp_path, drawn):
    draw_separation_margins(margins, tmp_path / "s.png", "Margins")
    (figure,) = drawn
    (axes,) = figure.axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == [
        "LP: 5730 rpm backward, AF 20.0",
        "LP: 8117 rpm forward, AF 11.5",
        "LP: 9072 rpm, AF 2.0",
        "LP: 12414 rpm, AF -40.0",
    ]
    labels = _labels(figure)
    assert {"ok", "inside margin", "unstable", "1 more, farther away"} <= set(labels)
    marks = {line.get_label(): line for line in axes.lines if line.get_linestyle() == "None"}
    assert marks["inside margin"].get_xdata()[0] == pytest.approx(100 * (850 / 900 - 1))
    assert marks["unstable"].get_xdata()[0] == pytest.approx(30.0)


def test_what_cannot_be_drawn_is_refused(result, lee, margins, tmp_path, ground, three_disk):
    for draw in (
        lambda path: draw_critical_speed_map(result, path, "t", {}),
        lambda path: draw_bearing_law(lee, [0.0, 1.0], path, "t", {}),
        lambda path: draw_separation_margins(margins, path, "t"),
    ):
        with pytest.raises(AnalysisError, match=r"suffix '.bmp'; allowed are"):
            draw(tmp_path / "p.bmp")
    with pytest.raises(AnalysisError, match="no margins"):
        draw_separation_margins([], tmp_path / "p.png", "t")
    with pytest.raises(AnalysisError, match="has no speed law"):
        draw_bearing_law(ground("rotor", "left", 1e6), [0.0, 1.0], tmp_path / "p.png", "t", {})
    empty = critical_speed_map(three_disk(), ["rotor.left"], [1e6], speed_max_rad_s=1.0)
    with pytest.raises(AnalysisError, match="no critical speed to draw"):
        draw_critical_speed_map(empty, tmp_path / "p.png", "t", {})
    assert list(tmp_path.iterdir()) == []
