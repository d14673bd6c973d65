"""Sweeps: places, values and cases of `[sweep]`, against closed forms, scipy and counting."""

from __future__ import annotations

import copy
import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.stats

from solidwhirl.core.errors import SceneError
from solidwhirl.identify.scene import scene_text
from solidwhirl.scene.sweep import SweepParameterSpec, SweepSpec, case_count
from solidwhirl.scene_reading.reader import parse_scene, scene_hash, with_model
from solidwhirl.sweep.cases import batch_cases, case_scene
from solidwhirl.sweep.samples import quantiles, sweep_values

STIFFNESS = "bearings[left].stiffness_n_per_m"


def swept(small_scene, method, *parameters, **more):
    return {**small_scene(), "sweep": {"method": method, "parameters": [*parameters], **more}}


def parameter(name="k", places=(STIFFNESS,), **keys):
    return {"name": name, "places": list(places), **keys}


def spec(method, *parameters, **more):
    return SweepSpec.model_validate({"method": method, "parameters": parameters, **more})


def written(tmp_path, data, name="swept.toml"):
    path = tmp_path / name
    path.write_text(scene_text(data, {}), encoding="utf-8")
    return path


UNIFORM = {"distribution": "uniform", "lower": 0.0, "upper": 1.0}
PINNED = {
    "latin_hypercube": [(0.24408918765, 0.524768151837), (0.92792019364, 0.0256752764314)],
    "sobol": [(0.15546531789, 0.588747326285), (0.838384716772, 0.104060153477)],
}

# -- values ---------------------------------------------------------------------------------------


TWO = [parameter("a", values=[1, 5, 2]), parameter("b", values=["x", "y", "x"])]
FACTORS = {"lower": 1e5, "upper": 1e8, "count": 4, "spacing": "logarithmic"}


@pytest.mark.parametrize(
    ("method", "parameters", "expected"),
    [
        # every combination; the last parameter runs fastest
        ("grid", TWO, [(a, b) for a in (1, 5, 2) for b in "xyx"]),
        # side by side
        ("list", TWO, [(1, "x"), (5, "y"), (2, "x")]),
        # equal steps
        (
            *("grid", [parameter(lower=1.0, upper=2.0, count=5)]),
            [(1.0,), (1.25,), (1.5,), (1.75,), (2.0,)],
        ),
        # equal factors, rounded to 12 digits: decades come out as they are
        ("grid", [parameter(**FACTORS)], [(1e5,), (1e6,), (1e7,), (1e8,)]),
    ],
)
def test_values_of_grids_and_lists(method, parameters, expected):
    asked = spec(method, *parameters)
    assert [tuple(v.values()) for v in sweep_values(asked)] == expected
    assert case_count(asked) == len(expected)


def test_more_sobol_points_go_on_from_the_first():
    few, many = (
        sweep_values(spec("sobol", parameter(**UNIFORM), samples=n, seed=4)) for n in (8, 32)
    )
    assert many[:8] == few


@pytest.mark.parametrize("method", ["latin_hypercube", "sobol"])
def test_seed_decides_on_every_release(method):
    """Written down with scipy 1.10; a batch that goes on elsewhere has to find its cases again."""
    two = [parameter(name, **UNIFORM) for name in "ab"]

    def run(**more):
        return sweep_values(spec(method, *two, samples=2, **more))

    assert [tuple(v.values()) for v in run(seed=1)] == PINNED[method]
    assert run(seed=1) != run(seed=2)
    assert run() == run(seed=0)


PROBABILITY = np.array([1e-6, 0.01, 0.2, 0.5, 0.77, 0.999])
SIGMA = math.sqrt(math.log1p((6e6 / 3e7) ** 2))
LOGNORMAL = scipy.stats.lognorm(SIGMA, scale=3e7 * math.exp(-0.5 * SIGMA**2))
BETWEEN = {"mean": 3e7, "standard_deviation": 6e6, "lower": 2e7, "upper": 4e7}
LOW, HIGH = LOGNORMAL.cdf([2e7, 4e7])
TRUNCATED = SimpleNamespace(ppf=lambda share: LOGNORMAL.ppf(LOW + share * (HIGH - LOW)))
MIDDLE = {"distribution": "normal", "mean": 5.0, "standard_deviation": 2.0}
AROUND = {"loc": 5.0, "scale": 2.0}


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        (UNIFORM | {"lower": -2.0, "upper": 3.0}, scipy.stats.uniform(-2.0, 5.0)),
        (
            {"distribution": "log_uniform", "lower": 1e5, "upper": 1e9},
            scipy.stats.loguniform(1e5, 1e9),
        ),
        (MIDDLE, scipy.stats.norm(**AROUND)),
        (MIDDLE | {"lower": 4.0, "upper": 9.0}, scipy.stats.truncnorm(-0.5, 2.0, **AROUND)),
        (MIDDLE | {"lower": 1.0}, scipy.stats.truncnorm(-2.0, np.inf, **AROUND)),
        ({"distribution": "lognormal", "mean": 3e7, "standard_deviation": 6e6}, LOGNORMAL),
        (BETWEEN | {"distribution": "lognormal"}, TRUNCATED),
    ],
)
def test_quantiles_are_those_of_the_distribution(keys, expected):
    record = SweepParameterSpec.model_validate(parameter(**keys))
    # 12 digits are kept, and scipy's truncated normal has a digit less in its tail
    np.testing.assert_allclose(
        quantiles(record, PROBABILITY), expected.ppf(PROBABILITY), rtol=1e-10, atol=1e-11
    )


