"""Running cases: what is kept, what goes on after a failure, what is not tried."""

from __future__ import annotations

import json

import pytest

from solidwhirl import study_runner
from solidwhirl.cost import REFERENCE_MACHINE
from solidwhirl.scene_file import parse_scene
from solidwhirl.study_matrix import FULL, QUICK
from solidwhirl.study_measure import StageClock, peak_memory_gib
from solidwhirl.study_runner import StudyError, run_cases
from solidwhirl.study_settings import case_scene, study_cases

NO_MAP = ("reference", "mesh", "dial", "modes", "beam", "coupling")


@pytest.fixture
def cases(small_scene):
    """The quick cases of the small scene without the map."""
    found = study_cases(parse_scene(small_scene()), QUICK)
    return [c for c in found if c.group in NO_MAP]


@pytest.fixture
def process(monkeypatch):
    """Stand-in for the process of a case: what it was asked, and what it says by name."""
    asked, said = [], {}

    def run(path, answer, patience_s):
        payload = json.loads(path.read_text(encoding="utf-8"))
        asked.append(payload)
        message = said.get(len(asked), "")
        if isinstance(message, BaseException):
            raise message
        if not message:
            answer.write_text(json.dumps({"status": "done", "cpu_s": 1.0}), encoding="utf-8")
        return message

    monkeypatch.setattr(study_runner, "_process", run)
    return asked, said


def test_results_are_kept(cases, process, tmp_path):
    asked, _ = process
    first = run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert asked == [c.payload for c in cases]
    second = run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert len(asked) == len(cases)
    assert [o.status for o in second] == ["done"] * len(cases)
    assert [o.result for o in second] == [o.result for o in first]


def test_broken_off_study_goes_on(cases, process, tmp_path):
    asked, said = process
    said[3] = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert len(list(tmp_path.glob("*.json"))) == 2
    assert not list(tmp_path.glob(".*"))
    run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert len(asked) == 3 + len(cases) - 2


def test_failed_case_is_recorded_and_tried_again(cases, process, tmp_path):
    asked, said = process
    said[2] = "the disk fell off"
    lines = []
    found = run_cases(cases, tmp_path, QUICK, lines.append)
    assert [o.status for o in found] == ["done", "failed"] + ["done"] * (len(cases) - 2)
    assert found[1].message == "the disk fell off"
    assert f"{cases[1].name} failed: the disk fell off" in lines
    record = json.loads((tmp_path / f"{cases[1].key}.json").read_text(encoding="utf-8"))
    assert record["result"]["message"] == "the disk fell off"
    assert record["case"]["name"] == cases[1].name
    again = run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert len(asked) == len(cases) + 1
    assert again[1].status == "done"


def test_without_the_reference_there_is_no_study(cases, process, tmp_path):
    process[1][1] = "no such thing"
    with pytest.raises(StudyError, match="reference can not be computed: no such thing"):
        run_cases(cases, tmp_path, QUICK, lambda text: None)


def test_half_a_file_is_no_result(cases, process, tmp_path):
    asked, _ = process
    (tmp_path / f"{cases[0].key}.json").write_text('{"schema": "sol', encoding="utf-8")
    run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert len(asked) == len(cases)


def memory_of(case):
    return study_runner.predict(case, REFERENCE_MACHINE).memory_gib


def test_too_large_cases_are_skipped_and_said(small_scene, process, tmp_path, monkeypatch):
    scene = parse_scene(small_scene())
    cases = [c for c in study_cases(scene, FULL) if c.group in NO_MAP]
    solid = max((c for c in cases if c.level == "solid"), key=memory_of)
    # a little less than what the largest one of the solids may have
    available = 0.99 / 0.8 * memory_of(solid)
    monkeypatch.setattr(study_runner, "available_memory_gib", lambda: available)
    lines = []
    found = run_cases(cases, tmp_path, FULL, lines.append)
    skipped = [o for o in found if o.status == "skipped"]
    assert solid.name in [o.case.name for o in skipped]
    assert found[0].status == "done"
    for o in skipped:
        assert "GiB" in o.message or "s of processor time" in o.message
        assert any(o.case.name in line and "skipped" in line for line in lines)


