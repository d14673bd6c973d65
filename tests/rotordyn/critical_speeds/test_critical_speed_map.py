"""Critical speed maps: closed forms, limits of the stiffness, re-assembly, published rotors."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import (
    between_bearings,
    connect,
    ground,
    one_rotor,
    polynomial_law,
    rigid_body,
    steel_shaft,
    three_disk,
    three_disk_element,
    twin,
    with_axial_and_torsion,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.bearing_laws import LEE_ISOTROPIC
from solidwhirl.rotordyn.assembly.system import with_bearing_stiffness
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.critical_speeds import speed_roots
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map


def _on_springs(element, names, stiffness=1e6, ratio=1.0, law=None):
    own = (None, stiffness)
    return one_rotor(element, [connect(n, f"rotor.{n}", *own, speed_law=law) for n in names], ratio)


# Closed forms.


def test_rigid_rotor_on_two_springs():
    """Bounce 2k = mΩ², tilt 2ka² = Ω²(Id ∓ Ip) of a symmetric rigid rotor, any stiffness."""
    mass, diametral, polar, arm = 30.0, 0.9, 0.3, 0.35
    body = rigid_body("drum", mass, 0.0, [diametral, diametral, polar], {"a": -arm, "b": arm})
    stiffness = np.geomspace(1e4, 1e12, 9)
    found = critical_speed_map(_on_springs(body, "ab"), ["a", "b"], stiffness, speed_max_rad_s=1e7)
    bounce = np.sqrt(2 * stiffness / mass)
    exact = {
        "backward": [bounce, np.sqrt(2 * stiffness * arm**2 / (diametral + polar))],
        "forward": [bounce, np.sqrt(2 * stiffness * arm**2 / (diametral - polar))],
    }
    for whirl, branches in exact.items():
        rows = found.speed_rad_s[(found.whirl == whirl).all(axis=1)]
        np.testing.assert_allclose(rows, np.sort(branches, axis=0), rtol=1e-11)
    # A free rigid rotor has no critical speed, a rigid one in rigid bearings neither.
    assert found.free_rad_s.size == 0
    assert found.rigid_rad_s.size == 0
    # Shapes do not change: bounce and tilt at any stiffness.
    np.testing.assert_allclose(found.likeness, 1.0, rtol=1e-9)


def test_laval_rotor_on_flexible_supports():
    """Supports and shaft in series: mΩ² = 1/(1/k_s + 1/2k), k_s of a Timoshenko beam.

    The shaft has 1e-6 of the disk's mass.
    """
    mass, length, radius, modulus, poisson = 50.0, 1.0, 0.02, 2e11, 0.3
    disk, light = [(length / 2, mass, 0.2, 0.5)], (modulus, poisson, 0.04)
    own = (np.linspace(0, length, 9), radius, {"a": 0.0, "b": length}, disk)
    shaft = steel_shaft("laval", *own, material=light)
    area, second = np.pi * radius**2, np.pi * radius**4 / 4
    shear = 6 * (1 + poisson) / (7 + 6 * poisson) * modulus / (2 * (1 + poisson)) * area
    shaft_stiffness = 1 / (length**3 / (48 * modulus * second) + length / (4 * shear))
    stiffness = np.geomspace(1e4, 1e12, 17)
    found = critical_speed_map(_on_springs(shaft, "ab"), ["a", "b"], stiffness, branch_count=2)
    exact = np.sqrt(1 / (1 / shaft_stiffness + 0.5 / stiffness) / mass)
    for whirl in ("backward", "forward"):
        rows = found.speed_rad_s[(found.whirl == whirl).all(axis=1)]
        # The shaft adds less than half of its relative mass of 1e-6 to the speed.
        error = np.abs(rows / exact - 1).min(axis=0)
        assert error.max() < 6e-7
    assert np.abs(found.rigid_rad_s / np.sqrt(shaft_stiffness / mass) - 1).min() < 6e-7


# Against assembling anew at each stiffness.


@pytest.mark.parametrize("varied", [["C"], ["inner.A", "inner.B", "outer.D"], ["outer.D"]])
def test_map_passes_the_stiffness_of_other_joints(varied):
    """Counter-rotating shafts, anisotropic: k goes from below to above the other joints.

    Coordinates follow the stiffest path, so a map that did not change them would lose digits.
    """
    system = twin(support=3e9, joint=2e7)
    stiffness = np.geomspace(1e4, 1e12, 9)
    found = critical_speed_map(system, varied, stiffness, branch_count=3)
    for column, k in enumerate(stiffness):
        again = rd.critical_speeds(with_bearing_stiffness(system, varied, k))
        direct = [c.speed_rad_s for c in again][:6]
        mapped = np.sort(found.speed_rad_s[:, column])[:6]
        np.testing.assert_allclose(mapped, direct, rtol=1e-9)
        whirl = found.whirl[np.argsort(found.speed_rad_s[:, column]), column][:6]
        assert list(whirl) == [c.whirl for c in again][:6]


def test_asymptotes_are_those_of_reassembled_systems():
    system = twin(support=3e9, joint=2e7)
    found = critical_speed_map(system, ["C"], [1e6], branch_count=3)
    free = rd.critical_speeds(with_bearing_stiffness(system, ["C"], 0.0))[:6]
    np.testing.assert_allclose(found.free_rad_s, [c.speed_rad_s for c in free], rtol=1e-10)
    rigid = rd.critical_speeds(twin(support=3e9, joint=None))[:6]
    np.testing.assert_allclose(found.rigid_rad_s, [c.speed_rad_s for c in rigid], rtol=1e-10)
    assert list(found.rigid_whirl) == [c.whirl for c in rigid]


def test_axial_motion_and_torsion_are_left_out():
    shaft = with_axial_and_torsion(three_disk_element(), 1.3, 0.05, "left", "right")
    options = {"axial_stiffness_n_per_m": 1e6, "torsion_stiffness_n_m_per_rad": 1e4}
    systems = between_bearings(shaft, 7e7, **options), between_bearings(three_disk_element(), 7e7)
    varied = (["rotor.left", "rotor.right"], np.geomspace(1e6, 1e9, 4))
    spatial, lateral = (critical_speed_map(s, *varied, speed_max_rad_s=3000.0) for s in systems)
    assert set(spatial.whirl.ravel()) <= {"forward", "backward", ""}
    np.testing.assert_allclose(spatial.speed_rad_s, lateral.speed_rad_s, rtol=1e-10)


def test_damping_and_own_stiffness_are_left_out():
    """The bearings' own anisotropy and damping are replaced by k·I; the record keeps them."""
    names = ["rotor.left", "rotor.right"]
    damped, plain = (
        critical_speed_map(system, names, [1e7, 1e8], branch_count=2)
        for system in (three_disk(), three_disk(0.0, 0.0))
    )
    np.testing.assert_array_equal(damped.speed_rad_s, plain.speed_rad_s)
    assert set(damped.whirl.ravel()) == {"forward", "backward"}
    np.testing.assert_array_equal(damped.chosen_stiffness_n_per_m, [[7e7, 5e7]] * 2)


