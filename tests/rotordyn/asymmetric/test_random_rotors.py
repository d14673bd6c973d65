"""Unstable ranges of random asymmetric rotors against growth at many speeds, by steps in time."""

from __future__ import annotations

import numpy as np
import pytest
from random_asymmetric import growth_at, random_system

from solidwhirl.rotordyn.asymmetric import unstable_ranges

LOW, HIGH, NARROWEST = 0.5, 6.0, 1e-4
# Growth that the steps in time tell from rounding.
GROWS = 1e-5


def missed_and_false(system, samples):
    """Speeds that grow outside of all ranges, and ranges that do not grow, or grow beyond ends."""
    found = unstable_ranges(system, LOW, HIGH, NARROWEST)
    width = NARROWEST * (HIGH - LOW)
    speeds = np.linspace(LOW, HIGH, samples + 2)[1:-1]
    growth = np.concatenate([growth_at(system, part) for part in np.array_split(speeds, 8)])
    inside = np.array([any(r.low_rad_s < v < r.high_rad_s for r in found) for v in speeds])
    missed = [
        float(v)
        for v in speeds[(growth > GROWS) & ~inside]
        # a range of its own that is narrower than those looked for ends within its width
        if not (growth_at(system, v + width * np.array([-1.0, 1.0])) < GROWS).all()
    ]
    # growth begins at nothing: what lies beside an end is not judged
    well = np.array([any(abs(v - _middle(r)) < 0.48 * _width(r) for r in found) for v in speeds])
    false = speeds[(growth < 1e-2 * GROWS) & well].tolist()
    for one in found:
        (top,) = growth_at(system, [one.speed_rad_s])
        if abs(top - one.growth_1_s) > 1e-3 * one.growth_1_s + GROWS:
            false.append(one.speed_rad_s)
    return missed, false, len(found)


def _middle(one):
    return 0.5 * (one.low_rad_s + one.high_rad_s)


def _width(one):
    return one.high_rad_s - one.low_rad_s


@pytest.mark.parametrize("seed", [1, 11, 30])
def test_none_missed_and_none_false(seed):
    missed, false, _ = missed_and_false(random_system(seed), 250)
    assert (missed, false) == ([], [])


@pytest.mark.verify
@pytest.mark.parametrize("part", range(2))
def test_none_missed_and_none_false_in_twenty(part):
    found = [
        missed_and_false(random_system(seed), 1200) for seed in range(10 * part, 10 * part + 10)
    ]
    assert [(missed, false) for missed, false, _ in found] == [([], [])] * 10
    assert sum(count for _, _, count in found) > 10
