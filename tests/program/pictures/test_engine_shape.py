"""The mode in space is the mode that the program found: place, size, phase and sense."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from solidwhirl.drawing.modes import pictured_modes
from solidwhirl.pictures.engine_shape import displaced, engine_shape
from solidwhirl.rotordyn.modes.mode_shapes import mode_shapes


@pytest.fixture(scope="module")
def shapes(twin):
    return [engine_shape(twin, pictured_modes(twin, 2)[1], k) for k in range(2)]


def test_modes_of_critical_speeds_are_chosen(twin, shapes):
    lowest = sorted(c.critical.speed_rad_s for c in twin.critical_speeds)[:2]
    for shape, speed in zip(shapes, lowest, strict=True):
        assert shape.speed_rpm == pytest.approx(speed * 30 / np.pi)
        # at a critical speed of order 1 the mode turns once per turn; the search's accuracy 1e-10
        assert shape.frequency_hz == pytest.approx(speed / (2 * np.pi), rel=1e-8)
    assert [s.whirl for s in shapes] == ["backward", "forward"]


def test_without_critical_speeds_the_top_speed_is_shown(laval):
    slow = dataclasses.replace(laval, critical_speeds=())
    beginning, chosen = pictured_modes(slow, 3)
    assert beginning == "mode" and len(chosen.rpm) == 3
    assert chosen.rpm == pytest.approx(laval.campbell.speeds_rad_s[-1] * 30 / np.pi)
    lowest = sorted(laval.campbell.frequency_hz[:, -1])[:3]
    # both are accurate to that of the eigenvalue solver
    assert chosen.modes.frequency_hz == pytest.approx(lowest, rel=1e-9)


def test_largest_displacement_is_as_said(shapes):
    for shape in shapes:
        phases = np.linspace(0.0, 2.0 * np.pi, 361)
        largest = max(displaced(b, p)[1].max() for b in shape.bodies for p in phases)
        # 361 phases miss the largest of a cosine by (0.5°)²/2
        assert largest == pytest.approx(shape.largest_m, rel=1e-4)


def test_orbits_turn_as_the_mode_whirls(shapes):
    """Both shafts of one mode turn about the same axis; the paths are sampled, not labelled."""
    for shape in shapes:
        assert shape.orbits
        for orbit in shape.orbits:
            x, y = orbit.points_m[:, 0], orbit.points_m[:, 1]
            area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
            assert orbit.whirl == shape.whirl
            assert np.sign(area) == (1.0 if shape.whirl == "forward" else -1.0)


def test_surface_and_orbits_move_together(twin, shapes):
    """The mean of a ring of the inner shaft is the point of the orbit there, at every phase."""
    shape = shapes[1]
    body = next(b for b in shape.bodies if b.body == "inner")
    at = 0.26666666666666666
    orbit = next(o for o in shape.orbits if abs(o.points_m[0, 2] - at) < 1e-9)
    ring = np.abs(body.points_m[:, 2] - at) < 1e-6
    ring &= np.abs(np.hypot(*body.points_m[:, :2].T) - 0.02) < 1e-6
    assert ring.any(), "the shaft has no ring of points at C"
    for k in (0, 16, 40):
        points, _ = displaced(body, 2.0 * np.pi * k / 64)
        # between nodes the centre line is drawn straight; at one it is that of the surface
        np.testing.assert_allclose(
            points[ring, :2].mean(axis=0), orbit.points_m[k, :2], atol=2e-2 * shape.largest_m
        )


def test_deflection_has_the_form_of_the_mode_shape(twin, shapes):
    shape = shapes[0]
    modes = pictured_modes(twin, 1)[1].modes
    outer = mode_shapes(twin.system, modes).body("outer")
    motion = outer.interface_motion[outer.interfaces.index("C"), :, 0]
    orbit = next(o for o in shape.orbits if abs(o.points_m[0, 2] - 0.2666666666) < 1e-6)
    # the orbit is the motion times one length for all orbits, over one period from phase 0
    turn = np.exp(2j * np.pi * np.arange(64) / 64)
    path = np.real(motion[:, None] * turn).T
    unit = np.hypot(*orbit.points_m[:, :2].T).max() / np.hypot(*path.T).max()
    np.testing.assert_allclose(orbit.points_m[:, :2], unit * path, atol=1e-9 * shape.largest_m)


def test_outer_shaft_is_open_and_inner_is_not(shapes):
    by_name = {b.body: b for b in shapes[0].bodies}
    for name, is_open in (("inner", False), ("outer", True)):
        faces = by_name[name].quadrangles
        middle = by_name[name].points_m[faces].mean(axis=1)
        angle = np.degrees(np.arctan2(middle[:, 1], middle[:, 0])) % 360.0
        assert bool(((angle > 90) & (angle < 200)).any()) is not is_open
