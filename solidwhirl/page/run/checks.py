"""Section: what must hold for bodies, system and modes, and whether it does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from solidwhirl.core.check_report import checks_line, failure_lines
from solidwhirl.page.frame.records import Block, Chart, Run, Section, Table, Text

_PER_CHECK = 24


def section(run: Run) -> Section | None:
    """Checks of the invariants.

    Parameters
    ----------
    run
        The run.
    """
    checks = run.document["invariants"]
    if not checks:
        return None
    failed = failure_lines(run.results.checks)
    undecided = [c for c in checks if c["passed"] is None]
    head = (
        f"**{len(checks)} checks: {checks_line(run.results.checks)}.** Each is a "
        "statement that holds for any rotor: symmetry of matrices, rigid motions without "
        "strain, energy and momentum, orthogonality of modes. What each means is in "
        "`docs/checks.md`."
    )
    blocks: list[Block] = [Text(text=head)]
    if failed:
        blocks.insert(0, Text(text="\n".join(f"- {line}" for line in failed), kind="warning"))
    near = _nearness_chart(checks)
    blocks += [near] if near else []
    blocks.append(_table(checks))
    if undecided:
        said = "\n".join(_by_reason(undecided))
        blocks.append(Text(text=f"Not applicable:\n\n{said}", kind="note"))
    return Section(name="checks", title="Checks", blocks=blocks)


def _by_reason(undecided: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """What was not decided, once for each reason."""
    for reason in dict.fromkeys(c["reason"] for c in undecided):
        same = [f"{c['name']} ({c['where']})" for c in undecided if c["reason"] == reason]
        yield f"- {reason}: {'; '.join(same)}"


def _worst(checks: Sequence[Mapping[str, Any]]) -> list[tuple[str, int, Mapping[str, Any]]]:
    """Name, number and the one nearest to its limit, of all that were decided."""
    found = []
    for name in dict.fromkeys(c["name"] for c in checks if c["passed"] is not None):
        same = [c for c in checks if c["name"] == name and c["passed"] is not None]
        found.append((name, len(same), max(same, key=_nearness)))
    return found


def _nearness(check: Mapping[str, Any]) -> float:
    value, limit = check["value"] or 0.0, check["limit"] or 0.0
    if not check["passed"]:
        return float("inf")
    return float(value / limit if limit > 0 else value - limit)


def _nearness_chart(checks: Sequence[Mapping[str, Any]]) -> Chart | None:
    """Worst value over its limit by check, on a logarithmic axis."""
    shown = [
        (name, float(c["value"]) / float(c["limit"]), c)
        for name, _, c in _worst(checks)
        if c["value"] and c["limit"] and c["value"] > 0.0 and c["limit"] > 0.0
    ][::-1]
    if not shown:
        return None
    good = np.array([bool(c["passed"]) for *_, c in shown])
    traces = []
    for passed, color, symbol, name in (
        (True, "@good", "circle", "holds"),
        (False, "@bad", "x", "fails"),
    ):
        mine = [(k, *entry) for k, entry in enumerate(shown) if good[k] == passed]
        if mine:
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "name": name,
                    "x": np.array([ratio for _, _, ratio, _ in mine]),
                    "y": np.array([float(k) for k, *_ in mine]),
                    "text": [
                        f"{label}<br>{c['where']}: {c['value']:.1e}, limit {c['limit']:.1e}"
                        for _, label, _, c in mine
                    ],
                    "hovertemplate": "%{text}<extra></extra>",
                    "marker": {"color": color, "symbol": symbol, "size": 10},
                }
            )
    lowest = min(ratio for _, ratio, _ in shown)
    return Chart(
        name="checks-nearness",
        title="How near each check is to its limit",
        caption="The largest value of each check over its limit; left of 1 it holds. Checks whose "
        "value is exactly 0 are in the table only.",
        alt=f"{len(shown)} checks, values over limits from {lowest:.0e} upwards; "
        f"{int((~good).sum())} are above 1.",
        traces=traces,
        layout={
            "xaxis": {"title": {"text": "value over limit [1]"}, "type": "log", "nticks": 6},
            "yaxis": {
                "title": {"text": ""},
                "ticks": "",
                "tickvals": np.arange(len(shown), dtype=float),
                "ticktext": [label for label, _, _ in shown],
                "range": [-0.7, len(shown) - 0.3],
            },
            "shapes": [
                {"type": "line", "x0": 1, "x1": 1, "yref": "paper", "y0": 0, "y1": 1,
                 "line": {"color": "@bad", "dash": "dash", "width": 1.5}}
            ],
            "showlegend": len(traces) > 1,
        },
        height_px=90 + _PER_CHECK * len(shown),
    )  # fmt: skip


def _table(checks: Sequence[Mapping[str, Any]]) -> Table:
    return Table(
        folded="All checks by name",
        head=("check", "number", "holds", "value", "limit", "nearest to its limit"),
        rows=[
            (name, count, c["passed"], _number(c["value"]), _number(c["limit"]), c["where"])
            for name, count, c in _worst(checks)
        ],
    )


def _number(value: float | None) -> str | None:
    return None if value is None else f"{value:.1e}" if value else "0"
