"""Critical speed maps: closed forms, limits of the stiffness, re-assembly, published rotors."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from solidwhirl.rotordyn import (
    AnalysisError,
    AssemblyError,
    Bearing,
    Disk,
    End,
    Rotor,
    assemble,
    beam_superelement,
    critical_speeds,
    rigid_superelement,
)
from solidwhirl.rotordyn.assembly.bearing_laws import LEE_ISOTROPIC, PolynomialLaw, TableLaw
from solidwhirl.rotordyn.assembly.system import with_bearing_stiffness
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map

RPM = np.pi / 30.0


def _on_springs(element, names, stiffness=1e6, ratio=1.0, law=None):
    bearings = tuple(
        Bearing(
            name=name,
            first=End(body="rotor", interface=name),
            stiffness_n_per_m=stiffness * np.eye(2),
            speed_law=law,
        )
        for name in names
    )
    return assemble({"rotor": Rotor(element=element, speed_ratio=ratio)}, bearings)


def _sorted_by_whirl(speeds, whirl):
    return {w: np.sort(speeds[whirl == w]) for w in ("backward", "forward")}


# Closed forms.


def test_rigid_rotor_on_two_springs():
    """Bounce 2k = mΩ², tilt 2ka² = Ω²(Id ∓ Ip) of a symmetric rigid rotor, any stiffness."""
    mass, diametral, polar, arm = 30.0, 0.9, 0.3, 0.35
    body = rigid_superelement(
        "drum", mass, [0, 0, 0], [diametral, diametral, polar], {"a": -arm, "b": arm},
    )  # fmt: skip
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
    disk = Disk(
        name="disk", position_m=length / 2, mass_kg=mass, diametral_kg_m2=0.5, polar_kg_m2=0.2
    )
    shaft = beam_superelement(
        "laval", np.linspace(0, length, 9), radius, 0.0, (modulus, poisson, 0.04),
        {"a": 0.0, "b": length}, [disk],
    )  # fmt: skip
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


@pytest.fixture(scope="module")
def beam():
    """Uniform steel shaft and its data."""
    data = (1.0, 0.03, 2.1e11, 0.3, 7850.0)
    length, radius, *material = data
    stations = np.linspace(0, length, 33)
    element = beam_superelement(
        "beam", stations, radius, 0.0, tuple(material), {"a": 0.0, "b": length}
    )
    return element, data


def test_soft_supports_lead_to_the_free_beam(beam):
    """Rigid motions fall with √k to bounce and tilt; elastic ones end at the free beam's."""
    element, _ = beam
    stiffness = np.array([1e2, 1e3, 1e4])
    system = _on_springs(element, "ab")
    found = critical_speed_map(system, ["a", "b"], stiffness, branch_count=3)
    free = _sorted_by_whirl(found.free_rad_s, found.free_whirl)
    inertia = element.inertia_kg_m2
    for whirl, sign in (("backward", 1), ("forward", -1)):
        rows = np.sort(found.speed_rad_s[(found.whirl == whirl).all(axis=1)], axis=0)
        bounce = np.sqrt(2 * stiffness / element.mass_kg)
        about_middle = inertia[0, 0] + sign * inertia[2, 2]
        tilt = np.sqrt(2 * stiffness * 0.5**2 / about_middle)
        # Bending under the inertia loads: relative k L³/(48 EI), 2e-6 for the softest.
        np.testing.assert_allclose(rows[0, 0], bounce[0], rtol=1e-5)
        np.testing.assert_allclose(rows[1, 0], tilt[0], rtol=1e-5)
        error = rows[2] / free[whirl][0] - 1
        np.testing.assert_allclose(error[1:] / error[:-1], 10.0, rtol=2e-2)


# Against assembling anew at each stiffness.


@pytest.mark.parametrize("ratio", [1.0, 1.6])
def test_map_is_that_of_reassembled_systems(three_disk_element, ratio):
    system = _on_springs(three_disk_element(), ["left", "right"], 7e7)
    stiffness = np.geomspace(1e4, 1e12, 9)
    found = critical_speed_map(
        system, ["left", "right"], stiffness, excitation_ratio=ratio, branch_count=3
    )
    for column, k in enumerate(stiffness):
        again = critical_speeds(with_bearing_stiffness(system, ["left", "right"], k), ratio)
        for whirl in ("backward", "forward"):
            direct = [c.speed_rad_s for c in again if c.whirl == whirl][:3]
            mapped = np.sort(found.speed_rad_s[found.whirl[:, column] == whirl, column])
            np.testing.assert_allclose(mapped[: len(direct)], direct, rtol=1e-12)


