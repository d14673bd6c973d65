"""Surfaces with fewer points, and which modes are shown."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from still_surface import still_surface

from solidwhirl.drawing.modes import critical_modes, pictured_modes
from solidwhirl.drawing.motion import engine_in_space, mode_in_space, with_few_points
from solidwhirl.drawing.surfaces import thinned
from solidwhirl.rotordyn.modes.whirl import Excitation
from solidwhirl.rotordyn.superelement.surface import outline_chains


def _ring(count):
    return np.column_stack([np.arange(count), np.roll(np.arange(count), -1)])


@given(count=st.integers(3, 30), seed=st.integers(0, 99))
def test_chains_hold_every_edge_once(count, seed):
    loop, piece = _ring(count), np.array([[count, count + 1], [count + 1, count + 2]])
    edges = np.random.default_rng(seed).permutation(np.concatenate([loop, piece]))
    chains = outline_chains(edges)
    found = [tuple(pair) for c in chains for pair in np.column_stack([c[:-1], c[1:]]).tolist()]
    assert sorted(found) == sorted(map(tuple, edges.tolist()))
    assert len(chains) == 2


def test_thinned_outline_keeps_corners_and_length():
    side = np.linspace(0.0, 1.0, 101)[:-1]
    z = np.concatenate([side, np.ones(100), 1.0 - side, np.zeros(100)])
    r = np.concatenate([np.zeros(100), side, np.ones(100), 1.0 - side]) + 0.2
    found = thinned(still_surface(np.column_stack([z, r]), _ring(400)), 0.25)
    assert 12 <= len(found.points_m) <= 24
    edges = found.points_m[found.cells]
    # a square stays one
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).sum() == pytest.approx(4.0)
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).max() <= 0.26


def _area(surface):
    a, b, c = surface.points_m[surface.cells].swapaxes(0, 1)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def test_solid_surfaces_are_thinned_to_a_limit():
    n = 80
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    points = np.column_stack([x.ravel(), y.ravel(), 0.1 * np.sin(3 * x).ravel()])
    at = np.arange((n - 1) * n)
    at = at[at % n < n - 1]
    cells = np.concatenate(
        [np.column_stack([at, at + 1, at + n + 1]), np.column_stack([at, at + n + 1, at + n])]
    )
    one = {key: np.array([0]) for key in ("coordinate", "order", "family")}
    surface = dataclasses.replace(
        still_surface(points, cells), amplitudes=points[:, :, None], **one
    )
    found = thinned(surface, 0.1)
    assert 1000 < len(found.points_m) <= 2500
    # the rim loses half a box
    assert _area(found) == pytest.approx(_area(surface), rel=0.06)
    # single precision of a solid's amplitudes
    np.testing.assert_allclose(found.amplitudes[:, :, 0], found.points_m, rtol=1e-6)


def test_backward_and_forward_modes_at_one_critical_speed_are_both_shown():
    """A mode that two shafts excite there only once; what unbalance excites comes first."""

    def critical(whirl, speed=100.0, exciters=("unbalance",)):
        return SimpleNamespace(
            critical=SimpleNamespace(
                speed_rad_s=speed,
                frequency_hz=speed / (2 * np.pi),
                whirl=whirl,
                log_decrement=0.0,
                shape=np.ones(4),
                shares=np.array([1.0, 0.0, 0.0, 0.0]),
                counts=lambda rule: speed < rule,
            ),
            excitation=Excitation(exciters, (), ""),
        )

    # what is critically damped is no critical speed; here all from 200 rad/s on
    scene = SimpleNamespace(criteria=SimpleNamespace(rule=200.0))
    found = [critical("backward"), critical("forward"), critical("forward")]
    found = [critical("straight", 50.0, ()), *found, critical("forward", 300.0)]
    results = SimpleNamespace(scene=scene, critical_speeds=found)
    (shown,) = critical_modes(results)
    assert shown.whirl == ("backward", "forward", "straight")
    assert [text.rpartition(", ")[2] for text in shown.texts] == list(shown.whirl)


def test_bodies_without_a_surface_set_the_scale_too(twin):
    """Of one body only its points are known: none of them moves farther than 1."""
    bare = dataclasses.replace(engine_in_space(twin), pieces=())
    bare = dataclasses.replace(bare, bare=twin.elements)
    mode = mode_in_space(bare, pictured_modes(twin, 1)[1], 0)
    moved = [e.recovery_modes @ mode.coordinates[name] for name, e in twin.elements.items()]
    cycle = np.exp(1j * np.linspace(0.0, np.pi, 181))
    size = [np.linalg.norm((f[None] * cycle[:, None, None]).real, axis=2) for f in moved]
    assert max(s.max() for s in size) == pytest.approx(1.0, abs=1e-12)
    assert max(s[0].max() for s in size) == pytest.approx(1.0, abs=1e-12)
    assert with_few_points(bare).bare == {}
