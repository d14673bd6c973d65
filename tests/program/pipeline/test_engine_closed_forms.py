"""Scenes of beams, rigid bodies, gears, speed laws and internal damping against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import (
    E_PA,
    MASS,
    MATERIALS,
    NU,
    POLAR,
    RISING,
    RPM,
    TABLE,
    joined,
    rigid_rotor,
    rotor_on_shaft,
)

from solidwhirl.build import cylinder
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.solver


def shaft_stiffness(radius=0.02, length=1.0):
    """Force in the middle of a pinned Timoshenko shaft; shear after Cowper (1966)."""
    bending = E_PA * np.pi * radius**4 / 4.0
    shear = 6 * (1 + NU) / (7 + 6 * NU) * E_PA / (2 * (1 + NU)) * np.pi * radius**2
    return 1.0 / (length**3 / (48.0 * bending) + length / (4.0 * shear))


def run(data):
    return run_scene(parse_scene(data))


def lowest(data, count=4):
    return run(data).at_rest.frequency_hz[:count]


# -- closed forms ---------------------------------------------------------------------------------


def test_rigid_rotor_along_and_about_its_axis():
    data = rigid_rotor()
    data["bearings"][0] |= {"axial_stiffness_n_per_m": 7e5, "torsion_stiffness_n_m_per_rad": 8e4}
    found = run(data).at_rest.frequency_hz * 2 * np.pi
    for wanted in (np.sqrt(7e5 / MASS), np.sqrt(8e4 / POLAR)):
        assert np.abs(found / wanted - 1.0).min() < 1e-9


def test_casing_with_its_mass_off_the_axis():
    """On springs at 0, c.g. at (x, 0, 0): uy drags rz along, which nothing holds.

    Then w^2 = k / (m Izz / (Izz + m x^2)), from m (y'' + x r'') = -k y, (Izz + m x^2) r'' =
    -m x y''. Held within the body, torsion would make that k / m.
    """
    data = rigid_rotor(a=-0.4, b=0.4)
    data["rigid_bodies"]["rotor"] |= {"speed_ratio": 0.0, "center_of_gravity_m": [0.3, 0.0, 0.0]}
    wanted = np.sqrt(4e6 / (MASS * POLAR / (POLAR + MASS * 0.3**2))) / (2 * np.pi)
    assert np.abs(run(data).at_rest.frequency_hz / wanted - 1.0).min() < 1e-9


@pytest.mark.parametrize(
    "odd", [{"center_of_gravity_m": [0.1, 0.0, 0.0]}, {"inertia_kg_m2": [0.5, 0.8, 0.9]}]
)
def test_turning_body_that_is_not_the_same_all_round_is_refused(odd):
    """Its mass matrix would turn in the inertial frame, which the equations do not have."""
    data = rigid_rotor(rpm=(0.0, 3e3))
    data["rigid_bodies"]["rotor"] |= odd
    with pytest.raises(ValueError, match="rotor"):
        joined(data)


def geared(ratio=-2.5, **gear):
    """Two rigid wheels with a gear between them."""
    data = rigid_rotor(gears=[{"name": "g", "first": "rotor.m", "second": "wheel.m", **gear}])
    data["gears"][0]["ratio"] = ratio
    wheel = {**data["rigid_bodies"]["rotor"], "speed_ratio": ratio, "mass_kg": 5.0}
    data["rigid_bodies"]["wheel"] = {**wheel, "inertia_kg_m2": [0.3, 0.3, 0.2]}
    data["bearings"] += [{"name": "C", "first": "wheel.m", "stiffness_n_per_m": 4e6}]
    return data


def test_rigid_gear():
    """Inertia seen from the spring: J1 + n^2 J2."""
    data = geared()
    data["bearings"][0]["torsion_stiffness_n_m_per_rad"] = 5e4
    wanted = np.sqrt(5e4 / (POLAR + 2.5**2 * 0.2)) / (2 * np.pi)
    assert np.abs(run(data).at_rest.frequency_hz / wanted - 1.0).min() < 1e-9


def test_elastic_gear_with_a_line_of_action():
    """Along y, by hand: teeth see y1 + r1 rz1 - y2 - (r1 / n) rz2; across it nothing changes."""
    mesh = {"base_radius_first_m": 0.2, "mesh_stiffness_n_per_m": 3e6, "line_of_action_deg": 90.0}
    found = run(geared(**mesh)).at_rest.frequency_hz * 2 * np.pi
    teeth = np.array([1.0, 0.2, -1.0, 0.2 / 2.5])
    stiffness = np.diag([4e6, 0.0, 4e6, 0.0]) + 3e6 * np.outer(teeth, teeth)
    squares = np.linalg.eigvals(np.diag(1.0 / np.array([MASS, POLAR, 5.0, 0.2])) @ stiffness).real
    for square in (*np.sort(squares)[1:], 4e6 / MASS, 4e6 / 5.0):  # the first turns freely
        assert np.abs(found / np.sqrt(square) - 1.0).min() < 1e-9


# -- speed laws -----------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [1.0, -2.0])
@pytest.mark.parametrize("name", ["rising", "table"])
def test_law_shifts_the_critical_speed(name, ratio):
    """m W^2 = 2 k(W) at the shaft's own speed W; the reference shaft turns at W / |ratio|."""
    data = rigid_rotor(rpm=(0.0, 12e3), speed_laws={"rising": RISING, "table": TABLE})
    data["rigid_bodies"]["rotor"]["speed_ratio"] = ratio
    for bearing in data["bearings"]:
        bearing["speed_law"] = name
        if name == "table":
            del bearing["stiffness_n_per_m"]
    if name == "rising":
        wanted = np.sqrt(4e6 / (MASS - 4e6 * 4e-7))
    else:
        wanted = max(np.roots([MASS, -2 * 3e3, -4e6]))  # 2e6 N/m and 3e3 N s/(m rad) per bearing
    found = np.array([c.critical.speed_rad_s for c in run(data).critical_speeds])
    assert np.abs(found * abs(ratio) / wanted - 1.0).min() < 1e-9
    assert np.abs(found * abs(ratio) / np.sqrt(4e6 / MASS) - 1.0).min() > 0.01


