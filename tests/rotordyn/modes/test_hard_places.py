"""Equal modes at the end of a list, slow nutation, kinks of a law, and the loss of stiffness."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from solidwhirl.rotordyn import Bearing, End, TableLaw, campbell, critical_speeds, modes_at_speed
from solidwhirl.rotordyn.critical_speeds.search import count_critical_speeds
from solidwhirl.rotordyn.modes.eigen import whole_group_count

KINK, MASS = 100.0, 10.0


@pytest.mark.parametrize(
    ("count", "expected"), [(1, 2), (2, 2), (3, 3), (4, 7), (5, 7), (7, 7), (8, 8), (20, 8)]
)
def test_groups_of_equal_frequencies_are_not_cut(count, expected):
    omega = np.array([1.0, 1.0 + 1e-9, 2.0, 3.0, 3.0, 3.0, 3.0, 5.0])
    assert whole_group_count(1j * omega, count) == expected


def test_no_modes_are_no_group():
    assert whole_group_count(np.empty(0, dtype=complex), 3) == 0


def test_odd_numbers_of_modes_and_branches_at_rest_are_made_even(
    three_disk_element, one_rotor, ground
):
    system = one_rotor(three_disk_element(), [ground("rotor", at, 5e7) for at in ("left", "right")])
    for count in (1, 3, 5):
        modes = modes_at_speed(system, 0.0, count)
        assert modes.eigenvalues.size == modes.shapes.shape[1] == count + 1
        assert campbell(system, [0.0, 300.0], branch_count=count).whirl.shape[0] == count + 1
        # at speed the pairs have come apart, and the count is that asked for
        assert modes_at_speed(system, 300.0, count).eigenvalues.size == count


@pytest.mark.parametrize("speed", [1e-6, 1e-3, 1.0])
def test_nutation_far_below_the_elastic_modes(three_disk_element, one_rotor, speed):
    """Ω Ip/It to (Ω/ω1)² = 1e-6; rounding of 1e-13 of ω1 = 400 rad/s counts beside it."""
    element = three_disk_element()
    modes = modes_at_speed(one_rotor(element, []), speed)
    expected = speed * element.inertia_kg_m2[2, 2] / element.inertia_kg_m2[0, 0]
    assert modes.zero_count == 6
    assert modes.eigenvalues[0].imag == pytest.approx(expected, rel=1e-5, abs=1e-11)


def _kinked(depth):
    """k(Ω) of a hub in which 10 Ω² reaches up to the kink, or beyond it by `depth`."""
    law = TableLaw(
        name="kinked",
        speeds_rad_s=np.array([0.0, KINK, 200.0, 300.0]),
        stiffness_n_per_m=np.multiply.outer([2e5, 1e5 * (1 - depth), 4e5, 5e5], np.eye(2)),
        damping_n_s_per_m=np.zeros((4, 2, 2)),
        interpolation="linear",
    )
    return Bearing(
        name="kinked",
        first=End(body="rotor", interface="hub"),
        tilt_stiffness_n_m_per_rad=1e7 * np.eye(2),
        speed_law=law,
    )


@pytest.mark.parametrize("depth", [0.1, 1e-3, 1e-4, 1e-7])
def test_a_kink_that_dips_below_the_excitation(hub, one_rotor, depth):
    """10 Ω² = k(Ω) in each straight piece; the dip lies between two samples of the search."""
    low = 1e5 * (1 - depth)
    down, up = (low - 2e5) / KINK, (4e5 - low) / KINK
    before = np.roots([MASS, -down, -2e5]).max()
    after = np.roots([MASS, -up, up * KINK - low]).min()
    found = [c.speed_rad_s for c in critical_speeds(one_rotor(hub(), [_kinked(depth)]), 1, 400)]
    expected = np.repeat([before, after, 200.0], 2)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_touch_at_a_kink_is_reported(hub, one_rotor):
    counted = count_critical_speeds(one_rotor(hub(), [_kinked(0.0)]), 1.0, 400.0)
    at_kink = sum(
        low <= KINK * (1 + 1e-9) and high >= KINK for low, high in counted.unresolved_rad_s
    )
    # as a place in doubt, or as a fall and a rise of both whirls
    assert at_kink == 1 or counted.rises == 2
    assert counted.falls - counted.rises == 2


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_loss_of_stiffness_is_noted_with_its_speed(one_rotor, hub, plane_spring, sign):
    disk = hub(stiffness=plane_spring(1e6, 0.0, 1e4), polar_kg_m2=0.0)
    disk = dataclasses.replace(disk, spin_softening=disk.stiffness / 777.0**2)
    diagram = campbell(one_rotor(disk, []), sign * np.array([0.0, 500.0, 900.0]), branch_count=4)
    (note,) = [note for note in diagram.notes if note.kind == "indefinite"]
    assert note.speed_rad_s == pytest.approx(sign * 777.0, rel=1e-10)
    assert "777 rad/s" in note.text


def test_no_stiffness_from_the_first_speed_on(one_rotor, hub, plane_spring):
    disk = hub(stiffness=plane_spring(1e6, 0.0, 1e4), polar_kg_m2=0.09)
    disk = dataclasses.replace(disk, spin_softening=np.diag([0.0, 0.0, 1.0, 1.0]) * 1e4 / 50.0**2)
    diagram = campbell(one_rotor(disk, []), [60.0, 80.0], branch_count=2)
    (note,) = [note for note in diagram.notes if note.kind == "indefinite"]
    assert note.speed_rad_s == 60.0
