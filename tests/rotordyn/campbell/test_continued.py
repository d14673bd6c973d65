"""Branches followed by some modes alone: against the whole spectrum and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import connect, hub, one_rotor, steel_shaft, table_law
from scipy.optimize import brentq

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.system import SpeedMatrices
from solidwhirl.rotordyn.campbell import continued
from solidwhirl.rotordyn.modes.nearby import nearby_modes
from solidwhirl.rotordyn.perturbation import lowest_modes

MASS, STIFFNESS = 10.0, 1e7
CRITICAL = 2.0 * np.sqrt(STIFFNESS * MASS)


def _shaft(seed):
    """A shaft on unlike damped supports with a skew stiffness."""
    rng = np.random.default_rng(seed)
    element = steel_shaft("r", np.linspace(0, 0.6, 7), 0.02, {"a": 0.0, "b": 0.5}, [])
    bearings = [
        connect(
            f"r.{end}",
            f"rotor.{end}",
            None,
            1e6 * (np.eye(2) + 0.4 * rng.normal(size=(2, 2))),
            300.0 * (np.eye(2) + 0.3 * rng.normal(size=(2, 2))),
        )
        for end in "ab"
    ]
    return one_rotor(element, bearings)


@pytest.mark.parametrize("soft", [1e-2, 1e-4, 1e-6])
def test_a_shaft_that_a_soft_spring_holds_turns_slowly(soft):
    """Two inertias on a stiff shaft: D at the root is a small difference of large terms."""
    inertia, stiff = np.diag([0.4, 0.1]), 1e5
    spring = stiff * np.array([[1.0, -1.0], [-1.0, 1.0]]) + np.diag([soft, 0.0])
    none = np.zeros((2, 2))
    matrices = SpeedMatrices(inertia, none, none, spring)
    # the shaft is rigid to soft / stiff
    root = 1j * np.sqrt(soft / 0.5)
    values, shapes = nearby_modes(matrices, 1.0001 * root, np.array([[1.0 + 0j], [0.98]]))
    # rounding of the stiff terms over the soft one, halved in the root
    allowed = 8 * np.finfo(float).eps * stiff / soft + soft / stiff
    assert abs(values[0] - root) <= allowed * abs(root)
    assert shapes[1, 0] / shapes[0, 0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_nearby_modes_are_those_of_the_whole_spectrum(seed):
    """From shapes at one speed to values at another, singly and in pairs."""
    system = _shaft(seed)
    here, there = (rd.modes_at_speed(system, speed) for speed in (300.0, 310.0))
    matrices = rd.matrices_at_speed(system, 310.0)
    for k in range(6):
        values, _ = nearby_modes(matrices, here.eigenvalues[k], here.shapes[:, [k]])
        assert np.abs(there.eigenvalues - values[0]).min() <= 1e-10 * abs(values[0])
    # no other is as near to the mean of the closest two
    first = int(np.abs(np.diff(here.eigenvalues)).argmin())
    both = slice(first, first + 2)
    values, shapes = nearby_modes(matrices, here.eigenvalues[both].mean(), here.shapes[:, both])
    np.testing.assert_allclose(np.sort_complex(values), np.sort_complex(there.eigenvalues[both]))
    velocity = matrices.damping + matrices.gyroscopic
    dynamic = [v**2 * matrices.mass + v * velocity + matrices.stiffness for v in values]
    for d, shape in zip(dynamic, shapes.T, strict=True):
        assert np.abs(d @ shape).max() < 1e-8 * (np.abs(d) @ np.abs(shape)).max()


def _born(factors):
    """A disk that does not tilt, on a bearing whose damping follows a table; critical at 1."""
    speeds = [0.0, 400.0, 1500.0]
    law = table_law(
        speeds,
        np.array([np.eye(2) * STIFFNESS] * 3),
        np.array([np.diag([f, 0.3]) * CRITICAL for f in factors]),
    )
    bearing = connect("b", "rotor.hub", speed_law=law)
    return one_rotor(hub(mass_kg=MASS, polar_kg_m2=0.0), [bearing]), law


def _frequency(law, speed):
    """Im λ of the motion that begins to oscillate, by the damping of the law."""
    zero = np.zeros((2, 2))
    damping = law.coefficients(speed, zero, zero).damping_n_s_per_m[0, 0]
    return np.sqrt(max(0.0, STIFFNESS / MASS - (damping / (2.0 * MASS)) ** 2))


def test_a_critical_speed_right_after_a_beginning_is_found():
    """The motion begins within a step of the search and meets the line in the same."""
    system, law = _born((2.0, 0.2, 0.3))
    found = [c.speed_rad_s for c in rd.critical_speeds(system, 1.0, 1400.0)]
    grid = np.linspace(1.0, 1400.0, 2000)
    miss = np.array([_frequency(law, s) - s for s in grid])
    exact = [
        brentq(lambda s: _frequency(law, s) - s, *grid[k : k + 2], xtol=1e-12)
        for k in np.flatnonzero(miss[1:] * miss[:-1] < 0)
    ]
    assert len(exact) == 2 and exact[0] < 400.0
    for speed in exact:
        assert np.abs(np.array(found) / speed - 1.0).min() < 1e-9


def test_beginnings_and_crossings_cost_no_eigenproblems(monkeypatch):
    """One for each speed that is asked for, at rest and at knots, and few to be sure near rest."""
    system, law = _born((2.0, 0.2, 1.4))
    solved = []

    def counted(assembled, speed, count=None):
        solved.append(speed)
        return rd.modes_at_speed(assembled, speed, count)

    for module in (lowest_modes, continued):
        monkeypatch.setattr(module, "modes_at_speed", counted)
    speeds = np.linspace(0.0, 1400.0, 15)
    diagram = rd.campbell(system, speeds, branch_count=4)
    kinds = [note.kind for note in diagram.notes]
    assert "begun" in kinds and "ended" in kinds and "crossing" in kinds
    assert len(solved) <= speeds.size + 1
    begun = next(note for note in diagram.notes if note.kind == "begun")
    zero = np.zeros((2, 2))
    damping = law.coefficients(begun.speed_rad_s, zero, zero).damping_n_s_per_m[0, 0]
    assert damping == pytest.approx(CRITICAL, rel=1e-7)
