"""Responses with nonlinear forces: closed forms, exact frequencies, and integration in time."""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest
from rotors import ground, hub, one_rotor, steel_shaft
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipk

from solidwhirl.rotordyn import AnalysisError, End
from solidwhirl.rotordyn.nonlinear import starts
from solidwhirl.rotordyn.nonlinear.continuation import Course, through
from solidwhirl.rotordyn.nonlinear.forced_system import NonlinearJoint, forced_system
from solidwhirl.rotordyn.nonlinear.forces import Clearance, CubicSpring, SqueezeFilm
from solidwhirl.rotordyn.nonlinear.harmonic_balance import (
    at_speed,
    balance,
    corrected,
    series_at,
    with_harmonics,
)
from solidwhirl.rotordyn.nonlinear.response import nonlinear_response
from solidwhirl.rotordyn.nonlinear.stability import SmallMotions, multipliers, small_motions
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response

MASS, STIFFNESS, DAMPING, OFFSET = 10.0, 1e7, 600.0, 5e-7
HUB = End(body="rotor", interface="hub")
FILM = {"radius_m": 0.05, "length_m": 0.02, "clearance_m": 1e-4, "viscosity_pa_s": 0.01}
GAP = {"gap_m": 3e-6, "stiffness_n_per_m": 2e7}


def jeffcott(mass=MASS, stiffness=STIFFNESS, damping=DAMPING):
    """A disk on an isotropic support; its tilt is apart."""
    tilt = 1e4 * np.eye(2)
    held = ground("rotor", "hub", stiffness, cx=damping, tilt_stiffness_n_m_per_rad=tilt)
    return one_rotor(hub(mass), [held])


def unbalance(moment=MASS * OFFSET, phase=0.0):
    return [Unbalance(body="rotor", interface="hub", moment_kg_m=moment, phase_rad=phase)]


def forced(force, speed=1000.0, gravity=(0.0, 0.0, 0.0), moment=MASS * OFFSET, system=None):
    joints = [NonlinearJoint(first=HUB, force=force)]
    return forced_system(system or jeffcott(), joints, unbalance(moment), speed, gravity)


def first_point(problem, omega, harmonics):
    """The first motion under the whole loads, as these are raised from none."""
    motion, _ = starts.raised(problem, omega)[0][0]
    return at_speed(problem, with_harmonics(motion, harmonics), omega)


@cache
def response(force, moment=MASS * OFFSET, top=1800.0):
    joints = [NonlinearJoint(first=HUB, force=force)]
    return nonlinear_response(jeffcott(), joints, unbalance(moment), (600.0, top), [HUB])


# -- circular orbits: one harmonic is exact ------------------------------------------------------


def cubic_dynamic_stiffness(r, omega):
    return 1e17 * r**2


def gap_dynamic_stiffness(r, omega):
    depth = np.maximum(r - GAP["gap_m"], 0.0)
    return GAP["stiffness_n_per_m"] * depth / r * (1.0 + 0.05j)


def film_dynamic_stiffness(r, omega):
    e = r / FILM["clearance_m"]
    b0 = FILM["viscosity_pa_s"] * FILM["radius_m"] * (FILM["length_m"] / FILM["clearance_m"]) ** 3
    damping = np.pi * b0 / (2 * (1 - e**2) ** 1.5)
    return 1e6 + 2 * e * omega * b0 / (1 - e**2) ** 2 + 1j * omega * damping


def thin_film_dynamic_stiffness(r, omega):
    return (film_dynamic_stiffness(r, omega) - 1e6) / 20.0


