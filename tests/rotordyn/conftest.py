"""The rotors of `rotors.py` as fixtures; each is the function that builds one."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

# what other tests take from here: rotors, plain_run_up
sys.path.insert(0, str(Path(__file__).parent))
import rotors


def _given(function):
    """Fixture that is the function itself."""
    return pytest.fixture(scope="session")(lambda: function)


ground = _given(rotors.ground)
hub = _given(rotors.hub)
general = _given(rotors.general)
one_rotor = _given(rotors.one_rotor)
with_axial_and_torsion = _given(rotors.with_axial_and_torsion)
with_stress = _given(rotors.with_stress)
truncated = _given(rotors.truncated)
three_disk_element = _given(rotors.three_disk_element)
three_disk = _given(rotors.three_disk)
twin_bodies = _given(rotors.twin_bodies)
twin = _given(rotors.twin)


@pytest.fixture(scope="module")
def full():
    """Whole rotor with centrifugal effects, of which estimates cut modes."""
    return rotors.with_stress(rotors.three_disk_element(), 0.5)
