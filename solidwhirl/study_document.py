"""A study as plain data and as a summary in Markdown."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from solidwhirl.machine import machine_speed
from solidwhirl.plain_data import plain_data
from solidwhirl.scene import Scene
from solidwhirl.scene_file import scene_hash
from solidwhirl.study_errors import matched_errors
from solidwhirl.study_runner import CaseOutcome
from solidwhirl.study_settings import StudyCase
from solidwhirl.study_table import ErrorPair, StudyRow, StudyTable
from solidwhirl.versions import package_versions

SCHEMA = "solidwhirl-study-1"


@dataclass(frozen=True, kw_only=True)
class Study:
    """A whole study.

    Attributes
    ----------
    scene
        The scene.
    quick
        Whether the small matrix was run.
    outcomes
        All cases, the reference first.
    table
        Errors, fronts and slopes.
    notes
        What a reader must know: levels that are missing, cases that were skipped.
    """

    scene: Scene
    quick: bool
    outcomes: tuple[CaseOutcome, ...]
    table: StudyTable
    notes: tuple[str, ...]


def series_name(series: tuple[str, int | None, str]) -> str:
    """Return "harmonic, order 3, graded"."""
    level, order, ladder = series
    if ladder == "profile":
        return level
    return ", ".join([level, *([f"order {order}"] if order else []), ladder])


def settings_text(case: StudyCase) -> str:
    """Return the settings of a case in one line."""
    return ", ".join(
        f"{key} = {value:.4g}" if isinstance(value, float) else f"{key} = {value}"
        for key, value in case.settings.items()
    )


def study_notes(outcomes: Sequence[CaseOutcome], table: StudyTable) -> tuple[str, ...]:
    """Return one sentence per case that is missing and per level that was left out."""
    notes = [f"{o.case.name}: {o.status}, {o.message}" for o in outcomes if o.status != "done"]
    beam = [o for o in outcomes if o.case.level == "beam"]
    if beam and not any(o.status == "done" for o in beam):
        notes.insert(0, f"Level beam is left out: {beam[0].message}")
    lost = [r.outcome.case.name for r in table.rows if r.campbell.unmatched]
    if lost:
        notes.append(
            f"Branches that are off by more than 25 % or missing, no error is given: "
            f"{', '.join(lost)}"
        )
    return tuple(notes)


def beam_maps(outcomes: Sequence[CaseOutcome]) -> list[dict[str, Any]]:
    """Return the maps: names of the axes and their points, row by row."""
    maps: dict[str, dict[str, Any]] = {}
    for outcome in outcomes:
        if outcome.case.group != "beam_map" or outcome.status != "done":
            continue
        row = outcome.case.payload
        own = maps.setdefault(
            row["map"],
            {"map": row["map"], "x_name": row["x_name"], "y_name": row["y_name"], "points": []},
        )
        own["points"] += outcome.result["points"]
    return list(maps.values())


def coupling_document(table: StudyTable) -> dict[str, Any] | None:
    """Return how much the coupling of the interfaces changes, None without both cases."""
    found = {
        r.outcome.case.settings["coupling"]: r
        for r in table.rows
        if r.outcome.case.group == "coupling" and r.outcome.status == "done"
    }
    if len(found) < 2:
        return None
    first, second = found["rigid"].outcome, found["distributing"].outcome
    apart = matched_errors(first.result["campbell"], second.result["campbell"])
    return {
        "interfaces": str(first.case.settings["interfaces"]).split(", "),
        "rigid_over_distributing_minus_1": apart.error.tolist(),
        "branches_without_partner": int((apart.partner < 0).sum()),
        "from_reference": {str(k): r.campbell.true for k, r in found.items()},
    }


def study_document(study: Study) -> dict[str, Any]:
    """Return everything that study.json holds; units are in the keys, absent values are null."""
    table = study.table
    document = {
        "schema": SCHEMA,
        "scene": {
            "name": study.scene.name,
            "title": study.scene.title,
            "sha256": scene_hash(study.scene),
        },
        "quick": study.quick,
        "machine": _machine(),
        "packages": package_versions(),
        "notes": list(study.notes),
        "reference": {
            "accuracy": study.outcomes[0].case.settings["accuracy"],
            "estimate": table.floor,
            "campbell": study.outcomes[0].result["campbell"],
            "critical_speeds": study.outcomes[0].result["critical_speeds"],
        },
        "cases": [_case(row) for row in table.rows],
        "pareto": {"error_cpu_s": table.time_front, "error_peak_memory": table.memory_front},
        "slopes": [
            {
                "level": s.series[0],
                "element_order": s.series[1],
                "ladder": s.series[2],
                "quantity": s.quantity,
                "over": "unknowns",
                **asdict(s.slope),
                "left_out": s.left_out,
                "cases": s.names,
            }
            for s in table.slopes
        ],
        "coupling": coupling_document(table),
        "beam_map": beam_maps(study.outcomes),
    }
    return plain_data(document)  # type: ignore[no-any-return]


def _machine() -> dict[str, Any]:
    speed = machine_speed()
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1024.0**3
    return {
        "system": platform.platform(),
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "memory_gib": memory,
        "gflops": speed.gflops,
        "gbytes_per_s": speed.gbytes_per_s,
    }


_MEASURED = (
    "unknowns",
    "coordinates",
    "rounds",
    "cpu_s",
    "startup_cpu_s",
    "stages_cpu_s",
    "peak_memory_gib",
    "startup_memory_gib",
    "with_estimates",
    "process_cpu_s",
    "wall_s",
    "bodies",
)


def _case(row: StudyRow) -> dict[str, Any]:
    case, result = row.outcome.case, row.outcome.result
    estimates = result.get("estimates") or {}
    return {
        "name": case.name,
        "group": case.group,
        "level": case.level,
        "element_order": case.order,
        "ladder": case.ladder,
        "settings": dict(case.settings),
        "status": row.outcome.status,
        "message": row.outcome.message,
        **{key: result.get(key) for key in _MEASURED},
        "campbell": _errors(row.campbell),
        "critical_speeds": _errors(row.critical_speeds),
        "estimated_parts": estimates.get("campbell_parts"),
    }


def _errors(pair: ErrorPair) -> dict[str, Any]:
    return {
        "relative_error": pair.true,
        "estimated_relative_error": pair.estimate,
        "effectivity": pair.effectivity,
        "least_effectivity": pair.least_effectivity,
        "without_partner": pair.unmatched,
    }


def summary(study: Study, document: Mapping[str, Any]) -> str:
    """Return the summary of a study in Markdown.

    Parameters
    ----------
    study
        The study.
    document
        From `study_document`.
    """
    table, machine = study.table, document["machine"]
    lines = [
        f"# Accuracy against cost: {study.scene.title or study.scene.name}",
        "",
        f"Errors are the largest of all branches and speeds, relative to the harmonic level at "
        f"accuracy {document['reference']['accuracy']:g}, whose own estimate is {table.floor:.1e}. "
        f"Time is processor time of the whole process, its start included, without error estimates "
        f"except for adaptive runs, which live by them. Machine: {machine['processor']}, "
        f"{machine['gflops']:.3g} GFLOP/s, {machine['gbytes_per_s']:.3g} GB/s on one core.",
        "",
        *(f"- {note}" for note in study.notes),
        "",
        "## Cases",
        "",
        *_case_lines(table),
        "",
        "Fronts: T, no case is both faster and more accurate; M, none needs both less memory and "
        "is more accurate. Effectivity: estimated over true error.",
        "",
        "## Slopes over the unknowns",
        "",
        *_slope_lines(table),
        *_coupling_lines(document["coupling"]),
        *_map_lines(document["beam_map"]),
    ]
    return "\n".join(lines) + "\n"


def _case_lines(table: StudyTable) -> list[str]:
    lines = [
        "| case | unknowns | CPU [s] | memory [GiB] | error | estimate | effectivity | "
        "critical speeds | fronts |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in table.rows:
        name = row.outcome.case.name
        if row.outcome.status != "done" or row.outcome.case.group == "coupling":
            continue
        fronts = "T" * (name in table.time_front) + "M" * (name in table.memory_front)
        cells = (
            name,
            f"{row.measured('unknowns'):.0f}",
            f"{row.measured('cpu_s'):.2f}",
            f"{row.measured('peak_memory_gib'):.3f}",
            "" if row.outcome.case.group == "reference" else _short(row.campbell.true),
            _short(row.campbell.estimate),
            _short(row.campbell.effectivity, ".2g"),
            "" if row.outcome.case.group == "reference" else _short(row.critical_speeds.true),
            fronts,
        )
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def _short(value: float, kind: str = ".1e") -> str:
    return format(value, kind) if math.isfinite(value) else ""


def _slope_lines(table: StudyTable) -> list[str]:
    if not table.slopes:
        return ["No series has three points or more that count.", ""]
    lines = ["| series | quantity | slope | ± | scatter [decades] | points | left out |"]
    lines.append("|---|---|---|---|---|---|---|")
    for s in table.slopes:
        cells = (
            series_name(s.series),
            s.quantity,
            f"{s.slope.slope:.2f}",
            f"{s.slope.standard_error:.2f}",
            f"{s.slope.scatter_log10:.2f}",
            str(s.slope.points),
            str(s.left_out),
        )
        lines.append("| " + " | ".join(cells) + " |")
    return [*lines, ""]


def _coupling_lines(found: Mapping[str, Any] | None) -> list[str]:
    if found is None:
        return []
    values = [
        abs(v) for row in found["rigid_over_distributing_minus_1"] for v in row if v is not None
    ]
    most = f"{max(values):.1e}" if values else "not comparable"
    return [
        "## Coupling of the interfaces",
        "",
        f"A choice of model, not an error: rigid instead of distributing coupling at "
        f"{', '.join(found['interfaces'])} changes the frequencies by {most} at most.",
        "",
    ]


def _map_lines(maps: Sequence[Mapping[str, Any]]) -> list[str]:
    lines = ["## Beams against solids", ""] if maps else []
    for found in maps:
        done = [p for p in found["points"] if p["status"] == "done"]
        good = {
            limit: sum((p["relative_error"] or math.inf) < limit for p in done)
            for limit in (0.01, 0.05)
        }
        lines.append(
            f"- {found['map']}: of {len(done)} points, {good[0.01]} are within 1 % and "
            f"{good[0.05]} within 5 % in the first two whirl pairs."
        )
    return [*lines, ""] if maps else []
