"""Rotors of bench/ordinary_rotors.py at the solid level, against the harmonic level."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.solver

BENCH = Path(__file__).resolve().parents[3] / "bench"
# Once held, a body is free to tilt: its estimates are made beside rigid motions. The others take
# seconds to minutes.
QUICK = ("once_held",)
LONG = (
    "overhung_disk",
    "thin_drum",
    "turbocharger",
    "free_shaft",
    "micro",
    "turbine_shaft",
    "flanged_tube",
    "cone",
    "two_materials",
    "twin_rotor",
)
CASES = [(name, 1e-2) for name in QUICK]
CASES += [pytest.param((name, 2e-3), marks=pytest.mark.verify) for name in LONG]


@pytest.fixture(scope="module")
def bench():
    """Modules ordinary_rotors and true_errors of the folder bench."""
    sys.path.insert(0, str(BENCH))
    yield tuple(importlib.import_module(name) for name in ("ordinary_rotors", "true_errors"))
    sys.path.remove(str(BENCH))


@pytest.mark.verify
@pytest.mark.parametrize("case", CASES, ids=lambda c: c[0])
def test_checks_and_accuracy_of_an_ordinary_rotor(bench, case):
    """All checks hold, the accuracy is met, and the estimate is 1 to 3 times the error.

    The truth is the harmonic level with elements of order 4 at a twentieth of the accuracy.
    """
    rotors, errors = bench
    name, accuracy = case
    scene = rotors.scene_of(name, accuracy)
    found, _ = errors.run(scene, level="solid")
    assert rotors.failed(found) == []
    assert found.estimates.largest <= accuracy
    finer, _ = errors.reference(scene, accuracy)
    compared = rotors.counted(found, finer)
    assert compared
    estimate, true = (errors.largest(compared, what) for what in ("estimate", "true"))
    assert true <= accuracy
    assert 1.0 <= estimate / true <= 3.0
