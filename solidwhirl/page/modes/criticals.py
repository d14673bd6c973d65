"""Critical speeds of a page: where they lie, and the table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.analyses.base import CRITICAL_SPEEDS, reference_ranges_rad_s
from solidwhirl.core.blocks import motion_text, numbers
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Run, Section, Table, Text
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.campbell import error_words
from solidwhirl.rotordyn.plots.chart import operating_toggle
from solidwhirl.scene_checks.operating import (
    critical_speeds_that_count,
    excited_critical_speeds,
)

# Rows of a table that is not folded.
_MOST = 15
# Part of the axis below which an error bar lies within its mark.
_SEEN = 0.008


def section(run: Run) -> Section | None:
    """Return the critical speeds; None where none can be, as the engine does not turn."""
    document, ratios = run.document, run.results.scene.speed_ratios()
    found, excited = critical_speeds_that_count(document), excited_critical_speeds(document)
    top = max(document["campbell"]["speed_rpm"], default=0.0)
    if not found and not top > 0.0:
        return None
    blocks: list[Any] = []
    if excited:
        drawn = critical_speed_chart(excited, top, reference_ranges_rad_s(run.results.operating))
        blocks.append(page_chart(drawn))
    elif top > 0.0:
        none = "that unbalance excites" if found else "at all"
        blocks.append(Text(text=f"There is no resonance {none} up to {top:g} rpm."))
    return Section.at(CRITICAL_SPEEDS, [*blocks, *critical_speed_tables(document, ratios)])


def critical_speed_tables(document: Mapping[str, Any], ratios: Mapping[str, float]) -> list[Table]:
    """Return what unbalance excites, and folded what it does not and what is critically damped.

    `document`: the contents of `results.json`. `ratios`: speed ratio of every body.
    """
    found, excited = critical_speeds_that_count(document), excited_critical_speeds(document)
    rest = [c for c in found if not c["excited"]]
    damped = [c for c in document["critical_speeds"] if c not in found]
    tables = [critical_speed_table(excited, ratios)] if excited else []
    if rest:
        tables.append(
            Table(
                folded=f"Crossings that unbalance does not excite ({len(rest)})",
                head=["reference shaft [rpm]", "frequency [Hz]", "whirl", "speed of", "why"],
                rows=[
                    [
                        f"{c['speed_rpm']:.1f}",
                        f"{c['frequency_hz']:.4g}",
                        motion_text(c),
                        ", ".join(c["shafts"]),
                        c["excited_why"],
                    ]
                    for c in rest
                ],
                caption="Here a natural frequency is that at which the shafts named turn.",
            )
        )
    if damped:
        title = f"Critically damped, no resonances ({len(damped)})"
        tables.append(replace(critical_speed_table(damped, ratios), folded=title, caption=""))
    return tables


def critical_speed_table(found: Sequence[Mapping[str, Any]], ratios: Mapping[str, float]) -> Table:
    """Return the table of critical speeds.

    `found`: entries of `critical_speeds` of `results.json`. `ratios`: speed ratio of every body.
    """
    estimated = any("frequency_error_estimate" in c for c in found)
    own = any(abs(ratios[c["shafts"][0]]) != 1.0 for c in found)
    head = [
        *("reference shaft [rpm]", "frequency [Hz]", "whirl", "excited by"),
        *("log. decrement [1]", "amplification factor [1]"),
    ]
    if own:
        head.insert(1, "exciting shaft [rpm]")
    if estimated:
        head.append("estimated error")
    rows = []
    for c in found:
        row = [
            f"{c['speed_rpm']:.1f}",
            f"{c['frequency_hz']:.4g}",
            motion_text(c),
            ", ".join(c["excited_by"]) or None,
            c["log_decrement"],
            c["amplification_factor"],
        ]
        if own:
            row.insert(1, f"{c['speed_rpm'] * abs(ratios[c['shafts'][0]]):.1f}")
        if estimated:
            row.append(error_words(c.get("frequency_error_estimate")))
        rows.append(row)
    return Table(
        head=head,
        rows=rows,
        folded=f"All critical speeds ({len(rows)})" if len(rows) > _MOST else "",
        caption="The error is relative, of speed and frequency. Unbalance of a rotor "
        "that is the same in all directions excites forward whirl alone.",
    )


def critical_speed_chart(
    found: Sequence[Mapping[str, Any]],
    top_rpm: float,
    operating_rad_s: Mapping[str, tuple[float, float]],
) -> charts.Chart:
    """Return the critical speeds along the speed with error bars, by exciting shaft.

    `found`: entries of `critical_speeds` of `results.json`. `top_rpm`: highest speed.
    `operating_rad_s`: see `solidwhirl.rotordyn.plots.chart.operating_toggle`.
    """
    exciters = list(dict.fromkeys(", ".join(c["excited_by"]) for c in found))
    parts: list[charts.Part] = [*operating_toggle(operating_rad_s)]
    for whirl in charts.WHIRL_LOOKS:
        own = [c for c in found if c["whirl"] == whirl]
        if not own:
            continue
        x = numbers([c["speed_rpm"] for c in own])
        bars = x * np.array([c.get("frequency_error_estimate") or 0.0 for c in own])
        parts.append(
            charts.Curve(
                x=x,
                y=numbers([exciters.index(", ".join(c["excited_by"])) for c in own]),
                name=charts.whirl_name(whirl),
                look=replace(charts.whirl_look(whirl), dash="", size=12.0),
                texts=[_critical_text(c) for c in own],
                # bars that the mark covers would look like a part of it
                errors=bars if (bars > _SEEN * top_rpm).any() else None,
            )
        )
    return charts.Chart(
        name="critical-speeds-chart",
        title="Where the critical speeds lie",
        caption="Critical speeds by the shaft that excites them, with their estimated errors as "
        "bars (most are smaller than the mark); hatched bands are operating speeds.",
        alt="Critical speeds along the speed of the reference shaft; the table below has the "
        "numbers.",
        x=replace(charts.speed_axis(0.0, 1.03 * top_rpm), digits=",.1f"),
        y=charts.Axis(label="unbalance of", places=exciters, low=-0.5, high=len(exciters) - 0.5),
        parts=parts,
        height_px=190 + 46 * len(exciters),
    )


def _critical_text(c: Mapping[str, Any]) -> str:
    words = [f"{c['frequency_hz']:.6g} Hz", motion_text(c)]
    if c["log_decrement"]:
        words.append(f"log. decrement {c['log_decrement']:.4g}")
    if c["amplification_factor"]:
        words.append(f"amplification factor {c['amplification_factor']:.3g}")
    if "frequency_error_estimate" in c:
        words.append(f"error {error_words(c['frequency_error_estimate'])}")
    return "\n".join(words)