def test_laws_switched_off_are_not_there():
    """The same as with constant bearings, bit for bit."""
    data = rigid_rotor(rpm=(0.0, 3e3, 9e3))
    plain = run(data)
    data["speed_laws"] = {"rising": RISING}
    data["bearings"][0]["speed_law"] = "rising"
    off = run({**data, "effects": {"speed_dependent_bearings": "off"}})
    assert np.array_equal(off.campbell.frequency_hz, plain.campbell.frequency_hz)
    assert [c.critical.speed_rad_s for c in off.critical_speeds] == [
        c.critical.speed_rad_s for c in plain.critical_speeds
    ]
    assert not np.array_equal(run(data).campbell.frequency_hz, plain.campbell.frequency_hz)
    # a table switched off leaves a bearing: at rest the law on or off is the same
    data = rigid_rotor(speed_laws={"table": TABLE})
    data["bearings"][0] = {"name": "A", "first": "rotor.a", "speed_law": "table"}
    off = lowest({**data, "effects": {"speed_dependent_bearings": "off"}})
    np.testing.assert_allclose(off, lowest(data), rtol=1e-12)


# -- internal damping -----------------------------------------------------------------------------


def threshold(data, to_rpm):
    data["analyses"] = [{"kind": "stability", "to_rpm": to_rpm, "count": 3}]
    found = run(data).analyses["stability"].document["threshold"]
    return found["speed_rpm"] * RPM, found["frequency_hz"] * 2 * np.pi


@pytest.mark.parametrize("external", [0.0, 30.0])
def test_threshold_of_internal_damping(external):
    """W = w (1 + c_e / c_i), c_i = beta k: Genta, Dynamics of Rotating Systems, section 2.5."""
    data = rotor_on_shaft()
    data["beams"]["rotor"]["internal_damping"] = {"stiffness_coefficient_s": 1e-4}
    data["bearings"] += [{"name": "C", "first": "rotor.m", "damping_n_s_per_m": external}]
    frequency = np.sqrt(shaft_stiffness() / MASS)
    speed, whirl = threshold(data, 6e3)
    wanted = frequency * (1.0 + external / (1e-4 * shaft_stiffness()))
    # the shaft itself weighs 1e-6 of the disk; beta k is damping of 1 % and less, in the square
    assert speed == pytest.approx(wanted, rel=1e-5)
    assert whirl == pytest.approx(frequency, rel=1e-5)


@pytest.mark.parametrize(
    "damping", [{"modal_ratio": 0.01}, {"stiffness_coefficient_s": 1e-6, "modal_ratio": 0.02}]
)
def test_damping_that_turns_with_a_solid_is_neutral_at_the_critical_speed(small_scene, damping):
    """At W = w forward the body sees a deflection at rest, whatever the damping."""
    data = small_scene(rpm=(0.0, 15e3), body={"internal_damping": damping})
    plain = run({**data, "effects": {"internal_damping": "off"}}).critical_speeds
    forward = [c.critical.speed_rad_s for c in plain if c.critical.whirl == "forward"]
    speed, whirl = threshold(data, 15e3)
    assert speed == pytest.approx(forward[0], rel=1e-6)
    assert whirl == pytest.approx(speed, rel=1e-6)