def test_moments_of_a_lognormal_are_those_of_the_value_not_of_its_logarithm():
    assert LOGNORMAL.mean() == pytest.approx(3e7, rel=1e-12)
    assert LOGNORMAL.std() == pytest.approx(6e6, rel=1e-12)
    record = SweepParameterSpec.model_validate(parameter(**BETWEEN | {"distribution": "lognormal"}))
    # the ends are moved inwards by 2^-31 of the probability
    assert quantiles(record, np.array([0.0, 1.0])) == pytest.approx([2e7, 4e7], rel=1e-6)


def test_values_of_a_sampled_sweep_are_equally_likely():
    drawn = parameter("law", values=["soft", "stiff", "worn", "new"])
    asked = spec("sobol", drawn, samples=64, seed=1)
    found = sweep_values(asked)
    assert len(found) == case_count(asked) == 64
    for text in drawn["values"]:
        assert [v["law"] for v in found].count(text) == 16


# -- cases ----------------------------------------------------------------------------------------


def test_plain_scene_is_one_case(tmp_path, small_scene):
    path = written(tmp_path, small_scene())
    (case,) = batch_cases([path])
    assert (case.name, dict(case.values), case.scene_path) == ("small", {}, path)
    assert case.digest == scene_hash(parse_scene(small_scene()))


def test_cases_have_their_values_where_they_belong(tmp_path, small_scene):
    data = swept(
        small_scene,
        "grid",
        parameter("k", (STIFFNESS, "bearings[1].stiffness_n_per_m"), values=[1e6, 2e7]),
        parameter("level", ("model.level",), values=["beam", "harmonic"]),
        parameter("thicker", ("bodies.rotor.sections[disk].end_m",), applies="factor", values=[2]),
    )
    cases = batch_cases([written(tmp_path, data)])
    assert [case.name for case in cases] == ["small-0001", "small-0002", "small-0003", "small-0004"]
    assert {(case.method, case.sweep_cases) for case in cases} == {("grid", 4)}
    for case, (k, level) in zip(
        cases, itertools.product((1e6, 2e7), ("beam", "harmonic")), strict=True
    ):
        expected = small_scene(model={"level": level})
        for bearing in expected["bearings"]:
            bearing["stiffness_n_per_m"] = k
        expected["bodies"]["rotor"]["sections"][1]["end_m"] = 0.28
        assert case.data == expected
        assert case.values == {"k": k, "level": level, "thicker": 2}
        assert case.digest == scene_hash(parse_scene(expected))
        assert case_scene(case) == parse_scene(expected)
    assert len({case.digest for case in cases}) == 4


def test_cases_share_what_they_have_in_common_and_nothing_else(tmp_path, small_scene):
    data = swept(small_scene, "list", parameter(values=[1e6, 2e6]))
    first, second = batch_cases([written(tmp_path, data)])
    assert first.data["bodies"] is second.data["bodies"]
    assert first.data["bearings"][0] is not second.data["bearings"][0]
    assert first.data["bearings"][1] is second.data["bearings"][1]


def test_tables_that_the_scene_leaves_out_and_whole_numbers_can_be_swept(tmp_path, small_scene):
    assert "effects" not in small_scene()
    tilt = parameter("tilt", ("effects.tilt",), values=["on", "off"])
    cases = batch_cases([written(tmp_path, swept(small_scene, "list", tilt))])
    assert [case_scene(case).effects.tilt for case in cases] == ["on", "off"]
    data = swept(small_scene, "grid", parameter("n", ("model.modes",), lower=2, upper=4, count=3))
    assert [case_scene(c).model.modes for c in batch_cases([written(tmp_path, data)])] == [2, 3, 4]


