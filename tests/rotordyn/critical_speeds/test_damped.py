"""Critical speeds with damping: against counts of whole spectra of the plain matrices."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from rotors import (
    connect,
    eigenvalues_of,
    ground,
    hub,
    one_rotor,
    steel_shaft,
    table_law,
    three_disk_element,
    twin_bearings,
    twin_rotors,
)
from scipy.optimize import brentq

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.critical_speeds import met
from solidwhirl.rotordyn.modes.operator_blocks import operator_blocks

TOP = 1500.0
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])


def _shaft(disk=0.05):
    disks = [(0.2, 12.0, 0.12, 0.07), (0.45, 8.0, disk, 0.03)]
    return steel_shaft("r", np.linspace(0, 0.6, 5), 0.02, {"a": 0.0, "b": 0.6}, disks)


def _on(*laws, **options):
    """A shaft on a constant stiffness and damping, (2, 2) each, or on a law, at either end."""
    none = np.zeros((2, 2))
    held = [
        connect(f"r.{end}", f"rotor.{end}", None, none, none, speed_law=own)
        if isinstance(own, rd.TableLaw)
        else connect(f"r.{end}", f"rotor.{end}", None, *own)
        for end, own in zip("ab", laws, strict=True)
    ]
    return one_rotor(_shaft(**options), held)


def _film(scale):
    """Like a film: stiffer and less damped as it turns faster, cross-coupled."""
    speeds = np.array([50.0, 200.0, 400.0, 800.0, 1200.0, 1600.0])
    rise, eye = speeds[:, None, None] / 1000.0, np.eye(2)
    stiffness = scale * ((1.0 + 0.4 * rise) * np.diag([1.0, 1.7]) + (0.1 + 0.5 * rise) * SKEW)
    return table_law(speeds, stiffness, scale * (0.002 / (0.1 + rise)) * eye)


SYSTEMS = {
    "isotropic, light": lambda: _on(*[(k * np.eye(2), 1e-5 * k * np.eye(2)) for k in (6e6, 2e7)]),
    "isotropic, much": lambda: _on(*[(k * np.eye(2), 2e-3 * k * np.eye(2)) for k in (4e6, 9e6)]),
    "isotropic law": lambda: _on(
        table_law(
            [0.0, 300.0, 900.0, 1600.0],
            1e7 * np.array([1.0, 0.4, 1.3, 0.9])[:, None, None] * np.eye(2),
            2e3 * np.array([1.0, 0.2, 1.0, 0.1])[:, None, None] * np.eye(2),
        ),
        (8e6 * np.eye(2), 300.0 * np.eye(2)),
    ),
    "unlike planes, much": lambda: _on(
        *[(k * np.diag([1.0, 2.3]), 1.5e-3 * k * np.diag([1.0, 0.6])) for k in (5e6, 8e6)]
    ),
    "cross-coupled": lambda: _on(
        *[(k * (np.diag([1.0, 1.3]) + 0.2 * SKEW), 1e-4 * k * np.eye(2)) for k in (1e7, 3e7)]
    ),
    "held at one end": lambda: one_rotor(
        _shaft(), [connect("r.a", "rotor.a", None, 8e6 * np.eye(2), 2e3 * np.eye(2))]
    ),
    "film": lambda: _on(_film(5e6), _film(8e6)),
    "thin disk, film": lambda: _on(_film(2e7), _film(9e6), disk=0.09),
    "two shafts": lambda: rd.assemble(
        twin_rotors(-1.3),
        [*twin_bearings(2e7, 1e7), ground("outer", "C", 1e5, cx=4e3, cy=9e3)],
    ),
}


@pytest.mark.parametrize("ratio", [1.0, 2.3])
@pytest.mark.parametrize("name", SYSTEMS)
def test_every_root_that_passes_the_excitation_is_found(name, ratio):
    """The roots above the line change at what is found, one for each, and nowhere else.

    They are those of the state matrix of the system as it is, at 40 speeds and 1e-6 beside each
    critical speed: eigenvalues are sure to 1e-9.
    """
    system = SYSTEMS[name]()
    found = rd.critical_speeds(system, ratio, TOP)
    at = np.array([c.speed_rad_s for c in found])
    assert at.size > 1 and (np.diff(at) >= 0).all()
    beside = np.multiply.outer(at, [1.0 - 1e-6, 1.0 + 1e-6]).ravel()
    speeds = np.sort(np.concatenate((np.linspace(1.0, TOP, 40), beside)))
    above = [np.count_nonzero(eigenvalues_of(system, s).imag > ratio * s) for s in speeds]
    inside = np.array([np.count_nonzero((at > a) & (at < b)) for a, b in pairwise(speeds)])
    np.testing.assert_array_equal(np.abs(np.diff(above)), inside)
    for critical in found:
        m, c, g, k = rd.matrices_at_speed(system, critical.speed_rad_s)
        s = critical.eigenvalue
        terms = [part @ critical.shape for part in (k, s * (c + g), s**2 * m)]
        assert np.abs(sum(terms)).max() < 1e-10 * sum(np.abs(term) for term in terms).max()


@pytest.mark.parametrize("name", ["isotropic, light", "isotropic, much", "isotropic law"])
def test_circles_alone_and_both_planes_together(name):
    """The complex problem of half the size against that of a system that knows of no turn."""
    system = SYSTEMS[name]()
    plain = dataclasses.replace(system, spin_generator=None)
    sizes = [[b.operator.size for b in operator_blocks(each)] for each in (system, plain)]
    assert sizes[1] == [2 * sizes[0][0]]
    one, other = (rd.critical_speeds(each, 1.0, TOP) for each in (system, plain))
    for first, second in zip(one, other, strict=True):
        assert first.eigenvalue == pytest.approx(second.eigenvalue, rel=1e-9)
        assert first.whirl == second.whirl
        product = abs(np.vdot(first.shape, second.shape))
        sizes = np.linalg.norm(first.shape) * np.linalg.norm(second.shape)
        assert product == pytest.approx(sizes, rel=1e-7)


def test_motion_that_begins_to_oscillate_meets_the_excitation():
    """m s² + c(Ω) s + k is overdamped until c falls below 2√(km); Im s = √(k/m − (c/2m)²) then.

    c falls from 400 to 500 rad/s: the motion begins at 405, meets the excitation at 414 with a
    damping ratio of 0.9, and again where c is gone.
    """
    mass, k, most = 10.0, 9e6, 20e3
    law = table_law([400.0, 500.0], [k, k], [most, 0.0], interpolation="linear")
    bearing = connect("hub", "rotor.hub", None, np.zeros((2, 2)), tilt=1e7, speed_law=law)
    system = one_rotor(hub(mass_kg=mass, polar_kg_m2=1e-3, diametral_kg_m2=1e-3), [bearing])

    def miss(speed):
        rate = 0.5 * most * (5.0 - speed / 100.0) / mass
        return np.sqrt(k / mass - rate**2) - speed

    begins = 500.0 - 100.0 * 2.0 * np.sqrt(k * mass) / most
    exact = [brentq(miss, begins * (1 + 1e-12), 450.0), np.sqrt(k / mass)]
    found = rd.critical_speeds(system, 1.0, 999.0)
    np.testing.assert_allclose([c.speed_rad_s for c in found], np.repeat(exact, 2), rtol=1e-11)


def test_two_roots_that_nearly_meet_are_two():
    """Cross-coupling draws both planes together: whirl of 382 and 397 rad/s, each there once."""
    own = (None, np.diag([7e7, 5e7]) + 1e7 * SKEW, 5e3)
    held = [connect(end, f"rotor.{end}", *own) for end in ("left", "right")]
    found = rd.critical_speeds(one_rotor(three_disk_element(), held), 1.0, 900.0)
    assert [round(c.speed_rad_s) for c in found] == [382, 397]


def test_a_root_that_is_missed_is_noticed(monkeypatch):
    """The roots at the ends of a stretch know nothing of those that are found in between."""
    system = SYSTEMS["cross-coupled"]()
    least = rd.critical_speeds(system, 1.0, TOP)[0].speed_rad_s
    solve = met.met

    def without_the_first(operator, speed, value, ratio):
        place = solve(operator, speed, value, ratio)
        return place if place is None or abs(place.speed - least) > 1e-6 * least else None

    monkeypatch.setattr(met, "met", without_the_first)
    with pytest.raises(rd.AnalysisError, match="can't be told apart"):
        met.met_by_excitation(system, 1.0, TOP)
