"""The Campbell picture is written completely and shows what it is given."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from solidwhirl.rotordyn import AnalysisError, campbell, critical_speeds, draw_campbell


@pytest.fixture(scope="module")
def results(twin):
    system = twin()
    diagram = campbell(system, np.linspace(0, 2000, 9), branch_count=4)
    return diagram, critical_speeds(system, 1.0, 2000.0)


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_picture_is_written(results, tmp_path, suffix):
    path = tmp_path / f"campbell.{suffix}"
    draw_campbell(*results, path, "Twin rotor", {"inner": 1.0, "outer": -1.0})
    start = path.read_bytes()[:8]
    assert start == b"\x89PNG\r\n\x1a\n" if suffix == "png" else start.startswith(b"<?xml")
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_picture_shows_directions_lines_and_speeds(results, tmp_path, monkeypatch):
    figures = []
    save = Figure.savefig

    def keep(figure, *args, **options):
        figures.append(figure)
        return save(figure, *args, **options)

    monkeypatch.setattr(Figure, "savefig", keep)
    ratios = {"inner": 1.0, "outer": -1.0, "blades": 3.0}
    draw_campbell(*results, tmp_path / "c.png", "Twin rotor", ratios)
    (figure,) = figures
    (axes,) = figure.axes
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts[:3] == ["forward", "backward", "critical speed"]
    assert texts[-3:] == ["9536  backward", "10996  forward", "18735  backward"]
    assert sorted(t.get_text() for t in axes.texts) == ["1× inner, outer", "3× blades"]
    styles = {
        line.get_label(): (line.get_color(), line.get_linestyle(), line.get_marker())
        for line in axes.lines
        if line.get_label() in ("forward", "backward")
    }
    assert all(a != b for a, b in zip(*styles.values(), strict=True))
    # The critical speeds lie on the once-per-revolution line.
    (marks,) = [line for line in axes.lines if line.get_label() == "critical speed"]
    np.testing.assert_allclose(marks.get_ydata(), np.array(marks.get_xdata()) / 60.0)


def test_unknown_kind_of_picture_is_refused(results, tmp_path):
    with pytest.raises(AnalysisError, match=r"suffix '.bmp'; allowed are"):
        draw_campbell(*results, tmp_path / "c.bmp", "t", {})
