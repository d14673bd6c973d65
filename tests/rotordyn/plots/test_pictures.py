"""Pictures are written completely and show what they are given."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from solidwhirl.rotordyn import (
    AnalysisError,
    InternalDamping,
    Rotor,
    TrackingNote,
    assemble,
    campbell,
    critical_speeds,
    draw_campbell,
    modes_at_speed,
)
from solidwhirl.rotordyn.modes.mode_shapes import mode_shapes
from solidwhirl.rotordyn.modes.participation import participation
from solidwhirl.rotordyn.plots.campbell import draw_annotated_campbell, draw_damped_campbell
from solidwhirl.rotordyn.plots.chart import Axis, Bars, Chart, Look
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.plots.modes import body_chart, deflection_chart, mode_names, share_chart


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


def test_picture_shows_directions_lines_and_speeds(results, tmp_path, drawn):
    ratios = {"inner": 1.0, "outer": -1.0, "blades": 3.0}
    draw_campbell(*results, tmp_path / "c.png", "Twin rotor", ratios)
    (figure,) = drawn
    (axes,) = figure.axes
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts[:3] == ["forward whirl", "backward whirl", "critical speed"]
    assert texts[-3:] == ["9536  backward", "10996  forward", "18735  backward"]
    assert sorted(t.get_text() for t in axes.texts) == ["1× inner, outer", "3× blades"]
    styles = {
        line.get_label(): (line.get_color(), line.get_linestyle(), line.get_marker())
        for line in axes.lines
        if line.get_label() in ("forward whirl", "backward whirl")
    }
    assert all(a != b for a, b in zip(*styles.values(), strict=True))
    # The critical speeds lie on the once-per-revolution line.
    (marks,) = [line for line in axes.lines if line.get_label() == "critical speed"]
    np.testing.assert_allclose(marks.get_ydata(), np.array(marks.get_xdata()) / 60.0)


def test_operating_speeds_are_hatched(results, tmp_path, drawn):
    ranges = {"inner": (500.0, 800.0), "the same": (500.0, 800.0), "outer": (1200.0, 1200.0)}
    for draw in (draw_campbell, draw_annotated_campbell, draw_damped_campbell):
        draw(*results, tmp_path / "c.png", "Twin rotor", {"inner": 1.0}, ranges)
        axes = drawn[-1].axes[0]
        (span,) = [patch for patch in axes.patches if patch.get_label() == "operating speed"]
        edges = np.array([500.0, 800.0]) * 30 / np.pi
        along = span.get_patch_transform().transform(span.get_path().vertices)[:, 0]
        assert (along.min(), along.max()) == pytest.approx(tuple(edges))
        (line,) = [line for line in axes.lines if line.get_label() == "operating speed"]
        assert line.get_xdata()[0] == pytest.approx(1200.0 * 30 / np.pi)
        texts = [text.get_text() for text in drawn[-1].legends[0].get_texts()]
        assert texts.count("operating speed") == 1


def test_unknown_kind_of_picture_is_refused(results, tmp_path):
    with pytest.raises(AnalysisError, match=r"suffix '.bmp'; allowed are"):
        draw_campbell(*results, tmp_path / "c.bmp", "t", {})


def _lines(axes, label):
    return [line for line in axes.lines if line.get_label() == label]


def test_notes_are_marked_at_their_branches(results, tmp_path, drawn):
    """Each kind has its own marker, at the speed of the note and the mean of its branches."""
    diagram, critical = results
    kinds = ("crossing", "veering", "ambiguous", "ended")
    notes = [
        TrackingNote(kind=kind, speed_rad_s=100.0 * (k + 3), branches=(0, 1), text="")
        for k, kind in enumerate(kinds)
    ]
    notes.append(TrackingNote(kind="range", speed_rad_s=1500.0, branches=(), text=""))
    marked = dataclasses.replace(diagram, notes=tuple(notes))
    draw_annotated_campbell(marked, critical, tmp_path / "c.png", "t", {})
    (axes,) = drawn[0].axes
    markers = set()
    for note in notes[:-1]:
        (mark,) = _lines(axes, note.kind)
        assert mark.get_xdata()[0] == pytest.approx(note.speed_rad_s * 30 / np.pi)
        # Linear between the speeds of the diagram.
        row = [np.interp(note.speed_rad_s, diagram.speeds_rad_s, f) for f in diagram.frequency_hz]
        assert mark.get_ydata()[0] == pytest.approx(np.mean(row[:2]), rel=1e-12)
        markers.add(mark.get_marker())
    assert len(markers) == 4
    (limit,) = _lines(axes, "end of the basis")
    assert limit.get_xdata()[0] == pytest.approx(1500 * 30 / np.pi)
    texts = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    assert texts[3:8] == [*kinds, "end of the basis"]


def test_ended_branch_is_marked_where_it_ended(results, tmp_path, drawn):
    diagram, _ = results
    values = diagram.frequency_hz.copy()
    values[1, 5:] = np.nan
    whirl = diagram.whirl.copy()
    whirl[1, 5:] = ""
    note = TrackingNote(kind="ended", speed_rad_s=1250.0, branches=(1,), text="")
    ended = dataclasses.replace(diagram, frequency_hz=values, whirl=whirl, notes=(note,))
    draw_annotated_campbell(ended, (), tmp_path / "c.png", "t", {})
    (mark,) = _lines(drawn[0].axes[0], "ended")
    assert mark.get_ydata()[0] == diagram.frequency_hz[1, 4]


@pytest.mark.verify
def test_decrements_are_drawn_below(three_disk_element, ground, tmp_path, drawn):
    inside = InternalDamping(stiffness_coefficient_s=2e-5)
    rotor = Rotor(element=three_disk_element(), speed_ratio=1.0, internal_damping=inside)
    held = tuple(ground("rotor", e, 7e7, 5e7, 7000, 5000) for e in ("left", "right"))
    system = assemble({"rotor": rotor}, held)
    diagram = campbell(system, np.linspace(0, 2500, 6), branch_count=4)
    draw_damped_campbell(diagram, (), tmp_path / "c.png", "Three disks", {"shaft": 1.0})
    upper, strip = drawn[0].axes
    assert upper.get_shared_x_axes().joined(upper, strip)
    shown = np.concatenate([line.get_ydata() for line in strip.lines if len(line.get_xdata()) > 2])
    # overdamped modes turn with the spin, and have no branch at rest
    known = diagram.log_decrement[np.isfinite(diagram.log_decrement)]
    assert np.isin(known, shown).all() and known.size < diagram.log_decrement.size
    # The first forward mode is unstable at the end, so the shaded range below zero is in view.
    assert known.min() < 0
    low, high = strip.get_ylim()
    assert low < known.min() and high == 1.08 * 2.0 < known.max()
    texts = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    assert texts[-1] == f"decrements up to {known.max():.3g}, above 2 not shown"


def test_mode_shapes_stand_beside_each_other(twin, tmp_path, drawn):
    system = twin()
    shapes = mode_shapes(system, modes_at_speed(system, 1500.0, 5))
    names = mode_names(shapes)
    draw_charts([deflection_chart([("fast", names, shapes)])], tmp_path / "m.png", "Twin rotor")
    frames = [axes for axes in drawn[0].axes if axes.get_visible()]
    assert [axes.get_title() for axes in frames][:2] == [
        "fast: mode 1,\n153.7 Hz, backward",
        "fast: mode 2,\n182.6 Hz, forward",
    ]
    assert drawn[0].get_suptitle() == "Twin rotor"
    assert len(frames) == 5
    for mode, axes in enumerate(frames):
        for body in shapes.bodies:
            (line,) = _lines(axes, body.body)
            np.testing.assert_array_equal(line.get_xdata(), body.axial_m)
            np.testing.assert_array_equal(line.get_ydata(), body.deflection[:, mode])
    draw_charts([body_chart(shapes, "outer", "1500 rpm")], tmp_path / "b.png", "Outer rotor")
    (axes,) = drawn[1].axes
    (line,) = _lines(axes, names[4])
    np.testing.assert_array_equal(line.get_ydata(), shapes.body("outer").deflection[:, 4])
    assert sorted(text.get_text() for text in axes.texts) == ["C", "D"]
    with pytest.raises(AnalysisError, match="no body 'fan'"):
        body_chart(shapes, "fan", "rest")


def test_shares_of_energy_are_stacked_to_one(twin, tmp_path, drawn):
    system = twin()
    modes = modes_at_speed(system, 1500.0, 4)
    result, names = participation(system, modes), mode_names(mode_shapes(system, modes))
    charts = [share_chart([("fast", names, result)], kind) for kind in ("kinetic", "strain")]
    draw_charts(charts, tmp_path / "p.png", "Twin rotor")
    kinetic, potential = drawn[0].axes
    heights = [patch.get_height() for patch in kinetic.patches]
    np.testing.assert_allclose(heights, 100.0 * result.kinetic_bodies.ravel(), atol=1e-12)
    tops = [patch.get_y() + patch.get_height() for patch in kinetic.patches]
    assert max(tops) == pytest.approx(100.0, abs=1e-9)
    shown = np.zeros(4)
    for patch in potential.patches:
        shown[round(patch.get_x() + 0.35)] += patch.get_height()
    every = 100.0 * np.vstack([result.strain_bodies, np.nan_to_num(result.strain_joints)])
    # what has less than half a percent of every mode is left out
    assert (np.abs(shown - every.sum(axis=0)) < 2.0).all()
    # told apart without colour too
    handles = drawn[0].legends[0].get_patches()
    assert len({(patch.get_facecolor(), patch.get_hatch()) for patch in handles}) == len(handles)


def test_negative_bars_stand_below_zero(tmp_path, drawn):
    """A centrifugal part may be negative: what follows stands on the positive ones."""
    values = {"a": [2.0, -1.0], "b": [-3.0, -2.0], "c": [1.0, 4.0]}
    bars = [Bars(values=np.array(v), name=n, look=Look("@c0")) for n, v in values.items()]
    axis = Axis(label="x", places=["first", "second"])
    chart = Chart(name="c", title="", x=axis, y=Axis(label="y"), parts=bars, is_stacked=True)
    draw_charts([chart], tmp_path / "s.png", "t")
    bottoms = [patch.get_y() for patch in drawn[0].axes[0].patches]
    assert bottoms == [0.0, 0.0, 0.0, -1.0, 2.0, 0.0]


def test_a_chart_without_frames_is_refused(tmp_path):
    with pytest.raises(AnalysisError, match="nothing to draw"):
        draw_charts([], tmp_path / "x.png", "t")
    with pytest.raises(AnalysisError, match="nothing to draw"):
        draw_charts([deflection_chart([])], tmp_path / "x.png", "t")
    assert not list(tmp_path.iterdir())