# Branches.


def test_branches_are_continuous_and_never_swap():
    """With a fine grid neighbours differ little; a coarse one must join the same branches."""
    system = _on_springs(three_disk_element(), ["left", "right"], 7e7)
    fine, coarse = (
        critical_speed_map(
            system, ["left", "right"], np.geomspace(1e5, 1e11, count), branch_count=3
        )
        for count in (61, 7)
    )
    np.testing.assert_allclose(coarse.speed_rad_s, fine.speed_rad_s[:, ::10], rtol=1e-11)
    np.testing.assert_array_equal(coarse.whirl, fine.whirl[:, ::10])
    # More support stiffness never lowers a critical speed of constant bearings (Courant).
    assert (np.diff(fine.speed_rad_s, axis=1) > 0).all()
    assert fine.likeness.min() > 0.9


def test_crossing_of_symmetric_and_antisymmetric_modes():
    """Two disks at the ends, far out: tilt crosses bounce as supports stiffen; shapes decide.

    In closed form: bounce 2k = mΩ², tilt 2ka² + κ = (Id + Ip)Ω² with a constant tilt spring κ.
    """
    mass, diametral, polar, arm, tilt = 30.0, 3.0, 0.3, 0.2, 2e5
    seats = {"a": -arm, "b": arm, "middle": 0.0}
    body = rigid_body("drum", mass, 0.0, [diametral, diametral, polar], seats)
    springs = [connect(name, f"rotor.{name}", stiffness=1e6) for name in "ab"]
    system = one_rotor(body, [*springs, connect("tilt", "rotor.middle", tilt=tilt)])
    stiffness = np.geomspace(1e5, 1e7, 12)
    found = critical_speed_map(system, ["a", "b"], stiffness, branch_count=2)
    bounce = np.sqrt(2 * stiffness / mass)
    backward = np.sqrt((2 * stiffness * arm**2 + tilt) / (diametral + polar))
    assert (bounce[0] - backward[0]) * (bounce[-1] - backward[-1]) < 0
    rows = found.speed_rad_s[(found.whirl == "backward").all(axis=1)]
    np.testing.assert_allclose(rows, [bounce, backward], rtol=1e-10)


def test_limit_cuts_branches():
    system = _on_springs(three_disk_element(), ["left", "right"], 7e7)
    stiffness = np.geomspace(1e5, 1e11, 13)
    every = critical_speed_map(system, ["left", "right"], stiffness, branch_count=3)
    below = critical_speed_map(system, ["left", "right"], stiffness, speed_max_rad_s=1400.0)
    assert np.nanmax(below.speed_rad_s) <= 1400.0
    seen = every.speed_rad_s <= 1400.0
    assert np.count_nonzero(np.isfinite(below.speed_rad_s)) == np.count_nonzero(seen)
    np.testing.assert_array_equal(below.whirl == "", np.isnan(below.speed_rad_s))
    assert below.rigid_rad_s.max() <= 1400.0


# Bearings that depend on the speed.


