"""From the ledgers of bench/forecast.py to the coefficients of whole runs.

Non-negative least squares of relative errors; what takes less than a tenth of a second counts less.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import nnls

from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.machine import machine_speed
from solidwhirl.cost import run_coefficients as present
from solidwhirl.cost.analyses import field_size, reduced_s
from solidwhirl.cost.around import beam_models_tried, pictures, records
from solidwhirl.cost.coefficients import BASE_GIB
from solidwhirl.cost.engine import sizes_solved, stage_works, unit_counts
from solidwhirl.cost.forecast import Forecast, forecast
from solidwhirl.cost.machine import GROUPS, REFERENCE, kept_jobs_s, machine_name
from solidwhirl.cost.stand_in import SteppedPart, stand_in, stepped_parts
from solidwhirl.cost.work import Cost, body_kind, couplings_s, mesh_kind
from solidwhirl.geometry import Body

if TYPE_CHECKING:
    from forecast import Case

HEAD = '"""Coefficients of whole runs, written by `python bench/forecast.py --fit`."""'
#: What each coefficient is.
WORDS = {
    "MACHINE": "Where they were measured, on one core.",
    "GFLOPS": "Rates of `solidwhirl.core.machine` there [1e9/s].",
    "GBYTES_PER_S": "And of memory [1e9 bytes/s].",
    "JOBS_S": "Processor seconds of the standard jobs of `solidwhirl doctor --calibrate` there.",
    "START": "Seconds of imports; where beams are tried, of each body and each of its sections.",
    "SOLVERS_S": "Seconds of the imports of mesher and solvers.",
    "MESHES": "How often the laws of meshes count.",
    "BODIES": "Kind of body: seconds of each reduction beside its law, and times that law.",
    "ASYMMETRIC_MEMORY": "How often the law of memory counts for an asymmetric body.",
    "UNITS": "Seconds a + b (n/100)^2 + c (n/100)^3 of one, in an engine of n coordinates.",
    "COMPARED": "How often the laws count of bodies with either coupling of their interfaces.",
    "NODAL_DIAMETER": "A nodal diameter beside a circumferential order of its body.",
    "FIELDS": "Seconds of the fields of a state in a body: once, per 1e5 unknowns with 32 places "
    "around.",
    "FILES": "Seconds of the files: once, per 1e5 unknowns, per 1e6 numbers of records.",
    "PAGE": "Seconds of the page: once, per analysis, per 1e5 unknowns, per 1e6 record numbers, "
    "with fields.",
    "PICTURES": "Seconds of the pictures: once, and of each.",
}
#: Powers of the coordinates in the time of one problem, beside what each costs once.
POWERS = {
    "undamped": (0, 3),
    "eigenproblem.hermitian": (0, 3),
    "eigenproblem.damped": (0, 2),
    "eigenproblem.isotropic": (0, 2),
    "eigenproblem.asymmetric": (0, 2),
    "eigenproblem.periodic": (3,),
    "continued": (0, 2),
    "factorisation": (0, 2),
    "solve": (0, 2),
    "balance": (0,),
    "step": (0, 2),
    "check": (0, 2),
    "result": (0,),
}
_SHORT_S, _ROUNDS = 0.1, 20
#: Stages of the engine that every run has, and what they are timed as.
ENGINE = {
    "campbell": ("assembly", "campbell"),
    "critical_speeds": ("critical_speeds",),
    "error_estimate": ("error_estimate",),
    "checks": ("checks", "stability"),
}
# Analyses that reduce bodies again are of other laws.
BODIES_AGAIN = ("nodal_diameters", "recovery")

Row = tuple[Mapping[str, float], float]
Rows = list[Row]


def relative(rows: Rows) -> dict[str, float]:
    """Coefficients by name of the sums that are nearest to the times, in parts of these.

    Errors count in parts of the geometric mean of both, so that half and twice are as far off.
    """
    names = sorted({name for counts, _ in rows for name in counts})
    design = np.array([[counts.get(name, 0.0) for name in names] for counts, _ in rows])
    times = np.array([max(seconds, 0.0) for _, seconds in rows])
    # each column by its own scale: the solver stops at an absolute size
    scale = np.maximum(np.abs(design).max(axis=0), 1e-300)
    said = times
    for _ in range(_ROUNDS):
        weight = 1.0 / (np.sqrt(times * np.maximum(said, 0.1 * times)) + _SHORT_S)
        found, _ = nnls(weight[:, None] * design / scale, weight * times)
        said = design / scale @ found
    return dict(zip(names, (found / scale).tolist(), strict=True))


def start(case: Case) -> Row:
    """Imports, and beams that are tried."""
    drawn = {name: b for name, b in case.bodies.items() if isinstance(b, Body)}
    counts = {"once": 1.0}
    if models := beam_models_tried(case.scene, case.plan, drawn):
        sections = sum(len(body.sections) for body in drawn.values())
        counts |= {"body": float(models * len(drawn)), "section": float(models * sections)}
    return counts, case.start_s


@contextmanager
def laws_alone() -> Iterator[None]:
    """Forecast bodies by their laws as bench/scaling.py measured them, and nothing beside."""
    kept = dict(present.BODIES), present.MESHES
    present.BODIES.update(dict.fromkeys(present.BODIES, (0.0, 1.0)))
    present.MESHES = 1.0
    try:
        yield
    finally:
        present.BODIES.update(kept[0])
        present.MESHES = kept[1]


@cache
def laws_of(case: Case) -> Forecast:
    """Forecast of a run by the laws alone; once for each run, as its meshes take a while."""
    with laws_alone():
        return forecast(case.scene, case.plan, case.bodies, machine=REFERENCE)


def meshes(case: Case) -> Row:
    """Meshes of all rounds of all bodies of a run; the first one loads the mesher."""
    counts: dict[str, float] = defaultdict(float, {"solvers": 1.0})
    for _, cost in _reductions(case):
        counts["mesh"] += cost.seconds.get("meshing", 0.0)
    spent = case.spent()
    return counts, sum(sum(times) for (stage, _), times in spent.items() if stage == "meshing")


def bodies(case: Case) -> Row:
    """Reductions with their judgements, all rounds of all bodies; the first loads the solvers."""
    counts: dict[str, float] = defaultdict(float, {"solvers": 1.0})
    for kind, cost in _reductions(case):
        counts["once"] += 1.0
        counts[kind] += cost.total_s - cost.seconds.get("meshing", 0.0)
    return counts, case.truth()["bodies"] - meshes(case)[1]


def _reductions(case: Case) -> Iterator[tuple[str, Cost]]:
    """Kind and cost of every reduction, by the laws alone."""
    expected = laws_of(case)
    for one in filter(None, (expected.first, expected.last)):
        for name, cost in one.bodies.items():
            own = case.plan.bodies[name]
            if own.level != "beam":
                yield body_kind(mesh_kind(case.bodies[name], own), own), cost


def engine(case: Case) -> Rows:
    """Stages of the engine, and analyses, by what they have to solve."""
    size, took = size_of(case), case.ledger["timings_cpu_s"]
    estimated = case.scene.model.estimates == "on"
    works = stage_works(case.plan, size, estimated)
    rows: Rows = []
    for stage, timed in ENGINE.items():
        counts = _counted(works.get(stage, Work()), size)
        if estimated and stage == "error_estimate":
            compared = couplings_s(case.plan, case.scene, case.bodies, REFERENCE)
            counts["compared"] = compared / present.COMPARED
        rows.append((counts, sum(took.get(name, 0.0) for name in timed)))
    stepped = _stepped(case)
    for spec in case.scene.analyses:
        counts = _counted(spec.work(size), size)
        for part in stepped.get(spec.label, ()):
            for p in POWERS["step"]:
                power = part.steps * (part.coordinates / 100.0) ** p
                counts[f"step {p}"] = counts.get(f"step {p}", 0.0) + power
        if counts and spec.kind not in BODIES_AGAIN:
            rows.append((counts, took[f"analysis {spec.label}"] + _checked_s(case, spec.kind)))
    return rows


def _checked_s(case: Case, kind: str) -> float:
    """Seconds in which an analysis is checked by other means, all alike."""
    checked = ("unbalance_response", "stability")
    count = sum(spec.kind in checked for spec in case.scene.analyses)
    whole: float = case.ledger["timings_cpu_s"].get("checks of the analyses", 0.0)
    return whole / count if kind in checked else 0.0


def size_of(case: Case) -> EngineSize:
    """Size of the engine of a run, with the coordinates that it had."""
    expected = laws_of(case)
    told = (expected.last or expected.first).size
    n = case.ledger["coordinates"]
    parts = tuple(part * n / told.coordinates for part in told.parts)
    return told._replace(coordinates=n, parts=parts)


def _stepped(case: Case) -> dict[str, list[SteppedPart]]:
    """Parts that run-ups step, with the bodies as they are foreseen."""
    expected = laws_of(case)
    bodies = (expected.last or expected.first).bodies
    sizes = {name: cost.coordinates for name, cost in bodies.items()}
    engine = stand_in(case.scene, case.plan, case.bodies)
    return stepped_parts(case.scene, case.plan, engine, sizes)


def written(case: Case) -> dict[str, Row]:
    """Files, page, and pictures."""
    expected = laws_of(case)
    size = (expected.last or expected.first).whole.unknowns / 1e5
    analyses, count = float(len(case.scene.analyses)), float(pictures(case.scene, case.plan))
    ledger = case.ledger
    all_of = {"once": 1.0, "size": size, "record": records(case.scene)}
    return {
        "files": (all_of, ledger["files_cpu_s"]),
        "page": (
            {**all_of, "each": analyses, "fields": float(case.plan.on("recovery"))},
            ledger["page_cpu_s"],
        ),
        "pictures": ({"once": 1.0, "each": count}, ledger["pictures_cpu_s"]),
    }


def _counted(work: Work, size: EngineSize) -> dict[str, float]:
    """How often each power of the coordinates counts in work."""
    return {
        f"{name} {power}": count * sizes_solved(name, size)[power]
        for name, count in unit_counts(work, size).items()
        if count
        for power in POWERS[name]
    }


def fitted(cases: list[Case]) -> dict[str, Any]:
    """Coefficients by their names in `solidwhirl.cost.run_coefficients`, without the machine's."""
    of_start, body = relative([start(c) for c in cases]), relative([bodies(c) for c in cases])
    mesh = relative([meshes(c) for c in cases])
    of_bodies = {
        "MESHES": mesh["mesh"],
        "BODIES": {k: (body["once"], body.get(k, own[1])) for k, own in present.BODIES.items()},
    }
    with using(of_bodies):
        unit = relative([row for c in cases for row in engine(c)])
    rows = [written(c) for c in cases]
    files, page, drawn = (relative([r[what] for r in rows]) for what in rows[0])
    first = {
        "START": tuple(of_start.get(k, 0.0) for k in ("once", "body", "section")),
        "SOLVERS_S": body["solvers"] + mesh["solvers"],
        **of_bodies,
        "ASYMMETRIC_MEMORY": _memory(cases),
        "UNITS": {
            name: tuple(unit.get(f"{name} {p}", 0.0) for p in (0, 2, 3))
            if any(f"{name} {p}" in unit for p in powers)
            else present.UNITS[name]
            for name, powers in POWERS.items()
        },
        "COMPARED": unit.get("compared", present.COMPARED),
        "FILES": (files["once"], files["size"], files["record"]),
        "PAGE": (page["once"], page["each"], page["size"], page["record"], page["fields"]),
        "PICTURES": (drawn["once"], drawn["each"]),
    }
    with using(first):  # these are told from the cost of bodies
        again = [
            (c, forecast(c.scene, c.plan, c.bodies, machine=REFERENCE))
            for c in cases
            if {spec.kind for spec in c.scene.analyses} & {*BODIES_AGAIN}
        ]
        return {**first, "NODAL_DIAMETER": _nodal(again), "FIELDS": _fields(again)}