@pytest.mark.parametrize(
    ("force", "seen", "moment", "top", "turning"),
    [
        (CubicSpring(radial_n_per_m3=1e17), cubic_dynamic_stiffness, MASS * OFFSET, 2500.0, 2),
        (Clearance(friction=0.05, **GAP), gap_dynamic_stiffness, MASS * OFFSET, 1800.0, 2),
        (SqueezeFilm(centring_n_per_m=1e6, **FILM), film_dynamic_stiffness, MASS * 3e-5, 1800.0, 0),
    ],
)
def test_circular_orbits(force, seen, moment, top, turning):
    found = response(force, moment, top)
    assert found.harmonics == 1 and found.truncation < 1e-9
    (branch,) = found.branches
    assert not branch.open_ends and branch.is_turning.sum() == turning
    omega, r = branch.speeds_rad_s, branch.largest_radius_m[:, 0]
    np.testing.assert_allclose(branch.major_m()[:, 0], r, rtol=1e-5)
    whole = STIFFNESS - MASS * omega**2 + 1j * DAMPING * omega + seen(r, omega)
    np.testing.assert_allclose(np.abs(whole) * r / (moment * omega**2), 1.0, rtol=1e-7)


def test_turning_points_and_jumps_of_a_radial_spring():
    """The speed squared is a quadratic in the radius; the branches turn where it has extremes."""
    alpha = 1e17

    def speed(r, side):
        stiffness = STIFFNESS + alpha * r**2
        a = MASS**2 * (r**2 - OFFSET**2)
        b = (DAMPING**2 - 2 * MASS * stiffness) * r**2
        root = np.sqrt(b**2 - 4 * a * stiffness**2 * r**2)
        return np.sqrt((-b + side * root) / (2 * a))

    down = minimize_scalar(lambda r: speed(r, 1.0), bounds=(1.2e-6, 1e-5), method="bounded",
                           options={"xatol": 1e-14}).fun  # fmt: skip
    jumps = response(CubicSpring(radial_n_per_m3=alpha), MASS * OFFSET, 2500.0).jumps
    assert [j.direction for j in jumps] == ["up", "down"]
    assert jumps[1].speed_rad_s == pytest.approx(down, rel=1e-9)
    # behind the jump the motion is that of the other branch at the same speed
    for jump in jumps:
        assert (jump.after_m[0] < jump.before_m[0]) == (jump.direction == "up")
        ends = [speed(jump.after_m[0], side) for side in (1.0, -1.0)]
        assert min(np.abs(np.array(ends) / jump.speed_rad_s - 1.0)) < 1e-9
        assert (
            min(abs(speed(jump.before_m[0], s) / jump.speed_rad_s - 1.0) for s in (1.0, -1.0))
            < 1e-9
        )


def test_stability_of_a_rubbing_orbit():
    """In axes that turn with the orbit small motions have constant coefficients."""
    friction = 0.2
    force = Clearance(friction=friction, **GAP)
    problem = forced(force)
    r, k, omega = None, GAP["stiffness_n_per_m"], 950.0
    point = first_point(problem, omega, 1)
    r = float(np.hypot(*point.motion_m[1]))
    assert r > GAP["gap_m"]
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    share = 1.0 - GAP["gap_m"] / r
    at = np.diag([1.0, share])  # radial, tangential
    own = (np.eye(2) + friction * turn) @ (k * at)
    stiffness = (STIFFNESS - MASS * omega**2) * np.eye(2) + own + DAMPING * omega * turn
    velocity = DAMPING * np.eye(2) + 2.0 * MASS * omega * turn
    state = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness / MASS, -velocity / MASS]])
    wanted = np.linalg.eigvals(expm(state * 2 * np.pi / omega))
    found = multipliers(small_motions(problem, 2500.0), point.motion_m, omega)
    for value in wanted:
        assert np.abs(found - value).min() < 1e-5
    assert np.abs(wanted).max() > 1.01 and abs(found[0]) == pytest.approx(
        np.abs(wanted).max(), rel=1e-5
    )
    changes = response(force).changes
    assert [c.kind for c in changes] == ["quasi-periodic"] and changes[0].speed_rad_s < omega


