"""Shapes along the axis: closed forms, orbits, and the axis of a solid from points on it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    ground,
    hub,
    one_rotor,
    pinned,
    steel_shaft,
    three_disk,
    twin,
    with_axial_and_torsion,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.modes.mode_shapes import mode_shapes, orbits
from solidwhirl.rotordyn.superelement.centreline import centreline_motion

LENGTH = 0.9


@pytest.fixture(scope="module")
def shaft():
    ends = {"right": LENGTH, "left": 0.0}
    return steel_shaft("shaft", np.linspace(0, LENGTH, 21), 0.025, ends)


@pytest.fixture(scope="module")
def spinning_shaft(shaft):
    system = one_rotor(shaft, [pinned("rotor", end) for end in ("left", "right")])
    return mode_shapes(system, rd.modes_at_speed(system, 800.0, 6))


def test_pinned_shaft_bends_in_sines(spinning_shaft):
    """Timoshenko beams with pinned ends have exact sine modes, at any speed."""
    body = spinning_shaft.body("rotor")
    assert body.axial_m.size == 21
    for mode in range(6):
        waves = 1 + mode // 2
        exact = np.sin(waves * np.pi * body.axial_m / LENGTH)
        found = body.deflection[:, mode]
        # 20 cubic elements: the shape's error is that of interpolation, below (kh)^4 / 384 ~ 1e-4.
        sign = np.sign(exact @ found)
        np.testing.assert_allclose(sign * found, exact / np.abs(exact).max(), atol=2e-4)


def test_orbits_are_circles_in_the_sense_of_the_whirl(spinning_shaft):
    ellipses = orbits(spinning_shaft.body("rotor").motion)
    inside = slice(1, -1)
    ratio = ellipses.minor[inside] / ellipses.major[inside]
    assert spinning_shaft.whirl.tolist() == ["backward", "forward"] * 3
    moving = ellipses.major[inside] > 1e-6
    for mode in range(6):
        sense = 1.0 if mode % 2 else -1.0
        np.testing.assert_allclose(ratio[moving[:, mode], mode], sense, rtol=1e-6)


def test_largest_orbit_is_one():
    system = twin()
    shapes = mode_shapes(system, rd.modes_at_speed(system, 1500.0, 8))
    majors, deflections = [], []
    for body in shapes.bodies:
        majors += [orbits(body.motion).major, orbits(body.interface_motion).major]
        deflections += [body.deflection, body.interface_deflection]
    np.testing.assert_allclose(np.concatenate(majors).max(axis=0), 1.0, rtol=1e-12)
    # At t = 0 the largest orbit is at the end of its major axis.
    np.testing.assert_allclose(np.concatenate(deflections).max(axis=0), 1.0, rtol=1e-12)
    assert shapes.body("outer").interfaces == ("C", "D")
    np.testing.assert_array_equal(shapes.body("inner").interface_axial_m, [0.0, 0.8 / 3, 0.4])
    np.testing.assert_allclose(shapes.frequency_hz[:2], [153.7, 182.6], atol=0.1)


@pytest.mark.parametrize("minor", [0.4, -0.4, 0.0])
@pytest.mark.parametrize("inclination", [-1.2, 0.3, np.pi / 2])
def test_ellipses_of_known_axes(minor, inclination):
    phase = 0.7
    # Along its own axes the point is at (cos(t − phase), minor sin(t − phase)).
    axes = np.array([1.0, -1j * minor]) * np.exp(-1j * phase)
    c, s = np.cos(inclination), np.sin(inclination)
    turn = np.array([[c, -s], [s, c]])
    found = orbits((turn @ axes).reshape(1, 2, 1))
    assert found.major[0, 0] == pytest.approx(1.0, rel=1e-12)
    assert found.minor[0, 0] == pytest.approx(minor, abs=1e-12)
    # +π/2 and −π/2 are one axis, of which either end may be given.
    half_turns = (found.inclination_rad[0, 0] - inclination) / np.pi
    assert half_turns == pytest.approx(round(half_turns), abs=1e-12)
    ends = (found.phase_rad[0, 0] - phase) / np.pi - half_turns
    assert ends / 2 == pytest.approx(round(ends / 2), abs=1e-12)
    assert -np.pi / 2 - 1e-12 < found.inclination_rad[0, 0] <= np.pi / 2 + 1e-12


def _solid(shaft, rings, angles):
    """The beam with points on rings as a solid has them: the axis plus an ovalling of the ring.

    The ring of harmonic 1 moves by ux = a + b cos 2θ, uy = b sin 2θ in the plane of x, turned by
    90° in the plane of y.
    """
    points, modes = [], []
    for station, radius, ovalling in rings:
        axis = shaft.recovery_modes[station, :2]
        for angle in angles:
            c, s = np.cos(2 * angle), np.sin(2 * angle)
            z = shaft.recovery_points_m[station, 2]
            points.append([radius * np.cos(angle), radius * np.sin(angle), z])
            moved = axis + ovalling * np.array([[c, s], [s, -c]]) @ axis
            modes.append(np.vstack((moved, np.zeros((1, shaft.size)))))
    points, modes = np.array(points), np.array(modes)
    return dataclasses.replace(shaft, recovery_points_m=points, recovery_modes=modes)


QUARTER = (0.0, np.pi / 2)


@pytest.mark.parametrize("knows", [True, False])
def test_axis_of_a_solid_from_its_surface(shaft, knows):
    solid = _solid(shaft, [(k, 0.025, 0.3) for k in range(21)], QUARTER)
    if not knows:
        solid = dataclasses.replace(solid, spin_generator=None)
    line = centreline_motion(solid)
    np.testing.assert_allclose(line.axial_m, shaft.recovery_points_m[:, 2], atol=1e-15)
    np.testing.assert_allclose(line.modes, shaft.recovery_modes[:, :2], atol=1e-12)


def test_rims_are_not_the_axis(shaft):
    """A disk at station 10 has only its rim on the outline; its motion is not the shaft's."""
    rings = [(k, 0.2 if k == 10 else 0.025, 5.0 if k == 10 else 0.0) for k in range(21)]
    line = centreline_motion(_solid(shaft, rings, QUARTER))
    np.testing.assert_allclose(line.axial_m, np.delete(shaft.recovery_points_m[:, 2], 10))
    # Without smaller circles beside it, the rim is all there is.
    drum = centreline_motion(_solid(shaft, [(k, 0.2, 0.0) for k in range(21)], QUARTER))
    assert drum.axial_m.size == 21


