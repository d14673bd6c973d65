"""Drawings show what they are given, in files that can be printed and searched."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from solidwhirl.drawing.bodies import silhouettes_of
from solidwhirl.page.run.accuracy import time_chart
from solidwhirl.page.run.checks import checks_chart
from solidwhirl.pictures.engine import draw_engine
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.plots.frame import (
    TEXT_PT,
    WHIRL_STYLES,
    new_figure,
    styled,
    write_figure,
)
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.superelement.invariants import compared


def test_engine_is_drawn_to_scale_with_all_names(geared, tmp_path, drawn):
    draw_engine(geared.scene, silhouettes_of(geared), tmp_path / "e.svg", "Geared")
    (axes,) = drawn[0].axes
    assert axes.get_aspect() == 1.0
    texts = [t.get_text() for t in axes.texts]
    nodes = [f"slow.{n}" for n in ("front", "seat")] + [f"fast.{n}" for n in ("seat", "rear")]
    nodes += [f"casing.{n}" for n in ("front", "middle", "rear")]
    joints = [f"b{k}: 1e7 N/m" for k in range(1, 5)] + ["mount: rigid", "gear: gear, ratio 0.5"]
    assert {*nodes, *joints, "slow (speed × 0.5)", "casing (speed × 0)"} <= {*texts}
    # the ruler below tells how many units of the drawing are a metre
    ruler = {t.get_text(): t.get_position() for t in axes.texts if t.get_ha() == "center"}
    metre = ruler["1000"][0] - ruler["0"][0]
    # the thick part of the fast shaft is 250 mm long and reaches from 10 to 30 mm
    paths = [p.get_path().vertices for p in axes.patches]
    assert any(
        np.ptp(v[:, 0]) == pytest.approx(0.25 * metre)
        and np.ptp(v[:, 1]) == pytest.approx(0.02 * metre)
        for v in paths
    )
    said = " ".join(t.get_text() for t in drawn[0].texts).replace("\n", " ")
    assert "dark: rigid" in said and "Toothed circles: gear" in said


def test_names_of_the_drawing_do_not_overlap(twin, tmp_path, drawn):
    """Measured from the boxes of the text as it is drawn."""
    draw_engine(twin.scene, silhouettes_of(twin), tmp_path / "e.png", "Twin")
    (axes,) = drawn[0].axes
    boxes = [t.get_window_extent() for t in axes.texts]
    for k, first in enumerate(boxes):
        for second in boxes[:k]:
            assert not (
                first.x0 < second.x1 - 1
                and second.x0 < first.x1 - 1
                and first.y0 < second.y1 - 1
                and second.y0 < first.y1 - 1
            )


def _one_line(path):
    figure = new_figure(path)
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], label="a")
    axes.set_xlabel("speed [rpm]")
    write_figure(figure, path)


def test_files_are_the_same_each_time_searchable_and_two_columns_wide(tmp_path):
    draw = styled(_one_line)
    for kind in ("svg", "pdf", "png"):
        for name in "ab":
            draw(tmp_path / f"{name}.{kind}")
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()
    root = ET.parse(tmp_path / "a.svg").getroot()
    assert "speed [rpm]" in ["".join(e.itertext()) for e in root.iter() if e.tag.endswith("}text")]
    points = float(re.sub("pt", "", root.attrib["width"]))
    assert points * 25.4 / 72.0 == pytest.approx(180.0, abs=0.1)
    data = (tmp_path / "a.pdf").read_bytes()
    # Type 42 (TrueType) with its file, not Type 3 glyph procedures that journals refuse
    assert b"/FontFile2" in data and b"/Type3" not in data
    assert b"CreationDate" not in data


def test_settings_end_with_the_picture():
    import matplotlib

    before = matplotlib.rcParams["font.size"]
    assert styled(lambda: matplotlib.rcParams["font.size"])() == TEXT_PT
    assert matplotlib.rcParams["font.size"] == before != TEXT_PT


def test_whirl_is_told_apart_without_colour():
    marks = [(s.dashes, s.marker, s.is_open) for s in WHIRL_STYLES.values()]
    assert len(set(marks)) == len(marks)
    assert WHIRL_STYLES["forward"].face == WHIRL_STYLES["forward"].color
    assert WHIRL_STYLES["backward"].face == "white"


def test_unknown_kind_is_refused(geared, tmp_path):
    with pytest.raises(AnalysisError, match=r"suffix '.bmp'"):
        draw_engine(geared.scene, silhouettes_of(geared), tmp_path / "e.bmp", "t")


def test_checks_stand_on_their_side_of_the_limit(tmp_path, drawn):
    good = compared("mass", "a", 1e-9, 1e-8, "x")
    bad = compared("stiffness", "a", 1e-3, 1e-4, "x")
    draw_charts([checks_chart([good, bad])], tmp_path / "c.png", "t")
    (axes,) = drawn[0].axes
    by_label = {line.get_label(): line for line in axes.lines}
    assert by_label["holds"].get_xdata() == pytest.approx([0.1])
    assert by_label["fails"].get_xdata() == pytest.approx([10.0])


def test_cost_has_a_bar_for_each_stage(tmp_path, drawn):
    draw_charts([time_chart({"mesh": 1.0, "modes": 3.0})], tmp_path / "c.png", "t")
    (axes,) = drawn[0].axes
    assert [p.get_width() for p in axes.patches] == [1.0, 3.0]
    assert {"1 s", "3 s"} <= {t.get_text() for t in axes.texts}
