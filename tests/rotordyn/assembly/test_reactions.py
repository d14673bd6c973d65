"""Bearing forces against statics, equilibrium, and stiff springs in place of exact joints."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    connect,
    ground,
    hub,
    one_rotor,
    pinned,
    plane_spring,
    polynomial_law,
    three_disk_element,
    turning,
    twin_bodies,
    twin_rotors,
    with_axial_and_torsion,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.reactions import joint_forces
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response, independent_loads
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response

GRAVITY = 9.81


def engine(stiffness=None, extra=()):
    """Counter-rotating shafts with internal damping; joints exact (None) or of a given stiffness.

    A and B hold the inner shaft, D the outer one, C joins both.
    """
    damped = rd.InternalDamping(stiffness_coefficient_s=1e-6)
    own = {"rigid": ("ux", "uy")} if stiffness is None else {"stiffness": stiffness}
    ends = {"inner.B": ("inner.B",), "outer.D": ("outer.D",), "C": ("inner.C", "outer.C")}
    stiff = [connect(name, *places, **own) for name, places in ends.items()]
    soft = ground("inner", "A", 4e7, 3e7, 800.0)
    rotors = twin_rotors(-1.4, internal_damping=damped)
    return rd.assemble(rotors, (soft, *stiff, *extra), "inner")


def _weights(system, direction):
    """Loads of gravity on all bodies along x (0) or y (1)."""
    return {
        name: GRAVITY * rotor.element.mass @ rotor.element.rigid_body_modes[:, direction]
        for name, rotor in system.system.rotors.items()
    }


def _static(system, loads):
    force = independent_loads(system, loads)
    return harmonic_response(system, 0.0, 0.0, force[None, :, None]).displacement[0, :, 0].real


@pytest.mark.parametrize("rigid", [True, False])
@pytest.mark.parametrize("direction", [0, 1])
def test_weight_of_a_shaft_splits_by_the_lever_rule(rigid, direction):
    element = three_disk_element()
    held = pinned if rigid else lambda *end: ground(*end, 3e6, 8e6)
    system = one_rotor(element, [held("rotor", end) for end in ("left", "right")])
    loads = _weights(system, direction)
    q, still = _static(system, loads), np.zeros(system.size)
    forces = joint_forces(system, 0.0, q, still, still, loads).bearings
    weight = element.mass_kg * GRAVITY
    share = element.center_of_gravity_m[2] / 1.3
    assert forces["rotor.right"][direction] == pytest.approx(share * weight, rel=1e-9)
    assert forces["rotor.left"][direction] == pytest.approx((1 - share) * weight, rel=1e-9)
    others = np.delete(np.array([*forces.values()]), direction, axis=1)
    assert np.abs(others).max() < 1e-9 * weight


def test_exact_joints_are_the_limit_of_stiff_ones():
    speeds = np.array([150.0, 600.0, 1300.0, 2500.0])
    parts = [
        Unbalance(body="inner", interface="C", moment_kg_m=1e-5),
        Unbalance(body="outer", interface="D", moment_kg_m=2e-5, phase_rad=0.7),
    ]
    exact = unbalance_response(engine(), parts, speeds)
    misses = []
    for stiffness in (1e12, 1e14):
        stiff = unbalance_response(engine(stiffness), parts, speeds)
        for one, other in zip(exact.exciters, stiff.exciters, strict=True):
            scale = max(np.abs(force).max() for force in one.bearing_forces.values())
            difference = [
                np.abs(force - other.bearing_forces[name]).max() / scale
                for name, force in one.bearing_forces.items()
            ]
            misses.append(max(difference))
    assert max(misses[:2]) < 1e-3
    # What a spring gives way falls with its stiffness; both exciters, all bearings.
    np.testing.assert_allclose(np.array(misses[:2]) / misses[2:], 100.0, rtol=0.02)


@pytest.mark.parametrize("stiffness", [None, 2e8])
def test_forces_on_the_ground_and_inertia_balance_the_loads(stiffness):
    system = engine(stiffness)
    # Loads on every coordinate of both bodies, the eliminated ones too.
    random = np.random.default_rng(5)
    speeds, omega = np.array([0.0, 400.0, 1900.0]), np.array([300.0, 700.0, 1900.0])
    loads = {
        name: random.standard_normal((3, rotor.element.size, 2)) @ np.array([1.0, 1j])
        for name, rotor in system.system.rotors.items()
    }
    force = independent_loads(system, loads)[:, :, None]
    q = harmonic_response(system, speeds, omega, force).displacement[:, :, 0]
    v, a = 1j * omega[:, None] * q, -(omega[:, None] ** 2) * q
    found = joint_forces(system, speeds, q, v, a, loads).bearings
    total = sum(found[name][:, :2] for name in found if name != "C")
    applied, inertia = np.zeros((3, 2), complex), np.zeros((3, 2), complex)
    moment = np.zeros((3, 2), complex)
    for name, rotor in system.system.rotors.items():
        element = rotor.element
        motion = system.transformation[system.body_slices[name]]
        carried = element.rigid_body_modes[:, :2]
        applied += loads[name] @ carried
        inertia += a @ motion.T @ element.mass @ carried
        # Tilts about the origin: angular momentum has the gyroscopic part.
        tilt = element.rigid_body_modes[:, 3:5]
        moment += loads[name] @ tilt - a @ motion.T @ element.mass @ tilt
        spin = (rotor.speed_ratio * speeds)[:, None]
        moment -= spin * (v @ motion.T @ element.gyroscopic.T @ tilt)
    # Rounding: the stiffness forces that cancel are about 1e4 times the loads.
    scale = np.abs(inertia).max()
    np.testing.assert_allclose(total + inertia, applied, rtol=0, atol=1e-9 * scale)
    places = {"inner.A": 0.0, "inner.B": 0.4, "outer.D": 0.4}
    # Moment about the origin of a force at z: (−z Fy, z Fx).
    held = sum(z * found[name][:, [1, 0]] * [-1, 1] for name, z in places.items())
    np.testing.assert_allclose(held, moment, rtol=0, atol=1e-9 * np.abs(moment).max())


def test_joint_of_two_disks_carries_gyroscopic_and_run_up_moments():
    # Disk 2 (Ip = 0.1) is joined to disk 1 in all motions; the equation of disk 2 alone gives what
    # the joint carries: M q'' + Ω2 G q' + Ω2² Kgeo q + ½ Ω2' G q, the last while speed varies.
    geometric = np.diag([3.0, 5.0, 0.2, 0.4])
    second = hub(mass_kg=4.0, present=np.zeros(6, dtype=bool))
    rotors = {
        "one": turning(hub(stiffness=plane_spring(1e6, 2e4, 3e4))),
        "two": turning(dataclasses.replace(second, stress_stiffening=geometric), 2.0),
    }
    joint = connect("joint", "one.hub", "two.hub", rigid=("ux", "uy", "rx", "ry"))
    system = rd.assemble(rotors, (joint,))
    random = np.random.default_rng(2)
    q, v, a = random.standard_normal((3, 5, 4))
    speed, rate = np.linspace(10.0, 50.0, 5), np.linspace(3.0, 4.0, 5)
    # The motion is any; the loads on disk 1 are what it needs, and do not enter the other side.
    element = rotors["one"].element
    moved = [part @ system.transformation[:4].T for part in (q, v, a)]
    two = rotors["two"].element
    other = [part @ system.transformation[4:].T for part in (q, v, a)]
    spin, rise = 2.0 * speed[:, None], 2.0 * rate[:, None]
    through = other[2] @ two.mass + spin * other[1] @ two.gyroscopic.T
    through = through + 0.5 * rise * other[0] @ two.gyroscopic.T + spin**2 * other[0] @ geometric
    needed = moved[2] @ element.mass + speed[:, None] * moved[1] @ element.gyroscopic.T
    needed = needed + 0.5 * rate[:, None] * moved[0] @ element.gyroscopic.T
    needed = needed + moved[0] @ element.stiffness + through
    found = joint_forces(system, speed, q, v, a, {"one": needed}, rate).bearings["joint"]
    np.testing.assert_allclose(found[:, [0, 1, 3, 4]], through, rtol=1e-9, atol=1e-8)
    assert not found[:, [2, 5]].any()


def test_bearing_with_a_speed_law():
    law = polynomial_law((1.0, 1e-3), (1.0,), (1.0,), (1.0, 0.0, 1e-6), top=1000.0)
    drag = {"tilt_damping_n_m_s_per_rad": np.diag([1.0, 2.0])}
    support = ground("rotor", "hub", 1e6, 2e6, 10.0, 30.0, speed_law=law, tilt=5e3, **drag)
    system = one_rotor(hub(), [support], ratio=-2.0)
    random = np.random.default_rng(4)
    speed = np.array([0.0, 100.0, 250.0, 100.0])
    q, v, a = random.standard_normal((3, 4, 4))
    found = joint_forces(system, speed, q, v, a).bearings["rotor.hub"]
    rising = 1.0 + 1e-3 * 2.0 * speed
    damping = 1.0 + 1e-6 * (2.0 * speed) ** 2
    place, rate = (part @ system.transformation.T for part in (q, v))
    np.testing.assert_allclose(found[:, 0], 1e6 * rising * place[:, 0] + 10.0 * rate[:, 0])
    np.testing.assert_allclose(found[:, 1], 2e6 * place[:, 1] + 30.0 * damping * rate[:, 1])
    np.testing.assert_allclose(found[:, 3], 5e3 * place[:, 2] + 1.0 * rate[:, 2])
    np.testing.assert_allclose(found[:, 4], 5e3 * place[:, 3] + 2.0 * rate[:, 3])


@pytest.mark.parametrize("mesh", [None, 1e15])
def test_gear_carries_the_torque_and_its_mates_carry_the_rest(mesh):
    # A torque on the far end of shaft 1, geared 1 : −3 to shaft 2, whose far end is held.
    inner, _ = twin_bodies()
    shaft = with_axial_and_torsion(inner, 0.4, 0.02, "A", "B")
    rotors = {"one": turning(shaft), "two": turning(dataclasses.replace(shaft, name="two"), -3.0)}
    more = {"one.A": ("uz",), "one.B": (), "two.A": ("uz", "rz"), "two.B": ()}
    bearings = [connect(at, at, rigid=("ux", "uy", *motions)) for at, motions in more.items()]
    first, second = (rd.End(body=body, interface="B") for body in rotors)
    gear = rd.Gear(
        name="gear", first=first, second=second, ratio=-3.0, mesh_stiffness_n_per_m=mesh,
        base_radius_first_m=0.06, line_of_action_rad=0.3,
    )  # fmt: skip
    system = rd.assemble(rotors, tuple(bearings), "one", (gear,))
    load = np.zeros(shaft.size)
    load[shaft.interface_index("A", "rz")] = 120.0
    q = _static(system, {"one": load})
    still = np.zeros(system.size)
    found = joint_forces(system, 0.0, q, still, still, {"one": load})
    # Positive along the tooth motion: n·(u1 − u2) + r1 rz1 + (r1/3) rz2; torque over base radius.
    tooth = 120.0 / 0.06
    # A mesh of 1e15 N/m keeps 1e-6 of its force to rounding in its compression of 1e-12 m.
    assert found.gears["gear"] == pytest.approx(tooth, rel=1e-6)
    assert found.bearings["two.A"][5] == pytest.approx(-120.0 / 3.0, rel=1e-6)
    push = -tooth * np.array([np.cos(0.3), np.sin(0.3)])
    for body, sign in (("one", 1.0), ("two", -1.0)):
        total = found.bearings[f"{body}.A"] + found.bearings[f"{body}.B"]
        np.testing.assert_allclose(total[:2], sign * push, rtol=1e-6)


def test_joints_that_hold_a_motion_twice_are_refused():
    system = engine(extra=(connect("again", "inner.B", rigid=("ux",)),))
    q = np.zeros(system.size)
    message = r"joints \['again', 'inner.B'\] hold the same motion"
    with pytest.raises(rd.AnalysisError, match=message):
        joint_forces(system, 0.0, q, q, q)


def test_wrong_arguments_are_refused():
    system = engine()
    q = np.zeros((3, system.size))
    loads = {"inner": np.zeros(4)}
    for arguments, message in [
        ((0.0, q, q[:2], q), "velocity has shape"),
        ((0.0, q[:, 1:], q[:, 1:], q[:, 1:]), "displacement has shape"),
        (([1.0, 2.0], q, q, q), r"speed_rad_s has shape \(2, 1\)"),
        ((1.0, q, q, q, None, np.inf), "speed_rate_rad_s2 has numbers that are not finite"),
        ((1.0, q, q, q, loads), r"body_loads\['inner'\] has shape \(4,\)"),
    ]:
        with pytest.raises(rd.AnalysisError, match=message):
            joint_forces(system, *arguments)
    with pytest.raises(rd.AssemblyError, match="no body 'fan'"):
        joint_forces(system, 1.0, q, q, q, {"fan": np.zeros(4)})
