"""Error estimates of resonance peaks against peaks of the whole body, found by fine sampling."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    ground,
    one_rotor,
    polynomial_law,
    truncated,
    twin,
    twin_bearings,
    twin_bodies,
    twin_rotors,
    with_stress,
)

from solidwhirl.rotordyn import AnalysisError, assemble
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.estimates.response_errors import (
    amplitude_error,
    harmonic_peak_errors,
    unbalance_peak_errors,
)
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.response.unbalance_peaks import resonance_peaks

LAW = polynomial_law((1.0, -1e-4), (1.0, -1e-4), (1.0, 1e-4), (1.0, 1e-4), top=4000.0)


def _fine_peaks(curve, positions, count):
    """Peaks of a curve (x) -> y by sampling twice, the second time around each peak."""
    found = resonance_peaks(positions, curve(positions))[:count]
    fine = []
    for peak in found:
        width = peak.position_rad_s / max(peak.amplification, 1.0) / 50
        around = peak.position_rad_s + width * np.linspace(-10, 10, 41)
        inner = resonance_peaks(around, curve(around), 1.0)
        fine.append(max(inner, key=lambda p: p.amplitude))
    assert len(fine) == count
    return found, fine


def _orbit_curve(system, unbalances, node):
    def curve(speeds):
        part = unbalance_response(system, unbalances, speeds).exciters[0]
        return part.orbits().major_m[:, part.nodes.index(node)]

    return curve


def _compare(found, exact, coarse, sampled, rtol):
    """Check positions and heights; what is left is (s/ω_c)², and the width of the peaks."""
    for parts, name, total in (
        (found.position, "position_rad_s", found.position_total),
        (found.height, "amplitude", found.height_total),
    ):
        pairs = zip(sampled, coarse, strict=True)
        read = [abs(1 - getattr(a, name) / getattr(b, name)) for a, b in pairs]
        np.testing.assert_allclose(parts["sampling"], read, rtol=1e-2, atol=1e-6)
        others = sum(values for part, values in parts.items() if part != "sampling")
        np.testing.assert_allclose(total, others + parts["sampling"], rtol=1e-12)
    pairs = list(zip(exact, coarse, strict=True))
    position = [abs(1 - a.position_rad_s / b.position_rad_s) for a, b in pairs]
    height = [abs(1 - a.amplitude / b.amplitude) for a, b in pairs]
    places = [b.position_rad_s for _, b in pairs]
    np.testing.assert_allclose(found.position_rad_s, places, rtol=1e-5)
    # 1e-6: accuracy of the parabola through fine samples
    moved = found.position_total - found.position["sampling"]
    higher = found.height_total - found.height["sampling"]
    np.testing.assert_allclose(moved, position, rtol=rtol, atol=1e-6)
    np.testing.assert_allclose(higher, height, rtol=rtol, atol=1e-5)


@pytest.mark.parametrize(("ratio", "law"), [(1.0, None), (-1.5, LAW)])
def test_unbalance_peaks(full, ratio, law):
    held = [ground("rotor", e, 7e7, 5e7, 8e3, 6e3, speed_law=law) for e in ("left", "right")]
    whole, cut = one_rotor(full, held, ratio), one_rotor(truncated(full, 6), held, ratio)
    node = End(body="rotor", interface="right")
    unbalances = [
        Unbalance(body="rotor", interface="left", moment_kg_m=1e-3),
        Unbalance(body="rotor", interface="right", moment_kg_m=4e-4, phase_rad=1.0),
    ]
    speeds = np.linspace(100.0, 1000.0, 901) / abs(ratio)
    _, exact = _fine_peaks(_orbit_curve(whole, unbalances, node), speeds, 2)
    sampled, coarse = _fine_peaks(_orbit_curve(cut, unbalances, node), speeds, 2)
    found = unbalance_peak_errors(cut, unbalances, node, sampled)
    _compare(found, exact, coarse, sampled, 0.1)
    assert found.bodies_without_estimate == () and "mode_truncation" in found.height


@pytest.mark.parametrize("direction", [None, 0.7])
def test_amplitude_at_one_speed(full, direction):
    """On flanks and between peaks: the change of what a probe sees, or of the major half axis."""
    held = [ground("rotor", e, 7e7, 5e7, 8e3, 6e3) for e in ("left", "right")]
    whole, cut = (one_rotor(body, held) for body in (full, truncated(full, 6)))
    node = End(body="rotor", interface="right")
    unbalances = [Unbalance(body="rotor", interface="left", moment_kg_m=1e-3)]
    speeds = np.array([250.0, 500.0, 800.0])

    def sizes(system):
        part = unbalance_response(system, unbalances, speeds).exciters[0]
        if direction is None:
            return part.orbits().major_m[:, part.nodes.index(node)]
        return np.abs(part.at_node("rotor", "right") @ [np.cos(direction), np.sin(direction)])

    exact, coarse = sizes(whole), sizes(cut)
    found = [amplitude_error(cut, unbalances, node, direction, speed) for speed in speeds]
    np.testing.assert_allclose(found, np.abs(1.0 - exact / coarse), rtol=0.1, atol=1e-6)


def test_peaks_over_the_frequency_at_one_speed():
    bodies = [with_stress(body, 0.5) for body in twin_bodies()]
    cut = [truncated(bodies[0], 10), truncated(bodies[1], 4)]
    damping = {"damping_n_s_per_m": 2e3 * np.eye(2)}
    held = tuple(dataclasses.replace(b, **damping) for b in twin_bearings(1e8, 1e8))
    whole, small = (assemble(twin_rotors(-1.3, bodies=both), held) for both in (bodies, cut))

    def curve(system):
        row = interface_row(system, "inner", "C", "ux")

        def receptance(omega):
            found = harmonic_response(system, 900.0, omega, row[None, :, None])
            return np.abs(found.displacement[:, :, 0] @ row)

        return receptance

    omega = np.linspace(500.0, 4000.0, 3501)
    _, exact = _fine_peaks(curve(whole), omega, 3)
    sampled, coarse = _fine_peaks(curve(small), omega, 3)
    row = interface_row(small, "inner", "C", "ux")
    found = harmonic_peak_errors(small, 900.0, row, row, sampled)
    _compare(found, exact, coarse, sampled, 0.15)


def test_peaks_without_damping_have_a_place_and_no_height(full):
    held = [ground("rotor", end, 7e7, 7e7) for end in ("left", "right")]
    whole, cut = one_rotor(full, held), one_rotor(truncated(full, 8), held)
    node = End(body="rotor", interface="right")
    unbalances = [Unbalance(body="rotor", interface="left", moment_kg_m=1e-3)]
    speeds = np.linspace(100.0, 600.0, 501)
    peaks = resonance_peaks(speeds, _orbit_curve(cut, unbalances, node)(speeds))
    found = unbalance_peak_errors(cut, unbalances, node, peaks)
    assert np.isnan(found.height_total).all() and len(peaks) >= 1
    place = 0.2 * (speeds[1] - speeds[0]) * np.linspace(-1, 1, 2001)
    for peak, error in zip(peaks, found.position_total, strict=True):
        tops = []
        for system in (whole, cut):  # largest next to the pole itself
            near = peak.position_rad_s + 5 * place
            part = unbalance_response(system, unbalances, near).exciters[0]
            motion = part.at_node(node.body, node.interface)[:, 0].real
            tops.append(near[np.abs(motion).argmax()])
        true = abs(1 - tops[0] / tops[1])
        assert error == pytest.approx(true, abs=4e-6, rel=0.2)  # samples of 1e-6 of the speed


def test_refusals_and_no_peaks(full):
    held = [ground("rotor", end, 7e7, 5e7, 1e3, 1e3) for end in ("left", "right")]
    system = one_rotor(truncated(full, 8), held)
    node = End(body="rotor", interface="right")
    unbalance = Unbalance(body="rotor", interface="left", moment_kg_m=1e-3)
    none = unbalance_peak_errors(system, [unbalance], node, ())
    assert none.position_total.shape == none.height_total.shape == (0,)
    both = [Unbalance(body=b, interface="C", moment_kg_m=1e-3) for b in ("inner", "outer")]
    at = End(body="inner", interface="A")
    for arguments in ((system, [], node, ()), (twin(ratio=-1.5), both, at, ())):
        with pytest.raises(AnalysisError, match="one ratio are allowed"):
            unbalance_peak_errors(*arguments)
    with pytest.raises(AnalysisError, match="load and row have shapes"):
        harmonic_peak_errors(system, 0.0, np.ones(3), np.ones(system.size), ())