# -- levels in one scene --------------------------------------------------------------------------


def test_solid_and_beam_of_one_shaft_in_one_scene():
    """1 m of 10 mm radius on springs: beam theory and the solid agree to 0.3 % and mix freely."""
    section = {"name": "s", "start_m": 0.0, "end_m": 1.0, "outer_radius_m": 0.01}
    ends = [{"name": n, "kind": "section", "at_m": z} for n, z in (("a", 0.0), ("b", 1.0))]
    solid = {"material": "plain", "sections": [section], "interfaces": ends}
    beam = {"material": "plain", "stations_m": np.linspace(0.0, 1.0, 21).tolist()}
    beam |= {"outer_radius_m": [0.01], "interfaces": {"a": 0.0, "b": 1.0}}
    data = {"name": "mixed", "materials": MATERIALS, "bodies": {"s": solid}, "beams": {"b": beam}}
    data["bearings"] = [
        {"name": f"{n}{z}", "first": f"{n}.{z}", "stiffness_n_per_m": 1e6}
        for n in "sb"
        for z in "ab"
    ]
    parts = []
    for drop, n in (("beams", "s"), ("bodies", "b")):
        own = [b for b in data["bearings"] if b["first"].startswith(n)]
        parts.append(lowest({**{k: v for k, v in data.items() if k != drop}, "bearings": own}, 8))
    np.testing.assert_allclose(parts[0], parts[1], rtol=3e-3)
    np.testing.assert_allclose(lowest(data, 16), np.sort(np.concatenate(parts)), rtol=1e-9)


@pytest.mark.parametrize("level", ["beam", "harmonic", "solid"])
@pytest.mark.parametrize("acts", ["axial", "torsion"])
def test_one_motion_along_the_axis_brings_the_other(level, acts):
    """A uniform rod on one soft spring along or about its axis; the other motion is free.

    Elastic modes of both are those of the free rod, c/2l and its multiples, and the rod as a whole
    is on the spring; what nothing holds is no mode. The spring lifts them by k φ²/2ω² < 1e-4, and
    contraction across the rod lowers the axial one by (ν π r/2l)² = 1e-4.
    """
    radius, length = 0.02, 1.0
    rho = MATERIALS["plain"]["density_kg_per_m3"]
    mass = rho * np.pi * radius**2 * length
    spring, inertia = (1e5, mass) if acts == "axial" else (1e2, 0.5 * mass * radius**2)
    key = {"axial": "axial_stiffness_n_per_m", "torsion": "torsion_stiffness_n_m_per_rad"}[acts]
    data = {
        "name": "rod",
        "model": {"level": level, "estimates": "off", "order": 2, "size_m": 0.1, "modes": 4},
        "materials": MATERIALS,
        "bodies": {
            "rod": {
                "material": "plain",
                "sections": [cylinder("s", 0.0, length, radius)],
                "interfaces": [
                    {"name": n, "kind": "section", "at_m": z} for n, z in (("a", 0.1), ("b", 0.9))
                ],
            }
        },
        "bearings": [
            {"name": "a", "first": "rod.a", "stiffness_n_per_m": 1e8, key: spring},
            {"name": "b", "first": "rod.b", "stiffness_n_per_m": 1e8},
        ],
    }
    found = lowest(data, None)
    # the same in all directions, so that lateral modes come in pairs
    paired = np.diff(found) < 1e-6 * found[1:]
    alone = found[~(np.append(paired, False) | np.insert(paired, 0, False))]
    waves = np.sqrt([E_PA / (2.0 * (1.0 + NU) * rho), E_PA / rho]) / (2.0 * length)
    exact = [np.sqrt(spring / inertia) / (2.0 * np.pi), *waves]
    assert alone[: len(exact)] == pytest.approx(exact, rel=2e-3)


def test_modes_of_one_body(small_scene):
    """Two of the modes, each in both planes, less than [model] says for all; none beyond all."""
    from solidwhirl.reduction import ReductionError

    few, many = (
        run(small_scene(rpm=None, model={"modes": 4}, body=body)).elements["rotor"]
        for body in ({"modes": 2}, {})
    )
    assert many.size - few.size == 2 * 2
    shaft = {"sections": [cylinder("shaft", 0.0, 0.4, 0.02)], "modes": 500}
    with pytest.raises(ReductionError, match="500 fixed-interface modes are asked for, the body"):
        run(small_scene(rpm=None, body=shaft))
