"""Stability thresholds against closed forms, and the least damping over the speed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import between_bearings, connect, hub, one_rotor, three_disk, three_disk_element, twin

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.bearing_laws import BearingCoefficients
from solidwhirl.rotordyn.checks.plain_responses import check_stability
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.stability.intervals import stability_chart, unstable_intervals

MASS, OMEGA = 10.0, 300.0
STIFFNESS = MASS * OMEGA**2

TURN = np.zeros((4, 4))
TURN[1, 0] = TURN[3, 2] = 1.0
TURN[0, 1] = TURN[2, 3] = -1.0


def first_window(system, speed_max_rad_s):
    """The unstable interval that begins first above rest, None if nothing grows."""
    return next(iter(unstable_intervals(system, 0.0, speed_max_rad_s)), None)


def laval(internal, external, tilt=10.0, bearings=(), ratio=1.0):
    """Disk at the middle of a massless shaft: internal damping β K, external damping at the disk.

    The tilts have a stiffness of their own and no polar inertia.
    """
    spring = np.diag([STIFFNESS, STIFFNESS, 2e4, 2e4])
    disk = hub(mass_kg=MASS, polar_kg_m2=0.0, stiffness=spring)
    disk = dataclasses.replace(disk, spin_generator=TURN)
    beta = rd.InternalDamping(stiffness_coefficient_s=internal / STIFFNESS)
    support = connect("support", "rotor.hub", damping=external, drag=tilt)
    return one_rotor(disk, [support, *bearings], ratio, internal_damping=beta)


@pytest.mark.parametrize(("internal", "external"), [(50, 120), (5, 500), (50, 50), (400, 30)])
def test_laval_rotor_with_internal_damping(internal, external):
    """Ω = ω0 (1 + d_a/d_i), whirling forward at ω0."""
    system = laval(float(internal), float(external))
    exact = OMEGA * (1 + external / internal)
    found = first_window(system, 1.7 * exact)
    assert found is not None
    assert found.low_rad_s == pytest.approx(exact, rel=1e-10)
    assert (found.kind, found.whirl) == ("flutter", "forward")
    assert found.frequency_hz == pytest.approx(OMEGA / (2 * np.pi), rel=1e-10)
    assert abs(found.eigenvalue.real) < 1e-9 * OMEGA
    np.testing.assert_allclose(np.abs(found.shape), [1, 1, 0, 0], atol=1e-9)
    assert first_window(system, 0.99 * exact) is None


@pytest.mark.parametrize("damping", [{"stiffness_coefficient_s": 1e-6}, {"modal_ratio": 0.01}])
def test_without_external_damping_the_critical_speed_is_the_threshold(damping):
    """A synchronous forward whirl does not deform the shaft in time, so nothing damps it."""
    plain = between_bearings(three_disk_element(), 7e7)
    forward = next(c for c in rd.critical_speeds(plain, 1.0, 2000.0) if c.whirl == "forward")
    inside = rd.InternalDamping(**damping)
    found = first_window(between_bearings(three_disk_element(), 7e7, inside=inside), 700.0)
    assert found.low_rad_s == pytest.approx(forward.speed_rad_s, rel=1e-9)
    assert found.whirl == "forward"


def test_counter_rotating_body_is_driven_backward():
    """With n = −2 the material turns twice as fast the other way."""
    found = first_window(laval(50.0, 120.0, ratio=-2.0), 1000.0)
    assert found.low_rad_s == pytest.approx(0.5 * OMEGA * (1 + 120 / 50), rel=1e-10)
    assert found.whirl == "backward"


@dataclasses.dataclass(frozen=True)
class _HalfSpeedFilm:
    """Law of a user that tells nothing of its structure: c = 100, κ = c Ω/2."""

    name: str = "law"
    speed_range_rad_s: tuple[float, float] = (0.0, 1e4)

    def coefficients(self, speed_rad_s, stiffness_n_per_m, damping_n_s_per_m):
        cross = 50.0 * speed_rad_s * np.array([[0.0, 1.0], [-1.0, 0.0]])
        return BearingCoefficients(cross, 100.0 * np.eye(2))


def test_cross_coupled_film():
    """Instability where the cross-coupling reaches c ω0 (half-speed whirl at κ = c Ω/2)."""
    film = connect("film", "rotor.hub", speed_law=_HalfSpeedFilm())
    found = first_window(laval(0.0, 0.0, bearings=(film,)), 2000.0)
    assert found.low_rad_s == pytest.approx(2 * OMEGA, rel=1e-10)
    assert found.whirl == "forward"


@pytest.mark.parametrize("external", [120.0, 0.0])
def test_divergence(external):
    """Stiffness k − Ω² s vanishes at √(k/s), whatever the damping."""
    system = laval(0.0, external, tilt=10.0 if external else 0.0)
    softening = -np.diag([3.0, 3.0, 0.0, 0.0])
    system = dataclasses.replace(system, centrifugal_stiffness=softening)
    exact = np.sqrt(STIFFNESS / 3.0)
    found = first_window(system, 2 * exact)
    # Without damping the eigenvalues ±iω meet in zero: no sign changes, growth starts there.
    assert found.low_rad_s == pytest.approx(exact, rel=1e-10)
    assert (found.kind, found.frequency_hz, found.whirl) == ("divergence", 0.0, "")


def test_stable_systems_have_no_threshold_and_driven_ones_none_above_rest():
    assert first_window(laval(0.0, -5.0), 1000.0).low_rad_s == 0.0
    assert first_window(laval(0.0, 100.0), 3000.0) is None
    assert first_window(twin(), 2000.0) is None
    assert first_window(three_disk(), 2500.0) is None


@pytest.mark.parametrize(
    ("find", "message"),
    [
        (lambda system: first_window(system, 0.0), "it must be above 0.0"),
        (lambda system: first_window(system, np.inf), "speeds are 0.0 and inf"),
        (lambda system: stability_chart(system, []), "one or more finite speeds"),
    ],
)
def test_searches_without_meaning_are_refused(find, message):
    with pytest.raises(rd.AnalysisError, match=message):
        find(laval(1.0, 1.0))


def test_chart_of_the_laval_rotor():
    """δ = −2π Re λ / ω of the forward whirl, from m λ² + (d_i + d_a) λ + k − iΩ d_i = 0."""
    internal, external = 50.0, 120.0
    speeds = np.linspace(0, 1500, 7)
    chart = stability_chart(laval(internal, external, tilt=1e3), speeds)
    for k, speed in enumerate(speeds):
        roots = np.roots([MASS, internal + external, STIFFNESS - 1j * speed * internal])
        forward = roots[roots.imag > 0][0]
        decrement = -2 * np.pi * forward.real / forward.imag
        assert chart.log_decrement[k] == pytest.approx(decrement, rel=1e-9, abs=1e-12)
        assert chart.growth_rate_1_s[k] == pytest.approx(forward.real, rel=1e-9)
        assert chart.frequency_hz[k] == pytest.approx(forward.imag / (2 * np.pi), rel=1e-9)
    unstable = speeds > OMEGA * (1 + external / internal)
    np.testing.assert_array_equal(chart.unstable_count, unstable.astype(int))


def test_chart_shows_divergence():
    system = laval(0.0, 120.0)
    softened = dataclasses.replace(system, centrifugal_stiffness=-np.diag([3.0, 3.0, 0.0, 0.0]))
    chart = stability_chart(softened, [100.0, 600.0])
    assert chart.unstable_count.tolist() == [0, 2]
    # m λ² + d λ + k − Ω² s = 0.
    exact = np.roots([MASS, 120.0, STIFFNESS - 3.0 * 600.0**2]).max()
    assert chart.growth_rate_1_s[1] == pytest.approx(exact, rel=1e-9)


def test_an_interval_in_which_nothing_grows_fails_its_check():
    """Neutral motion is no fault of an interval's edge, but it is one at its largest growth."""
    internal, external = 50.0, 120.0
    onset = OMEGA * (1 + external / internal)
    plain = PlainSystem.of(laval(internal, external))
    undamped = PlainSystem.of(laval(0.0, 0.0))

    def passes(system, low, high, top):
        (check,) = check_stability(system, [(low, high, top)], (0.0, 1.5 * onset), (), "s")
        return check.passed

    assert passes(plain, onset, 1.5 * onset, 1.5 * onset)
    assert not passes(plain, 0.9 * onset, 1.5 * onset, 1.5 * onset)
    assert not passes(plain, 1.1 * onset, 1.5 * onset, 1.5 * onset)
    assert not passes(undamped, onset, 1.2 * onset, 1.1 * onset)
