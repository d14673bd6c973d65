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
from solidwhirl.rotordyn.campbell.body_frames import campbell_seen_by_body
from solidwhirl.rotordyn.modes.mode_shapes import mode_shapes
from solidwhirl.rotordyn.modes.participation import participation
from solidwhirl.rotordyn.plots.campbell import draw_annotated_campbell, draw_damped_campbell
from solidwhirl.rotordyn.plots.modes import (
    draw_body_modes,
    draw_mode_shapes,
    draw_rotating_campbell,
)
from solidwhirl.rotordyn.plots.participation import draw_participation


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


def test_large_decrements_are_named_not_drawn(results, tmp_path, drawn):
    diagram, _ = results
    damped = dataclasses.replace(diagram, log_decrement=np.full(diagram.log_decrement.shape, 9.5))
    draw_damped_campbell(damped, (), tmp_path / "c.png", "t", {})
    texts = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    assert texts[-1] == "decrements up to 9.5, above 2 not shown"


@pytest.fixture(scope="module")
def frames(twin):
    system = twin()
    diagram = campbell(system, np.linspace(0, 2000, 9), branch_count=4)
    return [campbell_seen_by_body(system, diagram, body) for body in ("inner", "outer")]


def test_rotating_frames(frames, tmp_path, drawn):
    path = tmp_path / "r.png"
    draw_rotating_campbell(frames, path, "In the frames of the bodies")
    assert path.read_bytes()[:4] == b"\x89PNG"
    frames_drawn = drawn[0].axes
    assert [axes.get_title() for axes in frames_drawn] == ["inner", "outer"]
    texts = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    assert texts == ["turns with the spin", "turns against it", "a force at rest"]
    lines = [line for axes in frames_drawn for line in axes.lines]
    # A forward mode slower than its body is mirrored at zero and dashed afterwards.
    mirrored = [
        line
        for line in lines
        if line.get_label() == "turns against it" and np.nanmin(line.get_ydata()) == 0.0
    ]
    assert len(mirrored) >= 2
    assert all(np.nanmin(line.get_ydata()) >= 0 for line in lines)


def test_frames_without_shares_show_both_circles(twin, results, tmp_path, drawn):
    diagram, _ = results
    seen = campbell_seen_by_body(twin(), diagram, "inner")
    unknown = dataclasses.replace(seen, share=np.full(seen.share.shape, np.nan))
    draw_rotating_campbell([unknown], tmp_path / "r.png", "t")
    (axes,) = drawn[0].axes
    ends = {round(float(y), 3) for line in axes.lines for y in np.atleast_1d(line.get_ydata())
            if np.isfinite(y)}  # fmt: skip
    turn = 2000 / (2 * np.pi)
    for frequency in diagram.frequency_hz[:, -1]:
        assert {round(abs(frequency - turn), 3), round(frequency + turn, 3)} <= ends


def test_mode_shape_pictures(twin, tmp_path, drawn):
    system = twin()
    shapes = mode_shapes(system, modes_at_speed(system, 1500.0, 5))
    draw_mode_shapes(shapes, tmp_path / "m.png", "Twin rotor")
    frames = [axes for axes in drawn[0].axes if axes.get_visible()]
    assert [axes.get_title() for axes in frames][:2] == [
        "1: 153.7 Hz backward",
        "2: 182.6 Hz forward",
    ]
    assert len(frames) == 5
    for mode, axes in enumerate(frames):
        for body in shapes.bodies:
            (line,) = _lines(axes, body.body)
            np.testing.assert_array_equal(line.get_xdata(), body.axial_m)
            np.testing.assert_array_equal(line.get_ydata(), body.deflection[:, mode])
    draw_body_modes(shapes, "outer", tmp_path / "b.png", "Outer rotor")
    (axes,) = drawn[1].axes
    (line,) = _lines(axes, "5: 973.6 Hz forward")
    np.testing.assert_array_equal(line.get_ydata(), shapes.body("outer").deflection[:, 4])
    assert sorted(text.get_text() for text in axes.texts) == ["C", "D"]


def test_participation_picture(twin, tmp_path, drawn):
    system = twin()
    result = participation(system, modes_at_speed(system, 1500.0, 4))
    draw_participation(result, tmp_path / "p.png", "Twin rotor")
    kinetic, potential = drawn[0].axes
    for axes in (kinetic, potential):
        tops = [patch.get_y() + patch.get_height() for patch in axes.patches]
        # The shares are stacked to one.
        assert max(tops) == pytest.approx(1.0, abs=1e-9)
    heights = [patch.get_height() for patch in kinetic.patches]
    np.testing.assert_allclose(heights, result.kinetic_bodies.ravel(), atol=1e-15)
    texts = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    # Told apart without colour too.
    handles = drawn[0].legends[0].get_patches()
    assert len({patch.get_hatch() for patch in handles}) == len(handles)
    # The rigid joint and supports of 1e10 N/m store next to nothing.
    assert texts == ["inner", "outer", "inner.C", "other joints"]


def test_pictures_without_content_are_refused(frames, twin, tmp_path):
    path = tmp_path / "x.png"
    still = dataclasses.replace(frames[0], speed_ratio=0.0)
    with pytest.raises(AnalysisError, match="no body turns"):
        draw_rotating_campbell([still], path, "t")
    system = twin()
    modes = modes_at_speed(system, 0.0, 20)
    with pytest.raises(AnalysisError, match="there are 20 modes; 1 to 16 can be drawn"):
        draw_mode_shapes(mode_shapes(system, modes), path, "t")
    with pytest.raises(AnalysisError, match="1 to 16 can be drawn"):
        draw_participation(participation(system, modes), path, "t")
    with pytest.raises(AnalysisError, match="no body 'fan'"):
        draw_body_modes(mode_shapes(system, modes_at_speed(system, 0.0, 2)), "fan", path, "t")
    assert not list(tmp_path.iterdir())
