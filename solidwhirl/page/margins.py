"""Separation margins of a page: critical speeds beside the operating speeds of each shaft."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from solidwhirl.page.marks import whirl_text
from solidwhirl.page.operating import margin_words
from solidwhirl.page.records import Chart, Table, Text
from solidwhirl.page.traces import WHIRL, Trace, axis, band, marks, slug, style_of, whirl_name

# Margins that are drawn beside an operating range.
_MARGIN = 0.15
# Rows of a table that is shown whole.
_MOST = 12
_KEPT = "ok"
_VERDICTS = ("verdict_api_617", "verdict_15_percent", "verdict_20_percent")


def margin_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return table and chart of the separation margins of one analysis.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    rows = entry["margins"]
    if not rows:
        return [Text(text=f"`{name}`: there is no critical speed near the operating speeds.")]
    if len(rows) <= _MOST:
        return [margin_chart(name, entry), _margin_table(rows, f"Separation margins ({name})")]
    missed = [m for m in rows if any(m[key] not in (None, _KEPT) for key in _VERDICTS)]
    blocks: list[Any] = [margin_chart(name, entry)]
    if missed:
        blocks.append(_margin_table(missed, f"Separation margins that are not kept ({name})"))
    else:
        blocks.append(Text(text=f"`{name}`: all {len(rows)} critical speeds keep their margins."))
    every = _margin_table(rows, "")
    return [*blocks, replace(every, folded=f"All separation margins ({name}, {len(rows)})")]


def _margin_table(rows: Sequence[Mapping[str, Any]], title: str) -> Table:
    return Table(
        title=title,
        head=[
            "shaft",
            "critical speed [rpm]",
            "whirl",
            "amplification factor [1]",
            "margin",
            "API 617 asks [%]",
            "by API 617",
            "by 15 %",
            "by 20 %",
        ],
        rows=[
            [
                m["shaft"],
                f"{m['critical_speed_rpm']:.1f}",
                whirl_text(m["whirl"]),
                m["amplification_factor"],
                margin_words(m["margin"]),
                _required(m),
                *(m[key] for key in _VERDICTS),
            ]
            for m in rows
        ],
        caption="In the manner of API 617; no statement of compliance. Speeds are those of the "
        "shaft itself.",
    )


def margins_in_short(entry: Mapping[str, Any]) -> str:
    """Return how many critical speeds keep their margins, and which is the nearest.

    Parameters
    ----------
    entry
        Of a separation margin analysis in `results.json`.
    """
    rows = entry["margins"]
    if not rows:
        return "no critical speed near the operating speeds"
    missed = sum(m["verdict_15_percent"] != _KEPT for m in rows)
    by_formula = sum(m["verdict_api_617"] not in (None, _KEPT) for m in rows)
    nearest = min(rows, key=lambda m: (abs(m["margin"]), m["critical_speed_rpm"]))
    where = f"{margin_words(nearest['margin'])} the operating range of {nearest['shaft']}"
    said = f"all {len(rows)} kept"
    if missed or by_formula:
        said = f"**{missed} of {len(rows)} not kept** by 15 %, {by_formula} by API 617"
    return f"{said} (nearest: {nearest['critical_speed_rpm']:.0f} rpm, {where})"


def _required(m: Mapping[str, Any]) -> str | None:
    asked = m["required_api_617"]
    return "no margin is enough" if asked is None else f"{100.0 * asked:.1f}"


def margin_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return critical speeds and operating range of each shaft; arguments as `margin_blocks`."""
    shafts = list(dict.fromkeys(o["shaft"] for o in entry["operating"]))
    traces: list[Trace] = []
    for o in entry["operating"]:
        at = shafts.index(o["shaft"])
        wide = band(
            o["from_rpm"] * (1.0 - _MARGIN),
            o["to_rpm"] * (1.0 + _MARGIN),
            at - 0.32,
            at + 0.32,
            f"15 % around the operating speed of {o['shaft']}",
            showlegend=False,
        )
        del wide["fillpattern"]
        traces += [
            wide,
            band(
                o["from_rpm"],
                o["to_rpm"],
                at - 0.32,
                at + 0.32,
                f"operating speed of {o['shaft']}, {o['from_rpm']:g} to {o['to_rpm']:g} rpm",
                showlegend=False,
            ),
        ]
    for whirl in WHIRL:
        own = [m for m in entry["margins"] if (m["whirl"] or "planar") == whirl]
        if own:
            traces.append(
                marks(
                    [m["critical_speed_rpm"] for m in own],
                    [shafts.index(m["shaft"]) for m in own],
                    whirl_name(whirl),
                    style_of(whirl),
                    12,
                    text=[_margin_text(m) for m in own],
                    hovertemplate="<b>%{x:,.1f} rpm</b><br>%{text}<extra></extra>",
                )
            )
    last = max(
        [m["critical_speed_rpm"] for m in entry["margins"]]
        + [(1.0 + _MARGIN) * o["to_rpm"] for o in entry["operating"]]
    )
    return Chart(
        name=f"margins-{slug(name)}",
        title=f"Critical speeds and operating speeds ({name})",
        caption="Hatched: operating speeds of each shaft; plain around them: 15 % more and less. "
        "Critical speeds inside the plain band are nearer than 15 %.",
        alt="Critical speeds of each shaft beside its operating range; the table below has the "
        "numbers.",
        traces=traces,
        layout={
            "xaxis": axis("speed of the shaft itself [rpm]", range=[0.0, 1.04 * last]),
            "yaxis": axis(
                "shaft",
                tickmode="array",
                tickvals=list(range(len(shafts))),
                ticktext=shafts,
                range=[-0.5, len(shafts) - 0.5],
            ),
        },
        height_px=180 + 60 * len(shafts),
    )


def _margin_text(m: Mapping[str, Any]) -> str:
    words = [f"{margin_words(m['margin'])} the operating speed"]
    if m["amplification_factor"] is not None:
        words.append(f"amplification factor {m['amplification_factor']:.3g}")
    words.append(f"15 %: {m['verdict_15_percent']}")
    return "<br>".join(words)