@pytest.mark.parametrize(
    ("force", "seen", "moment", "speeds", "counts"),
    [
        # a fold beyond the upper end; the lower end amid the bistable part; in contact; in a film
        (CubicSpring(radial_n_per_m3=1e17), cubic_dynamic_stiffness, MASS * OFFSET,
         (1000.0, 1300.0), {1000.0: 1, 1300.0: 3}),
        (CubicSpring(radial_n_per_m3=1e17), cubic_dynamic_stiffness, MASS * OFFSET,
         (1200.0, 1300.0), {1200.0: 3, 1300.0: 3}),
        (Clearance(friction=0.05, **GAP), gap_dynamic_stiffness, MASS * OFFSET,
         (1000.0, 1150.0), {1000.0: 1, 1150.0: 3}),
        (SqueezeFilm(**{**FILM, "viscosity_pa_s": 5e-4}), thin_film_dynamic_stiffness, MASS * 4e-5,
         (2000.0, 2500.0), {2000.0: 3, 2500.0: 3}),
        # two joints at one place: loads are raised
        ([CubicSpring(radial_n_per_m3=1e17), Clearance(friction=0.05, **GAP)],
         lambda r, omega: cubic_dynamic_stiffness(r, omega) + gap_dynamic_stiffness(r, omega),
         MASS * OFFSET, (1200.0, 1300.0), {1200.0: 3, 1300.0: 3}),
    ],
)  # fmt: skip
def test_every_orbit_at_the_ends_of_the_range(monkeypatch, force, seen, moment, speeds, counts):
    """Radii are the roots of |D + k(r)| r = U ω², found by signs on a fine grid."""
    monkeypatch.setattr(starts, "_GRID", 7)
    monkeypatch.setattr(starts, "_BETWEEN", 1)
    joints = [NonlinearJoint(first=HUB, force=each) for each in np.atleast_1d(force)]
    found = nonlinear_response(jeffcott(), joints, unbalance(moment), speeds, [HUB])
    assert not any(b.open_ends for b in found.branches)

    def beyond(r, omega):
        whole = STIFFNESS - MASS * omega**2 + 1j * DAMPING * omega + seen(r, omega)
        return np.abs(whole) * r - moment * omega**2

    for omega, count in counts.items():
        r = np.concatenate((np.geomspace(1e-8, 9e-5, 4000), 1e-4 - np.geomspace(1e-5, 1e-8, 999)))
        values = beyond(r, omega)
        signs = np.flatnonzero(values[1:] * values[:-1] < 0.0)
        wanted = [brentq(beyond, r[k], r[k + 1], args=(omega,), xtol=1e-16) for k in signs]
        ends = [
            b.largest_radius_m[k, 0]
            for b in found.branches for k in (0, -1)
            if b.speeds_rad_s[k] == pytest.approx(omega, rel=1e-12)
        ]  # fmt: skip
        assert len(wanted) == count
        # samples of a circle lie within rounding of Newton's method, 1e-9
        assert sorted(ends) == pytest.approx(wanted, rel=1e-7)


def test_a_range_within_the_bistable_part_of_a_spring_along_x(monkeypatch):
    """No circles: of three motions at each end, those that are stable repeat in time."""
    monkeypatch.setattr(starts, "_BETWEEN", 1)
    force, gravity = CubicSpring(along_n_per_m3=(1e17, 0.0)), np.zeros(2)
    joints = [NonlinearJoint(first=HUB, force=force)]
    found = nonlinear_response(
        jeffcott(), joints, unbalance(), (1200.0, 1300.0), [HUB], tolerance=1e-5
    )
    ends = [
        (b.speeds_rad_s[k], b.translation_m[k, :, 0], b.is_stable[k])
        for b in found.branches for k in (0, -1)
    ]  # fmt: skip
    for end in (1200.0, 1300.0):
        here = [(m, stable) for speed, m, stable in ends if abs(speed - end) < 1e-9 * end]
        assert sorted(stable for _, stable in here) == [False, True, True]
        for motion, _ in here:
            rate = (1j * end * np.arange(len(motion))[:, None] * motion).sum(axis=0).real
            start = np.concatenate((motion.sum(axis=0).real, rate))
            size = np.abs(motion).max() * np.array([1.0, 1.0, end, end])
            moved = flow(force, end, gravity, start) - start
            assert np.abs(moved / size).max() < 1e-4  # 1e-5, and what a turn makes of it


