"""Pictures of responses are written completely and show what they are given."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from solidwhirl.rotordyn import End
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.plots.response import (
    ExciterCurves,
    amplitude_chart,
    force_chart,
    orbit_chart,
    phase_chart,
)
from solidwhirl.rotordyn.plots.response_maps import ground_chart, place_chart, stiffness_chart
from solidwhirl.rotordyn.response.maps import ground_motion_map, place_map
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
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
def exciters(response):
    return [
        ExciterCurves(
            bodies=e.bodies,
            frequency_ratio=e.frequency_ratio,
            speed_rpm=e.speeds_rad_s * RPM,
            motion_m={n.label: e.at_node(n.body, n.interface) for n in NODES},
            force_n={
                name: elliptic_orbits(*force[:, :2].T).major_m
                for name, force in e.bearing_forces.items()
            },
        )
        for e in response.exciters
    ]


def test_amplitude_and_phase(response, exciters, drawn, tmp_path):
    draw_charts([amplitude_chart(exciters), phase_chart(exciters)], tmp_path / "r.png", "Twin")
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
    legend = [text.get_text() for text in drawn[0].legends[0].get_texts()]
    assert legend[:2] == ["inner.C", "inner.B"]


def test_forces(response, exciters, drawn, tmp_path):
    draw_charts([force_chart(exciters)], tmp_path / "forces.png", "Twin rotor")
    axes, other = drawn[0].axes
    names = list(response.exciters[0].bearing_forces)
    assert len(axes.lines) == len(other.lines) == len(names)
    # The largest force of a turn, by looking at all instants of half a turn.
    force = response.exciters[0].bearing_forces[names[0]][1:, :2]
    phases = np.exp(1j * np.linspace(0.0, np.pi, 2001))[:, None, None]
    largest = np.linalg.norm((phases * force).real, axis=2).max(axis=0)
    factor = {"kN": 1e-3, "N": 1.0, "MN": 1e-6}[axes.get_ylabel().split("[")[1][:-1]]
    np.testing.assert_allclose(axes.lines[0].get_ydata()[1:], factor * largest, rtol=1e-5)


def test_orbits(response, exciters, drawn, tmp_path):
    rows = [0, 1, 40, 80, 120]
    speeds = response.speeds_rad_s[rows]
    draw_charts([orbit_chart([(e, rows) for e in exciters])], tmp_path / "orbits.png", "Twin")
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
        # small orbits have long numbers, which do not overlap as they are drawn
        boxes = [t.get_window_extent() for t in axes.get_xticklabels()]
        assert all(a.x1 < b.x0 for a, b in pairwise(boxes))


def test_orbits_at_one_speed_take_one_column(exciters, drawn, tmp_path):
    draw_charts([orbit_chart([(exciters[0], [40])])], tmp_path / "one.png", "Twin rotor")
    assert drawn[0].get_figwidth() * 25.4 == pytest.approx(88.0)


def test_place_maps(system, drawn, tmp_path):
    places = [*NODES, End(body="outer", interface="D")]
    found = place_map(system, places, 1e-5, np.linspace(0.0, 1500.0, 61))
    size = found.major_m()[:, :, found.nodes.index(DISK)]
    names = [place.label for place in places]
    hertz = found.frequencies_rad_s / (2.0 * np.pi)
    draw_charts([place_chart(names, found.speeds_rad_s * RPM, hertz, size)], tmp_path / "p.png", "")
    curves, mesh = drawn[0].axes[:2]
    labels = [text.get_text() for text in mesh.get_yticklabels()]
    assert labels == [line.get_label() for line in curves.lines] == names
    cells = mesh.collections[0].get_array().reshape(3, 61)
    np.testing.assert_allclose(cells[:, 1:] / cells.max(), size[:, 1:] / size.max())


def test_waterfall(system, drawn, tmp_path):
    speeds, omega = np.linspace(0.0, 900.0, 7), np.linspace(0.0, 1500.0, 61)
    found = ground_motion_map(system, 1e-6, "x", speeds, omega, DISK)
    chart = ground_chart(omega / (2.0 * np.pi), speeds * RPM, found.major_m())
    draw_charts([chart], tmp_path / "w.png", "Ground")
    axes, bar = drawn[0].axes
    factor = {"µm": 1e6, "mm": 1e3}[bar.get_ylabel().split("[")[1][:-1]]
    shown = axes.collections[0].get_array().reshape(7, 61)
    np.testing.assert_allclose(shown, factor * found.major_m())
    # The dashed line is once per revolution: 60 rpm per Hz.
    (line,) = axes.lines
    x, y = line.get_data()
    assert y[1] == pytest.approx(60.0 * x[1]) == pytest.approx(900.0 * RPM)


def test_stiffness_map_marks_the_choice(drawn, tmp_path):
    hertz, stiffness = np.linspace(1.0, 200.0, 11), np.logspace(7, 10, 9)
    size = np.abs(np.sin(np.outer(stiffness / 1e9, hertz))) + 1e-3
    for chosen in ((3e8, (100.0, 150.0)), None):
        draw_charts([stiffness_chart(hertz, stiffness, size, chosen)], tmp_path / "s.png", "t")
    axes = drawn[0].axes[0]
    assert axes.get_yscale() == "log"
    line, band = axes.lines
    assert line.get_ydata()[0] == 3e8
    np.testing.assert_allclose(band.get_xdata()[[0, -1]], [100.0, 150.0])
    assert not drawn[1].axes[0].lines
    np.testing.assert_allclose(axes.get_ylim(), [1e7, 1e10])