def test_sweep_is_no_part_of_what_the_scene_is(small_scene):
    """Neither hash, nor stages, nor a copy of the scene as data depend on how it is swept."""
    from solidwhirl.pipeline.cached_stages import engine_part

    plain = parse_scene(small_scene())
    scene = parse_scene(swept(small_scene, "list", parameter(values=[1e6])))
    assert scene.sweep is not None
    assert scene_hash(scene) == scene_hash(plain)
    assert engine_part(scene) == engine_part(plain)
    assert scene.model_dump(exclude_unset=True) == plain.model_dump(exclude_unset=True)


def test_options_are_in_the_digest_and_not_in_the_data(tmp_path, small_scene):
    path = written(tmp_path, swept(small_scene, "list", parameter(values=[1e6])))
    (plain,), (changed,) = batch_cases([path]), batch_cases([path], level="beam", accuracy=1e-2)
    assert plain.data == changed.data
    assert plain.digest != changed.digest
    scene = with_model(parse_scene(dict(plain.data)), level="beam", accuracy=1e-2)
    assert changed.digest == scene_hash(scene)
    assert case_scene(changed, level="beam", accuracy=1e-2) == scene


def test_case_without_a_scene_is_left_to_fail(tmp_path, small_scene):
    data = swept(small_scene, "list", parameter("modes", ("model.modes",), values=[3, 501]))
    good, bad = batch_cases([written(tmp_path, data)])
    assert case_scene(good).model.modes == 3
    with pytest.raises(SceneError, match=r"case small-0002: model\.modes: .*500.*found 501"):
        case_scene(bad)
    assert len(bad.digest) == 64
    assert bad.digest == batch_cases([written(tmp_path, data)])[1].digest != good.digest


def test_demonstration_on_the_twin_rotor(root):
    """One sample in each of 80 equally likely parts of every normal distribution."""
    # files lie beside the scene that names them
    (case,) = batch_cases([root / "scenes" / "own_mesh.toml"])
    assert case_scene(case).mesh_bodies
    cases = batch_cases([root / "scenes" / "ferraris_sweep.toml"])
    assert len(cases) == 80
    for name, mean, deviation, lower, upper in (
        ("inner_bearing_stiffness_n_per_m", 1e8, 1.5e7, 5e7, math.inf),
        ("intershaft_stiffness_n_per_m", 1e8, 1.5e7, 5e7, math.inf),
        ("support_stiffness_n_per_m", 8e6, 8e5, 4e6, math.inf),
        ("disk_thickness_m", 0.03, 4e-4, 0.028, 0.032),
    ):
        ends = [(e - mean) / deviation for e in (lower, upper)]
        bell = scipy.stats.truncnorm(*ends, loc=mean, scale=deviation)
        share = bell.cdf([case.values[name] for case in cases])
        assert sorted(np.floor(80.0 * share)) == list(range(80))
    plain = [case_scene(case).bodies for case in cases]
    assert len({b["inner"].sections[1].end_m for b in plain}) == 80
    # what is the same in all cases is computed once
    assert all(b["outer"] == plain[0]["outer"] for b in plain)


# -- refusals -------------------------------------------------------------------------------------