@pytest.mark.parametrize("varied", [["C"], ["inner.A", "inner.B", "outer.D"], ["outer.D"]])
def test_map_passes_the_stiffness_of_other_joints(twin, varied):
    """Counter-rotating shafts, anisotropic: k goes from below to above the other joints.

    Coordinates follow the stiffest path, so a map that did not change them would lose digits.
    """
    system = twin(support=3e9, joint=2e7)
    stiffness = np.geomspace(1e4, 1e12, 9)
    found = critical_speed_map(system, varied, stiffness, branch_count=3)
    for column, k in enumerate(stiffness):
        again = critical_speeds(with_bearing_stiffness(system, varied, k))
        direct = [c.speed_rad_s for c in again][:6]
        mapped = np.sort(found.speed_rad_s[:, column])[:6]
        np.testing.assert_allclose(mapped, direct, rtol=1e-9)
        whirl = found.whirl[np.argsort(found.speed_rad_s[:, column]), column][:6]
        assert list(whirl) == [c.whirl for c in again][:6]


def test_asymptotes_are_those_of_reassembled_systems(twin):
    system = twin(support=3e9, joint=2e7)
    found = critical_speed_map(system, ["C"], [1e6], branch_count=3)
    free = critical_speeds(with_bearing_stiffness(system, ["C"], 0.0))[:6]
    np.testing.assert_allclose(found.free_rad_s, [c.speed_rad_s for c in free], rtol=1e-10)
    rigid = critical_speeds(twin(support=3e9, joint=None))[:6]
    np.testing.assert_allclose(found.rigid_rad_s, [c.speed_rad_s for c in rigid], rtol=1e-10)
    assert list(found.rigid_whirl) == [c.whirl for c in rigid]


def test_axial_motion_and_torsion_are_left_out(
    three_disk_element, with_axial_and_torsion, one_rotor, ground
):
    shaft = with_axial_and_torsion(three_disk_element(), 1.3, 0.05, "left", "right")
    options = {"axial_stiffness_n_per_m": 1e6, "torsion_stiffness_n_m_per_rad": 1e4}
    bearings = [ground("rotor", end, 7e7, 7e7, **options) for end in ("left", "right")]
    plain = [ground("rotor", end, 7e7, 7e7) for end in ("left", "right")]
    names = [b.name for b in bearings]
    stiffness = np.geomspace(1e6, 1e9, 4)
    spatial, lateral = (
        critical_speed_map(one_rotor(e, b), names, stiffness, speed_max_rad_s=3000.0)
        for e, b in ((shaft, bearings), (three_disk_element(), plain))
    )
    assert set(spatial.whirl.ravel()) <= {"forward", "backward", ""}
    np.testing.assert_allclose(spatial.speed_rad_s, lateral.speed_rad_s, rtol=1e-10)


def test_damping_and_own_stiffness_are_left_out(three_disk):
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


def test_branches_are_continuous_and_never_swap(three_disk_element):
    """With a fine grid neighbours differ little; a coarse one must join the same branches."""
    system = _on_springs(three_disk_element(), ["left", "right"], 7e7)
    fine = critical_speed_map(
        system, ["left", "right"], np.geomspace(1e5, 1e11, 121), branch_count=3
    )
    coarse = critical_speed_map(
        system, ["left", "right"], np.geomspace(1e5, 1e11, 7), branch_count=3
    )
    np.testing.assert_allclose(coarse.speed_rad_s, fine.speed_rad_s[:, ::20], rtol=1e-11)
    np.testing.assert_array_equal(coarse.whirl, fine.whirl[:, ::20])
    # More support stiffness never lowers a critical speed of constant bearings (Courant).
    assert (np.diff(fine.speed_rad_s, axis=1) > 0).all()
    assert fine.likeness.min() > 0.9


