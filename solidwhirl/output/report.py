"""The report of a run: what was asked, computed, left out and why, and what came out."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from solidwhirl.core.check_report import checks_text
from solidwhirl.core.errors import markdown_cell, markdown_text
from solidwhirl.core.warnings import warnings_of
from solidwhirl.output.plan_text import plan_text, table
from solidwhirl.page.frame.records import Block, Table, Text
from solidwhirl.page.frame.render import cell_text
from solidwhirl.page.modes.criticals import critical_speed_tables
from solidwhirl.page.run.accuracy import accuracy_blocks
from solidwhirl.page.run.masses import properties_table, sizes_table
from solidwhirl.pipeline.run import Results
from solidwhirl.pipeline.verdict_text import answers

# Marks for bold and for code of the page, as they come out of `markdown_cell`.
_MARKS = re.compile(r"\\\*\\\*|\\`")


def report_text(results: Results, document: dict[str, Any]) -> str:
    """Markdown report of a run and the contents of its `results.json`."""
    critical = critical_speed_tables(document, results.scene.speed_ratios())
    parts = [
        f"# {markdown_text(results.scene.title or results.scene.name)}",
        table(" | ", ((a.about, a.marked) for a in answers(document)), _marked_cell),
        "\n".join(f"- **warning:** {markdown_text(message)}" for message in warnings_of(document)),
        "## Critical speeds",
        _told(critical) if critical else "None in the speed range.",
        "## Notes" if results.scene.notes else "",
        "\n".join(f"- {markdown_text(note)}" for note in results.scene.notes),
        "## What was computed, what was left out, and why",
        plan_text(results.plan),
        "## Bodies",
        _told([properties_table(document["bodies"]), sizes_table(document["bodies"])]),
        "## Assembled and solved" if results.bodies else "",
        _ledger(document["bodies"]),
        "## Accuracy",
        _told(accuracy_blocks(document)),
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


def _ledger(bodies: dict[str, Any]) -> str:
    lines = []
    for name, b in bodies.items():
        for label, done in b.get("assembled", {}).items():  # beams and rigid bodies have none
            lines.append(f"- {name}, {label}: {', '.join(done)}; {', '.join(b['solved'][label])}")
    return "\n".join(lines)


def _branches(diagram: dict[str, Any]) -> str:
    """Frequencies at the first, middle and last speed."""
    speeds = diagram["speed_rpm"]
    chosen = sorted({0, len(speeds) // 2, len(speeds) - 1})
    columns = [f"{speeds[k]:.0f} rpm [Hz]" for k in chosen]
    rows = []
    for b, branch in enumerate(diagram["frequency_hz"]):
        shown = ["-" if branch[k] is None else f"{branch[k]:.3f}" for k in chosen]
        rows.append((b + 1, *shown, diagram["whirl"][b][-1]))
    return table(" | ".join(["branch", *columns, "whirl at the last"]), rows)


def _analyses(results: Results) -> str:
    """One line for each analysis, and its files."""
    if not results.analyses:
        return ""
    return table(
        "analysis | kind | result | files",
        (
            (name, outcome.kind, outcome.headline, ", ".join(outcome.files))
            for name, outcome in results.analyses.items()
        ),
    )


def _cost(document: dict[str, Any]) -> str:
    of_engine, of_bodies = (document.get(k, {}) for k in ("dense_problems", "body_problems"))
    lines = []
    for name, spent in document["timings_s"].items():
        counts = [f"{n} {what}" for what, n in of_engine.get(name, {}).items()]
        counts += [f"{n} {what} of bodies" for what, n in of_bodies.get(name, {}).items()]
        lines.append(", ".join([f"- {name}: {spent:.2f} s", *counts]))
    kept = [name for name, origin in document.get("stages", {}).items() if origin == "kept"]
    if kept:
        lines.append(f"- kept from an earlier run: {', '.join(kept)}")
    lines.append(f"- peak memory: {document['peak_memory_gib']:.2f} GiB")
    predicted = document["predicted_cost"]
    lines.append(
        f"- predicted: {predicted['cpu_s']:.2g} s of one core, "
        f"{predicted['peak_memory_gib']:.2g} GiB"
    )
    return "\n".join(lines)


def _told(blocks: Iterable[Block]) -> str:
    """Texts and tables of the page."""
    parts = []
    for block in blocks:
        if isinstance(block, Text):
            parts.append(block.text)
        elif isinstance(block, Table):
            title = block.title or block.folded
            rows = [[cell_text(cell) for cell in row] for row in block.rows]
            shown = table(" | ".join(block.head), rows, _marked_cell)
            parts += [f"### {title}" if title else "", shown]
            parts.append(block.caption)
    return "\n\n".join(part for part in parts if part)


def _marked_cell(text: str) -> str:
    """A cell of the page, whose marks for bold and code are those of Markdown, for a table."""
    return _MARKS.sub(lambda found: found[0].replace("\\", ""), markdown_cell(text))