def test_points_that_cannot_give_the_axis_are_left_out(shaft):
    """Points at 0° and 180° feel the ovalling with one sign; the interfaces take their place."""
    solid = _solid(shaft, [(k, 0.025, 0.3) for k in range(21)], (0.0, np.pi))
    line = centreline_motion(solid)
    np.testing.assert_allclose(line.axial_m, [0.0, LENGTH])
    np.testing.assert_allclose(line.modes, shaft.recovery_modes[[0, -1], :2], atol=1e-12)


@pytest.mark.parametrize("knows", [True, False])
def test_axial_and_torsion_modes_have_no_deflection(shaft, knows):
    element = with_axial_and_torsion(shaft, LENGTH, 0.025, "left", "right")
    points = np.array([[0.02, 0, 0.0], [0, 0.02, 0.0]])
    swelling = np.zeros((2, 3, element.size))
    # A surface that swells and turns with the axial motion and torsion of the left end.
    axial, torsion = (element.interface_index("left", c) for c in ("uz", "rz"))
    swelling[0, 0, axial] = swelling[1, 1, axial] = 0.01
    swelling[0, 1, torsion], swelling[1, 0, torsion] = 0.02, -0.02
    element = dataclasses.replace(element, recovery_points_m=points, recovery_modes=swelling)
    if not knows:
        element = dataclasses.replace(element, spin_generator=None)
    held = {"axial_stiffness_n_per_m": 1e5, "torsion_stiffness_n_m_per_rad": 1e3}
    bearings = [ground("rotor", "left", 1e7, **held), ground("rotor", "right", 1e7)]
    system = one_rotor(element, bearings)
    modes = rd.modes_at_speed(system, 100.0, 6)
    # Axial: 1e5 N/m under about 14 kg.
    axial_mode = int(np.abs(modes.frequency_hz - 13.5).argmin())
    shapes = mode_shapes(system, modes)
    assert shapes.whirl[axial_mode] == "axial"
    body = shapes.body("rotor")
    assert not body.motion[..., axial_mode].any()
    assert not body.interface_motion[..., axial_mode].any()
    lateral = np.isin(shapes.whirl, ("forward", "backward"))
    assert lateral.sum() >= 4
    assert (np.abs(body.interface_deflection[:, lateral]).max(axis=0) > 0.1).all()


def test_hub_without_points_has_its_interface():
    system = one_rotor(hub(stiffness=np.diag([1e6, 2e6, 1e3, 1e3])))
    shapes = mode_shapes(system, rd.modes_at_speed(system, 10.0))
    np.testing.assert_array_equal(shapes.body("rotor").axial_m, [0.0])


def test_wrong_arguments_are_refused():
    system = twin()
    with pytest.raises(rd.AnalysisError, match="the system has 74"):
        mode_shapes(system, rd.modes_at_speed(three_disk(), 0.0, 2))
    shapes = mode_shapes(system, rd.modes_at_speed(system, 0.0, 2))
    with pytest.raises(rd.AnalysisError, match=r"no body 'fan'; there are \['inner', 'outer'\]"):
        shapes.body("fan")
