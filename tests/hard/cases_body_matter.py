"""Nearly incompressible, very soft and very heavy materials against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from builders_body import even, free_hz, held_hz, nearest_error, tube
from references_body import roots, timoshenko_free_hz
from shapes import STEEL, plane, section

from solidwhirl.geometry import Body
from solidwhirl.rotordyn import check_superelement

RUBBER = replace(STEEL, name="rubber", poissons_ratio=0.499)
SOFT = replace(STEEL, name="soft", youngs_modulus_pa=2e5, density_kg_per_m3=0.78)
HEAVY = replace(STEEL, name="heavy", density_kg_per_m3=7.8e7)
SHEAR = 2e11 / 2.6


def _incompressible(level: str, degree: int) -> float:
    """First bending frequency of a free shaft, L/D = 10, against order 5 of the meridian."""
    body = tube(1.0, 0.0, 0.05, material=RUBBER)
    fine = free_hz(body, "harmonic", even(0.04), components=(), degree=5)[0]
    size = even(0.05) if level == "harmonic" else even(0.06, 12)
    return abs(float(free_hz(body, level, size, components=(), degree=degree)[0] / fine) - 1.0)


def _incompressible_beam() -> float:
    """A slender one, L/D = 50, against Timoshenko's beam."""
    body = tube(1.0, 0.0, 0.01, material=RUBBER)
    found = free_hz(body, "harmonic", even(0.02), components=(), degree=4)[0]
    return abs(float(found) / timoshenko_free_hz(1.0, 0.01, RUBBER) - 1.0)


def _incompressible_torsion(level: str) -> float:
    """c/2L knows no Poisson's ratio but through G."""
    body = tube(0.2, 0.0, 0.05, material=RUBBER)
    size = even(0.02, 12)
    request = {"orders": (0,), "components": (), "modes": 4 if level == "harmonic" else 2}
    request["degree"] = 3 if level == "harmonic" else 2
    exact = np.sqrt(2e11 / (2.0 * 1.499) / 7800.0) / 0.4
    return nearest_error(held_hz(body, level, size, **request), np.array([exact]))


def _soft_ring() -> Body:
    """Hub and disk of steel, joined by a ring a million times softer and 1e4 times lighter."""
    return Body(
        name="isolated",
        sections=(
            section("hub", 0.0, 0.05, 0.0, 0.05, STEEL),
            section("ring", 0.0, 0.05, 0.05, 0.08, SOFT),
            section("disk", 0.0, 0.05, 0.08, 0.15, STEEL),
        ),
    )


def _soft_torsion(level: str) -> float:
    """Two rigid bodies on a ring in shear: k = 4π G b / (1/r1² - 1/r2²)."""
    stiffness = 4.0 * np.pi * SHEAR * 1e-6 * 0.05 / (1.0 / 0.05**2 - 1.0 / 0.08**2)
    hub = 7800.0 * np.pi * 0.05 * 0.05**4 / 2.0
    disk = 7800.0 * np.pi * 0.05 * (0.15**4 - 0.08**4) / 2.0
    exact = np.sqrt(stiffness * (1.0 / hub + 1.0 / disk)) / (2.0 * np.pi)
    size = even(0.01) if level == "harmonic" else even(0.05, 12)
    request = {"orders": (0,), "components": (), "modes": 4 if level == "harmonic" else 2}
    return nearest_error(held_hz(_soft_ring(), level, size, **request), np.array([exact]))


def _soft_lateral(level: str) -> float:
    """The lowest lateral modes scale with the root of the soft modulus: 1e-6 against 1e-5."""
    size = even(0.01) if level == "harmonic" else even(0.05, 8)
    stiffer = replace(SOFT, youngs_modulus_pa=2e6)
    ring = _soft_ring()
    parts = tuple(replace(s, material=stiffer) if s.name == "ring" else s for s in ring.sections)
    found = [
        free_hz(body, level, size, components=(), modes=2)[:2]
        for body in (ring, Body(name="ring", sections=parts))
    ]
    return float(np.abs(found[0] / found[1] * np.sqrt(10.0) - 1.0).max())


def _soft_invariants(level: str) -> float:
    """Invariants of the superelement that fail."""
    from builders_body import reduced

    size = even(0.01) if level == "harmonic" else even(0.05, 8)
    spin = {"maximum_speed_rad_s": 1.0, "centrifugal": True, "gyroscopic": True}
    element = reduced(_soft_ring(), level, size, components=(), modes=2, **spin)[0]
    return float(sum(not i.passed for i in check_superelement(element)))


def _heavy_disk() -> Body:
    """Shaft held at z = 0 with a disk at its end that is 1e4 times denser."""
    return Body(
        name="heavy",
        sections=(
            section("shaft", 0.0, 0.4, 0.0, 0.02, STEEL),
            section("disk", 0.4, 0.41, 0.0, 0.02, HEAVY),
        ),
        interfaces=(plane("wall", 0.0, "rigid"),),
    )


def _heavy_torsion(level: str) -> float:
    """Two rods in a row, equal torque at the joint: cos cos / c1 = sin sin / c2, exact."""
    c1, c2 = np.sqrt(SHEAR / 7800.0), np.sqrt(SHEAR / 7.8e7)

    def torque(w: float) -> float:
        # shaft: θ = sin(w z/c1); disk: θ ~ cos(w (z_end - z)/c2); continuity and equal G θ'
        left = np.cos(w * 0.4 / c1) * np.cos(w * 0.01 / c2) / c1
        right = np.sin(w * 0.4 / c1) * np.sin(w * 0.01 / c2) / c2
        return float(left - right)

    exact = roots(torque, 10.0, 2e3, 1) / (2.0 * np.pi)
    size, degree = (even(0.05), 4) if level == "harmonic" else (even(0.1, 6), 2)
    request = {"orders": (0,), "components": ("uz", "rz"), "modes": 6, "degree": degree}
    if level == "solid":
        request["modes"] = 2
    return nearest_error(held_hz(_heavy_disk(), level, size, **request), exact)


def _heavy_bending(level: str) -> float:
    """Disk on a massless cantilever with shear, plus 33/140 of the shaft (Rayleigh)."""
    inertia, area = np.pi * 0.02**4 / 4.0, np.pi * 0.02**2
    shear = 6.0 * 1.3 / (7.0 + 1.8) * SHEAR * area
    mass = HEAVY.density_kg_per_m3 * area * 0.01
    tilt = mass * (0.02**2 / 4.0 + 0.01**2 / 12.0)
    length, offset, e = 0.4, 0.005, 2e11
    # flexibility of the shaft's end to (force, moment), then at the disk's centre
    end = np.array(
        [
            [length**3 / (3 * e * inertia) + length / shear, length**2 / (2 * e * inertia)],
            [length**2 / (2 * e * inertia), length / (e * inertia)],
        ]
    )
    arm = np.array([[1.0, offset], [0.0, 1.0]])
    flexibility = arm @ end @ arm.T
    heavy = np.diag([mass + 33.0 / 140.0 * 7800.0 * area * length, tilt])
    exact = np.sqrt(1.0 / np.linalg.eigvals(flexibility @ heavy).real.max()) / (2.0 * np.pi)
    size, degree = (even(0.02), 3) if level == "harmonic" else (even(0.06, 8), 2)
    request = {"components": ("ux", "uy", "rx", "ry"), "degree": degree}
    return nearest_error(held_hz(_heavy_disk(), level, size, **request)[:1], np.array([exact]))