def test_keys_tell_cases_apart(small_scene):
    scene = parse_scene(small_scene())
    cases = study_cases(scene, FULL)
    assert len({c.key for c in cases}) == len(cases) == len({c.name for c in cases})
    again = study_cases(parse_scene(small_scene()), FULL)
    assert [c.key for c in again] == [c.key for c in cases]
    stiffer = study_cases(parse_scene(small_scene(bearing={"stiffness_n_per_m": 2e7})), FULL)
    pairs = zip(cases, stiffer, strict=True)
    assert all((a.key == b.key) == (a.group == "beam_map") for a, b in pairs)


def test_versions_are_in_the_key(cases, monkeypatch):
    before = cases[0].key
    with monkeypatch.context() as changed:
        changed.setattr("solidwhirl.study_settings.package_versions", lambda: {"numpy": "99"})
        assert cases[0].key != before
    monkeypatch.setattr("solidwhirl.study_settings.program_digest", lambda: "other sources")
    assert cases[0].key != before


def test_case_scenes_are_scenes(small_scene):
    """What a process reads back is the scene that was meant, settings of bodies out of the way."""
    scene = parse_scene(small_scene(body={"modes": 7}))
    for case in study_cases(scene, FULL):
        if case.payload["kind"] != "run":
            continue
        read = parse_scene(json.loads(json.dumps(case.payload["scene"])))
        assert read.bodies["rotor"].modes is None
        assert read.model.level == case.level
        assert read.model.order == case.order
        assert read.speeds == scene.speeds
        assert read.model.modes == case.settings.get("modes")
        assert read.model.compare_coupling == "off"


def test_both_couplings_are_set_where_joints_act(small_scene):
    scene = parse_scene(small_scene())
    found = {c.name: c.payload["scene"] for c in study_cases(scene, FULL) if c.group == "coupling"}
    for coupling in ("distributing", "rigid"):
        interfaces = found[f"coupling {coupling}"]["bodies"]["rotor"]["interfaces"]
        assert {i["coupling"] for i in interfaces} == {coupling}


def test_case_that_can_not_be_run_tells_why(small_scene, cases, tmp_path):
    """A real process: an interface beyond the end of the shaft."""
    data = small_scene()
    data["bodies"]["rotor"]["interfaces"][1]["at_m"] = 0.9
    scene = case_scene(parse_scene(data), level="harmonic")
    payload = {**cases[0].payload, "scene": scene.model_dump(mode="json", exclude_unset=True)}
    asked, answer = tmp_path / "case.json", tmp_path / "result.json"
    asked.write_text(json.dumps(payload), encoding="utf-8")
    assert study_runner._process(asked, answer, 100.0) == ""
    result = json.loads(answer.read_text(encoding="utf-8"))
    assert result["status"] == "failed"
    assert "interface 'right'" in result["message"]


def test_process_that_breaks_tells_its_last_line(tmp_path):
    asked = tmp_path / "case.json"
    asked.write_text('{"kind": "run"}', encoding="utf-8")
    assert study_runner._process(asked, tmp_path / "none", 100.0) == "KeyError: 'scene'"


def test_process_that_takes_too_long_is_ended(cases, tmp_path):
    asked = tmp_path / "case.json"
    asked.write_text(json.dumps(cases[0].payload), encoding="utf-8")
    assert study_runner._process(asked, tmp_path / "none", 0.05) == "ended after 0 s"


def test_stages_are_told_apart_by_what_is_said():
    heard = []
    clock = StageClock(heard.append)
    clock.say("mesh rotor (harmonic)")
    sum(k * k for k in range(300_000))  # some hundredths of a second
    clock.say("Campbell diagram at 3 speeds")
    clock.stop()
    assert heard == ["mesh rotor (harmonic)", "Campbell diagram at 3 speeds"]
    assert clock.seconds["meshing"] > 1e-3
    assert clock.seconds["meshing"] > clock.seconds["campbell"]


def test_peak_memory_is_read_from_the_kernel(tmp_path):
    status = tmp_path / "status"
    status.write_text("Name:\tx\nVmHWM:\t  2097152 kB\nVmRSS:\t 10 kB\n", encoding="ascii")
    assert peak_memory_gib(status) == 2.0
    assert 0.0 < peak_memory_gib(tmp_path / "none") < 100.0
