"""Standard input data, read back by a strict parser of the grammar, and its equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from floating_frame import floating_body, floating_frame_modes
from hypothesis import given, settings
from hypothesis import strategies as st
from point_bodies import point_form, some_points
from sid_file import (
    J_ROWS,
    KEYWORDS,
    OE_COLUMNS,
    check_for_open_readers,
    columns,
    fields,
    gyroscopic_layout,
    parse_sid,
    tensor,
)
from springs import inertial_modes

from solidwhirl.rotordyn import SuperelementError
from solidwhirl.rotordyn.exchange.multibody.mbdyn import write_mbdyn
from solidwhirl.rotordyn.exchange.multibody.sid import number, sid_name, sid_text, write_sid

# Twelve digits: half a unit of the last one, relative to the number.
DIGITS = 5e-12

SOLIDS, SOLVER = ("harmonic_rotor", "pinned_rotor"), pytest.mark.solver
_SMALL = point_form(some_points(1, count=2))


def written(element, path, **options):
    """Parse what the writer wrote."""
    exported = write_sid(element, path / "body.SID_FEM", **options)
    assert exported.files == (path / "body.SID_FEM",)
    sid = parse_sid(exported.files[0].read_text(encoding="ascii"))
    check_for_open_readers(sid)
    return sid, exported


def parsed(form, **options):
    sid = parse_sid(sid_text(form, **options))
    check_for_open_readers(sid)
    return sid


def close(found, wanted, scale=None):
    """Whether numbers agree to the digits of the file, relative to the largest."""
    size = np.abs(wanted).max() if scale is None else scale
    return np.abs(found - wanted).max() <= 4.0 * DIGITS * size


@pytest.mark.parametrize("stiffness", [0.0, 1e7])
@pytest.mark.parametrize(
    "body",
    ["disk_shaft", "lateral_shaft", *(pytest.param(b, marks=SOLVER) for b in SOLIDS)],
)
def test_frequencies_of_a_body(body, stiffness, request, tmp_path):
    """The numbers in the file alone give the frequencies of the system in the inertial frame.

    Of a solid stress stiffens the disk, and orders 0 and 1 are in one file.
    """
    element = request.getfixturevalue(body)
    sid, _ = written(element, tmp_path)
    names = [node.name for node in element.interfaces]
    has_axial = bool(element.rigid_body_present[2])
    springs = dict.fromkeys(names, (stiffness, stiffness * has_axial)) if stiffness else {}
    for speed in (0.0, 400.0, 1200.0):
        wanted = inertial_modes(element, springs, speed).eigenvalues.imag
        modes = floating_frame_modes(floating_body(fields(sid, names)), springs, speed)
        # a body without axial motion and torsion has these in the file as a rigid body
        kept = modes.orders < 2 if has_axial else modes.orders != 0
        np.testing.assert_allclose(modes.frequencies[kept], wanted, rtol=1e-9)


@pytest.mark.parametrize("layout", ["fembs", "mode"])
def test_identities(layout):
    """What holds in any such file, here to the last digit."""
    form = point_form(some_points(5), stiffening=3.0)
    sid = parsed(form, layout=layout)
    blocks = sid.blocks
    assert gyroscopic_layout(sid) == layout
    for node in sid.nodes:
        assert np.array_equal(node["origin"].m1[:, :, 0], node["phi"].m0)
        assert np.array_equal(node["AP"].m0, np.eye(3))
        skewed = node["AP"].m1
        assert np.array_equal(skewed, -skewed.transpose(2, 1, 0))
        psi = np.stack([skewed[2, :, 1], skewed[0, :, 2], skewed[1, :, 0]])
        assert np.array_equal(psi, node["psi"].m0)
    assert np.array_equal(blocks["mdCM"].m1[:, :, 0], blocks["Ct"].m0.T)
    change = tensor(blocks["J"].m1[:, :, 0], J_ROWS)
    gr = columns(sid, "Gr", layout).transpose(0, 2, 1)
    assert close(0.5 * (gr + gr.transpose(1, 0, 2)), change, np.abs(gr).max())
    assert close(columns(sid, "Ge", layout), 2.0 * blocks["Cr"].m1)
    for column, (a, b) in enumerate(OE_COLUMNS):
        force = -(0.5 if a == b else 1.0) * change[a, b]
        assert close(blocks["Oe"].m0[:, column], force, np.abs(gr).max())
    assert np.array_equal(blocks["Oe"].m1, blocks["Oe"].m1.transpose(1, 0, 2))
    assert np.array_equal(blocks["Cr"].m1, -blocks["Cr"].m1.transpose(1, 0, 2))
    stated = np.sqrt(np.diag(blocks["Ke"].m0)) / (2.0 * np.pi)
    assert np.abs(stated - sid.frequencies_hz).max() <= 0.5001e-3  # three digits behind the point
    assert blocks["ksigma"].structure == blocks["De"].structure == 0


def test_inertia_of_points():
    """Each term is the inertia force of points that move as the equation of the format says."""
    points = some_points(5, seed=3)
    form = point_form(points, stiffening=5.0)
    sid = parsed(form)
    mass, x, phi, _ = points
    rng = np.random.default_rng(7)
    q, rate, turn, push = rng.normal(size=5), rng.normal(size=5), *rng.normal(size=(2, 3))
    spin, along = rng.normal(size=3), {key: block.m0 for key, block in sid.blocks.items()}

    def on_modes(acceleration):
        return np.einsum("p,pa,paj->j", mass, acceleration, phi)

    place, velocity = x + phi @ q, phi @ rate
    one = {"Ct": push + 0.0 * x, "Cr": np.cross(turn, place), "Ge": 2.0 * np.cross(spin, velocity)}
    one["Oe"] = np.cross(spin, np.cross(spin, place))
    w = np.array([spin[a] * spin[b] for a, b in OE_COLUMNS])
    ge = columns(sid, "Ge", "fembs")
    terms = {
        "Ct": along["Ct"] @ push,
        "Cr": along["Cr"] @ turn + np.einsum("ijc,j,c->i", sid.blocks["Cr"].m1, q, turn),
        "Ge": np.einsum("ijc,j,c->i", ge, rate, spin),
        "Oe": along["Oe"] @ w + np.einsum("ijc,j,c->i", sid.blocks["Oe"].m1, q, w),
    }
    terms["Oe"] -= spin[2] ** 2 * form.stress_stiffening @ q  # by spin about z alone
    for key, acceleration in one.items():
        assert close(terms[key], on_modes(acceleration), 10.0), key
    # moments on the body: J to first order in q, and Gr
    gr = np.einsum("aib,i,b->a", columns(sid, "Gr", "fembs"), rate, spin)
    assert close(gr, 2.0 * np.einsum("p,pa->a", mass, np.cross(x, np.cross(spin, velocity))), 50.0)
    change = tensor(sid.blocks["J"].m1[:, :, 0], J_ROWS) @ q
    first = np.cross(phi @ q, np.cross(spin, x)) + np.cross(x, np.cross(spin, phi @ q))
    assert close(change @ spin, mass @ first, 50.0)
    inertia = tensor(sid.blocks["J"].m0[:, 0], J_ROWS)
    assert close(inertia @ spin, mass @ np.cross(x, np.cross(spin, x)), 50.0)
    assert close(sid.blocks["mdCM"].m0[:, 0], mass @ x, 50.0)


def test_modal_damping(disk_shaft, tmp_path):
    """De is 2 ζ ω, which says that mode j loses 2πζ of its logarithm per cycle."""
    sid, _ = written(disk_shaft, tmp_path, modal_damping=0.02)
    wanted = 2.0 * 0.02 * np.sqrt(np.diag(sid.blocks["Ke"].m0))
    np.testing.assert_allclose(np.diag(sid.blocks["De"].m0), wanted, rtol=4 * DIGITS)
    assert np.count_nonzero(sid.blocks["De"].m0) == wanted.size


def test_nodes(disk_shaft, tmp_path):
    """Interfaces come first, then recovery points; the report says which number is which."""
    sid, exported = written(disk_shaft, tmp_path)
    assert sid.labels == tuple(range(1, 3 + disk_shaft.recovery_points_m.shape[0]))
    assert [node["origin"].m0[2, 0] for node in sid.nodes[:2]] == [0.0, 0.4]
    places = np.array([node["origin"].m0[:, 0] for node in sid.nodes[2:]])
    assert close(places, disk_shaft.recovery_points_m)
    assert any(text.startswith("nodes 1 front, 2 rear; nodes 3 to ") for text in exported.carried)
    assert all(node["psi"].structure == 0 for node in sid.nodes[2:])
    # the place of an interface moves as the recovery point there
    shared = [k for k, place in enumerate(places) if place[2] == 0.4]
    assert close(sid.nodes[2 + shared[0]]["phi"].m0, sid.nodes[1]["phi"].m0)


def test_what_is_missing_is_said(lateral_shaft, disk_shaft, tmp_path):
    """No axial motion, no torsion, no stiffening about x and y, twelve digits, fewer modes."""
    text = " ".join(written(lateral_shaft, tmp_path)[1].left_out)
    for words in ("rigid in axial motion", "rigid in torsion", "about x and y", "12 digits"):
        assert words in text
    whole, exported = written(disk_shaft, tmp_path)
    assert not [x for x in exported.left_out if "rigid in" in x or "modes are written" in x]
    few, exported = written(disk_shaft, tmp_path, modes=3)
    # the lowest, and a pair is kept whole
    assert np.array_equal(few.frequencies_hz, whole.frequencies_hz[:4])
    told = f"4 of {whole.frequencies_hz.size} elastic modes"
    assert any(told in x for x in exported.left_out)


@pytest.mark.solver
def test_still_interfaces_are_said(pinned_rotor, harmonic_rotor, tmp_path):
    """Interfaces without rotations in a body that tilts; and the speed the modes are made for."""
    sid, exported = written(pinned_rotor, tmp_path)
    assert all(node["psi"].structure == 0 for node in sid.nodes)
    text = " ".join(exported.left_out)
    for words in ("without coordinates rx, ry: ", "'rear'", "up to 1500 rad/s"):
        assert words in text
    assert "without coordinates" not in " ".join(written(harmonic_rotor, tmp_path)[1].left_out)


@pytest.mark.parametrize("modes", [1, 12])
def test_numbers_of_modes(modes):
    """One mode, and 36 columns of Ge."""
    form = point_form(some_points(modes, count=max(2, modes // 3 + 1)))
    sid = parsed(form)
    assert close(sid.blocks["Cr"].m1, form.I5.transpose(2, 1, 0), 1.0)
    assert close(columns(sid, "Ge", "fembs")[-1, 0], 2.0 * form.I5[:, 0, -1], 1.0)


def test_modes_of_three_digits():
    """Indices of modes beyond 99 take more room, and nothing runs together."""
    modes, empty = 120, point_form(some_points(1))
    wide = {
        key: np.zeros((*getattr(empty, key).shape[:-1], modes)) for key in ("I3", "I4", "I8")
    } | {
        "frequencies_hz": 1.0 + np.arange(modes),
        "mass": np.eye(modes),
        "stiffness": np.diag((2 * np.pi * (1.0 + np.arange(modes))) ** 2),
        "stress_stiffening": np.zeros((modes, modes)),
        "I5": np.zeros((3, modes, modes)),
        "I9": np.zeros((3, 3, modes, modes)),
        "nodes": (),
        "points_m": np.zeros((1, 3)),
        "point_modes": np.zeros((1, 3, modes)),
    }
    wide["I5"][2, 0, 119], wide["I5"][2, 119, 0] = 0.25, -0.25
    wide["I9"][1, 1, 119, 109] = wide["I9"][1, 1, 109, 119] = -1.0
    wide["point_modes"][0, 1, 104] = 0.5
    sid = parsed(replace(empty, **wide))
    assert sid.blocks["Cr"].m1[119, 0, 2] == sid.nodes[0]["phi"].m0[1, 104] / 2.0 == 0.25
    assert sid.blocks["Oe"].m1[119, 109, 1] == sid.blocks["Oe"].m1[109, 119, 1] == -1.0
    assert np.count_nonzero(sid.blocks["Oe"].m1) == np.count_nonzero(sid.blocks["Ge"].m0) == 2


@settings(max_examples=50, deadline=None)
@given(
    st.text(min_size=1, max_size=80)
    | st.lists(
        st.sampled_from(
            [*KEYWORDS, "end", "nq", "order", "mass", "=", " ", "ä", "\n", "m0(", "jet", "Jet"]
        ),
        min_size=1,
        max_size=9,
    ).map("".join)
)
def test_names(name):
    """Any name gives a file that all readers take as meant."""
    form = replace(_SMALL, name=name)
    sid = parsed(form)
    assert sid.name == sid_name(name) == sid_name(sid.name)
    assert 1 <= len(sid.name) <= 40
    for word in ("end", "nq", "order", "mass", "frame", "phi", "node"):
        assert word not in sid.name


@settings(max_examples=100, deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_digits(value):
    """A number keeps 12 digits in 18 characters; what is too small is zero, too large refused."""
    if abs(value) >= 9.999999999995e99:
        with pytest.raises(SuperelementError, match="too large"):
            number(value, "here")
        return
    text = number(value, "here")
    assert len(text) == 18 and text[0] in " -" and text[14] == "D"
    found = float(text.replace("D", "E"))
    assert abs(found - value) <= max(DIGITS * abs(value), 1e-99)


def test_refused(disk_shaft, tmp_path):
    """Arguments out of their range; nothing is written. Bodies: in test_body_fixed."""
    path = tmp_path / "body.SID_FEM"
    with pytest.raises(SuperelementError, match="layout is 'simpack', allowed are 'fembs', 'mode'"):
        write_sid(disk_shaft, path, layout="simpack")
    for write in (write_sid, write_mbdyn):
        for ratio in (-0.1, 1.5, np.nan):
            with pytest.raises(SuperelementError, match="modal_damping"):
                write(disk_shaft, path, modal_damping=ratio)
    with pytest.raises(SuperelementError, match="'points', Ke: the number 1e\\+120"):
        sid_text(replace(_SMALL, name="points", stiffness=np.array([[1e120]])))
    many = np.zeros((100_000, 3))
    with pytest.raises(SuperelementError, match="100002 nodes"):
        sid_text(replace(_SMALL, points_m=many, point_modes=np.zeros((100_000, 3, 1))))
    assert not list(tmp_path.iterdir())
