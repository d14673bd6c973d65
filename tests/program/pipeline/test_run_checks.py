"""The checks of a run: all hold for good scenes, and what fails is said with what it spoils."""

from __future__ import annotations

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest

from solidwhirl.build import beam, bearing, body, disk, scene, unbalance
from solidwhirl.core.check_report import (
    checks_document,
    checks_line,
    checks_text,
    failed,
    failure_lines,
)
from solidwhirl.pipeline.checks import analysis_result_checks, run_checks
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.checks.plain_checks import COUNT_SPEEDS, ROOTS
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.solver


def checked(results, **changes):
    """Checks of results, with some of them changed."""
    found = lambda *names: SimpleNamespace(  # noqa: E731
        **{name: changes.get(name, getattr(results, name)) for name in names}
    )
    engine = found("elements", "system")
    engine.job, engine.reduced = results, changes.get("bodies", results.bodies)
    return run_checks(engine, found("at_rest", "campbell", "critical_speeds", "asymmetry"))


def bad(checks):
    return {(check.where, check.name) for check in failed(checks)}


@pytest.fixture(scope="module")
def small(small_scene):
    return run_scene(parse_scene(small_scene(rpm=(0.0, 20000.0, 40000.0))))


WHEEL = disk("wheel", mass_kg=2.0, polar=0.01, diametral=0.006, interface="right")
CASES = {
    "damped": {"bearing": {"damping_n_s_per_m": 500.0}},
    "stiffer in x": {"bearing": {"stiffness_n_per_m": [1e7, 3e6]}},
    "torsion": {"effects": {"torsion": "on", "axial": "on"}},
    "at rest": {"rpm": None},
    "by frequency": {"campbell": {"frequency_max_hz": 3000.0, "branches": None}},
    "beam": {"model": {"level": "beam"}},
    "disk": {"body": {"rigid_disks": [WHEEL]}},
}


@pytest.mark.parametrize("case", CASES)
def test_good_scenes_pass(small_scene, case):
    data = small_scene(**CASES[case])
    data["campbell"] = {k: v for k, v in data["campbell"].items() if v is not None}
    if "frequency_max_hz" in data["campbell"]:
        data["campbell"].pop("branches", None)
    checks = checked(run_scene(parse_scene(data)))
    assert not bad(checks)
    assert len(checks) > 20
    if case == "damped":
        assert any("damping" in check.reason for check in checks if check.passed is None)
    else:
        assert not [check for check in checks if check.passed is None]


def test_a_good_run_reports_all_kinds(small):
    checks = checked(small)
    assert not bad(checks)
    critical = {check.name for check in checks if check.where.startswith("critical speeds")}
    assert critical == {ROOTS, COUNT_SPEEDS}
    names = {check.name for check in checks}
    assert {
        "residual of every fixed-interface mode",
        "no fixed-interface mode is missing",
        "interface forces are reciprocal",
        "modes of the basis are M-orthonormal",
        "mass properties",
        "modal frequencies",
        "residual of every eigenpair",
        "no mode is missing",
        "orthogonality of the modes",
        "no critical speed is missing",
    } <= names
    assert all(check.concerns and check.where for check in checks)
    assert failure_lines(checks) == ()


def test_what_fails_is_said_with_what_it_spoils(small):
    """One thing wrong in the results: its own check fails, and names what can't be trusted."""
    values = np.array(small.campbell.eigenvalues)
    values[0, 1] *= 1.0 + 1e-6
    wrong = dataclasses.replace(small.campbell, eigenvalues=values)
    checks = checked(small, campbell=wrong)
    assert bad(checks) == {("Campbell diagram", ROOTS)}
    (line,) = failure_lines(checks)
    assert line.startswith(f"check failed: Campbell diagram: {ROOTS}: ")
    assert line.endswith("can't be trusted: branches of the Campbell diagram")
    assert "20000 rpm" in line

    checks = checked(small, critical_speeds=small.critical_speeds[1:])
    assert {name for _, name in bad(checks)} == {"no critical speed is missing"}

    element = small.elements["rotor"]
    heavy = dataclasses.replace(element, mass_kg=1.01 * element.mass_kg)
    checks = checked(small, elements={"rotor": heavy})
    assert bad(checks) == {("rotor", "mass properties")}

    result = small.bodies["rotor"]
    lost = compared(
        "no fixed-interface mode is missing", "rotor, n=1", 1.0, 0.0, "fixed-interface modes"
    )
    work = dataclasses.replace(result.work, checks=(lost,))
    checks = checked(small, bodies={"rotor": dataclasses.replace(result, work=work)})
    assert bad(checks) == {("rotor, n=1", "no fixed-interface mode is missing")}


