"""Measured targets: intervals, what can not be told apart, modes kept aside."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from solidwhirl.core.errors import SceneError
from solidwhirl.identify.model import Model
from solidwhirl.identify.record import document, value_lines
from solidwhirl.identify.run import identify, read_problem
from solidwhirl.identify.statistics import agrees, estimate, not_told_apart, scores

SCENE = """
name = "rods"
model = { level = "beam", estimates = "off" }
materials.steel = { density_kg_per_m3 = 7800.0, youngs_modulus_pa = 2e11, poissons_ratio = 0.3 }
"""
BODY = """
[bodies.NAME]
material = "steel"
sections = [{ name = "rod", start_m = 0.0, end_m = LENGTH, outer_radius_m = 0.02 }]
interfaces = [
    { name = "left", kind = "section", at_m = 0.0 },
    { name = "right", kind = "section", at_m = LENGTH },
]
"""
DENSITY = {"name": "density", "start": 7000.0, "lower": 6000.0, "upper": 9000.0,
           "places": ["materials.steel.density_kg_per_m3"]}  # fmt: skip
MODULUS = {"name": "modulus", "start": 1.9e11, "lower": 1.6e11, "upper": 2.4e11,
           "places": ["materials.steel.youngs_modulus_pa"]}  # fmt: skip


def problem(folder, bodies, parameters, targets, **settings):
    text = SCENE + "".join(
        BODY.replace("NAME", n).replace("LENGTH", str(z)) for n, z in bodies.items()
    )
    (folder / "rods.toml").write_text(text)
    lines = ['name = "test"', 'scene = "rods.toml"', "[settings]"]
    lines += [f"{key} = {value}" for key, value in settings.items()]
    for table, entries in (("parameters", parameters), ("targets", targets)):
        for entry in entries:
            lines += [f"[[{table}]]", *(f"{k} = {json.dumps(v)}" for k, v in entry.items())]
    (folder / "problem.toml").write_text("\n".join(lines))
    return read_problem(folder / "problem.toml")


def mode(number, value, **keys):
    return {"name": f"f{number}", "quantity": "frequency_hz", "mode": number, "value": value,
            "uncertainty": 1.0, **keys}  # fmt: skip


#: Roots of cos x cosh x = 1, of a free Euler beam
ROOTS = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671, 14.137165491257464])


def rod_numbers(modulus, radius, density):
    """Four frequencies and the mass of a free rod of 1 m."""
    speed = radius / 2.0 * np.sqrt(modulus / density)
    return np.append(ROOTS**2 * speed / (2.0 * np.pi), density * np.pi * radius**2)


@pytest.fixture
def euler_rod(monkeypatch):
    """Puts the closed form in the place of masses and frequencies of the one body of a scene."""
    from solidwhirl.identify import model

    def numbers(data):
        steel = data["materials"]["steel"]
        radius = data["bodies"]["a"]["sections"][0]["outer_radius_m"]
        return rod_numbers(steel["youngs_modulus_pa"], radius, steel["density_kg_per_m3"])

    def masses(problem, data):
        return np.where(problem.rows.is_mass, numbers(data)[-1], np.nan)

    def frequencies(problem, data, accuracy, found):
        for k, target in enumerate(problem.spec.targets):
            if target.mode:
                found[k] = numbers(data)[(target.mode - 1) // 2]

    monkeypatch.setattr(model, "_masses", masses)
    monkeypatch.setattr(model, "_fill_frequencies", frequencies)


def test_linear_problem_is_the_closed_form(tmp_path):
    """Two masses of one density: weighted mean and its variance, and one more kept aside."""
    lengths, masses, sigma = {"a": 0.4, "b": 1.0, "c": 0.7}, [3.95, 9.78, 6.9], [0.02, 0.03, 0.05]
    targets = [
        {"name": n, "quantity": "mass_kg", "body": n, "value": m, "uncertainty": s,
         "use": "check" if n == "c" else "fit"}
        for n, m, s in zip(lengths, masses, sigma, strict=True)
    ]  # fmt: skip
    found = identify(problem(tmp_path, lengths, [DENSITY], targets))
    volume = np.pi * 0.02**2 * np.array([*lengths.values()])
    weight = (volume / sigma)[:2]
    density = (weight @ (np.array(masses) / sigma)[:2]) / (weight @ weight)
    deviation = 1.0 / np.sqrt(weight @ weight)
    assert found.values["density"] == pytest.approx(density, rel=1e-6)
    record = document(found)["statistics"]
    wanted = density + 1.959963984540054 * deviation * np.array([-1.0, 1.0])
    assert record["intervals"]["density"] == pytest.approx(wanted, rel=1e-6)
    assert record["degrees_of_freedom"] == 1
    (aside,) = record["kept_aside"]
    spread = np.hypot(sigma[2], volume[2] * deviation)
    assert aside["standard_deviations"] == pytest.approx(
        (volume[2] * density - masses[2]) / spread, rel=1e-4
    )
    left = (density * volume - masses)[:2] / sigma[:2]
    assert record["chi_squared"] == pytest.approx(left @ left, rel=1e-4)


def test_statistics_of_a_straight_line():
    """Intercept and slope of y = a + b x: variances and correlation of the textbooks."""
    x, sigma = np.array([0.0, 1.0, 2.0, 5.0]), 0.3
    found = estimate(np.stack([np.ones(4), x], axis=1) / sigma, np.zeros(4))
    spread = ((x - x.mean()) ** 2).sum()
    wanted = sigma**2 * np.array([(x**2).mean() / spread, 1.0 / spread])
    np.testing.assert_allclose(np.diag(found.covariance), wanted, rtol=1e-12)
    assert found.correlation[0, 1] == pytest.approx(-x.mean() / np.sqrt((x**2).mean()), rel=1e-12)
    at = np.array([[1.0, 3.0]]) / sigma
    predicted = sigma**2 * (1 / 4 + (3.0 - x.mean()) ** 2 / spread)
    score = scores(at, np.array([2.0]), found)
    assert score[0] == pytest.approx(2.0 * sigma / np.sqrt(sigma**2 + predicted), rel=1e-12)


def test_blind_directions_have_no_interval():
    found = estimate(np.array([[1.0, -1.0, 0.0], [2.0, -2.0, 0.0], [0.0, 0.0, 3.0]]), np.zeros(3))
    assert np.isinf(found.half_width[:2]).all()
    assert found.half_width[2] == pytest.approx(1.959964 / 3.0, rel=1e-6)
    assert not_told_apart(found) == [(0, 1)]


def test_frequencies_do_not_tell_modulus_from_density(tmp_path, euler_rod):
    targets = [mode(k, f) for k, f in ((1, 180.0), (3, 490.0), (5, 950.0))]
    found = identify(problem(tmp_path, {"a": 1.0}, [MODULUS, DENSITY], targets, accuracy=1e-3))
    said = " ".join(value_lines(found))
    assert "can not tell modulus and density apart" in said
    assert document(found)["identifiability"]["undetermined_directions"] >= 0


def test_one_measurement_that_a_bound_keeps_away_is_not_met(tmp_path, euler_rod):
    """No degree of freedom is left, so that there is no probability."""
    for hertz, met in ((178.0, True), (300.0, False)):
        found = identify(problem(tmp_path, {"a": 1.0}, [MODULUS], [mode(1, hertz)]))
        assert (found.estimate.probability, found.met) == (None, met)


def test_shape_of_its_own_model_is_met(tmp_path):
    """The first mode of a free rod moves both ends alike, whatever the scale of the test."""
    shape = {"name": "s1", "quantity": "mode_shape", "mode": 1, "at": ["a.left", "a.right"],
             "shape": [-2.0, -2.0], "uncertainty": 0.02}  # fmt: skip
    bodies, targets = {"a": 1.0}, [mode(1, 178.0), shape, mode(3, 480.0)]
    found = identify(problem(tmp_path, bodies, [MODULUS], targets, accuracy=1e-3))
    reached = [t["reached"] for t in document(found)["targets"] if t["name"].startswith("s1")]
    assert reached == pytest.approx([-2.0, -2.0], rel=1e-6)
    assert found.estimate.freedom == 2


@pytest.mark.parametrize(
    ("parameters", "targets", "settings", "said"),
    [
        ([MODULUS, DENSITY], [mode(1, 180.0)], {}, "parameters: 2, but .* are 1 data"),
        ([MODULUS], [mode(1, 180.0)], {"prior": 0.1}, "settings.prior: measured targets"),
        ([MODULUS], [mode(1, 180.0, tolerance=0.1)], {}, r"targets\[0\].tolerance"),
        ([MODULUS], [mode(1, 180.0), {"name": "m", "quantity": "mass_kg", "body": "a",
          "value": 1.0}], {}, r"targets\[1\].uncertainty: missing"),
        ([MODULUS], [mode(1, 1.0, quantity="mode_shape", at=["a.left"], shape=[1.0])], {},
         r"targets\[0\].shape: 1 numbers at 1 places"),
        ([MODULUS], [mode(1, 1.0, quantity="mode_shape", at=["a.left"] * 2, shape=[1.0, 1.0])], {},
         r"targets\[0\].at: a place is there twice"),
        ([MODULUS], [mode(1, -180.0)], {}, r"targets\[0\].value: -180; frequency_hz is above zero"),
    ],
)  # fmt: skip
def test_measurements_that_are_refused(tmp_path, parameters, targets, settings, said):
    with pytest.raises(SceneError, match=said):
        problem(tmp_path, {"a": 1.0}, parameters, targets, **settings)


def test_intervals_cover_what_they_say(tmp_path, euler_rod):
    """Normal errors on a known rod: how often intervals of 95 % and kept modes hold, and sums.

    Counts are binomial, sums of squares over all draws chi-squared: of the deviations left, and of
    the parameters' errors by their covariance. Bounds hold 1 - 1e-4 of each.
    """
    radius = {"name": "radius", "start": 0.021, "lower": 0.017, "upper": 0.024,
              "places": ["bodies.a.sections[rod].outer_radius_m"]}  # fmt: skip
    truth = {"modulus": 2.0e11, "radius": 0.02}
    right = rod_numbers(**truth, density=7800.0)
    sigma = 0.005 * right
    targets = [mode(2 * k + 1, f) for k, f in enumerate(right[:4])]
    targets.append({"name": "m", "quantity": "mass_kg", "body": "a", "value": right[4]})
    for target, spread in zip(targets, sigma, strict=True):
        target["uncertainty"] = spread
    targets[3]["use"] = "check"
    base = problem(tmp_path, {"a": 1.0}, [MODULUS, radius], targets)
    draws, inside, sums = 400, np.zeros(3), np.zeros(2)
    for error in np.random.default_rng(7).normal(size=(draws, 5)):
        measured = [
            target.model_copy(update={"value": float(value)})
            for target, value in zip(base.spec.targets, right + sigma * error, strict=True)
        ]
        spec = base.spec.model_copy(update={"targets": tuple(measured)})
        found = identify(replace(base, spec=spec))
        own, aside = found.estimate, found.problem.rows.deviations(found.reached)[3:4]
        off = found.point - Model(found.problem).point(truth)
        kept = agrees(scores(found.slopes[3:4], aside, own))
        inside += np.append(np.abs(off) <= own.half_width, kept)
        sums += own.chi_squared, off @ np.linalg.solve(own.covariance, off)
    low, high = stats.binom.interval(1.0 - 1e-4, draws, 0.95)
    assert ((low <= inside) & (inside <= high)).all(), inside
    assert own.freedom == 2  # as many as parameters
    low, high = stats.chi2.interval(1.0 - 1e-4, 2 * draws)
    assert ((low < sums) & (sums < high)).all(), sums
