"""Separation margins against the formulas by hand, and amplification of a rotor in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, hub, one_rotor, twin

from solidwhirl.rotordyn import AnalysisError, critical_speeds
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.assembly.system import matrices_at_speed
from solidwhirl.rotordyn.modes.damping import amplification_factor
from solidwhirl.rotordyn.modes.whirl import excitation_by
from solidwhirl.rotordyn.response.separation_margins import (
    MarginMethod,
    OperatingRange,
    Resonance,
    margin_verdict,
    resonances_of_modes,
    separation_margins,
)


@pytest.mark.parametrize("damping_ratio", [1e-3, 0.05, 0.2])
def test_amplification_from_the_log_decrement(damping_ratio):
    decrement = 2 * np.pi * damping_ratio / np.sqrt(1 - damping_ratio**2)
    assert amplification_factor(decrement) == pytest.approx(0.5 / damping_ratio, rel=1e-13)
    # π/δ is the same to first order: they differ by ζ²/2.
    near = amplification_factor(decrement) / (np.pi / decrement) - 1
    assert near == pytest.approx(damping_ratio**2 / 2, rel=0.05)
    assert amplification_factor(-decrement) == pytest.approx(-0.5 / damping_ratio, rel=1e-13)
    assert amplification_factor(0.0) == np.inf


def _resonance(speed, factor, **options):
    return Resonance(speed_rad_s=speed, amplification_factor=factor, **options)


def _margins(*resonances):
    operating = OperatingRange(shaft="LP", speed_low_rad_s=800.0, speed_high_rad_s=1000.0)
    return separation_margins(operating, resonances)


def test_margins_below_inside_and_above():
    speeds = [400.0, 672.0, 688.0, 800.0, 1000.0, 1160.0, 1240.0, 1300.0]
    found = _margins(*(_resonance(s, 11.5) for s in reversed(speeds)))
    assert [m.resonance.speed_rad_s for m in found] == speeds
    margins = [-0.5, -0.16, -0.14, 0.0, 0.0, 0.16, 0.24, 0.30]
    np.testing.assert_allclose([m.margin for m in found], margins, rtol=1e-12, atol=0)
    assert [m.position for m in found] == ["below"] * 3 + ["inside"] * 2 + ["above"] * 3
    ends = [800.0] * 4 + [1000.0] * 4
    assert [m.operating_speed_rad_s for m in found] == ends
    # Asked: 15.3 % below and 25.3 % above by the formulas, then 15 and 20 %.
    no, yes = "inside margin", "ok"
    assert [m.verdict_api_617 for m in found] == [yes, yes, no, no, no, no, no, yes]
    assert [m.verdict_15_percent for m in found] == [yes, yes, no, no, no, yes, yes, yes]
    assert [m.verdict_20_percent for m in found] == [yes, no, no, no, no, no, yes, yes]


def test_critically_damped_resonance_may_be_inside_and_an_unstable_one_nowhere():
    damped, unstable = _margins(_resonance(900.0, 2.0), _resonance(3000.0, -20.0))
    assert damped.verdict_api_617 == "ok"
    # A fixed margin does not look at the damping.
    assert damped.verdict_15_percent == "inside margin"
    verdicts = {unstable.verdict_api_617, unstable.verdict_15_percent, unstable.verdict_20_percent}
    assert verdicts == {"unstable"}


def test_shafts_are_compared_at_their_own_speed():
    """A shaft at ratio n meets a resonance at |n|Ω, its own speed, which is the frequency."""
    system = twin(ratio=-1.5)
    found = critical_speeds(system, -1.5, 2000.0)
    for resonance, critical in zip(resonances_of_modes(found), found, strict=True):
        assert resonance.speed_rad_s == pytest.approx(1.5 * critical.speed_rad_s, rel=1e-14)
        assert resonance.whirl == critical.whirl
        assert resonance.amplification_factor == np.inf


@pytest.mark.parametrize(("low", "high"), [(0.0, 5.0), (6.0, 5.0), (5.0, np.inf), (np.nan, 5.0)])
def test_ranges_without_meaning_are_refused(low, high):
    with pytest.raises(AnalysisError, match="operating range of 'LP' is"):
        OperatingRange(shaft="LP", speed_low_rad_s=low, speed_high_rad_s=high)


# -- what an unbalance excites, and the verdict ---------------------------------------------------


@pytest.mark.parametrize("ratio", [1.0, -1.5])
@pytest.mark.parametrize("stretch", [1.0, 1.0 + 1e-3, 1.3])
def test_excited_is_what_an_unbalance_drives_without_bound(ratio, stretch):
    """A hair from an undamped critical speed the response is large, or it is not excited."""
    bearing = ground("rotor", "hub", 1e6, 1e6 * stretch, tilt=(1e5, 1e5 * stretch))
    system = one_rotor(hub(), [bearing], ratio)
    # off the centre of gravity, so that it drives tilts too
    found = [c for c in critical_speeds(system, ratio, 2000.0) if c.whirl]
    assert len(found) >= 2
    for critical in found:
        near = critical.speed_rad_s * (1.0 + 1e-7)
        matrices = matrices_at_speed(system, near)
        omega = abs(ratio) * near
        turn = 1j * np.sign(ratio)
        force = np.zeros(system.size, dtype=complex)
        for component, own in (("ux", 1.0), ("uy", -turn), ("rx", 0.1 * turn), ("ry", 0.1)):
            force += own * interface_row(system, "rotor", "hub", component)
        velocity = matrices.damping + matrices.gyroscopic
        dynamic = matrices.stiffness - omega**2 * matrices.mass + 1j * omega * velocity
        # its own part: another mode may be critical at the same speed
        row = critical.shape.conj() @ matrices.mass
        size = abs(row @ np.linalg.solve(dynamic, force))
        quiet = abs(row) @ abs(np.linalg.solve(dynamic + 0.1 * matrices.stiffness, force))
        excitation = excitation_by(system, critical.shape, ["rotor"])
        assert excitation.excited is bool(size > 1e3 * quiet), (critical.whirl, size / quiet)
        if stretch == 1.0:
            forward = "forward" if ratio > 0 else "backward"
            assert excitation.excited is (critical.whirl == forward)


def test_the_method_decides_and_says_why():
    near, silent = (
        _resonance(1200.0, 3.5, whirl="forward"),
        _resonance(900.0, np.inf, exciters=()),
    )
    found = _margins(near, _resonance(400.0, np.inf), silent)
    # 18.5 % asked by the standard
    by_standard = margin_verdict(found, MarginMethod())
    assert (by_standard.passed, by_standard.missed) == (True, ())
    assert by_standard.worst.resonance == near
    assert "11459 rpm (amplification factor 3.5) is 20.0 % above" in by_standard.why
    plain = margin_verdict(found, MarginMethod(kind="percent", percent=25.0))
    assert not plain.passed
    assert [m.resonance for m in plain.missed] == [near]
    assert "25.0 % asked" in plain.why
    assert margin_verdict(_margins(silent), MarginMethod()).passed
    for kind in ("api617", "percent"):
        verdict = margin_verdict(_margins(_resonance(900.0, 2.6)), MarginMethod(kind=kind))
        assert not verdict.passed
        assert "no margin is enough" in verdict.why


def test_torsion_is_judged_by_a_tenth_of_the_speed():
    """API 617 asks 10 % of torsional natural frequencies, whatever their amplification."""
    torsional = {"exciters": ("torque",), "whirl": "torsional", "kind": "torsional"}
    near, far, inside = (_resonance(x, 60.0, **torsional) for x in (1080.0, 1120.0, 900.0))
    found = _margins(near, far, inside)
    assert [m.required_api_617 for m in found] == [np.inf, 0.1, 0.1]
    assert [m.verdict_api_617 for m in found] == ["inside margin", "inside margin", "ok"]
    assert margin_verdict(_margins(far), MarginMethod()).passed
    assert margin_verdict(_margins(far), MarginMethod(kind="percent", percent=25.0)).passed
    assert not margin_verdict(_margins(inside), MarginMethod()).passed
    # coupled: the larger of both
    coupled = _margins(_resonance(1120.0, 60.0, exciters=("unbalance", "torque")))
    assert coupled[0].required_api_617 > 0.2
