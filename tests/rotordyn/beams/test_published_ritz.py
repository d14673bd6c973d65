"""Published one-mode (Ritz) models: the beam matrices projected on the shape of the publication.

Lalanne and Ferraris, Rotordynamics Prediction in Engineering, and the coaxial twin rotor of
Ferraris, Maisonneuve and Lalanne 1996 (J. Sound Vib. 195) as given by Müller and Hennings. Both
take sin(πz/L) along the inner shaft; the outer shaft of the twin rotor follows as a rigid body.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from rotors import STEEL, connect, ground, steel_shaft, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.modes.modal_truncation import project_system
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response

RPM = np.pi / 30.0
LENGTH = 0.4
RADIUS = 0.01


def sine(z):
    return np.sin(np.pi * z / LENGTH), np.pi / LENGTH * np.cos(np.pi * z / LENGTH)


def shaft(name, nodes, outer, inner, disk):
    """Beam with an interface at every node, so that its coordinates are deflections and slopes."""
    held = {f"{k}": z for k, z in enumerate(nodes)}
    return steel_shaft(name, nodes, outer, held, [disk], inner)


def planes(element, deflection, slope):
    """Coordinates of a shape in the plane of x and in that of y, shape (n, 2)."""
    motion = np.zeros((element.size, 2))
    for k, (w, theta) in enumerate(zip(deflection, slope, strict=True)):
        motion[element.interface_index(f"{k}", "ux"), 0] = w
        motion[element.interface_index(f"{k}", "ry"), 0] = theta
        motion[element.interface_index(f"{k}", "uy"), 1] = w
        motion[element.interface_index(f"{k}", "rx"), 1] = -theta
    return motion


def projected(rotors, bearings, shapes):
    """System restricted to the shapes given per body, shape (n_body, 2)."""
    system = rd.assemble(rotors, bearings)
    motion = np.vstack([shapes[name] for name in rotors])
    basis = np.linalg.lstsq(system.transformation, motion, rcond=None)[0]
    np.testing.assert_allclose(system.transformation @ basis, motion, atol=1e-12)
    return project_system(system, basis)


# Lalanne and Ferraris, chapter 2: shaft of radius 10 mm, disk of radius 150 mm and width 30 mm at
# L/3, pinned ends, optionally a spring of 5e5 N/m at 2L/3 in one direction.


@cache
def single_disk(spring=0.0):
    mass = STEEL[2] * np.pi * (0.15**2 - RADIUS**2) * 0.03
    polar = mass / 2 * (0.15**2 + RADIUS**2)
    disk = (LENGTH / 3, mass, polar, polar / 2 + mass / 12 * 0.03**2)
    nodes = np.linspace(0.0, LENGTH, 121)
    element = shaft("rotor", nodes, RADIUS, 0.0, disk)
    bearings = (ground("rotor", "80", spring, 0.0),) if spring else ()
    rotors = {"rotor": turning(element)}
    return projected(rotors, bearings, {"rotor": planes(element, *sine(nodes))})


def test_single_disk_rotor_has_the_matrices_of_the_book():
    system = single_disk()
    # Printed with four digits.
    np.testing.assert_allclose(system.mass, 14.29 * np.eye(2), atol=0.006)
    np.testing.assert_allclose(system.stiffness, 1.195e6 * np.eye(2), atol=600.0)
    np.testing.assert_allclose(system.gyroscopic, [[0, 2.871], [-2.871, 0]], atol=6e-4)


@pytest.mark.parametrize(
    ("spring", "rpm"), [(0.0, [2520, 3089]), (5e5, [2642, 3377])], ids=["isotropic", "anisotropic"]
)
def test_single_disk_rotor_critical_speeds(spring, rpm):
    found = rd.critical_speeds(single_disk(spring), speed_max_rad_s=1e4 * RPM)
    assert [c.whirl for c in found] == ["backward", "forward"]
    # Printed in whole rpm; the slope is linear in 120 elements, which costs 2e-5.
    np.testing.assert_allclose([c.speed_rad_s / RPM for c in found], rpm, atol=0.6)


# Coaxial twin rotor: inner shaft of radius 20 mm, disk at L/3; outer shaft 30/35 mm from C = 2L/3,
# where it is pinned to the inner one and a spring of 8e6 N/m acts in x, to D = L, pinned to the
# ground, with a disk at 13L/15. Positions are inferred from the printed numbers.

DISK_1 = (LENGTH / 3, 16.2464, 0.186022, 0.0942293)
DISK_2 = (13 * LENGTH / 15, 6.45079, 0.0362051, 0.0185863)


@pytest.fixture(scope="module")
def twin_ritz():
    nodes, outer_nodes = np.linspace(0.0, LENGTH, 121), np.linspace(LENGTH * 2 / 3, LENGTH, 11)
    inner = shaft("inner", nodes, 0.02, 0.0, DISK_1)
    outer = shaft("outer", outer_nodes, 0.035, 0.03, DISK_2)
    at_joint = sine(LENGTH * 2 / 3)[0]
    follow = at_joint * (LENGTH - outer_nodes) / (LENGTH / 3)
    shapes = {
        "inner": planes(inner, *sine(nodes)),
        "outer": planes(outer, follow, np.full(11, -at_joint / (LENGTH / 3))),
    }
    spring = connect("C", "inner.80", stiffness=(8e6, 0.0))
    rotors = {"inner": turning(inner), "outer": turning(outer, -1.0)}
    return projected(rotors, (spring,), shapes)


def test_twin_rotor_branches(twin_ritz):
    """m² ω⁴ − [m (k_x + k_y) + a² Ω²] ω² + k_x k_y = 0, tabulated with two decimals."""
    lower, upper = (
        [166.59, 166.35, 165.66, 164.60, 161.70],
        [190.93, 191.21, 192.01, 193.25, 196.71],
    )
    speeds = np.array([0, 4000, 8000, 12000, 20000]) * RPM
    diagram = rd.campbell(twin_ritz, speeds, branch_count=2)
    np.testing.assert_allclose(diagram.frequency_hz, [lower, upper], atol=0.012)


def test_twin_rotor_peaks(twin_ritz):
    found = rd.critical_speeds(twin_ritz, speed_max_rad_s=20000 * RPM)
    # Printed are 165.32 and 192.83 Hz, which no one-mode model meets together: each alone asks for
    # another gyroscopic moment. The closed form of this layout gives 165.19 and 193.10 Hz.
    np.testing.assert_allclose([c.frequency_hz for c in found], [165.19, 193.10], atol=0.012)
    np.testing.assert_allclose([c.frequency_hz for c in found], [165.32, 192.83], rtol=1.5e-3)


def test_twin_rotor_response_to_unbalance(twin_ritz):
    """1e-7 kg m on disk 1: amplitudes there, x in phase with the unbalance, y a quarter later."""
    omega = 2 * np.pi * np.array([100.0, 150.0, 180.0, 250.0])
    at_disk = sine(LENGTH / 3)[0]
    load = (1e-7 * omega**2 * at_disk)[:, None] * np.array([1.0, -1.0j])
    found = at_disk * harmonic_response(twin_ritz, omega, omega, load[..., None]).displacement
    tabulated = [[1.557, 2.354], [4.878, 16.831], [39.75, -9.03], [-12.00, -9.36]]
    # Ten times closer to a resonance means ten times the error of the frequency (3e-5).
    np.testing.assert_allclose(1e9 * found[..., 0] * [1.0, 1.0j], tabulated, rtol=2e-3, atol=1e-12)
