"""Geared turbo-alternator of Rao, Shiau and Chang 1998, Mech. Mach. Theory 33, 761-783.

Data and frequencies as in ROSS 2.3.0 (two_shaft_rotor_example), with single beam elements of 4.24
and 5 m: a comparison of programs, not of the converged rotor with the paper's table.
"""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, steel_shaft, turning

from solidwhirl import rotordyn as rd

MODULUS, SHEAR_MODULUS, DENSITY = 207e9, 79.5e9, 7800.0
TEETH = (328, 23)
BASE_RADIUS = 0.5086
PRESSURE_ANGLE = np.deg2rad(22.5)
SPEED = 157.08
FREQUENCIES = {
    0.0: [73.615, 76.699, 112.051, 112.757, 150.530, 236.932],
    SPEED: [73.140, 77.184, 108.496, 115.973, 150.524, 236.800],
}


def shaft(name, lengths, radii, disks, seats):
    nodes = np.concatenate(([0.0], np.cumsum(lengths)))
    inertias = [(nodes[node], mass, polar, diametral) for node, mass, diametral, polar in disks]
    material = (MODULUS, MODULUS / (2 * SHEAR_MODULUS) - 1, DENSITY)
    places = {label: nodes[node] for label, node in seats.items()}
    parts = {"material": material, "components": ("ux", "uy", "rx", "ry", "rz")}
    return steel_shaft(name, nodes, radii, places, inertias, **parts)


@pytest.fixture
def turbo_alternator():
    # generator, disk and gear; gear and turbine
    disks = [(1, 525.7, 16.1, 32.2), (2, 116.04, 3.115, 6.23), (4, 726.4, 56.95, 113.9)]
    lengths, radii = [0.1, 4.24, 1.16, 0.3], [0.15, 0.15, 0.11, 0.11]
    alternator = shaft("alternator", lengths, radii, disks, {"left": 0, "right": 3, "gear": 4})
    disks = [(0, 5.0, 0.002, 0.004), (2, 7.45, 0.0745, 0.149)]
    turbine = shaft("turbine", [0.3, 5.0, 0.1], 0.075, disks, {"gear": 0, "left": 1, "right": 3})
    ratio = -TEETH[0] / TEETH[1]
    rotors = {"alternator": turning(alternator), "turbine": turning(turbine, ratio)}
    bearings = tuple(
        ground(body, end, kx, ky, 3e3)
        for body, kx, ky in (("alternator", 183.9e6, 200.4e6), ("turbine", 10.1e6, 41.6e6))
        for end in ("left", "right")
    )
    first, second = (rd.End(body=name, interface="gear") for name in rotors)
    # The wheels touch along x; the teeth press along y, turned by the pressure angle.
    gear = rd.Gear(
        name="gear", first=first, second=second, ratio=ratio, mesh_stiffness_n_per_m=1e8,
        base_radius_first_m=BASE_RADIUS, line_of_action_rad=np.pi / 2 - PRESSURE_ANGLE,
    )  # fmt: skip
    return rd.assemble(rotors, bearings, "alternator", (gear,))


@pytest.mark.parametrize("speed", [0.0, SPEED])
def test_frequencies(turbo_alternator, speed):
    modes = rd.modes_at_speed(turbo_alternator, speed)
    found = np.abs(modes.eigenvalues)[: len(FREQUENCIES[speed])]
    # The example gives the pinion's base radius as 35.67 mm, the teeth make it 35.664 mm (1.7e-4):
    # the mode that lives on the teeth differs by 4e-5, the others by the six printed digits.
    np.testing.assert_allclose(found, FREQUENCIES[speed], rtol=6e-5)
    # Both shafts turn freely together.
    assert modes.zero_count == 2
