"""Static deflection and bearing loads against beams, balances of forces and the force method."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import (
    between_bearings,
    ground,
    one_rotor,
    pinned,
    steel_shaft,
    table_law,
    truncated,
    turning,
)

from solidwhirl.rotordyn import AnalysisError, AssemblyError, End, Gear, assemble
from solidwhirl.rotordyn.estimates.static_errors import static_errors
from solidwhirl.rotordyn.response.load_equilibrium import loads_in_equilibrium
from solidwhirl.rotordyn.response.static import (
    DOWN,
    STANDARD_GRAVITY,
    PointLoad,
    bearing_loads,
    static_response,
)

MODULUS, DENSITY, NU = 2e11, 7800.0, 0.3
LENGTH, RADIUS = 1.2, 0.06
AREA, SECOND = np.pi * RADIUS**2, 0.25 * np.pi * RADIUS**4
LINE = DENSITY * AREA * STANDARD_GRAVITY  # weight per length
# Cowper 1966, solid circle
KAPPA = 6.0 * (1.0 + NU) / (7.0 + 6.0 * NU)
SHEAR = KAPPA * AREA * MODULUS / (2.0 * (1.0 + NU))
BENDING = MODULUS * SECOND


def shaft(places=None, disks=(), length=LENGTH, sections=24, **options):
    places = places or {"left": 0.0, "mid": 0.5 * length, "right": length}
    return steel_shaft(
        "s", np.linspace(0.0, length, sections + 1), RADIUS, places, disks, **options
    )


def test_sag_slope_and_loads_of_a_thick_shaft_on_two_supports():
    """5 w L^4 / 384 EI + w L^2 / 8 kGA, w L^3 / 24 EI; loads w L / 2; turned about the axis."""
    system = one_rotor(shaft(), [pinned("rotor", "left"), pinned("rotor", "right")])
    bend = 5.0 * LINE * LENGTH**4 / (384.0 * BENDING) + LINE * LENGTH**2 / (8.0 * SHEAR)
    for angle in (-90.0, 30.0):
        way = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
        found = static_response(system, STANDARD_GRAVITY * way)
        line = found.lines["rotor"]
        sag, place = line.sag
        assert sag == pytest.approx(bend, rel=1e-9)
        assert place == pytest.approx(LENGTH / 2)
        middle = line.deflection_m[line.axial_m == place][0]
        np.testing.assert_allclose(middle, bend * way[:2], rtol=1e-9, atol=1e-20)
        for name, sign in (("rotor.left", 1.0), ("rotor.right", -1.0)):
            load = found.bearing_loads[name]
            np.testing.assert_allclose(load[:3], 0.5 * LINE * LENGTH * way, rtol=1e-9, atol=1e-9)
            slope = sign * LINE * LENGTH**3 / (24.0 * BENDING) * way[:2]
            np.testing.assert_allclose(found.slopes_rad[name], slope, rtol=1e-9, atol=1e-18)
        # the line: shear adds w L / 2 kGA to its slope at the end, differences miss 4 h^2 / L^2
        whole = LINE * LENGTH**3 / (24.0 * BENDING) + LINE * LENGTH / (2.0 * SHEAR)
        np.testing.assert_allclose(line.slope_rad[0], whole * way[:2], rtol=8e-3, atol=1e-12)
        assert found.relative_residual < 1e-9


def test_overhung_disk():
    """A disk a beyond a bearing: W a^2 (L + a) / 3 EI; loads up W a / L, down W (L + a) / L."""
    a, mass = 0.3, 50.0
    element = steel_shaft(
        "s", np.linspace(0.0, LENGTH + a, 26), 0.03, {"left": 0.0, "right": LENGTH,
        "end": LENGTH + a}, [(LENGTH + a, mass, 0.5, 0.3)], material=(MODULUS, NU, 1e-6),
    )  # fmt: skip
    system = one_rotor(element, [ground("rotor", "left", 1e13), ground("rotor", "right", 1e13)])
    found = static_response(system)
    weight, bending = mass * STANDARD_GRAVITY, MODULUS * 0.25 * np.pi * 0.03**4
    shear = KAPPA * np.pi * 0.03**2 * MODULUS / (2.0 * (1.0 + NU))
    down = weight * a**2 * (LENGTH + a) / (3.0 * bending)
    down += weight * (a + a**2 / LENGTH) / shear
    assert found.lines["rotor"].sag == pytest.approx((down, LENGTH + a), rel=1e-6)
    loads = [found.bearing_loads[f"rotor.{end}"][1] for end in ("left", "right")]
    wanted = [weight * a / LENGTH, -weight * (LENGTH + a) / LENGTH]
    np.testing.assert_allclose(loads, wanted, rtol=1e-6)
    assert found.relative_residual < 1e-9


def middle_load(softness):
    """Load of the middle one of three bearings of this compliance, by the force method."""
    free = 5.0 * LINE * LENGTH**4 / (384.0 * BENDING) + LINE * LENGTH**2 / (8.0 * SHEAR)
    unit = LENGTH**3 / (48.0 * BENDING) + LENGTH / (4.0 * SHEAR)
    ends = 0.5 * softness[0]
    return (free + ends * LINE * LENGTH) / (unit + softness[1] + 0.5 * softness[0])


@pytest.mark.parametrize("softness", [(0.0, 0.0), (2e-9, 5e-9)])
def test_shaft_on_three_bearings(softness):
    places = ("left", "mid", "right")
    ends, mid = softness
    held = [pinned("rotor", p) for p in places]
    if ends:
        held = [ground("rotor", p, 1.0 / (mid if p == "mid" else ends)) for p in places]
    loads = bearing_loads(one_rotor(shaft(), held))
    middle = middle_load(softness)
    wanted = [0.5 * (LINE * LENGTH - middle), middle, 0.5 * (LINE * LENGTH - middle)]
    np.testing.assert_allclose([-loads[f"rotor.{p}"][1] for p in places], wanted, rtol=1e-8)


def test_stiffness_that_depends_on_the_load():
    """k = c W^n on three bearings against the same fixed point by the force method."""

    factors = {"left": 3e7, "mid": 4e7, "right": 3e7}
    for power in (0.4, -0.9):

        def stiffness(name, load, power=power):
            return factors[name] * (load / 300.0) ** power

        def assemble_with(loads, stiffness=stiffness):
            held = [ground("rotor", p, stiffness(p, loads[f"rotor.{p}"])) for p in factors]
            return one_rotor(shaft(), held)

        start = dict.fromkeys((f"rotor.{p}" for p in factors), LINE * LENGTH / 3.0)
        found = loads_in_equilibrium(assemble_with, start)
        assert found.converged and found.changes[-1] <= 1e-9
        ends, middle = found.loads_n["rotor.left"], found.loads_n["rotor.mid"]
        own = middle_load((1.0 / stiffness("left", ends), 1.0 / stiffness("mid", middle)))
        assert middle == pytest.approx(own, rel=1e-8)
        assert 2.0 * ends + middle == pytest.approx(LINE * LENGTH, rel=1e-8)
    few = loads_in_equilibrium(assemble_with, start, most=2)
    assert not few.converged and len(few.changes) == 2
    with pytest.raises(AnalysisError, match="no bearings"):
        loads_in_equilibrium(assemble_with, {**start, "X": 1.0})


def geared():
    """Two shafts with their wheels amid bearings; 20 degrees of pressure, x to the second."""
    ends = {"left": 0.0, "mid": 0.5 * LENGTH, "right": LENGTH}
    body = shaft(ends, components=("ux", "uy", "rx", "ry", "rz"))
    held = [ground(name, end, 1e9) for name in "ab" for end in ("left", "right")]
    gear = Gear(
        name="g", first=End(body="a", interface="mid"), second=End(body="b", interface="mid"),
        ratio=-2.0, base_radius_first_m=0.2, line_of_action_rad=np.radians(70.0),
    )  # fmt: skip
    return assemble({"a": turning(body), "b": turning(body, -2.0)}, tuple(held), gears=(gear,))


def test_forces_of_gear_teeth():
    """T / r along the line of action, shared by both bearings of each shaft."""
    found = static_response(geared(), (0.0, 0.0, 0.0), gear_torques_n_m={"g": 500.0})
    force = 500.0 / 0.2 * np.array([np.cos(np.radians(70.0)), np.sin(np.radians(70.0)), 0.0])
    for end in ("left", "right"):
        np.testing.assert_allclose(found.bearing_loads[f"a.{end}"][:3], -0.5 * force, rtol=1e-8)
        np.testing.assert_allclose(found.bearing_loads[f"b.{end}"][:3], 0.5 * force, rtol=1e-8)
    assert found.gear_forces_n["g"] == pytest.approx(2500.0)
    assert found.relative_residual < 1e-8
    alone = bearing_loads(geared())
    np.testing.assert_allclose(
        [alone[f"{n}.{e}"][1] for n in "ab" for e in ("left", "right")], -0.5 * LINE * LENGTH
    )
    with pytest.raises(AnalysisError, match="no gear 'h'"):
        static_response(geared(), gear_torques_n_m={"h": 1.0})


def test_forces_and_moments_on_places():
    """A moment about x amid two supports: loads M / L up and down along y."""
    system = between_bearings(shaft(), 1e9)
    mid = End(body="rotor", interface="mid")
    acting = [PointLoad(at=mid, force_n=(100.0, 0.0, 0.0), moment_n_m=(60.0, 0.0, 0.0))]
    found = static_response(system, (0.0, 0.0, 0.0), acting)
    loads = [found.bearing_loads[f"rotor.{end}"] for end in ("left", "right")]
    np.testing.assert_allclose([load[0] for load in loads], [50.0, 50.0], rtol=1e-9)
    np.testing.assert_allclose([load[1] for load in loads], [60.0 / LENGTH, -60.0 / LENGTH])
    with pytest.raises(AssemblyError, match="no component 'uz'"):
        static_response(system, points=[PointLoad(at=mid, force_n=(0.0, 0.0, 1.0))])
    with pytest.raises(AnalysisError, match="nothing holds the system"):
        static_response(one_rotor(shaft(), [ground("rotor", "left", 1e9)]))


def test_bearings_are_taken_at_the_speed():
    """A table: the rotor sinks by W / 2k(speed); cross terms move it aside."""
    law = table_law([0.0, 100.0], [[[2e6, 0.0], [0.0, 2e6]], [[1e6, 5e5], [-5e5, 1e6]]])
    held = [ground("rotor", end, 0.0, speed_law=law) for end in ("left", "right")]
    system = one_rotor(shaft(), held)
    half = 0.5 * LINE * LENGTH
    still, fast = (static_response(system, speed_rad_s=speed) for speed in (0.0, 100.0))
    np.testing.assert_allclose(
        still.bearing_motions["rotor.left"][:2], [0.0, -half / 2e6], rtol=1e-9, atol=1e-15
    )
    wanted = np.linalg.solve([[1e6, 5e5], [-5e5, 1e6]], [0.0, -half])
    np.testing.assert_allclose(fast.bearing_motions["rotor.left"][:2], wanted, rtol=1e-9)
    np.testing.assert_allclose(fast.bearing_loads["rotor.left"][:2], [0.0, -half], atol=1e-9)


def test_reduction_is_exact_at_interfaces_and_its_sag_has_an_estimate():
    """No mode at all: loads and interfaces stay, the sag between them is missed as estimated."""
    places = {"left": 0.0, "right": LENGTH}
    full = shaft(places)
    whole = one_rotor(full, [ground("rotor", end, 1e7) for end in places])
    exact = static_response(whole)
    for kept in (0, 2):
        few = one_rotor(truncated(full, kept), [ground("rotor", end, 1e7) for end in places])
        found = static_response(few)
        for name, load in exact.bearing_loads.items():
            np.testing.assert_allclose(found.bearing_loads[name], load, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(
                found.slopes_rad[name], exact.slopes_rad[name], rtol=1e-9, atol=1e-18
            )
        work = [
            result.load @ (system.transformation @ result.displacement)
            for result, system in ((found, few), (exact, whole))
        ]
        errors = static_errors(few, DOWN, found)
        assert errors.parts["mode_truncation"] == pytest.approx(work[1] / work[0] - 1.0, rel=1e-6)
        assert errors.total == errors.parts["mode_truncation"]
    assert static_errors(few, DOWN, found).bodies_without_estimate == ()
