"""Bearings whose force depends on the frequency: laws, modes, critical speeds and responses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg as la
from rotors import hub, one_rotor, steel_shaft

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.frequency_laws import AnyFrequencyLaw, FrequencyTableLaw
from solidwhirl.rotordyn.assembly.system import at_rate, matrices_at_speed
from solidwhirl.rotordyn.checks.plain_checks import check_campbell, check_critical_roots
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.modes.nearby import with_own_bearings
from solidwhirl.rotordyn.perturbation.left_vectors import mode_pairs
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.stability.intervals import unstable_intervals

TOP = 900.0


def _table(seed, size=2, frequencies=(0.0, 150.0, 400.0, 900.0), mass=3.0):
    """A film whose stiffness, damping and added mass change with speed and frequency."""
    rng = np.random.default_rng(seed)
    speeds = np.array([50.0, 300.0, 600.0, 1000.0])
    shape = (speeds.size, len(frequencies), size, size)
    scale = np.array([1.0, 1.0, 1e-3, 1e-3])[:size]
    even = np.eye(size) + 0.2 * rng.normal(size=shape)
    rise = 1.0 + np.linspace(0.0, 0.6, len(frequencies))[:, None, None]
    sides = np.outer(np.sqrt(scale), np.sqrt(scale))
    added = np.eye(size) + 0.1 * rng.normal(size=shape)
    return FrequencyTableLaw(
        name=f"film {seed}",
        speeds_rad_s=speeds,
        frequencies_rad_s=np.array(frequencies),
        stiffness_n_per_m=4e6 * rise * even * sides,
        damping_n_s_per_m=3e3 / rise * (np.eye(size) + 0.2 * rng.normal(size=shape)) * sides,
        mass_kg=mass * added * sides,
    )


def _bearing(name, end, law, **options):
    place = rd.End(body=end.partition(".")[0], interface=end.partition(".")[2])
    return rd.Bearing(name=name, first=place, speed_law=law, **options)


def _shaft(laws, ratio=1.0):
    """A shaft with a wheel on two films."""
    element = steel_shaft(
        "rotor",
        np.linspace(0, 0.9, 5),
        0.03,
        {"a": 0.0, "m": 0.45, "b": 0.9},
        [(0.45, 30.0, 0.4, 0.2)],
    )
    bearings = [_bearing(e, f"rotor.{e}", law) for e, law in zip("ab", laws, strict=True)]
    return one_rotor(element, bearings, ratio)


def _dynamic(system, speed, rate):
    """D(Ω, s) with the bearings as their laws have them, without what this module tests."""
    bare = matrices_at_speed(replace(system, law_joints=()), speed)
    total = bare.stiffness + rate * (bare.damping + bare.gyroscopic) + rate**2 * bare.mass
    for joint in system.law_joints:
        z = joint.law.dynamic_stiffness(abs(joint.speed_ratio * speed), rate)
        total = total + joint.motion.T @ z @ joint.motion
    return total


def _miss(system, speed, rate):
    """How far a matrix is from singular, by its smallest singular value over its size."""
    d = _dynamic(system, speed, rate)
    scale = 1.0 / np.sqrt(np.abs(np.diag(d)))
    return la.svdvals(scale[:, None] * d * scale)[-1]


@pytest.mark.parametrize("size", [2, 4])
@pytest.mark.parametrize("interpolation", ["monotone", "linear"])
def test_frozen_laws_have_the_dynamic_stiffness(size, interpolation):
    """K + sC is Z at the rate of one, and along the multiple of the speed of the other."""
    law = replace(_table(1, size), interpolation=interpolation)
    own = np.zeros((2, 2))
    for speed in (0.0, 20.0, 299.0, 300.0, 555.0, 1500.0):
        for rate in (-30.0 + 200j, 5.0 + 1200j, 40j, -7.0 + 0j):
            k, c = law.at_rate(rate).coefficients(speed, own, own)
            z = law.dynamic_stiffness(speed, rate)
            np.testing.assert_allclose(k + rate * c, z, rtol=1e-12, atol=1e-9 * np.abs(z).max())
        for ratio in (0.0, 0.46, 1.0, 2.5):
            frozen = law.at_whirl_ratio(ratio)
            k, c = frozen.coefficients(speed, own, own)
            z = law.dynamic_stiffness(speed, 1j * ratio * speed)
            known = k + 1j * ratio * speed * c
            np.testing.assert_allclose(known, z, rtol=1e-12, atol=1e-9 * np.abs(z).max())
            if size == 2:
                pieces = frozen.pieces(own, own).at(speed)
                known = pieces[0] + 1j * ratio * speed * pieces[1]
                np.testing.assert_allclose(known, z, rtol=1e-10, atol=1e-9 * np.abs(z).max())


@dataclass(frozen=True)
class _Maxwell(AnyFrequencyLaw):
    """A spring beside a spring and a damper in a row: Z = k + k1 τs / (1 + τs)."""

    name = "maxwell"
    speed_range_rad_s = (0.0, 1e4)
    stiffness: float
    second: float
    time_s: float

    def dynamic_stiffness(self, speed_rad_s, rate):
        turned = rate * self.time_s
        return (self.stiffness + self.second * turned / (1.0 + turned)) * np.eye(2)


@pytest.mark.parametrize("time_s", [1e-4, 1.5e-3, 2e-2])
def test_maxwell_element_against_the_closed_form(time_s):
    """(m s² + k)(1 + τs) + k1 τs = 0."""
    mass, k, k1 = 10.0, 1e6, 3e6
    law = _Maxwell(k, k1, time_s)
    system = one_rotor(hub(mass, 1.0, 1.0), [_bearing("b", "rotor.hub", law)])
    found = rd.modes_at_speed(system, 0.0)
    roots = np.roots([mass * time_s, mass, (k + k1) * time_s, k])
    right = roots[roots.imag > 0][0]
    lateral = np.abs(found.eigenvalues - right) < 1e-3 * abs(right)
    assert lateral.sum() == 2  # in x and in y
    np.testing.assert_allclose(found.eigenvalues[lateral], right, rtol=1e-10)


@pytest.mark.parametrize("seed", range(2))
def test_modes_of_tables_are_all_there(seed):
    """Each is a root; brute force counts as many: frozen roots whose frequency is passed."""
    system = _shaft([_table(seed, mass=0.0), _table(seed + 10, mass=0.0)])
    for speed in (0.0, 420.0):
        modes = rd.modes_at_speed(system, speed)
        assert max(_miss(system, speed, s) for s in modes.eigenvalues) < 1e-9
        edges = np.linspace(0.0, 1500.0, 61)
        above = []
        for omega in edges:
            values = rd.modes_at_speed(at_rate(system, 1j * omega), speed).eigenvalues
            above.append(np.count_nonzero(values.imag > omega))
        passed = above[0] - above[-1]
        assert np.count_nonzero(modes.eigenvalues.imag <= 1500.0) == passed + (
            modes.eigenvalues.size - above[0]
        )


def test_added_mass_is_mass():
    """A table over the speed alone: roots of the problem with the mass in its matrix."""
    law = _table(3, frequencies=(0.0, 900.0))
    mean = {name: getattr(law, name)[:, 0] for name in ("stiffness_n_per_m", "damping_n_s_per_m")}
    added = np.broadcast_to(np.array([[3.0, 0.4], [0.4, 2.0]]), (4, 2, 2))
    law = FrequencyTableLaw(name="seal", speeds_rad_s=law.speeds_rad_s, mass_kg=added, **mean)
    system, speed = _shaft([law, law]), 333.0
    modes = rd.modes_at_speed(system, speed)
    sync = matrices_at_speed(at_rate(system, 0j), speed)
    mass = sync.mass + sum(j.motion.T @ added[0] @ j.motion for j in system.law_joints)
    n = system.size
    velocity = sync.damping + sync.gyroscopic
    values = la.eigvals(
        np.block(
            [
                [np.zeros((n, n)), np.eye(n)],
                [-la.solve(mass, sync.stiffness), -la.solve(mass, velocity)],
            ]
        )
    )
    right = values[(values.imag > 0) & (np.abs(values) < 1e5)]
    for value in modes.eigenvalues[np.abs(modes.eigenvalues) < 1e4]:
        assert np.abs(right - value).min() < 1e-8 * abs(value)
    assert np.count_nonzero(modes.eigenvalues.imag < 5e3) == np.count_nonzero(right.imag < 5e3)


@pytest.mark.parametrize(("seed", "mass"), [(5, 0.0), (2, 6.0)])
def test_critical_speeds_are_roots_and_all_there(seed, mass):
    """Im λ = Ω at each; their number is that by which modes below the line change."""
    system = _shaft([_table(seed, mass=mass), _table(seed + 7, mass=mass)])
    found = rd.critical_speeds(system, 1.0, TOP)
    assert len(found) >= 2
    for one in found:
        assert one.eigenvalue.imag == pytest.approx(one.speed_rad_s, rel=1e-10)
        assert _miss(system, one.speed_rad_s, one.eigenvalue) < 1e-9
    for low, high in pairwise([1.0, *np.linspace(200.0, TOP, 5)]):
        above = [
            np.count_nonzero(rd.modes_at_speed(system, float(v)).eigenvalues.imag > v)
            for v in (low, high)
        ]
        passed = sum(low < c.speed_rad_s <= high for c in found)
        assert passed >= above[0] - above[1]
        assert (passed - above[0] + above[1]) % 2 == 0


def test_diagram_responses_and_checks():
    """The diagram holds roots at all speeds; the response is the direct solution; checks pass."""
    system = _shaft([_table(4), _table(9)])
    speeds = np.linspace(0.0, 600.0, 13)
    diagram = rd.campbell(system, speeds, branch_count=4)
    for place, speed in enumerate(speeds):
        for value in diagram.eigenvalues[:, place]:
            assert np.isnan(value) or _miss(system, speed, value) < 1e-9
    assert not [c for c in check_campbell(system, diagram) if c.passed is False]
    found = rd.critical_speeds(system, 1.0, TOP)
    roots = [(c.speed_rad_s, c.eigenvalue) for c in found]
    checks = check_critical_roots(PlainSystem.of(system), roots, 1.0, TOP)
    assert not [c for c in checks if c.passed is False]
    unbalance = Unbalance(body="rotor", interface="m", moment_kg_m=1e-4)
    response = unbalance_response(system, [unbalance], speeds[1:])
    exciter = response.exciters[0]
    row = list(response.exciters[0].nodes).index(rd.End(body="rotor", interface="m"))
    for place, speed in enumerate(speeds[1:]):
        load = np.zeros(system.size, dtype=complex)
        rows = system.transformation
        names = [
            (c.interface, c.component) for c in system.system.rotors["rotor"].element.coordinates
        ]
        x, y = names.index(("m", "ux")), names.index(("m", "uy"))
        load += rows[x] * 1e-4 * speed**2 - 1j * rows[y] * 1e-4 * speed**2
        motion = la.solve(_dynamic(system, speed, 1j * speed), load)
        right = [rows[x] @ motion, rows[y] @ motion]
        np.testing.assert_allclose(exciter.translation_m[place, row], right, rtol=1e-9)


def test_a_shaft_that_turns_backward_sees_the_table_in_a_mirror():
    """The same roots, with and without tilts."""
    for size in (2, 4):
        laws = [_table(6, size), _table(8, size)]
        forward, backward = _shaft(laws), _shaft(laws, -1.0)
        values = [rd.modes_at_speed(s, 300.0).eigenvalues for s in (forward, backward)]
        low = [v[np.abs(v) < 5e3] for v in values]
        np.testing.assert_allclose(np.sort_complex(low[0]), np.sort_complex(low[1]), rtol=1e-8)


def test_change_of_a_root_counts_the_change_of_its_bearings():
    """To first order, against the root with a little more stiffness of one bearing."""
    laws, speed, more = [_table(4), _table(9)], 350.0, 40.0
    system = _shaft(laws)
    modes = rd.modes_at_speed(system, speed)
    at = int(np.argmin(np.abs(modes.eigenvalues.imag - 300.0)))
    rate = complex(modes.eigenvalues[at])
    pairs = mode_pairs(matrices_at_speed(at_rate(system, rate), speed), modes)
    left, right = pairs.left[:, at], pairs.right[:, at]
    motion = system.law_joints[0].motion
    frozen = complex(-(motion @ left) @ (motion @ right) * more)
    expected = with_own_bearings(system, speed, rate, (left, right), frozen)
    stiffer = laws[0].stiffness_n_per_m + more * np.eye(2)
    changed = _shaft([replace(laws[0], stiffness_n_per_m=stiffer), laws[1]])
    values = rd.modes_at_speed(changed, speed).eigenvalues
    moved = values[np.abs(values - rate).argmin()] - rate
    np.testing.assert_allclose(moved, expected, rtol=1e-4)
    # the bearings' own change is no small part of it
    assert abs(frozen - moved) > 1e-2 * abs(moved)


def test_unstable_range_of_a_cross_coupled_film():
    """Its ends have Im s alone with the bearing of that frequency; outside all motions decay."""
    film = _table(4, mass=0.0)
    stiffness = np.array(film.stiffness_n_per_m)
    push = 1e6 * np.linspace(0.0, 3.0, 4)[:, None]
    stiffness[..., 0, 1], stiffness[..., 1, 0] = push, -push
    film = replace(film, stiffness_n_per_m=stiffness)
    system = _shaft([film, film])
    found = unstable_intervals(system, 0.0, TOP)
    assert len(found) == 1
    (one,) = found
    assert one.opens
    # growth below 1e-8 of the eigenvalue counts as none
    assert abs(one.eigenvalue.real) < 2e-8 * abs(one.eigenvalue)
    assert _miss(system, one.low_rad_s, one.eigenvalue) < 1e-9
    for speed, grows in ((0.98 * one.low_rad_s, False), (1.02 * one.low_rad_s, True)):
        assert (rd.modes_at_speed(system, speed).eigenvalues.real.max() > 0) is np.bool_(grows)