CHECKS = (
    compared("a", "one", 1e-12, 1e-10, "nothing"),
    compared("a", "two", 5e-11, 1e-10, "nothing"),
    compared("a", "three", float("nan"), 1e-10, "frequencies", "because"),
    compared("b", "one", 0.0, 0.0, "counts"),
    compared("c", "one", -1e-3, -1e-14, "mass"),
    undecided("d", "system", "counts", "there is damping"),
)


def test_report_and_document():
    """What is no number fails."""
    assert failed(CHECKS) == (CHECKS[2],)
    assert len(failure_lines(CHECKS)) == 1
    text = checks_text(CHECKS)
    assert text.startswith("6 checks: 1 FAILED, 4 passed, 1 not applicable (damped system).")
    assert (
        "**check failed: three: a: nan, allowed 1.0e-10 (because); can't be trusted: freq" in text
    )
    # the failed one is shown of its name, not the largest that passed
    assert "| a | 3 | three | nan | 1.0e-10 |" in text
    assert "| b | 1 | one | 0 | 0 |" in text
    assert "- not applicable: system: d: there is damping" in text
    assert checks_line([CHECKS[0], CHECKS[5]]) == "1 passed, 1 not applicable (damped system)"
    assert checks_line(CHECKS[1:3]) == "1 FAILED, 1 passed"
    good = checks_text(CHECKS[:2])
    assert "| a | 2 | two | 5.0e-11 | 1.0e-10 |" in good
    assert "failed:" not in good
    document = checks_document(CHECKS)
    assert [entry["passed"] for entry in document] == [True, True, False, True, True, None]
    assert document[5]["value"] is None
    back = [Invariant(**entry) for entry in document[3:]]
    assert back == list(CHECKS[3:])
    assert document[2]["value"] is None
    json.dumps(document, allow_nan=False)


def test_a_shaft_that_an_unbalance_does_not_reach_is_no_missing_peak():
    """Two shafts on a casing that stands still: one moves by the rounding of the other alone."""

    def shaft(at, **more):
        wheel = disk("d", mass_kg=5.0, polar=0.05, diametral=0.026, at_m=at + 0.25)
        places = {"l": at, "m": at + 0.25, "r": at + 0.5}
        return beam(list(places.values()), 0.02, places, disks=[wheel], **more)

    seats = {"al": 0.0, "ar": 0.5, "bl": 1.0, "br": 1.5}
    spring = {"stiffness_n_per_m": 1e7, "damping_n_s_per_m": 100.0}
    casing = {"mass_kg": 40.0, "center_of_gravity_m": [0.0, 0.0, 0.7]}
    casing |= {"inertia_kg_m2": [4.0, 4.0, 3.0], "interfaces": seats | {"p": 0.7}}
    response = {"kind": "unbalance_response", "observe": ["a.m", "b.m"], "to_rpm": 9000}
    asked = scene(
        "apart",
        speeds_rpm=[0.0, 4500.0, 9000.0],
        branches=6,
        beams={"a": shaft(0.0), "b": shaft(1.0, speed_ratio=0.7)},
        rigid_bodies={"casing": casing},
        bearings=[
            *(bearing(s, f"{s[0]}.{s[1]}", f"casing.{s}", **spring) for s in seats),
            bearing("mount", "casing.p", rigid=["ux", "uy", "uz", "rx", "ry", "rz"]),
        ],
        analyses=[{**response, "unbalances": [unbalance("a.m", 1e-5)]}],
    )
    results = run_scene(asked)
    (exciter,) = results.analyses["unbalance_response"].document["exciters"]
    reached, other = (max(exciter["places"][place]["major_m"]) for place in ("a.m", "b.m"))
    assert other < 1e-20 * reached
    assert len(exciter["peaks"]["a.m"]) == 1
    assert not bad(results.checks)