def test_crossing_of_symmetric_and_antisymmetric_modes():
    """Two disks at the ends, far out: tilt crosses bounce as supports stiffen; shapes decide.

    In closed form: bounce 2k = mΩ², tilt 2ka² + κ = (Id + Ip)Ω² with a constant tilt spring κ.
    """
    mass, diametral, polar, arm, tilt = 30.0, 3.0, 0.3, 0.2, 2e5
    body = rigid_superelement(
        "drum", mass, [0, 0, 0], [diametral, diametral, polar],
        {"a": -arm, "b": arm, "middle": 0.0},
    )  # fmt: skip
    system = _on_springs(body, "ab")
    held = Bearing(
        name="tilt",
        first=End(body="rotor", interface="middle"),
        tilt_stiffness_n_m_per_rad=tilt * np.eye(2),
    )
    system = assemble(system.system.rotors, (*system.system.bearings, held))
    stiffness = np.geomspace(1e5, 1e7, 12)
    found = critical_speed_map(system, ["a", "b"], stiffness, branch_count=2)
    bounce = np.sqrt(2 * stiffness / mass)
    backward = np.sqrt((2 * stiffness * arm**2 + tilt) / (diametral + polar))
    assert (bounce[0] - backward[0]) * (bounce[-1] - backward[-1]) < 0
    rows = found.speed_rad_s[(found.whirl == "backward").all(axis=1)]
    np.testing.assert_allclose(rows, [bounce, backward], rtol=1e-10)


def test_limit_cuts_branches(three_disk_element):
    system = _on_springs(three_disk_element(), ["left", "right"], 7e7)
    stiffness = np.geomspace(1e5, 1e11, 13)
    every = critical_speed_map(system, ["left", "right"], stiffness, branch_count=3)
    below = critical_speed_map(system, ["left", "right"], stiffness, speed_max_rad_s=1400.0)
    assert np.nanmax(below.speed_rad_s) <= 1400.0
    seen = every.speed_rad_s <= 1400.0
    assert np.count_nonzero(np.isfinite(below.speed_rad_s)) == np.count_nonzero(seen)
    np.testing.assert_array_equal(below.whirl == "", np.isnan(below.speed_rad_s))
    assert below.rigid_rad_s.max() <= 1400.0


# Published rotors.


_NELSON_STATIONS_CM = [
    0, 1.27, 5.08, 7.62, 8.89, 10.16, 10.67, 11.43, 12.70, 13.46, 16.51, 19.05, 22.86, 26.67,
    28.70, 30.48, 31.50, 34.54, 35.5,
]  # fmt: skip
_NELSON_RADII_CM = [
    0.51, 1.02, 0.76, 2.03, 2.03, 3.30, 3.30, 2.54, 2.54, 1.27, 1.27, 1.52, 1.52, 1.27, 1.27,
    3.81, 2.03, 2.03,
]  # fmt: skip


def test_nelson_mcvaugh_rotor_on_the_map():
    """Nelson and McVaugh 1976: 15470/17159, 46612/49983, 64752/96457 rpm at 4.378e7 N/m.

    Their beam has no shear; the Timoshenko beam lies up to 1.5 % below.
    """
    inner = np.zeros(18)
    inner[[6, 7, 17]] = [0.0152, 0.0178, 0.0152]
    disk = Disk(
        name="disk", position_m=0.0889, mass_kg=1.401, diametral_kg_m2=0.00136, polar_kg_m2=0.00203
    )
    shaft = beam_superelement(
        "nelson", np.array(_NELSON_STATIONS_CM) / 100, np.array(_NELSON_RADII_CM) / 100, inner,
        (2.078e11, 2.078e11 / (2 * 1.039e11) - 1, 7806.0), {"left": 0.1651, "right": 0.2870},
        [disk],
    )  # fmt: skip
    stiffness = [1e6, 4.378e7, 1e10]
    found = critical_speed_map(
        _on_springs(shaft, ["left", "right"]), ["left", "right"], stiffness, branch_count=3
    )
    rpm = _sorted_by_whirl(found.speed_rad_s[:, 1] / RPM, found.whirl[:, 1])
    published = {"backward": [15470, 46612, 64752], "forward": [17159, 49983, 96457]}
    for whirl, expected in published.items():
        below = np.array(expected) / rpm[whirl] - 1
        assert (below > 1e-3).all()
        assert (below < 1.5e-2).all()


# Bearings that depend on the speed.


def test_map_of_lee_bearings_on_a_rigid_rotor():
    """Bounce alone: 2k p(Ω) = mΩ², all positive roots of a polynomial at each stiffness."""
    mass = 30.0
    body = rigid_superelement(
        "drum", mass, [0, 0, 0], [40.0, 40.0, 0.3], {"a": -0.3, "b": 0.3},
    )  # fmt: skip
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


