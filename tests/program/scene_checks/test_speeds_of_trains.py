"""Operating speeds of shafts that are coupled to one with a range of its own."""

from __future__ import annotations

import pytest
from beam_scene import BEAM

from solidwhirl.analyses.base import judged_text
from solidwhirl.core.errors import SceneError
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.pipeline.verdict_text import answers
from solidwhirl.scene_checks.operating import operating_speeds, running_speeds
from solidwhirl.scene_reading.reader import parse_scene


def gear(first, second, ratio):
    return {"name": f"{first}-{second}", "first": f"{first}.b", "second": f"{second}.a",
            "ratio": ratio}  # fmt: skip


def train(ratios, gears=(), operating=(), **more):
    """Shafts of speed ratios, each on two bearings."""
    return parse_scene(
        {
            "name": "train",
            "speeds": {"to_rpm": 3000.0, "count": 3},
            "beams": {name: BEAM | {"speed_ratio": ratio} for name, ratio in ratios.items()},
            "bearings": [
                {"name": f"{name}_{end}", "first": f"{name}.{end}", "stiffness_n_per_m": 1e6}
                for name in ratios
                for end in "ab"
            ],
            "gears": [gear(*own) for own in gears],
            "operating": [
                {"shaft": shaft, "from_rpm": low, "to_rpm": high} for shaft, low, high in operating
            ],
            **more,
        }
    )


def speeds(scene):
    return {o.shaft: (round(o.from_rpm, 6), round(o.to_rpm, 6)) for o in operating_speeds(scene)}


TWO_STAGES = ({"m": 1.0, "i": -2.5, "p": 10.0, "c": 10.0}, [("m", "i", -2.5), ("i", "p", -4.0)])
SPOOLS = ({"lp": 1.0, "hp": 1.8, "fan": 0.4, "frame": 0.0}, [("lp", "fan", 0.4)])


@pytest.mark.parametrize(
    ("parts", "given", "follow"),
    [
        (TWO_STAGES, [("m", 1480, 1500)], {"i": (3700, 3750), "p": (14800, 15000)}),
        (TWO_STAGES, [("c", 15000, 15000)], {"m": (1500, 1500), "i": (3750, 3750)}),
        (TWO_STAGES, [("m", 1480, 1500), ("i", 3701, 3749)], {"p": (14800, 15000)}),
        # only the ratios of the speeds join the spools of an engine
        (SPOOLS, [("hp", 9000, 18000)], {"lp": (5000, 10000), "fan": (2000, 4000)}),
        (SPOOLS, [("lp", 4000, 5000), ("hp", 9900, 18000)], {"fan": (1600, 2000)}),
    ],
)
def test_shafts_without_speeds_of_their_own_follow(parts, given, follow):
    own = {shaft: (low, high) for shaft, low, high in given}
    assert speeds(train(*parts, given)) == own | follow


def test_one_that_turns_alike_is_one_with_the_shaft():
    (_, _, last) = operating_speeds(train(*TWO_STAGES, [("m", 1480, 1500)]))
    assert last.bodies == ("p", "c") and last.follows == "m"
    assert last.is_of(["c"]) and not last.is_of(["m"])


@pytest.mark.parametrize("given", [("c", 14800, 16000), ("i", 3700, 3700), ("c", 1480, 1500)])
def test_speeds_that_no_gear_allows_are_refused_with_both(given):
    with pytest.raises(SceneError) as error:
        train(*TWO_STAGES, [("m", 1480, 1500), given])
    (text,) = error.value.problems
    assert text.startswith("operating[1]: ")
    assert f"{given[0]!r} runs at {given[1]:g} to {given[2]:g} rpm, but 'm'" in text
    assert "give one, the other follows" in text


def test_spools_may_run_as_they_like():
    assert speeds(train(*SPOOLS, [("lp", 2000, 5000), ("hp", 12000, 18000)]))["hp"][0] == 12000


def test_margins_of_a_shaft_that_follows_are_those_of_its_own_speeds():
    """The faster shaft, given, or by the slower one: the same margins, judged and named."""
    margins = [{"kind": "separation_margins"}]
    parts = ({"slow": 1.0, "fast": -7.0}, [("slow", "fast", -7.0)])
    found = {}
    for given in (("slow", 1000.0, 1100.0), ("fast", 7000.0, 7700.0)):
        document = results_document(run_scene(train(*parts, [given], analyses=margins)))
        found[given[0]] = document["analyses"]["separation_margins"]
        assert set(document["verdict"]["margins"]["judged"]) == {"slow", "fast"}
        (said,) = (a for a in answers(document) if a.about == "Separation margins")
        assert "fast at 7000 to 7700 rpm" in said.text and "slow at 1000 to 1100 rpm" in said.text
        # limits of vibration and margins of the table are of the shaft's own speeds
        ends = {c["margin_of"] for c in document["verdict"]["critical_speeds"] if c["excited"]}
        assert ends <= {"slow", "fast"} and "fast" in ends
    assert any(m["shaft"] == "fast" for m in found["slow"]["margins"])
    for shaft in ("slow", "fast"):
        both = [[m["margin"] for m in f["margins"] if m["shaft"] == shaft] for f in found.values()]
        assert both[0] == pytest.approx(both[1], rel=1e-9)


def test_what_turns_and_was_not_judged_is_named():
    scene = train(*TWO_STAGES, [("m", 1480, 1500)])
    every = running_speeds(scene)
    assert judged_text(every, scene.speed_ratios()) == (
        "judged: m at 1480 to 1500 rpm; i at 3700 to 3750 rpm; p and c at 14800 to 15000 rpm"
    )
    assert judged_text(every[1:2], scene.speed_ratios()) == (
        "judged: i at 3700 to 3750 rpm alone; m, p, c, which turn too, were not judged"
    )
    assert judged_text(every[:1], {"m": 1.0, "frame": 0.0}) == ""
