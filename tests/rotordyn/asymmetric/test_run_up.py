"""Run-ups in the turning frame: other integrators, the frame at rest, exact motion, growth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from bladed_hub import BladedHub
from flat_rotors import CROSS, bladed, flat_mass, in_its_frame, on_shaft, two_blades
from rotors import connect, ground, polynomial_law, rigid_body, turning
from sometimes import often
from turning_frame import unbalance_run_up

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.asymmetric import (
    assemble_rotating,
    fitted_growth,
    floquet_multipliers,
    growth_end,
    run_up_rotating,
    unstable_ranges,
)
from solidwhirl.rotordyn.asymmetric.loads import gravity_force, own_unbalance
from solidwhirl.rotordyn.asymmetric.response import steady_response
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.record import MotionState
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile

HUB = rd.End(body="rotor", interface="hub")
LAW = polynomial_law((1.0, -2e-3, 1e-5), (0.5, 1e-3), (1.0, -1e-3), top=300.0)
UNBALANCES = (
    Unbalance(body="a", interface="m", moment_kg_m=2e-4, phase_rad=0.4),
    Unbalance(body="a", interface="r", moment_kg_m=1e-4, phase_rad=-1.0),
    Unbalance(body="b", interface="r", moment_kg_m=1e-4, phase_rad=2.0),
)


def steady(speed, duration):
    return SpeedProfile(times_s=[0.0, duration], speeds_rad_s=[speed, speed])


def far(found, known, name="translation_m"):
    """Largest difference of two records over the largest number of the second."""
    found, known = getattr(found, name), getattr(known, name)
    return float(np.abs(found - known).max() / np.abs(known).max())


def alone(element, *bearings, ratio=1.0):
    return assemble_rotating({"rotor": turning(element, ratio)}, bearings)


def test_two_bladed_hub_against_an_adaptive_integrator():
    """Of fourth order; the Euler force of the rising speed is a quarter of the answer."""
    hub = BladedHub(count=2, springs=np.diag([2.0, 5.0]))
    mass, coriolis, stiffness, stress, softening = hub.direct
    hold = (
        np.diag([40.0, 90.0]) + 0.4 * CROSS, np.diag([0.3, 0.2]),
        np.diag([30.0, 20.0]), np.diag([0.1, 0.2]),
    )  # fmt: skip
    names = ("stiffness", "damping", "tilt", "drag")
    held = connect(
        "mast", "rotor.hub", **dict(zip(names, hold, strict=True)), cross_coupling="as_given"
    )
    system = alone(bladed(hub), held)
    profile = SpeedProfile(times_s=[0.0, 2.0], speeds_rad_s=[1.0, 3.0])
    unbalance = Unbalance(body="rotor", interface="hub", moment_kg_m=10.0)
    given = (mass, coriolis, stiffness, stress - softening), np.eye(6, hub.size), hold, 10.0
    errors = []
    for step in (0.02, 0.01):
        run = run_up_rotating(system, profile, [unbalance], step_s=step, outputs=[HUB])
        found = run.translation_m[0, 0] + 1j * run.translation_m[0, 1]
        known, without = (
            unbalance_run_up(*given, (1.0, 1.0), run.time_s, euler=euler) for euler in (True, False)
        )
        errors.append(np.abs(found - known).max() / np.abs(known).max())
        assert np.abs(without - known).max() > 0.2 * np.abs(known).max()
    assert errors[1] < 2e-8
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.05)


def engines(ratio, law=None):
    """A counter-rotating engine with its first rotor in axes at rest, and in turning ones.

    Beside a first one that turns backward the coordinates of the second turn with it.
    """
    first = rigid_body("a", 12.0, 0.18, [0.5, 0.5, 0.7], {"l": 0.0, "m": 0.2, "r": 0.5})
    second = rigid_body("b", 6.0, 0.3, [0.2, 0.2, 0.25], {"m": 0.2, "r": 0.45})
    bearings = (
        connect("left", "a.l", None, (5e5, 3e5), 400.0, speed_law=law),
        connect("right", "a.r", None, 6e5, 400.0),
        connect("inter", "b.m", "a.m", 8e5, 400.0),
        connect("outer", "b.r", None, (4e5, 5e5), 400.0),
    )
    known = {} if ratio < 0 else {"spin_generator": None}
    other = turning(dataclasses.replace(second, **known), -1.4)
    system = rd.assemble({"a": turning(first, ratio), "b": other}, bearings)
    turned = assemble_rotating({"a": turning(in_its_frame(first), ratio), "b": other}, bearings)
    assert turned.turned == ({"a", "b"} if ratio < 0 else {"a"})
    how = {
        "outputs": [rd.End(body="a", interface="l"), rd.End(body="b", interface="r")],
        "bearings": ["left", "inter", "outer"],
    }
    return system, turned, how


RECORDED = ("translation_m", "rotation_rad", "velocity_m_per_s", "force_n")


@pytest.mark.parametrize("ratio", [1.0, -1.3])
def test_body_of_revolution_moves_as_in_axes_at_rest(ratio):
    """At constant speed the other integrator is exact but for the load; the weight only bends."""
    system, turned, how = engines(ratio, LAW)
    errors = []
    for step in (1e-4, 5e-5):
        given = {"step_s": step, "gravity_m_per_s2": (1.0, -9.81, 0.0), **how}
        found = run_up_rotating(turned, steady(200.0, 0.1), UNBALANCES, **given)
        known = run_up(system, steady(200.0, 0.1), UNBALANCES, **given)
        errors.append([far(found, known, name) for name in RECORDED])
    assert max(errors[1]) < 5e-9
    assert np.log2(np.divide(*errors)) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize("ratio", often([1.0, -1.3], -1.3))
def test_body_of_revolution_runs_up_as_in_axes_at_rest(ratio):
    """What is left falls with the square of the block, the error of the other integrator."""
    system, turned, how = engines(ratio)
    profile = SpeedProfile(times_s=[0.0, 0.1, 0.14], speeds_rad_s=[0.0, 60.0, 60.0])
    errors = []
    for step in (5e-5, 2.5e-5):
        found = run_up_rotating(turned, profile, UNBALANCES, step_s=step, **how)
        phase = 300.0 * step**2
        known = run_up(system, profile, UNBALANCES, step_s=step, phase_error_rad=phase, **how)
        assert known.longest_block == 1
        errors.append([far(found, known, name) for name in ("translation_m", "force_n")])
    assert max(errors[1]) < 1e-8
    assert np.log2(np.divide(*errors)) == pytest.approx(2.0, abs=0.05)


def test_energy_of_a_run_up_is_in_balance():
    """Unbalance, weight, a law, joints of what turns with what does not: of fourth order."""
    _, turned, _ = engines(1.0, LAW)
    profile = SpeedProfile(times_s=[0.0, 0.1, 0.14], speeds_rad_s=[0.0, 200.0, 150.0])
    errors = []
    for step in (2e-4, 1e-4):
        run = run_up_rotating(
            turned, profile, UNBALANCES, step_s=step, gravity_m_per_s2=(1.0, -9.81, 0.0)
        )
        energy = run.energy
        assert min(np.ptp(energy.load_work_j), np.ptp(energy.drive_work_j)) > 1e-3
        errors.append(np.abs(energy.error_j).max() / energy.stored_j.max())
    assert errors[1] < 1e-6
    assert np.log2(errors[0] / errors[1]) > 3.5


@pytest.mark.parametrize("ratio", [1.0, -2.0])
def test_own_unbalance_is_that_of_a_mass_off_the_axis(ratio):
    """Also while the speed rises, where it drags on the mass."""
    place, angle = 1e-3, 0.7
    center = place * np.array([np.cos(angle), np.sin(angle)])
    held = ground("rotor", "hub", 4e4, 9e4, 30.0, 20.0)
    off, even = (alone(flat_mass(5.0, center=c), held, ratio=ratio) for c in (center, (0.0, 0.0)))
    profile = SpeedProfile(times_s=[0.0, 0.2, 0.3], speeds_rad_s=[0.0, 150.0, 150.0])
    how = {"step_s": 1e-3, "outputs": [HUB]}
    # seen from a frame that turns backward the mass lies where it lies at the time 0
    same = Unbalance(body="rotor", interface="hub", moment_kg_m=5.0 * place, phase_rad=angle)
    known = run_up_rotating(even, profile, [same], **how)
    assert far(run_up_rotating(off, profile, [], **how), known) < 1e-12
    none = run_up_rotating(off, profile, [], own_unbalance=False, **how)
    assert not none.translation_m.any()


def test_weight_at_rest_and_in_free_fall():
    """A shaft that stands still stays where its weight puts it; a free body falls as all do."""
    flat, pull = flat_mass(5.0, (1e6, 2e6)), (0.0, -9.81, 0.0)
    how = {"gravity_m_per_s2": pull, "outputs": [HUB]}
    held = alone(flat, ground("rotor", "hub", 0.0, cx=10.0))
    run = run_up_rotating(held, steady(0.0, 0.1), [], step_s=1e-3, **how)
    assert run.translation_m[0, 1] == pytest.approx(-5.0 * 9.81 / 2e6, rel=1e-9)
    still = MotionState(displacement=np.zeros(2), velocity=np.zeros(2))
    profile = SpeedProfile(times_s=[0.0, 1.0], speeds_rad_s=[3.0, 9.0])  # beyond its size
    free = alone(flat_mass(5.0))
    run = run_up_rotating(free, profile, [], step_s=2e-3, initial=still, **how)
    assert run.translation_m[0, 1] == pytest.approx(-0.5 * 9.81 * run.time_s**2, abs=1e-8)
    assert run.velocity_m_per_s[0, 1] == pytest.approx(-9.81 * run.time_s, abs=1e-7)
    assert run.stopped is None


def test_weight_sets_off_no_vibration():
    """A two-bladed hub on unlike springs starts in the motion that comes again with every turn."""
    hub = bladed(BladedHub(count=2, springs=np.diag([2.0, 5.0])))
    held = connect("mast", "rotor.hub", None, (40.0, 90.0), (0.3, 0.2), (30.0, 20.0))
    system, turn = alone(hub, held), 2.0 * np.pi / 1.4
    how = {"step_s": turn / 1024, "outputs": [HUB], "gravity_m_per_s2": (0.0, -0.1, 0.0)}
    run = run_up_rotating(system, steady(1.4, 2.0 * turn), [], **how)
    motion = run.translation_m[0, :2]
    assert np.ptp(motion[1]) > 1e-3 * np.abs(motion[1]).max()
    assert np.abs(motion[:, 1024:] - motion[:, :1025]).max() < 1e-8 * np.abs(motion).max()


def test_stiff_modes_need_no_short_steps():
    """A spring a hundred million times as stiff, of 1600 radians in a step, is not heard of."""
    profile = SpeedProfile(times_s=[0.0, 1.0], speeds_rad_s=[0.0, 20.0])
    same = Unbalance(body="rotor", interface="hub", moment_kg_m=1e-3)
    runs = []
    for stiff in (1e8, 1e12):
        system = alone(flat_mass(5.0, (1e3, stiff)), ground("rotor", "hub", 500.0, 1e3, 30.0))
        runs.append(run_up_rotating(system, profile, [same], step_s=5e-3, outputs=[HUB]))
    assert far(*runs) < 1e-3
    assert all(run.stopped is None for run in runs)


@pytest.mark.parametrize(
    ("system", "speed"),
    [
        (on_shaft(5.0, (1e6, 2e6)), 550.0),
        pytest.param(on_shaft(1.0, (1.0, 1.21), 0.02), 1.05, marks=pytest.mark.verify),
        pytest.param(on_shaft(1.0, (1.0, 1.21), 0.02), 1.3, marks=pytest.mark.verify),
        pytest.param(two_blades((40.0, 40.0))[0], 9.0, marks=pytest.mark.verify),
        (two_blades((40.0, 90.0), (0.3, 0.2))[0], 2.0509677395642005),
        pytest.param(two_blades((40.0, 90.0), (0.3, 0.2))[0], 8.9, marks=pytest.mark.verify),
    ],
)
def test_growth_in_time_is_that_of_the_multipliers(system, speed):
    known = floquet_multipliers(system, speed).growth_1_s
    found = fitted_growth(system, speed)
    # the steps themselves are good to 1e-7
    assert abs(found.rate_1_s - known) < found.error_1_s + 1e-7 * abs(known)
    assert found.error_1_s < 1e-2 * abs(known)


def test_drive_of_a_train_of_bodies():
    """Two wheels on a shaft that twists, driven at the first."""
    motions = ("ux", "uy", "rz")
    first = rd.rigid_superelement("a", 3.0, [0.0] * 3, [0.2, 0.2, 0.3], {"m": 0.0}, motions)
    second = rd.rigid_superelement("b", 2.0, [0.0] * 3, [0.1, 0.1, 0.15], {"m": 0.0}, motions)
    shaft = connect("shaft", "a.m", "b.m", 4e3, 3.0, torsion_stiffness_n_m_per_rad=50.0)
    left = connect("left", "a.m", None, (9e4, 4e4), 30.0)
    bearings = (shaft, left, connect("right", "b.m", None, 3e4))
    profile = SpeedProfile(times_s=[0.0, 0.4], speeds_rad_s=[0.0, 60.0])
    unbalance = Unbalance(body="a", interface="m", moment_kg_m=3e-3)
    how = {
        "step_s": 1e-4,
        "outputs": [rd.End(body=body, interface="m") for body in "ab"],
        "drives": [rd.End(body="a", interface="m")],
    }
    bodies = {"a": turning(first), "b": turning(second)}
    known = run_up(rd.assemble(bodies, bearings), profile, [unbalance], phase_error_rad=1e-6, **how)
    twist = np.ptp(known.rotation_rad[:, 2], axis=0)
    assert twist.max() > 0.4
    turned = assemble_rotating({**bodies, "a": turning(in_its_frame(first))}, bearings)
    found = run_up_rotating(turned, profile, [unbalance], **how)
    for name in ("translation_m", "rotation_rad"):
        assert far(found, known, name) < 1e-6


def test_drive_of_a_body_with_its_mass_off_the_axis():
    """A torque where the inertia is or at the only seat: the same, and neither turns the body."""
    motions, center = ("ux", "uy", "rz"), [2e-7, 1e-7, 0.0]
    heavy = rd.rigid_superelement("rotor", 3.0, center, [0.2, 0.2, 0.3], {"hub": 0.0}, motions)
    system = alone(in_its_frame(heavy), ground("rotor", "hub", 9e4, 4e4, 30.0))
    profile = SpeedProfile(times_s=[0.0, 0.4], speeds_rad_s=[0.0, 60.0])
    how = {"step_s": 1e-3, "outputs": [HUB]}
    known = run_up_rotating(system, profile, [], **how)
    found = run_up_rotating(system, profile, [], drives=[HUB], **how)
    assert far(found, known) < 1e-12
    none = run_up_rotating(system, profile, [], drives=[HUB], own_unbalance=False, **how)
    assert np.abs(none.translation_m).max() < 1e-12 * np.abs(known.translation_m).max()


def test_growth_ends_where_the_unstable_range_does():
    """Later by what the speed rises while the motion turns from growth to decay; or it diverges."""
    damping = 2.0 * 0.02 * np.sqrt(0.5 * 2.21)
    system = alone(flat_mass(1.0, (1.0, 1.21)), ground("rotor", "hub", 0.0, cx=damping))
    (known,) = unstable_ranges(system.periodic, 0.1, 3.0)
    disturbed = MotionState(displacement=np.array([1e-6, 2e-6]), velocity=np.zeros(2))

    def run(duration):
        profile = SpeedProfile(times_s=[0.0, duration], speeds_rad_s=[0.95, 1.2])
        how = {"step_s": 0.1, "outputs": [HUB], "initial": disturbed}
        return run_up_rotating(system, profile, [], **how)

    fast, slow = (
        growth_end(run(duration)).speed_rad_s - known.high_rad_s for duration in (1e3, 2e3)
    )
    assert 0.0 < slow < 0.6 * fast < 0.003
    assert abs(2.0 * slow - fast) < 5e-4
    stopped = run(4e3)
    assert known.low_rad_s < stopped.stopped.speed_rad_s < known.high_rad_s
    assert stopped.time_s[-1] == pytest.approx(stopped.stopped.time_s)
    assert growth_end(stopped) is None


def test_what_has_no_meaning_is_refused():
    hub = bladed(BladedHub(count=2, springs=np.diag([2.0, 5.0])))
    system = alone(hub, connect("fixed", "rotor.hub", rigid=("ux", "uy")))
    profile = steady(10.0, 0.1)
    with pytest.raises(AnalysisError, match="'fixed' is rigid"):
        run_up_rotating(system, profile, [], step_s=1e-3, bearings=["fixed"])
    system = alone(flat_mass(5.0, (1e6, 2e6)), ground("rotor", "hub", 1e5))
    with pytest.raises(AnalysisError, match="turns by"):
        run_up_rotating(system, steady(10.0, 1.0), [], step_s=0.2)
    short = MotionState(displacement=np.zeros(3), velocity=np.zeros(2))
    with pytest.raises(AnalysisError, match="2 finite"):
        run_up_rotating(system, profile, [], step_s=1e-3, initial=short)
    with pytest.raises(AnalysisError, match="no outputs"):
        growth_end(run_up_rotating(system, profile, [], step_s=1e-3))
    with pytest.raises(AnalysisError, match="8 turns"):
        fitted_growth(system.periodic, 10.0, turns=7)


def test_motion_settles_to_the_steady_one():
    """A mass off the axis of a flat shaft, under its weight: the orbit that harmonics give."""
    system = alone(
        flat_mass(5.0, (4e4, 9e4), center=(1e-3, 2e-3)),
        ground("rotor", "hub", 2e4, 5e4, 150.0, 250.0),
    )
    pull, speed, turns = (0.0, -9.81, 0.0), 60.0, 40
    known = steady_response(
        system,
        [speed],
        constant=gravity_force(system, pull),
        centrifugal=own_unbalance(system),
    )
    turn = 2.0 * np.pi / speed
    how = {"step_s": turn / 400, "outputs": [HUB], "gravity_m_per_s2": pull}
    run = run_up_rotating(system, steady(speed, turns * turn), [], **how)
    last = run.angle_rad >= run.angle_rad[-1] - 2.0 * np.pi
    waves = np.exp(1j * np.multiply.outer(known.multiples, run.angle_rad[last]))
    orbit = np.einsum("hc,ht->ct", known.translation_m[0, :, 0], waves).real
    found = run.translation_m[0, :2, last].T
    assert np.abs(found - orbit).max() < 1e-7 * np.abs(orbit).max()