def test_map_of_lee_bearings_folds_back(three_disk_element):
    """Where k(Ω) grows faster than Ω² one mode has three critical speeds, found by re-assembly."""
    names = ["left", "right"]
    system = _on_springs(three_disk_element(), names, 7e7, law=LEE_ISOTROPIC)
    stiffness = np.array([1.85e8, 1.95e8, 2.05e8])
    found = critical_speed_map(system, names, stiffness, speed_max_rad_s=2000.0)
    forward = [
        np.sort(found.speed_rad_s[found.whirl[:, column] == "forward", column])
        for column in range(3)
    ]
    assert [speeds.size for speeds in forward] == [2, 4, 2]
    for speeds, k in zip(forward, stiffness, strict=True):
        again = critical_speeds(with_bearing_stiffness(system, names, k), 1.0, 2000.0)
        direct = [c.speed_rad_s for c in again if c.whirl == "forward"]
        np.testing.assert_allclose(speeds, direct, rtol=1e-9)


def test_constant_law_gives_the_map_of_constant_bearings(three_disk_element):
    one = PolynomialLaw(
        name="one", argument_unit="Hz", argument_range=(0.0, 1e3), stiffness_x=(1.0,),
        stiffness_y=(1.0,), damping_x=(1.0,), damping_y=(1.0,),
    )  # fmt: skip
    stiffness = np.geomspace(1e6, 1e10, 5)
    direct, searched = (
        critical_speed_map(
            _on_springs(three_disk_element(), ["left", "right"], 7e7, law=law),
            ["left", "right"],
            stiffness,
            speed_max_rad_s=2000.0,
        )
        for law in (None, one)
    )
    for column in range(stiffness.size):
        one, two = (np.sort(m.speed_rad_s[:, column]) for m in (direct, searched))
        one, two = one[np.isfinite(one)], two[np.isfinite(two)]
        np.testing.assert_allclose(two, one, rtol=1e-10)


def test_other_bearings_keep_their_law(three_disk_element):
    """Vary one constant bearing beside one that depends on the speed."""
    system = _on_springs(three_disk_element(), ["left", "right"], 7e7, law=LEE_ISOTROPIC)
    bearings = tuple(
        dataclasses.replace(b, speed_law=None) if b.name == "right" else b
        for b in system.system.bearings
    )
    system = assemble(system.system.rotors, bearings)
    stiffness = np.array([1e6, 1e8, 1e10])
    found = critical_speed_map(system, ["right"], stiffness, speed_max_rad_s=900.0)
    for column, k in enumerate(stiffness):
        again = critical_speeds(with_bearing_stiffness(system, ["right"], k), 1.0, 900.0)
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
def test_arguments_without_meaning_are_refused(three_disk_element, arguments, message):
    given = {"bearings": ["left"], "stiffnesses_n_per_m": [1e6], "branch_count": 2} | arguments
    system = _on_springs(three_disk_element(), ["left", "right"])
    with pytest.raises(AnalysisError, match=message):
        critical_speed_map(system, given.pop("bearings"), given.pop("stiffnesses_n_per_m"), **given)


def test_bearings_that_cannot_be_varied_are_refused(three_disk_element, twin, one_rotor):
    with pytest.raises(AnalysisError, match="bearing 'C' is rigid"):
        critical_speed_map(twin(), ["C"], [1e6], branch_count=1)
    lee = _on_springs(three_disk_element(), ["left", "right"], law=LEE_ISOTROPIC)
    with pytest.raises(AnalysisError, match="bearings depend on the speed"):
        critical_speed_map(lee, ["left"], [1e6], branch_count=1)
    crossed = Bearing(
        name="seal",
        first=End(body="rotor", interface="left"),
        stiffness_n_per_m=np.array([[1e6, 2e5], [-2e5, 1e6]]),
    )
    soft = _on_springs(three_disk_element(), ["left", "right"])
    seal = assemble(soft.system.rotors, (*soft.system.bearings, crossed))
    with pytest.raises(AnalysisError, match="not symmetric"):
        critical_speed_map(seal, ["left"], [1e6], branch_count=1)
    table = TableLaw(
        name="film",
        speeds_rad_s=np.array([0.0, 100.0]),
        stiffness_n_per_m=np.stack([1e7 * np.eye(2)] * 2),
        damping_n_s_per_m=np.zeros((2, 2, 2)),
    )
    film = _on_springs(three_disk_element(), ["left", "right"], 0.0, law=table)
    with pytest.raises(AssemblyError, match="table of absolute values"):
        critical_speed_map(film, ["left"], [1e6], speed_max_rad_s=100.0)
