"""What a run comes to, against a rigid rotor of four motions written out in numpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from beam_scene import beam_scene
from engine_parts import RIGID, RPM

from solidwhirl.analyses.base import Operating, Stability
from solidwhirl.analyses.responses.run_up import complexity_chart
from solidwhirl.batch.rows import verdict_scalars
from solidwhirl.console.summary import warning_texts
from solidwhirl.core.errors import SceneError
from solidwhirl.estimates.documents import coupling_effect
from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.alarms import alarms_of, diagram_alarms
from solidwhirl.pipeline.run import run_scene
from solidwhirl.pipeline.verdict_text import answers
from solidwhirl.rotordyn.campbell.branches import TrackingNote
from solidwhirl.rotordyn.stability.intervals import UnstableInterval
from solidwhirl.scene_reading.reader import parse_scene

MASS = RIGID["mass_kg"]
DIAMETRAL, _, POLAR = RIGID["inertia_kg_m2"]
# of the bearings from the centre of gravity
ARMS = (-0.1, 0.2)
CROSS = [[1e6, 3e5], [-3e5, 1e6]]


def scene(stiffness=1e6, damping=0.0, analyses=(), to_rpm=9000.0, **more):
    ends = {"stiffness_n_per_m": stiffness, "damping_n_s_per_m": damping}
    data = {
        "name": "rigid",
        "speeds": {"to_rpm": to_rpm, "count": 4},
        "rigid_bodies": {"r": RIGID},
        "bearings": [{"name": end, "first": f"r.{end}", **ends} for end in "ab"],
        "analyses": list(analyses),
    }
    return parse_scene({**data, **more})


def verdict(*args, **more):
    return results_document(run_scene(scene(*args, **more)))


def first_order(stiffness, damping, speed):
    """State matrix of (x, y, slopes of x and y) of the rigid rotor."""
    arms = np.kron([[1.0, 1.0], ARMS], np.eye(2))  # motion at the bearings = armsᵀ q
    each = stiffness * np.eye(2) if np.ndim(stiffness) == 0 else np.array(stiffness)
    k = arms @ np.kron(np.eye(2), each) @ arms.T
    c = damping * arms @ arms.T
    # slopes a, b: Id a'' + Ω Ip b' and Id b'' − Ω Ip a'
    c[2:, 2:] += speed * POLAR * np.array([[0.0, 1.0], [-1.0, 0.0]])
    m = np.diag([MASS, MASS, DIAMETRAL, DIAMETRAL])
    return np.block(
        [[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]]
    )


def first_of(whirl, stiffness, damping, speed):
    """Lowest mode that whirls forward (+1) or backward (−1) and vibrates: λ."""
    values, vectors = np.linalg.eig(first_order(stiffness, damping, speed))
    turn = [np.abs(v[0] + whirl * 1j * v[1]) > np.abs(v[0] - whirl * 1j * v[1]) for v in vectors.T]
    zeta = -values.real / np.abs(values)
    fits = [v for v, t, z in zip(values, turn, zeta, strict=True) if v.imag > 0 and t and z < 0.7]
    return min(fits, key=lambda v: v.imag)


MARGINS = {"kind": "separation_margins"}
OPERATING = [{"shaft": "r", "from_rpm": 4000, "to_rpm": 6000}]
RESPONSE = {
    "kind": "unbalance_response",
    "to_rpm": 9000,
    "unbalances": [{"at": "r.a", "moment_kg_m": 1e-4}],
    "observe": ["r.b"],
}


@pytest.fixture(scope="module")
def unstable():
    """Cross-coupled bearings with little damping, no analysis of stability."""
    found = scene(CROSS, 150.0, [RESPONSE], operating=OPERATING)
    results = run_scene(found)
    return results, results_document(results)


def test_instability_is_told_without_an_analysis_of_it(unstable):
    results, document = unstable
    found = document["verdict"]
    growth = np.linalg.eigvals(first_order(CROSS, 150.0, 0.0)).real.max()
    assert growth > 50.0
    assert found["stable"] is False
    assert found["unstable_from_rpm"] == 0.0
    (interval,) = found["unstable_intervals"]
    assert interval["kind"] == "flutter"
    assert interval["whirl"] == "forward"
    assert interval["to_rpm"] == pytest.approx(9000.0)
    speeds = np.linspace(0, 9000, 31) * RPM
    largest = max(np.linalg.eigvals(first_order(CROSS, 150.0, s)).real.max() for s in speeds)
    assert interval["largest_growth_rate_per_s"] == pytest.approx(largest, rel=1e-3)
    kinds = [alarm["kind"] for alarm in found["alarms"]]
    assert kinds == ["unstable", "unstable operation"]
    messages = [alarm["message"] for alarm in found["alarms"]]
    assert messages[0].endswith("; no steady vibration exists from here on, although "
                                "unbalance_response goes there")  # fmt: skip
    assert all("\n" not in m and m.split()[1] == "rpm:" for m in messages)
    assert [d["message"] for d in document["doubts"]][-2:] == messages
    assert warning_texts(document)[-2:] == messages
    assert verdict_scalars(found)["verdict.stable"] == 0.0
    assert "failed" not in repr(results)


def test_first_modes_at_the_operating_speeds(unstable):
    _, document = unstable
    found = document["verdict"]["at_operating"]
    assert [e["shaft_speed_rpm"] for e in found] == [4000, 6000]
    for entry in found:
        assert entry["stable"] is False
        for key, whirl in (("first_forward", 1), ("first_backward", -1)):
            value = first_of(whirl, CROSS, 150.0, entry["speed_rpm"] * RPM)
            own = entry[key]
            assert own["frequency_hz"] == pytest.approx(value.imag / 2 / np.pi, rel=1e-9)
            decrement = -2 * np.pi * value.real / value.imag
            assert own["log_decrement"] == pytest.approx(decrement, rel=1e-9)
    scalars = verdict_scalars(document["verdict"])
    least = min(e["first_forward"]["log_decrement"] for e in found)
    assert scalars["verdict.first_forward_log_decrement"] == least < 0


def test_a_stable_rotor_alarms_of_nothing():
    document = verdict(1e6, 500.0, [RESPONSE], operating=OPERATING)
    found = document["verdict"]
    assert found["stable"] is True
    assert found["unstable_intervals"] == found["alarms"] == document["doubts"] == []
    # steady response of the four motions at the highest operating speed, both sides
    speeds = np.array(document["analyses"]["unbalance_response"]["speed_rpm"])
    inside = np.unique([*speeds[(speeds > 4000) & (speeds < 6000)], 4000.0, 6000.0])
    largest = max(_swing(500.0, rpm * RPM) for rpm in inside)
    (own,) = found["vibration"]
    assert own["at_operating"]["peak_to_peak_um"] == pytest.approx(largest, rel=1e-3)
    assert own["over_sweep"]["peak_to_peak_um"] >= own["at_operating"]["peak_to_peak_um"]
    assert own["api617_limit_um"] is None


@pytest.mark.parametrize(
    ("chosen", "limit"), [({"method": "api617"}, 25.4), ({}, None), ({"method": "percent"}, None)]
)
def test_the_limit_of_a_standard_is_that_of_scenes_that_chose_it(chosen, limit):
    asked = [RESPONSE, {**MARGINS, **chosen}]
    document = verdict(1e6, 500.0, asked, operating=OPERATING)
    found = document["verdict"]["vibration"][0]["api617_limit_um"]
    assert found == (limit and pytest.approx(limit, rel=1e-14))
    said = next(a.text for a in answers(document) if a.about == "Vibration")
    assert ("API 617" in said) is (limit is not None)


def interval(low, high, closes):
    return UnstableInterval(
        low_rad_s=low * RPM, high_rad_s=high * RPM, opens=True, closes=closes, kind="flutter",
        growth_1_s=1.0, speed_rad_s=high * RPM, eigenvalue=100j, frequency_hz=16.0,
        frequency_end_hz=16.0, whirl="forward", shape=np.empty(0),
    )  # fmt: skip


def test_a_mode_that_stands_still_in_space_is_told_unless_it_grows():
    notes = [
        TrackingNote(kind=kind, speed_rad_s=rpm * RPM, branches=(), text="")
        for kind, rpm in (("indefinite", 567.0), ("crossing", 600.0), ("indefinite", 800.0))
    ]
    still = Stability(low_rpm=0.0, high_rpm=900.0, intervals=(), at_operating=())
    first, second = diagram_alarms(notes, still)
    assert first.message.startswith("567 rpm: a mode stands still in space, at 1/rev")
    assert second.speed_rpm == pytest.approx(800.0)
    (alone,) = diagram_alarms(notes, replace(still, intervals=(interval(800.0, 900.0, False),)))
    assert alone == first


def test_modes_made_by_a_steep_law_are_warned_of_once():
    notes = [
        TrackingNote(kind="steep law", speed_rad_s=rpm * RPM, branches=(k,), text="")
        for k, rpm in ((4, 800.0), (2, 600.0))
    ]
    still = Stability(low_rpm=0.0, high_rpm=900.0, intervals=(), at_operating=())
    (told,) = diagram_alarms(notes, still)
    assert told.message.startswith("600 rpm: ")
    assert "(branch 5, 3)" in told.message


def test_each_onset_alarms_once():
    """Flutter from 4500 rpm on, where a shaft runs that has not begun to before."""
    found = Stability(
        low_rpm=0.0,
        high_rpm=9000.0,
        intervals=(interval(1000.0, 1100.0, True), interval(4500.0, 9000.0, False)),
        at_operating=(),
    )
    document = {"unbalance": {"kind": "unbalance_response", "speed_rpm": [2000.0, 9000.0]}}
    early, late = Operating("r", 4000.0, 6000.0, 1.0), Operating("s", 5000.0, 6000.0, 1.0)
    alarms = alarms_of(found, (early, late), document)
    assert [(a.kind, a.speed_rpm) for a in alarms] == [
        ("unstable", pytest.approx(1000.0)),
        ("unstable operation", pytest.approx(4500.0)),
        ("unstable operation", pytest.approx(5000.0)),
    ]
    assert alarms[1].message.count(" rpm: ") == 1
    closed = replace(found, intervals=found.intervals[:1])
    slow = {"unbalance": {**document["unbalance"], "speed_rpm": [500.0, 9000.0]}}
    (alarm,) = alarms_of(closed, (), slow)
    assert "exists up to 1100 rpm, although unbalance goes there" in alarm.message
    (_, alarm) = alarms_of(closed, (Operating("s", 1050.0 * 2, 6000.0, 2.0),), {})
    assert alarm.message.startswith("2100 rpm: s operates")
    assert alarm.message.endswith("is unstable up to 2200 rpm")
    assert "r operates" in alarms[1].message and "unbalance goes there" in alarms[1].message


def _swing(damping, speed):
    """Peak to peak of interface b in um by an unbalance of 1e-4 kg m at a."""
    force = 1e-4 * speed**2 * np.array([1.0, -1j, ARMS[0], -1j * ARMS[0]])
    force[2:] /= DIAMETRAL
    force[:2] /= MASS
    state = np.linalg.solve(
        1j * speed * np.eye(8) - first_order(1e6, damping, speed), [*[0] * 4, *force]
    )
    x = state[0] + ARMS[1] * state[2]
    y = state[1] + ARMS[1] * state[3]
    return 1e6 * (np.abs(x + 1j * y) + np.abs(x - 1j * y))


STABILITY = {"kind": "stability", "to_rpm": 9000, "count": 5}


def test_destabilising_cross_coupling_never_raises_the_smallest_decrement():
    """It does among all modes of a beam: the least damped is one of kilohertz.

    The first forward mode over the speed is that of the four motions.
    """
    stiffness = [[1e6, 2e5], [-2e5, 1e6]]
    found = verdict(stiffness, 300.0, [STABILITY])["analyses"]["stability"]
    value = first_of(1, stiffness, 300.0, 9000 * RPM)
    decrement = -2 * np.pi * value.real / value.imag
    assert found["first_forward"]["log_decrement"][-1] == pytest.approx(decrement, rel=1e-9)
    least = []
    for skew in (0.0, 2e5, 4e5):
        data = beam_scene([STABILITY], 9000.0).model_dump(mode="json", exclude_none=True)
        data["speeds"] = {"list_rpm": [0.0, 9000.0]}
        for bearing in data["bearings"]:
            bearing["stiffness_n_per_m"] = [[1e6, skew], [-skew, 1e6]]
            bearing["damping_n_s_per_m"] = [[1e3, 0], [0, 1e3]]
        found = results_document(run_scene(parse_scene(data)))["analyses"]["stability"]
        assert found["frequency_max_hz"] == 3 * 9000 / 60
        assert max(found["frequency_hz"]) < 450.0
        least.append(found["smallest_log_decrement"][-1])
    assert least == sorted(least, reverse=True)
    assert least[0] > 2 * least[-1]


def test_margins_are_judged_by_the_whirl_that_unbalance_excites():
    """Of an isotropic rotor without damping: backward whirl inside, forward whirl 10 % below."""
    chosen = {**MARGINS, "name": "plain", "method": "percent", "percent": 5}
    own = {"operating": [{"shaft": "r", "from_rpm": 4700, "to_rpm": 5000}]}
    document = verdict(1e6, 0.0, [MARGINS, chosen], **own)
    found = document["analyses"]["separation_margins"]
    assert [{key: o[key] for key in own["operating"][0]} for o in found["operating"]] == (
        own["operating"]
    )
    inside = [m for m in found["margins"] if m["position"] == "inside"]
    assert [(m["whirl"], m["excited"]) for m in inside] == [("backward", False)]
    assert "against the shaft" in inside[0]["excited_why"]
    (forward,) = [m for m in found["margins"] if m["excited"]]
    assert forward["whirl"] == "forward"
    assert forward["amplification_factor"] is None
    assert 0.05 < -forward["margin"] < 0.16 == forward["required"]
    assert found["verdict"]["passed"] is False
    assert found["verdict"]["worst"]["whirl"] == "forward"
    plain = document["analyses"]["plain"]
    assert plain["verdict"]["passed"] is True
    assert plain["verdict"]["worst"]["required"] == pytest.approx(0.05)
    summed = document["verdict"]["margins"]
    assert (summed["passed"], summed["method"]) == (False, "api617")
    # the decrements are rounding: null, and no mode is unstable
    assert all(c["log_decrement"] is None for c in document["critical_speeds"])
    assert all(d is None for branch in document["campbell"]["log_decrement"] for d in branch)
    assert "unstable" not in {m["verdict_api_617"] for m in found["margins"]}
    assert document["verdict"]["stable"] is True


def test_damped_roots_are_told_apart_and_judged_by_no_margin():
    """Heavily damped modes are critical speeds of nothing; the limit is a key of the scene."""
    own = {"operating": [{"shaft": "r", "from_rpm": 3000, "to_rpm": 5000}]}
    document = verdict(1e6, 1200.0, [MARGINS], **own)
    criticals = document["critical_speeds"]
    assert criticals
    assert all(c["critically_damped"] for c in criticals)
    assert all(c["amplification_factor"] < 2.5 for c in criticals)
    found = document["analyses"]["separation_margins"]
    assert found["margins"] == []
    assert len(found["critically_damped"]) >= len(criticals)
    assert found["verdict"]["passed"] is True
    assert document["verdict"]["critical_speeds"] == []
    marks = np.array(document["campbell"]["critically_damped"])
    assert marks.any()
    # a lower limit lets them count again, and by a plain percentage they are too near
    percent = {**MARGINS, "method": "percent", "percent": 30}
    strict = verdict(1e6, 1200.0, [percent], criteria={"amplification_min": 0.5}, **own)
    assert not all(c["critically_damped"] for c in strict["critical_speeds"])
    judged = strict["analyses"]["separation_margins"]
    assert judged["verdict"]["passed"] is False
    assert judged["verdict"]["method"] == "percent"
    assert judged["margins"][0]["required_api_617"] == 0.0


def test_the_accuracy_is_that_of_modes_that_count():
    results = run_scene(scene(1e6, 600.0))
    found, rule = results.estimates, results.scene.criteria.rule
    counts = rule.counts(found.campbell.campbell.eigenvalues)
    assert counts.any()
    assert not counts.all()
    for where, largest in ((~counts, found.largest), (counts, 1.0)):
        total = np.where(where, 1.0, found.campbell.total)
        errors = replace(found.campbell, parts={"mesh": total})
        assert replace(found, campbell=errors).largest == largest
    for k, own in enumerate(found.critical):
        total = np.where(np.arange(len(found.critical)) == k, 1.0, found.critical_speeds.total)
        errors = replace(found.critical_speeds, parts={"mesh": total})
        assert (replace(found, critical_speeds=errors).largest == 1.0) is own.counts(rule)


def test_the_choice_of_the_coupling_counts_where_it_matters():
    diagram = {
        "error_parts": {"interface_coupling": [[0.02, None], [0.77, 0.01]]},
        "critically_damped": [[False, False], [True, False]],
    }
    assert coupling_effect({"campbell": diagram, "critical_speeds": []}) == 0.02
    speeds = [
        {"critically_damped": damped, "error_parts": {"interface_coupling": value}}
        for damped, value in ((True, 0.5), (False, 0.024))
    ]
    assert coupling_effect({"campbell": diagram, "critical_speeds": speeds}) == 0.024


RUN = {
    "kind": "run_up",
    "ramp_s": 0.5,
    "to_rpm": 9000,
    "sampling_hz": 10000,
    "record_hz": 10000,
    "mount": "a",
    "unbalances": [{"at": "r.a", "moment_kg_m": 1e-5}],
    "observe": ["r.a"],
}


def test_a_run_up_that_diverges_stops():
    document = verdict(CROSS, 0.0, [RUN])
    found = document["analyses"]["run_up"]
    stopped = found["diverged"]
    assert 0.3 < stopped["amplitude_m"] < 0.35  # longer than the rotor, one step later
    assert 0.0 < stopped["speed_rpm"] < 9000.0
    assert found["largest_mount_force_n"] < 1e6
    (alarm,) = [a for a in document["verdict"]["alarms"] if a["kind"] == "run-up diverged"]
    assert f"{stopped['speed_rpm']:.6g} rpm" in alarm["message"]
    # and not where nothing grows
    stable = verdict(1e6, 100.0, [RUN])
    assert stable["analyses"]["run_up"]["diverged"] is None
    assert stable["verdict"]["alarms"] == []


def test_a_compared_model_that_diverges_is_told_and_left_out(monkeypatch):
    unstable = run_scene(scene(CROSS, 0.0)).system
    monkeypatch.setattr(
        "solidwhirl.analyses.responses.run_up.rigid_bodies_system", lambda *_: unstable
    )
    asked = {**RUN, "compare_flexible": [[]], "bands_hz": [[10.0, 60.0]]}
    document = verdict(1e6, 100.0, [asked])
    found = document["analyses"]["run_up"]
    alone = verdict(CROSS, 0.0, [RUN])["analyses"]["run_up"]["diverged"]
    assert found["diverged"] is None
    assert [model["name"] for model in found["complexity"]["models"]] == ["all modes"]
    (left,) = found["complexity"]["diverged"]
    assert left == {"name": "no modes", **alone}
    (alarm,) = document["verdict"]["alarms"]
    assert alarm["kind"] == "compared model diverged"
    assert alarm["message"].startswith(f"{left['speed_rpm']:.6g} rpm: ")
    chart = complexity_chart(found["complexity"])
    assert "not compared: no modes at" in chart.caption


@pytest.mark.parametrize(
    ("gravity", "text"),
    [
        ([0, 0, -9.81], "no axial bearing carries the weight of 'r' along z"),
        ([0, -9.81, 0], "no bearing carries the weight of 'r' along y"),
    ],
)
def test_weight_that_nothing_carries_is_refused_before_computing(gravity, text):
    """Axial damping alone, or one bearing away from the centre of gravity, hold nothing."""
    data = scene().model_dump(mode="json", exclude_none=True)
    data["bearings"][0]["axial_damping_n_s_per_m"] = 10.0
    del data["bearings"][1 if gravity[1] else 2 :]
    data["analyses"] = [{**RUN, "gravity_m_per_s2": gravity}]
    with pytest.raises(SceneError, match=text):
        parse_scene(data)
    data["bearings"][0] |= {"axial_stiffness_n_per_m": 1e6, "tilt_stiffness_n_m_per_rad": 1e4}
    parse_scene(data)


@pytest.mark.parametrize(
    ("more", "text"),
    [
        (
            {"operating": [{"shaft": "s", "from_rpm": 1, "to_rpm": 2}]},
            "operating.0..shaft: no body",
        ),
        ({"analyses": [MARGINS]}, r"analyses.0..operating: missing"),
        ({"analyses": [{**MARGINS, "percent": 20}]}, 'use method "percent"'),
        ({"criteria": {"amplification_min": -1}}, "criteria.amplification_min"),
    ],
)
def test_operating_speeds_and_criteria_without_meaning_are_refused(more, text):
    with pytest.raises(SceneError, match=text):
        scene(**more)
