"""A body with every matrix of the format, and its frequencies from bare matrices by numpy alone."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
from springs import on_springs

from solidwhirl.rotordyn import (
    Disk,
    beam_superelement,
    modes_at_speed,
    rigid_superelement,
)

SPRINGS = {"a": (4e7, 6e7, 3e6), "b": (5e7, 5e7, 0.0)}
TORSION = 2e4
SPEED = 900.0
MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")


@cache
def body():
    """A shaft with a disk in all six motions, free, with Kgeo and S.

    A beam has neither. These are M + c K and M: they cancel in rigid motion and turn with the body,
    as those of a solid do, and Kgeo − S = c K is 0.2 % to some hundred % of K at the top speed.
    """
    stations = np.linspace(0.0, 0.9, 7)
    shaft = beam_superelement(
        "shaft",
        stations,
        0.025,
        0.0,
        (2.1e11, 0.3, 7850.0),
        {"a": 0.1, "b": 0.8, "tip": 0.9},
        [Disk(name="wheel", position_m=0.55, mass_kg=20.0, polar_kg_m2=0.4, diametral_kg_m2=0.22)],
        components=MOTIONS,
    )
    return dataclasses.replace(
        shaft,
        name="shaft one",
        stress_stiffening=shaft.mass + 2e-7 * shaft.stiffness,
        spin_softening=shaft.mass,
        maximum_speed_rad_s=2000.0,
    )


def tied():
    """A rigid casing with three interfaces: its coordinates are tied."""
    return rigid_superelement(
        "casing",
        40.0,
        [0.0, 0.0, 0.3],
        [2.0, 2.0, 1.5],
        {"a": [0.0, 0.0, 0.1], "b": 0.8, "foot": [0.2, -0.1, 0.5]},
    )


def springs(element):
    """Stiffness on the coordinates of an element, from the interfaces' names."""
    out = np.zeros(element.size)
    for name, (x, y, z) in SPRINGS.items():
        for motion, value in zip(("ux", "uy", "uz"), (x, y, z), strict=True):
            out[element.interface_index(name, motion)] = value
    out[element.interface_index("a", "rz")] = TORSION
    return np.diag(out)


def ours(element, speed, held):
    """Frequencies of the program itself [Hz]."""
    given = SPRINGS if held else {}
    lateral = {name: (x, y) for name, (x, y, _) in given.items()}
    axial = {name: z for name, (_, _, z) in given.items()}
    system = on_springs(element, lateral, axial, {"a": TORSION})
    return modes_at_speed(system, speed).frequency_hz


def from_matrices(mass, damping, stiffness):
    """Frequencies of M q'' + C q' + K q = 0 [Hz] in rising order, no part of the program used."""
    n = len(mass)
    root = np.sqrt(np.diag(mass))
    scale = np.outer(root, root)
    rates = np.linalg.solve(mass / scale, np.hstack([-stiffness / scale, -damping / scale]))
    state = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), rates])
    found = np.linalg.eigvals(state).imag
    return np.sort(found[found > 0.0]) / (2.0 * np.pi)


def error(found, expected):
    """Largest relative error of the elastic frequencies, those above 1 Hz."""
    expected = expected[expected > 1.0]
    found = found[found > 1.0]
    assert len(found) >= len(expected) > 10
    found = found[: len(expected)]
    return float(np.abs(found / expected - 1.0).max())


def compare(element, found, limit):
    """Compare frequencies free, on springs and at speed with those of matrices, by role.

    Parameters
    ----------
    found
        The matrices in the element's order, of the roles that `write_*` gives them at `SPEED`.
    limit
        Relative.
    """
    mass, stiffness = found["mass"], found["stiffness"]
    zero, own = np.zeros_like(mass), springs(element)
    damping = SPEED * found["gyroscopic"]
    change = SPEED**2 * (found["stress_stiffening"] + found["spin_softening"])
    at_rest, held = ours(element, 0.0, False), ours(element, 0.0, True)
    turning = ours(element, SPEED, True)
    assert error(from_matrices(mass, zero, stiffness), at_rest) < limit
    assert error(from_matrices(mass, zero, stiffness + own), held) < limit
    assert error(from_matrices(mass, damping, stiffness + own + change), turning) < limit
    given = found["gyroscopic_at_speed"], found["stiffness_at_speed"] + own
    assert error(from_matrices(mass, *given), turning) < limit


def expected(element):
    """Matrices of an element by role, as formats without rows of their own hold them."""
    change = element.stress_stiffening - element.spin_softening
    return {
        "mass": element.mass,
        "stiffness": element.stiffness,
        "gyroscopic": element.gyroscopic,
        "stress_stiffening": element.stress_stiffening,
        "spin_softening": -element.spin_softening,
        "rigid_modes": element.rigid_body_modes,
        "spin_generator": element.spin_generator,
        "stiffness_at_speed": element.stiffness + SPEED**2 * change,
        "gyroscopic_at_speed": SPEED * element.gyroscopic,
    }
