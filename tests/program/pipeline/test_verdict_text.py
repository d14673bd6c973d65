"""The verdict of a run in words: what is judged, named and left out."""

from __future__ import annotations

import pytest

from solidwhirl.pipeline.verdict_text import answers

INTERVAL = {
    "from_rpm": 708.4, "to_rpm": 900.0, "opens": True, "closes": True, "kind": "flutter",
    "frequency_hz": 40.123, "whirl": "forward",
}  # fmt: skip


ACCURACY = {"asked": 1e-3, "largest_error_estimate": 3e-4, "met": True, "not_estimated": []}


def critical(rpm, *, excited=True, margin=None, factor=5.0):
    return {
        "speed_rpm": rpm, "whirl": "forward", "amplification_factor": factor, "excited": excited,
        "shares": {"lateral": 1.0, "torsional": 0.0, "axial": 0.0, "disk": 0.0},
        "margin": margin, "margin_of": None if margin is None else "rotor",
    }  # fmt: skip


def verdict(**more):
    return {
        "verdict": {
            "speed_range_rpm": [0.0, 12000.0],
            "unstable_intervals": [],
            "at_operating": [],
            "critical_speeds": [],
            "margins": {"passed": None, "method": None, "why": ""},
            "vibration": [],
            "accuracy": ACCURACY,
            "coupling_effect": None,
        }
        | more
    }


def said(about, **more):
    return next(a for a in answers(verdict(**more)) if a.about.startswith(about))


def test_without_questions_there_are_stability_critical_speeds_and_accuracy():
    found = answers(verdict())
    assert [a.about.split(" (")[0] for a in found] == ["Stability", "Critical speeds", "Accuracy"]
    assert found[0].text == "stable, 0 to 12000 rpm" and found[0].good is True
    assert found[1].text == "none that unbalance excites up to 12000 rpm"
    assert found[2].marked == "✓ **met**: 0.03 % estimated, 0.1 % asked"


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({}, "unstable 708 to 900 rpm (flutter, forward whirl, 40.12 Hz)"),
        ({"closes": False}, "unstable from 708 rpm (flutter, forward whirl, 40.12 Hz)"),
        ({"kind": "divergence"}, "unstable 708 to 900 rpm (divergence)"),
    ],
)
def test_unstable_speeds(changed, text):
    found = said("Stability", unstable_intervals=[INTERVAL | changed])
    assert found.text == text and found.good is False
    many = said("Stability", unstable_intervals=[INTERVAL] * 5).text
    assert many.count("flutter") == 3 and many.endswith("and 2 more intervals")


def test_damping_at_operating_speeds():
    def end(rpm, decrement, hertz, shaft="a"):
        mode = {"log_decrement": decrement, "frequency_hz": hertz}
        return {"shaft": shaft, "shaft_speed_rpm": rpm, "first_forward": mode}

    found = said("Log. decrement", at_operating=[end(8500.0, 1.09, 123.7), end(9000.0, None, 5.0)])
    assert found.text == "1.09 at 8500 rpm (123.7 Hz); no damping at 9000 rpm (5 Hz)"
    assert found.good is None
    assert said("Log. decrement", at_operating=[end(8500.0, -0.1, 9.0)]).good is False
    assert "none" in said("Log. decrement", at_operating=[end(8500.0, None, None)]).text
    two = said("Log. decrement", at_operating=[end(1.0, 1.0, 1.0), end(2.0, 1.0, 1.0, "b")]).text
    assert "1 rpm of a" in two and "2 rpm of b" in two


def test_critical_speeds_are_those_that_unbalance_excites_nearest_first():
    every = [critical(1000.0 * k, margin=0.1 * (k - 6)) for k in range(1, 9)]
    every.append(critical(6100.0, excited=False, margin=0.0))
    text = said("Critical speeds", critical_speeds=every).text
    assert text.startswith("8 that unbalance excites; nearest: 5000 rpm (forward, AF 5, 10 % below")
    assert "6000 rpm (forward, AF 5, inside the speeds of rotor)" in text
    assert "7000" in text and "6100" not in text and "4000" not in text
    lone = said("Critical speeds", critical_speeds=[critical(50.25, factor=None)]).text
    assert lone == "50.25 rpm (forward, undamped)"


def test_weight_has_critical_speeds_where_a_body_bends_unlike_in_two_planes():
    assert said("Gravity", gravity_critical_speeds=[]).text == "none in the speed range"
    found = [{"speed_rpm": rpm} for rpm in (4013.2, 8000.0, 9000.0, 9500.0)]
    assert said("Gravity", gravity_critical_speeds=found[:1]).text == "4013 rpm"
    text = said("Gravity", gravity_critical_speeds=found).text
    assert text == "4013 rpm; 8000 rpm; 9000 rpm, and 1 more"


@pytest.mark.parametrize(
    ("changed", "text", "good"),
    [
        ({"met": False, "largest_error_estimate": 3.2},
         "NOT met: 320 % estimated, 0.1 % asked", False),
        ({"met": None, "not_estimated": ["a", "b"]},
         "not estimated: a, b; the rest 0.03 % estimated, 0.1 % asked", None),
        ({"met": None, "not_estimated": ["a"], "largest_error_estimate": None},
         "not estimated: a", None),
        ({"met": False, "not_estimated": ["a"]},
         "NOT met: 0.03 % estimated, 0.1 % asked; not estimated: a", False),
        ({"met": None, "largest_error_estimate": None}, "no error estimates", None),
    ],
)  # fmt: skip
def test_accuracy_names_what_is_not_estimated(changed, text, good):
    found = said("Accuracy", accuracy=ACCURACY | changed)
    assert found.text == text and found.good is good


def test_margins_vibration_and_choice_of_interfaces():
    margins = {"passed": False, "method": "api617", "why": "too near"}
    found = said("Separation margins", margins=margins)
    assert found.marked == "✗ **fail** (by API 617): too near"
    # a pass is one where the errors of the critical speeds are known and small enough
    for decided, good in ((True, True), (False, None), (None, None)):
        passed = {"passed": True, "method": "api617", "why": "far", "decided": decided}
        assert said("Separation margins", margins=passed).good is good
    places = [
        {"place": p, "api617_limit_um": 25.4, "over_sweep": None, "at_operating": own}
        for p, own in (("a.x", None), ("a.y", {"peak_to_peak_um": 9.87, "speed_rpm": 8500.0}))
    ]
    assert said("Vibration", vibration=places).text == (
        "9.87 µm peak to peak at a.y, 8500 rpm, the largest of 2 places; limit of API 617 at the "
        "probes: 25.4 µm"
    )
    assert said("Choice of interfaces", coupling_effect=0.024).text.startswith("up to 2.4 %")
    # not where it is worth no more than the error
    assert not [a for a in answers(verdict(coupling_effect=5e-4)) if a.about.startswith("Choice")]
