"""Every hard case stays within its limit."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from table import all_cases

CASES = all_cases()


@pytest.mark.solver
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(c, id=f"{c.level}: {c.case}", marks=[pytest.mark.verify] if c.is_long else [])
        for c in CASES
    ],
)
def test_hard_case(case):
    assert case.measure() <= case.limit, f"{case.figure}; limit from {case.reason}"


def test_cases_are_told_apart():
    names = [(case.case, case.level) for case in CASES]
    assert len(set(names)) == len(names)
