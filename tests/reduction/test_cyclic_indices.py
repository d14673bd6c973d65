"""Nodal-diameter modes of bodies of revolution against closed forms in the turning frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI
from shapes import bladed_disk

from solidwhirl.geometry import Body, Interface, Material, Section
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.meshing.own.revolved import unfolded
from solidwhirl.reduction import ReductionError
from solidwhirl.reduction.basis.overspeed import speed_without_stiffness
from solidwhirl.reduction.body.cyclic_indices import CyclicRequest, reduce_indices
from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
from solidwhirl.rotordyn import nodal_diameters as nd

pytestmark = pytest.mark.solver

STEEL = Material(name="steel", density_kg_per_m3=7800.0, youngs_modulus_pa=2e11, poissons_ratio=0.3)


def _plate(thickness_m=0.001):
    """Annular plate, bore 0.1 m, rim 0.2 m, with an interface in the bore."""
    ring = Section(
        name="plate", start_m=0.0, end_m=thickness_m, inner_radius_m=(0.1, 0.1),
        outer_radius_m=(0.2, 0.2), material=STEEL,
    )  # fmt: skip
    bore = Interface(
        name="bore", kind="inner", coupling="distributing", start_m=0.0, end_m=thickness_m
    )
    return Body(name="plate", sections=(ring,), interfaces=(bore,))


def _reduced(body, size_m, **asked):
    mesh = mesh_meridian(body, MeshSize(size_m=size_m, corner_size_m=asked.pop("corner_m", size_m)))
    given = {"level": "harmonic", "held": (), "degree": 2, "modes": 6, "maximum_speed_rad_s": 100.0}
    return reduce_indices(body, mesh, MPI.COMM_SELF, CyclicRequest(**{**given, **asked}))


def test_annular_plate_clamped_in_its_bore():
    """Kirchhoff's plate, Bessel functions, Hz; thickness over width 0.01 costs some 1e-4."""
    expected = {
        0: (79.409, 518.446), 1: (81.028, 528.646), 2: (89.649, 559.328), 3: (113.173, 610.721),
    }  # fmt: skip
    body, _ = _reduced(_plate(), 0.002, corner_m=1e-3, indices=tuple(expected), held=("bore",))
    found = nd.nodal_diameter_modes(body, np.array([0.0]), 2)
    for index, hertz in expected.items():
        family = found.family(index, "backward")
        assert family.frequency_hz[0] == pytest.approx(hertz, rel=1e-3)
        assert family.frequency_hz[0] == pytest.approx(
            found.family(index, "forward").frequency_hz[0], rel=1e-10
        )


def test_spinning_ring_backward_and_forward(spinning_ring):
    """Bryan's ring: the backward wave is faster by 4nΩ/(n²+1), both from the inextensional form."""
    speed, radius, side, modulus, density = 1000.0, 0.1, 0.002, 2.1e11, 7850.0
    body, _ = _reduced(
        spinning_ring, 0.001, indices=(2, 3), degree=3, modes=4, maximum_speed_rad_s=speed
    )
    found = nd.nodal_diameter_modes(body, np.array([0.0, speed]), 4)
    for n in (2, 3):
        shape = n**2 * (n**2 - 1) ** 2
        stiffness = modulus * side**2 / 12 * shape / (density * radius**4)
        root = np.sqrt(stiffness / (1 + n**2) + speed**2 * shape / (n**2 + 1) ** 2)
        shift = 2 * n * speed / (n**2 + 1)
        for direction, rate in (("backward", root + shift), ("forward", root - shift)):
            hertz = found.family(n, direction).frequency_hz[1]
            # the ring bends out of its plane too, nearby
            assert np.abs(2 * np.pi * hertz / rate - 1.0).min() < 1.5e-3


@pytest.mark.verify
def test_estimated_errors_cover_those_of_a_coarse_mesh():
    asked = {"indices": (0, 2), "held": ("bore",), "maximum_speed_rad_s": 400.0}
    plate, speeds = _plate(0.01), np.array([0.0, 400.0])
    errors = ("mode_truncation", "mesh")
    coarse, _ = _reduced(plate, 0.02, corner_m=0.01, estimates=errors, modes=4, **asked)
    fine, _ = _reduced(plate, 0.002, corner_m=2e-4, degree=3, modes=12, **asked)
    pairs = [nd.nodal_diameter_modes(body, speeds, 2) for body in (coarse, fine)]
    for own, true in zip(pairs[0].families, pairs[1].families, strict=True):
        # the second mode of index 0 is torsion on the coarse mesh, and bending on the fine one
        count = 2 if own.index else 1
        error = (own.frequency_hz / true.frequency_hz - 1.0)[:, :count]
        assert (error > 0.0).all()
        # a bound that says something
        assert (error < own.error[:, :count]).all()
        assert (own.error[:, :count] < 4.0 * error).all()