def _memory(cases: list[Case]) -> float:
    """Geometric mean of what runs with asymmetric bodies needed beside what their law says."""
    ratios = []
    for case in cases:
        if case.plan.on("asymmetry"):
            told = laws_of(case).peak_memory_gib - BASE_GIB
            needed = case.ledger["peak_memory_gib"] - BASE_GIB
            ratios.append(present.ASYMMETRIC_MEMORY * needed / told)
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else present.ASYMMETRIC_MEMORY


@contextmanager
def using(values: Mapping[str, Any]) -> Iterator[None]:
    """Forecast with other coefficients."""
    kept = {name: getattr(present, name) for name in values}
    for name, value in values.items():
        setattr(present, name, value)
    try:
        yield
    finally:
        for name, value in kept.items():
            setattr(present, name, value)


def write(values: Mapping[str, Any], path: Path) -> None:
    """Write the coefficients as the module that the program reads, with the machine's jobs."""
    speed, jobs = machine_speed(), kept_jobs_s() or present.JOBS_S
    own = {
        "MACHINE": machine_name(),
        "GFLOPS": speed.gflops,
        "GBYTES_PER_S": speed.gbytes_per_s,
        "JOBS_S": {group: jobs[group] for group in GROUPS},
    }
    lines = [HEAD, "", "from __future__ import annotations", ""]
    for name, value in {**own, **values}.items():
        lines += [f"#: {WORDS[name]}", f"{name}{_type(value)} = {_text(value)}"]
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _type(value: Any) -> str:
    if isinstance(value, dict):
        each = next(iter(value.values()))
        return f": dict[str, {_type(each)[2:] or 'float'}]"
    if isinstance(value, tuple):
        return f": tuple[{', '.join(['float'] * len(value))}]"
    return ""


