"""Bodies in a frame that moves with them: against the inertial frame, definitions, invariances."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from flat_rotors import in_its_frame
from floating_frame import floating_body, floating_frame_modes
from point_bodies import skew
from springs import inertial_modes

from solidwhirl.rotordyn import (
    Disk,
    SuperelementError,
    attach_rigid_disk,
    beam_superelement,
    rigid_superelement,
)
from solidwhirl.rotordyn.exchange.matrices.arrays_npz import write_npz
from solidwhirl.rotordyn.exchange.matrices.dmig import write_dmig
from solidwhirl.rotordyn.exchange.matrices.matrix_market import write_matrix_market
from solidwhirl.rotordyn.exchange.matrices.op4 import write_op4
from solidwhirl.rotordyn.exchange.multibody.body_fixed import body_fixed_form
from solidwhirl.rotordyn.exchange.python.exudyn import write_exudyn
from solidwhirl.rotordyn.exchange.python.ross import write_ross
from solidwhirl.rotordyn.superelement.mass_moments import (
    joined_moments,
    projected_moments,
    rigid_motion_moments,
)
from solidwhirl.rotordyn.superelement.record import Coordinate, InterfaceNode, Superelement

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
LATERAL = ("ux", "uy", "rx", "ry")
STEEL = (2.1e11, 0.3, 7850.0)
# Both sides are eigenvalues of dense matrices; rounding is that of the highest frequency.
SAME = 1e-10


@cache
def shaft(components=ALL, start_m=0.0, splits=1):
    """Stepped hollow shaft with a disk inside and one on an arm beyond its end."""
    stations = np.linspace(0.0, 0.8, 4 * splits + 1) + start_m
    body = beam_superelement(
        "shaft", stations, np.repeat([0.03, 0.04, 0.035, 0.02], splits),
        np.repeat([0.0, 0.01, 0.02, 0.0], splits), STEEL,
        {"front": start_m, "rear": start_m + 0.6, "end": start_m + 0.8},
        [Disk(name="d", position_m=start_m + 0.4, mass_kg=9.0, polar_kg_m2=0.2,
              diametral_kg_m2=0.12)],
        components,
    )  # fmt: skip
    return attach_rigid_disk(body, "end", "fan", 5.0, 0.1, 0.06, offset_m=0.07)


def assert_same_frequencies(element, springs, speeds, orders=(1, -1, 0), rtol=SAME):
    """Every frequency of the assembled system is one of the frame's equations, and no other is."""
    body = floating_body(body_fixed_form(element))
    for speed in speeds:
        expected = np.sort(inertial_modes(element, springs, speed).eigenvalues.imag)
        modes = floating_frame_modes(body, springs, speed)
        found = modes.frequencies[np.isin(modes.orders, orders)]
        np.testing.assert_allclose(found, expected, rtol=rtol)


@pytest.mark.parametrize("springs", [(1e7, 2e6), (3e9, 1e9)])
def test_shaft_with_disks_in_both_frames(springs):
    """Soft and stiff springs, no spin, both senses, up to a speed above several critical ones."""
    held = {"front": springs, "rear": (2.0 * springs[0], 0.5 * springs[1])}
    assert_same_frequencies(shaft(), held, (0.0, 250.0, -250.0, 2000.0))


def test_lateral_body_in_both_frames():
    """Without uz and rz the frame brings axial motion and torsion along, rigid ones."""
    element = shaft(LATERAL)
    held = {"front": (1e7, 0.0), "rear": (2e7, 0.0)}
    assert_same_frequencies(element, held, (0.0, 700.0), orders=(1, -1))
    form = body_fixed_form(element)
    assert form.frequencies_hz.size == element.size - 4
    modes = floating_frame_modes(form, {"front": (1e7, 3e6)}, 700.0)
    np.testing.assert_allclose(
        modes.frequencies[modes.orders == 0], np.sqrt(3e6 / form.mass_kg), rtol=1e-12
    )


@pytest.mark.solver
def test_stiffening_of_a_continuum_is_that_of_its_stress(harmonic_rotor):
    """What is left of K2 + G L + M L² without Kspin is ∫ σ0 : ∇uᵀ∇v, which no L and G enter."""
    form = body_fixed_form(harmonic_rotor)
    expected = form.shapes.T @ harmonic_rotor.stress_stiffening @ form.shapes
    # rounding of three matrices whose parts cancel
    scale = np.abs(expected).max()
    np.testing.assert_allclose(form.stress_stiffening, expected, atol=1e-11 * scale)


