"""Static loads of journals and places of unbalances by hand, on rotors of one beam."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, one_rotor, steel_shaft

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.lateral.rigid_supports import (
    first_critical_speed_rad_s,
    journal_loads_kg,
    journal_seats,
    on_rigid_supports,
    overhung_masses_kg,
)
from solidwhirl.rotordyn.lateral.unbalance_cases import (
    Journals,
    PlacementRules,
    unbalance_cases,
)

RULES = PlacementRules(speed_max_rpm=10e3)


def rotor(disks, at=(0.2, 1.0), stiffness=5e7, density=7800.0, ratio=1.0):
    """A shaft from 0 to 1.2 m with interfaces on it, and disks (place, mass)."""
    places = {"left": 0.0, "a": at[0], "quarter": 0.4, "mid": 0.6, "far": 0.8, "b": at[1]}
    stations = sorted({*places.values(), 1.2})
    shaft = steel_shaft(
        "rotor", stations, [0.04] * (len(stations) - 1), {**places, "right": 1.2},
        [(z, m, 0.02 * m, 0.012 * m) for z, m in disks], material=(2e11, 0.3, density),
    )  # fmt: skip
    bearings = [ground("rotor", end, stiffness, cx=1e3) for end in "ab"]
    return one_rotor(shaft, bearings, ratio)


def journals_of(system):
    seats = journal_seats(system, "rotor", 0.0)
    rigid = on_rigid_supports(system, "rotor", seats)
    loads = journal_loads_kg(rigid, list(seats))
    overhung = overhung_masses_kg(system, "rotor", seats)
    return Journals(seats=seats, loads_kg=loads, overhung_kg=overhung), rigid


def test_loads_of_two_journals_are_those_of_statics():
    disks = [(0.0, 30.0), (0.6, 100.0), (0.8, 50.0)]
    system = rotor(disks)
    found, _ = journals_of(system)
    shaft = system.system.rotors["rotor"].element.mass_kg - 180.0
    about_a = sum(m * (z - 0.2) for z, m in [*disks, (0.6, shaft)])
    second = about_a / 0.8
    loads = list(found.loads_kg.values())
    assert loads == pytest.approx([shaft + 180.0 - second, second], rel=1e-9)
    # beyond the journals: the disk, and its part of 0.2 m of shaft
    per_m = shaft / 1.2
    assert 30.0 < found.overhung_kg[0] < 30.0 + 0.2 * per_m
    assert 0.0 < found.overhung_kg[1] < 0.2 * per_m


def test_three_journals_share_by_the_stiffness_of_the_shaft():
    """A uniform beam on three supports in line, ends and middle: 3/16, 10/16, 3/16."""
    shaft = steel_shaft("rotor", [0.0, 2.0, 4.0], [0.02] * 2, {"a": 0.0, "m": 2.0, "b": 4.0})
    system = one_rotor(shaft, [ground("rotor", end, 1e6 * k) for k, end in enumerate("amb", 1)])
    found, _ = journals_of(system)
    whole = system.system.rotors["rotor"].element.mass_kg
    shares = np.array(list(found.loads_kg.values())) / whole
    np.testing.assert_allclose(shares, [3 / 16, 10 / 16, 3 / 16], rtol=2e-3)


def test_journals_are_what_holds_the_shaft():
    system = rotor([(0.6, 100.0)])
    assert list(journal_seats(system, "rotor", 0.0)) == ["rotor.a", "rotor.b"]
    weak = ground("rotor", "mid", 1e3)
    more = one_rotor(system.system.rotors["rotor"].element, [*system.system.bearings, weak])
    assert list(journal_seats(more, "rotor", 0.0)) == ["rotor.a", "rotor.b"]
    assert list(journal_seats(more, "rotor", 0.0, ["rotor.mid"])) == ["rotor.mid"]
    with pytest.raises(AnalysisError, match="do not hold 'rotor'"):
        journal_seats(more, "rotor", 0.0, ["casing"])
    free = one_rotor(system.system.rotors["rotor"].element, [])
    with pytest.raises(AnalysisError, match="no journals"):
        journal_seats(free, "rotor", 0.0)


def test_first_critical_speed_on_rigid_supports():
    """A light uniform shaft with a heavy disk in the middle: √(48 EI / (m L³))."""
    system = rotor([(0.6, 100.0)], stiffness=1e6, density=10.0)
    _, rigid = journals_of(system)
    inertia = np.pi * 0.04**4 / 4.0
    flexible = np.sqrt(48.0 * 2e11 * inertia / (100.0 * 0.8**3))
    found = first_critical_speed_rad_s(rigid, "rotor", 30.0)
    assert found == pytest.approx(flexible, rel=0.02)  # shear makes it softer
    assert found < flexible


@pytest.mark.parametrize("ratio", [1.0, -1.0])
def test_static_and_couple_unbalance(ratio):
    """U = k · 6350 W/N: all journals for one antinode, the nearest journal for each of two."""
    system = rotor([(0.4, 60.0), (0.8, 60.0)], stiffness=2e6, ratio=ratio)
    journals, _ = journals_of(system)
    cases = unbalance_cases(system, "rotor", journals, RULES, 600.0)
    static = next(c for c in cases if c.kind == "static")
    assert [u.end.label for u in static.unbalances] == ["rotor.mid"]
    whole = sum(journals.loads_kg.values())
    assert static.unbalances[0].moment_kg_m == pytest.approx(2.0 * 0.635e-6 * whole)
    couple = next(c for c in cases if c.kind == "couple")
    first, second = couple.unbalances
    assert [first.interface, second.interface] == ["a", "b"]
    assert [first.phase_rad, second.phase_rad] == [0.0, np.pi]
    wanted = [2.0 * 0.635e-6 * load for load in journals.loads_kg.values()]
    assert [u.moment_kg_m for u in couple.unbalances] == pytest.approx(wanted)


def test_a_journal_that_is_lifted_carries_its_load():
    system = rotor([(0.0, 400.0)], stiffness=2e6)
    journals, _ = journals_of(system)
    assert min(journals.loads_kg.values()) < 0.0
    cases = unbalance_cases(system, "rotor", journals, RULES, 2000.0)
    loads = [load for case in cases if case.kind == "couple" for load in case.loads_kg]
    assert loads and min(loads) > 0.0


def test_overhung_unbalance():
    """An overhung wheel moves most in the first mode; its mass beyond the journal counts."""
    system = rotor([(0.0, 40.0)], stiffness=5e7)
    journals, _ = journals_of(system)
    cases = unbalance_cases(system, "rotor", journals, RULES, 2000.0)
    first = min(cases, key=lambda c: (min(c.modes_rad_s), c.kind != "overhung"))
    assert first.kind == "overhung"
    assert [u.end.label for u in first.unbalances] == ["rotor.left"]
    wanted = 2.0 * 0.635e-6 * journals.overhung_kg[0]
    assert first.unbalances[0].moment_kg_m == pytest.approx(wanted)


def test_without_a_mode_in_range_the_first_one_beyond_is_taken():
    """A stiff rotor has its unbalance where its first mode will move most."""
    system = rotor([(0.6, 60.0)], stiffness=1e9)
    journals, _ = journals_of(system)
    inside = unbalance_cases(system, "rotor", journals, RULES, 2000.0)
    first = min(mode for case in inside for mode in case.modes_rad_s)
    found = unbalance_cases(system, "rotor", journals, RULES, 0.3 * first)
    modes = [mode for case in found for mode in case.modes_rad_s]
    assert modes == pytest.approx([first] * len(found), rel=1e-9)
    (static,) = (case for case in found if case.kind == "static")
    assert [u.end.label for u in static.unbalances] == ["rotor.mid"]