def test_map_of_lee_bearings_on_a_rigid_rotor():
    """Bounce alone: 2k p(Ω) = mΩ², all positive roots of a polynomial at each stiffness."""
    mass = 30.0
    body = rigid_body("drum", mass, 0.0, [40.0, 40.0, 0.3], {"a": -0.3, "b": 0.3})
    system = _on_springs(body, "ab", law=LEE_ISOTROPIC)
    stiffness, limit = np.geomspace(1e6, 1e8, 9), 2000.0
    found = critical_speed_map(system, ["a", "b"], stiffness, speed_max_rad_s=limit)
    for column, k in enumerate(stiffness):
        exact = []
        # Tilt: 2k a² p(Ω) = (Id ± Ip) Ω².
        for inertia in (mass, (40 + 0.3) / 0.3**2, (40 - 0.3) / 0.3**2, mass):
            polynomial = 2 * k * np.array(LEE_ISOTROPIC.stiffness_x)
            polynomial[2] -= inertia
            roots = np.roots(polynomial[::-1])
            real = roots.real[np.abs(roots.imag) < 1e-9 * np.abs(roots)]
            exact += list(real[(real > 0) & (real < limit)])
        mapped = found.speed_rad_s[:, column]
        np.testing.assert_allclose(np.sort(mapped[np.isfinite(mapped)]), np.sort(exact), rtol=1e-9)


def test_other_bearings_keep_their_law():
    """Vary one constant bearing beside one that depends on the speed."""
    left = connect("left", "rotor.left", None, 7e7, speed_law=LEE_ISOTROPIC)
    system = one_rotor(three_disk_element(), [left, connect("right", "rotor.right", None, 7e7)])
    stiffness = np.array([1e6, 1e8, 1e10])
    found = critical_speed_map(system, ["right"], stiffness, speed_max_rad_s=900.0)
    for column, k in enumerate(stiffness):
        again = rd.critical_speeds(with_bearing_stiffness(system, ["right"], k), 1.0, 900.0)
        mapped = np.sort(found.speed_rad_s[:, column])
        mapped = mapped[np.isfinite(mapped)]
        np.testing.assert_allclose(mapped, [c.speed_rad_s for c in again], rtol=1e-9)


# Faults.


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"bearings": ["nose"]}, r"bearings is \['nose'\]; one or more of"),
        ({"bearings": []}, r"bearings is \[\]"),
        ({"bearings": "left"}, "bearings is 'left'"),
        ({"stiffnesses_n_per_m": [1e6, 1e5]}, "strictly rising"),
        ({"stiffnesses_n_per_m": [0.0, 1e5]}, "positive"),
        ({"stiffnesses_n_per_m": []}, r"found shape \(0,\)"),
        ({"excitation_ratio": 0.0}, "excitation_ratio is 0.0"),
        ({"branch_count": 0}, "branch_count is 0"),
        ({"speed_max_rad_s": -1.0}, "speed_max_rad_s is -1.0"),
        ({"branch_count": None}, "no branch_count is given"),
    ],
)
def test_arguments_without_meaning_are_refused(arguments, message):
    given = {"bearings": ["left"], "stiffnesses_n_per_m": [1e6], "branch_count": 2} | arguments
    system = _on_springs(three_disk_element(), ["left", "right"])
    with pytest.raises(rd.AnalysisError, match=message):
        critical_speed_map(system, given.pop("bearings"), given.pop("stiffnesses_n_per_m"), **given)


def test_bearings_that_cannot_be_varied_are_refused():
    lee = _on_springs(three_disk_element(), ["left", "right"], law=LEE_ISOTROPIC)
    for system, name, message in (
        (twin(), "C", "bearing 'C' is rigid"),
        (lee, "left", "bearings depend on the speed"),
    ):
        with pytest.raises(rd.AnalysisError, match=message):
            critical_speed_map(system, [name], [1e6], branch_count=1)


def test_a_map_beside_a_speed_law_takes_few_problems_of_full_size(monkeypatch):
    """Roots refined in the modes with the bearings held are those of each eigenvalue's sign."""
    shaft = three_disk_element()
    law = polynomial_law((1.0, 4e-4), (1.0, 2e-4), (1.0,), (1.0,), top=3000.0)
    held = [ground("rotor", "left", 1e7, 6e6), ground("rotor", "right", 2e7, 1e7, speed_law=law)]
    stiffness = np.geomspace(1e6, 1e8, 5)

    def solved():
        with SYSTEMS.counted() as counts:
            found = critical_speed_map(
                one_rotor(shaft, held), [held[0].name], stiffness, speed_max_rad_s=2000.0
            )
        return found, counts

    found, counts = solved()
    monkeypatch.setattr(speed_roots, "held_modes", lambda *_: None)
    by_signs, many = solved()
    assert found.speed_rad_s.shape[0] > 3
    np.testing.assert_allclose(found.speed_rad_s, by_signs.speed_rad_s, rtol=1e-11)
    np.testing.assert_allclose(found.likeness, by_signs.likeness, atol=1e-6)
    assert counts["eigenproblems"] + counts["factorisations"] <= 15 * stiffness.size
    assert many["eigenproblems"] > 5 * counts["eigenproblems"]
