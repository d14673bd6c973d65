"""Spectra of signals that are known, and responses of a disk that is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, hub, one_rotor

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up import force_spectrum, response
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold

TIME = np.arange(4000) / 2000.0


@pytest.mark.parametrize("window", ["boxcar", "hann", "flattop"])
def test_amplitudes_of_lines_on_the_grid(window):
    signal = 3.0 + 2.0 * np.cos(2 * np.pi * 100.0 * TIME + 0.3) + 0.5 * np.cos(2e3 * np.pi * TIME)
    found = force_spectrum.amplitude_spectrum(TIME, np.stack((signal, -2 * signal)), window)
    assert found.amplitude.shape == (2, 2001) and found.window == window
    assert found.frequency_hz[[0, -1]].tolist() == [0.0, 1000.0]
    # whole periods in the record: exact but for rounding
    for place, amplitude in ((0, 3.0), (200, 2.0), (2000, 0.5)):
        assert found.amplitude[0, place] == pytest.approx(amplitude, rel=1e-12)
        assert found.amplitude[1, place] == pytest.approx(2 * amplitude, rel=1e-12)


def test_flattop_keeps_amplitudes_between_the_lines():
    for window, worst in (("flattop", 2e-3), ("hann", 0.16)):
        waves = np.cos(2 * np.pi * np.multiply.outer(np.linspace(100.0, 100.5, 7), TIME))
        found = force_spectrum.amplitude_spectrum(TIME, waves, window)
        errors = found.amplitude.max(axis=1) - 1.0
        # Harris 1978: scalloping losses of 0.01 dB and of 1.42 dB
        assert np.abs(errors).max() < worst
    assert np.abs(errors).max() > 0.1


def test_spectrogram_follows_a_sweep():
    rate = 200.0
    signal = 1.5 * np.cos(2 * np.pi * (50.0 * TIME + 0.5 * rate * TIME**2))
    found = force_spectrum.spectrogram(TIME, signal, 0.1, overlap=0.5)
    assert found.amplitude.shape == (found.frequency_hz.size, found.time_s.size)
    ridge = found.frequency_hz[found.amplitude.argmax(axis=0)]
    # a bin is 10 Hz wide, and the sweep moves by 20 Hz in a piece
    np.testing.assert_allclose(ridge, 50.0 + rate * found.time_s, atol=6.0)
    assert found.time_s[0] == pytest.approx(0.05, abs=1e-3)
    # the blur takes some of the amplitude
    assert (found.amplitude.max(axis=0) > 1.0).all()


def accelerating():
    angle = 300.0 * TIME + 0.5 * 200.0 * TIME**2
    return angle, (TIME > 0.3) & (TIME < 1.7)


def test_orders_of_a_real_signal_are_kept_apart():
    angle, inside = accelerating()
    amplitude = 2.0 * np.exp(0.4j)
    signal = (amplitude * np.exp(1j * angle)).real + 3.0 * np.cos(2.5 * angle + 1.0)
    found = force_spectrum.order_amplitude(TIME, angle, signal, 1.0, 0.2)
    # the Hann window keeps out what is 14 lines away by 80 dB
    np.testing.assert_allclose(found[inside], amplitude, atol=1e-3)
    other = force_spectrum.order_amplitude(TIME, angle, signal, 2.5, 0.2)
    np.testing.assert_allclose(other[inside], 3.0 * np.exp(1j), atol=1e-3)
    assert np.isnan(found[:200]).all() and np.isnan(found[-200:]).all()


def test_forward_and_backward_parts_of_a_path_are_kept_apart():
    angle, inside = accelerating()
    path = 2.0j * np.exp(1j * angle) + 0.5 * np.exp(-1j * angle)
    for order, amplitude in ((1.0, 2j), (-1.0, 0.5)):
        found = force_spectrum.order_amplitude(TIME, angle, path, order, 0.2)
        np.testing.assert_allclose(found[inside], amplitude, atol=1e-3)
    # at a slow start the window does not hold two turns
    slow = 5.0 * TIME
    assert np.isnan(force_spectrum.order_amplitude(TIME, slow, np.cos(slow), 1.0, 0.2)).all()


MASS, NATURAL, RATIO = 10.0, 120.0, 0.03
STIFFNESS, DAMPING = MASS * NATURAL**2, 2 * RATIO * MASS * NATURAL


@pytest.fixture(scope="module")
def swept():
    """A damped disk with two unbalances that turns backward, run up slowly past resonance."""
    held = ground("rotor", "hub", STIFFNESS, None, DAMPING, tilt=1e6)
    system = one_rotor(hub(mass_kg=MASS), [held], -1.5)
    unbalances = [
        Unbalance(body="rotor", interface="hub", moment_kg_m=1e-3),
        Unbalance(body="rotor", interface="hub", moment_kg_m=5e-4, phase_rad=1.1),
    ]
    options = {"step_s": 1e-3, "record_every": 2, "bearings": ["rotor.hub"]}
    return run_up(system, ramp_and_hold(200.0, 60.0), unbalances, **options)


def transmissibility(frequency_hz):
    omega = 2 * np.pi * frequency_hz
    through = STIFFNESS + 1j * omega * DAMPING
    return np.abs(through / (through - MASS * omega**2))


@pytest.mark.verify
@pytest.mark.parametrize("axis", ["x", "y"])
def test_normalised_response_of_a_slow_sweep_is_the_transmissibility(swept, axis):
    found = response.normalised_response(swept, "rotor.hub", axis, band_hz=0.4)
    inside = (found.frequency_hz > 5.0) & (found.frequency_hz < 44.0)
    expected = transmissibility(found.frequency_hz)
    # Resonance of width 2Dω0 = 7.2 rad/s swept at 5 rad/s²: of the order of 5/3.6² but for the
    # linearity, which keeps the ratio of the transforms; the band of 0.4 Hz takes 2 % of the peak.
    np.testing.assert_allclose(found.ratio[inside], expected[inside], rtol=0.05)
    assert found.ratio[inside].max() == pytest.approx(1 / (2 * RATIO), rel=0.03)


def test_normalised_response_ends_where_the_excitation_does(swept):
    # 1.5 times 200 rad/s; 60 s resolve 2/60 Hz
    fastest = 300.0 / (2 * np.pi)
    assert response.excited_band_hz(swept) == pytest.approx((2.0 / 60.0, fastest), rel=1e-3)
    found = response.normalised_response(swept, "rotor.hub", band_hz=0.4)
    known = np.isfinite(found.ratio)
    assert found.excited_hz == response.excited_band_hz(swept)
    assert not known[found.frequency_hz > fastest + 0.2].any()
    assert known[(found.frequency_hz > 1.0) & (found.frequency_hz < fastest - 0.4)].all()
    assert found.frequency_hz[-1] > 200.0  # the axis itself goes as far as the record


def test_peaks_of_a_spectrum_are_more_than_side_lobes():
    """Lines of known height: kept down to 1e-4 of the highest, beyond only above the lobes."""
    lines = {100.25: 1.0, 300.0: 5e-4, 340.0: 2e-5, 105.0: 3.5e-3}
    signal = sum(a * np.cos(2 * np.pi * f * TIME + f) for f, a in lines.items())
    spectrum = force_spectrum.amplitude_spectrum(TIME, signal)
    # 340 Hz is too low; at 105 Hz, 9.5 lines off, lobes reach 1/(π 9.5 (9.5² − 1)) = 4e-4
    for driven, expected in ((100.25, [100.25, 300.0]), (150.0, [100.25, 105.0, 300.0])):
        peaks = force_spectrum.spectrum_peaks(spectrum, 1.0, driven_to_hz=driven)
        hertz = [p.position_rad_s / (2 * np.pi) for p in peaks]
        assert hertz == pytest.approx(expected, abs=0.1)
    plain = force_spectrum.amplitude_spectrum(TIME, signal, "boxcar")
    with pytest.raises(AnalysisError, match="window 'boxcar'; allowed"):
        force_spectrum.spectrum_peaks(plain, 1.0, 100.0)


def test_order_response_of_a_slow_sweep_is_the_transmissibility(swept):
    found = response.order_response(swept, "rotor.hub", "rotor", 0.4)
    inside = (found.frequency_hz > 8.0) & (found.frequency_hz < 44.0) & np.isfinite(found.ratio)
    assert inside.sum() > 1e4
    error = found.ratio[inside] / transmissibility(found.frequency_hz[inside]) - 1.0
    away = np.abs(2 * np.pi * found.frequency_hz[inside] - NATURAL) > 30.0
    # far from resonance the response is steady; near it the sweep of 5 rad/s² comes late by about
    # 5/3.6 = 1.4 rad/s, of a half width of 3.6 rad/s
    assert np.abs(error[away]).max() < 0.02
    assert np.abs(error).max() < 0.6
    assert found.ratio[inside].max() == pytest.approx(1 / (2 * RATIO), rel=0.1)


def test_excitation_is_the_inertia_of_the_turning_mass(swept):
    assert response.excited_bodies(swept) == ("rotor",)
    times = np.linspace(1.0, 59.0, 7)
    step = 1e-4

    def place(t):
        angle = -1.5 * swept.profile.angle_rad(t)
        return 1e-3 * np.exp(1j * angle) + 5e-4 * np.exp(1j * (angle + 1.1))

    expected = -(place(times + step) - 2 * place(times) + place(times - step)) / step**2
    # differences: (ωh)²/12 of 7.5e-5 at 300 rad/s
    np.testing.assert_allclose(response.excitation_force_n(swept, times)[0], expected, rtol=1e-4)


@pytest.mark.parametrize(
    ("name", "arguments", "text"),
    [
        ("amplitude_spectrum", (TIME, TIME[:-1]), r"signal \(3999,\)"),
        ("amplitude_spectrum", (TIME**2, TIME), "not evenly spaced"),
        ("amplitude_spectrum", (TIME, np.full(4000, np.inf)), "not finite"),
        ("amplitude_spectrum", (TIME, TIME, "square"), "window is 'square'; allowed are"),
        ("amplitude_spectrum", (TIME, 1j * TIME), "the signal is complex"),
        ("spectrogram", (TIME, TIME, 9.0), "duration_s is 9.0"),
        ("spectrogram", (TIME, TIME, 0.1, "hann", 1.0), "overlap is 1.0"),
        ("order_amplitude", (TIME, TIME, TIME, 0.0, 0.1), "order is 0.0"),
        ("order_amplitude", (TIME, TIME[1:], TIME, 1.0, 0.1), r"the angle \(3999,\)"),
    ],
)
def test_what_makes_no_sense_is_refused(name, arguments, text):
    with pytest.raises(AnalysisError, match=text):
        getattr(force_spectrum, name)(*arguments)


def test_responses_refuse_what_is_not_there(swept):
    with pytest.raises(AnalysisError, match="'nose' was not recorded"):
        response.normalised_response(swept, "nose")
    with pytest.raises(AnalysisError, match="axis is 'z'"):
        response.normalised_response(swept, "rotor.hub", "z")
    with pytest.raises(AnalysisError, match="'casing' has no unbalance"):
        response.order_response(swept, "rotor.hub", "casing", 0.5)


def test_responses_need_unbalance_and_enough_records():
    system = one_rotor(hub(), [ground("rotor", "hub", 1e5, tilt=1e6)])
    profile = SpeedProfile(times_s=[0.0, 1.0], speeds_rad_s=[300.0, 300.0])
    options = {"step_s": 1e-3, "bearings": ["rotor.hub"], "record_every": 10}
    still = run_up(system, profile, [], **options)
    with pytest.raises(AnalysisError, match="no unbalance to normalise with"):
        response.normalised_response(still, "rotor.hub")
    with pytest.raises(AnalysisError, match="nothing is excited"):
        response.excited_band_hz(still)
    unbalance = [Unbalance(body="rotor", interface="hub", moment_kg_m=1e-3)]
    with pytest.raises(AnalysisError, match=r"at 100 Hz, the excitation goes to 47.7\d+ Hz"):
        response.normalised_response(run_up(system, profile, unbalance, **options), "rotor.hub")
