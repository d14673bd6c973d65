"""Pictures of sweeps and the numbers behind them, from rows with known answers."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from solidwhirl.core.key_units import label_of, wrapped
from solidwhirl.sweep.analysis import SweepPictureSettings, analyse_sweep, sweep_document
from solidwhirl.sweep.bands import LEVELS, least_samples, order_statistics, quantiles
from solidwhirl.sweep.design import SweepPictureError, sweep_designs
from solidwhirl.sweep.margins import band_margin
from solidwhirl.sweep.matching import match_curves, visiting_order
from solidwhirl.sweep.records import BatchRow
from solidwhirl.sweep.sensitivity import rank_limits
from solidwhirl.sweep.tracks import critical_tracks
from solidwhirl.sweep_pictures.all import draw_batch
from solidwhirl.sweep_pictures.parts import in_powers_of_ten

RPM = 30.0 / np.pi
POLAR, DIAMETRAL, TILT = 0.05, 0.2, 6e4
SPEEDS = np.linspace(0.0, 9000.0, 10)
CORNERS = [{"p": p, "q": q} for p in (0.0, 1.0) for q in (0.0, 1.0)]


def laval_row(number, values, stiffness=4e6, mass=15.0, tilt=TILT, top_rpm=1e9, scene="laval"):
    """Massless shaft with a disk in the middle.

    Lateral ω² = k/m in both senses, conical I_d ω² ∓ I_p Ω ω = c, so that at Ω = ω
    Ω² = c / (I_d ∓ I_p) forward and backward. Rows list what they have by rising speed, without
    a sign of which is which but the whirl.
    """
    lateral = np.sqrt(stiffness / mass)
    critical = [
        (lateral, "forward"),
        (lateral, "backward"),
        (np.sqrt(tilt / (DIAMETRAL - POLAR)), "forward"),
        (np.sqrt(tilt / (DIAMETRAL + POLAR)), "backward"),
    ]
    critical = sorted((w * RPM, name) for w, name in critical if w * RPM < top_rpm)
    spin = SPEEDS / RPM
    root = np.sqrt((POLAR * spin) ** 2 + 4.0 * DIAMETRAL * tilt)
    conical = [(sign * POLAR * spin + root) / (2.0 * DIAMETRAL) for sign in (-1, 1)]
    branches = sorted([np.full(SPEEDS.size, lateral), *conical], key=lambda b: b[0])
    return BatchRow(
        case=f"{scene}-{number:04d}",
        scene=scene,
        status="done",
        values=values,
        critical_speed_rpm=tuple(s for s, _ in critical),
        critical_frequency_hz=tuple(s / 60.0 for s, _ in critical),
        critical_whirl=tuple(w for _, w in critical),
        critical_error_estimate=tuple(0.01 for _ in critical),
        campbell_speed_rpm=tuple(SPEEDS),
        campbell_frequency_hz=tuple(tuple(b / (2.0 * np.pi)) for b in branches),
    )


def speed_row(number, values, *speeds, whirls=("forward",) * 9, error=0.0, ratios=(1.0,) * 9):
    """A row with critical speeds that are given, each with its whirl and its excitation ratio."""
    count = len(speeds)
    return replace(
        laval_row(number, values),
        critical_speed_rpm=speeds,
        critical_frequency_hz=tuple(s * r / 60.0 for s, r in zip(speeds, ratios, strict=False)),
        critical_whirl=tuple(whirls[:count]),
        critical_error_estimate=(error,) * count,
    )


def grid_rows(stiffness, mass):
    pairs = [(k, m) for k in stiffness for m in mass]
    return [
        laval_row(n, {"stiffness_n_per_m": k, "mass_kg": m}, k, m) for n, (k, m) in enumerate(pairs)
    ]


def ladder_rows():
    """The conical critical speeds cross the lateral ones at c = 0.0667 MN m and 0.04 MN m."""
    return [laval_row(n, {"c": c}, tilt=c) for n, c in enumerate(np.linspace(1e4, 1e5, 10))]


def sample_rows(count, spread=0.05, seed=3):
    """k and m lognormal: ω = √(k/m) is lognormal as well."""
    draw = np.random.default_rng(seed).standard_normal((count, 2))
    values = zip(4e6 * np.exp(spread * draw[:, 0]), 15.0 * np.exp(spread * draw[:, 1]), strict=True)
    return [laval_row(n, {"k": k, "m": m}, k, m) for n, (k, m) in enumerate(values)]


def lateral_track(found, whirl="forward"):
    """The critical speed that is √(k/m): the tracks are told apart by what they depend on."""
    rows = found.design.rows
    expected = [RPM * np.sqrt(r.values["k"] / r.values["m"]) for r in rows]
    return next(
        t for t in found.tracks
        if t.whirl == whirl and np.allclose(t.speed_rpm, expected, rtol=1e-9)
    )  # fmt: skip


def test_grid_gives_the_powers_of_the_laval_rotor():
    """ω = √(k/m): d ln ω / d ln k = 1/2, d ln ω / d ln m = -1/2, whatever the spacing."""
    rows = grid_rows(np.array([1.0, 2.0, 4.5, 7.0]) * 1e6, [10.0, 14.0, 22.0])
    (found,) = analyse_sweep(rows, SweepPictureSettings())
    assert found.design.kind == "one_at_a_time"
    moving = [s for s in found.sensitivities if s.quantity.startswith("critical speed")]
    assert len(moving) == 2  # forward and backward; the conical ones are constant
    for item in moving:
        powers = {e.parameter: e.elasticity for e in item.one_at_a_time}
        # ln ω is linear in ln k and ln m, so that differences are exact
        assert powers["stiffness_n_per_m"] == pytest.approx(0.5, abs=1e-9)
        assert powers["mass_kg"] == pytest.approx(-0.5, abs=1e-9)
        assert item.one_at_a_time[0].parameter == "stiffness_n_per_m"
        # the square root over a factor of 7 leaves the chord by 11 %: √s between 1 and √7
        root = np.sqrt(np.array([1.0, 2.0, 4.5, 7.0]))
        chord = np.interp([1.0, 2.0, 4.5, 7.0], [1.0, 7.0], root[[0, -1]])
        stiffness = next(e for e in item.one_at_a_time if e.parameter == "stiffness_n_per_m")
        assert stiffness.off_line == pytest.approx(np.abs(root - chord).max() / np.ptp(root))
        assert not stiffness.linear and not item.linear
        assert any("not linear" in note for note in item.notes)


def test_slope_at_the_baseline_is_that_of_a_parabola():
    """A quadratic response: the three-point derivative is exact, on uneven spacing too."""
    for places in ([1.0, 2.0, 4.0], [1.0, 4.0], [0.5, 1.0, 3.0, 7.0]):
        rows = [
            replace(laval_row(n, {"p": p}), responses={"r.y": 3.0 * p**2 - p + 5.0})
            for n, p in enumerate(places)
        ]
        (found,) = analyse_sweep(rows, SweepPictureSettings(design="grid"))
        effect = next(s for s in found.sensitivities if s.quantity == "r.y").one_at_a_time[0]
        exact = 6.0 * effect.baseline - 1.0
        secant = 3.0 * 5.0 - 1.0  # of p² between 1 and 4
        assert effect.slope == pytest.approx(secant if len(places) == 2 else exact)


def test_samples_give_the_powers_of_the_laval_rotor():
    """ln ω = ½ ln k - ½ ln m: exponents ±½."""
    (found,) = analyse_sweep(sample_rows(200), SweepPictureSettings())
    assert found.design.kind == "samples"
    track = lateral_track(found)
    item = next(s for s in found.sensitivities if s.quantity == track.name)
    powers = {e.parameter: e.elasticity for e in item.regressions}
    assert powers == {"k": pytest.approx(0.5, abs=1e-9), "m": pytest.approx(-0.5, abs=1e-9)}
    assert item.linear and item.r_squared > 0.995  # ±5 %: curvature of the root is 0.1 %
    assert item.power_law_r_squared == pytest.approx(1.0, abs=1e-12)
    # bands of the critical speed are those of its branch of the diagram: lognormal with s √2/2
    exact = RPM * np.sqrt(4e6 / 15.0) * np.exp(stats.norm.ppf(LEVELS) * 0.05 / np.sqrt(2.0))
    at = found.tracks.index(track)
    low, high = found.critical_quantiles.low[:, at], found.critical_quantiles.high[:, at]
    assert ((low < exact) & (exact < high)).all()
    speeds = found.critical_quantiles.value[:, at]
    bands = 60.0 * found.bands.frequency_hz.value[:, :, 0]
    assert any(np.allclose(speeds, branch, rtol=1e-12) for branch in bands.T)


def test_regression_agrees_with_scipy_and_its_limits_hold_95_percent():
    rng = np.random.default_rng(8)
    held = ranks = 0
    trials = 200
    true_rank = 6.0 / np.pi * np.arcsin(0.5 * 0.6)
    for _ in range(trials):
        x = rng.standard_normal(40)
        y = 0.6 * x + 0.8 * rng.standard_normal(40)  # variance 1, correlation 0.6
        rows = [
            replace(laval_row(n, {"x": a}), responses={"r.y": b})
            for n, (a, b) in enumerate(zip(x, y, strict=True))
        ]
        (design,) = sweep_designs(rows, "samples")
        (item,) = _of(design, "r.y")
        (effect,) = item.regressions
        known = stats.linregress(x, y)
        assert effect.coefficient == pytest.approx(known.rvalue)
        assert item.r_squared == pytest.approx(known.rvalue**2)
        spread = np.std(x, ddof=1) / np.std(y, ddof=1)
        half = stats.t.ppf(0.975, 38) * known.stderr * spread
        assert np.ptp(effect.coefficient_limits) == pytest.approx(2.0 * half)
        low, high = np.array(effect.coefficient_limits) / spread
        held += low < 0.6 < high
        ranks += effect.rank_limits[0] < true_rank < effect.rank_limits[1]
    # 95 % of 200 with a standard deviation of 3.1
    assert abs(held - 190) <= 10 and abs(ranks - 190) <= 10
    low, high = rank_limits(0.0, 103, 0.95)
    assert high == -low == pytest.approx(np.tanh(1.959964 / 10.0))
    assert rank_limits(1.0, 20, 0.95) == (1.0, 1.0)


def _of(design, name):
    from solidwhirl.sweep.sensitivity import sensitivity
    from solidwhirl.sweep.tracks import quantities

    return [sensitivity(design, q) for q in quantities(design, ()) if q.name == name]


def test_what_is_not_linear_is_said():
    """y = x² on symmetric samples: no plane and no rank sees it."""
    x = np.linspace(-1.0, 1.0, 41) + 1e-3 * np.sin(np.arange(41.0))
    rows = [replace(laval_row(n, {"x": a}), responses={"r.y": a * a}) for n, a in enumerate(x)]
    (item,) = _of(sweep_designs(rows, "samples")[0], "r.y")
    assert not item.linear and item.r_squared < 0.01
    assert "not linear" in item.notes[0]
    assert np.isnan(item.regressions[0].elasticity)


def test_inputs_that_follow_from_others_or_share_effects_are_said():
    rng = np.random.default_rng(0)
    a, b = rng.standard_normal((2, 60))
    rows = [
        replace(
            laval_row(n, {"a": x, "twice": 2.0 * x + 1.0, "near": x + y}),
            responses={"r.y": x + 0.1 * y},
        )
        for n, (x, y) in enumerate(zip(a, b, strict=True))
    ]
    (item,) = _of(sweep_designs(rows, "samples")[0], "r.y")
    assert [e.parameter for e in item.regressions] == ["a", "near"]
    assert any(n.startswith("twice is left out") for n in item.notes)
    assert any("correlated" in n for n in item.notes)


def test_critical_speeds_are_followed_through_crossings():
    """Index alone would join the lateral to the conical speed; closed forms tell."""
    rows = ladder_rows()
    tracks = critical_tracks(sweep_designs(rows)[0])
    assert len(tracks) == 4
    c = np.array([r.values["c"] for r in rows])
    for whirl, inertia in (("forward", DIAMETRAL - POLAR), ("backward", DIAMETRAL + POLAR)):
        for speeds in (np.full(10, RPM * np.sqrt(4e6 / 15.0)), RPM * np.sqrt(c / inertia)):
            own = [t for t in tracks if t.whirl == whirl and np.allclose(t.speed_rpm, speeds)]
            assert len(own) == 1
    # a speed that leaves the range keeps its track
    c = np.linspace(2e4, 1.4e5, 13)
    rows = [laval_row(n, {"c": one}, tilt=one, top_rpm=7000.0) for n, one in enumerate(c)]
    tracks = critical_tracks(sweep_designs(rows)[0])
    assert len(tracks) == 4
    conical = next(t for t in tracks if t.whirl == "forward" and np.isnan(t.speed_rpm).any())
    limit = (DIAMETRAL - POLAR) * (7000.0 / RPM) ** 2
    assert (np.isfinite(conical.speed_rpm) == (c < limit)).all()


def test_shafts_of_other_speed_are_told_apart():
    """The same whirl, excited at 1× and at 1.5×: they cross and must not be mixed."""
    rows = []
    for n, p in enumerate(np.linspace(0.0, 1.0, 6)):
        first, second = 3000.0 + 1000.0 * p, 3900.0 - 1000.0 * p
        speeds, ratios = zip(*sorted([(first, 1.0), (second, 1.5)]), strict=True)
        rows.append(speed_row(n, {"p": p}, *speeds, ratios=ratios, error=float("nan")))
    tracks = critical_tracks(sweep_designs(rows)[0])
    assert sorted(round(t.excitation_ratio, 6) for t in tracks) == [1.0, 1.5]
    assert next(t for t in tracks if t.excitation_ratio > 1.2).name.endswith(", 1.5×")
    assert not any(t.doubtful.any() for t in tracks)


def test_a_coarse_crossing_is_in_doubt():
    """Two cases on each side of an unseen crossing: nothing tells crossing from veering."""
    places = np.array([[0.0], [1.0]])
    curves = [np.array([[100.0], [130.0]]), np.array([[110.0], [118.0]])]
    found = match_curves(places, curves, [[(0, "forward")] * 2] * 2)
    assert found.doubtful[:, 1].any() or found.doubtful[:, 0].any()
    # while far apart nothing is
    clear = match_curves(places, [np.array([[100.0], [300.0]]), np.array([[105.0], [310.0]])],
                         [[(0, "forward")] * 2] * 2)  # fmt: skip
    assert not clear.doubtful.any()


def test_every_curve_belongs_to_one_track_once():
    rng = np.random.default_rng(5)
    places = rng.random((30, 2))
    curves = [np.exp(rng.normal(size=(rng.integers(0, 6), 3))) for _ in range(30)]
    kinds = [[(0, str(rng.choice(["forward", "backward", "mixed"]))) for _ in c] for c in curves]
    found = match_curves(places, curves, kinds)
    for case, own in enumerate(curves):
        used = found.index[:, case]
        assert sorted(used[used >= 0]) == list(range(len(own)))
    for row in found.index:
        whirls = {kinds[c][k][1] for c, k in enumerate(row) if k >= 0}
        steps = [kinds[c][row[c]][1] for c in visiting_order(places) if row[c] >= 0]
        assert whirls == set(steps)
    assert sorted(visiting_order(places)) == list(range(30))


def test_order_statistics_cover_with_the_stated_confidence():
    """Exact: the binomial probability that the ranks enclose the quantile."""
    for count in (59, 72, 128, 1000):
        for level in (0.05, 0.5, 0.95):
            low, high = order_statistics(count, level, 0.95)
            below = stats.binom(count, level)
            assert low == 0 or below.cdf(low - 1) <= 0.025 < below.cdf(low)
            assert high == count + 1 or below.sf(high - 1) <= 0.025 < below.sf(high - 2)
    # no lower limit of the 5 % quantile below 72 samples: 0.95^71 > 0.025 > 0.95^72
    assert least_samples(0.05, 0.95) == 72
    assert order_statistics(71, 0.05, 0.95)[0] == 0 < order_statistics(72, 0.05, 0.95)[0]


def test_quantiles_of_normal_samples():
    rng = np.random.default_rng(11)
    samples = rng.standard_normal((200, 400))
    found = quantiles(samples)
    exact = stats.norm.ppf([0.05, 0.5, 0.95])[:, None]
    covered = ((found.low < exact) & (exact < found.high)).mean(axis=1)
    # at least 95 % by construction, less three standard deviations of 400 trials (1.1 %)
    assert (covered > 0.95 - 0.033).all() and (covered < 0.995).all()
    # standard error √(p(1-p)/n)/φ(q) = 0.149 for 5 %; mean of 400 columns, three times; the
    # bias of definition 7 is of the order 1/n
    assert np.abs(found.value.mean(axis=1) - exact[:, 0]).max() < 3 * 0.149 / 20 + 0.02
    few = quantiles(samples[:30])
    assert np.isnan(few.low[0]).all() and np.isnan(few.high[2]).all()
    assert np.isfinite(few.high[0]).all() and (few.count == 30).all()
    # missing samples are left out and counted
    samples = np.arange(100.0)[:, None] * np.ones(2)
    samples[::2, 1] = np.nan
    found = quantiles(samples)
    assert found.count.tolist() == [100, 50]
    assert found.value[1].tolist() == [49.5, 50.0]


def test_margins_between_cases_do_not_miss_the_band():
    """Critical speeds 4000 and 6000 rpm at the ends: linear between, so 5000 in the middle."""
    speeds = np.array([4000.0, 4900.0, 5000.0, 5100.0, 6120.0, np.nan])
    signed = band_margin(speeds, (4900.0, 5100.0))
    np.testing.assert_allclose(signed, [-900 / 4900, 0.0, 0.0, 0.0, 0.2, np.nan])
    rows = [speed_row(n, corner, 4000.0 + 2000.0 * corner["p"]) for n, corner in enumerate(CORNERS)]
    (found,) = analyse_sweep(rows, SweepPictureSettings(operating_rpm=(4900.0, 5100.0)))
    (one,) = found.maps
    speed = 4000.0 + 2000.0 * np.broadcast_to(one.x, one.margin.shape)
    if one.x_name == "q":
        speed = 4000.0 + 2000.0 * np.broadcast_to(one.y[:, None], one.margin.shape)
    exact = np.maximum(np.maximum((4900.0 - speed) / 4900.0, (speed - 5100.0) / 5100.0), 0.0)
    np.testing.assert_allclose(one.margin, exact, atol=1e-12)
    # the cases themselves are all 18 % away
    np.testing.assert_allclose(one.case_margin, [900 / 4900] * 2 + [900 / 5100] * 2)


def test_no_margin_is_larger_than_what_was_searched():
    """One critical speed 40 % below; another above leaves the search at 9000 rpm, margin 80 %."""
    rows = []
    for n, corner in enumerate(CORNERS):
        speeds = (3000.0,) if corner["p"] else (3000.0, 8500.0)
        rows.append(speed_row(n, corner, *speeds, whirls=("backward", "forward")))

    def least(low, high, chosen=rows):
        settings = SweepPictureSettings(operating_rpm=(low, high), map_parameters=("p", "q"))
        (found,) = analyse_sweep(chosen, settings)
        return found

    (one,) = least(5000.0, 5000.0).maps
    np.testing.assert_allclose(one.margin, 0.4)  # 3000 rpm is the nearest everywhere
    (one,) = least(8000.0, 8000.0).maps
    # from 8500 to the end of the search, 9000 rpm, along p
    exact = np.broadcast_to((500.0 + 500.0 * one.x) / 8000.0, one.margin.shape)
    np.testing.assert_allclose(one.margin, exact)
    assert any("12 % and more" in note for note in one.notes)
    beyond = least(9500.0, 9500.0)
    assert beyond.maps == () and "no margin is known of 4 cases" in beyond.notes[-1]


def test_margins_take_the_least_over_other_parameters():
    values = [(p, q, r) for p in (0.0, 1.0) for q in (0.0, 1.0) for r in (0.0, 1.0)]
    rows = [
        speed_row(n, {"p": p, "q": q, "r": r}, 4000.0 + 100.0 * p + 10.0 * q + 500.0 * r)
        for n, (p, q, r) in enumerate(values)
    ]
    settings = SweepPictureSettings(operating_rpm=(5000.0, 5000.0), map_parameters=("p", "q"))
    ((one,),) = [a.maps for a in analyse_sweep(rows, settings)]
    assert one.least_over == ("r",)
    assert one.margin[0, 0] == pytest.approx(500.0 / 5000.0)  # r = 1
    assert one.margin[-1, -1] == pytest.approx(390.0 / 5000.0)


def test_kinds_of_designs():
    grid = grid_rows([1e6, 2e6], [10.0, 11.0, 12.0])
    assert sweep_designs(grid)[0].kind == "one_at_a_time"
    samples = sample_rows(30)
    assert sweep_designs(samples)[0].kind == "samples"
    with pytest.raises(SweepPictureError, match="varied alone"):
        sweep_designs(samples, "grid")
    star = [laval_row(n, {"a": a, "b": b}) for n, (a, b) in
            enumerate([(1, 1), (0, 1), (2, 1), (1, 0), (1, 5)])]  # fmt: skip
    (design,) = sweep_designs(star)
    assert design.kind == "one_at_a_time" and design.baseline == 0
    ladder = [laval_row(n, {"k": k}) for n, k in enumerate(np.geomspace(1e5, 1e8, 30))]
    (design,) = sweep_designs(ladder)
    assert design.kind == "one_at_a_time" and design.parameters[0].logarithmic
    drawn = np.random.default_rng(1).random(30)
    rows = [laval_row(n, {"k": k}) for n, k in enumerate(drawn)]
    assert sweep_designs(rows)[0].kind == "one_at_a_time"
    # the method of the sweep tells, where rows have it
    (design,) = sweep_designs([replace(r, method="sobol", sweep_cases=32) for r in rows])
    assert design.kind == "samples" and design.missing == 2
    assert sweep_designs(rows, "samples")[0].kind == "samples"
    assert sweep_designs([laval_row(0, {})])[0].kind == "none"


def test_refusals_name_the_place():
    rows = grid_rows([1e6, 2e6], [10.0, 11.0])
    for settings, said in (
        ({"operating_rpm": (5000.0, 4000.0)}, "0 < low <= high"),
        ({"confidence": 1.0}, "confidence is 1"),
        ({"map_parameters": ("k", "k")}, "two different names"),
        ({"map_parameters": ("missing", "mass_kg")}, "'missing' is no parameter"),
    ):
        with pytest.raises(SweepPictureError, match=said):
            analyse_sweep(rows, SweepPictureSettings(**settings))
    with pytest.raises(SweepPictureError, match="laval-0001: no value of"):
        analyse_sweep([rows[0], replace(rows[1], values={})], SweepPictureSettings())


@pytest.mark.parametrize(
    ("key", "label"),
    [
        ("bearings[left].stiffness_n_per_m", "bearings[left].stiffness [N/m]"),
        ("outer_radius_m[0]", "outer_radius[0] [m]"),
        ("tilt_damping_n_m_s_per_rad", "tilt_damping [N·m·s/rad]"),
        ("gravity_m_per_s2", "gravity [m/s²]"),
        ("response.disk.peak_amplitude_m", "response.disk.peak_amplitude [m]"),
        ("damping_n_s_per_m", "damping [N·s/m]"),
        ("accuracy", "accuracy"),
        ("m", "m"),
    ],
)
def test_units_are_read_from_keys(key, label):
    assert label_of(key) == label
    # long ones are wrapped without loss
    lines = wrapped(label, 20).split("\n")
    assert max(map(len, lines)) <= 22 and "".join(lines).replace(" ", "") == label.replace(" ", "")


@pytest.mark.parametrize(
    ("label", "largest", "scale", "said"),
    [
        ("k [N/m]", 3.2e7, 1e7, "k [10⁷ N/m]"),
        ("gap [m]", 2e-5, 1e-5, "gap [10⁻⁵ m]"),
        ("count", 12_000.0, 1e4, "count [10⁴]"),
        ("factor", 1.05, 1.0, "factor"),
        ("disk_thickness [m]", 0.03, 1.0, "disk_thickness [m]"),
        ("shift [m]", 0.0, 1.0, "shift [m]"),
    ],
)
def test_powers_of_ten_stand_in_the_unit(label, largest, scale, said):
    assert in_powers_of_ten(label, largest) == (scale, said)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Everything that is drawn of a grid with a failed case, and of samples."""
    out = tmp_path_factory.mktemp("pictures") / "new"
    grid = [replace(r, scene="grid") for r in grid_rows([1e6, 2e6, 4e6, 8e6], [10.0, 15.0, 20.0])]
    grid[5] = replace(
        BatchRow(case="grid-0005", scene="grid", status="failed"),
        message="the mesh is <too> fine", values=grid[5].values,
    )  # fmt: skip
    samples = [replace(r, scene="samples") for r in sample_rows(40)]
    rows = [*grid, *samples, laval_row(0, {}, scene="plain")]
    settings = SweepPictureSettings(
        operating_rpm=(4000.0, 4500.0), labels={"k": "lateral <stiffness> [N/m]"}
    )
    return rows, settings, out, draw_batch(rows, out, settings=settings)


