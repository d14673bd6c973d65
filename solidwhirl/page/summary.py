"""Section: what was asked, what came out, and what was left out and why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from solidwhirl.check_report import failure_lines
from solidwhirl.estimate_documents import coupling_effect
from solidwhirl.operating import Operating, nearest
from solidwhirl.page.margins import margins_in_short
from solidwhirl.page.marks import whirl_text
from solidwhirl.page.operating import margin_text, operating_speeds
from solidwhirl.page.records import Block, Run, Section, Table, Text
from solidwhirl.page.traces import analyses_of_kind
from solidwhirl.rotordyn.bearing_notes import note_lines
from solidwhirl.scene import Scene

# Critical speeds that a reader in a hurry is shown.
_MOST = 12
# The choice of the coupling is named beside the estimate where it is worth so many times as much.
_MUCH, _ROUNDING = 2.0, 1e-6
_MET = {True: "met", False: "**not met**", None: "not known"}


def section(run: Run) -> Section:
    """Summary of a run.

    Parameters
    ----------
    run
        The run.
    """
    operating = operating_speeds(run.document, run.results.scene.speed_ratios())
    criticals = _critical_speeds(run.document["critical_speeds"], operating)
    blocks = [*_warnings(run), _key_numbers(run), criticals]
    notes = run.results.scene.notes
    if notes:
        listed = "\n".join(f"- {' '.join(note.split())}" for note in notes)
        blocks.append(Text(text=f"**What the scene says of itself**\n\n{listed}"))
    blocks += [*_asked(run), *_choices(run)]
    return Section(name="summary", title="Summary", blocks=tuple(b for b in blocks if b))


def _warnings(run: Run) -> Iterator[Block]:
    failed = failure_lines(run.results.checks)
    if failed:
        yield Text(text="\n".join(f"- {line}" for line in failed), kind="warning")
    doubts = [doubt["message"] for doubt in run.document.get("doubts", ())]
    doubts += note_lines(run.results.bearing_notes)
    if doubts:
        yield Text(text="\n".join(f"- {line}" for line in doubts), kind="warning")


def _key_numbers(run: Run) -> Table:
    """The lines that a reader in a hurry wants."""
    document = run.document
    found = document["accuracy"]
    largest = found["largest_error_estimate"]
    mass = sum(b["mass_kg"] for b in document["bodies"].values())
    speeds = document["campbell"]["speed_rpm"]
    said = "estimates are off"
    if largest is not None:
        said = f"{100 * largest:.2g} % ({_MET[found['met']]})"
    rows = [
        ("Bodies", f"{len(document['bodies'])}, together {mass:.5g} kg"),
        ("Speeds", f"{speeds[0]:g} to {speeds[-1]:g} rpm of the reference shaft"),
        ("Critical speeds in this range", str(len(document["critical_speeds"]))),
        *_margin_rows(document),
        ("Largest estimated error", f"{said}, asked {100 * found['asked']:.2g} %"),
        *_coupling_rows(document, largest),
        ("Checks", _checks_text(document["invariants"])),
        ("Other analyses", _listed(document["analyses"]) or "none"),
        (
            "Computed in",
            f"{sum(document['timings_s'].values()):.3g} s, {document['peak_memory_gib']:.2g} GiB",
        ),
    ]
    return Table(
        head=("at a glance", ""),
        rows=rows,
        caption="What the error estimate covers, and what it does not, is under Accuracy and cost.",
    )


def _margin_rows(document: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Separation margins, where operating speeds were given."""
    found = analyses_of_kind(document, "separation_margins")
    for name, entry in found.items():
        yield (
            "Separation margins" + (f" ({name})" if len(found) > 1 else ""),
            margins_in_short(entry),
        )


def _coupling_rows(document: Mapping[str, Any], largest: float | None) -> Iterator[tuple[str, str]]:
    """Choice of the coupling, where it is worth more than the estimated error."""
    effect = coupling_effect(document)
    if effect is not None and effect > _MUCH * max(largest or 0.0, _ROUNDING):
        yield (
            "Not in it: rigid or distributing interfaces",
            f"up to {100.0 * effect:.2g} %, a choice of the model, see Accuracy and cost",
        )


def _checks_text(checks: Sequence[Mapping[str, Any]]) -> str:
    passed = [c["passed"] for c in checks]
    said = [f"{passed.count(True)} hold"]
    if False in passed:
        said.insert(0, f"**{passed.count(False)} failed**")
    if None in passed:
        said.append(f"{passed.count(None)} can not be decided")
    return f"{len(passed)}: {', '.join(said)}"


def _listed(analyses: Mapping[str, Any]) -> str:
    return ", ".join(name.replace("_", " ") for name in analyses)


def _critical_speeds(found: Sequence[Mapping[str, Any]], operating: Sequence[Operating]) -> Block:
    if not found:
        return Text(text="**Critical speeds:** none in the speed range.")
    entries, said = nearest(found, operating, _MOST)
    head = ["speed [rpm]", "frequency [Hz]", "± [%]", "whirl", "log. decrement", "excited by"]
    rows = [
        [
            f"{c['speed_rpm']:.1f}",
            f"{c['frequency_hz']:.3f}",
            _percent(c.get("frequency_error_estimate")),
            whirl_text(c["whirl"]),
            c["log_decrement"],
            ", ".join(c["excited_by"]),
        ]
        for c in entries
    ]
    if operating:
        head.append("margin")
        for row, c in zip(rows, entries, strict=True):
            row.append(margin_text(c["speed_rpm"], c["excited_by"], operating))
        said += "Margins are from the operating speeds of the shaft that excites. "
    return Table(
        title="Critical speeds",
        head=head,
        rows=rows,
        caption=f"{said}Speeds of the reference shaft. ± is the estimated error of the "
        "discretisation, not that of the input. ● forward, □ backward, ◆ mixed whirl.",
    )


def _percent(relative: float | None) -> str | None:
    return None if relative is None else f"{100.0 * relative:.1g}"


def _asked(run: Run) -> Iterator[Block]:
    scene = run.results.scene
    yield Table(title="What was asked", head=("", ""), rows=[*_questions(scene)])


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
            title="How the bodies were modelled at first",
            head=(
                "body", "level", "circumferential orders", "interface motions",
                "element order", "corner size [mm]", "expected error",
            ),
            rows=rows,
            caption="Where error estimates are on, the mesh and the number of modes then follow "
            "the estimates, see the rounds under Accuracy and cost.",
        )  # fmt: skip