LIMITS = {"distribution": "uniform", "lower": 1e6, "upper": 1e7}
BELL = {"distribution": "normal", "mean": 1e7, "standard_deviation": 1e6}
PLACE, FACTOR = {"values": [1]}, {"values": [2], "applies": "factor"}
EIGHT = {"samples": 8}
REFUSED = [
    ("grid", {}, {}, r"sweep\.parameters\[0\]\.values: missing; a grid needs values, or lower"),
    ("grid", {"values": []}, {}, r"sweep\.parameters\[0\]\.values: empty; one at least is needed"),
    ("grid", {"values": [True]}, {}, r'values\[0\]: true and false .* write "on" or "off"'),
    ("grid", {"values": [[1.0]]}, {}, r"values\[0\]: a number or a text is needed"),
    ("grid", {"values": [1e31]}, {}, r"values\[0\]: a number from -1e\+30 to 1e\+30"),
    ("grid", {"values": [1, "x"]}, {}, r"values: 'x' stands among numbers"),
    ("grid", {"values": [1], "lower": 2}, {}, r"lower: stands beside values"),
    ("grid", {"lower": 1, "upper": 2}, {}, r"count: missing"),
    ("grid", {"lower": 2, "upper": 1, "count": 3}, {}, r"upper: 1 is not above lower = 2"),
    ("grid", {"lower": 0, "upper": 1, "count": 3, "spacing": "logarithmic"}, {},
     r"lower: 0 has no logarithm"),
    ("grid", LIMITS, {}, r"distribution: is not for method 'grid'; allowed are count, lower"),
    ("grid", PLACE, EIGHT, r"sweep\.samples: method 'grid' draws no samples"),
    ("grid", PLACE, {"seed": 8}, r"sweep\.seed: method 'grid' draws no samples"),
    ("grid", {"vlaues": [1]}, {}, r"parameters\[0\]\.vlaues: unknown key; did you mean 'values'"),
    ("list", {"lower": 1, "upper": 2, "count": 3}, {}, r"values: missing; method 'list' needs"),
    ("sobol", LIMITS, {}, r"sweep\.samples: missing; method 'sobol' needs the number"),
    ("sobol", LIMITS, {"samples": 60}, r"sweep\.samples: 60 is no power of 2.* take 32 or 64"),
    ("sobol", {}, EIGHT, r"distribution: missing"),
    ("sobol", {"distribution": "normal"}, EIGHT, r"mean and standard_deviation: missing; dis"),
    ("sobol", {**LIMITS, "mean": 1}, EIGHT, r"mean: is not for distribution 'uniform'"),
    ("sobol", {**BELL, "standard_deviation": 0}, EIGHT, r"standard_deviation: 0; a numb"),
    ("sobol", {**BELL, "lower": 2e7}, EIGHT, r"lower: 2e\+07 cuts off the mean, 1e\+07"),
    ("sobol", {**BELL, "upper": 9e6}, EIGHT, r"upper: 9e\+06 cuts off the mean"),
    ("sobol", {**BELL, "distribution": "lognormal", "mean": -1}, EIGHT,
     r"mean: -1; a lognormal distribution has a mean above 0"),
    ("latin_hypercube", {**LIMITS, "distribution": "weibull"}, EIGHT,
     r"distribution: .*'uniform', 'log_uniform', 'normal' or 'lognormal'.*found 'weibull'"),
    ("latin_hypercube", LIMITS, {"samples": 20001}, r"samples: .*20000"),
    ("random", PLACE, {}, r"sweep\.method: .*'grid', 'list', 'latin_hypercube' or 'sob"),
    ("grid", {"values": ["a"], "applies": "factor"}, {}, r"values: 'a' is no factor"),
    ("grid", {**PLACE, "name": "a b"}, {}, r"sweep\.parameters\[0\]\.name: "),
    ("grid", {**PLACE, "places": []}, {}, r"parameters\[0\]\.places: empty; one at least is n"),
    ("grid", {**PLACE, "places": ["..x"]}, {}, r"places\[0\]: '\.\.x' is no place; allowed"),
    ("grid", {**PLACE, "places": ["bearings[lef].stiffness_n_per_m"]}, {},
     r"places\[0\]: .*bearings has no entry \[lef\]; did you mean 'left'\?"),
    ("grid", {**PLACE, "places": ["bodies.rotr.x"]}, {}, r"bodies has no 'rotr'; did you me"),
    ("grid", {**PLACE, "places": ["bodies.rotor"]}, {}, r"'bodies\.rotor' is a table"),
    ("grid", {**PLACE, "places": ["bodys"]}, {}, r"the scene has no 'bodys'; did you mean"),
    ("grid", {"values": ["x"], "places": ["name"]}, {}, r"'name' stays as it is"),
    ("grid", {**FACTOR, "places": ["model.size_m"]}, {},
     r"'model\.size_m' is left out in the scene; a factor needs a number there"),
    ("grid", {"values": [2], "places": [STIFFNESS, "bearings[0].stiffness_n_per_m"]}, {},
     r"places\[1\]: 'bearings\[0\]\.stiffness_n_per_m' is filled by sweep\.parameters\[0\]\.pl"),
]  # fmt: skip


@pytest.mark.parametrize(("method", "keys", "more", "message"), REFUSED)
def test_wrong_sweep_is_refused(tmp_path, small_scene, method, keys, more, message):
    path = tmp_path / "wrong.toml"
    data = swept(small_scene, method, parameter(**keys) | keys, **more)
    path.write_text(scene_text(data, {}), encoding="utf-8")
    with pytest.raises(SceneError, match=message) as caught:
        batch_cases([path])
    # keys that do not fit, and those that are missing instead
    assert len(caught.value.problems) <= 2
    assert all(problem.startswith("sweep.") for problem in caught.value.problems)
    assert str(caught.value).startswith(f"{path}: sweep.")