def test_every_kind_of_picture_is_drawn(drawn):
    _, _, out, files = drawn
    assert {f.name for f in files} == {
        f"{scene}-{name}"
        for scene in ("grid", "samples")
        for name in ("critical-speeds.png", "tornado.png", "parallel.html", "margins.png")
    } | {"samples-campbell-bands.png", "sweep.json"}  # fmt: skip
    assert {f.name for f in out.iterdir()} == {f.name for f in files}
    for path in files:
        if path.suffix == ".png":
            assert path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 20_000


def test_the_page_stands_alone_and_escapes_names(drawn):
    page = (drawn[2] / "samples-parallel.html").read_text(encoding="utf-8")
    assert 'src="http' not in page and "lateral <stiffness>" not in page
    own = page.split("Plotly.newPlot(")[-1]
    assert '"parcoords"' in own and "lateral" in own


def test_the_document_holds_the_numbers(drawn):
    rows, settings, out, _ = drawn
    document = json.loads((out / "sweep.json").read_text(encoding="utf-8"))
    assert document == json.loads(json.dumps(sweep_document(rows, settings=settings)))
    assert document["schema"] == "solidwhirl-sweep-1"
    assert document["cases"] == {"done": 52, "failed": 1}
    grid, samples = document["scenes"]
    assert grid["left_out"][0]["message"] == "the mesh is <too> fine"
    assert any("1 of 12 cases left out" in n for n in grid["notes"])
    assert samples["campbell"]["cases"] == 40
    assert any("72 do" in n for n in samples["notes"])
    limits = samples["campbell"]["frequency_hz"]["lower_limit"][0]
    assert all(v is None for branch in limits for v in branch)
    assert grid["campbell"] is None and grid["margin_maps"][0]["interpolated"]


