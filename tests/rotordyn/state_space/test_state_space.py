"""State-space models against direct responses, modes and statics; their files."""

from __future__ import annotations

import dataclasses

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.linalg as la
from rotors import connect, ground, polynomial_law, three_disk_element, turning, twin

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.modes.modal_truncation import truncated_system
from solidwhirl.rotordyn.state_space import channels
from solidwhirl.rotordyn.state_space.file import (
    export_mat,
    export_npz,
    read_state_space,
    write_state_space,
)
from solidwhirl.rotordyn.state_space.model import state_space, tabulated_state_space

SPEEDS = (0.0, 700.0, 2500.0)
HERTZ = np.array([10.0, 59.0, 61.0, 150.0, 220.0, 400.0])


def _force(interface, component, body="rotor"):
    return channels.ForceInput(body=body, interface=interface, component=component)


def _motion(interface, component, quantity="displacement"):
    at = {"body": "rotor", "interface": interface, "component": component}
    return channels.MotionOutput(**at, quantity=quantity)


def _carried(bearing, component="ux"):
    return channels.BearingForceOutput(bearing=bearing, component=component)


INPUTS = (_force("left", "ux"), _force("right", "ry"))
OUTPUTS = (
    _motion("right", "ux"),
    _motion("left", "uy", "velocity"),
    _motion("right", "ry", "acceleration"),
)


@pytest.fixture(scope="module")
def system():
    """Every constant term: damping, internal damping, circulation, cross-coupling."""
    seal = connect("seal", "rotor.left", None, [[1e6, 4e5], [-4e5, 1e6]], 300.0)
    inside = rd.InternalDamping(stiffness_coefficient_s=1e-6)
    rotor = turning(three_disk_element(), internal_damping=inside)
    held = [ground("rotor", end, 7e7, 5e7, 700.0, 500.0) for end in ("left", "right")]
    return rd.assemble({"rotor": rotor}, (*held, seal))


@pytest.fixture(scope="module")
def model(system):
    return state_space(system, INPUTS, OUTPUTS, (-100.0, 2600.0))


def frequency_response(model, speed, hertz):
    """Responses C (iω − A)⁻¹ B + D of a model, shape (f, outputs, inputs)."""
    a, b, c, d = model.at_speed(speed)
    unit = np.eye(len(a))
    return np.array([c @ la.solve(1j * w * unit - a, b) + d for w in 2 * np.pi * np.array(hertz)])


def _direct(system, speed, hertz):
    """Responses of OUTPUTS to INPUTS from the dynamic stiffness, written out by hand."""
    m, c, g, k = rd.matrices_at_speed(system, speed)
    index = system.system.rotors["rotor"].element.interface_index
    rows = {key: system.transformation[index(*key)] for key in
            (("left", "ux"), ("left", "uy"), ("right", "ux"), ("right", "ry"))}  # fmt: skip
    loads = np.column_stack((rows["left", "ux"], rows["right", "ry"]))
    found = []
    for w in 2 * np.pi * hertz:
        q = np.linalg.solve(k + 1j * w * (c + g) - w**2 * m, loads)
        found.append([rows["right", "ux"] @ q, 1j * w * rows["left", "uy"] @ q,
                      -(w**2) * rows["right", "ry"] @ q])  # fmt: skip
    return np.array(found)


def _assert_near(found, exact):
    """Equal to 1e-9 of the largest response of each channel.

    Rounding of the stiffest coordinates: ω² of the highest mode is 1e9 times (2π 10 Hz)².
    """
    scale = np.abs(exact).max(axis=0)
    # At rest the planes of x and y may not couple; then nothing is to come out at all.
    scale = np.where(scale > 0, scale, 1e-12)
    np.testing.assert_allclose(found / scale, exact / scale, rtol=0, atol=1e-9)


@pytest.mark.parametrize("speed", SPEEDS)
def test_frequency_response_of_polynomial_and_table_is_the_direct_one(system, model, speed):
    table = tabulated_state_space(system, INPUTS, OUTPUTS, SPEEDS)
    for form in (model, table):
        _assert_near(frequency_response(form, speed, HERTZ), _direct(system, speed, HERTZ))


