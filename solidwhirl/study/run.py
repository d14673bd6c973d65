"""Error against cost: one scene with ladders of settings, each held against the same truth."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from solidwhirl.cache.files import StageStore
from solidwhirl.core.errors import UserError, clean, writing
from solidwhirl.core.machine import available_memory_gib
from solidwhirl.cost.machine import Machine, this_machine
from solidwhirl.cost.work import predict_cost
from solidwhirl.files.run_folder import refuse_foreign, refuse_occupied
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.scene_reading.reader import read_scene, scene_hash
from solidwhirl.study import report
from solidwhirl.study.cases import FULL, QUICK, Ladders, StudyCase, study_cases
from solidwhirl.study.measure import measured_apart
from solidwhirl.study.table import Outcome, study_table

Progress = Callable[[str], None]

# Part of the available memory that a case may be predicted to need.
_MEMORY_SHARE = 0.8
# Modes where nothing says how many; starting a process; iterations of an adaptive run.
_MODES, _START_S, _ITERATIONS = 12, 2.5, 2.0
# A process that takes this many times what was allowed or predicted is ended.
_PATIENCE = 15.0


class StudyError(UserError):
    """A study that can't be made."""


def study_command(
    scene_path: str | Path,
    out: str | Path,
    progress: Progress = lambda text: None,
    *,
    quick: bool = False,
    peers: str | Path | None = None,
) -> report.Study:
    """Measure error against processor time and memory over levels, orders, meshes and modes.

    Writes `study.json`, `study.md` and `study.png` into the folder.

    Results of finished cases are cached in the folder cases/: a study that was interrupted
    continues where it stopped. `progress` is called with one line per case, with the time to go;
    `quick` takes short ladders, under a minute for a small scene; `peers` is a JSON file of points
    of other programs (a list of `report.PeerPoint`) that are shown beside them.

    Raises SceneError: the scene can't be read; StudyError: there is no body with a profile, the
    points can't be read, or the reference fails; OutputError: the folder can't be written.
    """
    scene, out = read_scene(scene_path), Path(out)
    others = () if peers is None else read_peers(Path(peers))
    if not scene.bodies:
        raise StudyError("a study needs a body with a profile, [bodies.NAME]; the scene has none")
    refuse_occupied(out, (report.DOCUMENT, "cases"))
    refuse_foreign(out / report.DOCUMENT, '"schema": "solidwhirl-study-', "no study wrote it")
    ladders = QUICK if quick else FULL
    cases = study_cases(scene, ladders)  # a scene that is refused leaves no folder
    with writing(out):
        (out / "cases").mkdir(parents=True, exist_ok=True)
        outcomes = run_cases(cases, out / "cases", ladders, progress)
        progress("picture")
        study = report.Study(
            scene=scene, quick=quick, outcomes=outcomes, table=study_table(outcomes), peers=others
        )
        document = report.study_document(study)
        chart = report.study_chart(study)
        draw_charts([chart], out / report.PICTURE, chart.title)
        replace_text(out / report.REPORT, report.summary(study, document))
        replace_text(out / report.DOCUMENT, json.dumps(document, indent=1, allow_nan=False) + "\n")
    return study


def read_peers(path: Path) -> tuple[report.PeerPoint, ...]:
    """Read points of other programs.

    Raises StudyError: no file, no JSON, or other keys and values than `report.PeerPoint` has.
    """
    try:
        points = TypeAdapter(tuple[report.PeerPoint, ...]).validate_json(path.read_bytes())
    except OSError as error:
        raise StudyError(f"{path}: can not be read: {error.strerror}") from error
    except ValidationError as error:
        first = error.errors()[0]
        place = "".join(f"[{k}]" if isinstance(k, int) else f".{k}" for k in first["loc"])
        found = f"{clean(repr(first['input']), 80)} found; {clean(first['msg'])}"
        raise StudyError(f"{path}: {place or 'the list'}: {found}") from error
    return points


