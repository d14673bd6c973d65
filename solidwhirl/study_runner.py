"""Running the cases of a study one after the other, each in its own process, and keeping them."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from solidwhirl.bodies import build_bodies
from solidwhirl.cost import predict_cost
from solidwhirl.machine import MachineSpeed, available_memory_gib, machine_speed
from solidwhirl.plan import make_plan
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.scene_file import parse_scene
from solidwhirl.study_matrix import Matrix
from solidwhirl.study_measure import Progress, children_cpu_seconds
from solidwhirl.study_settings import CASE_SCHEMA, StudyCase

Status = Literal["done", "failed", "skipped"]

# Part of the available memory that a case may be predicted to need.
_MEMORY_SHARE = 0.8
# Modes where nothing says how many; starting a process; a map point; rounds of an adaptive run.
_MODES, _START_S, _POINT_S, _ROUNDS = 12, 2.5, 1.2, 2.0
# A process that takes this many times what is allowed by prediction is ended.
_PATIENCE = 15.0
# Bytes of a kept result; usual are a few thousand.
_LARGEST_RECORD = 100_000_000


class StudyError(ValueError):
    """A study that can't be made."""


@dataclass(frozen=True, kw_only=True)
class CaseOutcome:
    """What became of a case.

    Attributes
    ----------
    case
        The case.
    status
        "done", "failed" or "skipped".
    message
        Why, if it is not done.
    result
        Of `solidwhirl.study_case.run_case`; empty if it is not done.
    """

    case: StudyCase
    status: Status
    message: str = ""
    result: Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """What a case will take.

    Attributes
    ----------
    seconds
        Processor time.
    memory_gib
        Peak memory; 0 where it is not predicted.
    """

    seconds: float
    memory_gib: float