def test_rows_that_hold_little_are_drawn_as_far_as_they_go(tmp_path):
    """No critical speeds, no diagrams, a parameter that varies among failed cases alone."""
    rows = [
        BatchRow(
            case=f"bare-{n}", scene="bare", status="done" if n < 4 else "failed",
            values={"p": float(n), "q": float(n >= 4)}, responses={"r.y": 2.0 * n} if n < 4 else {},
        )
        for n in range(6)
    ]  # fmt: skip
    settings = SweepPictureSettings(operating_rpm=(4e3, 5e3))
    files = {f.name for f in draw_batch(rows, tmp_path, settings=settings)}
    assert files == {"bare-parallel.html", "sweep.json"}
    empty = [replace(r, responses={}) for r in rows]
    assert [f.name for f in draw_batch(empty, tmp_path / "empty")] == ["sweep.json"]
    # nothing without a sweep
    single = [laval_row(0, {}), laval_row(0, {}, scene="other")]
    failed = [replace(r, status="failed") for r in grid_rows([1e6, 2e6], [10.0])]
    for few in (single, failed):
        assert draw_batch(few, tmp_path / "none") == () and not (tmp_path / "none").exists()


def test_words_are_drawn_as_words(tmp_path):
    """Two levels beside a number: a bar for the words, no power of them."""
    rows = [
        laval_row(n, {"level": level, "k": k}, stiffness=k * (1.02 if level == "beam" else 1.0))
        for n, (level, k) in enumerate(
            (level, k) for level in ("beam", "harmonic") for k in (2e6, 3e6, 4e6)
        )
    ]
    files = draw_batch(rows, tmp_path, settings=SweepPictureSettings(operating_rpm=(4e3, 5e3)))
    (scene,) = json.loads(files[-1].read_text())["scenes"]
    effect = next(
        e for e in scene["sensitivities"][0]["one_at_a_time"] if e["parameter"] == "level"
    )
    assert effect["elasticity"] is None and effect["slope"] is None
    # √1.02 - 1 = 1 % between the words
    swing = effect["largest"] / effect["smallest"]
    assert swing == pytest.approx(np.sqrt(1.02))
    assert scene["parameters"][0]["choices"] == ["beam", "harmonic"]
    assert "laval-margins.png" not in {f.name for f in files}  # one number alone
