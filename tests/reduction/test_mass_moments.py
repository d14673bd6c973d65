"""Mass moments of reduced bodies: closed forms, integrals over recovered fields, both levels."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
import scipy.linalg
from reduced import reduced_to
from shapes import body as body_of
from shapes import plane, section
from simplex import gauss_rule, second_order

from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.own.revolved import revolved as sector_of

pytestmark = pytest.mark.solver

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
LATERAL = ("ux", "uy", "rx", "ry")
# e_k × x has the component a of size CROSS[a, k, d] x_d
CROSS = np.zeros((3, 3, 3))
for k, d, a in itertools.permutations(range(3)):
    CROSS[a, k, d] = np.linalg.det(np.eye(3)[[k, d, a]])


def tube(couplings=("distributing", "rigid")):
    """Tube 0.1 m long from z = 0.05 m, radii 10 and 20 mm."""
    ends = zip("ab", (0.05, 0.15), couplings, strict=True)
    planes = [plane(*end) for end in ends]
    return body_of(section("tube", 0.05, 0.15, 0.01, 0.02), interfaces=planes, name="tube")


def stepped(coupling="distributing"):
    """Shaft with a disk, nowhere symmetric along its axis."""
    planes = (plane("a", 0.0, coupling), plane("b", 0.1, coupling)) if coupling else ()
    shaft, disk = section("shaft", 0.0, 0.1, 0.0, 0.02), section("disk", 0.02, 0.04, 0.02, 0.04)
    return body_of(shaft, disk, interfaces=planes, name="stepped")


COARSE = MeshSize(size_m=0.02, corner_size_m=0.02, growth=0.8)
TURNING = {"maximum_speed_rad_s": 500.0, "gyroscopic": True, "centrifugal": True}
EIGHT = MeshSize(size_m=0.05, corner_size_m=0.05, growth=0.8, around=8)


def reduced(body, level, size, orders, components=None, mesh=None, modes=3, **request):
    wanted = components or (ALL if 0 in orders else LATERAL)
    return reduced_to(
        body, level, size, mesh, orders=orders, components=wanted, modes=modes, **request
    )[0]


def size_of(array):
    return np.abs(array).max()


@pytest.mark.parametrize(
    ("level", "coupling", "orders"),
    [
        ("harmonic", "rigid", (0, 1)),
        ("harmonic", "distributing", (1, 0)),
        ("harmonic", None, (0, 1, 2, 3)),
        ("solid", "rigid", (0, 1)),
        ("solid", "distributing", (1,)),
    ],
)
def test_moments_belong_to_the_mass_matrix_and_the_rigid_motions(level, coupling, orders):
    """Their trace is M, and with translations and rotations they are the lower moments."""
    element = reduced(stepped(coupling), level, EIGHT, orders, modes=2)
    moments, motions = element.moments, element.rigid_body_modes
    second, present = moments.second_kg, element.rigid_body_present
    trace = second[0, 0] + second[1, 1] + second[2, 2]
    # the same sums in another order
    np.testing.assert_allclose(trace, element.mass, atol=1e-14 * size_of(element.mass))
    for a in np.flatnonzero(present[:3]):
        simple = np.einsum("bjk,j->bk", second[a], motions[:, a])
        # rigid motions of the solid are fitted, good to 1e-12
        np.testing.assert_allclose(
            simple, moments.displacement_kg, atol=1e-10 * size_of(moments.displacement_kg)
        )
    for k in np.flatnonzero(present[3:]):
        turned = np.einsum("abjk,j->abk", second, motions[:, 3 + k])
        first = np.einsum("ad,dbj->abj", CROSS[:, k], moments.first_kg_m)
        np.testing.assert_allclose(turned, first, atol=1e-10 * size_of(moments.first_kg_m))


def integrals(fields, places, weights):
    """The three moments of fields (points, 3, n) at places with their masses."""
    return (
        np.einsum("paj,p->aj", fields, weights),
        np.einsum("pa,pbj,p->abj", places, fields, weights, optimize=True),
        np.einsum("paj,pbk,p->abjk", fields, fields, weights, optimize=True),
    )


def recovering(monkeypatch, points):
    """Let the next reductions recover the displacement of other points."""
    import solidwhirl.reduction.body.reduce as stage

    monkeypatch.setattr(stage, "_recovery_points", lambda *_: points)


def revolved(body, mesh, angles, monkeypatch, orders):
    """Recovered fields at nodes on a few meridians, and what integrates between and around."""
    theta = 2.0 * np.pi * np.arange(angles) / angles
    z, r = mesh.points.T
    r = np.maximum(r, 1e-13)  # the axis is at every angle
    points = np.concatenate([np.column_stack([r * np.cos(t), r * np.sin(t), z]) for t in theta])
    recovering(monkeypatch, points)
    element = reduced(body, "harmonic", None, orders, mesh=mesh)
    b, weight = gauss_rule(2, 4)
    shape, _ = second_order(b)
    nodal = element.recovery_modes.reshape(angles, len(z), 3, -1)[:, mesh.cells]
    fields = np.einsum("qi,tciaj->tcqaj", shape, nodal, optimize=True)
    corner = mesh.points[mesh.cells[:, :3]]
    area = np.abs(np.linalg.det(corner[:, 1:] - corner[:, :1]))
    at = np.einsum("qi,cid->cqd", b, corner)
    density = np.array([m.density_kg_per_m3 for m in mesh.materials])[mesh.cell_material]
    mass = (density * area)[:, None] * weight * at[..., 1] * 2.0 * np.pi / angles
    x = [np.stack([at[..., 1] * np.cos(t), at[..., 1] * np.sin(t), at[..., 0]], -1) for t in theta]
    n = fields.shape[-1]
    return (
        element,
        fields.reshape(-1, 3, n),
        np.array(x).reshape(-1, 3),
        np.tile(mass.ravel(), angles),
    )


@pytest.mark.parametrize(("coupling", "orders"), [("rigid", (0, 1)), (None, (2, 0, 1))])
def test_moments_are_integrals_of_the_recovered_fields(coupling, orders, monkeypatch):
    """Displacement from the recovery of pictures, summed over a revolved cloud of points."""
    body = stepped(coupling)
    mesh = mesh_meridian(body, COARSE)
    # orders up to 2 in two fields of two directions: 2·3 waves at most, exact with 7 angles
    element, fields, places, weights = revolved(body, mesh, 7, monkeypatch, orders)
    moments = element.moments
    expected = integrals(fields, places, weights)
    found = (moments.displacement_kg, moments.first_kg_m, moments.second_kg)
    for left, right in zip(found, expected, strict=True):
        # both rules are exact on polynomials: rounding
        np.testing.assert_allclose(left, right, atol=1e-12 * size_of(right))
    # orders meet: motion along x of one order with motion along z of another is not zero
    order = np.array([c.component in ("uz", "rz") for c in element.coordinates])
    if coupling:
        assert size_of(moments.second_kg[0, 2][np.ix_(~order, order)]) > 0.01


def mode_numbers(element):
    """Frequency of the first bending pair; moments of it and of order 0 that no sign changes."""
    frequency = np.array([c.frequency_hz for c in element.coordinates])
    lateral = np.abs(element.spin_generator).any(axis=0)
    pair = np.flatnonzero(lateral & (frequency > 10.0))[:2]
    single = np.flatnonzero(~lateral & (frequency > 10.0))[:2]
    second, norm = element.moments.second_kg, np.linalg.norm
    own, across = np.ix_(pair, pair), np.ix_(pair, single)
    numbers = [
        norm(second[0, 0][own]),
        norm(second[2, 2][own]),
        norm(second[0, 2][across]),
        norm(second[2, 0][across]),
        norm(second[2, 1][across]),
        norm(element.moments.first_kg_m[..., single]),
    ]
    return frequency[pair[0]], np.array(numbers)


def test_the_solid_converges_to_the_harmonic_level():
    """Free modes: errors fall with the elements and the angle of the sector, halved together."""
    body = dataclasses.replace(tube(), interfaces=())

    def meridian(size):
        return mesh_meridian(body, MeshSize(size_m=size, corner_size_m=size))

    fine = reduced(body, "harmonic", None, (0, 1), mesh=meridian(0.005), degree=4)
    _, exact = mode_numbers(fine)
    errors = []
    for size, sectors in ((0.01, 8), (0.005, 16)):
        mesh = sector_of(meridian(size), sectors)
        _, found = mode_numbers(reduced(body, "solid", None, (0, 1), modes=2, mesh=mesh))
        errors.append(np.abs(found - exact).max() / exact.max())
    assert errors[1] < errors[0] / 5.0  # measured 7.1, and 20 when halved again
    assert errors[1] < 1e-3


@pytest.mark.parametrize(
    ("level", "orders"), [("harmonic", (0, 1, 2)), ("solid", (0, 1)), ("solid", (1,))]
)
def test_moments_turn_with_the_field(level, orders):
    """Fields turned by any angle have moments turned by it, on a solid mesh as well."""
    body = dataclasses.replace(tube(), interfaces=())
    element = reduced(body, level, EIGHT, orders, modes=2)
    moments, generator = element.moments, element.spin_generator
    for angle in (np.pi / 2, 0.7):
        turned = scipy.linalg.expm(angle * generator)
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        for found, expected in (
            (moments.displacement_kg @ turned, turn @ moments.displacement_kg),
            (
                moments.first_kg_m @ turned,
                np.einsum("ac,bd,cdj->abj", turn, turn, moments.first_kg_m),
            ),
            (
                turned.T @ moments.second_kg @ turned,
                np.einsum("ac,bd,cdjk->abjk", turn, turn, moments.second_kg),
            ),
        ):
            np.testing.assert_allclose(found, expected, atol=1e-13 * size_of(expected))


def test_moments_and_the_matrices_of_rotation_are_of_one_field():
    """In the frame that turns with the body, from G, S and L assembled apart from the moments.

    G + 2 M L is 2∫ φ·(n × φ) dm, and −S + G L + M L² is −∫ (n × φ)·(n × φ) dm.
    """
    element = reduced(stepped("rigid"), "harmonic", COARSE, (0, 1), **TURNING)
    second, turn = element.moments.second_kg, element.spin_generator
    coriolis = element.gyroscopic + 2.0 * element.mass @ turn
    softening = -element.spin_softening + element.gyroscopic @ turn + element.mass @ turn @ turn
    # the quadrature of the assembly is exact for all of them: rounding
    size = 1e-12 * size_of(second)
    np.testing.assert_allclose(coriolis, 2.0 * (second[1, 0] - second[0, 1]), atol=size)
    np.testing.assert_allclose(softening, -(second[0, 0] + second[1, 1]), atol=size)


def test_half_of_the_solid_is_enough_for_lateral_motion():
    """The same mesh whole and as its half: interface motions are the same static fields."""
    body = stepped()
    mesh = mesh_revolved(body, EIGHT)
    half = reduced(body, "solid", None, (1,), LATERAL, modes=1, mesh=mesh)
    whole = reduced(body, "solid", None, (0, 1), ALL, modes=1, mesh=mesh)
    held = [(i, c) for i in ("a", "b") for c in LATERAL]
    one, two = ([e.interface_index(*h) for h in held] for e in (half, whole))
    for name in ("displacement_kg", "first_kg_m", "second_kg"):
        found, expected = (
            getattr(e.moments, name)[..., at] for e, at in ((half, one), (whole, two))
        )
        if name == "second_kg":
            found, expected = found[:, :, one], expected[:, :, two]
        # static solutions of two factorisations
        np.testing.assert_allclose(found, expected, atol=1e-8 * size_of(expected))


def test_nodes_of_two_orders_are_matched_by_their_place():
    """Another distribution of the mesh numbers its nodes otherwise, a little beside in rounding."""
    from mpi4py import MPI

    from solidwhirl.reduction.body.mass_moments import OrderFields, amplitudes_at

    rng = np.random.default_rng(1)
    places = rng.random((50, 2))
    amplitudes = tuple(rng.random((50, 4)) for _ in range(3))
    fields = OrderFields(
        order=0, places_m=places, amplitudes=amplitudes, signs=np.ones(4), rows=np.arange(4)
    )
    other = rng.permutation(50)
    moved = places[other] * (1.0 + 1e-15)
    found = amplitudes_at(fields, moved, MPI.COMM_SELF)
    for left, right in zip(found, amplitudes, strict=True):
        np.testing.assert_array_equal(left, right[other])
