"""Modes found from a known spectrum beside it, against whole spectra."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import ground, one_rotor, polynomial_law, steel_shaft, with_axial_and_torsion

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.perturbation import lowest_modes
from solidwhirl.rotordyn.perturbation.continued_spectrum import NearModes, known_spectrum
from solidwhirl.rotordyn.perturbation.near_subspace import Mixer

NEEDED = 6
FILM = polynomial_law((1.0, 3e-4), (1.0, 1e-4), (1.0, -2e-4), (1.0, -1e-4), top=3000.0)
EVEN = polynomial_law((1.0, 3e-4), (1.0, 3e-4), (1.0, -2e-4), (1.0, -2e-4), top=3000.0)
SUPPORTS = {
    "damped": {"cx": 900.0, "cy": 400.0},
    "overdamped": {"cx": 3e5, "cy": 2e5},
    "law": {"cx": 900.0, "cy": 400.0, "speed_law": FILM},
    "isotropic": {"cx": 900.0, "speed_law": EVEN},
}


def shaft_on(kind):
    """A shaft with two disks on two supports: uneven, or the same in all directions."""
    disks = [(0.3, 20.0, 0.4, 0.21), (0.9, 12.0, 0.2, 0.11)]
    seats = {"A": 0.0, "B": 0.8}
    shaft = steel_shaft("rotor", np.linspace(0.0, 1.0, 13), 0.03, seats, disks)
    if kind == "isotropic":  # with axial motion and torsion beside it
        shaft = with_axial_and_torsion(shaft, 0.8, 0.03, *seats)
        along = {"axial_stiffness_n_per_m": 1e7, "torsion_stiffness_n_m_per_rad": 1e5}
        held = [ground("rotor", end, 4e7, **SUPPORTS[kind], **along) for end in seats]
        return one_rotor(shaft, held)
    held = [ground("rotor", end, 4e7, 2e7, **SUPPORTS[kind]) for end in seats]
    return one_rotor(shaft, held)


@pytest.mark.parametrize("kind", SUPPORTS)
def test_modes_beside_a_known_spectrum_are_the_lowest_of_the_whole(kind):
    system = shaft_on(kind)
    near = NearModes(system, known_spectrum(system, rd.modes_at_speed(system, 600.0), NEEDED))
    for speed in (600.0, 640.0, 700.0, 500.0):
        found, whole = near.at(speed), rd.modes_at_speed(system, speed)
        count = found.eigenvalues.size
        assert NEEDED < count < whole.eigenvalues.size
        np.testing.assert_allclose(found.eigenvalues, whole.eigenvalues[:count], rtol=1e-9)
        np.testing.assert_allclose(found.real_eigenvalues, whole.real_eigenvalues, rtol=1e-7)
        if kind == "isotropic":
            assert {-1, 0, 1} == set(found.family.tolist())
            np.testing.assert_array_equal(found.family, whole.family[:count])
        product = found.shapes.conj().T @ system.mass @ whole.shapes[:, :count]
        np.testing.assert_allclose(np.abs(np.diag(product)), 1.0, rtol=1e-8)
    assert (rd.modes_at_speed(system, 600.0).real_eigenvalues.size > 0) == (kind == "overdamped")


def test_what_is_too_far_away_is_left_to_the_whole_spectrum():
    system = shaft_on("damped")
    near = NearModes(system, known_spectrum(system, rd.modes_at_speed(system, 0.0), NEEDED))
    for speed in np.linspace(200.0, 6000.0, 10):
        found, whole = near.at(speed), rd.modes_at_speed(system, speed)
        if found is None:
            continue
        count = found.eigenvalues.size
        np.testing.assert_allclose(found.eigenvalues, whole.eigenvalues[:count], rtol=1e-8)
    assert near.at(6000.0) is None
    # a support that turns negative is no matter of few modes
    soft = dataclasses.replace(FILM, stiffness_x=(1.0, -1e-3))
    negative = [dataclasses.replace(b, speed_law=soft) for b in shaft_on("law").system.bearings]
    turned = one_rotor(system.system.rotors["rotor"].element, negative)
    near = NearModes(turned, known_spectrum(turned, rd.modes_at_speed(turned, 900.0), NEEDED))
    assert near.at(950.0) is not None and near.at(1100.0) is None


def test_systems_without_a_basis_are_left_alone():
    shaft = shaft_on("damped").system.rotors["rotor"].element
    for bearings in (
        # at rest overdamped whirl does not oscillate
        [ground("rotor", end, 4e7, cx=3e5) for end in "AB"],
        [ground("rotor", end, 4e7, 2e7) for end in "AB"],
        [ground("rotor", "A", 4e7, 0.0, cx=900.0)],
    ):
        system = one_rotor(shaft, bearings)
        assert known_spectrum(system, rd.modes_at_speed(system, 0.0), NEEDED) is None


@pytest.mark.parametrize("kind", SUPPORTS)
def test_a_damped_diagram_needs_few_whole_spectra(kind, monkeypatch):
    system, speeds = shaft_on(kind), np.linspace(0.0, 800.0, 41)
    with SYSTEMS.counted() as counts:
        found = rd.campbell(system, speeds, branch_count=NEEDED)
    # axial motion and torsion are solved at each speed
    beside = speeds.size if kind == "isotropic" else 0
    assert counts["eigenproblems"] <= 1 + beside
    monkeypatch.setattr(lowest_modes, "known_spectrum", lambda *_: None)
    with SYSTEMS.counted() as counts:
        whole = rd.campbell(shaft_on(kind), speeds, branch_count=NEEDED)  # nothing of it is kept
    assert counts["eigenproblems"] >= speeds.size + beside
    np.testing.assert_allclose(found.eigenvalues, whole.eigenvalues, rtol=1e-10)
    assert (found.whirl == whole.whirl).all()
    assert [note.text for note in found.notes] == [note.text for note in whole.notes]


def test_modes_are_found_back_from_a_spectrum_ahead():
    """Beyond the reach of the spectrum at rest one more does, from which modes are continued back.

    Step by step: at once the subspace would be too far away.
    """
    system = shaft_on("damped")
    with SYSTEMS.counted() as counts:
        found = rd.campbell(system, np.linspace(0.0, 6000.0, 61), branch_count=4)
    assert counts["eigenproblems"] == 2
    whole = rd.modes_at_speed(system, 6000.0, 4)
    np.testing.assert_allclose(
        np.sort(found.eigenvalues[:, -1].imag)[:4], whole.eigenvalues.imag[:4], rtol=1e-10
    )


@pytest.mark.parametrize("rates", [(0.8, -0.5), (0.7 + 0.2j, -0.6j)])
def test_mixed_iterates_come_to_rest_in_few_steps_and_tell_how_far_they_are(rates):
    """P + f = J P + b with two rates of convergence: three iterates tell where it rests."""
    slow, rest = np.array([rates]), np.array([[1.0, -2.0]])
    part, mixer, errors = np.zeros_like(rest * slow), Mixer(), []
    for _ in range(3):
        move = slow * part + (1.0 - slow) * rest - part
        part, farther = mixer.after(part, move)
        errors.append(np.linalg.norm(part - rest))
    assert errors[1] > 0.1 and errors[2] < 1e-9
    # what the changes tell of the distance is not far below it
    assert errors[2] < farther * np.linalg.norm(move) < 1.0