def test_modes_are_those_of_the_free_body():
    """Rigid motions are taken out: orthogonal to all modes, and no mode is lost or doubled."""
    element = shaft()
    form = body_fixed_form(element)
    assert form.frequencies_hz.size == element.size - 6
    momentum = element.mass @ element.rigid_body_modes
    scale = np.sqrt(np.diag(element.rigid_body_modes.T @ momentum))
    # rounding
    assert np.abs(form.shapes.T @ momentum / scale).max() < 1e-12
    product = form.shapes.T @ element.mass @ form.shapes
    np.testing.assert_allclose(product, np.eye(form.frequencies_hz.size), atol=1e-12)
    assert np.abs(form.I3).max() < 1e-11 * np.sqrt(form.mass_kg)
    assert np.abs(form.I4).max() < 1e-11 * np.sqrt(np.abs(form.inertia_kg_m2).max())
    count = element.free_frequencies_hz.size
    found = form.frequencies_hz[:count]
    np.testing.assert_allclose(found, element.free_frequencies_hz, rtol=1e-10)


# Lumped toys: every integral is a sum over points.


def rings(seed=0):
    """Rigid rings of eight points on the axis, tied by springs, as a superelement.

    Each ring has six motions about its centre; the first and the last are interfaces, the others
    are called modal. Springs resist relative motion of neighbours, beyond that of a rigid body.
    """
    rng = np.random.default_rng(seed)
    places = np.array([0.1, 0.3, 0.45, 0.8])
    count, angles = places.size, 0.25 * np.pi * np.arange(8)
    masses, points, motions = [], [], []
    for k, z in enumerate(places):
        radius, half = rng.uniform(0.05, 0.2), rng.uniform(0.005, 0.02)
        own = np.stack(
            (radius * np.cos(angles), radius * np.sin(angles), half * (-1.0) ** np.arange(8)), 1
        )
        masses.append(np.full(8, rng.uniform(0.2, 1.0)))
        points.append(own + np.array([0.0, 0.0, z]))
        field = np.zeros((8, 3, 6 * count))
        field[:, :, 6 * k : 6 * k + 3] = np.eye(3)
        field[:, :, 6 * k + 3 : 6 * k + 6] = np.cross(np.eye(3), own[:, None]).transpose(0, 2, 1)
        motions.append(field)
    masses, points, motions = map(np.concatenate, (masses, points, motions))
    return places, masses, points, motions


def toy():
    """Superelement of the rings with exact matrices, and its points: masses, places, motions."""
    places, masses, points, motions = rings()
    count = places.size
    n = 6 * count
    rigid = np.zeros((n, 6))
    gyroscopic, moments, stiffness = np.zeros((n, n)), None, np.zeros((n, n))
    turn = np.kron(np.eye(2 * count), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0] * 3]))
    for k, z in enumerate(places):
        at = slice(6 * k, 6 * k + 6)
        rigid[at] = np.eye(6)
        rigid[6 * k, 4], rigid[6 * k + 1, 3] = z, -z
        own = slice(8 * k, 8 * k + 8)
        arms = points[own] - [0.0, 0.0, z]
        inertia = np.einsum("p,pa,pb->ab", masses[own], arms, arms)
        inertia = np.trace(inertia) * np.eye(3) - inertia
        gyroscopic[6 * k + 3, 6 * k + 4] = inertia[2, 2]
        gyroscopic[6 * k + 4, 6 * k + 3] = -inertia[2, 2]
        placed = np.zeros((6, n))
        placed[:, at] = np.eye(6)
        part = rigid_motion_moments(masses[own].sum(), [0.0, 0.0, z], inertia, [0.0, 0.0, z])
        part = projected_moments(part, placed)
        moments = part if moments is None else joined_moments(moments, part)
        if k + 1 < count:
            # relative motion of the next ring to where this one would take it
            gap = np.zeros((6, n))
            gap[:, 6 * k + 6 : 6 * k + 12] = np.eye(6)
            gap[:, at] = -np.eye(6)
            arm = places[k + 1] - z
            gap[0, 6 * k + 4], gap[1, 6 * k + 3] = -arm, arm
            rates = np.diag([3e6, 3e6, 8e6, 4e4, 4e4, 3e4]) * (1.0 + k)
            stiffness += gap.T @ rates @ gap
    mass = np.einsum("p,paj,pak->jk", masses, motions, motions)
    total = masses.sum()
    center = masses @ points / total
    arms = points - center
    spread = np.einsum("p,pa,pb->ab", masses, arms, arms)
    names = ["first", "second", "third", "last"]
    element = Superelement(
        name="rings", level="lumped", harmonics=(),
        coordinates=tuple(
            Coordinate(kind="interface", interface=name, component=c, frequency_hz=0.0)
            for name in names for c in ALL
        ),
        interfaces=tuple(
            InterfaceNode(name=name, position_m=np.array([0.0, 0.0, z]), coupling="none")
            for name, z in zip(names, places, strict=True)
        ),
        mass=mass, stiffness=stiffness, gyroscopic=gyroscopic,
        stress_stiffening=np.zeros((n, n)), spin_softening=np.zeros((n, n)),
        rigid_body_modes=rigid, rigid_body_present=np.ones(6, dtype=bool),
        mass_kg=total, center_of_gravity_m=center,
        inertia_kg_m2=np.trace(spread) * np.eye(3) - spread,
        full_dofs=n, maximum_speed_rad_s=np.inf, recovery_points_m=points,
        recovery_modes=motions, free_frequencies_hz=np.empty(0),
        fixed_interface_frequencies_hz=np.empty(0), frequency_error_estimate=np.empty(0),
        spin_generator=turn, moments=moments,
    )  # fmt: skip
    return element, masses, points, motions


