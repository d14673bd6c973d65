"""Error estimates of beams by stations against closed forms, and against shorter elements."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, one_rotor, steel_shaft

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn import frequency_errors
from solidwhirl.rotordyn.beams.elements import shear_coefficient

LENGTH, RADIUS = 1.0, 0.03
E, NU, RHO = 2e11, 0.3, 7850.0
# What the estimate may exceed the error by: it is of first order, and grows without bound where
# elements resonate by themselves, as in the last mode that a mesh has. Errors below are rounding.
MOST, SMALL = 2.0, 1e-7


def pinned_hz(number):
    """Timoshenko's beam on rigid bearings: the lower root of its quadratic in ω²."""
    area, second = np.pi * RADIUS**2, 0.25 * np.pi * RADIUS**4
    shear = shear_coefficient(NU, 0.0) * E / (2.0 * (1.0 + NU))
    k = number * np.pi / LENGTH
    roots = np.roots([
        RHO**2 * second / shear,
        -(RHO * area + RHO * second * k**2 * (1.0 + E / shear)),
        E * second * k**4,
    ])  # fmt: skip
    return np.sqrt(roots.min()) / (2.0 * np.pi)


def shaft(elements, components=("ux", "uy", "rx", "ry")):
    stations = np.linspace(0.0, LENGTH, elements + 1)
    ends = {"left": 0.0, "right": LENGTH}
    return rd.beam_superelement("rotor", stations, RADIUS, 0.0, (E, NU, RHO), ends, (), components)


@pytest.mark.parametrize("elements", [1, 2, 3, 4, 8])
def test_bending_on_rigid_bearings(elements):
    held = [
        rd.Bearing(name=e, first=rd.End(body="rotor", interface=e), rigid=("ux", "uy"))
        for e in ("left", "right")
    ]
    system = one_rotor(shaft(elements), held)
    modes = rd.modes_at_speed(system, 0.0)
    estimate = frequency_errors(system, modes).total
    for number in range(1, min(elements, 4) + 1):
        found = modes.frequency_hz[2 * number - 2]
        error = 1.0 - pinned_hz(number) / found
        assert error > 0.0
        assert error <= estimate[2 * number - 2] + SMALL
        if number < elements:
            assert estimate[2 * number - 2] <= MOST * error + SMALL


@pytest.mark.parametrize("motion", ["uz", "rz"])
@pytest.mark.parametrize("elements", [2, 5])
def test_rods(motion, elements):
    """Free along or about the axis, closed form: half waves of bars and torsion."""
    system = one_rotor(shaft(elements, ("ux", "uy", "rx", "ry", motion)), ())
    modes = rd.modes_at_speed(system, 0.0)
    estimate = frequency_errors(system, modes).total
    rate = np.sqrt((E if motion == "uz" else E / (2.0 * (1.0 + NU))) / RHO)
    exact = 0.5 * rate / LENGTH
    own = system.transformation[system.body_slices["rotor"]] @ modes.shapes
    row = system.system.rotors["rotor"].element.interface_index("left", motion)
    (along,) = np.flatnonzero(
        (np.abs(own[row]) > 1e-3 * np.abs(own).max(axis=0))
        & (np.abs(modes.frequency_hz / exact - 1.0) < 0.3)
    )
    error = modes.frequency_hz[along] / exact - 1.0
    # bending, which has the lowest modes of single elements, tells how near a resonance of one is
    assert error < estimate[along] < 10.0 * error


def test_stepped_shafts_with_disks_at_speed():
    """Against elements cut into six, of which the error is a thousandth, or a 36th of rods."""
    random = np.random.default_rng(5)
    for _ in range(6):
        count = random.integers(2, 5)
        stations = np.cumsum([0.0, *random.uniform(0.05, 0.4, count)])
        radii = random.uniform(0.015, 0.05, count)
        bores = radii * random.choice([0.0, 0.6], count)
        disks = [(float(stations[1]), 8.0, 0.06, 0.035), (float(stations[-1]), 3.0, 0.02, 0.012)]
        found = []
        for pieces in (1, 6):
            fine = np.interp(np.arange(pieces * count + 1) / pieces, np.arange(count + 1), stations)
            ends = {"left": 0.0, "right": float(stations[-1])}
            own = [np.repeat(r, pieces) for r in (radii, bores)]
            element = steel_shaft("rotor", fine, own[0], ends, disks, inner=own[1])
            held = [ground("rotor", end, 3e7, ky=5e7) for end in ends]
            system = one_rotor(element, held)
            modes = rd.modes_at_speed(system, 900.0)
            found.append((modes.frequency_hz, frequency_errors(system, modes).total))
        (coarse, estimate), (exact, _) = found
        # the lower half of what the mesh has: shapes of the others are not those of the shaft
        for k in range(2 * count):
            error = abs(coarse[k] - exact[k]) / coarse[k]
            assert error <= 1.05 * estimate[k] + SMALL