def test_table_converges_with_the_square_of_its_step(system, model):
    """Linear between two speeds: exact for a beam (K2 = 0), of second order with a K2."""
    table = tabulated_state_space(system, INPUTS, OUTPUTS, [0.0, 2500.0])
    exact, found = (frequency_response(m, 1000.0, HERTZ) for m in (model, table))
    _assert_near(found, exact)
    softened = dataclasses.replace(system, centrifugal_stiffness=-1e-2 * system.mass)
    exact = frequency_response(state_space(softened, INPUTS, OUTPUTS, (0, 800)), 300.0, HERTZ[:1])
    errors = []
    for step in (200.0, 100.0, 50.0):
        speeds = [300.0 - step, 300.0 + step]
        table = tabulated_state_space(softened, INPUTS, OUTPUTS, speeds)
        found = frequency_response(table, 300.0, HERTZ[:1])
        errors.append(np.abs(found - exact).max() / np.abs(exact).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(rates, 2.0, atol=0.1)


def test_speed_dependent_bearings():
    law = polynomial_law((1.0, 1e-3, -2e-7), (0.5, 2e-4), (1.0, -1e-4), top=3000.0)
    bearings = tuple(
        dataclasses.replace(ground("rotor", end, 7e7, 5e7, 700.0), speed_law=law)
        for end in ("left", "right")
    )
    system = rd.assemble({"rotor": turning(three_disk_element())}, bearings)
    table = tabulated_state_space(system, INPUTS, OUTPUTS, SPEEDS)
    for speed in SPEEDS:
        found, exact = frequency_response(table, speed, HERTZ), _direct(system, speed, HERTZ)
        _assert_near(found, exact)
    with pytest.raises(rd.AnalysisError, match="use tabulated_state_space"):
        state_space(system, INPUTS, OUTPUTS, (0.0, 100.0))


def test_bearing_forces_hold_static_loads(system):
    """A constant force of 1 N in x is carried by the three bearings."""
    outputs = [_carried(name) for name in ("rotor.left", "rotor.right", "seal")]
    model = state_space(system, INPUTS[:1], outputs, (0.0, 1000.0))
    for speed in (0.0, 1000.0):
        found = frequency_response(model, speed, [0.0])[0, :, 0]
        # Internal damping at speed adds a circulatory couple, but no net force.
        assert found.sum() == pytest.approx(1.0, rel=1e-8)
    # At rest nearly all of it goes to ground where it acts.
    assert abs(found[0]) > 0.5


def test_models_of_truncated_systems_converge(system):
    """Displacement and velocity do; the acceleration under its own load needs all modes."""
    grid, errors = np.linspace(5, 250, 20), []
    exact = np.array([_direct(system, speed, grid)[:, :2] for speed in SPEEDS])
    for count in (16, 24, 40):
        small = state_space(truncated_system(system, count), INPUTS, OUTPUTS[:2], (0.0, 2500.0))
        assert small.state_count == 2 * count
        found = np.array([frequency_response(small, speed, grid) for speed in SPEEDS])
        errors.append((np.abs(found - exact) / np.abs(exact).max(axis=(0, 1))).max())
    assert errors[0] > 2 * errors[1] > 4 * errors[2] and errors[2] < 1e-2


def test_scale_is_of_powers_of_two(system, model):
    np.testing.assert_array_equal(np.log2(model.state_scale) % 1, 0)
    # Balancing stops where a power of two gains nothing; over (q, q') rows and columns differ by
    # orders of magnitude.
    a = np.abs(sum(2600.0**p * np.abs(term) for p, term in enumerate(model.a)))
    np.fill_diagonal(a, 0.0)
    plain = a * model.state_scale[:, None] / model.state_scale
    balanced, raw = (m.sum(axis=0) / m.sum(axis=1) for m in (a, plain))
    assert balanced.max() < 16 and balanced.min() > 1 / 16
    assert raw.max() > 1e4
    # The physical state: x · scale = (q, q'), so q' of one half is the derivative of the other.
    n = system.size
    kinematic = model.a[0][:n, n:] * model.state_scale[:n, None] / model.state_scale[n:]
    np.testing.assert_array_equal(kinematic, np.eye(n))


def test_names_and_units(model):
    assert model.input_names == ("force rotor.left.ux", "force rotor.right.ry")
    assert model.input_units == ("N", "N m")
    assert model.output_names[1:] == (
        "velocity rotor.left.uy",
        "acceleration rotor.right.ry",
    )
    assert model.output_units == ("m", "m/s", "rad/s2")


@pytest.mark.parametrize(
    ("inputs", "outputs", "error", "message"),
    [
        ((), OUTPUTS, rd.AnalysisError, "there are 0 and 3"),
        (INPUTS, (_carried("x"),), rd.AnalysisError, "no bearing 'x'"),
        (INPUTS, (_carried("seal", "q"),), rd.AnalysisError, "component is 'q'"),
        ((_force("middle", "ux"),), OUTPUTS, rd.AssemblyError, "no interface 'middle'"),
        (INPUTS, (_motion("left", "ux", "jerk"),), rd.AnalysisError, "quantity is 'jerk'"),
    ],
)
def test_wrong_channels_are_refused(system, inputs, outputs, error, message):
    with pytest.raises(error, match=message):
        state_space(system, inputs, outputs, (0.0, 1.0))


def test_joints_without_a_motion_are_refused():
    with pytest.raises(rd.AnalysisError, match="bearing 'C' is rigid in ux"):
        state_space(twin(), [_force("C", "ux", "inner")], [_carried("C")], (0.0, 1.0))


def test_wrong_speeds_are_refused(system, model):
    with pytest.raises(rd.AnalysisError, match=r"speed_range_rad_s is \(5.0, 5.0\)"):
        state_space(system, INPUTS, OUTPUTS, (5.0, 5.0))
    with pytest.raises(rd.AnalysisError, match="two or more rising speeds"):
        tabulated_state_space(system, INPUTS, OUTPUTS, [1.0])
    with pytest.raises(rd.AnalysisError, match="holds from -100 to 2600"):
        model.at_speed(3000.0)
    with pytest.raises(rd.AnalysisError, match="b has shape"):
        dataclasses.replace(model, b=model.b[:2])


def _fields(model):
    return [getattr(model, field.name) for field in dataclasses.fields(model)]


@pytest.mark.parametrize("kind", ["polynomial", "table"])
def test_file_keeps_every_bit(system, tmp_path, kind):
    build = {"polynomial": state_space, "table": tabulated_state_space}[kind]
    model = build(truncated_system(system, 8), INPUTS, OUTPUTS, (0.0, 900.0))
    path = tmp_path / "model.h5"
    write_state_space(model, path)
    assert [p.name for p in tmp_path.iterdir()] == ["model.h5"]
    for found, written in zip(_fields(read_state_space(path)), _fields(model), strict=True):
        np.testing.assert_array_equal(found, written)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda f: f.attrs.update({"format": "other"}), "'format' is 'other'"),
        (lambda f: f.attrs.update({"format_version": "2.0.0"}), "'format_version' is '2.0.0'"),
        (lambda f: f.attrs.update({"form": "spline"}), "'form' is 'spline'"),
        (lambda f: f.__delitem__("B"), "B is missing"),
        (lambda f: f["D"].write_direct(np.full(f["D"].shape, np.nan)), "D has nan"),
        (lambda f: f.move("C", "C2"), "C is missing"),
    ],
)
def test_damaged_files_are_refused(model, tmp_path, damage, message):
    path = tmp_path / "model.h5"
    write_state_space(model, path)
    with h5py.File(path, "r+") as file:
        damage(file)
    with pytest.raises(rd.AnalysisError, match=message) as caught:
        read_state_space(path)
    assert str(caught.value).startswith(str(path))


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(rd.AnalysisError, match="no such file"):
        read_state_space(tmp_path / "nothing.h5")


