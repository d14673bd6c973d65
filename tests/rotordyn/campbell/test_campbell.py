"""Tracking of branches: crossings, veerings, repeated modes, direction and grid."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import hub, one_rotor, plane_spring

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.perturbation import lowest_modes

MASS, TRANSLATION, DIAMETRAL, POLAR, TILT = 10.0, 1e6, 0.05, 0.08, 12500.0
# Where the backward tilt mode, Id ω² + Ip Ω ω = kr, meets the translation, m ω² = kt.
MEET_OMEGA = np.sqrt(TRANSLATION / MASS)
MEET_SPEED = (TILT - DIAMETRAL * MEET_OMEGA**2) / (POLAR * MEET_OMEGA)

GRIDS = [
    np.linspace(0, 2 * MEET_SPEED, 2),
    np.linspace(0, 2 * MEET_SPEED, 4),
    np.linspace(0, 2 * MEET_SPEED, 41),
    np.array([0.0, MEET_SPEED, 2 * MEET_SPEED]),
    np.array([0.0, MEET_SPEED * (1 - 1e-4), MEET_SPEED * (1 + 3e-4), 2 * MEET_SPEED]),
]


def coupled_disk(coupling):
    """Disk whose translation and tilt are tied by a small off-diagonal stiffness."""
    return one_rotor(hub(MASS, POLAR, DIAMETRAL, plane_spring(TRANSLATION, coupling, TILT)))


def _by_kind(diagram, kind):
    return [note for note in diagram.notes if note.kind == kind]


@pytest.mark.parametrize("speeds", GRIDS, ids=lambda g: f"{g.size} speeds")
def test_uncoupled_modes_cross_on_any_grid(speeds):
    diagram = rd.campbell(coupled_disk(0.0), speeds, branch_count=4)
    tilt = DIAMETRAL, POLAR * speeds, -TILT
    root = np.sqrt(tilt[1] ** 2 + 4 * DIAMETRAL * TILT)
    backward, forward = (root - tilt[1]) / (2 * DIAMETRAL), (root + tilt[1]) / (2 * DIAMETRAL)
    exact = np.stack([np.full_like(speeds, MEET_OMEGA)] * 2 + [backward, forward])
    np.testing.assert_allclose(diagram.eigenvalues.imag, exact, rtol=1e-12)
    crossings = _by_kind(diagram, "crossing")
    assert [note.branches for note in crossings] == [(0, 2), (1, 2)]
    # A crossing is placed by interpolation between points less than 2e-2 of the step apart.
    for note in crossings:
        assert note.speed_rad_s == pytest.approx(MEET_SPEED, rel=1e-3)
    assert not _by_kind(diagram, "veering") and not _by_kind(diagram, "ambiguous")


@pytest.mark.parametrize("speeds", GRIDS, ids=lambda g: f"{g.size} speeds")
@pytest.mark.parametrize("coupling", [500.0, 3000.0])
def test_coupled_modes_veer_on_any_grid(speeds, coupling):
    diagram = rd.campbell(coupled_disk(coupling), speeds, branch_count=4)
    # Both are backward, so the lower one stays the lower one: modes of one symmetry never cross.
    last = diagram.eigenvalues[:, -1].imag
    assert last[0] < 0.7 * MEET_OMEGA < 0.95 * MEET_OMEGA < last[2]
    assert (diagram.whirl[[0, 2], -1] == "backward").all()
    veerings = _by_kind(diagram, "veering")
    assert [note.branches for note in veerings] == [(0, 2)]
    assert veerings[0].speed_rad_s == pytest.approx(MEET_SPEED, rel=0.02)
    assert not _by_kind(diagram, "ambiguous")


def test_a_veering_narrower_than_resolved_is_a_crossing():
    # Distance 5e-6 of the frequency: below the 1e-4 that is told apart.
    for speeds in GRIDS:
        diagram = rd.campbell(coupled_disk(0.5), speeds, branch_count=4)
        assert diagram.eigenvalues[2, -1].imag < 0.7 * MEET_OMEGA
        assert len(_by_kind(diagram, "crossing")) == 2


def test_frequencies_below_a_limit_include_branches_that_enter():
    # At rest the tilt mode is at 79.6 Hz, above the limit; the backward one drops below it.
    diagram = rd.campbell(coupled_disk(0.0), GRIDS[1], frequency_max_hz=60.0)
    assert diagram.frequency_hz.shape == (3, 4)
    assert diagram.frequency_hz[2, 0] > 60.0 > diagram.frequency_hz[2, -1]


def test_a_branch_that_becomes_rigid_ends():
    # The tilt stiffness kr − Ω² s vanishes at 1000 rad/s.
    disk = hub(MASS, 0.0, DIAMETRAL, plane_spring(TRANSLATION, 0.0, TILT))
    disk = dataclasses.replace(disk, spin_softening=np.diag([0, 0, TILT / 1e6, TILT / 1e6]))
    diagram = rd.campbell(one_rotor(disk, []), [0.0, 500.0, 900.0, 1200.0], branch_count=4)
    exact = np.sqrt((TILT - TILT / 1e6 * diagram.speeds_rad_s[:3] ** 2) / DIAMETRAL)
    np.testing.assert_allclose(diagram.eigenvalues[2:, :3].imag, [exact, exact], rtol=1e-12)
    assert np.isnan(diagram.frequency_hz[2:, 3]).all()
    assert (diagram.whirl[2:, 3] == "").all()
    np.testing.assert_allclose(diagram.eigenvalues[:2].imag, MEET_OMEGA, rtol=1e-12)
    assert {note.branches for note in _by_kind(diagram, "ended")} == {(2,), (3,)}
    assert len(_by_kind(diagram, "indefinite")) == 1


def test_every_speed_at_which_a_mode_stands_still_is_noted():
    """k − Ω² s of the tilts vanishes at 1000 rad/s and of the translations at 1100 rad/s."""
    disk = hub(MASS, 0.0, DIAMETRAL, plane_spring(TRANSLATION, 0.0, TILT))
    softening = np.diag(np.array([TRANSLATION / 1.21, TRANSLATION / 1.21, TILT, TILT]) / 1e6)
    system = one_rotor(dataclasses.replace(disk, spin_softening=softening), [])
    notes = _by_kind(
        rd.campbell(system, [0.0, 900.0, 1050.0, 1200.0], branch_count=4), "indefinite"
    )
    assert [note.speed_rad_s for note in notes] == pytest.approx([1000.0, 1100.0], rel=1e-9)
    assert ["2 negative" in notes[0].text, "4 negative" in notes[1].text] == [True, True]


def test_no_speed_is_solved_twice_where_branches_end(monkeypatch):
    disk = hub(stiffness=plane_spring(TRANSLATION, 0.0, TILT), polar_kg_m2=0.0)
    disk = dataclasses.replace(disk, spin_softening=disk.stiffness / 1e6)
    solved = []

    def counted(assembled, speed, count=None):
        solved.append(speed)
        return rd.modes_at_speed(assembled, speed, count)

    monkeypatch.setattr(lowest_modes, "modes_at_speed", counted)
    diagram = rd.campbell(one_rotor(disk, []), [0.0, 900.0, 1500.0], frequency_max_hz=100.0)
    assert np.isnan(diagram.frequency_hz[:, 2]).all()
    assert len(solved) == len(set(solved))


def test_speeds_beyond_the_basis_are_noted():
    disk = hub(stiffness=plane_spring(TRANSLATION, 0.0, TILT))
    system = one_rotor(dataclasses.replace(disk, maximum_speed_rad_s=300.0), (), -2.0)
    assert system.speed_limit_rad_s == 150.0
    (note,) = _by_kind(rd.campbell(system, [0.0, 200.0], branch_count=1), "range")
    assert note.speed_rad_s == 150.0
    assert not _by_kind(rd.campbell(system, [0.0, 150.0], branch_count=1), "range")


def test_a_diagram_may_be_empty_or_of_one_speed():
    system = coupled_disk(0.0)
    diagram = rd.campbell(system, [0.0, 1.0], frequency_max_hz=1.0)
    assert diagram.frequency_hz.shape == diagram.whirl.shape == (0, 2)
    assert [note.kind for note in diagram.notes] == ["empty"]
    one = rd.campbell(system, [0.0], branch_count=2)
    many = rd.campbell(system, [0.0, 10.0], branch_count=2)
    assert one.frequency_hz.shape == (2, 1)
    np.testing.assert_array_equal(one.frequency_hz[:, 0], many.frequency_hz[:, 0])


@pytest.mark.parametrize(
    ("speeds", "options", "message"),
    [
        ([], {"branch_count": 2}, r"found shape \(0,\)"),
        ([0.0, 1.0, 1.0], {"branch_count": 2}, "strictly monotonic"),
        ([0.0, np.nan], {"branch_count": 2}, "finite"),
        ([0.0, 1.0], {}, "one of branch_count and frequency_max_hz"),
        ([0.0, 1.0], {"branch_count": 2, "frequency_max_hz": 5.0}, "one of branch_count"),
        ([0.0, 1.0], {"branch_count": 0}, "branch_count is 0"),
        ([0.0, 1.0], {"frequency_max_hz": -1.0}, "frequency_max_hz is -1.0"),
    ],
)
def test_arguments_without_meaning_are_refused(speeds, options, message):
    with pytest.raises(rd.AnalysisError, match=message):
        rd.campbell(coupled_disk(0.0), speeds, **options)
