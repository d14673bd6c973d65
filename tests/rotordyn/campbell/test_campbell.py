"""Tracking of branches: crossings, veerings, repeated modes, direction and grid."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import ground, hub, one_rotor, plane_spring, three_disk_element, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.campbell import tracking

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


def coupled_disk(coupling, ratio=1.0):
    """Disk whose translation and tilt are tied by a small off-diagonal stiffness."""
    disk = hub(
        mass_kg=MASS,
        diametral_kg_m2=DIAMETRAL,
        polar_kg_m2=POLAR,
        stiffness=plane_spring(TRANSLATION, coupling, TILT),
    )
    return one_rotor(disk, [], ratio)


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


def test_repeated_modes_at_rest_split_into_whirl_pairs():
    bearings = [ground("rotor", end, 7e7) for end in ("left", "right")]
    system = one_rotor(three_disk_element(), bearings)
    diagram = rd.campbell(system, np.linspace(0, 2000, 9), branch_count=6)
    # Isotropic supports: pairs are equal at rest to rounding and part from there.
    assert (diagram.whirl[:, 0] == "planar").all()
    assert (diagram.whirl[::2, 1:] == "backward").all()
    assert (diagram.whirl[1::2, 1:] == "forward").all()
    np.testing.assert_allclose(diagram.frequency_hz[::2, 0], diagram.frequency_hz[1::2, 0])
    assert (np.diff(diagram.frequency_hz[::2], axis=1) < 0).all()
    assert (np.diff(diagram.frequency_hz[1::2], axis=1) > 0).all()
    assert diagram.overlap.min() > 0.8


def test_frequencies_below_a_limit_include_branches_that_enter():
    # At rest the tilt mode is at 79.6 Hz, above the limit; the backward one drops below it.
    diagram = rd.campbell(coupled_disk(0.0), GRIDS[1], frequency_max_hz=60.0)
    assert diagram.frequency_hz.shape == (3, 4)
    assert diagram.frequency_hz[2, 0] > 60.0 > diagram.frequency_hz[2, -1]


def test_a_mode_that_the_spin_lifts_has_a_branch_from_rest_on():
    # A free tilt is rigid at rest and precesses with (Ip/It) Ω.
    system = one_rotor(hub(polar_kg_m2=0.06), [ground("rotor", "hub", 1e5)])
    diagram = rd.campbell(system, [0.0, 50.0, 100.0], frequency_max_hz=30.0)
    exact = np.array([np.nan, 60.0, 120.0]) / (2 * np.pi)
    np.testing.assert_allclose(diagram.frequency_hz[0], exact, rtol=1e-12)
    assert diagram.whirl[0].tolist() == ["", "forward", "forward"]
    (note,) = _by_kind(diagram, "begun")
    assert (note.speed_rad_s, note.branches) == (0.0, (0,))
    later = rd.campbell(system, [50.0, 100.0], frequency_max_hz=30.0)
    np.testing.assert_allclose(later.frequency_hz, diagram.frequency_hz[:, 1:], rtol=1e-12)
    assert not _by_kind(later, "begun")


def test_a_branch_that_becomes_rigid_ends():
    # The tilt stiffness kr − Ω² s vanishes at 1000 rad/s.
    disk = hub(
        mass_kg=MASS,
        diametral_kg_m2=DIAMETRAL,
        polar_kg_m2=0.0,
        stiffness=plane_spring(TRANSLATION, 0.0, TILT),
    )
    disk = dataclasses.replace(disk, spin_softening=np.diag([0, 0, TILT / 1e6, TILT / 1e6]))
    diagram = rd.campbell(one_rotor(disk, []), [0.0, 500.0, 900.0, 1200.0], branch_count=4)
    exact = np.sqrt((TILT - TILT / 1e6 * diagram.speeds_rad_s[:3] ** 2) / DIAMETRAL)
    np.testing.assert_allclose(diagram.eigenvalues[2:, :3].imag, [exact, exact], rtol=1e-12)
    assert np.isnan(diagram.frequency_hz[2:, 3]).all()
    assert (diagram.whirl[2:, 3] == "").all()
    np.testing.assert_allclose(diagram.eigenvalues[:2].imag, MEET_OMEGA, rtol=1e-12)
    assert {note.branches for note in _by_kind(diagram, "ended")} == {(2,), (3,)}
    assert len(_by_kind(diagram, "indefinite")) == 1


def test_no_speed_is_solved_twice_where_branches_end(monkeypatch):
    disk = hub(stiffness=plane_spring(TRANSLATION, 0.0, TILT), polar_kg_m2=0.0)
    disk = dataclasses.replace(disk, spin_softening=disk.stiffness / 1e6)
    solved = []

    def counted(assembled, speed, count=None):
        solved.append(speed)
        return rd.modes_at_speed(assembled, speed, count)

    monkeypatch.setattr(tracking, "modes_at_speed", counted)
    diagram = rd.campbell(one_rotor(disk, []), [0.0, 900.0, 1500.0], frequency_max_hz=100.0)
    assert np.isnan(diagram.frequency_hz[:, 2]).all()
    assert len(solved) == len(set(solved))


def test_speeds_beyond_the_basis_are_noted():
    disk = dataclasses.replace(
        hub(stiffness=plane_spring(TRANSLATION, 0.0, TILT)), maximum_speed_rad_s=300.0
    )
    system = rd.assemble({"disk": turning(disk, -2.0)}, ())
    assert system.speed_limit_rad_s == 150.0
    (note,) = _by_kind(rd.campbell(system, [0.0, 200.0], branch_count=1), "range")
    assert note.speed_rad_s == 150.0
    assert not _by_kind(rd.campbell(system, [0.0, 150.0], branch_count=1), "range")


def test_a_diagram_may_be_empty():
    diagram = rd.campbell(coupled_disk(0.0), [0.0, 1.0], frequency_max_hz=1.0)
    assert diagram.frequency_hz.shape == diagram.whirl.shape == (0, 2)
    assert [note.kind for note in diagram.notes] == ["empty"]


def test_one_speed_is_the_first_column_of_many():
    system = coupled_disk(0.0)
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
