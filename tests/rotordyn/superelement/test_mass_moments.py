"""Moments of displacements over the mass against sums over points, and against each other."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn import (
    Disk,
    SuperelementError,
    attach_rigid_disk,
    beam_superelement,
    check_superelement,
    rigid_superelement,
)
from solidwhirl.rotordyn.run_up.complexity import as_rigid_body, without_modes
from solidwhirl.rotordyn.superelement.mass_moments import (
    MassMoments,
    joined_moments,
    projected_moments,
    rigid_motion_moments,
)

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")


def cloud(seed, count=40):
    """Masses and places of points, with their mass, centre of gravity and inertia about it."""
    rng = np.random.default_rng(seed)
    masses, places = rng.uniform(0.5, 2.0, count), rng.normal(size=(count, 3))
    places = places + np.array([0.1, 0.2, 3.0])
    total = masses.sum()
    center = masses @ places / total
    arms = places - center
    inertia = np.einsum("p,pa,pb->ab", masses, arms, arms)
    return masses, places, total, center, np.trace(inertia) * np.eye(3) - inertia


def summed(masses, places, fields):
    """Moments of fields (points, 3, n) by their definition."""
    return MassMoments(
        displacement_kg=np.einsum("p,pbj->bj", masses, fields),
        first_kg_m=np.einsum("p,pa,pbj->abj", masses, places, fields),
        second_kg=np.einsum("p,paj,pbk->abjk", masses, fields, fields),
    )


def rigid_fields(places, pivot):
    """t + θ × (x − pivot) for unit t and θ."""
    turned = np.cross(np.eye(3), (places - pivot)[:, None, :]).transpose(0, 2, 1)
    return np.concatenate((np.broadcast_to(np.eye(3), (len(places), 3, 3)), turned), axis=2)


def assert_same(found, expected, size=1.0):
    for name in ("displacement_kg", "first_kg_m", "second_kg"):
        left, right = getattr(found, name), getattr(expected, name)
        # rounding of sums of a hundred terms
        np.testing.assert_allclose(left, right, atol=1e-12 * size * np.abs(right).max())


@pytest.mark.parametrize("pivot", [(0.0, 0.0, 0.0), (0.3, -0.2, 2.0)])
def test_rigid_motion_against_points(pivot):
    masses, places, total, center, inertia = cloud(1)
    expected = summed(masses, places, rigid_fields(places, np.array(pivot)))
    assert_same(rigid_motion_moments(total, center, inertia, pivot), expected)


def test_other_coordinates_and_sums_against_points():
    masses, places, total, center, inertia = cloud(2)
    basis = np.random.default_rng(3).normal(size=(6, 4))
    fields = rigid_fields(places, np.zeros(3)) @ basis
    found = projected_moments(rigid_motion_moments(total, center, inertia), basis)
    assert_same(found, summed(masses, places, fields))
    assert_same(joined_moments(found, found), summed(2.0 * masses, places, fields))
    assert projected_moments(None, basis) is None
    assert joined_moments(found, None) is None


def disk_points(mass_kg, polar_kg_m2, diametral_kg_m2, center_m):
    """Six pairs of points with a disk's mass and inertia."""
    across = np.sqrt(1.5 * polar_kg_m2 / mass_kg)
    along = np.sqrt(3.0 * (diametral_kg_m2 - 0.5 * polar_kg_m2) / mass_kg)
    arms = np.diag([across, across, along])
    return np.full(6, mass_kg / 6.0), np.concatenate((arms, -arms)) + center_m


def test_rigid_disk_against_points():
    """What a disk on an arm adds is the sum over points that move with its interface."""
    bare = beam_superelement(
        "s", [0.0, 0.4, 0.7], 0.02, 0.0, (2e11, 0.3, 7800.0), {"a": 0.0, "b": 0.7}, components=ALL
    )
    whole = attach_rigid_disk(bare, "b", "d", 3.0, 0.02, 0.013, offset_m=0.05)
    masses, places = disk_points(3.0, 0.02, 0.013, np.array([0.0, 0.0, 0.75]))
    motion = np.zeros((6, bare.size))
    for k, component in enumerate(ALL):
        motion[k, bare.interface_index("b", component)] = 1.0
    fields = rigid_fields(places, np.array([0.0, 0.0, 0.7])) @ motion
    assert_same(whole.moments, joined_moments(bare.moments, summed(masses, places, fields)))


