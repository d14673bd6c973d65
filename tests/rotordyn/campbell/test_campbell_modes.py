"""The branches of a diagram are all modes of the system: against numpy's general solver."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import connect, eigenvalues_of, ground, hub, one_rotor, steel_shaft, table_law, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.campbell.branch_numbers import branch_numbers
from solidwhirl.rotordyn.campbell.branches import follow, lowest
from solidwhirl.rotordyn.checks.plain_checks import check_campbell
from solidwhirl.rotordyn.checks.system_checks import check_system
from solidwhirl.rotordyn.modes.mode_shapes import mode_shapes

RPM = np.pi / 30.0
SPEEDS = np.linspace(0.0, 1000.0, 11)
KINDS = (
    "free", "held once", "dampers", "overdamped", "overdamped in two planes", "negative",
    "anisotropic", "cross-coupled", "table", "spools", "held once, damped",
)  # fmt: skip


def _seeds(often, all_of_them):
    """Seeds of every kind; the later ones with the long comparisons."""
    marks = {True: [pytest.mark.verify], False: []}
    return [
        pytest.param(s, id=f"{KINDS[s % len(KINDS)]} {s}", marks=marks[s >= often])
        for s in range(all_of_them)
    ]


def _bearing(rng, kind, body, end):
    stiffness, damping = np.eye(2) * 10 ** rng.uniform(5, 7), np.eye(2) * 10 ** rng.uniform(1, 3)
    law = None
    if kind in ("held once", "anisotropic", "spools"):
        damping = 0.0 * damping
    if kind == "dampers":
        stiffness = 0.0 * stiffness
    if kind.startswith("overdamped"):
        damping = damping * 1e3
    if kind in ("anisotropic", "overdamped in two planes"):
        stiffness, damping = stiffness @ np.diag([1, 0.4]), damping @ np.diag([1, 0.7])
    if kind == "negative":
        stiffness = stiffness * rng.choice([-1, 1])
    if kind == "cross-coupled":
        stiffness = stiffness * (1 + 0.5 * rng.normal(size=(2, 2))) + 3e5 * rng.normal(size=(2, 2))
    if kind == "table":
        law = table_law(
            [0.0, *np.sort(rng.uniform(50, 900, 3))],
            rng.normal(size=(4, 2, 2)) * 2e5 + stiffness,
            rng.uniform(0.1, 10, 4)[:, None, None] * damping,
        )
        stiffness = damping = np.zeros((2, 2))
    return connect(f"{body}.{end}", f"{body}.{end}", None, stiffness, damping, speed_law=law)


def _system(seed):
    """One or two rigid rotors, each with one end held or both or none."""
    rng, kind = np.random.default_rng(seed), KINDS[seed % len(KINDS)]
    names = ("first", "second") if kind == "spools" or rng.random() < 0.2 else ("first",)
    rotors, bearings = {}, []
    for ratio, name in zip((1.0, rng.uniform(-2, 2)), names, strict=False):
        tilt = rng.uniform(0.02, 0.3)
        mass, place, polar = (
            rng.uniform(2, 20),
            rng.uniform(0.05, 0.2),
            tilt * rng.uniform(0.1, 1.9),
        )
        inertia, seats = [tilt, tilt, polar], {"a": 0.0, "b": 0.3}
        body = rd.rigid_superelement(name, mass, [0, 0, place], inertia, seats)
        rotors[name] = turning(body, ratio)
        ends = {"free": (), "held once": "a", "held once, damped": "a"}.get(kind, "ab")
        bearings += [_bearing(rng, kind, name, end) for end in ends]
    if len(names) == 2:
        bearings.append(connect("between", "first.b", "second.b", 4e5))
    return rd.assemble(rotors, tuple(bearings)), int(rng.integers(2, 6))


def _oscillating(system, speed):
    """Eigenvalues with Im λ > 0 by rising Im λ, zeros and what is within rounding of real out."""
    values = eigenvalues_of(system, speed)
    values = values[values.imag > np.maximum(1e-5 * np.abs(values), 1e-3)]
    return values[np.argsort(values.imag)]


def _alive(column):
    return column[np.isfinite(column)]


@pytest.mark.parametrize("seed", _seeds(11, 44))
def test_the_lowest_modes_at_every_speed_are_on_branches(seed):
    system, count = _system(seed)
    diagram = rd.campbell(system, SPEEDS, branch_count=count)
    below = rd.campbell(system, SPEEDS, frequency_max_hz=60.0)
    for column, speed in enumerate(SPEEDS):
        exact = _oscillating(system, speed)
        mine = _alive(diagram.eigenvalues[:, column])
        sure = mine[mine.imag > np.maximum(2e-5 * np.abs(mine), 2e-3)]
        # motions that hardly turn are on branches too, and below all others
        lowest = exact[: max(0, count - (mine.size - sure.size))]
        for value in lowest:
            assert np.abs(mine - value).min(initial=np.inf) < 1e-7 * abs(value)
        for value in sure:
            assert np.abs(exact - value).min(initial=np.inf) < 1e-7 * abs(value)
        limited = _alive(below.eigenvalues[:, column])
        for value in exact[exact.imag < 120 * np.pi * (1 - 1e-9)]:
            assert np.abs(limited - value).min(initial=np.inf) < 1e-7 * abs(value)
    assert not [c for c in check_campbell(system, diagram, None, count) if c.passed is False]


@pytest.mark.parametrize("seed", _seeds(11, 22))
def test_branches_do_not_depend_on_where_the_range_begins(seed):
    system, count = _system(seed)
    whole = rd.campbell(system, SPEEDS, branch_count=count)
    for first in (2, 5):
        part = rd.campbell(system, SPEEDS[first:], branch_count=count)
        rest = whole.eigenvalues[:, first:]
        np.testing.assert_allclose(part.eigenvalues, rest[np.isfinite(rest).any(axis=1)], rtol=1e-8)
    back = rd.campbell(system, SPEEDS[::-1], branch_count=count)
    np.testing.assert_array_equal(back.eigenvalues[:, ::-1], whole.eigenvalues)


@pytest.mark.parametrize("seed", _seeds(11, 22))
def test_modes_have_the_numbers_of_their_branches(seed):
    """At speeds of the diagram and between them, by a diagram that has these speeds as well."""
    system, count = _system(seed)
    between = np.array([130.0, 777.0])
    every = np.sort(np.concatenate((SPEEDS, between)))
    fine = rd.campbell(system, every, branch_count=count)
    numbers_of = rd.campbell(system, SPEEDS, branch_count=count)
    if len(fine.eigenvalues) != len(numbers_of.eigenvalues):
        pytest.skip("a branch is among the lowest between the speeds alone")
    for speed in (*SPEEDS[[0, 1, -1]], *between):
        modes = rd.modes_at_speed(system, float(speed))
        numbers = branch_numbers(system, numbers_of, modes)
        column = fine.eigenvalues[:, np.searchsorted(every, speed)]
        on = numbers > 0
        np.testing.assert_allclose(column[numbers[on] - 1], modes.eigenvalues[on], rtol=1e-7)
        assert on.sum() == np.isfinite(column).sum()


def test_a_free_rigid_rotor_precesses():
    """(Ip/It) Ω from rest on; at rest there is nothing that oscillates."""
    body = rd.rigid_superelement("r", 10.0, [0, 0, 0.1], [0.1, 0.1, 0.15], {"a": 0.0, "b": 0.3})
    system = one_rotor(body)
    diagram = rd.campbell(system, SPEEDS, branch_count=4)
    assert np.isnan(diagram.frequency_hz[0, 0])
    precession = [1.5 * SPEEDS[1:] / (2 * np.pi)]
    np.testing.assert_allclose(diagram.frequency_hz[:, 1:], precession, rtol=1e-9)
    assert rd.critical_speeds(system, speed_max_rad_s=1000.0) == ()
    found = (rd.modes_at_speed(system, 0.0), diagram, {1.0: ()})
    checks = check_system(system, *found, branch_count=4, speed_max_rad_s=1000.0)
    assert not [check for check in checks if check.passed is False]


@pytest.mark.parametrize(
    ("rpm", "outer", "inner", "disk"), [(15000, 0.05, 0.04, 0), (6000, 0.01, 0, 20)]
)
def test_a_free_beam_precesses_as_a_rigid_body(rpm, outer, inner, disk):
    """(Ip/It) Ω less what bending gives way: stiff, so that the rigid limit holds."""
    disks = [(0.25, disk, 0.19, 0.1)] if disk else []
    stiff = {"inner": inner, "material": (2e15, 0.3, 4430.0)}
    stations, seats = np.linspace(0, 0.5, 7), {"a": 0.0, "b": 0.5}
    element = steel_shaft("r", stations, outer, seats, disks, **stiff)
    system = one_rotor(element)
    diagram = rd.campbell(system, np.linspace(0, rpm, 4) * RPM, frequency_max_hz=600.0)
    ratio = element.inertia_kg_m2[2, 2] / element.inertia_kg_m2[0, 0]
    np.testing.assert_allclose(diagram.frequency_hz[0, -1], ratio * rpm / 60.0, rtol=1e-4)
    assert diagram.whirl[0, -1] == "forward"
    # it begins at rest, which is no place to be searched for
    fronts = follow(system, np.linspace(0, rpm, 4) * RPM, lowest(4))
    assert len(fronts) <= 12


def test_births_and_ends_are_placed():
    """A rigid disk on one bearing whose damping falls to the critical one and rises again."""
    mass, stiffness = 10.0, 1e6
    critical = 2.0 * np.sqrt(stiffness * mass)
    law = table_law(
        [0.0, 400.0, 1000.0],
        np.array([np.eye(2) * stiffness] * 3),
        np.array([np.diag([f * critical, critical * 1.2]) for f in (2, 0.2, 1.4)]),
    )
    bearing = connect("b", "rotor.hub", speed_law=law)
    system = one_rotor(hub(mass_kg=mass, polar_kg_m2=0.0), [bearing])
    diagram = rd.campbell(system, SPEEDS, branch_count=2)
    notes = [n for n in diagram.notes if n.kind in ("begun", "ended")]
    found = [(n.kind, n.speed_rad_s) for n in sorted(notes, key=lambda n: n.speed_rad_s)]
    assert [kind for kind, _ in found] == ["begun", "ended"]
    # where the piecewise cubic or linear damping is critical
    for _, speed in found:
        damping = law.coefficients(speed, np.zeros((2, 2)), np.zeros((2, 2))).damping_n_s_per_m
        assert damping[0, 0] == pytest.approx(critical, rel=1e-5)
    assert all("overdamped" in n.text for n in notes)


def test_branches_go_through_every_knot():
    system, _ = _system(KINDS.index("table"))
    fronts = follow(system, SPEEDS[[2, 6]], lowest(2))
    seen = [front.modes.speed_rad_s for front in fronts]
    inside = [knot for knot in system.knots_rad_s if knot < SPEEDS[6]]
    assert len(inside) > 1 and set(inside) <= set(seen) and seen == sorted(seen)


def test_equal_modes_at_rest_have_no_sense_of_whirl():
    system = one_rotor(hub(), [ground("rotor", "hub", 1e6, 1e6, 100.0)])
    assert (rd.campbell(system, [0.0, 100.0], branch_count=2).whirl[1:, 0] == "straight").all()
    assert set(mode_shapes(system, rd.modes_at_speed(system, 0.0)).whirl) == {"straight"}
