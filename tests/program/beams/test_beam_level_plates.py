"""Annular plates of the beam level against plate theory in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize as opt
import scipy.special as sp

from solidwhirl.beams.plates import Edge, line_of, plate_matrices, spin_of
from solidwhirl.beams.profile import Cell, Place, Plate, Slice
from solidwhirl.geometry import Material

NU = 0.3
METAL = Material(name="metal", density_kg_per_m3=7800.0, youngs_modulus_pa=2e11, poissons_ratio=NU)
CLAMPED = Edge(root=np.inf)


def plate_of(inner, outer, width):
    cell = Cell(
        inner_m=inner, outer_m=outer, slices=(Slice(start_m=0.0, end_m=width, material=METAL),)
    )
    return Plate(cells=(cell,), inner=Place(0, 0.5 * width), outer=None)


def rigidity(width):
    return METAL.youngs_modulus_pa * width**3 / 12.0 / (1.0 - NU**2)


def frequency_equation(root, ratio):
    """Determinant of Kirchhoff's plate with one nodal diameter, clamped at r = ratio, free at 1."""
    functions = [(sp.jv, sp.jvp, -1), (sp.yv, sp.yvp, -1), (sp.iv, sp.ivp, 1), (sp.kv, sp.kvp, 1)]
    matrix = np.zeros((4, 4))
    for k, (value, rate, sign) in enumerate(functions):
        w, w1 = value(1, root), root * rate(1, root)
        matrix[:, k] = (
            value(1, root * ratio),
            rate(1, root * ratio),
            root**2 * rate(1, root, 2) + NU * (w1 - w),
            sign * root**3 * rate(1, root) - (1.0 - NU) * (w1 - w),
        )
    return np.linalg.det(matrix / np.abs(matrix).max(axis=0))


@pytest.mark.parametrize("ratio", [0.1, 0.3, 0.5, 0.7])
def test_one_nodal_diameter_clamped_free(ratio):
    # λ² = ω a² √(ρh/D); the frequency equation is that of Vogel and Skinner (1965), case of the
    # clamped hub and free rim; its roots are 3.478, 6.552, 13.290, 37.50, as Leissa tabulates.
    grid = np.linspace(1.5, 7.0, 400)
    signs = [frequency_equation(x, ratio) for x in grid]
    at = next(k for k in range(399) if signs[k] * signs[k + 1] < 0.0)
    exact = opt.brentq(frequency_equation, grid[at], grid[at + 1], args=(ratio,)) ** 2
    width = 1e-3
    plate = plate_matrices(plate_of(ratio, 1.0, width), "tilt", (CLAMPED, None))
    omega = 2.0 * np.pi * plate.frequencies_hz[0]
    found = omega * np.sqrt(METAL.density_kg_per_m3 * width / rigidity(width))
    # h/a = 1e-3: shear takes off 1e-5; the elements leave 1e-4 at the widest plate
    assert found == pytest.approx(exact, rel=2e-4)


def test_tilt_between_rigid_hub_and_rim():
    # f = A r + B r³ + C/r + D r ln r; the couple is 4π D_plate times the last coefficient
    # (Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, section 64).
    a, b, width = 0.1, 0.35, 1e-3
    rows = []
    for r in (a, b):
        rows.append([r, r**3, 1.0 / r, r * np.log(r)])
        rows.append([1.0, 3.0 * r**2, -1.0 / r**2, np.log(r) + 1.0])
    tilt = np.linalg.solve(np.array(rows), [0.0, 0.0, b, 1.0])
    plate = plate_of(a, b, width)
    found = plate_matrices(plate, "tilt", (CLAMPED, CLAMPED)).stiffness[:2, :2]
    # shear in a plate of h/a = 1e-2 is 1e-4 of bending
    assert abs(found[0, 0]) == pytest.approx(abs(4.0 * np.pi * rigidity(width) * tilt[3]), rel=3e-4)
    assert found[0, 1] == -found[0, 0]


