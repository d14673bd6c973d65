"""Section: what must hold for bodies, system and modes, and whether it does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from solidwhirl.core.blocks import warning
from solidwhirl.core.check_report import checks_line, failure_lines, nearest_to_limit
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Block, Run, Section, Table, Text
from solidwhirl.rotordyn.plots.chart import Axis, Chart, Curve, Look, Rule
from solidwhirl.rotordyn.superelement.invariants import Invariant

_PER_CHECK = 24


def section(run: Run) -> Section | None:
    """Return the checks of the invariants."""
    checks = run.results.checks
    if not checks:
        return None
    undecided = [c for c in checks if c.passed is None]
    blocks: list[Block] = [*warning(failure_lines(checks))]
    blocks.append(
        Text(
            text=f"**{len(checks)} checks: {checks_line(checks)}.** Each is a "
            "statement that holds for any rotor: symmetry of matrices, rigid motions without "
            "strain, energy and momentum, orthogonality of modes. What each means is in "
            "`docs/checks.md`."
        )
    )
    chart = checks_chart(checks)
    blocks += [page_chart(chart)] if chart else []
    blocks.append(_table(checks))
    if undecided:
        said = "\n".join(reasons(undecided))
        blocks.append(Text(text=f"Not applicable:\n\n{said}", kind="note"))
    return Section(name="checks", title="Checks", blocks=blocks)


def reasons(undecided: Sequence[Invariant]) -> Iterator[str]:
    """Say what was not decided, once for each reason."""
    for reason in dict.fromkeys(c.reason for c in undecided):
        same = [f"{c.name} ({c.where})" for c in undecided if c.reason == reason]
        yield f"- {reason}: {'; '.join(same)}"


def checks_chart(checks: Sequence[Invariant]) -> Chart | None:
    """Return the largest value of each check over its limit; None if all are exactly 0."""
    shown = [
        (c.value / c.limit, c)
        for _, c in nearest_to_limit(checks)
        if c.value and c.limit and c.value > 0.0 and c.limit > 0.0
    ]
    if not shown:
        return None
    curves = []
    for passed, look, name in (
        (True, Look("@good", "", "circle", 10.0), "holds"),
        (False, Look("@bad", "", "x", 10.0), "fails"),
    ):
        mine = [(k, ratio, c) for k, (ratio, c) in enumerate(shown) if bool(c.passed) == passed]
        texts = [f"{c.name}\n{c.where}: {c.value:.1e}, limit {c.limit:.1e}" for _, _, c in mine]
        x, y = np.array([row[1] for row in mine]), np.array([float(row[0]) for row in mine])
        curves += [Curve(x=x, y=y, name=name, look=look, texts=texts)] if mine else []
    lowest = min(ratio for ratio, _ in shown)
    failures = sum(not c.passed for _, c in shown)
    return Chart(
        name="checks-nearness",
        title="How near each check is to its limit",
        caption="The largest value of each check over its limit; left of 1 it holds. Checks whose "
        "value is exactly 0 are in the table only.",
        alt=f"{len(shown)} checks, values over limits from {lowest:.0e} upwards; "
        f"{failures} are above 1.",
        x=Axis(label="value over limit", unit="1", is_log=True, digits=".2g"),
        y=Axis(label="", places=[c.name for _, c in shown], low=len(shown) - 0.4, high=-0.6),
        parts=[*curves, Rule(at=1.0, look=Look("@bad", "dash", width=1.5))],
        has_legend=len(curves) > 1,
        height_px=90 + _PER_CHECK * len(shown),
    )


def _table(checks: Sequence[Invariant]) -> Table:
    return Table(
        folded="All checks by name",
        head=("check", "number", "holds", "value", "limit", "nearest to its limit"),
        rows=[
            (c.name, count, c.passed, _number(c.value), _number(c.limit), c.where)
            for count, c in nearest_to_limit(checks)
        ],
    )


def _number(value: float | None) -> str | None:
    if value is None or not np.isfinite(value):
        return None
    return f"{value:.1e}" if value else "0"
