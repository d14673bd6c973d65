"""The report of a run: what was asked, computed, left out and why, and what came out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from solidwhirl.core.check_report import checks_text
from solidwhirl.core.errors import markdown_row, markdown_text
from solidwhirl.core.warnings import Doubt
from solidwhirl.cost.forecast import Forecast
from solidwhirl.estimates.documents import (
    coupling_effect,
    coupling_text,
    followed_by,
    materials_text,
)
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.resolution import Resolution
from solidwhirl.pipeline.run import Results
from solidwhirl.pipeline.verdict_text import answers
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.scene_checks.operating import critical_speeds_that_count


def report_text(results: Results, document: dict[str, Any]) -> str:
    """Markdown report of a run and the contents of its `results.json`."""
    parts = [
        f"# {markdown_text(results.scene.title or results.scene.name)}",
        _table(" | ", ((a.about, a.marked) for a in answers(document))),
        "\n".join(f"- **warning:** {markdown_text(message)}" for message in _warnings(document)),
        "## Critical speeds",
        _critical(critical_speeds_that_count(document)),
        "## Notes" if results.scene.notes else "",
        "\n".join(f"- {markdown_text(note)}" for note in results.scene.notes),
        "## What was computed, what was left out, and why",
        plan_text(results.plan),
        "## Bodies",
        _bodies(document["bodies"]),
        "## Assembled and solved" if results.bodies else "",
        _ledger(document["bodies"]),
        "## Accuracy",
        _accuracy(document),
        "## Frequencies",
        _branches(document["campbell"]),
        "## Other analyses" if results.analyses else "",
        _analyses(results),
        "## Checks",
        checks_text(results.checks),
        "## Cost",
        _cost(document),
    ]
    return "\n\n".join(p for p in parts if p) + "\n"


def _warnings(document: dict[str, Any]) -> list[str]:
    return [*(doubt["message"] for doubt in document["doubts"]), *document["bearing_notes"]]


def doubts_text(doubts: Iterable[Doubt]) -> str:
    """Warnings about a scene as Markdown; empty if there are none."""
    lines = [f"- {markdown_text(doubt.message)}" for doubt in doubts]
    return "\n".join(["Warnings:", "", *lines]) if lines else ""


def plan_text(plan: Plan, doubts: Iterable[Doubt] = ()) -> str:
    """The plan as Markdown tables, after warnings about the scene."""
    effects = _table(
        "effect |  | why | cost when on",
        ((e.name, "on" if e.on else "off", e.why, e.cost) for e in plan.effects),
    )
    bodies = _table(
        "body | level | circumferential orders | interface motions | "
        "first element order | first corner size [mm] | expected error | matrices | "
        "factorisations | eigenproblems",
        (
            (
                name,
                b.level,
                ", ".join(str(n) for n in b.orders),
                " ".join(b.components),
                *_fineness(b.resolution),
                b.matrices,
                f"<= {b.factorisations}",
                f"<= {b.eigenproblems}",
            )
            for name, b in plan.bodies.items()
        ),
    )
    parts = [effects, bodies] if plan.bodies else [effects]
    said = doubts_text(doubts)
    parts = [said, *parts] if said else parts
    if plan.analyses:
        parts.append(_table("analysis | kind", plan.analyses))
    if plan.speeds_beyond:
        fastest = float(plan.speeds_rad_s.max()) * RPM_PER_RAD_S
        parts.append(
            f"Speeds above {fastest:.6g} rpm, where [speeds] ends; the bodies are made for these:"
        )
        rows = ((a.analysis, f"{a.speed_rpm:.6g}", a.source) for a in plan.speeds_beyond)
        parts.append(_table("analysis | to [rpm] | which is", rows))
    return "\n\n".join(parts)


def cost_text(expected: Forecast) -> str:
    """The predicted cost as a Markdown table."""
    head, *rows = expected.rows()
    said = "Seconds of one core, without the other analyses, pictures and files."
    return f"{_table(' | '.join(head), rows)}\n\n{said}"


def _fineness(found: Resolution | None) -> tuple[str, str, str]:
    """Element order, corner size and expected error to begin with; beams have none."""
    if found is None:
        return "-", "-", "-"
    corner = f"{1e3 * found.size.corner_size_m:.3g}"
    # of a given mesh nothing is expected
    expected = "-" if math.isnan(found.expected_error) else f"{found.expected_error:.1e}"
    return str(found.degree), corner, expected


def _bodies(bodies: dict[str, Any]) -> str:
    return _table(
        "body | mass [kg] | centre of gravity [m] | polar inertia [kg m²] | "
        "diametral inertia [kg m²] | level | unknowns | reduced | "
        "hoop strain at top speed | first free lateral frequencies [Hz]",
        (
            (
                name,
                f"{b['mass_kg']:.5g}",
                f"{b['center_of_gravity_m'][2]:.5g}",
                f"{b['polar_inertia_kg_m2']:.5g}",
                "-"
                if b["diametral_inertia_kg_m2"] is None
                else f"{b['diametral_inertia_kg_m2']:.5g}",
                b["level"],
                b["full_dofs"],
                b["reduced_dofs"],
                f"{b['hoop_strain_at_top_speed']:.1e}" if "hoop_strain_at_top_speed" in b else "-",
                ", ".join(f"{f:.2f}" for f in _first_of_pairs(b)) or "-",
            )
            for name, b in bodies.items()
        ),
    )


def _first_of_pairs(body: dict[str, Any]) -> list[float]:
    """Three frequencies; those of a body of revolution come in pairs."""
    step = 1 if body["level"] == "imported" else 2
    return list(body["free_frequencies_hz"][: 3 * step : step])


def _ledger(bodies: dict[str, Any]) -> str:
    lines = []
    for name, b in bodies.items():
        for label, done in b.get("assembled", {}).items():  # beams and rigid bodies have none
            lines.append(f"- {name}, {label}: {', '.join(done)}; {', '.join(b['solved'][label])}")
    return "\n".join(lines)


def _critical(entries: Sequence[Mapping[str, Any]]) -> str:
    if not entries:
        return "None in the speed range."
    return _table(
        "speed [rpm] | frequency [Hz] | ± | whirl | AF | log decrement | excited by",
        (
            (
                f"{c['speed_rpm']:.1f}",
                f"{c['frequency_hz']:.3f}",
                _percent(c.get("frequency_error_estimate")),
                c["whirl"],
                "-" if c["amplification_factor"] is None else f"{c['amplification_factor']:.3g}",
                "-" if c["log_decrement"] is None else f"{c['log_decrement']:.4g}",
                ", ".join(c["excited_by"]),
            )
            for c in entries
        ),
    )


def _percent(relative: float | None) -> str:
    """A relative error as text."""
    return "-" if relative is None else f"{100.0 * relative:.1g} %"


def _accuracy(document: dict[str, Any]) -> str:
    """What was asked and got, by round and by part."""
    found = document["accuracy"]
    if found["largest_error_estimate"] is None and not found["rounds"]:
        return "The scene has the error estimates off; what its mesh rule expects is in the plan."
    met = {True: "met", False: "not met", None: "unknown"}[found["met"]]
    largest = found["largest_error_estimate"]
    said = "-" if largest is None else f"{largest:.1e}"
    lines = [f"Asked {found['asked']:.1e}, largest estimated relative error {said}: {met}."]
    parts = document["campbell"].get("error_parts", {})
    rows = [(part, _largest(values), _where(part)) for part, values in parts.items()]
    lines.append(_table("part | largest of the branches | ", rows))
    steps = [
        (
            k + 1,
            ", ".join(f"{n} {u}" for n, u in r["unknowns"].items()),
            ", ".join(f"{n} {m}" for n, m in r["modes"].items()),
            f"{r['largest_error_estimate']:.1e}",
            followed_by(found["rounds"], k) or "-",
        )
        for k, r in enumerate(found["rounds"])
    ]
    lines.append(_table("round | unknowns | modes | estimate | refined", steps))
    solids = [name for name, b in document["bodies"].items() if b["level"] == "solid"]
    if solids and steps:
        lines.append(
            f"The mesh of {', '.join(solids)} is compared with a finer one after the last round: "
            "it is in the largest estimate and not in those of the rounds."
        )
    effect = coupling_effect(document)
    if effect is not None:
        lines.append(f"- {coupling_text(effect)}")
    for name, names in found.get("bodies_of_several_materials", {}).items():
        lines.append(f"- {name} {materials_text(names)}")
    for name in found["bodies_without_estimate"]:
        lines.append(f"- {name}: carries no error estimate; nothing of it is in these numbers")
    for name in found.get("meshes_without_estimate", ()):
        lines.append(
            f"- {name}: the error of its mesh, which was given, is not known and not in these "
            "numbers; compare with a finer mesh"
        )
    return "\n\n".join(lines)


def _largest(values: Any) -> str:
    known = [v for row in values for v in row if v is not None]
    return f"{max(known):.1e}" if known else "-"


def _where(part: str) -> str:
    return "a choice of the model: not summed" if part == "interface_coupling" else ""


def _branches(diagram: dict[str, Any]) -> str:
    """Frequencies at the first, middle and last speed."""
    speeds = diagram["speed_rpm"]
    chosen = sorted({0, len(speeds) // 2, len(speeds) - 1})
    columns = [f"{speeds[k]:.0f} rpm [Hz]" for k in chosen]
    rows = []
    for b, branch in enumerate(diagram["frequency_hz"]):
        shown = ["-" if branch[k] is None else f"{branch[k]:.3f}" for k in chosen]
        rows.append((b + 1, *shown, diagram["whirl"][b][-1]))
    return _table(" | ".join(["branch", *columns, "whirl at the last"]), rows)


def _analyses(results: Results) -> str:
    """One line for each analysis, and its files."""
    if not results.analyses:
        return ""
    return _table(
        "analysis | kind | result | files",
        (
            (name, outcome.kind, outcome.headline, ", ".join(outcome.files))
            for name, outcome in results.analyses.items()
        ),
    )


def _cost(document: dict[str, Any]) -> str:
    lines = [f"- {name}: {spent:.2f} s" for name, spent in document["timings_s"].items()]
    kept = [name for name, origin in document.get("stages", {}).items() if origin == "kept"]
    if kept:
        lines.append(f"- kept from an earlier run: {', '.join(kept)}")
    lines.append(f"- peak memory: {document['peak_memory_gib']:.2f} GiB")
    predicted = document["predicted_cost"]
    lines.append(
        f"- predicted without the other analyses: {predicted['cpu_s']:.2g} s of one core, "
        f"{predicted['peak_memory_gib']:.2g} GiB"
    )
    return "\n".join(lines)


def _table(head: str, rows: Iterable[Iterable[Any]]) -> str:
    """A table whose titles stand with bars between them."""
    rule = "|" + "---|" * (head.count(" | ") + 1)
    return "\n".join([f"| {head} |", rule, *(markdown_row(row) for row in rows)])