def test_disk_of_a_shaft_is_a_disk_at_an_interface():
    """The same body twice: with its disk among the beams, and attached afterwards."""
    shaft = ([0.0, 0.3, 0.7], 0.02, 0.01, (2e11, 0.3, 7800.0), {"a": 0.0, "m": 0.3, "b": 0.7})
    disk = Disk(name="d", position_m=0.3, mass_kg=3.0, polar_kg_m2=0.02, diametral_kg_m2=0.013)
    inside = beam_superelement("s", *shaft, [disk], components=ALL)
    outside = attach_rigid_disk(
        beam_superelement("s", *shaft, components=ALL), "m", "d", 3.0, 0.02, 0.013
    )
    # modes with interfaces held do not see the disk, so the coordinates are the same
    assert_same(inside.moments, outside.moments, 10.0)


def test_shaft_converges_to_points_on_its_axis():
    """Trapezoidal sums of ρA w w over the nodes: error falls with the square of their distance."""
    radius, density, errors = 0.02, 7800.0, []
    for count in (41, 81):
        stations = np.linspace(0.2, 1.2, count)
        body = beam_superelement(
            "s", stations, radius, 0.0, (2e11, 0.3, density), {"a": 0.2, "b": 1.2}, components=ALL
        )
        few = np.r_[0:12, 12:16]  # interfaces, and the lowest modes in bending
        weights = np.full(count, density * np.pi * radius**2 / (count - 1))
        weights[[0, -1]] *= 0.5
        expected = summed(weights, body.recovery_points_m, body.recovery_modes[:, :, few])
        found = projected_moments(body.moments, np.eye(body.size)[:, few])
        # rotations about the axis, and of sections, move no point of it
        pairs = [(a, b) for a in range(3) for b in range(3) if (a, b) != (2, 2)]
        straight = [k for k, c in enumerate(np.array(body.coordinates)[few]) if c.component != "rz"]
        error = [
            np.abs(found.displacement_kg - expected.displacement_kg).max(),
            np.abs(found.first_kg_m - expected.first_kg_m)[2].max(),
        ]
        error += [
            np.abs(found.second_kg - expected.second_kg)[a, b][np.ix_(straight, straight)].max()
            for a, b in pairs
        ]
        errors.append(np.array(error))
    seen = errors[0] > 1e-12
    assert seen.sum() >= 5
    assert (np.log2(errors[0][seen] / errors[1][seen]) > 1.9).all()
    assert (errors[1][~seen] < 1e-12).all()


def test_every_body_has_moments_that_fit():
    names = {"moments against the mass", "moments of rigid motion"}
    body = beam_superelement(
        "s", np.linspace(0.1, 1.1, 6), [0.05, 0.06, 0.07, 0.05, 0.04], [0.01, 0.0, 0.02, 0.0, 0.0],
        (2e11, 0.3, 7800.0), {"a": 0.1, "b": 0.7, "c": 1.1},
        [Disk(name="d", position_m=0.5, mass_kg=9.0, polar_kg_m2=0.2, diametral_kg_m2=0.13)], ALL,
    )  # fmt: skip
    with_disk = attach_rigid_disk(body, "b", "e", 5.0, 0.1, 0.06, 0.07)
    casing = rigid_superelement("r", 3.0, [0.1, 0.0, 0.3], [0.2, 0.3, 0.25], {"a": 0.0, "b": 1.0})
    for element in (body, with_disk, casing, without_modes(with_disk), as_rigid_body(body)):
        checks = {c.name: c for c in check_superelement(element)}
        assert names <= set(checks)
        assert all(c.passed for c in checks.values()), element.name
        # rounding; the limit leaves a factor of a thousand
        assert max(checks[name].value for name in names) < 1e-13


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ((np.zeros((2, 4)), np.zeros((3, 3, 4)), np.zeros((3, 3, 4, 4))), "displacement_kg has"),
        ((np.zeros((3, 4)), np.zeros((3, 3, 5)), np.zeros((3, 3, 4, 4))), "first_kg_m has shape"),
        ((np.zeros((3, 4)), np.zeros((3, 3, 4)), np.zeros((3, 3, 4, 5))), "second_kg has shape"),
        ((np.full((3, 4), np.nan), np.zeros((3, 3, 4)), np.zeros((3, 3, 4, 4))), "is nan"),
        (
            (np.zeros((3, 4)), np.zeros((3, 3, 4)), np.arange(144.0).reshape(3, 3, 4, 4)),
            "differs from",
        ),
    ],
)
def test_what_can_be_no_moments_is_refused(arrays, message):
    names = ("displacement_kg", "first_kg_m", "second_kg")
    with pytest.raises(SuperelementError, match=message):
        MassMoments(**dict(zip(names, arrays, strict=True)))


def test_moments_of_another_body_are_refused(hub):
    import dataclasses

    moments = rigid_motion_moments(1.0, np.zeros(3), np.eye(3))
    with pytest.raises(SuperelementError, match="moments is of 6 coordinates, allowed are 4"):
        dataclasses.replace(hub(), moments=moments)
    with pytest.raises(SuperelementError, match="moments is a float"):
        dataclasses.replace(hub(), moments=1.0)