def test_all_problems_of_a_sweep_at_once(small_scene):
    data = swept(
        small_scene,
        "list",
        parameter("a", values=[1, 2]),
        parameter("a", ("nowhere",), values=[1, 2, 3]),
        samples=5,
    )
    with pytest.raises(SceneError) as caught:
        parse_scene(data)
    keys = [problem.split(":")[0] for problem in caught.value.problems]
    assert keys == [
        "sweep.parameters[1].name",
        "sweep.samples",
        "sweep.parameters[1].values",
        "sweep.parameters[1].places[0]",
    ]


def test_grid_of_too_many_cases_is_refused(small_scene):
    three = [parameter(n, (p,), lower=1, upper=2, count=30) for n, p in zip("abc", "xyz")]  # noqa: B905
    with pytest.raises(SceneError, match="the grid has 27000 cases; at most 20000 are allowed"):
        parse_scene(swept(small_scene, "grid", *three))


def test_sweep_without_any_scene_is_refused(tmp_path, small_scene):
    """A key that the scene leaves out may be new to it, but not to the program."""
    place = "bearings[left].stifness_n_per_m"
    path = written(tmp_path, swept(small_scene, "grid", parameter(places=(place,), values=[1, 2])))
    with pytest.raises(SceneError) as caught:
        batch_cases([path])
    assert str(caught.value) == (
        f"{path}: sweep: no case makes a scene; small-0001 (k = 1): bearings[0].stifness_n_per_m: "
        "unknown key; did you mean 'stiffness_n_per_m'?"
    )


def test_options_that_do_not_fit_are_refused(tmp_path, small_scene):
    """One that replaces what is swept, and one that the scene can not have."""
    level = parameter("level", ("model.level",), values=["beam"])
    path = written(tmp_path, swept(small_scene, "list", level))
    with pytest.raises(SceneError, match=r"parameters\[0\]\.places: --level replaces 'model\.le"):
        batch_cases([path], level="harmonic")
    assert batch_cases([path], accuracy=1e-2)
    path = written(tmp_path, small_scene(model={"order": 4}))
    with pytest.raises(SceneError, match="order"):
        batch_cases([path], level="solid")


def test_names_of_folders_are_unique(tmp_path, small_scene):
    first = written(tmp_path, swept(small_scene, "list", parameter(values=[1e6])), "first.toml")
    second = written(tmp_path, {**small_scene(), "name": "small-0001"}, "second.toml")
    third = written(tmp_path, {**small_scene(), "name": "Small-0001"}, "third.toml")
    with pytest.raises(
        SceneError, match=rf"{second}: name: a case of {first} is named 'small-0001"
    ):
        batch_cases([first, second])
    with pytest.raises(SceneError, match=rf"{third}: name: 'Small-0001' and 'small-0001'"):
        batch_cases([first, third])
    with pytest.raises(SceneError, match="is named 'small-0001' too"):
        batch_cases([first, first])
    device = written(tmp_path, {**small_scene(), "name": "nul"}, "nul.toml")
    with pytest.raises(SceneError, match="name: 'nul' can not be the name of a file"):
        batch_cases([device])


VALUES = [None, True, "", "x", [], {}, -1, 0, 5e-324, 1e30, 10**400, math.nan, math.inf]


@pytest.mark.parametrize("value", VALUES)
def test_every_value_of_a_sweep_replaced_gives_cases_or_one_message(tmp_path, scene_data, value):
    """Exhaustive over the demonstration scene, and over a grid of a range."""
    path = tmp_path / "sweep.toml"
    ranged = {"lower": 1e6, "upper": 1e8, "count": 3, "spacing": "logarithmic"}
    place = "bearings[front].stiffness_n_per_m"
    grid = {"method": "grid", "parameters": [parameter(places=(place,), **ranged)]}
    sampled = scene_data("sweep")
    sampled["sweep"]["samples"] = 4
    for base in (sampled, {**sampled, "sweep": grid}):
        for steps in leaves(base["sweep"]):
            data = copy.deepcopy(base)
            holder = data["sweep"]
            for step in steps[:-1]:
                holder = holder[step]
            holder[steps[-1]] = value
            if value is None:
                del holder[steps[-1]]
            try:
                parse_scene(data, path)
                path.write_text(scene_text(data, {}), encoding="utf-8")
                assert batch_cases([path])
            except SceneError as error:
                assert str(error).startswith(f"{path}: sweep"), steps


def leaves(value, path=()):
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
        yield (*path, key)
        if isinstance(inner, dict | list):
            yield from leaves(inner, (*path, key))