def test_integrals_are_their_definitions():
    element, masses, points, motions = toy()
    form = body_fixed_form(element)
    fields = np.moveaxis(motions @ form.shapes, 2, 1)  # (points, modes, 3)
    tilde, places = skew(fields), skew(points)
    np.testing.assert_allclose(tilde[3, 2] @ [1.0, 2.0, 3.0], np.cross(fields[3, 2], [1, 2, 3]))
    expected = {
        "I3": np.einsum("p,pja->aj", masses, fields),
        "I4": np.einsum("p,pab,pjb->aj", masses, places, fields),
        "I5": np.einsum("p,pjab,pkb->ajk", masses, tilde, fields),
        "I8": -np.einsum("p,pab,pjbc->acj", masses, places, tilde),
        "I9": np.einsum("p,pjab,pkbc->acjk", masses, tilde, tilde),
        "inertia_kg_m2": -np.einsum("p,pab,pbc->ac", masses, places, places),
    }
    for name, value in expected.items():
        scale = np.abs(value).max() if name not in ("I3", "I4") else np.sqrt(form.mass_kg)
        np.testing.assert_allclose(getattr(form, name), value, atol=1e-11 * scale, err_msg=name)
    np.testing.assert_array_equal(form.points_m, points)
    np.testing.assert_allclose(form.point_modes, fields.transpose(0, 2, 1), atol=1e-12)


