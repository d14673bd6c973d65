"""Results of two models matched one to one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import ground, one_rotor, three_disk_element, truncated

from solidwhirl.rotordyn import AnalysisError, CriticalSpeed, campbell, critical_speeds
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.critical_speeds.followed import followed_critical_speeds
from solidwhirl.rotordyn.estimates.campbell_errors import campbell_errors
from solidwhirl.rotordyn.estimates.differences import (
    campbell_differences,
    critical_speed_differences,
    frequency_partners,
)

SPEEDS = np.linspace(0.0, 1500.0, 7)
ENDS = ("left", "right")


@pytest.fixture(scope="module")
def pair():
    full = three_disk_element()
    held = [ground("rotor", end, 7e7, 5e7) for end in ("left", "right")]
    return one_rotor(full, held), one_rotor(truncated(full, 12), held)


@pytest.fixture(scope="module")
def diagrams(pair):
    return [campbell(system, SPEEDS, branch_count=8) for system in pair]


def _reordered(diagram, order):
    names = ("eigenvalues", "frequency_hz", "log_decrement", "whirl", "shares", "overlap")
    return dataclasses.replace(diagram, **{name: getattr(diagram, name)[order] for name in names})


def test_differences_are_the_errors_of_the_truncated_body(pair, diagrams):
    exact, cut = diagrams
    found = campbell_differences(cut, exact)
    np.testing.assert_array_equal(found.partner, np.arange(8))
    estimate = campbell_errors(pair[1], cut)
    # a truncated body is too stiff; (s/ω_c)² of the lowest four is below 0.1
    np.testing.assert_allclose(found.frequency[:4], estimate.total[:4], rtol=0.1)


def test_order_of_branches_does_not_matter(diagrams):
    exact, cut = diagrams
    order = np.random.default_rng(4).permutation(8)
    found = campbell_differences(cut, _reordered(exact, order))
    np.testing.assert_array_equal(order[found.partner], np.arange(8))
    np.testing.assert_array_equal(found.frequency, campbell_differences(cut, exact).frequency)


def test_forward_and_backward_branches_that_cross_are_told_apart(diagrams):
    """Two branches of equal mean frequency differ by their whirl alone."""
    exact, _ = diagrams
    frequency = np.array([np.linspace(50, 51, 7), np.linspace(50, 49.9, 7)])
    whirl = np.array([["forward"] * 7, ["backward"] * 7])
    base = dataclasses.replace(_reordered(exact, [0, 1]), frequency_hz=frequency, whirl=whirl)
    swapped = dataclasses.replace(base, whirl=base.whirl[::-1])
    np.testing.assert_array_equal(campbell_differences(base, base).partner, [0, 1])
    np.testing.assert_array_equal(campbell_differences(base, swapped).partner, [1, 0])
    straight = dataclasses.replace(base, whirl=np.full((2, 7), "straight"))
    np.testing.assert_array_equal(campbell_differences(base, straight).partner, [0, 1])


def test_branches_without_partner_are_nan(diagrams):
    exact, cut = diagrams
    fewer = _reordered(exact, [0, 1, 2, 3])
    found = campbell_differences(cut, fewer)
    np.testing.assert_array_equal(found.partner, [0, 1, 2, 3, -1, -1, -1, -1])
    assert np.isnan(found.frequency[4:]).all() and np.isfinite(found.frequency[:4]).all()
    values = exact.frequency_hz.copy()
    values[1, 4:], values[2] = np.nan, np.nan
    ended = campbell_differences(cut, dataclasses.replace(exact, frequency_hz=values))
    assert ended.partner[1] == 1 and ended.partner[2] == -1
    np.testing.assert_array_equal(np.isnan(ended.frequency[1]), SPEEDS[3] < SPEEDS)


def test_diagrams_of_other_speeds_are_refused(pair, diagrams):
    other = campbell(pair[0], SPEEDS[:5], branch_count=2)
    with pytest.raises(AnalysisError, match="over the same ones"):
        campbell_differences(diagrams[0], other)


def test_critical_speeds_are_matched_within_excitation_and_whirl(pair):
    exact, cut = (
        (*critical_speeds(s, 1.0, 1500.0), *critical_speeds(s, 0.5, 3000.0)) for s in pair
    )
    found = critical_speed_differences(cut, exact)
    np.testing.assert_array_equal(found.partner, np.arange(len(cut)))
    mine, other = (np.array([c.speed_rad_s for c in part]) for part in (cut, exact))
    np.testing.assert_allclose(found.speed, (mine - other) / mine)
    assert (found.speed > -1e-12).all()


def _critical(speed, whirl="forward", ratio=1.0):
    return CriticalSpeed(
        speed_rad_s=speed, frequency_hz=ratio * speed / (2 * np.pi), whirl=whirl,
        shares=np.array([1.0, 0.0, 0.0, 0.0]), shape=np.ones(2, complex), log_decrement=0.0,
    )  # fmt: skip


def test_critical_speeds_without_partner_are_nan():
    first = [_critical(100.0), _critical(104.0), _critical(300.0, "backward"), _critical(90.0)]
    second = [_critical(103.0), _critical(100.0, ratio=2.0), _critical(91.0), _critical(300.0)]
    found = critical_speed_differences(first, second)
    np.testing.assert_array_equal(found.partner, [-1, 0, -1, 2])
    np.testing.assert_allclose(found.speed, [np.nan, 1 / 104, np.nan, -1 / 90])
    for pair in (((), second), (first, ())):
        empty = critical_speed_differences(*pair)
        assert np.isnan(empty.speed).all() and (empty.partner == -1).all()


def test_modes_are_paired_at_one_speed_as_branches_are():
    hertz, whirl = (
        np.array([50.0, np.nan, 50.2, 80.0, 0.0]),
        np.array(["forward", "", "backward"] * 2)[:5],
    )
    whirl[3:] = "straight"
    theirs = np.array([0.0, 50.1, 50.15, 81.0, 200.0])
    sense = np.array(["straight", "backward", "forward", "straight", "straight"])
    found = frequency_partners(hertz, whirl, theirs, sense)
    np.testing.assert_array_equal(found, [2, -1, 1, 3, 0])


@pytest.mark.parametrize("drag", [0.0, 2e4])
def test_followed_critical_speeds_are_those_that_are_searched(drag):
    """Other stiffness of the supports; with damping and without, one eigenproblem for each."""
    element = three_disk_element()

    def on(stiffness):
        held = [ground("rotor", e, stiffness, 0.7 * stiffness, cx=drag, cy=drag) for e in ENDS]
        return one_rotor(element, held)

    first, second = on(7e7), on(6.6e7)
    known = [*critical_speeds(first, 1.0, 1500.0), *critical_speeds(first, 0.5, 1500.0)]
    with SYSTEMS.counted() as counts:
        found = followed_critical_speeds(second, [*known, None])
    assert counts["eigenproblems"] == len(known)
    assert len(known) > 4 and found[-1] is None and None not in found[:-1]
    searched = [*critical_speeds(second, 1.0, 1600.0), *critical_speeds(second, 0.5, 1600.0)]
    partner = critical_speed_differences(found[:-1], searched)
    assert (partner.partner >= 0).all()
    np.testing.assert_allclose(partner.speed, 0.0, atol=1e-9)
    for one, k in zip(found[:-1], partner.partner, strict=True):
        assert one.log_decrement == pytest.approx(searched[k].log_decrement, rel=1e-6, abs=1e-9)


def test_a_critical_speed_that_is_gone_is_not_followed():
    element = three_disk_element()
    first, second = (
        one_rotor(element, [ground("rotor", e, k, k) for e in ENDS]) for k in (7e7, 2e6)
    )
    lowest = critical_speeds(first, 1.0, 1500.0)[0]
    assert followed_critical_speeds(second, [lowest]) == [None]
