"""Error estimates along the branches of a Campbell diagram and of critical speeds."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    SKEW,
    connect,
    one_rotor,
    polynomial_law,
    truncated,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.estimates.campbell_errors import campbell_errors, interpolation_part
from solidwhirl.rotordyn.estimates.critical_speed_errors import critical_speed_errors
from solidwhirl.rotordyn.estimates.eigenvalue_errors import frequency_errors
from solidwhirl.rotordyn.perturbation import lowest_modes

PART, OVER = "mode_truncation", "speed_interpolation"
SPEEDS = np.linspace(0.0, 1500.0, 7)
LAW = polynomial_law((1.0, -1e-4), (1.0, -2e-4, 1e-8), (1.0, 1e-4), top=4000.0)


@pytest.fixture(scope="module")
def pair(full):
    """The whole and the truncated rotor on bearings of any kind."""

    def build(kept=12, damping=0.0, law=None, cross=0.0, slack=0.0):
        own = (None, np.diag([7e7, 5e7]) + cross * SKEW, damping)
        held = [connect(end, f"rotor.{end}", *own, speed_law=law) for end in ("left", "right")]
        return one_rotor(full, held), one_rotor(truncated(full, kept, slack=slack), held)

    return build


@pytest.mark.parametrize("damping", [0.0, 5e3])
def test_branches_are_wrong_by_their_estimates(pair, damping):
    whole, cut = pair(damping=damping)
    exact, diagram = (rd.campbell(s, SPEEDS, branch_count=5) for s in (whole, cut))
    found = campbell_errors(cut, diagram)
    true = np.abs(1.0 - exact.eigenvalues / diagram.eigenvalues)
    np.testing.assert_allclose(found.total, true, rtol=0.1)  # (s/ω_c)²
    assert set(found.parts) == {PART, OVER, "eigen_solver"}
    np.testing.assert_allclose(found.total, sum(found.parts.values()), rtol=1e-14)


def test_errors_of_a_damped_diagram_need_few_whole_spectra(pair, monkeypatch):
    """The lowest modes that others are continued to have the errors of whole spectra."""
    speeds = np.linspace(0.0, 800.0, 21)
    for law, cross in ((None, 1e6), (LAW, 0.0)):
        _, cut = pair(kept=24, damping=900.0, law=law, cross=cross)
        diagram = rd.campbell(cut, speeds, branch_count=5)
        with SYSTEMS.counted() as counts:
            found = campbell_errors(cut, diagram)
        assert counts["continued"] > 15 and counts["eigenproblems"] < 5
        with monkeypatch.context() as patch:
            patch.setattr(lowest_modes, "known_spectrum", lambda *_: None)
            whole = campbell_errors(cut, diagram)
        for part, values in found.parts.items():
            limit = 1e-10 if part == "eigen_solver" else 1e-7 * whole.total.max()
            np.testing.assert_allclose(values, whole.parts[part], rtol=1e-6, atol=limit)


def test_parts_of_a_branch_are_those_of_its_modes(pair):
    _, cut = pair(damping=5e3)
    diagram = rd.campbell(cut, SPEEDS, branch_count=5)
    found = campbell_errors(cut, diagram)
    for place in (0, 3, 6):
        modes = rd.modes_at_speed(cut, float(SPEEDS[place]))
        single = frequency_errors(cut, modes).parts[PART]
        columns = np.abs(diagram.eigenvalues[:, place, None] - modes.eigenvalues).argmin(axis=1)
        both = found.parts[PART][:, place] + found.parts[OVER][:, place]
        np.testing.assert_allclose(both, single[columns], rtol=1e-6)
    assert not found.parts[OVER][:, [0, -1]].any()
    assert (found.parts[OVER] >= 0).all() and found.parts[OVER].any()


def test_interpolation_is_what_exceeds_the_line_in_the_square_of_the_speed():
    speeds = np.array([0.0, 1.0, 2.0, 4.0])
    line = 0.1 + 0.02 * speeds**2
    bump, dip = np.array([0.0, 0.3, 0.0, 0.0]), np.array([0.0, 0.0, -0.05, 0.0])
    nothing = np.full(4, np.nan)
    ended = np.where(speeds < 4, line, np.nan)
    found = interpolation_part(speeds, np.array([line, line + bump + dip, nothing, ended]))
    np.testing.assert_allclose(found[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(found[1], bump, atol=1e-15)
    assert np.isnan(found[2]).all()
    np.testing.assert_allclose(found[3], [0.0, 0.0, 0.0, np.nan], atol=1e-15)
    # from fast to slow, and against the reference sense, it is the same
    np.testing.assert_allclose(interpolation_part(speeds[::-1], (line + bump)[None, ::-1]),
                               bump[None, ::-1], atol=1e-15)  # fmt: skip
    np.testing.assert_allclose(interpolation_part(-speeds, (line + bump)[None]), bump[None],
                               atol=1e-15)  # fmt: skip
    assert interpolation_part(speeds[:1], line[None, :1]) == 0.0


def test_absent_branches_are_nan_and_foreign_diagrams_refused(pair):
    whole, cut = pair()
    diagram = rd.campbell(cut, SPEEDS, branch_count=5)
    values = diagram.eigenvalues.copy()
    values[4, 5:] = np.nan
    ended = dataclasses.replace(diagram, eigenvalues=values, frequency_hz=values.imag / 2 / np.pi)
    found = campbell_errors(cut, ended)
    for part in (*found.parts.values(), found.total):
        assert np.isnan(part[4, 5:]).all() and np.isfinite(part[:4]).all()
    with pytest.raises(rd.AnalysisError, match="no mode of this system"):
        campbell_errors(whole, diagram)


CASES = {
    "undamped": {},
    "damped": {"damping": 5e3},
    "cross-coupled": {"damping": 5e3, "cross": 1e7},
    "law": {"law": LAW},
    "damped law": {"law": LAW, "damping": 2e4},
}


@pytest.mark.parametrize("ratio", [1.0, -0.7, 2.0])
@pytest.mark.parametrize("case", CASES)
def test_critical_speeds_are_wrong_by_their_estimates(pair, case, ratio):
    whole, cut = pair(**CASES[case])
    limit = 1500.0 / abs(ratio)
    exact, coarse = (rd.critical_speeds(system, ratio, limit) for system in (whole, cut))
    assert len(exact) == len(coarse) >= 3
    found = critical_speed_errors(cut, coarse)
    pairs = zip(exact, coarse, strict=True)
    true = np.array([abs(1.0 - a.speed_rad_s / b.speed_rad_s) for a, b in pairs])
    # (s/ω_c)², and 1e-11 of accuracy of the speeds with damping
    np.testing.assert_allclose(found.total, true, rtol=0.05, atol=3e-11)
    assert OVER not in found.parts


def test_critical_speeds_take_the_share_of_their_branch(pair):
    _, cut = pair(damping=5e3)
    coarse = rd.critical_speeds(cut, 1.0, 1400.0)
    # one of the speeds of the diagram is the first critical speed itself
    speeds = np.sort(np.append(SPEEDS, coarse[0].speed_rad_s))
    diagram = rd.campbell(cut, speeds, branch_count=6)
    branches = campbell_errors(cut, diagram)
    found = critical_speed_errors(cut, coarse, branches)
    plain = critical_speed_errors(cut, coarse)
    np.testing.assert_allclose(found.total, plain.total, rtol=1e-12)
    place = int(np.searchsorted(speeds, coarse[0].speed_rad_s))
    row = int(np.abs(diagram.frequency_hz[:, place] - coarse[0].frequency_hz).argmin())
    over, rest = (branches.parts[part][row, place] for part in (OVER, PART))
    share = found.parts[OVER][0] / (found.parts[OVER][0] + found.parts[PART][0])
    assert share == pytest.approx(over / (over + rest), rel=1e-9) and share > 0.01
    # beyond the diagram nothing is known of the share
    short = campbell_errors(cut, rd.campbell(cut, SPEEDS[:2], branch_count=6))
    last = critical_speed_errors(cut, coarse, short)
    assert last.parts[OVER][-1] == 0.0 and last.parts[PART][-1] == plain.parts[PART][-1]


def test_critical_speeds_that_rounding_moved_are_wrong_by_that(pair):
    """Where the branch is not met, the distance along the line counts as an error of the solver."""
    _, cut = pair()
    (first, *_) = rd.critical_speeds(cut, 1.0, 900.0)
    off = 1e-4
    moved = dataclasses.replace(
        first,
        speed_rad_s=first.speed_rad_s * (1.0 + off),
        frequency_hz=first.frequency_hz * (1.0 + off),
    )
    found = critical_speed_errors(cut, (first, moved)).parts["eigen_solver"]
    # the branch is straight over so short a way
    assert found[0] < 1e-3 * off
    assert found[1] == pytest.approx(off, rel=1e-2)


def test_no_critical_speeds_and_foreign_ones(pair):
    whole, cut = pair()
    assert critical_speed_errors(cut, ()).total.shape == (0,)
    diagram = campbell_errors(cut, rd.campbell(cut, SPEEDS[:2], branch_count=2))
    assert critical_speed_errors(cut, (), diagram).total.shape == (0,)
    foreign = pair(kept=4)[1]
    with pytest.raises(rd.AnalysisError, match="no mode of this system"):
        critical_speed_errors(foreign, rd.critical_speeds(whole, 1.0, 900.0))
