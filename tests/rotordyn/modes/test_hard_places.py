"""Equal modes at the end of a list, slow nutation, kinks of a law, and the loss of stiffness."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, one_rotor, three_disk_element

from solidwhirl.rotordyn import campbell, modes_at_speed
from solidwhirl.rotordyn.modes.eigen import whole_group_count


@pytest.mark.parametrize(
    ("count", "expected"), [(1, 2), (2, 2), (3, 3), (4, 7), (5, 7), (7, 7), (8, 8), (20, 8)]
)
def test_groups_of_equal_frequencies_are_not_cut(count, expected):
    omega = np.array([1.0, 1.0 + 1e-9, 2.0, 3.0, 3.0, 3.0, 3.0, 5.0])
    assert whole_group_count(1j * omega, count) == expected


def test_no_modes_are_no_group():
    assert whole_group_count(np.empty(0, dtype=complex), 3) == 0


def test_odd_numbers_of_modes_and_branches_at_rest_are_made_even():
    system = one_rotor(three_disk_element(), [ground("rotor", at, 5e7) for at in ("left", "right")])
    for count in (1, 3, 5):
        modes = modes_at_speed(system, 0.0, count)
        assert modes.eigenvalues.size == modes.shapes.shape[1] == count + 1
        assert campbell(system, [0.0, 300.0], branch_count=count).whirl.shape[0] == count + 1
        # at speed the pairs have come apart, and the count is that asked for
        assert modes_at_speed(system, 300.0, count).eigenvalues.size == count
