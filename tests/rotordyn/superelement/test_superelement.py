"""The record checks itself, and a rigid disk adds what mechanics says."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from solidwhirl.rotordyn import (
    Coordinate,
    InterfaceNode,
    SuperelementError,
    attach_rigid_disk,
    beam_superelement,
    check_superelement,
)


@pytest.fixture(scope="module")
def inner(twin_bodies):
    return twin_bodies()[0]


def _changed(array, index, value):
    copy = np.array(array)
    copy[index] = value
    return copy


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda e: {"name": ""}, "empty name"),
        (lambda e: {"level": "shell"}, "level is 'shell'"),
        (lambda e: {"mass": np.eye(3)}, r"mass has shape \(3, 3\), allowed is"),
        (
            lambda e: {"stiffness": _changed(e.stiffness, (0, 1), np.nan)},
            r"stiffness\[0, 1\] is nan",
        ),
        (lambda e: {"mass": _changed(e.mass, (0, 1), 1.0)}, "mass is not symmetric: largest dev"),
        (lambda e: {"gyroscopic": e.mass}, "gyroscopic is not skew"),
        (lambda e: {"rigid_body_modes": np.zeros((6, 6))}, "rigid_body_modes has shape"),
        (lambda e: {"rigid_body_present": np.ones(3)}, "rigid_body_present has shape"),
        (lambda e: {"mass_kg": 0.0}, "mass_kg is 0.0"),
        (lambda e: {"maximum_speed_rad_s": -1.0}, "maximum_speed_rad_s is -1.0"),
        (lambda e: {"full_dofs": -1}, "full_dofs is -1"),
        (lambda e: {"recovery_modes": np.zeros((2, 3, 5))}, "recovery_modes has shape"),
        (lambda e: {"frequency_error_estimate": np.zeros(2)}, "allowed is 0 or"),
        (lambda e: {"inertia_kg_m2": np.triu(np.ones((3, 3)))}, "inertia_kg_m2 is not symmetric"),
        (lambda e: {"provenance": {"a": {1, 2}}}, "what JSON can hold"),
        (lambda e: {"coordinates": ()}, "has no coordinates"),
        (lambda e: {"coordinates": e.coordinates[::-1]}, "interface coordinates come first"),
        (lambda e: {"coordinates": (e.coordinates[0], *e.coordinates[:-1])}, "more than once"),
        (lambda e: {"interfaces": e.interfaces[1:]}, "names interface 'A'"),
        (lambda e: {"interfaces": (e.interfaces[0], *e.interfaces)}, "occur more than once"),
    ],
)
def test_contradictions_are_refused(inner, change, message):
    with pytest.raises(SuperelementError, match=message):
        dataclasses.replace(inner, **change(inner))


def test_bad_coordinates_and_interfaces_are_refused(inner):
    bad = Coordinate(kind="modal", interface="A", component="q", frequency_hz=1.0)
    with pytest.raises(SuperelementError, match="is modal and needs"):
        dataclasses.replace(inner, coordinates=(*inner.coordinates[:-1], bad))
    bad = Coordinate(kind="interface", interface="A", component="q", frequency_hz=0.0)
    with pytest.raises(SuperelementError, match="neither modal nor one of"):
        dataclasses.replace(inner, coordinates=(bad, *inner.coordinates[1:]))
    with pytest.raises(SuperelementError, match="coupling is 'glue'"):
        InterfaceNode(name="A", position_m=np.zeros(3), coupling="glue")
    with pytest.raises(SuperelementError, match=r"position_m has shape \(2,\)"):
        InterfaceNode(name="A", position_m=np.zeros(2), coupling="rigid")
    with pytest.raises(SuperelementError, match="empty name"):
        InterfaceNode(name="", position_m=np.zeros(3), coupling="rigid")


def test_arrays_are_read_only_and_exactly_symmetric(inner):
    with pytest.raises(ValueError, match="read-only"):
        inner.mass[0, 0] = 1.0
    # A deviation below the limit is taken out.
    mass = np.array(inner.mass)
    mass[0, 1] += 1e-12 * mass.max()
    repaired = dataclasses.replace(inner, mass=mass)
    np.testing.assert_array_equal(repaired.mass, repaired.mass.T)
    # the caller keeps its own array
    mass = np.array(inner.mass)
    element = dataclasses.replace(inner, mass=mass)
    mass[0, 0] = -1.0
    assert element.mass[0, 0] == inner.mass[0, 0]


def test_interface_index_names_what_exists(inner):
    assert inner.coordinates[inner.interface_index("C", "ry")].label == "C.ry"
    assert inner.coordinates[-1].label.startswith("mode ")
    with pytest.raises(SuperelementError, match=r"no interface 'X'; it has \['A', 'C', 'B'\]"):
        inner.interface_index("X", "ux")
    with pytest.raises(SuperelementError, match=r"'uz'; it has \['ux', 'uy', 'rx', 'ry'\]"):
        inner.interface_index("A", "uz")
    with pytest.raises(SuperelementError, match="no interface 'X'"):
        inner.interface_node("X")


DISK = {"mass_kg": 7.0, "polar_kg_m2": 0.09, "diametral_kg_m2": 0.05}


@pytest.mark.parametrize("offset", [0.0, -0.07, 0.2])
def test_attached_disk_keeps_the_invariants(inner, offset):
    twice = attach_rigid_disk(inner, "B", "one", **DISK, offset_m=offset)
    twice = attach_rigid_disk(twice, "A", "two", **DISK)
    for invariant in check_superelement(twice):
        assert invariant.passed, invariant
    assert twice.mass_kg == pytest.approx(inner.mass_kg + 14.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"interface": "X"}, "no interface 'X'"),
        ({"mass_kg": -1.0}, "mass_kg is -1.0"),
        ({"polar_kg_m2": np.nan}, "polar_kg_m2 is nan"),
        ({"offset_m": np.inf}, "offset_m is inf"),
    ],
)
def test_disks_out_of_range_are_refused(inner, options, message):
    with pytest.raises(SuperelementError, match=message):
        attach_rigid_disk(**{"element": inner, "interface": "A", "name": "d", **DISK, **options})


def test_invariants_hold_for_beams_of_all_sizes():
    for size in (1e-3, 1.0, 1e3):
        shaft = beam_superelement(
            "s",
            size * np.linspace(-0.3, 1, 15),
            size * np.linspace(0.02, 0.05, 14),
            size * 0.01,
            (2e11, 0.3, 7800.0),
            {"a": 0.0, "b": 0.9 * size},
        )
        for invariant in check_superelement(shaft):
            assert invariant.passed, invariant
            assert invariant.value <= invariant.limit
