"""Thin drum, thin disk, needle shaft and solid shaft against closed forms."""

from __future__ import annotations

import numpy as np
from builders_body import even, free_hz, held_hz, nearest_error, reduced, tube
from references_body import free_plate_hz, spinning_plate_hz, timoshenko_free_hz, torsion_hz
from shapes import STEEL

from solidwhirl.meshing import MeshSize

# A drum of radius 1 m and wall 1/200 of it, a disk of radius 0.2 m and thickness 1/200 of it.
# On the solid level the disk is 1/50: a plate of 1/200 takes more tetrahedra than a test may have.
WALL, DISK, THIN, THICKER = 0.005, 0.2, 0.001, 0.004
TORSION = float(np.sqrt(2e11 / 2.6 / 7800.0))
# Flat tetrahedra of 30 times their thickness: one through the wall.
FLAT = MeshSize(size_m=0.15, corner_size_m=0.15, through_thickness=0.05, around=24)
FLAT_DISK = MeshSize(size_m=0.03, corner_size_m=0.03, through_thickness=0.2, around=24)


def _drum_torsion() -> float:
    request = {"orders": (0,), "components": (), "modes": 3}
    found = held_hz(tube(2.0, 1.0 - WALL / 2, 1.0 + WALL / 2), "harmonic", even(0.05), **request)
    return nearest_error(found, np.array([TORSION / 4.0]))


def _drum_bending_energy() -> float:
    """Rayleigh, no extension, n = 2: ω² = E h² n²(n²-1)² / (12 ρ R⁴ (1-ν²) (n²+1))."""
    body = tube(0.5, 1.0 - WALL / 2, 1.0 + WALL / 2)
    found = held_hz(body, "harmonic", even(0.05), orders=(2,), components=(), degree=3, modes=3)
    squared = 2e11 * WALL**2 * 36.0 / (12.0 * 7800.0 * 0.91 * 5.0)
    return nearest_error(found[:2], np.array([np.sqrt(squared) / (2.0 * np.pi)]))


def _hoop_strain(level: str) -> float:
    """Thin ring: σ = ρ Ω² r² at the mean radius; bore of a flat ring (plane stress) in full."""
    a, b, nu, speed = 1.0 - WALL / 2, 1.0 + WALL / 2, 0.3, 50.0
    size = even(WALL / 2) if level == "harmonic" else FLAT
    body = tube(WALL, a, b)
    spin = {"maximum_speed_rad_s": speed, "centrifugal": True}
    strain = reduced(body, level, size, components=(), modes=1, **spin)[1].hoop_strain
    hoop = 7800.0 * speed**2 / 4.0 * ((3.0 + nu) * b**2 + (1.0 - nu) * a**2)
    return abs(strain * 2e11 / hoop - 1.0)


def _disk(level: str, order: int) -> float:
    size = even(0.01) if level == "harmonic" else FLAT_DISK
    thin = THIN if level == "harmonic" else THICKER
    request = {"orders": (order,), "components": (), "modes": 2, "degree": 2}
    if level == "harmonic":
        request |= {"degree": 3, "modes": 3}
    found = held_hz(tube(thin, 0.0, DISK), level, size, **request)
    return nearest_error(found[:4], np.array([free_plate_hz(order, DISK, thin, STEEL)]))


def _spinning_disk() -> float:
    speed = 500.0
    request = {"orders": (0,), "components": (), "modes": 2}
    spin = {"maximum_speed_rad_s": speed, "centrifugal": True, "gyroscopic": True}
    element = reduced(tube(THIN, 0.0, DISK), "harmonic", even(0.01), **request, **spin)[0]
    k = element.stiffness + speed**2 * (element.stress_stiffening - element.spin_softening)
    values = np.linalg.eigvals(np.linalg.solve(element.mass, k)).real
    found = np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)
    return nearest_error(found, np.array([spinning_plate_hz(DISK, THIN, STEEL, speed)]))


NEEDLE = {
    "harmonic": even(0.02),
    "solid": even(0.04, 6),
}


def _needle(level: str) -> float:
    degree = 3 if level == "harmonic" else 2
    found = free_hz(tube(1.0, 0.0, 0.005), level, NEEDLE[level], components=(), degree=degree)
    return abs(found[0] / timoshenko_free_hz(1.0, 0.005, STEEL) - 1.0)


def _needle_torsion() -> float:
    request = {"orders": (0,), "components": (), "degree": 3}
    found = held_hz(tube(1.0, 0.0, 0.005), "harmonic", NEEDLE["harmonic"], **request)
    return nearest_error(found, TORSION * np.arange(1, 3) / 2.0)


def _solid_shaft_torsion(level: str) -> float:
    """All torsional modes below 55 kHz of a cylinder as long as its diameter, with nodes inside."""
    request = {"orders": (0,), "components": (), "modes": 24, "degree": 4}
    size, top = even(0.02), 55e3
    if level == "solid":
        request |= {"modes": 3, "degree": 2}
        size, top = even(0.02, 12), 20e3
    found = held_hz(tube(0.1, 0.0, 0.05), level, size, **request)
    return nearest_error(found, torsion_hz(0.1, 0.05, STEEL, top))


def _solid_shaft_spurious() -> float:
    """Modes up to 60 kHz that elements of order 4 and 2 do not share, n = 0, 1, 2."""
    body, odd = tube(0.1, 0.0, 0.05), 0
    for order in (0, 1, 2):
        request = {"orders": (order,), "components": (), "modes": 16}
        few = held_hz(body, "harmonic", even(0.01), degree=2, **request)
        many = held_hz(body, "harmonic", even(0.015), degree=4, **request)
        few, many = few[few < 6e4], many[many < 6e4]
        odd += abs(len(few) - len(many)) if len(few) != len(many) else 0
        n = min(len(few), len(many))
        odd += int(np.sum(np.abs(few[:n] / many[:n] - 1.0) > 2e-3))
    return float(odd)


def _solid_shaft_lateral() -> float:
    """A stocky solid cylinder, n = 1: the solid level against the harmonic one."""
    body = tube(0.1, 0.0, 0.05)
    fine = free_hz(body, "harmonic", even(0.02), components=(), degree=4)[:2]
    found = free_hz(body, "solid", even(0.03, 12), components=(), modes=3)[:2]
    return float(np.abs(found / fine - 1.0).max())