def test_an_open_end_is_told():
    """Without damping the motion at a resonance has no bound."""
    problem = forced(CubicSpring(), system=jeffcott(damping=0.0))
    course = Course(
        equations=partial(balance, problem), low=900.0, high=1100.0, unit=200.0, longest=0.1,
        size_m=1e-12, bound_m=1e-4,
    )  # fmt: skip
    branch = through(course, first_point(problem, 900.0, 1))
    assert branch.open_ends == ((-1, "grows"),)
    # m e ω² = |k − m ω²| r
    omega, r = branch.points[-1].point.parameter, np.hypot(*branch.points[-1].point.motion_m[1])
    assert r > 1e-4 and omega == pytest.approx(np.sqrt(STIFFNESS / MASS / (1 + OFFSET / r)))


def test_where_loads_can_not_be_raised_is_told(monkeypatch):
    """Next to rest the part of the loads is that of the linear motion."""
    monkeypatch.setattr(starts, "_POINTS", 9)
    problem = forced(CubicSpring(along_n_per_m3=(1e17, 0.0)))
    found, share = starts.raised(problem, 700.0)
    assert not found and 0.0 < share < 1.0
    monkeypatch.setattr(starts, "_POINTS", 300)
    found, share = starts.raised(problem, 700.0)
    assert len(found) == 1 and share is None


def test_a_branch_ends_where_a_film_closes():
    """At the radius 0.99 c, beyond which films are not computed, the circle takes the load."""
    force, moment = SqueezeFilm(**{**FILM, "viscosity_pa_s": 5e-8}), MASS * 2e-5
    problem = forced(force, 800.0, moment=moment)
    course = Course(
        equations=partial(balance, problem), low=500.0, high=1100.0, unit=600.0, longest=0.05
    )
    branch = through(course, first_point(problem, 500.0, 1))
    assert branch.open_ends == ((-1, "closed"),)
    omega, r = branch.points[-1].point.parameter, np.hypot(*branch.points[-1].point.motion_m[1])
    assert r == pytest.approx(0.99 * FILM["clearance_m"], rel=1e-5)
    whole = STIFFNESS - MASS * omega**2 + 1j * DAMPING * omega
    whole += (film_dynamic_stiffness(r, omega) - 1e6) / 2e5
    assert abs(whole) * r == pytest.approx(moment * omega**2, rel=1e-7)


# -- convergence in the number of harmonics ------------------------------------------------------


@pytest.mark.parametrize("alpha", [1.0, 0.1])
def test_free_oscillation_of_a_cubic_spring(alpha):
    """Against elliptic integrals: m x'' + x + alpha x^3 = 0 from x = 1 at rest."""
    exact = np.sqrt(1 + alpha) * np.pi / (2 * ellipk(alpha / (2 * (1 + alpha))))
    assert exact == pytest.approx({1.0: 1.317776, 0.1: 1.036717}[alpha], abs=5e-7)
    spring = CubicSpring(along_n_per_m3=(alpha, 0.0))
    errors = []
    for harmonics in (1, 3, 5, 7):
        speeds = []
        for sign in (1.0, -1.0):  # next to no load on either side of the free motion
            problem = forced(spring, 1.3, moment=1e-5, system=jeffcott(1.0, 1.0, 0.0))
            motion, row = np.zeros((2, 2 * harmonics + 1, 2))
            motion[1, 0] = sign
            row[1::2, 0] = 1.0
            found = corrected(partial(balance, problem), (motion, exact), (row.ravel(), 0.0), 1.0)
            assert found.motion_m[1::2, 0].sum() == pytest.approx(sign)
            speeds.append(found.parameter)
        errors.append(np.mean(speeds) / exact - 1.0)
    backbone = np.sqrt(1 + 0.75 * alpha) / exact - 1.0
    assert errors[0] == pytest.approx(backbone, rel=1e-6)
    assert errors[0] * exact + exact == pytest.approx(
        {1.0: 1.322876, 0.1: 1.036822}[alpha], abs=5e-7
    )
    # each further harmonic brings the error down by a factor; rounding of the two loads remains
    ratio = np.abs(errors[:-1]) / np.maximum(np.abs(errors[1:]), 1e-12)
    assert (ratio[:2] > 20.0).all() and abs(errors[3]) < 2e-7


