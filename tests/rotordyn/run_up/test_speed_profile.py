"""The speed profile: exact angle, one-sided acceleration, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold


def test_angle_is_the_integral_of_the_speed():
    profile = SpeedProfile(times_s=[0.0, 0.7, 1.0, 2.5], speeds_rad_s=[10.0, 150.0, 150.0, -40.0])
    for time in (0.0, 0.3, 0.7, 0.85, 1.9, 2.5):
        breaks = [t for t in (0.7, 1.0) if t < time] or None
        expected, _ = quad(lambda t: float(profile.speed_rad_s(t)), 0.0, time, points=breaks)
        # adaptive quadrature is exact for straight lines but for rounding
        assert float(profile.angle_rad(time)) == pytest.approx(expected, rel=1e-13, abs=1e-13)


def test_speed_and_acceleration_at_breakpoints():
    profile = ramp_and_hold(60.0, 2.0, 1.0, start_speed_rad_s=10.0)
    np.testing.assert_array_equal(profile.speed_rad_s([0.0, 1.0, 2.0, 3.0]), [10, 35, 60, 60])
    # right-continuous: at 2 s the ramp is over
    np.testing.assert_array_equal(
        profile.acceleration_rad_s2([0.0, 1.999, 2.0, 3.0]), [25, 25, 0, 0]
    )
    assert profile.duration_s == 3.0
    assert ramp_and_hold(60.0, 2.0).times_s.size == 2


@pytest.mark.parametrize(
    ("times", "speeds", "text"),
    [
        ([0.0], [1.0], "two or more"),
        ([0.0, 1.0], [1.0, 2.0, 3.0], r"speeds of shape \(3,\)"),
        ([0.0, np.nan], [1.0, 2.0], "not finite"),
        ([0.1, 1.0], [1.0, 2.0], "rise from 0"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], "rise from 0"),
    ],
)
def test_profiles_without_meaning_are_refused(times, speeds, text):
    with pytest.raises(AnalysisError, match=text):
        SpeedProfile(times_s=times, speeds_rad_s=speeds)


def test_times_outside_and_bad_durations_are_refused():
    profile = ramp_and_hold(60.0, 2.0)
    with pytest.raises(AnalysisError, match=r"time 2.1 s is outside .* from 0 to 2 s"):
        profile.speed_rad_s([1.0, 2.1])
    with pytest.raises(AnalysisError, match="ramp_s is 0"):
        ramp_and_hold(60.0, 0.0)
    with pytest.raises(AnalysisError, match="hold_s is -1"):
        ramp_and_hold(60.0, 1.0, -1.0)