@pytest.mark.parametrize("away_m", [9.0, 300.0])
def test_a_small_rotor_far_from_the_origin_passes(small_scene, away_m):
    """Its places are known to the rounding of the distance, and so are lengths of its beams."""
    data = small_scene(model={"level": "beam"})
    body = data["bodies"]["rotor"]
    for part in (*body["sections"], *body["interfaces"]):
        for key in part.keys() & {"start_m", "end_m", "at_m"}:
            part[key] = away_m + 0.25 * part[key]
    assert not bad(run_scene(parse_scene(data)).checks)


@pytest.mark.parametrize("spin_rpm", [0.0, 7000.0])
def test_a_force_that_turns_alone_is_checked_at_the_spin_of_the_rotor(spin_rpm):
    """Forces turn through 12 000 rpm on an overhung disk at one spin; softer bearings at speed."""
    places = {"a": 0.0, "m": 0.2, "b": 0.4, "end": 0.55}
    wheel = disk("d", mass_kg=8.0, polar=0.09, diametral=0.05, at_m=0.55)
    law = {"kind": "polynomial", "argument_unit": "rpm", "argument_range": [0, 12000]}
    law |= {"stiffness_x": [1.0, -4e-5], "stiffness_y": [1.0, -5e-5]}
    held = {"stiffness_n_per_m": 2e7, "damping_n_s_per_m": 400.0, "speed_law": "soft"}
    response = {"kind": "unbalance_response", "observe": ["r.end"], "to_rpm": 12000}
    asked = scene(
        "apart",
        speeds_rpm=[0.0, 6000.0, 12000.0],
        branches=6,
        beams={"r": beam([*places.values()], 0.02, places, disks=[wheel])},
        bearings=[bearing("a", "r.a", **held), bearing("b", "r.b", **held)],
        speed_laws={"soft": law},
        analyses=[{**response, "speed_rpm": spin_rpm, "unbalances": [unbalance("r.end", 1e-5)]}],
    )
    results = run_scene(asked)
    names = {check.name for check in results.checks}
    assert {"response is that of the system", "no peak of the response is missing"} <= names
    assert not bad(results.checks)
    # what a response of the other kind would be is told apart
    outcome = results.analyses["unbalance_response"]
    assert outcome.document["exciters"][0]["peaks"]["r.end"]
    told = dataclasses.replace(outcome, document={**outcome.document, "spin_rpm": 3000.0})
    critical = [c.critical for c in results.critical_speeds]
    wrong = analysis_result_checks(results.system, critical, {"response": told})
    assert ("response", "response is that of the system") in bad(wrong)


@pytest.mark.verify
def test_a_rotor_held_at_one_end_misses_no_mode():
    """The stiffness of its rigid tilt is rounding, here just positive: it drowned all others.

    The numbers are those of one random rotor: with fewer digits the rounding is another one.
    """
    radii = {"inner_radius_m": 0.002680202960123763, "outer_radius_m": 0.0028042822044625285}
    places = {"a": 0.00149735862064161, "b": 0.023209058619944958}
    section = {"name": "s", "start_m": 0.0, "end_m": 0.024955977010693502, **radii}
    asked = scene(
        "once_held",
        model={"level": "harmonic", "accuracy": 0.0001607818219295574},
        speeds_rpm=np.linspace(0.0, 543879.402507857, 5),
        branches=8,
        bodies={"rotor": body(section, interfaces=places)},
        bearings=[bearing("a", "rotor.a", stiffness_n_per_m=5215856.731272889)],
    )
    assert not bad(run_scene(asked).checks)
