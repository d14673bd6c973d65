"""Ground motion of engines with asymmetric bodies."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from flat_rotors import flat_mass, in_its_frame
from rotors import ground, pinned, steel_shaft, turning
from scipy.integrate import solve_ivp
from sometimes import often

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.coordinates import interface_row, joint_motion
from solidwhirl.rotordyn.asymmetric import assemble_rotating
from solidwhirl.rotordyn.asymmetric.ground_motion import rotating_ground_map, rotating_ground_peaks
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response.map_peaks import ground_motion_peaks
from solidwhirl.rotordyn.response.maps import ground_motion_map

AMPLITUDE = 2e-6
ENDS = ("left", "right")
DISK = rd.End(body="shaft", interface="disk")
# Signs of ux, uy, rx, ry of the plane of x and that of y.
PLANES = np.array([1.0, -1.0, -1.0, 1.0])


def shaft(stations, mass=12.0, **options):
    """A shaft of steel with a disk three quarters along it."""
    end = float(stations[-1])
    disks = [(0.75 * end, mass, 1e-2 * mass, 6e-3 * mass)]
    seats = {"left": 0.0, "disk": 0.75 * end, "right": end}
    return steel_shaft("shaft", stations, 0.03, seats, disks, **options)


def flat(element, part):
    """A body whose stiffness is higher in the plane of x by a part, and lower in that of y."""
    planes = np.tile(PLANES, element.size // 4)
    own = in_its_frame(element)
    return dataclasses.replace(own, stiffness=own.stiffness * (1.0 + part * planes))


@pytest.mark.parametrize("ratio", [1.0, -1.5])
@pytest.mark.parametrize("supports", [{}, {"ky": 5e7, "cx": 3e3, "cy": 1e3}, {"cx": 2e3}])
def test_a_body_of_revolution_has_the_map_of_the_ordinary_road(supports, ratio):
    element = shaft(0.3 * np.arange(5))
    held = [ground("shaft", end, 3e7, **supports) for end in ENDS]
    ordinary = rd.assemble({"shaft": turning(element, ratio)}, held)
    rotating = assemble_rotating({"shaft": turning(in_its_frame(element), ratio)}, tuple(held))
    speeds, omega = np.array([0.0, 150.0, 700.0]), np.linspace(20.0, 2000.0, 45)
    known = ground_motion_map(ordinary, AMPLITUDE, "x", speeds, omega, DISK)
    found = rotating_ground_map(rotating, AMPLITUDE, "x", speeds * abs(ratio), omega, DISK)
    assert found.multiples.tolist() == [-2, 0, 2]
    limit = 1e-9 * np.abs(known.translation_m).max(axis=(1, 2), keepdims=True)
    assert (np.abs(found.translation_m[:, :, 1] - known.translation_m) <= limit).all()
    assert (np.abs(found.translation_m[:, :, [0, 2]]) <= limit[..., None]).all()
    if supports:
        # heights of peaks are right to 1e-4 by either road
        tops = ground_motion_peaks(ordinary, known), rotating_ground_peaks(rotating, found)
        highest = [top.height_m.max(axis=1) for top in tops]
        assert highest[1] == pytest.approx(highest[0], rel=1e-4)


def in_time(ordinary, part, speed, frequency):
    """Periodic motion x, y of the disk on a ground that moves by cos ωt along x, over two turns.

    In fixed axes and absolute coordinates, where the ground pushes through the bearings. Returns
    times (t,) and motion (t, 2).
    """
    mass, damping, gyroscopic, stiffness = rd.matrices_at_speed(ordinary, speed)
    turn, size = ordinary.system.rotors["shaft"].element.spin_generator, ordinary.size
    assert ordinary.transformation == pytest.approx(np.eye(size))
    own = ordinary.system.rotors["shaft"].element.stiffness
    uneven = part * own * np.tile(PLANES, size // 4)
    inverse = np.linalg.inv(mass)
    spring, drag = np.zeros((2, size))
    for bearing in ordinary.system.bearings:
        k, c = bearing.matrices()
        motion = joint_motion(ordinary, bearing)
        spring, drag = spring + k[0] @ motion, drag + c[0] @ motion

    def rate(time, state):
        z = state.reshape(2 * size, -1)
        around = np.cos(speed * time) * np.eye(size) + np.sin(speed * time) * turn
        force = -(stiffness + around @ uneven @ around.T) @ z[:size]
        force -= (damping + gyroscopic) @ z[size:]
        push = spring * np.cos(frequency * time) - frequency * drag * np.sin(frequency * time)
        force[:, -1] += push
        return np.vstack((z[size:], inverse @ force)).ravel()

    end = 4.0 * np.pi / speed
    begin = np.eye(2 * size, 2 * size + 1)
    times = np.linspace(0.0, end, 401)
    found = solve_ivp(rate, (0.0, end), begin.ravel(), "DOP853", times, rtol=1e-10, atol=1e-13)
    states = found.y.T.reshape(times.size, 2 * size, -1)
    whole = states[-1]
    first = np.linalg.solve(np.eye(2 * size) - whole[:, :-1], whole[:, -1])
    motion = states[:, :size] @ np.append(first, 1.0)
    rows = np.array([interface_row(ordinary, "shaft", "disk", c) for c in ("ux", "uy")])
    return times[:-1], (motion @ rows.T)[:-1]


@pytest.mark.parametrize("speed", often([200.0, 260.0, 400.0], 400.0))
def test_a_flat_shaft_on_unlike_supports_in_time(speed):
    """Ground motion at 1.5 times the speed is seen at 0.5, 2.5 and 3.5 times the speed too."""
    element, part = shaft(np.array([0.0, 0.9, 1.2])), 0.2
    held = tuple(ground("shaft", end, 3e7, ky=1e7, cx=3e4, cy=1e4) for end in ENDS)
    ordinary = rd.assemble({"shaft": turning(element)}, held)
    rotating = assemble_rotating({"shaft": turning(flat(element, part))}, held)
    times, motion = in_time(ordinary, part, speed, 1.5 * speed)
    lines = {1.5: 0, 3.5: -2, 0.5: -2, 2.5: -4}
    omega = speed * np.array(sorted(lines))
    found = rotating_ground_map(rotating, 1.0, "x", [speed], omega, DISK)
    assert found.multiples.tolist() == [-4, -2, 0, 2, 4]
    largest = np.abs(found.translation_m).max()
    for own, at in zip(sorted(lines), found.translation_m[0], strict=True):
        known = 2.0 * np.exp(-1j * own * speed * times) @ motion / times.size
        seen = at[found.multiples.tolist().index(lines[own])]
        # harmonics go on until they are below 1e-7, and what they change by is its square
        assert seen == pytest.approx(known, abs=1e-10 * largest)
        assert np.abs(known).max() > 1e-7 * largest


def test_a_mass_on_a_flat_shaft_in_closed_form():
    """m z'' + k z + κ e^{2iΩt} z* = −m x_g'' of z = x + iy couples ω with 2Ω − ω, −ω with 2Ω + ω.

    κ: half the difference of both stiffnesses. Bearings are rigid, the shaft has no mass.
    """
    mass, part = 10.0, 0.1
    light = steel_shaft("shaft", np.array([0.0, 0.5, 1.0]), 0.03,
                        {"left": 0.0, "disk": 0.5, "right": 1.0}, [(0.5, mass, 1e-6, 1e-6)],
                        material=(2e11, 0.3, 1e-6))  # fmt: skip
    held = tuple(pinned("shaft", end) for end in ENDS)
    rotating = assemble_rotating({"shaft": turning(flat(light, part))}, held)
    row = interface_row(rotating, "shaft", "disk", "ux")
    soft = np.linalg.solve(rotating.periodic.stiffness_at_rest(), row)
    k = 1.0 / float(row @ soft) / (1.0 + part)
    slow = np.sqrt(k / mass)
    speed, omega = 0.8 * slow, slow * np.linspace(0.1, 1.7, 23)
    below, above = 2.0 * speed - omega, 2.0 * speed + omega
    seen = np.concatenate((omega, np.abs(below), above))
    found = rotating_ground_map(rotating, AMPLITUDE, "x", [speed], seen, DISK)
    assert found.multiples.tolist() == [-2, 0, 2]

    def circles(other):
        """Amplitudes of circles at ω and at the other rate."""
        first, second = k - mass * omega**2, k - mass * other**2
        one = 0.5 * mass * omega**2 * AMPLITUDE / (first - (part * k) ** 2 / second)
        return one, -part * k * one / second

    (ahead, lower), (back, upper) = circles(below), circles(above)
    known = np.stack((AMPLITUDE + ahead + back, -1j * (ahead - back)), axis=1)
    direct = found.translation_m[0, : omega.size, 1]
    sizes = found.major_m()[0, omega.size :].reshape(2, omega.size, 3)
    pairs = (
        (direct, known),
        (np.where(below > 0.0, sizes[0, :, 0], sizes[0, :, 2]), np.abs(lower)),
        (sizes[1, :, 0], np.abs(upper)),
    )
    for own, wanted in pairs:
        # the disk's inertia and the shaft's mass leave 6e-8
        assert own == pytest.approx(wanted, rel=1e-6)


def test_what_no_ground_moves_is_refused():
    within = {"flat": turning(flat_mass(2.0, (300.0, 700.0)))}
    rotating = assemble_rotating(within, (ground("flat", "hub", 800.0),))
    hub = rd.End(body="flat", interface="hub")
    with pytest.raises(AnalysisError, match="'flat' cannot move along x as a whole"):
        rotating_ground_map(rotating, AMPLITUDE, "x", [10.0], [10.0], hub)
