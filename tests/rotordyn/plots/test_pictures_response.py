"""Pictures of responses are written completely and show what they are given."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from solidwhirl.rotordyn import AnalysisError, End
from solidwhirl.rotordyn.plots.response import (
    draw_bearing_forces,
    draw_orbits,
    draw_unbalance_response,
)
from solidwhirl.rotordyn.plots.response_maps import (
    draw_ground_motion,
    draw_place_map,
    draw_stiffness_map,
)
from solidwhirl.rotordyn.response.maps import ground_motion_map, place_map
from solidwhirl.rotordyn.response.stiffness_maps import (
    choose_stiffness,
    synchronous_stiffness_map,
)
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response

RPM = 30.0 / np.pi
DISK = End(body="inner", interface="C")
NODES = (DISK, End(body="inner", interface="B"))


@pytest.fixture(scope="module")
def system(twin):
    return twin(ratio=-1.5, support=5e7, joint=1e8)


@pytest.fixture(scope="module")
def response(system):
    parts = [
        Unbalance(body="inner", interface="C", moment_kg_m=1e-5),
        Unbalance(body="outer", interface="D", moment_kg_m=1e-5),
    ]
    return unbalance_response(system, parts, np.linspace(0.0, 1500.0, 151))


@pytest.fixture(scope="module")
def maps(system):
    speeds, omega = np.linspace(0.0, 900.0, 7), np.linspace(0.0, 1500.0, 61)
    places = place_map(system, [*NODES, End(body="outer", interface="D")], 1e-5, omega)
    one_body = place_map(system, NODES, 1e-5, omega)
    ground = ground_motion_map(system, 1e-6, "x", speeds, omega, DISK)
    unbalance = Unbalance(body="inner", interface="C", moment_kg_m=1e-5)
    names = ["inner.A", "inner.B"]
    stiffness = synchronous_stiffness_map(
        system, names, np.logspace(7, 10, 9), unbalance, omega, DISK
    )
    return places, one_body, ground, stiffness


def _is_png(path):
    return path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_amplitude_and_phase(response, drawn, tmp_path):
    path = tmp_path / "response.png"
    draw_unbalance_response(response, NODES, path, "Twin rotor")
    assert _is_png(path) and [p.name for p in tmp_path.iterdir()] == [path.name]
    upper, beside, lower, _ = drawn[0].axes
    assert upper.get_yscale() == "log"
    assert [axes.get_title() for axes in (upper, beside)] == [
        "unbalance of inner (1×)",
        "unbalance of outer (1.5×)",
    ]
    # No logarithm of the zero at rest.
    (curve,) = [line for line in upper.lines if line.get_label() == "inner.C"]
    assert np.isnan(curve.get_ydata()[0])
    inner = next(e for e in response.exciters if e.bodies == ("inner",))
    factor = {"µm": 1e6, "mm": 1e3, "m": 1.0}[upper.get_ylabel().split("[")[1][:-1]]
    expected = factor * inner.orbits().major_m[1:, inner.nodes.index(DISK)]
    np.testing.assert_allclose(curve.get_ydata()[1:], expected)
    np.testing.assert_allclose(curve.get_xdata(), response.speeds_rad_s * RPM)
    phase = np.concatenate([line.get_ydata() for line in lower.lines])
    assert np.nanmax(np.abs(phase)) <= 180.0
    assert len(upper.texts) >= 2
    legend = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    assert legend[:2] == ["inner.C", "inner.B"]


def test_forces(response, drawn, tmp_path):
    draw_bearing_forces(response, tmp_path / "forces.png", "Twin rotor")
    axes, other = drawn[0].axes
    names = list(response.exciters[0].bearing_forces)
    assert len(axes.lines) == len(other.lines) == len(names)
    # The largest force of a turn, by looking at all instants of half a turn.
    force = response.exciters[0].bearing_forces[names[0]][1:, :2]
    phases = np.exp(1j * np.linspace(0.0, np.pi, 2001))[:, None, None]
    largest = np.linalg.norm((phases * force).real, axis=2).max(axis=0)
    factor = {"kN": 1e-3, "N": 1.0, "MN": 1e-6}[axes.get_ylabel().split("[")[1][:-1]]
    np.testing.assert_allclose(axes.lines[0].get_ydata()[1:], factor * largest, rtol=1e-5)


def test_orbits(response, drawn, tmp_path):
    speeds = response.speeds_rad_s[[0, 40, 80, 120, 150]]
    draw_orbits(response, NODES, speeds, tmp_path / "orbits.png", "Twin rotor")
    shown = [axes for axes in drawn[0].axes if axes.axison]
    # nothing moves at rest
    assert [axes.get_title() for axes in shown] == [
        f"{s * RPM:.0f} rpm,\nunbalance of {body}"
        for body in ("inner", "outer")
        for s in speeds[1:]
    ]
    for axes in shown:
        low, high = axes.get_xlim()
        assert low == -high and axes.get_ylim() == (low, high)
        for line in axes.lines:
            assert np.abs(np.asarray(line.get_data(), dtype=float)).max() <= high


def test_orbits_at_one_speed_take_one_column(response, drawn, tmp_path):
    one = replace(response, exciters=response.exciters[:1])
    draw_orbits(one, NODES, response.speeds_rad_s[[40]], tmp_path / "one.png", "Twin rotor")
    assert drawn[0].get_figwidth() * 25.4 == pytest.approx(88.0)


def test_numbers_of_orbits_do_not_overlap(response, drawn, tmp_path):
    """Measured from the boxes of the text as it is drawn; small orbits have long numbers."""
    draw_orbits(response, NODES, response.speeds_rad_s[[1, 40, 80, 120]], tmp_path / "o.png", "t")
    for axes in drawn[0].axes:
        boxes = [t.get_window_extent() for t in axes.get_xticklabels()]
        assert all(a.x1 < b.x0 for a, b in pairwise(boxes))


def test_place_maps(maps, drawn, tmp_path):
    for index, at in enumerate(maps[:2]):
        draw_place_map(at, DISK, tmp_path / f"{index}.png", "Places")
    curves, first = drawn[0].axes[:2]
    labels = [text.get_text() for text in first.get_yticklabels()]
    assert (
        labels == [line.get_label() for line in curves.lines] == ["inner.C", "inner.B", "outer.D"]
    )
    mesh = drawn[1].axes[1].collections[0].get_array().reshape(2, 61)
    expected = maps[1].major_m()[:, 1:, maps[1].nodes.index(DISK)]
    np.testing.assert_allclose(mesh[:, 1:] / mesh.max(), expected / expected.max())


def test_waterfall(maps, drawn, tmp_path):
    draw_ground_motion(maps[2], tmp_path / "w.png", "Ground")
    axes, bar = drawn[0].axes
    factor = {"µm": 1e6, "mm": 1e3}[bar.get_ylabel().split("[")[1][:-1]]
    shown = axes.collections[0].get_array().reshape(7, 61)
    np.testing.assert_allclose(shown, factor * maps[2].major_m())
    # The dashed line is once per revolution: 60 rpm per Hz.
    (line,) = axes.lines
    x, y = line.get_data()
    assert y[1] == pytest.approx(60.0 * x[1]) == pytest.approx(900.0 * RPM)
    assert "displacement of inner.C for 1e-06 m of the ground" in axes.get_title()


def test_stiffness_map_marks_the_choice(maps, drawn, tmp_path):
    choice = choose_stiffness(maps[3], 800.0)
    draw_stiffness_map(maps[3], tmp_path / "s.png", "Stiffness", choice)
    draw_stiffness_map(maps[3], tmp_path / "t.png", "Stiffness")
    axes = drawn[0].axes[0]
    assert axes.get_yscale() == "log"
    chosen, band = axes.lines
    np.testing.assert_allclose(band.get_xdata()[[0, -1]], np.array(choice.band_rad_s) / (2 * np.pi))
    assert chosen.get_ydata()[0] == choice.stiffness_n_per_m
    assert not drawn[1].axes[0].lines
    np.testing.assert_allclose(axes.get_ylim(), [1e7, 1e10])


def test_wrong_arguments_are_refused(response, maps, tmp_path):
    places, _, ground, _ = maps
    path = tmp_path / "p.png"
    for draw, message in [
        (lambda: draw_unbalance_response(response, [], path, "t"), "0 nodes; 1 to 7"),
        (lambda: draw_unbalance_response(response, 8 * [DISK], path, "t"), "8 nodes; 1 to 7"),
        (
            lambda: draw_unbalance_response(response, NODES, tmp_path / "p.bmp", "t"),
            "suffix '.bmp'; allowed are",
        ),
        (lambda: draw_orbits(response, NODES, [], path, "t"), "0 speeds; 1 to 8"),
        (lambda: draw_orbits(response, NODES, [3.0], path, "t"), "the nearest is 0 rad/s"),
        (
            lambda: draw_place_map(places, End(body="fan", interface="x"), path, "t"),
            "no node fan.x; it has",
        ),
    ]:
        with pytest.raises(AnalysisError, match=message):
            draw()
    still = type(ground)(
        amplitude_m=0.0, direction="x", speeds_rad_s=ground.speeds_rad_s,
        frequencies_rad_s=ground.frequencies_rad_s, node=ground.node,
        translation_m=0.0 * ground.translation_m,
    )  # fmt: skip
    with pytest.raises(AnalysisError, match="amplitude_m of the map is 0"):
        draw_ground_motion(still, path, "t")
    assert not list(tmp_path.iterdir())