def _text(value: Any) -> str:
    if isinstance(value, dict):
        rows = (f"    {json.dumps(name)}: {_text(each)}," for name, each in value.items())
        return "\n".join(["{", *rows, "}"])
    if isinstance(value, tuple):
        return f"({', '.join(_text(each) for each in value)})"
    return json.dumps(value) if isinstance(value, str) else f"{value:.4g}"


def _nodal(found: Iterable[tuple[Case, Forecast]]) -> float:
    """Of analyses of kind nodal_diameters, beside what the laws of bodies say."""
    rows = []
    for case, expected in found:
        spent = case.analyses()
        for spec in case.scene.analyses:
            if spec.kind == "nodal_diameters" and spec.label in spent:
                told = expected.analyses[spec.label].seconds / present.NODAL_DIAMETER
                rows.append(({"each": told}, spent[spec.label]))
    return relative(rows)["each"] if rows else present.NODAL_DIAMETER


def _fields(found: Iterable[tuple[Case, Forecast]]) -> tuple[float, float]:
    """Of analyses of kind recovery, beside the reduction that comes before."""
    rows = []
    for case, expected in found:
        bodies, spent = (expected.last or expected.first).bodies, case.analyses()
        for spec in case.scene.analyses:
            if spec.kind == "recovery" and spec.label in spent:
                states = float(sum(state.instants for state in spec.states))
                size = states * sum(field_size(bodies[n], spec.sectors) for n in spec.bodies)
                before = sum(reduced_s(bodies[name]) for name in spec.bodies)
                counts = {"once": states * len(spec.bodies), "size": size}
                rows.append((counts, spent[spec.label] - before))
    each = relative(rows) if rows else {}
    return (each["once"], each["size"]) if rows else present.FIELDS