def run_cases(
    cases: Sequence[StudyCase], folder: Path, ladders: Ladders, progress: Progress
) -> tuple[Outcome, ...]:
    """Run the cases that have no result yet, the reference first, each in a process of its own.

    Results are cached in the folder; failed cases are run again.

    Raises StudyError: the reference fails: nothing can be held against it.
    """
    store = StageStore(folder)
    machine = this_machine()
    reference = _planned(cases[0], machine, ladders.longest_s)
    # what is held against a truth may take as long as the truth
    longest_s = max(reference.cpu_s, ladders.longest_s)
    planned = [reference] + [_planned(case, machine, longest_s) for case in cases[1:]]
    keys = [
        store.key("study", scene_hash(c.scene), c.estimates, c.ladder == "reference")
        for c in (plan.case for plan in planned)
    ]
    found = [store.find(key, progress) for key in keys]
    predicted = [
        0.0 if f is not None or _too_large(p) else p.cpu_s
        for f, p in zip(found, planned, strict=True)
    ]
    begun = time.perf_counter()
    outcomes: list[Outcome] = []
    for k, (plan, known) in enumerate(zip(planned, found, strict=True)):
        case, said = plan.case, f"case {k + 1} of {len(cases)}, {plan.case.name}"
        reason = "" if known is not None else _too_large(plan)
        if reason:
            progress(f"{said}: skipped, {reason}")
            outcomes.append(Outcome(case=case, status="skipped", message=reason))
            continue
        if known is None:
            progress(f"{said}; {_to_go(predicted, k, time.perf_counter() - begun)}")
            known = measured_apart(case, _PATIENCE * max(plan.cpu_s, plan.allowed_s))
        if isinstance(known, str):
            progress(f"{case.name} failed: {known}")
            outcomes.append(Outcome(case=case, status="failed", message=known))
        else:
            if found[k] is None:
                store.keep(keys[k], case.name, known, progress)
            outcomes.append(Outcome(case=case, status="done", measured=known))
        if outcomes[0].measured is None:
            raise StudyError(f"the reference can not be computed: {outcomes[0].message}")
    return tuple(outcomes)


@dataclass(frozen=True, kw_only=True)
class _Planned:
    """A case with its predicted cost, and the processor time that it may be predicted to take."""

    case: StudyCase
    allowed_s: float
    cpu_s: float
    memory_gib: float


def _planned(case: StudyCase, machine: Machine, allowed_s: float) -> _Planned:
    """Predict a case, adaptive runs from the a-priori mesh rule; without estimates if it must."""
    if case.level == "beam":
        return _Planned(case=case, allowed_s=allowed_s, cpu_s=_START_S, memory_gib=0.0)
    # without estimates the plan holds the mesh of the a-priori rule, not the first adaptive one
    model = case.scene.model.model_copy(update={"estimates": "off"})
    scene = case.scene.model_copy(update={"model": model})
    bodies = build_bodies(scene)
    plan = make_plan(scene, bodies)
    modes = dict.fromkeys(bodies, scene.model.modes or _MODES)
    plain, estimated = (
        predict_cost(plan, scene, bodies, modes=modes, estimates=e, machine=machine).whole
        for e in (False, True)
    )
    cost, memory = _START_S + plain.total_s + estimated.total_s, estimated.peak_memory_gib
    if case.estimates == "on":
        cost = _START_S + _ITERATIONS * estimated.total_s
    elif cost > allowed_s or memory > _MEMORY_SHARE * available_memory_gib():
        case = replace(case, estimates="off")
        cost, memory = _START_S + plain.total_s, plain.peak_memory_gib
    return _Planned(case=case, allowed_s=allowed_s, cpu_s=cost, memory_gib=memory)


def _too_large(plan: _Planned) -> str:
    """Why a case is skipped; the reference is always tried, as nothing goes without it."""
    if plan.case.ladder == "reference":
        return ""
    available = available_memory_gib()
    if plan.memory_gib > _MEMORY_SHARE * available:
        return (
            f"it would need about {plan.memory_gib:.3g} GiB, more than {_MEMORY_SHARE:.0%} of the "
            f"{available:.3g} that are available"
        )
    if plan.cpu_s > plan.allowed_s:
        return (
            f"it would take about {plan.cpu_s:.0f} s of processor time, more than the "
            f"{plan.allowed_s:.0f} allowed"
        )
    return ""


def _to_go(predicted_s: Sequence[float], number: int, spent_s: float) -> str:
    """Say how long the cases from a number on take, by how those before turned out."""
    done = sum(predicted_s[:number])
    seconds = (spent_s / done if done else 1.0) * sum(predicted_s[number:])
    amount = f"{seconds / 60.0:.0f} min" if seconds > 90.0 else f"{seconds:.0f} s"
    return f"about {amount} to go"
