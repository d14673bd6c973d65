"""Random rotor-bearing systems against an independent solver: numpy and scipy alone."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench"


@pytest.fixture(scope="module")
def compare():
    sys.path.insert(0, str(BENCH))
    from against_general_solver import compare

    yield compare
    sys.path.remove(str(BENCH))


def told(outcome):
    return [str(d) for d in outcome.disagreements] + [outcome.refused, *outcome.reported]


@pytest.mark.verify
def test_no_number_is_wrong_in_silence(compare):
    """Campbell diagram, critical speeds, stability and responses of random systems."""
    found = [compare(number, samples=100) for number in range(6)]
    assert not {o.number: told(o) for o in found if o.is_defect}


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(286, id="damped far beyond its frequency"),
        pytest.param(303, id="growth that begins too slow to count"),
        pytest.param(320, id="slow growth beside fast decay"),
        pytest.param(1016, id="samples a rounding apart"),
        pytest.param(332, id="two excitations of overdamped bearings"),
    ],
)
def test_hard_systems_pass_every_check(compare, number):
    found = compare(number, samples=100)
    assert told(found) == [""]


@pytest.mark.verify
@pytest.mark.parametrize("first", [1050, 1100, 1225])
def test_many_systems(compare, first):
    """Blocks that hold each class of systems eight times at least; bench/ runs any number."""
    found = [compare(number) for number in range(first, first + 25)]
    assert not {o.number: told(o) for o in found if o.is_defect}