def test_rate_in_a_gap():
    """A force with kinks converges by a power of the number of harmonics, motion two faster."""
    problem = forced(Clearance(center_m=(0.0, 2e-6), **GAP))
    best = first_point(problem, 1000.0, 47).motion_m
    counts = np.array([3, 7, 13, 23])
    size = np.linalg.norm(best)
    errors = []
    for harmonics in counts:
        found = at_speed(problem, with_harmonics(best, harmonics), 1000.0).motion_m
        errors.append(np.linalg.norm(with_harmonics(found, 47) - best) / size)
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate > 3.0 and errors[1] < 1e-3


# -- integration in time -------------------------------------------------------------------------


def disk_rate(force, omega, gravity, damping=DAMPING):
    """Rate of the state (x, y, x', y') of the disk."""

    def rate(time, state):
        u, v = state[:2], state[2:]
        load = MASS * OFFSET * omega**2 * np.array([np.cos(omega * time), np.sin(omega * time)])
        held = STIFFNESS * u + damping * v + force.at(u[None], v[None]).force_n[0]
        return np.concatenate((v, (load - held) / MASS + gravity))

    return rate


def flow(force, omega, gravity, start, periods=1.0):
    """State of the disk after some periods from (x, y, x', y')."""
    rate = disk_rate(force, omega, gravity)
    end = periods * 2 * np.pi / omega
    return solve_ivp(rate, (0.0, end), start, rtol=1e-8, atol=1e-12, method="DOP853").y[:, -1]


@pytest.mark.parametrize(
    ("force", "omega", "gravity", "harmonics", "error"),
    [
        (CubicSpring(along_n_per_m3=(1e17, 0.0)), 1250.0, (0.0, 0.0), 15, 1e-6),
        (Clearance(center_m=(0.0, 2e-6), friction=0.1, **GAP), 1000.0, (0.0, 0.0), 31, 1e-4),
        (SqueezeFilm(**FILM), 900.0, (0.0, -50.0), 15, 1e-4),
    ],
)
def test_motion_and_multipliers_in_time(force, omega, gravity, harmonics, error):
    problem = forced(force, omega, (*gravity, 0.0))
    point = first_point(problem, omega, harmonics)
    values, slopes = series_at(np.zeros(1), harmonics)
    start = np.concatenate(((values @ point.motion_m)[0], omega * (slopes @ point.motion_m)[0]))
    size = np.array([1.0, 1.0, omega, omega]) * np.abs(point.motion_m).max()
    end = flow(force, omega, np.array(gravity), start)
    assert np.abs((end - start) / size).max() < error
    step = 1e-3
    columns = [
        (flow(force, omega, np.array(gravity), start + step * size * np.eye(4)[k])
         - flow(force, omega, np.array(gravity), start - step * size * np.eye(4)[k]))
        / (2.0 * step * size)
        for k in range(4)
    ]  # fmt: skip
    found = multipliers(small_motions(problem, 2500.0), point.motion_m, omega)
    for wanted in np.linalg.eigvals(np.stack(columns, axis=1) * size[None] / size[:, None]):
        assert np.abs(found - wanted).min() < 5e-3


# -- motions that are sought ---------------------------------------------------------------------


def sought(force, system, moment, speeds, turns, **options):
    joints = [NonlinearJoint(first=HUB, force=force)]
    return nonlinear_response(
        system, joints, unbalance(moment), speeds, [HUB], sought_turns=turns, **options
    )


