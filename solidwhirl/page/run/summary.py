"""Section: the verdict, the drawing and the Campbell diagram at a glance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from solidwhirl.analyses.base import Operating
from solidwhirl.core.blocks import margin_words, warning
from solidwhirl.core.check_report import checks_line, failure_lines
from solidwhirl.core.warnings import warnings_of
from solidwhirl.page.drawing.engine import small_picture
from solidwhirl.page.frame.records import Row, Run, Section, Table, Text
from solidwhirl.page.modes.campbell import small_chart
from solidwhirl.page.modes.criticals import critical_speed_table
from solidwhirl.pipeline.verdict_text import answers
from solidwhirl.scene_checks.operating import excited_critical_speeds, margin_of, nearest

# Critical speeds that a reader in a hurry is shown.
_MOST = 12
# Height of the diagram on the first screen, pixels.
_HIGH = 580


def section(run: Run) -> Section:
    """Summary of a run: the first screen of its page, warnings, critical speeds."""
    chart = small_chart(run.results)
    # the diagram stands at the right of both others
    beside = () if chart is None else (replace(chart, height_px=_HIGH),)
    blocks = [
        *warning(failure_lines(run.results.checks)),
        Row(blocks=(verdict_table(run), *beside, small_picture(run))),
        *warning(warnings_of(run.document)),
        critical_speeds_block(
            excited_critical_speeds(run.document),
            run.results.operating,
            run.results.scene.speed_ratios(),
        ),
    ]
    return Section(name="summary", title="Summary", blocks=blocks)


def verdict_table(run: Run) -> Table:
    """Return the answers of the verdict, the checks, and how many warnings there are."""
    rows = [(a.about, a.marked) for a in answers(run.document)]
    rows.append(("Checks", checks_line(run.results.checks)))
    count = len(warnings_of(run.document))
    if count:
        rows.append(("Warnings", f"{count}, below the drawing"))
    return Table(head=("", ""), rows=rows)


def critical_speeds_block(
    found: Sequence[Mapping[str, Any]], operating: Sequence[Operating], ratios: Mapping[str, float]
) -> Table | Text:
    """Return the critical speeds nearest to operating speeds, with their margins.

    `found`: those that unbalance excites. `found`, `ratios`: as of `critical_speed_table`.
    """
    if not found:
        return Text(text="**Critical speeds:** none in the speed range that unbalance excites.")
    entries, said = nearest(found, operating, _MOST)
    table = critical_speed_table(entries, ratios)
    head, rows = [*table.head], [[*row] for row in table.rows]
    if operating:
        head.append("margin")
        for row, c in zip(rows, entries, strict=True):
            row.append(margin_text(c["speed_rpm"], c["shafts"], operating))
        said += "Margins are from the operating speeds of the shaft that excites. "
    return Table(
        title="Critical speeds",
        head=head,
        rows=rows,
        caption=f"{said}The error is that of the discretisation, not that of the input.",
    )


def margin_text(
    speed_rpm: float, shafts: Sequence[str], operating: Sequence[Operating]
) -> str | None:
    """Return the distance of `margin_of` in words; arguments as there."""
    found = margin_of(speed_rpm, shafts, operating)
    if found is None:
        return None
    margin, shaft = found
    return f"**inside** {shaft}" if margin == 0.0 else f"{margin_words(margin)} {shaft}"