def _exported(model, folder):
    """What other programs read: npz and mat."""
    export_npz(model, folder / "m.npz")
    export_mat(model, folder / "m.mat")
    assert sorted(p.name for p in folder.iterdir()) == ["m.mat", "m.npz"]
    with np.load(folder / "m.npz") as npz:
        return dict(npz), scipy.io.loadmat(folder / "m.mat", simplify_cells=True)


def test_npz_and_mat_of_a_polynomial(model, tmp_path):
    npz, mat = _exported(model, tmp_path)
    assert npz["input_names"].tolist() == list(model.input_names)
    for stored in (npz, mat):
        for name, value in zip("ABCD", model.at_speed(700.0), strict=True):
            found = sum(700.0**k * stored[f"{name}{k}"] for k in range(3))
            np.testing.assert_allclose(found, value, rtol=1e-14)
        np.testing.assert_array_equal(stored["speed_range"].ravel(), [-100.0, 2600.0])
    assert list(mat["output_units"]) == list(model.output_units)
    assert mat["form"] == "polynomial"


def test_npz_and_mat_of_a_table(system, tmp_path):
    model = tabulated_state_space(truncated_system(system, 8), INPUTS, OUTPUTS, SPEEDS)
    npz, mat = _exported(model, tmp_path)
    np.testing.assert_array_equal(npz["A"], model.a)
    np.testing.assert_array_equal(npz["speeds"], SPEEDS)
    # In Matlab the third axis is the speed.
    np.testing.assert_array_equal(mat["A"][:, :, 1], model.a[1])
