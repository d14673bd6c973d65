"""Fast forms against a general solver on laws whose structure shows at few speeds only.

The solver is written here: M, G, C and K of a rigid rotor from its own geometry, laws interpolated
by scipy or summed as polynomials, all eigenvalues of the state matrix, linear solutions.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
from scipy.interpolate import PchipInterpolator

from solidwhirl.rotordyn import (
    AnalysisError,
    AssemblyError,
    Bearing,
    End,
    Rotor,
    assemble,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.bearing_laws import BearingCoefficients, PolynomialLaw, TableLaw
from solidwhirl.rotordyn.complex_form import complex_form
from solidwhirl.rotordyn.critical_speeds import count_critical_speeds
from solidwhirl.rotordyn.plane_spectrum import planes_apart
from solidwhirl.rotordyn.rigid_superelement import rigid_superelement
from solidwhirl.rotordyn.speed_derivative import speed_derivative
from solidwhirl.rotordyn.unbalance import Unbalance, resolving_speeds, unbalance_response
from solidwhirl.rotordyn.unbalance_peaks import resonance_peaks

ZERO = np.zeros((2, 2))
PLACES = {"a": -0.1, "b": 0.2}
MASS, DIAMETRAL, POLAR = 10.0, 0.1, 0.15
LIMIT = 1000.0


def _rotor(ratio=1.0):
    element = rigid_superelement(
        "rotor", MASS, (0.0, 0.0, 0.0), (DIAMETRAL, DIAMETRAL, POLAR), PLACES,
        components=("ux", "uy", "rx", "ry"),
    )  # fmt: skip
    return Rotor(element=element, speed_ratio=ratio)


def _system(laws, ratio=1.0, **options):
    """The rotor on one bearing with a law at each place; polynomials scale 1e6 N/m, 100 N s/m."""
    bearings = []
    for place, law in zip(PLACES, laws, strict=True):
        own = {}
        if isinstance(law, PolynomialLaw):
            own = {"stiffness_n_per_m": 1e6 * np.eye(2), "damping_n_s_per_m": 100.0 * np.eye(2)}
        bearings.append(
            Bearing(
                name=place, first=End(body="rotor", interface=place), speed_law=law, **own, **options
            )
        )
    return assemble({"rotor": _rotor(ratio)}, tuple(bearings))


# The general solver.


def _evaluated(law, speed):
    """k and c of a law at a speed by scipy and sums of powers."""
    if isinstance(law, PolynomialLaw):
        factors = (law.stiffness_x, law.stiffness_y, law.damping_x, law.damping_y)
        x = [sum(c * speed**p for p, c in enumerate(factor)) for factor in factors]
        return 1e6 * np.diag(x[:2]), 100.0 * np.diag(x[2:])
    at = np.clip(speed, law.speeds_rad_s[0], law.speeds_rad_s[-1])
    out = []
    for table in (law.stiffness_n_per_m, law.damping_n_s_per_m):
        if law.interpolation == "monotone":
            out.append(PchipInterpolator(law.speeds_rad_s, table)(at))
        else:
            columns = table.reshape(-1, 4).T
            out.append(np.array([np.interp(at, law.speeds_rad_s, c) for c in columns]))
    return [part.reshape(2, 2) for part in out]


def _general(laws, speed):
    """M, C + ΩG and K of (x, y, rx, ry): a place at z moves by (x + z ry, y − z rx)."""
    mass = np.diag([MASS, MASS, DIAMETRAL, DIAMETRAL])
    velocity = np.zeros((4, 4))
    velocity[2, 3], velocity[3, 2] = speed * POLAR, -speed * POLAR
    stiffness = np.zeros((4, 4))
    for z, law in zip(PLACES.values(), laws, strict=True):
        seen = np.array([[1.0, 0.0, 0.0, z], [0.0, 1.0, -z, 0.0]])
        k, c = _evaluated(law, speed)
        stiffness += seen.T @ k @ seen
        velocity += seen.T @ c @ seen
    return mass, velocity, stiffness


def _eigenvalues(laws, speed):
    """All eigenvalues with a frequency, rising; scaled so that entries are of one size."""
    mass, velocity, stiffness = _general(laws, speed)
    inverse = np.linalg.inv(mass)
    state = np.block([[np.zeros((4, 4)), np.eye(4)], [-inverse @ stiffness, -inverse @ velocity]])
    values = la.eigvals(state)
    return np.sort_complex(values[values.imag > 1e-6 * np.abs(values)] * -1j) * 1j


def _amplitude(laws, speed):
    """Largest motion of the centre by an unbalance of 1 kg m there, over Ω²."""
    mass, velocity, stiffness = _general(laws, speed)
    load = np.array([1.0, -1j, 0.0, 0.0])
    motion = la.solve(stiffness + 1j * speed * velocity - speed**2 * mass, load)
    return np.abs(motion[:2]).max()


# Laws that deceive samples.


def _rows(rng, kind):
    """Rising speeds: spread, clustered at low speed below one far row, or about one speed."""
    if kind == "far":
        return np.concatenate((np.sort(rng.uniform(0.0, 1.2 * LIMIT, 4)), [1e9]))
    if kind == "clustered":
        centre = rng.uniform(50.0, 900.0)
        return np.unique(np.concatenate(([0.0], centre + rng.uniform(0.0, 2.0, 4), [2e5])))
    return np.sort(rng.uniform(0.0, 1.5 * LIMIT, 5))


def _random_table(rng, damped):
    speeds = _rows(rng, rng.choice(["far", "clustered", "spread"]))
    stiffness = np.multiply.outer(10.0 ** rng.uniform(4.5, 6.5, speeds.size), np.eye(2))
    damping = np.multiply.outer(10.0 ** rng.uniform(0.0, 3.0, speeds.size), np.eye(2)) * damped
    odd, at = rng.choice(["", "cross", "entry", "damping", "symmetric"]), rng.integers(speeds.size)
    if odd == "cross":
        stiffness[at] += 0.5 * stiffness[at, 0, 0] * np.array([[0.0, 1.0], [-1.0, 0.0]])
    elif odd == "symmetric":
        stiffness[at] += 0.3 * stiffness[at, 0, 0] * np.array([[0.0, 1.0], [1.0, 0.0]])
    elif odd == "entry":
        stiffness[at, 1, 1] *= 2.0
    elif odd == "damping" and damped:
        damping[at, 0, 1] = 0.5 * damping[at, 0, 0]
    return TableLaw(
        name="table", speeds_rad_s=speeds, stiffness_n_per_m=stiffness, damping_n_s_per_m=damping,
        interpolation=str(rng.choice(["linear", "monotone"])),
    )  # fmt: skip


def _random_polynomial(rng, damped):
    """k touches zero at one speed, in one plane or both."""
    zero = rng.uniform(100.0, 1100.0)
    touching = (1.0 + 1e-9, -2.0 / zero, 1.0 / zero**2)
    other = touching if rng.random() < 0.5 else (1.0, rng.uniform(0.0, 1e-3))
    along = (1.0, 0.0, rng.uniform(0.0, 1e-6)) if damped else (0.0,)
    return PolynomialLaw(
        name="polynomial", argument_unit="rad/s", argument_range=(0.0, 2e3),
        stiffness_x=touching, stiffness_y=other, damping_x=along,
        damping_y=along if rng.random() < 0.5 else (2.0 * damped,),
    )  # fmt: skip


def _random_laws(seed):
    rng = np.random.default_rng(seed)
    damped = float(rng.random() < 0.6)
    makers = [_random_table, _random_polynomial]
    return [makers[int(rng.random() < 0.3)](rng, damped) for _ in PLACES]


def _marks(laws, system):
    """Speeds where laws change, and between and beside them."""
    knots = np.array([0.1, *system.knots_rad_s, LIMIT])
    knots = np.unique(knots[(knots > 0) & (knots <= LIMIT)])
    middles = 0.5 * (knots[1:] + knots[:-1])
    return np.unique(np.concatenate((knots, middles, knots[:-1] + 1e-3 * np.diff(knots))))


def _check_modes(laws, system):
    for speed in _marks(laws, system):
        wanted = _eigenvalues(laws, speed)
        found = modes_at_speed(system, float(speed)).eigenvalues
        found = found[found.imag > 1e-6 * np.abs(found)]
        assert found.size == wanted.size
        rest = list(wanted)
        for value in found:
            near = int(np.argmin(np.abs(np.array(rest) - value)))
            # equal eigenvalues of a defective pair split by the root of the rounding
            assert abs(rest.pop(near) - value) <= 1e-6 * abs(value)


def _check_critical_speeds(laws, system):
    grid = np.unique(np.concatenate((_marks(laws, system), np.linspace(0.1, LIMIT, 401))))
    above = np.array([np.count_nonzero(_eigenvalues(laws, s).imag > s) for s in grid])
    found = np.array([c.speed_rad_s for c in critical_speeds(system, 1.0, LIMIT)])
    for speed in found:
        values = _eigenvalues(laws, speed)
        assert np.abs(values.imag - speed).min() <= 1e-5 * speed
    slack = 1e-8 * grid
    for low, high, change, near in zip(grid[:-1], grid[1:], np.diff(above), slack, strict=False):
        if change and not (np.abs(found[:, None] - [low, high]) < near).any():
            there = np.count_nonzero((found > low) & (found <= high))
            assert there >= abs(change)


def _check_response(laws, system):
    places = [Unbalance(body="rotor", interface="a", moment_kg_m=0.1)]
    speeds = resolving_speeds(system, places, np.linspace(0.0, LIMIT, 60))
    return speeds, places


@pytest.mark.parametrize("seed", range(40))
def test_random_laws(seed):
    laws = _random_laws(seed)
    system = _system(laws)
    _check_modes(laws, system)
    _check_critical_speeds(laws, system)
