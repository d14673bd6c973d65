"""Measured targets: intervals, what can not be told apart, modes kept aside."""

from __future__ import annotations

import json

import numpy as np
import pytest

from solidwhirl.core.errors import SceneError
from solidwhirl.identify.model import Model
from solidwhirl.identify.record import document, value_lines
from solidwhirl.identify.run import identify, read_problem
from solidwhirl.identify.statistics import estimate, not_told_apart, scores

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


def test_frequencies_do_not_tell_modulus_from_density(tmp_path):
    targets = [mode(k, f) for k, f in ((1, 180.0), (3, 490.0), (5, 950.0))]
    found = identify(problem(tmp_path, {"a": 1.0}, [MODULUS, DENSITY], targets, accuracy=1e-3))
    said = " ".join(value_lines(found))
    assert "can not tell modulus and density apart" in said
    assert document(found)["identifiability"]["undetermined_directions"] >= 0


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
    ],
)  # fmt: skip
def test_measurements_that_are_refused(tmp_path, parameters, targets, settings, said):
    with pytest.raises(SceneError, match=said):
        problem(tmp_path, {"a": 1.0}, parameters, targets, **settings)


@pytest.mark.verify
def test_intervals_cover_what_they_say(tmp_path):
    """Monte Carlo: normal errors on the frequencies of a known rod, 20 tests, two parameters."""
    length = {"name": "radius", "start": 0.021, "lower": 0.017, "upper": 0.024,
              "places": ["bodies.a.sections[rod].outer_radius_m"]}  # fmt: skip
    mass = {"name": "m", "quantity": "mass_kg", "body": "a", "uncertainty": 0.05}
    generator, inside, tests = np.random.default_rng(7), [], 20
    truth = {"modulus": 2.0e11, "radius": 0.02}
    heavy = 7800.0 * np.pi * 0.02**2
    own = identify(
        problem(
            tmp_path, {"a": 1.0}, [MODULUS, length],
            [mode(1, 179.0), {**mass, "value": heavy}, mode(3, 480.0)],
        )
    )  # fmt: skip
    model = Model(own.problem)
    first, _, second = model.complete(model.point(truth), 1e-3)
    for _ in range(tests):
        f1, f3, kg = np.array([first, second, heavy]) + generator.normal(size=3) * [1, 1, 0.05]
        targets = [mode(1, f1), {**mass, "value": kg}, mode(3, f3)]
        found = identify(problem(tmp_path, {"a": 1.0}, [MODULUS, length], targets))
        intervals = document(found)["statistics"]["intervals"]
        inside += [lo <= truth[name] <= hi for name, (lo, hi) in intervals.items()]
    # 95 % of 40: within three standard deviations of the count
    assert abs(sum(inside) - 38) <= 3.0 * np.sqrt(40 * 0.05 * 0.95)