#: Bladed disk, Hz at rest and at 6000 rpm, backward and forward, extrapolated to 0.15 %.
BLADED = {
    0: ((1075.86, 1539.90), (1088.12, 1546.19), (1088.12, 1546.19)),
    1: ((1067.58, 1508.74), (1079.89, 1517.01), (1079.55, 1515.73)),
}
EXTRAPOLATED = 1.5e-3


def test_bladed_disk_at_rest_and_at_speed():
    """Errors of a coarse sector lie between those of the extrapolation and the estimates."""
    body = bladed_disk()
    mesh = mesh_sector(body, MeshSize(size_m=0.02, corner_size_m=0.009, growth=0.6))
    speed = 6000.0 * np.pi / 30.0
    request = CyclicRequest(
        level="solid", indices=(0, 1, 2), held=("bore",), degree=2, modes=5,
        maximum_speed_rad_s=speed, estimates=("mode_truncation", "mesh"),
    )  # fmt: skip
    reduced, _ = reduce_indices(body, mesh, MPI.COMM_SELF, request)
    assert reduced.sectors == 12
    found = nd.nodal_diameter_modes(reduced, np.array([0.0, speed]), 2)
    for index, (rest, backward, forward) in BLADED.items():
        for direction, turning in (("backward", backward), ("forward", forward)):
            own = found.family(index, direction)
            off = own.frequency_hz / np.array([rest, turning]) - 1.0
            assert (off > -EXTRAPOLATED).all()
            assert (off < own.error + EXTRAPOLATED).all()
            assert (own.error < 3.0 * (off + EXTRAPOLATED)).all()
    # a wave against the spin is faster in the frame that turns
    split = [found.family(1, d).frequency_hz[1] for d in ("backward", "forward")]
    assert (split[0] > split[1]).all()


def test_engine_orders_meet_only_their_own_diameter_of_a_body_of_revolution():
    """A wave stands still in the fixed frame where K + Ω² (Kσ - S) of the whole mesh is singular.

    Its negative eigenvalues are counted by a factorisation, on the fixed frame's own matrices.
    """
    body, _ = _reduced(
        _plate(), 0.002, indices=(2, 3), held=("bore",), modes=4, maximum_speed_rad_s=700.0
    )
    modes = nd.nodal_diameter_modes(body, np.linspace(0.0, 700.0, 9), 2)
    found = nd.engine_order_crossings(modes, range(1, 9))
    assert [(c.engine_order, c.index, c.direction, c.mode) for c in found] == [
        (3, 3, "backward", 0), (2, 2, "backward", 0),
    ]  # fmt: skip
    for crossing in found:
        assert _lost_stiffness_rad_s(crossing.index) == pytest.approx(
            crossing.speed_rad_s, rel=1e-6
        )


def _lost_stiffness_rad_s(order):
    """Lowest speed at which the held plate has a static wave of an order in the fixed frame."""
    plate = _plate()
    clamped = replace(plate, interfaces=(replace(plate.interfaces[0], coupling="rigid"),))
    mesh = mesh_meridian(plate, MeshSize(size_m=0.002, corner_size_m=0.002))
    effects = OperatorEffects(gyroscopic=False, centrifugal=True, components={"bore": ()})
    operators = build_operators(
        clamped, mesh, MPI.COMM_SELF, order=order, degree=2, effects=effects
    )
    return speed_without_stiffness(operators, np.empty((operators.mass.getLocalSize()[0], 0)))


def test_sectors_have_the_indices_of_their_meridian():
    """Half and whole sector are one mesh of the circle; the meridian is another mesh.

    What the speed adds is the same on all three: splitting, stiffening, softening.
    """
    plate, speeds = _plate(0.02), np.array([0.0, 1500.0])
    asked = {"indices": (0, 1, 2), "held": ("bore",), "maximum_speed_rad_s": 1500.0}
    half = mesh_revolved(plate, MeshSize(size_m=0.02, corner_size_m=0.01))
    meridian, _ = _reduced(plate, 0.005, degree=3, **asked)
    request = CyclicRequest(level="solid", degree=2, modes=6, **asked)
    sectors = [reduce_indices(plate, m, MPI.COMM_SELF, request)[0] for m in (half, unfolded(half))]
    expected, one, other = (nd.nodal_diameter_modes(b, speeds, 1) for b in (meridian, *sectors))
    for own, same, true in zip(one.families, other.families, expected.families, strict=True):
        np.testing.assert_allclose(own.frequency_hz, same.frequency_hz, rtol=1e-9)
        # the coarse mesh is too stiff by 1 %, and so is what the speed adds
        (rest, fast), (true_rest, true_fast) = own.frequency_hz[:, 0], true.frequency_hz[:, 0]
        assert 1.0 < rest / true_rest < 1.015
        assert fast - rest == pytest.approx(true_fast - true_rest, rel=0.015)


def test_an_index_that_moves_as_a_whole_is_refused(spinning_ring):
    with pytest.raises(ReductionError, match="nodal diameter 1 moves the body as a whole"):
        _reduced(spinning_ring, 0.001, indices=(1,))