@pytest.mark.verify
def test_subharmonic_of_order_three(monkeypatch):
    """Where it exists: balance of ω/3 with the linear motion at ω, in x of a Duffing oscillator.

    Nayfeh and Mook (1995), Nonlinear Oscillations, section 4.1.4, without expansion about 3 ω0.
    """
    monkeypatch.setattr(starts, "_EACH", 1)
    damping, offset, alpha = 200.0, 1.5e-6, 1e17 / MASS
    force, system = CubicSpring(along_n_per_m3=(1e17, 0.0)), jeffcott(damping=damping)
    found = sought(force, system, MASS * offset, (2500.0, 3600.0), (3,))
    # in x the spring has three motions of one turn, and this one of three
    assert [b.period_multiple for b in found.branches] == [1, 1, 1, 3]
    branch = found.branches[-1]
    assert not branch.open_ends
    omega0 = STIFFNESS / MASS

    def parts(omega):
        """β = αB² and D of (¾αA² − D)² + γ² = ¾β ¾αA², and γ."""
        beta = alpha * (offset * omega**2 / (omega0 - omega**2)) ** 2
        return beta, omega**2 / 9 - omega0 - 1.5 * beta, damping / MASS * omega / 3

    def exists(omega):
        beta, d, gamma = parts(omega)
        return 0.75 * beta * d + (0.375 * beta) ** 2 - gamma**2

    begins = brentq(exists, 2800.0, 3400.0)
    assert branch.speeds_rad_s.min() == pytest.approx(begins, rel=1e-3)
    assert branch.speeds_rad_s[branch.is_turning] == pytest.approx([begins], rel=1e-3)
    # the larger motion is stable, both have about the amplitudes of the two roots
    beta, d, _ = parts(branch.speeds_rad_s)
    root = np.sqrt(np.maximum(exists(branch.speeds_rad_s), 0.0))
    third = np.abs(branch.translation_m[:, 1, 0, 0])
    large, small = (np.sqrt((d + 0.375 * beta + s * root) / (0.75 * alpha)) for s in (1.0, -1.0))
    far = branch.speeds_rad_s > 1.02 * begins
    np.testing.assert_allclose(third[far & branch.is_stable], large[far & branch.is_stable], 0.03)
    np.testing.assert_allclose(third[far & ~branch.is_stable], small[far & ~branch.is_stable], 0.03)
    assert branch.is_stable[far].any() and not branch.is_stable[far].all()


def test_an_isolated_branch_closes():
    """A gap just too wide for the main resonance: circles in contact are a closed form."""
    gap = {"gap_m": 8.8e-6, "stiffness_n_per_m": 1e8}
    found = sought(Clearance(**gap), jeffcott(), MASS * OFFSET, (600.0, 4000.0), ())
    main, branch = found.branches
    assert not main.is_closed and main.largest_radius_m.max() < gap["gap_m"]
    assert branch.is_closed and not branch.open_ends and branch.is_turning.sum() == 2
    omega, r = branch.speeds_rad_s, branch.largest_radius_m[:, 0]
    contact = gap["stiffness_n_per_m"] * (1.0 - gap["gap_m"] / r)
    whole = STIFFNESS - MASS * omega**2 + 1j * DAMPING * omega + contact
    np.testing.assert_allclose(np.abs(whole) * r / (MASS * OFFSET * omega**2), 1.0, rtol=1e-6)
    # a motion that is lost there falls to the main branch, which is not touched
    assert {jump.direction for jump in found.jumps} <= {"up", "down"}
    assert all(jump.after_m[0] < gap["gap_m"] for jump in found.jumps)


@pytest.mark.verify
def test_a_rub_that_repeats_after_two_turns(monkeypatch):
    """From one start of each size and speed: the others only find it again."""
    monkeypatch.setattr(starts, "_EACH", 1)
    force = Clearance(center_m=(0.0, 3e-6), gap_m=3e-6, stiffness_n_per_m=2e7)
    system = jeffcott(damping=200.0)
    found = sought(force, system, MASS * OFFSET, (1950.0, 2150.0), (2,), tolerance=3e-3)
    doubled = next(c.speed_rad_s for c in found.changes if c.kind == "period doubling")
    branch = next(b for b in found.branches if b.period_multiple == 2)
    assert branch.speeds_rad_s.min() == pytest.approx(doubled, rel=5e-3)
    at = int(np.argmin(np.abs(branch.speeds_rad_s - 2060.0)))
    assert branch.is_stable[at]
    omega, motion = branch.speeds_rad_s[at], branch.translation_m[at, :, 0]
    order = 0.5 * omega * np.arange(len(motion))
    start = np.concatenate((motion.sum(axis=0).real, (1j * order[:, None] * motion).sum(0).real))

    def later(turns):
        rate = disk_rate(force, omega, np.zeros(2), 200.0)
        span = (0.0, turns * 2 * np.pi / omega)
        return solve_ivp(rate, span, start, rtol=1e-9, atol=1e-13, method="DOP853").y[:2, -1]

    size = np.abs(motion).max()
    assert np.abs(later(2) - start[:2]).max() < 5e-3 * size
    assert np.abs(later(1) - start[:2]).max() > 5e-2 * size