def test_rings_spin_as_points_do():
    """Stiffening of rigid arms: per point with the arm r and f = m r⊥, θᵀ[(r·f) 1 − sym(r fᵀ)]θ."""
    element, masses, points, _ = toy()
    form = body_fixed_form(element)
    expected = np.zeros((element.size, element.size))
    for p, (mass, place) in enumerate(zip(masses, points, strict=True)):
        node = form.nodes[p // 8].position_m
        force, arm = mass * place * [1.0, 1.0, 0.0], place - node
        product = np.outer(arm, force)
        at = slice(6 * (p // 8) + 3, 6 * (p // 8) + 6)
        expected[at, at] += arm @ force * np.eye(3) - 0.5 * (product + product.T)
    expected = form.shapes.T @ expected @ form.shapes
    np.testing.assert_allclose(
        form.stress_stiffening, expected, atol=1e-11 * np.abs(expected).max()
    )
    springs = {"first": (1e6, 3e5), "last": (4e6, 1e5)}
    assert_same_frequencies(element, springs, (0.0, 400.0, -400.0))


# Invariances.


def test_place_on_the_axis_does_not_matter():
    """The same shaft elsewhere: the modes and what has no place in it are the same."""
    here, there = body_fixed_form(shaft()), body_fixed_form(shaft(start_m=-3.0))
    np.testing.assert_allclose(there.frequencies_hz, here.frequencies_hz, rtol=1e-10)
    springs = {"front": (1e7, 2e6), "rear": (2e7, 1e6)}
    found, expected = (floating_frame_modes(f, springs, 600.0).frequencies for f in (there, here))
    np.testing.assert_allclose(found, expected, rtol=1e-9)  # arms five times as long


def test_pairs_lie_in_the_planes():
    """First mode of a pair: no motion along y and about x; the second is the first turned."""
    element = shaft()
    form = body_fixed_form(element)
    turned = element.spin_generator @ form.shapes
    lateral = np.abs(turned).max(axis=0) > 1e-6
    first = np.flatnonzero(lateral)[::2]
    scale = np.sqrt(np.diag(element.mass))[:, None]
    np.testing.assert_allclose(
        scale * turned[:, first], scale * form.shapes[:, first + 1], atol=1e-9
    )
    across = [k for k, c in enumerate(element.coordinates) if c.component in ("uy", "rx")]
    assert np.abs((scale * form.shapes)[np.ix_(across, first)]).max() < 1e-9
    np.testing.assert_allclose(
        form.frequencies_hz[first], form.frequencies_hz[first + 1], rtol=1e-10
    )


def test_nodes_move_as_points_there():
    element = shaft()
    form = body_fixed_form(element)
    assert [node.name for node in form.nodes] == ["front", "rear", "end"]
    for node in form.nodes:
        at = np.abs(form.points_m - node.position_m).sum(axis=1).argmin()
        np.testing.assert_allclose(node.translations, form.point_modes[at], atol=1e-12)
        rows = [element.interface_index(node.name, c) for c in ("rx", "ry", "rz")]
        np.testing.assert_array_equal(node.rotations, form.shapes[rows])
    bare = body_fixed_form(shaft(LATERAL))
    assert not np.abs(bare.nodes[0].translations[2]).any()
    assert not np.abs(bare.nodes[0].rotations[2]).any()


def test_fewer_modes_converge_to_all():
    """Rayleigh-Ritz at rest: from above, never worse with more modes, exact with all."""
    element = shaft()
    springs = {"front": (1e7, 2e6), "rear": (2e7, 1e6)}
    exact = np.sort(inertial_modes(element, springs, 0.0).eigenvalues.imag)[:6]
    errors = []
    for modes in (4, 8, 16, element.size - 6):
        body = body_fixed_form(element, modes=modes)
        assert body.frequencies_hz.size in (modes, modes + 1)
        found = floating_frame_modes(body, springs, 0.0).frequencies[:6]
        errors.append(found / exact - 1.0)
    errors = np.array(errors)
    assert (errors > -1e-11).all()
    assert (np.diff(errors, axis=0) < 1e-11).all()
    # free modes follow the force of a spring slowly
    assert (errors.max(axis=1)[1:] < 0.5 * errors.max(axis=1)[:-1]).all()
    assert errors[-1].max() < 1e-10


def test_a_pair_is_never_parted():
    form = body_fixed_form(shaft())
    for modes in range(1, form.frequencies_hz.size - 2, 3):
        fewer = body_fixed_form(shaft(), modes=modes)
        count = fewer.frequencies_hz.size
        assert count in (modes, modes + 1)
        assert form.frequencies_hz[count] > form.frequencies_hz[count - 1] * (1.0 + 1e-6)
        # products of the same shapes, added up in another order
        np.testing.assert_allclose(fewer.I9, form.I9[:, :, :count, :count], atol=1e-14)


# Refusal.


def _without(**fields):
    return lambda: dataclasses.replace(shaft(), **fields)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: rigid_superelement("r", 1.0, [0.0] * 3, [1.0, 1.0, 1.0], {"a": 0.0}),
            r"coordinates are tied \(constraint\)",
        ),
        (_without(moments=None), "moments of its displacement over the mass are not known"),
        (_without(spin_generator=None), "its spin generator is not known"),
        (_without(rigid_body_present=np.zeros(6, dtype=bool)), "no rigid motion ux, uy, rx, ry"),
        (_without(gyroscopic=np.zeros((30, 30))), "gyroscopic matrix differs by"),
        (
            lambda: dataclasses.replace(shaft(), stiffness=shaft().mass),
            "the stiffness resists rigid motion",
        ),
        (
            lambda: dataclasses.replace(
                rigid_superelement("r", 1.0, [0.0] * 3, [1.0, 1.0, 2.0], {"a": 0.0}),
                constraint=None,
            ),
            "no elastic motion",
        ),
    ],
)
def test_bodies_without_a_frame_of_their_own_are_refused(make, message):
    with pytest.raises(SuperelementError, match=message):
        body_fixed_form(make())


@pytest.mark.parametrize("modes", [0, -1, 1000])
def test_modes_that_do_not_exist_are_refused(modes):
    with pytest.raises(SuperelementError, match=f"{modes} modes; it has 1 to"):
        body_fixed_form(shaft(), modes=modes)


def test_a_body_in_its_own_frame_is_the_same_as_in_fixed_axes():
    """Its own frame, at rest: frequencies, and terms that do not depend on the choice in a pair."""
    even = shaft()
    known, found = body_fixed_form(even), body_fixed_form(in_its_frame(even))
    assert found.frequencies_hz == pytest.approx(known.frequencies_hz, rel=1e-10)
    change = found.shapes.T @ even.mass @ known.shapes
    for name in ("stress_stiffening", "I5"):
        turned = change.T @ getattr(found, name) @ change
        expected = getattr(known, name)
        assert turned == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize(
    "write", [write_npz, write_op4, write_dmig, write_matrix_market, write_ross, write_exudyn]
)
def test_formats_of_the_inertial_frame_do_not_take_a_body_in_its_own(tmp_path, write):
    with pytest.raises(SuperelementError, match="is asymmetric: its matrices are"):
        write(in_its_frame(shaft()), tmp_path / "shaft.py")
    assert not list(tmp_path.iterdir())
