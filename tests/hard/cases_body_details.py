"""Tiny fillets, slices, steps and interfaces that nearly touch, folded elements, other units."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from builders_body import even, free_hz, reduced, tube
from builders_more import smallest_jacobians
from shapes import STEEL, plane, section

from solidwhirl.geometry import Body, Interface, Section
from solidwhirl.meshing import MeshSize
from solidwhirl.meshing.own.quality import scaled_jacobians, straighten
from solidwhirl.rotordyn import Superelement, check_superelement

GRADED = MeshSize(size_m=0.02, corner_size_m=1e-4, growth=0.7)


def _rotor(*interfaces: Interface, fillet_m: float = 0.0, step_m: float = 0.0) -> Body:
    """Shaft of radius 0.02 m with a disk; a step of this length on the disk's shoulder."""
    sections: list[Section] = [
        section("shaft", 0.0, 0.4, 0.0, 0.02, STEEL),
        section("disk", 0.145, 0.175, 0.02, 0.15, STEEL),
    ]
    if step_m:
        sections.append(section("step", 0.175, 0.175 + step_m, 0.02, 0.1, STEEL))
    return Body(
        name="rotor",
        sections=tuple(sections),
        interfaces=interfaces,
        fillet_radius_m=fillet_m,
    )


def _tiny_fillet() -> float:
    """Fillets of 1e-3 of the shaft's radius against sharp corners with elements of their size."""
    size = MeshSize(size_m=0.02, corner_size_m=2e-5, growth=0.5)
    found = [
        free_hz(_rotor(fillet_m=r), "harmonic", size, components=(), degree=3, modes=2)[0]
        for r in (0.0, 2e-5)
    ]
    return abs(float(found[1] / found[0]) - 1.0)


def _slices(level: str, part: float) -> float:
    """Shaft cut into slices of this part of its neighbours, against the shaft in one piece."""
    length, radius = 0.4, 0.02
    size = even(0.02) if level == "harmonic" else even(0.1, 8)
    ends = np.array([0.0, 0.1, 0.1 + 0.1 * part, 0.2, 0.2 + 0.1 * part, length])
    pieces = tuple(
        section(f"part {k}", a, b, 0.0, radius, replace(STEEL, name=f"steel {k % 2}"))
        for k, (a, b) in enumerate(pairwise(ends))
    )
    body = Body(name="slices", sections=pieces)
    found = free_hz(body, level, size, components=(), modes=2)[0]
    exact = free_hz(tube(length, 0.0, radius), "harmonic", even(0.01), components=(), degree=4)[0]
    return abs(float(found / exact) - 1.0)


def _step(level: str, part: float) -> float:
    """A step on a shoulder of this part of the disk's width, against none."""
    degree = 3 if level == "harmonic" else 2
    found = [
        free_hz(_rotor(step_m=0.03 * p), level, GRADED, components=(), modes=2, degree=degree)[0]
        for p in (part, 0.0)
    ]
    return abs(float(found[0] / found[1]) - 1.0)


def _near_invariants(level: str) -> float:
    """Invariants that fail, with interfaces 1e-3 of the length apart."""
    found = check_superelement(_with_near_interfaces(level, 1e-3))
    return float(sum(not i.passed for i in found))


def _with_near_interfaces(level: str, part: float) -> Superelement:
    size = even(0.02) if level == "harmonic" else even(0.1, 8)
    body = tube(0.4, 0.0, 0.02, plane("a", 0.2), plane("b", 0.2 + part * 0.4))
    spin = {"maximum_speed_rad_s": 300.0, "centrifugal": True, "gyroscopic": True}
    return reduced(body, level, size, modes=6, **spin)[0]


def _bent_element() -> float:
    """Elements with an edge bent inwards: folded ones taken for good, or left folded."""
    wrong = 0
    for bend in np.linspace(0.05, 0.6, 23):
        points = np.array([[0, 0], [1, 0], [0, 1], [0.5, bend], [0.5, 0.5], [0, 0.5]], dtype=float)
        cells = np.arange(6)[None, :]
        folded = smallest_jacobians(points, cells)[0] <= 0.0
        wrong += int(folded and scaled_jacobians(points, cells)[0] > 0.0)
        moved, _ = straighten(points, cells, 0.02)
        wrong += int(smallest_jacobians(moved, cells)[0] <= 0.0)
    return float(wrong)


def _slab(level: str) -> float:
    """A shaft clamped in its middle by a rigid slab: its ends bend as cantilevers."""
    slab = Interface(name="hub", kind="slab", coupling="rigid", start_m=0.3, end_m=0.5)
    size = (
        MeshSize(size_m=0.02, corner_size_m=0.001, growth=0.5)
        if level == "harmonic"
        else even(0.1, 8)
    )
    body = tube(0.8, 0.0, 0.01, slab)
    request = {"components": ("ux", "uy", "rx", "ry"), "modes": 2}
    found = reduced(body, level, size, **request)[0].fixed_interface_frequencies_hz
    area, inertia, e = np.pi * 1e-4, np.pi * 1e-8 / 4.0, 2e11
    exact = 1.875104068711961**2 / 0.3**2 * np.sqrt(e * inertia / (7800.0 * area)) / (2.0 * np.pi)
    return float(np.abs(found[:4] / exact - 1.0).max())
