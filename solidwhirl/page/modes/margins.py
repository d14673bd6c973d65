"""Separation margins of a page: critical speeds beside the operating speeds of each shaft."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

from solidwhirl.page.frame.marks import whirl_text
from solidwhirl.page.frame.operating import margin_words
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Table, Text
from solidwhirl.page.frame.traces import numbers
from solidwhirl.rotordyn.plots import chart as charts

# Margins that are drawn beside an operating range.
_MARGIN = 0.15
# Rows of a table that is shown whole.
_MOST = 12
_VERDICTS = ("verdict_api_617", "verdict_15_percent", "verdict_20_percent")


def margin_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return verdict, chart and table of the separation margins of one analysis.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    rows, verdict = entry["margins"], entry["verdict"]
    word = "Pass" if verdict["passed"] else "FAIL"
    kind: Literal["plain", "warning"] = "plain" if verdict["passed"] else "warning"
    blocks: list[Any] = [
        Text(text=f"**{word} by {method_name(verdict)}** (`{name}`): {verdict['why']}.", kind=kind)
    ]
    if rows:
        table = _margin_table(rows, f"Separation margins ({name})")
        if len(rows) > _MOST:
            table = replace(table, title="", folded=f"Separation margins ({name}, {len(rows)})")
        blocks += [page_chart(margin_chart(entry), name), table]
    damped = entry["critically_damped"]
    if damped:
        blocks.append(
            Table(
                folded=f"Critically damped, without margins ({name}, {len(damped)})",
                head=["shaft", "speed [rpm]", "whirl", "amplification factor [1]"],
                rows=[
                    [
                        m["shaft"],
                        f"{m['critical_speed_rpm']:.1f}",
                        whirl_text(m["whirl"]),
                        m["amplification_factor"],
                    ]
                    for m in damped
                ],
            )
        )
    return blocks


def method_name(verdict: Mapping[str, Any]) -> str:
    """Return the method of a verdict in words.

    Parameters
    ----------
    verdict
        `verdict` of a separation margin analysis in `results.json`.
    """
    if verdict["method"] == "api617":
        return "API 617"
    return f"a margin of {verdict['percent']:g} %"


def _margin_table(rows: Sequence[Mapping[str, Any]], title: str) -> Table:
    return Table(
        title=title,
        head=[
            *("shaft", "critical speed [rpm]", "whirl", "excited by unbalance"),
            *("amplification factor [1]", "margin", "asked [%]"),
            *("API 617", "15 %", "20 %"),
        ],
        rows=[
            [
                m["shaft"],
                f"{m['critical_speed_rpm']:.1f}",
                whirl_text(m["whirl"]),
                m["excited"],
                m["amplification_factor"],
                margin_words(m["margin"]),
                _required(m),
                *(m[key] for key in _VERDICTS),
            ]
            for m in rows
        ],
        caption="Only what unbalance excites is judged. In the manner of API 617; no statement of "
        "compliance. Speeds are those of the shaft itself.",
    )


def _required(m: Mapping[str, Any]) -> str:
    asked = m["required"]
    return "no margin is enough" if asked is None else f"{100.0 * asked:.1f}"


def margin_chart(entry: Mapping[str, Any]) -> charts.Chart:
    """Return critical speeds and operating range of each shaft; `entry` as in `margin_blocks`."""
    shafts = list(dict.fromkeys(o["shaft"] for o in entry["operating"]))
    parts: list[charts.Part] = []
    for o in entry["operating"]:
        at, low, high = shafts.index(o["shaft"]), o["from_rpm"], o["to_rpm"]
        between = (at - 0.32, at + 0.32)
        wide = f"15 % around the operating speed of {o['shaft']}"
        parts += [
            charts.Span(low=low * (1.0 - _MARGIN), high=high * (1.0 + _MARGIN), text=wide,
                        between=between),
            charts.Span(low=low, high=high, between=between, is_hatched=True,
                        text=f"operating speed of {o['shaft']}, {low:g} to {high:g} rpm"),
        ]  # fmt: skip
    for whirl in charts.WHIRL_LOOKS:
        own = [m for m in entry["margins"] if (m["whirl"] or "planar") == whirl]
        if own:
            parts.append(
                charts.Curve(
                    x=numbers([m["critical_speed_rpm"] for m in own]),
                    y=numbers([shafts.index(m["shaft"]) for m in own]),
                    name=charts.whirl_name(whirl),
                    look=replace(charts.whirl_look(whirl), dash="", size=12.0),
                    texts=[_margin_text(m) for m in own],
                )
            )
    last = max(
        [m["critical_speed_rpm"] for m in entry["margins"]]
        + [(1.0 + _MARGIN) * o["to_rpm"] for o in entry["operating"]]
    )
    speeds = charts.speed_axis(0.0, 1.04 * last, "speed of the shaft itself")
    return charts.Chart(
        name="margins",
        title="Critical speeds and operating speeds",
        caption="Hatched: operating speeds of each shaft; plain around them: 15 % more and less. "
        "Critical speeds inside the plain band are nearer than 15 %.",
        alt="Critical speeds of each shaft beside its operating range; the table below has the "
        "numbers.",
        x=replace(speeds, digits=",.1f"),
        y=charts.Axis(label="shaft", places=shafts, low=-0.5, high=len(shafts) - 0.5),
        parts=parts,
        height_px=180 + 60 * len(shafts),
    )


def _margin_text(m: Mapping[str, Any]) -> str:
    words = [f"{margin_words(m['margin'])} the operating speed"]
    if m["amplification_factor"] is not None:
        words.append(f"amplification factor {m['amplification_factor']:.3g}")
    words.append(f"15 %: {m['verdict_15_percent']}")
    return "\n".join(words)