def run_cases(
    cases: Sequence[StudyCase], folder: Path, matrix: Matrix, progress: Progress
) -> tuple[CaseOutcome, ...]:
    """Run the cases that have no result yet, in their order.

    Parameters
    ----------
    cases
        The reference first.
    folder
        Where results are kept as `<key>.json`, and taken from. Failed cases are run again.
    matrix
        The longest times.
    progress
        Called with one line per case, with the time to go.

    Raises
    ------
    StudyError
        The reference fails: nothing can be held against it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    kept = {case.name: _kept(case, folder) for case in cases}
    machine = machine_speed()
    predictions = {c.name: predict(c, machine) for c in cases if kept[c.name] is None}
    clock = _TimeToGo({name: p.seconds for name, p in predictions.items()})
    done: list[CaseOutcome] = []
    for number, case in enumerate(cases, 1):
        result = kept[case.name]
        if result is not None:
            done.append(CaseOutcome(case=case, status="done", result=result))
            continue
        reason = _beams_missing(case, done) or _too_large(case, predictions[case.name], matrix)
        if reason:
            progress(f"case {number} of {len(cases)}, {case.name}: skipped, {reason}")
            done.append(CaseOutcome(case=case, status="skipped", message=reason, result={}))
        else:
            progress(f"case {number} of {len(cases)}, {case.name}; {clock.text()}")
            done.append(_run(case, folder, _PATIENCE * _allowed_s(case, matrix)))
            if done[-1].status == "failed":
                progress(f"{case.name} failed: {done[-1].message}")
        clock.finish(case.name, ran=not reason)
        if case.group == "reference" and done[-1].status != "done":
            raise StudyError(f"the reference can not be computed: {done[-1].message}")
    return tuple(done)


def predict(case: StudyCase, machine: MachineSpeed) -> Prediction:
    """Predict processor time and memory of a case; adaptive runs from the a-priori mesh rule.

    Parameters
    ----------
    case
        The case.
    machine
        From `solidwhirl.machine.machine_speed`.
    """
    if case.payload["kind"] == "map_row":
        return Prediction(seconds=_START_S + _POINT_S * len(case.payload["x"]), memory_gib=0.0)
    if case.level == "beam":
        return Prediction(seconds=_START_S, memory_gib=0.0)
    scene = parse_scene(case.payload["scene"])
    # without estimates the plan holds the mesh of the a-priori rule, not the first adaptive one
    model = scene.model.model_copy(update={"estimates": "off"})
    scene = scene.model_copy(update={"model": model})
    bodies = build_bodies(scene)
    plan = make_plan(scene, bodies)
    modes = dict.fromkeys(bodies, scene.model.modes or _MODES)
    apart = case.payload["phases"] == "apart"
    plain, estimated = (
        predict_cost(plan, scene, bodies, modes=modes, estimates=e, machine=machine).whole
        for e in (False, True)
    )
    seconds = plain.total_s + estimated.total_s if apart else _ROUNDS * estimated.total_s
    memory = max(plain.peak_memory_gib, estimated.peak_memory_gib)
    return Prediction(seconds=_START_S + seconds, memory_gib=memory)


class _TimeToGo:
    """Time to go, from predicted times and how they turned out so far."""

    def __init__(self, seconds: Mapping[str, float]) -> None:
        self._left = dict(seconds)
        self._predicted = self._spent = 0.0
        self._since = time.perf_counter()

    def finish(self, name: str, *, ran: bool) -> None:
        """Take a case off the list."""
        now = time.perf_counter()
        seconds = self._left.pop(name)
        if ran:
            self._predicted += seconds
            self._spent += now - self._since
        self._since = now

    def text(self) -> str:
        """Return "about 4 min to go"."""
        slowness = self._spent / self._predicted if self._predicted else 1.0
        seconds = slowness * sum(self._left.values())
        amount = f"{seconds / 60.0:.0f} min" if seconds > 90.0 else f"{seconds:.0f} s"
        return f"about {amount} to go"


def _kept(case: StudyCase, folder: Path) -> dict[str, Any] | None:
    """The result of an earlier run; None without one, or if the file is not what was written."""
    path = folder / f"{case.key}.json"
    try:
        if path.stat().st_size > _LARGEST_RECORD:
            return None
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(record, dict) or record.get("schema") != CASE_SCHEMA:
        return None
    result = record.get("result")
    if not isinstance(result, dict) or result.get("status") != "done":
        return None
    return result if record.get("sha256") == _digest(result) else None


def _digest(result: Mapping[str, Any]) -> str:
    """SHA-256 of a result, as it is written and read again."""
    return hashlib.sha256(json.dumps(result, sort_keys=True).encode()).hexdigest()


def _beams_missing(case: StudyCase, done: Sequence[CaseOutcome]) -> str:
    """Why a row of the map is not tried: beams failed in the scene and in all rows so far."""
    if case.group != "beam_map":
        return ""
    beam = [o for o in done if o.case.group == "beam"]
    points = [p for o in done if o.case.group == "beam_map" for p in o.result.get("points", ())]
    tried = [p for p in points if p["status"] != "absent"]
    if not tried or any(o.status == "done" for o in beam):
        return ""
    refused = all(p["status"] == "failed" and p["level"] == "beam" for p in tried)
    return f"no point had beams: {tried[0]['message']}" if refused else ""


def _allowed_s(case: StudyCase, matrix: Matrix) -> float:
    if case.level == "solid":
        return matrix.solid_longest_s
    return matrix.longest_s


def _too_large(case: StudyCase, predicted: Prediction, matrix: Matrix) -> str:
    """Why a case is skipped; the reference is always tried, as nothing goes without it."""
    if case.group == "reference":
        return ""
    available = available_memory_gib()
    if predicted.memory_gib > _MEMORY_SHARE * available:
        return (
            f"it would need about {predicted.memory_gib:.3g} GiB, more than {_MEMORY_SHARE:.0%} "
            f"of the {available:.3g} that are available"
        )
    allowed = _allowed_s(case, matrix)
    if predicted.seconds > allowed:
        return (
            f"it would take about {predicted.seconds:.0f} s of processor time, more than the "
            f"{allowed:g} allowed"
        )
    return ""


def _run(case: StudyCase, folder: Path, patience_s: float) -> CaseOutcome:
    """Run a case in a process of its own and keep its result."""
    before = children_cpu_seconds()
    with tempfile.TemporaryDirectory(prefix=".running-", dir=folder) as scratch:
        asked, answer = Path(scratch) / "case.json", Path(scratch) / "result.json"
        asked.write_text(json.dumps(case.payload), encoding="utf-8")
        message = _process(asked, answer, patience_s)
        result = json.loads(answer.read_text(encoding="utf-8")) if not message else {}
    result = {"status": "failed", "message": message} if message else result
    result["process_cpu_s"] = children_cpu_seconds() - before
    about = {"name": case.name, "settings": dict(case.settings), "group": case.group}
    record = {"schema": CASE_SCHEMA, "case": about, "sha256": _digest(result), "result": result}
    with replacing(folder / f"{case.key}.json") as temporary:
        temporary.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    if result["status"] != "done":
        return CaseOutcome(case=case, status="failed", message=result["message"], result={})
    return CaseOutcome(case=case, status="done", result=result)


def _process(asked: Path, answer: Path, patience_s: float) -> str:
    """Start the process and wait; what went wrong, or nothing."""
    command = [sys.executable, "-m", "solidwhirl.study_case", str(asked), str(answer)]
    one_thread = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command,
            env={**os.environ, **one_thread},
            capture_output=True,
            text=True,
            timeout=patience_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"ended after {patience_s:.0f} s"
    if done.returncode < 0:
        return f"ended by signal {-done.returncode}" + (
            ", which is how a system ends programs when memory runs out"
            if done.returncode == -9
            else ""
        )
    if done.returncode > 0 or not answer.is_file():
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        return lines[-1].strip() if lines else f"ended with code {done.returncode}"
    return ""