# -- flexible shafts -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def shaft():
    element = steel_shaft(
        "shaft", np.linspace(0.0, 1.0, 11), 0.02, {"left": 0.0, "hub": 0.4, "right": 1.0},
        [(0.4, 8.0, 0.04, 0.02)],
    )  # fmt: skip
    ends = [ground("rotor", end, 2e7, 1e7, 300.0) for end in ("left", "right")]
    return one_rotor(element, ends)


def test_derivatives_and_linear_limit(shaft):
    linear = nonlinear_response(
        shaft,
        [NonlinearJoint(first=HUB, force=CubicSpring())],
        unbalance(1e-4),
        (200.0, 290.0),
        [HUB],
    )
    (branch,) = linear.branches
    wanted = unbalance_response(shaft, unbalance(1e-4), branch.speeds_rad_s[::9]).exciters[0]
    given = wanted.at_node("rotor", "hub")
    np.testing.assert_allclose(branch.translation_m[::9, 1, 0], given, rtol=1e-7)
    problem = forced(SqueezeFilm(**FILM), 250.0, (0.0, -9.81, 0.0), 1e-4, shaft)
    motion = 1e-5 * np.random.default_rng(2).standard_normal((7, 2))
    found = balance(problem, motion, 250.0)
    near = [balance(problem, motion, 250.0 + d).residual_m for d in (0.01, -0.01)]
    slope = (near[0] - near[1]) / 0.02
    np.testing.assert_allclose(
        found.by_parameter, slope, rtol=1e-5, atol=1e-5 * np.abs(slope).max()
    )
    for k in range(motion.size):
        step = 1e-9 * np.eye(motion.size)[k].reshape(motion.shape)
        near = [balance(problem, motion + d, 250.0).residual_m for d in (step, -step)]
        np.testing.assert_allclose(found.by_motion[:, k], (near[0] - near[1]) / 2e-9, atol=1e-4)


@pytest.mark.verify
def test_few_shapes_have_the_multipliers_of_all(shaft):
    problem = forced(CubicSpring(along_n_per_m3=(1e14, 0.0)), 250.0, moment=1e-5, system=shaft)
    course = Course(
        equations=partial(balance, problem), low=150.0, high=500.0, unit=350.0, longest=0.025,
        size_m=1e-12, bound_m=1.0,
    )  # fmt: skip
    branch = through(course, first_point(problem, 150.0, 3))
    few = small_motions(problem, 500.0)
    assert few.system.size < 0.5 * shaft.size
    whole = SmallMotions(
        system=shaft, motion=problem.motion, forced=problem, shapes=np.eye(shaft.size)
    )
    first, last = (k for k, p in enumerate(branch.points) if p.is_turning)
    between = [p.point for p in branch.points[first + 1 : last]]
    turned = [branch.points[k].point.parameter for k in (first, last)]
    at = min(between, key=lambda point: abs(point.parameter - np.mean(turned)))
    found, wanted = (multipliers(s, at.motion_m, at.parameter)[0] for s in (few, whole))
    assert found.real > 1.01 and abs(found - wanted) < 1e-5


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"speeds_rad_s": (0.0, 1.0)}, "must rise from above 0"),
        ({"joints": []}, "joints is empty"),
        ({"unbalances": []}, "unbalances is empty"),
        ({"places": [End(body="rotor", interface="x")]}, "rotor.x"),
    ],
)
def test_refusals(changes, says):
    joints = [NonlinearJoint(first=HUB, force=CubicSpring())]
    asked = {"joints": joints, "unbalances": unbalance(), "speeds_rad_s": (1.0, 2.0)}
    with pytest.raises(AnalysisError, match=says):
        nonlinear_response(jeffcott(), **{**asked, "places": [HUB], **changes})
