"""What a plan says: effects, bodies, analyses, what they cost, and why. Loads nothing of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from solidwhirl.core.errors import markdown_cell, markdown_text
from solidwhirl.core.warnings import Doubt
from solidwhirl.cost.analyses import AnalysisCost
from solidwhirl.cost.effects import EffectCost
from solidwhirl.cost.forecast import Forecast
from solidwhirl.cost.tables import forecast_rows, memory_text, seconds_text
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.resolution import Resolution
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S


class Costs(NamedTuple):
    """What a plan costs: the forecast, and what each effect adds, or saves as it is off."""

    expected: Forecast
    effects: Mapping[str, EffectCost]


def plan_text(plan: Plan, doubts: Iterable[Doubt] = (), costs: Costs | None = None) -> str:
    """The plan as Markdown tables, after warnings about the scene; `costs`: of its parts."""
    effects = _effects_table(plan, costs)
    bodies = table(
        "body | level | circumferential orders | interface motions | "
        "first element order | first corner size [mm] | expected error | matrices | "
        "factorisations | eigenproblems",
        (
            (
                name,
                b.level,
                ", ".join(str(n) for n in b.orders),
                " ".join(b.components),
                *_resolution(b.resolution),
                b.matrices,
                f"<= {b.factorisations}",
                f"<= {b.eigenproblems}",
            )
            for name, b in plan.bodies.items()
        ),
    )
    parts = [effects, bodies] if plan.bodies else [effects]
    if said := [f"- {markdown_text(doubt.message)}" for doubt in doubts]:
        parts.insert(0, "\n".join(["Warnings:", "", *said]))
    if plan.analyses:
        parts.append(_analyses_table(plan, costs))
    if plan.speeds_beyond:
        fastest = float(plan.speeds_rad_s.max()) * RPM_PER_RAD_S
        parts.append(
            f"Speeds above {fastest:.6g} rpm, where [speeds] ends; the bodies are made for these:"
        )
        rows = ((a.analysis, f"{a.speed_rpm:.6g}", a.source) for a in plan.speeds_beyond)
        parts.append(table("analysis | to [rpm] | which is", rows))
    return "\n\n".join(parts)


def _effects_table(plan: Plan, costs: Costs | None) -> str:
    """Effects, why they are on or off, and what they cost or save."""
    plain = [(e.name, "on" if e.on else "off", e.why, e.cost) for e in plan.effects]
    head = "effect |  | why | cost when on"
    if costs is None:
        return table(head, plain)
    rows = []
    for effect, row in zip(plan.effects, plain, strict=True):
        cost, saves = costs.effects.get(effect.name), "" if effect.on else "saves "
        rows.append((*row, "-" if cost is None else f"{saves}{_spent(cost)}"))
    return table(f"{head} | adds", rows)


def _spent(cost: EffectCost | AnalysisCost) -> str:
    return f"{seconds_text(cost.seconds)} s, {memory_text(cost.memory_gib)} GiB"


def _analyses_table(plan: Plan, costs: Costs | None) -> str:
    if costs is None:
        return table("analysis | kind", plan.analyses)
    rows = ((name, kind, _spent(costs.expected.analyses[name])) for name, kind in plan.analyses)
    return table("analysis | kind | adds", rows)


def cost_text(expected: Forecast) -> str:
    """The predicted cost as a Markdown table."""
    head, *rows = forecast_rows(expected)
    said = "Processor seconds of one core, with nothing kept from earlier runs."
    return f"{table(' | '.join(head), rows)}\n\n{said}"


def _resolution(found: Resolution | None) -> tuple[str, str, str]:
    """Element order, corner size and expected error to begin with; beams have none."""
    if found is None:
        return "-", "-", "-"
    corner = f"{1e3 * found.size.corner_size_m:.3g}"
    # of a given mesh nothing is expected
    expected = "-" if math.isnan(found.expected_error) else f"{found.expected_error:.1e}"
    return str(found.degree), corner, expected


def table(
    head: str, rows: Iterable[Iterable[Any]], cell: Callable[[str], str] = markdown_cell
) -> str:
    """Return a Markdown table whose titles stand with bars between them."""
    rule = "|" + "---|" * (head.count(" | ") + 1)
    lines = ("| " + " | ".join(cell(str(value)) for value in row) + " |" for row in rows)
    return "\n".join([f"| {head} |", rule, *lines])
