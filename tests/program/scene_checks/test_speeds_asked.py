"""Speeds above those of the diagram: who asks for them is said in the plan and in refusals."""

from __future__ import annotations

import math
import re

import pytest
from beam_scene import beam_scene, margins

from solidwhirl.output.plan_documents import plan_document
from solidwhirl.output.plan_text import plan_text
from solidwhirl.pipeline.run import make_plan
from solidwhirl.scene_checks.speeds_asked import speeds_beyond, top_speed, top_speed_text


def scene(analyses, to_rpm=18_000.0, ratio=1.0):
    return beam_scene(analyses, to_rpm, ratio)


STABILITY = {"kind": "stability", "to_rpm": 30_000.0}
# Analyses, speed ratio, and the speeds of the reference shaft that they look to.
CASES = [
    ([], 1.0, {}),
    ([margins(10_000, 12_000)], 1.0, {}),  # 1.3 · 12 000 = 15 600
    ([margins(10_000, 15_000)], 1.0, {"separation_margins": 19_500.0}),
    ([margins(10_000, 15_000)], -2.0, {}),
    ([margins(10_000, 15_000)], 0.5, {"separation_margins": 39_000.0}),
    ([margins(10_000, 15_000, search_factor=2.0)], 1.0, {"separation_margins": 30_000.0}),
    (
        [margins(10_000, 15_000), STABILITY],
        1.0,
        {"separation_margins": 19_500.0, "stability": 30_000.0},
    ),
    ([{"kind": "mode_shapes", "speeds_rpm": [1e3, 2e4]}], 1.0, {"mode_shapes": 20_000.0}),
]


@pytest.mark.parametrize(("analyses", "ratio", "expected"), CASES)
def test_who_asks(analyses, ratio, expected):
    found = scene(analyses, ratio=ratio)
    beyond = speeds_beyond(found)
    assert {a.analysis: a.speed_rpm for a in beyond} == pytest.approx(expected)
    highest = max(18_000.0, *expected.values()) if expected else 18_000.0
    assert top_speed(found) == pytest.approx(highest * math.pi / 30.0)
    assert bool(top_speed_text(found, "rotor")) == bool(expected)


def test_the_plan_lists_them():
    found = scene([margins(10_000, 15_000), STABILITY])
    plan = make_plan(found, {})
    text = plan_text(plan)
    assert "Speeds above 18000 rpm, where [speeds] ends" in text
    said = "1.3 times the operating speed of 'rotor', 15000 rpm, to which"
    assert said in text and "(search_factor)" in text
    assert "to_rpm of analyses[1] (stability)" in text
    assert [e["to_rpm"] for e in plan_document(plan)["speeds_beyond"]] == [19_500.0, 30_000.0]
    assert "Speeds above" not in plan_text(make_plan(scene([]), {}))


@pytest.mark.solver
def test_refused_speed_says_what_is_allowed_and_where_it_comes_from(invoke, ferraris, refusal):
    """Beyond linear prestress at 1.3 times the operating speed; the scene ends far below.

    In the middle of a thin solid disk the hoop strain is (1 - nu)(3 + nu)/8 rho a^2 W^2/E
    (Timoshenko and Goodier, Theory of Elasticity, section 32). The disk is a fifth as thick as its
    radius and sits on a shaft, which is worth a few per cent.
    """
    ranges = '[{ shaft = "inner", from_rpm = 100000, to_rpm = 200000 }]'
    analysis = f'\n[[analyses]]\nname = "m"\nkind = "separation_margins"\noperating = {ranges}\n'
    done, written = invoke(ferraris + analysis, "--quiet")
    message = refusal(done, "bad.toml").splitlines()[-1]
    found = re.search(
        r"at 260000 rpm the hoop strain is .* that is to (\d+) rpm.*"
        r"; this speed is 1\.3 times the operating speed of 'inner', 200000 rpm, to which "
        r"analyses\[\d\] \(m\) looks \(search_factor\), although \[speeds\] ends at 20000 rpm$",
        message,
    )
    assert found, message
    mean = (1.0 - 0.3) * (3.0 + 0.3) / 8.0 * 7800.0 * 0.15**2 / 2e11
    assert float(found[1]) == pytest.approx(math.sqrt(0.05 / mean) * 30.0 / math.pi, rel=0.05)
    assert not written
