"""Section: what the scene says and asks for, and what was left out and why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from solidwhirl.page.frame.records import Block, Run, Section, Table, Text
from solidwhirl.scene.records import Scene


def section(run: Run) -> Section:
    """Notes and inputs of a run."""
    notes = run.results.scene.notes
    blocks: list[Block] = []
    if notes:
        listed = "\n".join(f"- {' '.join(note.split())}" for note in notes)
        blocks.append(Text(text=f"**Notes**\n\n{listed}"))
    asked = [*_questions(run.results.scene), *_sizes(run.document)]
    blocks += [Table(title="Inputs", head=("", ""), rows=asked), *_choices(run)]
    return Section(name="inputs", title="Notes and inputs", blocks=blocks)


def _questions(scene: Scene) -> Iterator[tuple[str, str]]:
    speeds, model = scene.speeds, scene.model
    if speeds.list_rpm is not None:
        asked = ", ".join(f"{v:g}" for v in speeds.list_rpm) + " rpm"
    else:
        asked = f"{speeds.from_rpm:g} to {speeds.to_rpm:g} rpm, {speeds.count} speeds"
    yield "Speeds of the reference shaft", asked
    ratios = [f"{name} {ratio:g}" for name, ratio in scene.speed_ratios().items()]
    yield "Speed ratios of the bodies", ", ".join(ratios)
    most = scene.campbell.frequency_max_hz
    branches = f"all below {most:g} Hz" if most else f"the lowest {scene.campbell.branches}"
    yield "Branches of the Campbell diagram", branches
    yield "Level of the bodies", model.level
    yield "Relative accuracy", f"{model.accuracy:g}, error estimates {model.estimates}"
    named = [a.label if a.label == a.kind else f"{a.label} ({a.kind})" for a in scene.analyses]
    yield "Analyses", ", ".join(named) or "none"


def _sizes(document: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    mass = sum(b["mass_kg"] for b in document["bodies"].values())
    yield "Bodies", f"{len(document['bodies'])}, together {mass:.5g} kg"
    seconds, memory = sum(document["timings_s"].values()), document["peak_memory_gib"]
    yield "Computed in", f"{seconds:.3g} s, {memory:.2g} GiB"


def _left_out(effects: Sequence[Mapping[str, Any]]) -> str:
    """Effects that were computed, and those that were not with the reason."""
    named = [(e["name"].replace("_", " "), e["on"], e["why"]) for e in effects]
    on = ", ".join(name for name, is_on, _ in named if is_on) or "nothing"
    off = "\n".join(f"- {name}: {why}" for name, is_on, why in named if not is_on)
    text = f"**What was computed, what was left out, and why**\n\nComputed: {on}."
    return f"{text} Left out:\n\n{off}" if off else text


def _choices(run: Run) -> Iterator[Block]:
    plan = run.document["plan"]
    yield Text(text=_left_out(plan["effects"]))
    yield Table(
        folded=f"Effects, why, and what they cost ({len(plan['effects'])})",
        head=("effect", "computed", "why", "cost when on"),
        rows=[(e["name"].replace("_", " "), e["on"], e["why"], e["cost"]) for e in plan["effects"]],
    )
    rows = []
    for name, body in plan["bodies"].items():
        size, expected = body["corner_size_m"], body["expected_relative_error"]
        rows.append(
            (
                name,
                body["level"],
                ", ".join(str(n) for n in body["circumferential_orders"]) or None,
                " ".join(body["interface_components"]),
                body["element_order"],
                None if size is None else f"{1e3 * size:.3g}",
                None if expected is None else f"{expected:.1e}",
            )
        )
    if rows:
        yield Table(
            title="Initial discretisation",
            head=(
                "body", "level", "circumferential orders", "interface DOFs",
                "element order", "corner size [mm]", "expected error",
            ),
            rows=rows,
            caption="Where error estimates are on, the mesh and the number of modes then follow "
            "the estimates, see the iterations under Accuracy and cost.",
        )  # fmt: skip
