"""Records of a run-up: continuation, sampling, torsion of geared trains, notes and refusals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    between_bearings,
    connect,
    ground,
    hub,
    one_rotor,
    rigid_body,
    steel_shaft,
    three_disk_element,
    turning,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.record import MotionState
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold


def spools():
    """Two rigid rotors on springs, one turning against the other."""
    rotors, bearings = {}, []
    for name, ratio in (("a", 1.0), ("b", -1.4)):
        element = rigid_body(name, 8.0, 0.2, [0.4, 0.4, 0.5], {"l": 0.0, "r": 0.5})
        rotors[name] = turning(element, ratio)
        own = (None, (4e5, 3e5), 100.0)
        bearings += [connect(f"{name} {at}", f"{name}.{at}", *own) for at in "lr"]
    return rd.assemble(rotors, tuple(bearings))


UNBALANCES = (
    Unbalance(body="a", interface="r", moment_kg_m=2e-4, phase_rad=0.4),
    Unbalance(body="b", interface="l", moment_kg_m=1e-4, phase_rad=2.0),
)
OUTPUTS = (rd.End(body="a", interface="l"), rd.End(body="b", interface="r"))
PROFILE = SpeedProfile(times_s=[0.0, 0.1, 0.14], speeds_rad_s=[0.0, 200.0, 200.0])


def test_a_run_may_be_continued():
    system = spools()
    options = {"step_s": 5e-5, "outputs": OUTPUTS, "bearings": ["a l"], "phase_error_rad": 1e-5}
    whole = run_up(system, PROFILE, UNBALANCES, **options)
    first = run_up(system, ramp_and_hold(200.0, 0.1), UNBALANCES, **options)
    angle = float(PROFILE.angle_rad(0.1))
    ratios = {"a": 1.0, "b": -1.4}
    turned = [
        dataclasses.replace(u, phase_rad=u.phase_rad + ratios[u.body] * angle) for u in UNBALANCES
    ]
    rest = SpeedProfile(times_s=[0.0, 0.04], speeds_rad_s=[200.0, 200.0])
    second = run_up(system, rest, turned, initial=first.final, **options)
    for name in ("translation_m", "force_n"):
        expected, found = getattr(whole, name)[..., -800:], getattr(second, name)[..., -800:]
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_records_are_samples_of_all_steps():
    system = spools()
    options = {"step_s": 1e-4, "outputs": OUTPUTS, "bearings": ["a l", "b r"]}
    every = run_up(system, PROFILE, UNBALANCES, **options)
    some = run_up(system, PROFILE, UNBALANCES, record_every=7, **options)
    assert every.time_s.size == 1401 and some.time_s.size == 201
    assert some.sample_rate_hz == pytest.approx(1e4 / 7)
    for name in ("translation_m", "angular_velocity_rad_per_s", "force_n", "moment_n_m"):
        np.testing.assert_array_equal(getattr(some, name), getattr(every, name)[..., ::7])
    np.testing.assert_array_equal(some.energy.stored_j, every.energy.stored_j[::7])


def test_speeds_beyond_the_basis_are_noted():
    element = dataclasses.replace(three_disk_element(), maximum_speed_rad_s=100.0)
    system = between_bearings(element, 7e7, ratio=2.0)
    run = run_up(system, ramp_and_hold(60.0, 1e-2), [], step_s=1e-3, phase_error_rad=1.0)
    assert run.notes == (
        "above 50 rad/s a body runs faster than its basis was made for; the run goes to 60 rad/s",
    )


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"step_s": 0.0}, "step_s is 0.0; it must be positive"),
        ({"step_s": 3e-4}, r"breakpoint of the profile at 0\.\d+ s is not a whole number of steps"),
        ({"step_s": 2e-2}, "turns by 5.6 rad; take a step of at most 0.00357 s"),
        ({"step_s": 2e-3, "phase_error_rad": 1e-9}, "allows to freeze"),
        ({"phase_error_rad": 0.0}, "phase_error_rad is 0.0"),
        ({"record_every": 0}, "record_every is 0"),
        ({"bearings": ["nose"]}, r"there are no bearings \['nose'\]; there are \['a l'"),
        ({"gravity_m_per_s2": (0.0, 9.81)}, "three finite numbers"),
        ({"gravity_m_per_s2": (0.0, 0.0, 9.81)}, "no body can move along z"),
        (
            {"initial": MotionState(displacement=np.zeros(3), velocity=np.zeros(3))},
            r"displacement of the initial state has shape \(3,\)",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(changes, text):
    options = {"step_s": 1e-4, **changes}
    with pytest.raises(rd.AnalysisError, match=text):
        run_up(spools(), PROFILE, UNBALANCES, **options)


def test_places_that_do_not_exist_are_refused():
    system = spools()
    with pytest.raises(rd.AssemblyError, match="no body 'c'"):
        run_up(system, PROFILE, [], step_s=1e-4, outputs=[rd.End(body="c", interface="l")])
    with pytest.raises(rd.AssemblyError, match="no interface 'nose'"):
        missing = Unbalance(body="a", interface="nose", moment_kg_m=1.0)
        run_up(system, PROFILE, [missing], step_s=1e-4)
    with pytest.raises(rd.AssemblyError, match="no component 'rz'"):
        run_up(system, PROFILE, [], step_s=1e-4, drives=[OUTPUTS[0]])


def geared(damping=1.0, joined=True):
    """A shaft with an inertia at its far end that drives a fan through a gear at a third."""
    parts = ("ux", "uy", "rx", "ry", "rz")

    def train(name, length, inertia):
        disk = [(length, 5.0, inertia, 0.5 * inertia)]
        # next to no mass of its own
        light = {"material": (2e11, 0.3, 1e-3), "components": parts}
        return steel_shaft(name, [0.0, length], 0.01, {"a": 0.0, "b": length}, disk, **light)

    rotors = {
        "shaft": turning(train("shaft", 0.5, 0.1)),
        "fan": turning(train("fan", 0.2, 0.6), 0.3),
    }
    # damping lets the ringing of the torsion die out; it acts on what departs from Ω(t) only
    loss = {"torsion_damping_n_m_s_per_rad": damping}
    places = [f"{body}.{at}" for body in rotors for at in "ab"]
    bearings = tuple(connect(at, at, stiffness=1e7, tilt=1e5, **loss) for at in places)
    first, second = rd.End(body="shaft", interface="b"), rd.End(body="fan", interface="a")
    gear = rd.Gear(name="gear", first=first, second=second, ratio=0.3)
    return rd.assemble(rotors, bearings, "shaft", (gear,) if joined else ())


def test_torque_runs_through_a_geared_train():
    system = geared()
    ends = [rd.End(body=body, interface=at) for body in ("shaft", "fan") for at in "ab"]
    run = run_up(
        system, ramp_and_hold(100.0, 4.0), [], step_s=1e-3, outputs=ends, drives=[ends[0]],
        phase_error_rad=1.0,
    )  # fmt: skip
    spring = 2e11 / 2.6 * 0.5 * np.pi * 0.01**4
    angle = run.rotation_rad[:, 2, -1]
    # d'Alembert at Ω' = 25 rad/s²: the shaft carries its own inertia and the fan's by ratio²
    expected = -25.0 * (0.1 + 0.3**2 * 0.6) * 0.5 / spring
    assert angle[1] - angle[0] == pytest.approx(expected, rel=1e-3)
    assert angle[3] - angle[2] == pytest.approx(-25.0 * 0.3 * 0.6 * 0.2 / spring, rel=1e-3)
    assert angle[2] == pytest.approx(0.3 * angle[1], rel=1e-9)


@pytest.mark.parametrize("step_s", [1e-3, 1e-2])
def test_work_of_the_torque_and_speed_of_the_train_are_exact_for_any_step(step_s):
    """The ringing of the shaft at 20 Hz, and of its ends at 1 MHz, needs no resolution."""
    ends = [rd.End(body=body, interface="b") for body in ("shaft", "fan")]
    run = run_up(
        geared(damping=0.0), ramp_and_hold(100.0, 0.5), [], step_s=step_s, outputs=ends,
        drives=[rd.End(body="shaft", interface="a")], phase_error_rad=1.0,
    )  # fmt: skip
    shaft, fan = run.rotation_rad[:, 2]
    assert np.abs(shaft).max() > 1e-4
    # no angular momentum beyond that of Ω(t), counted at the reference shaft; the ends at the
    # gear have next to no inertia, which leaves 1e-9 of the torque in balance to rounding
    np.testing.assert_allclose(0.1 * shaft + 0.3 * 0.6 * fan, 0.0, atol=1e-5 * np.abs(fan).max())
    assert run.energy.stored_j.max() > 1e-3
    assert np.abs(run.energy.error_j).max() < 1e-9 * run.energy.stored_j.max()


def test_each_free_train_needs_one_drive():
    options = {"step_s": 1e-3, "phase_error_rad": 1.0}
    profile = ramp_and_hold(100.0, 0.1)
    first, second = rd.End(body="shaft", interface="a"), rd.End(body="fan", interface="b")
    apart = geared(joined=False)
    for system, drives, trains in ((geared(), [first, second], 1), (apart, [first], 2)):
        with pytest.raises(rd.AnalysisError, match=rf"do not balance the {trains} train\(s\)"):
            run_up(system, profile, [], drives=drives, **options)
    run = run_up(apart, profile, [], drives=[first, second], outputs=[first], **options)
    assert np.abs(run.rotation_rad[0, 2]).max() > 0


def test_nothing_to_stand_on_is_refused():
    system = one_rotor(hub())
    with pytest.raises(rd.AnalysisError, match="nothing holds the system against its load"):
        run_up(system, PROFILE, [], step_s=1e-3, gravity_m_per_s2=(0.0, -9.81, 0.0))


def test_a_support_that_pushes_outwards_drives_the_motion_away():
    system = one_rotor(hub(mass_kg=10.0), [ground("rotor", "hub", 4e4, -1e4, tilt=1e5)])
    at = rd.End(body="rotor", interface="hub")
    place = np.zeros(system.size)
    place[:2] = 1e-3
    profile = SpeedProfile(times_s=[0.0, 0.2], speeds_rad_s=[50.0, 50.0])
    start = MotionState(displacement=place, velocity=np.zeros(system.size))
    run = run_up(system, profile, [], step_s=1e-3, outputs=[at], initial=start)
    x, y, _ = run.translation_m[0]
    np.testing.assert_allclose(x, 1e-3 * np.cos(np.sqrt(4e3) * run.time_s), atol=1e-12)
    np.testing.assert_allclose(y, 1e-3 * np.cosh(np.sqrt(1e3) * run.time_s), rtol=1e-10)


def test_bearings_beyond_their_law_are_noted():
    held = ground("rotor", "hub", 1e6, None, 1e3, speed_law=rd.LEE_ANISOTROPIC, tilt=1e6)
    system = one_rotor(hub(), [held])
    run = run_up(system, ramp_and_hold(1200.0, 1.0), [], step_s=1e-3, phase_error_rad=1.0)
    (note,) = run.notes
    # 1106.27 to 1200 rad/s
    assert note.startswith("10564.1 to 11459.2 rpm: negative damping by law 'lee_anisotropic'")