def test_torsion_spring_and_root():
    # 4π G t / (1/a² − 1/b²): Lagrange elements of degree 4 meet 1/r to 1e-4
    a, b, width = 0.02, 0.15, 0.03
    plate = plate_of(a, b, width)
    shear = METAL.youngs_modulus_pa / 2.6
    found = plate_matrices(plate, "torsion", (CLAMPED, CLAMPED)).stiffness[0, 0]
    assert found == pytest.approx(4 * np.pi * shear * width / (a**-2 - b**-2), rel=1e-4)
    held = plate_matrices(plate, "tilt", (CLAMPED, CLAMPED)).stiffness[0, 0]
    loose = [
        plate_matrices(plate, "tilt", (Edge(root=k), CLAMPED)).stiffness[0, 0]
        for k in (1e3, 1e6, 1e9, 1e13)
    ]
    assert np.all(np.diff(loose) > 0.0)
    assert loose[-1] == pytest.approx(held, rel=1e-3)


@pytest.mark.parametrize("edges", [(CLAMPED, None), (None, CLAMPED), (CLAMPED, Edge(root=None))])
def test_rigid_motion_has_the_inertia_of_a_ring(edges):
    a, b, width = 0.02, 0.15, 0.03
    mass = METAL.density_kg_per_m3 * np.pi * (b**2 - a**2) * width
    polar = 0.5 * mass * (a**2 + b**2)
    diametral = 0.5 * polar + mass * width**2 / 12.0
    hub = Cell(inner_m=0.0, outer_m=a, slices=plate_of(a, b, width).cells[0].slices)
    found = plate_matrices(plate_of(a, b, width), "tilt", edges, rings=(hub, None))
    held = sum(edge is not None for edge in edges)
    one = np.zeros(len(found.mass))
    one[:held] = 1.0
    assert one @ found.mass @ one == pytest.approx(diametral, rel=1e-12)
    assert one @ found.gyroscopic @ one == pytest.approx(polar, rel=1e-12)
    assert np.abs(found.stiffness @ one).max() == 0.0
    moved = plate_matrices(plate_of(a, b, width), "shift", edges)
    one = np.zeros(len(moved.mass))
    one[:held] = 1.0
    assert one @ moved.mass @ one == pytest.approx(mass, rel=1e-12)
    assert abs(one @ moved.gyroscopic @ one) < 1e-12 * mass


def test_stiffening_cancels_softening_in_rigid_tilt_only():
    a, b, width = 0.02, 0.15, 0.005
    slices = plate_of(a, b, width).cells[0].slices
    hub = Cell(inner_m=0.0, outer_m=a, slices=slices)
    found = plate_matrices(plate_of(a, b, width), "tilt", (CLAMPED, None), rings=(hub, None))
    net = found.stiffening - found.softening
    assert abs(net[0, 0]) < 1e-12 * found.softening[0, 0]
    assert found.softening[0, 0] == pytest.approx(
        np.pi / 4.0 * METAL.density_kg_per_m3 * width * b**4, rel=1e-12
    )
    # bending is stiffened: in the rotating frame by more than the tilt's Ω²
    assert net[1, 1] > 0.0


def test_even_disk_has_the_centrifugal_stress_of_the_books():
    # solid disk: σr = σφ = (3 + ν)/8 ρ b² in its centre, hoop (1 − ν)/4 ρ b² at its rim
    # (Timoshenko and Goodier, Theory of Elasticity, section 32)
    a, b, width = 0.02, 0.15, 0.005
    plate = plate_of(a, b, width)
    hub = Cell(inner_m=0.0, outer_m=a, slices=plate.cells[0].slices)
    line = line_of(plate.cells)
    spin = spin_of(plate.cells, line, hub, None)
    # tension of the hub: π t ∫ (σr + σφ) r dr with σr + σφ = ρ/8 [2 (3 + ν) b² − 4 (1 + ν) r²]
    exact = np.pi * width * METAL.density_kg_per_m3 / 8.0
    exact *= (3.0 + NU) * b**2 * a**2 - (1.0 + NU) * a**4
    assert spin.edge_stiffening[0] == pytest.approx(exact, rel=1e-8)
