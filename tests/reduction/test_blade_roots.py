"""Stress at the roots of blades against Bernoulli's beam, at rest and turning."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.linalg as la
from mpi4py import MPI
from numpy.polynomial import polynomial as poly

from solidwhirl.geometry import Blade, Body, Interface, Material, Section
from solidwhirl.meshing import MeshSize
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.reduction.body.cyclic_indices import CyclicRequest, reduce_indices
from solidwhirl.rotordyn import nodal_diameters as nd

pytestmark = pytest.mark.solver

# A beam has no Poisson effect; the carrier is stiff and light.
SOFT = Material(name="soft", density_kg_per_m3=7800.0, youngs_modulus_pa=2e11, poissons_ratio=0.0)
STIFF = Material(name="stiff", density_kg_per_m3=1.0, youngs_modulus_pa=2e16, poissons_ratio=0.0)
LENGTH, CHORD, THICKNESS, HUB = 0.1, 0.01, 0.002, 0.05
BEAM_RAD_S = np.sqrt(2e11 * THICKNESS**2 / 12.0 / 7800.0) / LENGTH**2
SPEED = 4.0 * BEAM_RAD_S


def _bladed(stagger_deg, count=6):
    ring = Section(
        name="ring", start_m=0.0, end_m=0.02, inner_radius_m=(0.03, 0.03),
        outer_radius_m=(HUB, HUB), material=STIFF,
    )  # fmt: skip
    blades = Blade(
        name="blades", on="ring", count=count, length_m=LENGTH, chord_m=(CHORD, CHORD),
        thickness_m=(THICKNESS, THICKNESS), stagger_deg=(stagger_deg, stagger_deg), material=SOFT,
    )  # fmt: skip
    bore = Interface(name="bore", kind="inner", coupling="rigid", start_m=0.0, end_m=0.02)
    return Body(name="rotor", sections=(ring,), interfaces=(bore,), features=(blades,))


@cache
def _modes(stagger_deg, indices):
    """Modes at rest and at the speed of the blade that turns."""
    speeds = [0.0, SPEED]
    body = _bladed(stagger_deg)
    mesh = mesh_sector(body, MeshSize(size_m=0.02, corner_size_m=0.005, growth=0.5))
    request = CyclicRequest(
        level="solid", indices=indices, held=("bore",), degree=2, modes=4,
        maximum_speed_rad_s=SPEED,
    )  # fmt: skip
    reduced, shapes = reduce_indices(body, mesh, MPI.COMM_SELF, request)
    return nd.nodal_diameter_modes(reduced, np.array(speeds), 2), shapes


def _per_tip(modes, shapes, place, direction, at):
    """Nominal root stress of the first mode over the largest displacement."""
    family = modes.family(modes.body.indices[place].index, direction)
    sign = -1.0 if family.direction == "forward" else 1.0
    rates = sign * family.frequency_hz[at] / nd.HZ_PER_RAD_S
    vectors, speed = family.vectors[at], float(modes.speeds_rad_s[at])
    found = [nd.root_stress(r, rates, speed, vectors) for r in shapes.roots[place]]
    largest = nd.cycle_peak(shapes.amplitudes[place] @ vectors).max(axis=0)
    return [(r.nominal_pa / largest)[0] for r in found], [(r.peak_pa / largest)[0] for r in found]


def _turning_beam(speed_over_beam, hub_over_length, in_plane):
    """First frequency in √(EI/ρAL⁴) and curvature at the root over the tip's deflection times L².

    Ritz's method with x² to x¹¹, which knows nothing of sections' equilibrium. In the plane of
    rotation the frequency is lower, ω² - η².
    """
    powers = [np.eye(12)[k] for k in range(2, 12)]
    eta = speed_over_beam**2
    tension = eta * np.array([0.5 + hub_over_length, -hub_over_length, -0.5])  # of x from the root

    def integral(*factors):
        whole = [1.0]
        for factor in factors:
            whole = poly.polymul(whole, factor)
        return poly.polyval(1.0, poly.polyint(whole))

    size = (len(powers),) * 2
    stiffness, mass = np.zeros(size), np.zeros(size)
    for i, p in enumerate(powers):
        for j, q in enumerate(powers):
            stiffness[i, j] = integral(poly.polyder(p, 2), poly.polyder(q, 2))
            stiffness[i, j] += integral(tension, poly.polyder(p), poly.polyder(q))
            mass[i, j] = integral(p, q)
    stiffness -= eta * mass if in_plane else 0.0
    squares, shapes = la.eigh(stiffness, mass)
    shape = sum(c * p for c, p in zip(shapes[:, 0], powers, strict=True))
    curvature = poly.polyval(0.0, poly.polyder(shape, 2)) / poly.polyval(1.0, shape)
    return np.sqrt(squares[0]), abs(curvature)


@pytest.mark.parametrize(
    ("stagger_deg", "indices"),
    # half sectors with real and complex fields; whole sectors of both
    [(0.0, (0, 2, 3)), (40.0, (0, 2))],
)
def test_bending_of_a_slender_blade_at_rest(stagger_deg, indices):
    modes, shapes = _modes(stagger_deg, indices)
    expected = 3.516015 * 2e11 * 0.5 * THICKNESS / LENGTH**2
    for place in range(len(indices)):
        for direction in ("backward", "forward"):
            nominal, peak = _per_tip(modes, shapes, place, direction, 0)
            # Timoshenko's shear: (t/L)², some 4e-4, and the mesh
            assert nominal == pytest.approx([expected], rel=2e-3)
            assert 0.5 * expected < peak[0] < 2.0 * expected


@pytest.mark.parametrize(("stagger_deg", "indices"), [(0.0, (0, 2, 3)), (90.0 - 1e-9, (0, 2))])
def test_bending_of_a_turning_blade(stagger_deg, indices):
    """Flap in the plane of rotation (no stagger) and out of it: the tension carries a part."""
    modes, shapes = _modes(stagger_deg, indices)
    rate, curvature = _turning_beam(4.0, HUB / LENGTH, in_plane=stagger_deg == 0.0)
    expected = curvature * 2e11 * 0.5 * THICKNESS / LENGTH**2
    for place in (0, 1):
        for direction in ("backward", "forward"):
            family = modes.family(indices[place], direction)
            found = family.frequency_hz[1, 0] / nd.HZ_PER_RAD_S / BEAM_RAD_S
            assert found == pytest.approx(rate, rel=2e-3)
            nominal, _ = _per_tip(modes, shapes, place, direction, 1)
            assert nominal == pytest.approx([expected], rel=2e-3)
