"""Unstable ranges of speed against dense sampling of the general eigenproblem, written here."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from rotors import (
    between_bearings,
    connect,
    eigenvalues_of,
    general,
    ground,
    hub,
    one_rotor,
    polynomial_law,
    table_law,
    three_disk,
    three_disk_element,
)
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.modes.damping import DampingRule
from solidwhirl.rotordyn.stability.intervals import stability_chart, unstable_intervals
from solidwhirl.rotordyn.stability.whirl_decrements import whirl_decrements

CROSS = np.array([[0.0, 1.0], [-1.0, 0.0]])
EYE = np.eye(2)
NEUTRAL = 1e-8


class Case(NamedTuple):
    """Matrices of a rotor, the law of its bearing on the first two coordinates, the range."""

    mass: np.ndarray
    stiffness: np.ndarray
    gyroscopic: np.ndarray
    damping: np.ndarray
    circulatory: np.ndarray
    isotropic: bool
    rows: np.ndarray
    k: np.ndarray
    c: np.ndarray
    interpolation: str
    top: float
    places: tuple[float, ...]

    def law(self, speeds):
        """Stiffness and damping of the bearing at speeds, each (s, 2, 2)."""
        if self.interpolation == "polynomial":
            powers = speeds[:, None] ** np.arange(len(self.c))
            damping = np.einsum("sp,pij->sij", powers, self.c)
            return self.k[0] + np.zeros((len(speeds), 1, 1)), damping
        inside = np.clip(speeds, self.rows[0], self.rows[-1])
        both = []
        for values in (self.k, self.c):
            flat = values.reshape(len(values), 4)
            if self.interpolation == "linear":
                at = np.array([np.interp(inside, self.rows, column) for column in flat.T]).T
            else:
                at = PchipInterpolator(self.rows, flat)(inside)
            both.append(at.reshape(-1, 2, 2))
        return both

    def growth(self, speeds, neutral=NEUTRAL):
        """Largest Re λ − 1e-8 |λ| at speeds, by the companion matrix in units of the mean rate."""
        speeds = np.atleast_1d(np.asarray(speeds, dtype=float))
        n = len(self.mass)
        k = np.repeat(self.stiffness[None], speeds.size, 0)
        k = k + speeds[:, None, None] * self.circulatory
        c = self.damping + speeds[:, None, None] * self.gyroscopic
        of_bearing = self.law(speeds)
        k[:, :2, :2] += of_bearing[0]
        c[:, :2, :2] += of_bearing[1]
        rate = np.sqrt(np.abs(np.trace(self.stiffness)) / np.trace(self.mass))
        companion = np.zeros((speeds.size, 2 * n, 2 * n))
        companion[:, :n, n:] = rate * np.eye(n)
        companion[:, n:, :n] = -np.linalg.solve(self.mass, k) / rate
        companion[:, n:, n:] = -np.linalg.solve(self.mass, c)
        values = np.linalg.eigvals(companion)
        return (values.real - neutral * np.abs(values)).max(axis=1)


def _body(rng):
    """Random rotor of 4, 6 or 8 coordinates, in pairs that turn into each other, or without."""
    pairs = int(rng.integers(2, 5))
    isotropic = bool(rng.random() < 0.4)
    spread = rng.normal(size=(pairs, pairs)) * 0.2
    small = np.diag(rng.uniform(1, 4, pairs)) + spread @ spread.T
    rates = rng.uniform(60, 400, pairs) ** 2
    turn = rng.normal(size=(pairs, pairs)) * 0.3 + np.eye(pairs)
    k = turn.T @ np.diag(rates) @ turn
    g = np.diag(rng.uniform(0, 1.5, pairs))
    mass, stiffness, gyroscopic = np.kron(small, EYE), np.kron(k, EYE), np.kron(g, CROSS)
    if not isotropic:
        uneven = rng.normal(size=(2 * pairs, 2 * pairs)) * 0.15
        change = np.eye(2 * pairs) + uneven
        stiffness = change.T @ stiffness @ change
        skew = rng.normal(size=(2 * pairs, 2 * pairs)) * 0.2
        gyroscopic = gyroscopic + skew - skew.T
    return mass, 0.5 * (stiffness + stiffness.T), gyroscopic, isotropic


def _case(seed):
    rng = np.random.default_rng(seed)
    mass, stiffness, gyroscopic, isotropic = _body(rng)
    n, top = len(mass), float(rng.uniform(200, 2000))
    damping = np.kron(np.diag(rng.uniform(0.5, 6, n // 2)), EYE)
    circulatory = np.zeros((n, n))
    kind = ("film", "damping", "stiffness", "meeting", "inside", "polynomial", "marginal")[seed % 7]
    base_k, base_c = rng.uniform(1e3, 5e4), rng.uniform(5, 60)
    rows, k, c = np.array([0.0, top]), base_k * EYE + np.zeros((2, 2, 2)), None
    interpolation = str(rng.choice(["linear", "monotone"]))
    places = []
    if kind in ("film", "damping", "stiffness"):
        rows, k, c, places = _dips(rng, kind, stiffness, base_k, base_c, top)
    elif kind == "meeting":
        damping = damping * 10 ** rng.uniform(-4, -1)
        base_c = base_c * 10 ** rng.uniform(-4, -1)
        gyroscopic = gyroscopic * 10 ** rng.uniform(-7, 0)
        place, cross = rng.uniform(0.1, 0.9), base_k * 10 ** rng.uniform(-4, -1.5)
        k = np.array([[[base_k * (1 + s), cross], [-cross, base_k]] for s in (-place, 1 - place)])
        places = [place * top]
    elif kind == "inside":
        own = rng.uniform(0.5, 8)
        inner = own * np.diag(np.repeat(rng.uniform(0, 1, n // 2), 2))
        damping, circulatory = damping + inner, inner @ np.kron(np.eye(n // 2), CROSS)
    elif kind == "polynomial":
        place, half = rng.uniform(0, top), top * 10 ** rng.uniform(-3, -1)
        # c ((Ω − place)² / half² − 1), deep enough to beat the damping of the body
        scale = rng.uniform(20, 200)
        parts = scale * np.array([(place / half) ** 2 - 1, -2 * place / half**2, half**-2])
        c, interpolation = parts[:, None, None] * EYE, "polynomial"
        places = [place]
    elif kind == "marginal":
        count = int(rng.integers(2, 7))
        rows = np.sort(np.append(rng.uniform(0, top, count - 2), [0.0, top]))
        k = base_k * (rng.uniform(0.1, 20, (count, 1, 1)) * EYE + rng.normal(size=(count, 2, 2)))
        c = base_c * (EYE + 0.2 * rng.normal(size=(count, 2, 2)))
        damping = damping * 10 ** rng.uniform(-4, 0)
        gyroscopic = gyroscopic * 10 ** rng.uniform(-3, 0)
    if c is None:
        c = base_c * EYE + np.zeros((2, 2, 2))
    case = Case(
        mass, stiffness, gyroscopic, damping, circulatory, isotropic, rows, k, c, interpolation,
        top, tuple(places),
    )  # fmt: skip
    return _barely_unstable(case, rng) if kind == "marginal" else case


def _barely_unstable(case, rng):
    """The case with as much damping as leaves one narrow window of a smooth maximum of growth."""
    speeds = np.linspace(0, case.top, 401)
    width = 10 ** rng.uniform(-3, -1.5)
    # more damping 2 d M moves all values by about −d
    first = float(case.growth(speeds).max())
    low, high = first - abs(first), first + abs(first)
    for _ in range(20):
        more = 0.5 * (low + high)
        damped = case._replace(damping=case.damping + 2 * more * case.mass)
        growth = damped.growth(speeds)
        at = speeds[growth.argmax()]
        near = at + case.top * np.linspace(-0.05, 0.05, 101)
        near = near[(near > 0) & (near < case.top)]
        part = np.count_nonzero(damped.growth(near) > 0) / 1000
        if 0.5 * width < part < 2 * width and (growth > 0).mean() < 4 * width:
            break
        low, high = (more, high) if part > width else (low, more)
    return damped._replace(places=(float(at),))


def _dips(rng, kind, stiffness, base_k, base_c, top):
    """One to three rows, anywhere, that feed a motion, between two close ones that do not."""
    half = top * 10 ** rng.uniform(-3.3, -1.3, int(rng.integers(1, 4)))
    middle = rng.uniform(0, top, half.size)
    middle[0] = rng.choice([0.0, top, middle[0], middle[0]])
    rows = {0.0: 0, top: 0, float(rng.uniform(1.5, 20) * top): 0}
    for place, width in zip(middle, half, strict=True):
        rows |= {float(place + s * width): 0 for s in (-1, 1) if place + s * width > 0}
    rows |= {float(place): 1 for place in middle}
    speeds = np.array(sorted(rows))
    k = np.repeat(base_k * EYE[None], speeds.size, 0)
    c = np.repeat(base_c * EYE[None], speeds.size, 0)
    for at, speed in enumerate(speeds):
        if not rows[speed]:
            continue
        if kind == "film":
            k[at] += base_c * rng.uniform(100, 3000) * CROSS
        elif kind == "damping":
            c[at] = -rng.uniform(2, 100) * (EYE if rng.random() < 0.5 else np.diag([1.0, -0.2]))
        else:
            k[at] = -rng.uniform(0.2, 3) * np.trace(stiffness) * np.diag([1.0, rng.uniform(0, 1)])
    return speeds, k, c, [float(v) for v in middle]


def _assembled(case):
    body = general(case.mass, case.stiffness, np.zeros_like(case.mass))
    body = dataclasses.replace(body, gyroscopic=case.gyroscopic)
    if case.isotropic:
        turn = np.kron(np.eye(len(case.mass) // 2), -CROSS)
        body = dataclasses.replace(body, spin_generator=turn)
    if case.interpolation == "polynomial":
        parts = tuple(float(v) for v in case.c[:, 0, 0])
        law = polynomial_law((1.0,), (1.0,), parts, parts, top=case.top)
        film = connect("film", "rotor.hub", None, case.k[0], 1.0, speed_law=law)
    else:
        law = table_law(case.rows, case.k, case.c, case.interpolation)
        film = connect("film", "rotor.hub", speed_law=law)
    system = one_rotor(body, [film])
    damping = system.damping + case.damping
    return dataclasses.replace(system, damping=damping, circulatory_stiffness=case.circulatory)


def _sampled(case, found, count):
    """Ranges of growth by dense sampling, with their ends solved for, and their largest growth."""
    grid = [np.linspace(0.0, case.top, count)]
    knots = [v for v in case.rows if 0 < v < case.top]
    grid += [np.linspace(a, b, 33) for a, b in pairwise([0.0, *knots, case.top])]
    for place in case.places:
        grid += [place + case.top * w * np.linspace(-1, 1, 101) for w in (1e-3, 1e-2, 1e-1)]
    ends = [0.0, *(v for r in found for v in (r.low_rad_s, r.high_rad_s)), case.top]
    grid.append(np.array([0.5 * (a + b) for a, b in pairwise(ends)]))
    speeds = np.unique(np.concatenate(grid))
    speeds = speeds[(speeds >= 0) & (speeds <= case.top)]
    growth = case.growth(speeds)
    unstable = growth > 0

    damped = case.growth(speeds, 0.0) < -1e-11

    def edge(left, right):
        # where nothing is damped there is no change of sign, and growth beyond rounding counts
        step = -1 if unstable[right] else 1
        calm = left if unstable[right] else right
        beyond = next(
            (k for k in range(calm, calm + 400 * step, step) if 0 <= k < speeds.size and damped[k]),
            None,
        )
        level = NEUTRAL if beyond is None else 0.0
        ends = sorted((speeds[left + right - calm], speeds[calm if beyond is None else beyond]))
        return brentq(lambda v: float(case.growth(v, level)[0]), *ends, xtol=1e-13, rtol=1e-13)

    change = np.flatnonzero(unstable[1:] != unstable[:-1])
    edges = [edge(k, k + 1) for k in change]
    edges = [0.0] * bool(unstable[0]) + edges + [case.top] * bool(unstable[-1])
    ranges = list(zip(edges[::2], edges[1::2], strict=True))
    growth = case.growth(speeds, 0.0)
    tops = [float(growth[(speeds >= a) & (speeds <= b)].max()) for a, b in ranges]
    return ranges, tops


def _compare(seed, count):
    case = _case(seed)
    found = unstable_intervals(_assembled(case), 0.0, case.top)
    expected, tops = _sampled(case, found, count)
    got = [(r.low_rad_s, r.high_rad_s) for r in found]
    assert len(got) == len(expected), (seed, got, expected)
    if got:
        np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-9 * case.top)
    for record, (low, high), growth in zip(found, expected, tops, strict=True):
        assert record.opens == (low > 0)
        assert record.closes == (high < case.top)
        assert record.growth_1_s >= growth * (1 - 1e-6) - 1e-12
        assert record.growth_1_s == pytest.approx(
            float(case.growth(record.speed_rad_s, 0.0)[0]), rel=1e-6, abs=1e-9 * case.top
        )
        assert (record.kind == "flutter") == (record.frequency_hz > 0) == bool(record.whirl)
    return len(got)


def test_random_rotors():
    """Windows anywhere, narrow ones at rows that no even grid meets: none missed, none false."""
    assert sum(_compare(seed, 300) for seed in range(8)) > 3


@pytest.mark.verify
@pytest.mark.parametrize("first", [8, 28, 48])
def test_more_random_rotors(first):
    for seed in range(first, first + 20):
        _compare(seed, 4000)


RPM = np.pi / 30


@pytest.mark.parametrize(
    ("top_rpm", "middle_rpm", "half_rpm"),
    [(9000, 4321.0, 7.0), (20_000, 16_170.0, 170.0), (9000, 9000.0, 7.0), (9000, 0.0, 7.0)],
)
def test_window_at_one_row(top_rpm, middle_rpm, half_rpm):
    """Damping falls linearly from c to −c and back: it is negative over half the width."""
    rows = np.array([middle_rpm - 2 * half_rpm, middle_rpm, middle_rpm + 2 * half_rpm, 3e4])
    rows, signs = rows[rows >= 0], np.array([1.0, -1.0, 1.0, 1.0])[rows >= 0]
    law = table_law(rows * RPM, np.full(rows.size, 1e6), 200.0 * signs, "linear")
    bearing = connect("b", "rotor.hub", drag=5.0, speed_law=law)
    system = one_rotor(hub(stiffness=np.diag([0.0, 0.0, 2e4, 2e4])), [bearing])
    (found,) = unstable_intervals(system, 0.0, top_rpm * RPM)
    ends = np.clip([middle_rpm - half_rpm, middle_rpm + half_rpm], 0, top_rpm)
    np.testing.assert_allclose(np.array([found.low_rad_s, found.high_rad_s]) / RPM, ends, rtol=1e-9)
    assert (found.opens, found.closes) == (middle_rpm > 0, middle_rpm < top_rpm)
    # λ² + 2 σ λ + ω² with σ = −c / 2m at the row
    assert found.growth_1_s == pytest.approx(10.0, rel=1e-9)
    assert found.speed_rad_s == pytest.approx(middle_rpm * RPM, abs=1e-9)
    assert found.kind == "flutter"
    damped = np.sqrt(1e5 - 100.0 * (middle_rpm in (0, top_rpm)) * (middle_rpm == 0))
    assert found.frequency_hz == pytest.approx(damped / (2 * np.pi), rel=1e-9)
    before = max(middle_rpm - 1.01 * half_rpm, 1.0) * RPM
    assert len(unstable_intervals(system, 0.0, before)) == (middle_rpm == 0)


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_sleeping_top(damping):
    """A top stands up from Ω = 2 √(k I) / Ip on; damping in the inertial frame tips it always.

    I θ'' + (d − iΩ Ip) θ' − k θ = 0 for the tilt θ = rx + i ry.
    """
    tilt, polar, diametral = 50.0, 0.1, 0.05
    body = hub(polar_kg_m2=polar, diametral_kg_m2=diametral, stiffness=np.diag([1e6, 1e6, 0, 0]))
    spring = connect("b", "rotor.hub", damping=damping, tilt=-tilt, drag=damping)
    system = one_rotor(body, [spring])
    limit = 2 * np.sqrt(tilt * diametral) / polar
    (found,) = unstable_intervals(system, 0.0, 3 * limit)
    assert (found.low_rad_s, found.opens, found.kind) == (0.0, False, "divergence")
    assert found.closes == (damping == 0)
    assert found.speed_rad_s == pytest.approx(0.0, abs=1e-6)
    roots = np.roots([diametral, damping, -tilt])
    assert found.growth_1_s == pytest.approx(roots.max(), rel=1e-9)
    if damping == 0:
        assert found.high_rad_s == pytest.approx(limit, rel=1e-9)
        meeting = limit * polar / (2 * diametral) / (2 * np.pi)
        assert found.frequency_end_hz == pytest.approx(meeting, rel=1e-6)


def test_two_undamped_modes_meet_and_part():
    """K = [[a(Ω), e], [−e, b]]: undamped flutter where |a − b| < 2 e, and nowhere else."""
    stiffness, cross, top = 1e5, 40.0, 1000.0
    rows = np.array([0.0, top])
    ramp = np.array([0.4, 1.9]) * stiffness
    k = ramp[:, None, None] * np.diag([1.0, 0.0]) + cross * CROSS
    law = table_law(rows, k, interpolation="linear")
    body = general(np.eye(5), np.diag([0.0, stiffness, 9e5, 8e5, 7e5]), np.zeros((5, 5)))
    system = one_rotor(body, [connect("b", "rotor.hub", speed_law=law)])
    (found,) = unstable_intervals(system, 0.0, top)
    slope = (ramp[1] - ramp[0]) / top
    ends = (stiffness + np.array([-2.0, 2.0]) * cross - ramp[0]) / slope
    assert ends[1] - ends[0] < 1.1e-3 * top
    np.testing.assert_allclose([found.low_rad_s, found.high_rad_s], ends, rtol=1e-9)
    # λ² = −b ± i e in the middle
    assert found.growth_1_s == pytest.approx(np.sqrt(-stiffness + 1j * cross).real, rel=1e-6)


def test_one_way_coupling_grows_from_rest_on():
    """k_yx = 0: at rest pairs are defective, and growth begins with the root of the speed."""
    cross = np.array([[7e7, -3e7], [0.0, 7e7]])
    held = [connect("rotor.left", "rotor.left", stiffness=cross), ground("rotor", "right", 7e7)]
    system = one_rotor(three_disk_element(), held)
    (found,) = unstable_intervals(system, 0.0, 1500.0)
    # beside a defective root λ0 growth is that of √(Ω g): that it counts needs 1e-8 of |λ|
    assert 0.0 <= found.low_rad_s < 1e-9
    slow, fast = (eigenvalues_of(system, v, 1e3).real.max() for v in (1e-2, 1.0))
    assert fast / slow == pytest.approx(10.0, rel=0.02)
    largest = eigenvalues_of(system, found.speed_rad_s, 1e3).real.max()
    assert found.growth_1_s == pytest.approx(largest, rel=1e-6)


def test_free_motions_are_no_instability():
    """A free long rotor with damping inside does not stay upright: only its largest axis would."""
    free = one_rotor(three_disk_element(), [])
    assert unstable_intervals(free, 0.0, 2500.0) == ()
    inside = rd.InternalDamping(stiffness_coefficient_s=1e-6)
    lossy = one_rotor(three_disk_element(), internal_damping=inside)
    (found,) = unstable_intervals(lossy, 0.0, 2500.0)
    assert (found.whirl, found.closes) == ("forward", False)
    # the precession (Ip/It) Ω is slower than the material turns
    assert 0 < 2 * np.pi * found.frequency_hz < 0.5 * found.low_rad_s
    # growth as the rotor deforms is too slow to be seen at first, but positive
    assert abs(found.eigenvalue.real) < 2e-8 * abs(found.eigenvalue)


def test_onset_is_that_of_the_mode_that_grows():
    """Slow modes of soft supports are as near to the axis at the onset of the elastic one."""
    inside = rd.InternalDamping(stiffness_coefficient_s=1e-6)
    system = between_bearings(three_disk_element(), 100.0, 90.0, 1.0, inside=inside)
    (found,) = unstable_intervals(system, 0.0, 2500.0)
    values = eigenvalues_of(system, found.low_rad_s, 1e3)
    forward = values[np.abs(values - 1483j).argmin()]
    assert abs(found.eigenvalue - forward) < 1e-7 * abs(forward)
    assert abs(forward.real) < 1e-9 * abs(forward)
    assert found.whirl == "forward"


def test_undamped_isotropic_pair_is_neutral():
    """Real parts of rounding are neither growth nor a window, whatever solver finds them."""
    body = hub(mass_kg=10, polar_kg_m2=0.08, stiffness=np.diag([9e5, 9e5, 2e4, 2e4]))
    # a support of negative stiffness leaves no proof from the signs of the bearings
    law = table_law([0.0, 2000.0], [-3e5, -3e5])
    system = one_rotor(body, [connect("b", "rotor.hub", speed_law=law)])
    assert unstable_intervals(system, 0.0, 2000.0) == ()
    chart = stability_chart(system, np.linspace(0.0, 2000.0, 5))
    assert not chart.unstable_count.any()
    assert (chart.log_decrement == 0).all()
    assert (chart.first_forward.log_decrement == 0).all()


@pytest.mark.parametrize(("low", "high"), [(0.0, np.nan), (5.0, 5.0), (-np.inf, 0.0)])
def test_ranges_without_meaning_are_refused(low, high):
    with pytest.raises(rd.AnalysisError, match=r"speeds are|must be above"):
        unstable_intervals(three_disk(), low, high)


def test_first_forward_and_backward_mode_of_a_disk():
    """m z'' + d z' + k z and I θ'' + (d − iΩ Ip) θ' + kt θ: closed form, axis held harder."""
    mass, k, d, tilt, polar, diametral, loss = 10.0, 4e6, 300.0, 2e4, 0.1, 0.05, 3.0
    body = hub(mass, polar, diametral, np.diag([k, k, tilt, tilt]))
    system = one_rotor(body, [connect("b", "rotor.hub", damping=d, drag=loss)])
    speeds = np.array([0.0, 100.0, 600.0])
    found = whirl_decrements(system, speeds)
    for at, speed in enumerate(speeds):
        roots = np.concatenate(
            (np.roots([mass, d, k]), np.roots([diametral, loss - 1j * speed * polar, tilt]))
        )
        for sign, first in ((1, found.first_forward), (-1, found.first_backward)):
            whirl = roots[sign * roots.imag > 0]
            root = whirl[np.abs(whirl.imag).argmin()]
            assert first.frequency_hz[at] == pytest.approx(abs(root.imag) / 2 / np.pi, rel=1e-4)
            decrement = -2 * np.pi * root.real / abs(root.imag)
            assert first.log_decrement[at] == pytest.approx(decrement, rel=1e-4)


def test_heavily_damped_modes_are_not_the_first():
    """Damping ratios of 0.8 across the axis: the first mode of either whirl is a tilt."""
    body = hub(mass_kg=10.0, polar_kg_m2=0.0, stiffness=np.diag([1e5, 1e5, 2e4, 2e4]))
    system = one_rotor(body, [connect("b", "rotor.hub", damping=1600.0)])
    found = whirl_decrements(system, [0.0, 500.0])
    tilts = np.sqrt(2e4 / 0.05) / (2 * np.pi)
    hard = whirl_decrements(system, [500.0], DampingRule(amplification_min=0.0))
    for first in (found.first_forward, found.first_backward):
        np.testing.assert_allclose(first.frequency_hz, tilts, rtol=1e-6)
    assert (hard.first_forward.frequency_hz < 0.2 * tilts).all()
