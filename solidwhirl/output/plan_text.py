"""What a plan says: effects, bodies, analyses, what they cost, and why. Loads nothing of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from solidwhirl.core.blocks import Part, Table
from solidwhirl.core.errors import markdown_cell, markdown_text
from solidwhirl.cost.analyses import AnalysisCost
from solidwhirl.cost.effects import EffectCost
from solidwhirl.cost.forecast import Forecast
from solidwhirl.cost.tables import forecast_rows, memory_text, seconds_text
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.resolution import Resolution
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.scene.records import ACCURACY_WITH_FEATURES, Scene


class Costs(NamedTuple):
    """What a plan costs: the forecast, and what each effect adds, or saves as it is off."""

    expected: Forecast
    effects: Mapping[str, EffectCost]


def brief_parts(plan: Plan, expected: Forecast) -> list[Part]:
    """What is computed and left out, on which level, and how long all of it takes."""
    parts: list[Part] = [
        Table(
            head=("effect", "", "why"),
            rows=[(e.name, "on" if e.on else "off", e.why) for e in plan.effects],
        )
    ]
    if plan.bodies:
        rows = [(name, b.level, _resolution(b.resolution)[-1]) for name, b in plan.bodies.items()]
        parts.append(Table(head=("body", "level", "expected error"), rows=rows))
    if plan.analyses:
        parts.append(_analyses_table(plan, None))
    parts += _speeds_beyond(plan)
    seconds, memory = seconds_text(expected.seconds), memory_text(expected.peak_memory_gib)
    took = f"About {seconds} s of one core and {memory} GiB; --costs says of what."
    return [*parts, took]


def plan_parts(plan: Plan, costs: Costs | None = None) -> list[Part]:
    """The plan as tables; `costs`: of its parts."""
    parts: list[Part] = [_effects_table(plan, costs)]
    if plan.bodies:
        parts.append(_bodies_table(plan))
    if plan.analyses:
        parts.append(_analyses_table(plan, costs))
    return [*parts, *_speeds_beyond(plan)]


def accuracy_text(scene: Scene) -> str:
    """The accuracy that a scene asks for, or that it has by default."""
    asked = scene.model.accuracy
    if asked == ACCURACY_WITH_FEATURES and any(b.has_features for b in scene.bodies.values()):
        return f"{asked:g}, the default with blades, holes, slots and the like"
    return f"{asked:g}"


def _speeds_beyond(plan: Plan) -> list[Part]:
    if not plan.speeds_beyond:
        return []
    fastest = float(plan.speeds_rad_s.max()) * RPM_PER_RAD_S
    rows = [(a.analysis, f"{a.speed_rpm:.6g}", a.source) for a in plan.speeds_beyond]
    return [
        f"Speeds above {fastest:.6g} rpm, where [speeds] ends; the bodies are made for these:",
        Table(head=("analysis", "to [rpm]", "which is"), rows=rows),
    ]


def plan_text(plan: Plan) -> str:
    """The plan as Markdown."""
    return "\n\n".join(map(_markdown, plan_parts(plan)))


def _markdown(part: Part) -> str:
    if isinstance(part, Table):
        return table(" | ".join(part.head), part.rows)
    if isinstance(part, str):
        return part
    return "\n".join(f"- {markdown_text(line)}" for line in part)


def _bodies_table(plan: Plan) -> Table:
    head = (
        *("body", "level", "circumferential orders", "interface motions", "first element order"),
        *("first corner size [mm]", "expected error", "matrices", "factorisations"),
        "eigenproblems",
    )
    rows = [
        (
            name,
            b.level,
            ", ".join(str(n) for n in b.orders),
            " ".join(b.components),
            *_resolution(b.resolution),
            str(b.matrices),
            f"<= {b.factorisations}",
            f"<= {b.eigenproblems}",
        )
        for name, b in plan.bodies.items()
    ]
    return Table(head=head, rows=rows)


def _effects_table(plan: Plan, costs: Costs | None) -> Table:
    """Effects, why they are on or off, and what they cost or save."""
    plain = [(e.name, "on" if e.on else "off", e.why, e.cost) for e in plan.effects]
    head = ("effect", "", "why", "cost when on")
    if costs is None:
        return Table(head=head, rows=plain)
    rows = []
    for effect, row in zip(plan.effects, plain, strict=True):
        cost, saves = costs.effects.get(effect.name), "" if effect.on else "saves "
        rows.append((*row, "-" if cost is None else f"{saves}{_spent(cost)}"))
    return Table(head=(*head, "adds"), rows=rows)


def _spent(cost: EffectCost | AnalysisCost) -> str:
    return f"{seconds_text(cost.seconds)} s, {memory_text(cost.memory_gib)} GiB"


def _analyses_table(plan: Plan, costs: Costs | None) -> Table:
    if costs is None:
        return Table(head=("analysis", "kind"), rows=plan.analyses)
    rows = [(name, kind, _spent(costs.expected.analyses[name])) for name, kind in plan.analyses]
    return Table(head=("analysis", "kind", "adds"), rows=rows)


def cost_parts(expected: Forecast) -> list[Part]:
    """The predicted cost."""
    head, *rows = forecast_rows(expected)
    said = "Processor seconds of one core, with nothing kept from earlier runs."
    return [Table(head=head, rows=rows), said]


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
