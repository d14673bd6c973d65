"""Plates and rotating blades as solid sectors, thinner and thinner, against theories of thin ones.

Kirchhoff's plate and Bernoulli's beam are the limits of the solid. Without Poisson's effect they
are reached as thickness²: what follows next is shear and rotary inertia. With it, a clamped edge
that hinders the thickness from changing (and a free edge that takes torsion) adds a term linear in
the thickness (Dauge and Gruais, Asymptotic Anal. 13 (1996) 167-197), so that the limit is seen by
extrapolation alone.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from mpi4py import MPI
from numpy.polynomial import Legendre, Polynomial
from scipy.optimize import brentq
from scipy.special import iv, jv, kv, yv

from solidwhirl.geometry import Blade, Body, Interface, Material, Section
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.reduction.body.cyclic_indices import CyclicRequest, reduce_indices
from solidwhirl.rotordyn import nodal_diameters as nd

pytestmark = pytest.mark.solver

MODULUS, DENSITY = 2e11, 7800.0
INNER, OUTER = 0.1, 0.2


def material(poisson, name="steel", stiffer=1.0, lighter=1.0):
    return Material(
        name=name, density_kg_per_m3=DENSITY / lighter, youngs_modulus_pa=MODULUS * stiffer,
        poissons_ratio=poisson,
    )  # fmt: skip


def kirchhoff_hz(order, poisson, thickness_m):
    """Lowest frequency of the annular plate, clamped at its hub, free at its rim."""

    def determinant(k):
        rows = np.zeros((4, 4))
        for j, (function, sign) in enumerate(((jv, 1.0), (yv, 1.0), (iv, -1.0), (kv, -1.0))):
            for i, x in ((0, k * INNER), (2, k * OUTER)):
                w = function(order, x)
                lower = -kv(order - 1, x) if function is kv else function(order - 1, x)
                slope = lower - order / x * w
                if i == 0:
                    rows[:2, j] = w, slope
                    continue
                # radial moment and Kirchhoff's shear; ∇²w = -sign k² w
                rows[2, j] = -sign * w - (1 - poisson) * (slope / x - order**2 * w / x**2)
                rows[3, j] = -sign * slope - (1 - poisson) * order**2 / x**2 * (slope - w / x)
        return la.det(rows / np.abs(rows).max(axis=0))

    trial = np.linspace(5.0, 40.0, 400)
    values = [determinant(k) for k in trial]
    at = next(i for i in range(len(trial)) if values[i] * values[i + 1] < 0.0)
    root = brentq(determinant, trial[at], trial[at + 1], xtol=1e-11)
    rigidity = MODULUS * thickness_m**2 / (12.0 * (1.0 - poisson**2) * DENSITY)
    return root**2 * np.sqrt(rigidity) / (2.0 * np.pi)


def plate_hz(level, thickness_m, poisson, orders, size_m, degree=3, corner_m=None):
    """Lowest frequency of every order of the plate by its nodal diameters."""
    ring = Section(
        name="plate", start_m=0.0, end_m=thickness_m, inner_radius_m=(INNER, INNER),
        outer_radius_m=(OUTER, OUTER), material=material(poisson),
    )  # fmt: skip
    bore = Interface(name="bore", kind="inner", coupling="rigid", start_m=0.0, end_m=thickness_m)
    body = Body(name="plate", sections=(ring,), interfaces=(bore,))
    make = mesh_revolved if level == "solid" else mesh_meridian
    size = MeshSize(size_m=size_m, corner_size_m=corner_m or size_m)
    return lowest_hz(body, make(body, size), orders, degree)


def lowest_hz(body, mesh, indices, degree, speeds_rad_s=(0.0,), count=1):
    """Frequencies (index, speed, mode) at rest or at speed, the bore held."""
    request = CyclicRequest(
        level="solid" if mesh.dimension == 3 else "harmonic", indices=tuple(indices),
        held=("bore",), degree=degree, modes=count + 3, maximum_speed_rad_s=max(speeds_rad_s),
    )  # fmt: skip
    reduced, _ = reduce_indices(body, mesh, MPI.COMM_SELF, request)
    found = nd.nodal_diameter_modes(reduced, np.array(speeds_rad_s), count)
    return np.array([found.family(h, "backward").frequency_hz for h in indices])


def test_kirchhoff_plate_is_that_of_the_literature():
    """Hz, from tables of the thin plate 0.001 m thick."""
    known = (79.409, 81.028, 89.649, 113.173)
    own = [kirchhoff_hz(n, 0.3, 1e-3) for n in range(4)]
    np.testing.assert_allclose(own, known, rtol=1e-5)


@pytest.mark.parametrize("level", ["solid", "harmonic"])
def test_plate_without_poissons_effect_is_thin_to_second_order(level):
    """Umbrella mode: (f / f_Kirchhoff - 1) ~ thickness², whose next term is 1 % of it here."""
    off = [
        plate_hz(level, t, 0.0, (0,), 2.0 * t)[0, 0, 0] / kirchhoff_hz(0, 0.0, t) - 1.0
        for t in (0.01, 0.005)
    ]
    assert off[0] < off[1] < 0.0
    assert np.log2(off[0] / off[1]) == pytest.approx(2.0, abs=0.03)
    # the limit of both: what is left of the fourth power
    assert abs(4.0 * off[1] - off[0]) / 3.0 < 5e-5


@pytest.mark.verify
@pytest.mark.parametrize("level", ["solid", "harmonic"])
def test_clamped_plate_in_the_limit_of_no_thickness(level):
    """c + a t + b t² through three thicknesses has no c, for 0 to 3 nodal diameters.

    The term of t³ that is left out grows with the number of waves: (t / wavelength)³.
    """
    thickness = np.array([0.01, 0.005, 0.0025])
    orders = (0, 1, 2, 3)
    off = [
        plate_hz(level, t, 0.3, orders, 2.0 * t)[:, 0, 0]
        / [kirchhoff_hz(n, 0.3, t) for n in orders]
        - 1.0
        for t in thickness
    ]
    limit, linear, _ = np.linalg.solve(np.vander(thickness, increasing=True), np.array(off))
    assert (np.abs(limit) < [1.5e-4, 1.5e-4, 2e-4, 5e-4]).all()
    # a clamped edge stiffens, a free one that takes torsion softens
    assert linear[0] > 0.0 > linear[3]


@pytest.mark.verify
def test_plate_errors_fall_with_the_mesh():
    """Umbrella mode of a thick plate: the corners of the clamped bore, r^0.711, rule in the end.

    Exponent of a corner of 90° with one face held and one free at ν = 0.3 (Williams 1952).
    """
    exact = plate_hz("harmonic", 0.02, 0.3, (0,), 0.01, degree=4, corner_m=2e-5)[0, 0, 0]
    errors = [
        plate_hz("solid", 0.02, 0.3, (0,), size, degree=2)[0, 0, 0] / exact - 1.0
        for size in (0.02, 0.01, 0.005)
    ]
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert min(errors) > 0.0
    # twice the exponent, and more as long as the wave itself costs something
    assert rates[0] > rates[1] > 1.4


def beam_rates(eta, hub, count=1):
    """Flap frequencies of a rotating uniform cantilever in √(EI / ρAL⁴), by Rayleigh and Ritz.

    `eta`: speed in the same unit; `hub`: radius of the root over the length.
    """
    x = Polynomial([0.0, 1.0])
    basis = [
        x * x * Polynomial(Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial).coef)
        for k in range(9)
    ]
    tension = Polynomial([hub + 0.5, -hub, -0.5])

    def over_length(p):
        return p.integ()(1.0) - p.integ()(0.0)

    stiffness = [
        [
            over_length(a.deriv(2) * b.deriv(2) + eta**2 * tension * a.deriv() * b.deriv())
            for b in basis
        ]
        for a in basis
    ]
    mass = [[over_length(a * b) for b in basis] for a in basis]
    return np.sqrt(la.eigh(stiffness, mass, eigvals_only=True)[:count])


def test_rotating_beam_is_that_of_the_literature():
    eta = (0.0, 1.0, 2.0, 4.0, 12.0)
    known = {
        0.0: ((3.516015, 3.681647, 4.137320, 5.585001, 13.170150),
              (22.034492, 22.181011, 22.614922, 24.273349, 37.603112)),
        1.0: ((3.516015, 3.888824, 4.833689, 7.475048, 19.721542),),
    }  # fmt: skip
    for hub, rows in known.items():
        found = np.array([beam_rates(e, hub, 2) for e in eta]).T
        for own, row in zip(found, rows, strict=False):
            np.testing.assert_allclose(own, row, rtol=1e-6)


def blade_rates(slenderness, etas, hub=1.0, length_m=0.2, poisson=0.0):
    """Flap and lag (speed, 2) of square blades on a ring that hardly gives, unit as of the beam.

    `slenderness`: length over side. `hub`: radius of the root over the length.
    """
    side, radius = length_m / slenderness, hub * length_m
    ring = Section(
        name="hub", start_m=-0.6 * side, end_m=0.6 * side,
        inner_radius_m=(radius - 0.5 * side,) * 2, outer_radius_m=(radius,) * 2,
        material=material(0.0, "hub", stiffer=1e4, lighter=100.0),
    )  # fmt: skip
    bore = Interface(
        name="bore", kind="inner", coupling="rigid", start_m=-0.6 * side, end_m=0.6 * side
    )
    blades = Blade(
        name="blades", on="hub", count=12, length_m=length_m, chord_m=(side, side),
        thickness_m=(side, side), material=material(poisson),
    )  # fmt: skip
    body = Body(name="rotor", sections=(ring,), interfaces=(bore,), features=(blades,))
    mesh = mesh_sector(body, MeshSize(size_m=side, corner_size_m=side, growth=1.0))
    unit = np.sqrt(MODULUS * side**2 / (12.0 * DENSITY * length_m**4))
    hz = lowest_hz(body, mesh, (0,), 3, tuple(unit * np.array(etas)), count=2)[0]
    # tension counts in both planes, and the spin softens motion in its own plane
    return np.sort(2.0 * np.pi * hz / unit, axis=1)[:, ::-1]


@pytest.mark.verify
def test_slender_blades_turn_like_beams():
    """Flap and lag over the speed come down to Bernoulli's beam as (side / length)²."""
    etas = (0.0, 2.0, 4.0)
    flap = np.array([beam_rates(e, 1.0)[0] for e in etas])
    exact = np.column_stack([flap, np.sqrt(flap**2 - np.square(etas))])
    off = np.array([blade_rates(s, etas) / exact - 1.0 for s in (10.0, 20.0)])
    assert (off[0] < off[1]).all()
    assert (off[1] < 0.0).all()
    np.testing.assert_allclose(np.log2(off[0] / off[1]), 2.0, atol=0.05)
    # extrapolated; the next power is (1 / 20)⁴ of a few tens
    np.testing.assert_allclose((4.0 * off[1] - off[0]) / 3.0, 0.0, atol=1.5e-4)


@pytest.mark.verify
@pytest.mark.parametrize("hub", [0.25, 3.0])
def test_slender_blades_on_hubs_of_other_radii(hub):
    etas = (0.0, 1.0, 3.0)
    flap = np.array([beam_rates(e, hub)[0] for e in etas])
    exact = np.column_stack([flap, np.sqrt(flap**2 - np.square(etas))])
    off = np.array([blade_rates(s, etas, hub) / exact - 1.0 for s in (15.0, 30.0)])
    np.testing.assert_allclose(np.log2(off[0] / off[1]), 2.0, atol=0.05)
    np.testing.assert_allclose((4.0 * off[1] - off[0]) / 3.0, 0.0, atol=1.5e-4)
