"""Critical speeds of a page: the table, their margins from operating speeds, the map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.operating import critical_speeds_that_count
from solidwhirl.page.margins import margin_blocks
from solidwhirl.page.marks import whirl_text
from solidwhirl.page.operating import operating_bands, operating_speeds
from solidwhirl.page.records import Chart, Choice, Option, Run, Section, Table, Text
from solidwhirl.page.traces import (
    SPEED_AXIS,
    WHIRL,
    Trace,
    analyses_of_kind,
    axis,
    branch_lines,
    line,
    log_axis,
    marks,
    numbers,
    percent,
    series_style,
    slug,
    style_of,
    whirl_name,
)

# Rows of a table that is not folded.
_MOST = 15
# Part of the axis below which an error bar lies within its mark.
_SEEN = 0.008


def section(run: Run) -> Section | None:
    """Return critical speeds, margins and maps; None where nothing of it was computed."""
    document, ratios = run.document, run.results.scene.speed_ratios()
    found = critical_speeds_that_count(document)
    damped = [c for c in document["critical_speeds"] if c not in found]
    margins = analyses_of_kind(document, "separation_margins")
    maps = analyses_of_kind(document, "critical_speed_map")
    top = max(document["campbell"]["speed_rpm"], default=0.0)
    if not (found or margins or maps) and not top > 0.0:
        return None
    blocks: list[Any] = []
    if found:
        blocks += [critical_speed_chart(document, ratios), critical_speed_table(found, ratios)]
    elif top > 0.0:
        blocks.append(Text(text=f"There is no resonance up to {top:g} rpm."))
    if damped:
        table = critical_speed_table(damped, ratios)
        title = f"Critically damped, no resonances ({len(damped)})"
        blocks.append(replace(table, folded=title, caption=""))
    for name, entry in margins.items():
        blocks += margin_blocks(name, entry)
    blocks += [map_chart(name, entry) for name, entry in maps.items()]
    return Section(
        name="critical-speeds",
        title="Critical speeds",
        blocks=blocks,
        note="Speeds at which the unbalance of a shaft turns as fast as the engine vibrates.",
    )


def critical_speed_table(found: Sequence[Mapping[str, Any]], ratios: Mapping[str, float]) -> Table:
    """Return the table of critical speeds.

    Parameters
    ----------
    found
        Entries of `critical_speeds` of `results.json`.
    ratios
        Speed ratio of every body.
    """
    estimated = any("frequency_error_estimate" in c for c in found)
    own = any(abs(ratios[c["excited_by"][0]]) != 1.0 for c in found)
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
            whirl_text(c["whirl"]),
            ", ".join(c["excited_by"]),
            c["log_decrement"],
            c["amplification_factor"],
        ]
        if own:
            row.insert(1, f"{c['speed_rpm'] * abs(ratios[c['excited_by'][0]]):.1f}")
        if estimated:
            row.append(percent(c.get("frequency_error_estimate")))
        rows.append(row)
    return Table(
        head=head,
        rows=rows,
        folded=f"All critical speeds ({len(rows)})" if len(rows) > _MOST else "",
        caption="The error is that of speed and frequency alike, relative. Unbalance of a rotor "
        "that is the same in all directions excites forward whirl alone.",
    )


def critical_speed_chart(document: Mapping[str, Any], ratios: Mapping[str, float]) -> Chart:
    """Return the critical speeds along the speed with error bars, by exciting shaft.

    Parameters
    ----------
    document
        The contents of `results.json`.
    ratios
        Speed ratio of every body.
    """
    found = critical_speeds_that_count(document)
    exciters = list(dict.fromkeys(", ".join(c["excited_by"]) for c in found))
    top = max(document["campbell"]["speed_rpm"])
    # categories stand at 0, 1, ...
    traces: list[Trace] = operating_bands(
        operating_speeds(document, ratios), -0.5, len(exciters) - 0.5
    )
    for whirl in WHIRL:
        own = [c for c in found if (c["whirl"] or "planar") == whirl]
        if not own:
            continue
        errors = [c.get("frequency_error_estimate") or 0.0 for c in own]
        x = numbers([c["speed_rpm"] for c in own])
        bars = x * np.array(errors)
        traces.append(
            marks(
                x,
                [exciters.index(", ".join(c["excited_by"])) for c in own],
                whirl_name(whirl),
                style_of(whirl),
                12,
                error_x={
                    "type": "data",
                    "array": bars,
                    "color": style_of(whirl).color,
                    "thickness": 1.5,
                    # bars that the mark covers would look like a part of it
                    "visible": bool((bars > _SEEN * top).any()),
                },
                text=[_critical_text(c) for c in own],
                hovertemplate="<b>%{x:,.1f} rpm</b><br>%{text}<extra></extra>",
            )
        )
    return Chart(
        name="critical-speeds-chart",
        title="Where the critical speeds lie",
        caption="Critical speeds by the shaft that excites them, with their estimated errors as "
        "bars (most are smaller than the mark); hatched bands are operating speeds.",
        alt="Critical speeds along the speed of the reference shaft; the table below has the "
        "numbers.",
        traces=traces,
        layout={
            "xaxis": axis(SPEED_AXIS, range=[0.0, 1.03 * top]),
            "yaxis": axis(
                "unbalance of",
                tickmode="array",
                tickvals=list(range(len(exciters))),
                ticktext=[e if len(e) < 24 else e[:22] + " …" for e in exciters],
                range=[-0.5, len(exciters) - 0.5],
            ),
        },
        height_px=190 + 46 * len(exciters),
    )


def _critical_text(c: Mapping[str, Any]) -> str:
    words = [f"{c['frequency_hz']:.6g} Hz, {c['whirl']}"]
    if c["log_decrement"]:
        words.append(f"log. decrement {c['log_decrement']:.4g}")
    if c["amplification_factor"]:
        words.append(f"amplification factor {c['amplification_factor']:.3g}")
    if "frequency_error_estimate" in c:
        words.append(f"error {percent(c['frequency_error_estimate'])}")
    return "<br>".join(words)


def map_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return a critical speed map.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    stiffness = numbers(entry["stiffness_n_per_m"])
    speed = numbers(entry["shaft_speed_rpm"]).reshape(-1, stiffness.size)
    shaft = entry["excited_by"]
    # limits are of the reference shaft, branches of the shaft that excites
    with np.errstate(invalid="ignore"):
        ratios = speed / numbers(entry["critical_speed_rpm"]).reshape(speed.shape)
    known = ratios[np.isfinite(ratios)]
    ratio = float(np.median(known)) if known.size else np.nan
    ends = float(stiffness[0]), float(stiffness[-1])
    traces: list[Trace] = []
    limits = (("free_rpm", "without these bearings"), ("rigid_rpm", "with rigid bearings"))
    for number, (key, text) in enumerate(limits):
        values = [v for v in numbers(entry[key]) * ratio if np.isfinite(v) and v > 0.0]
        if values:
            x = np.array([[*ends, np.nan]] * len(values)).ravel()[:-1]
            y = np.array([[v, v, np.nan] for v in values]).ravel()[:-1]
            style = series_style(6)._replace(color="@muted", dash=("dot", "longdashdot")[number])
            traces.append(
                line(
                    x,
                    y,
                    text,
                    style,
                    hovertemplate=f"{text}: %{{y:,.1f}} rpm<extra></extra>",
                )
            )
            traces[-1]["line"]["width"] = 1
    texts = [
        [f"branch {b + 1}, {w or 'none'}" for w in branch]
        for b, branch in enumerate(entry["whirl"])
    ]
    traces += branch_lines(
        stiffness,
        speed,
        entry["whirl"],
        texts,
        "%{x:.4g} N/m<br><b>%{y:,.1f} rpm</b><br>%{text}",
    )
    if entry["operating_speed_rpm"] is not None:
        rpm = entry["operating_speed_rpm"]
        style = series_style(6)._replace(dash="longdash")
        traces.append(line(ends, [rpm, rpm], f"operating speed {rpm:g} rpm", style))
    return Chart(
        name=f"map-{slug(name)}",
        title=f"Critical speed map ({name})",
        caption=f"Undamped critical speeds of {shaft} over the stiffness of "
        f"{', '.join(entry['bearings'])}. On the left they tend to those without these bearings, "
        "on the right to those with rigid ones (thin lines).",
        alt=f"{len(speed)} branches of critical speeds over bearing stiffness from {ends[0]:.3g} "
        f"to {ends[1]:.3g} N/m.",
        traces=traces,
        layout={
            "xaxis": log_axis("stiffness of the bearings [N/m]", *ends),
            "yaxis": axis(f"critical speed of {shaft} [rpm]", type="log"),
        },
        height_px=480,
        controls=[
            Choice(
                label="speed axis",
                options=[
                    Option(label="logarithmic", traces=()),
                    Option(label="linear", traces=(), layout={"yaxis.type": "linear"}),
                ],
            )
        ],
    )
