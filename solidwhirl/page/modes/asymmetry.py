"""Section: what the frame of asymmetric bodies shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from solidwhirl.core.blocks import numbers
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Block, Run, Section, Table, Text
from solidwhirl.rotordyn.modes.kinds import kind_words, shares_in
from solidwhirl.rotordyn.plots.asymmetric import FrequencyLines, lines_chart
from solidwhirl.rotordyn.plots.campbell import error_words
from solidwhirl.rotordyn.plots.chart import Chart


def section(run: Run) -> Section | None:
    """Return the section; None where all bodies are symmetric."""
    found = run.document.get("asymmetry")
    if found is None:
        return None
    return Section(
        name="asymmetry",
        title="Asymmetric rotor",
        blocks=blocks_of(found),
        note="Computed in the rotating frame, where supports that differ in x and y vary with the "
        "angle.",
    )


def blocks_of(found: Mapping[str, Any]) -> list[Block]:
    """Return tables and charts of the key `asymmetry` of `results.json`."""
    periods = found["periods_per_turn"]
    text = "All supports are isotropic: matrices are constant in the rotating frame."
    if periods:
        text = (
            f"Some supports are anisotropic: in the rotating frame the matrices have {periods} "
            f"period{'s' if periods > 1 else ''} in a turn."
        )
    return [
        Text(text=text),
        ranges_table(found),
        *closed_table(found),
        resonances_table(found),
        *(page_chart(chart) for chart in line_charts(found)),
        bodies_table(found),
    ]


def ranges_table(found: Mapping[str, Any]) -> Block:
    """Return the unstable ranges."""
    if not found["unstable_ranges"]:
        return Text(text="There is no unstable range of speeds.")
    rows = [
        [
            f"{r['from_rpm']:.2f}{'' if r['opens'] else ' (or below)'}",
            f"{r['to_rpm']:.2f}{'' if r['closes'] else ' (or above)'}",
            r["largest_growth_rate_per_s"],
            f"{r['largest_growth_at_rpm']:.1f}",
            meeting_text(r["meeting"], r["kind"]),
        ]
        for r in found["unstable_ranges"]
    ]
    return Table(
        head=["from [rpm]", "to [rpm]", "largest growth [1/s]", "at [rpm]", "what meets"],
        rows=rows,
        title="Unstable ranges",
        caption="All ranges wider than a ten-thousandth of the speeds, in speeds of the reference "
        "shaft. A motion grows by e in the reciprocal of its growth.",
    )


def closed_table(found: Mapping[str, Any]) -> list[Block]:
    """Return the ranges that damping closes, if there are any."""
    rows = [
        [
            f"{r['from_rpm']:.2f}",
            f"{r['to_rpm']:.2f}",
            r["largest_growth_rate_per_s"],
            meeting_text(r["meeting"], r["kind"]),
        ]
        for r in found["closed_by_damping"]
    ]
    if not rows:
        return []
    return [
        Table(
            head=["from [rpm]", "to [rpm]", "growth without damping [1/s]", "what meets"],
            rows=rows,
            title="Ranges that damping closes",
            caption="Unstable if nothing were damped; with the damping of the scene they are not.",
        )
    ]


def meeting_text(meeting: Mapping[str, Any] | None, kind: str) -> str:
    """Return which motions meet where a range begins, in words."""
    if kind == "divergence" or meeting is None:
        return "one motion that stands still in the body" if kind == "divergence" else "–"
    first, second = meeting["first_hz"], meeting["second_hz"]
    times = f"{meeting['turns']} × speed"
    if meeting["relation"] == "difference" and not meeting["turns"]:
        return f"two motions of {first:.4g} Hz in the body"
    return {
        "main": f"twice {first:.4g} Hz is {times}",
        "sum": f"{first:.4g} Hz + {second:.4g} Hz is {times}",
        "difference": f"{first:.4g} Hz − {second:.4g} Hz is {times}",
        "alone": f"{first:.4g} Hz alone",
    }[meeting["relation"]]


def resonances_table(found: Mapping[str, Any]) -> Table:
    """Return critical speeds and gravity critical speeds."""
    rows = [
        [
            what,
            f"{r['speed_rpm']:.2f}",
            kind_words(shares_in(r["shares"])),
            f"{r['multiple']:+d} × speed" if r["multiple"] else "–",
            r["damping_ratio"],
            error_words(r["error_estimate"]),
        ]
        for what, key in (
            ("unbalance, bow", "critical_speeds"),
            ("weight", "gravity_critical_speeds"),
        )
        for r in found[key]
    ]
    return Table(
        head=["load", "speed [rpm]", "motion", "mostly seen at", "damping ratio [1]", "error"],
        rows=rows,
        title="Resonance speeds for loads synchronous with the rotation",
        caption="Unbalance and bow turn with the body. Weight turns backward in it: at about half "
        "of the critical speeds it shakes the shaft twice per turn. Multiples are those of fixed "
        "axes; negative ones turn backward. The error is relative.",
    )


def line_charts(found: Mapping[str, Any]) -> list[Chart]:
    """Return the frequencies in fixed axes and in those of the body."""
    lines = found["lines"]
    rpm = numbers(lines["speed_rpm"])
    hertz, forward, backward, axial, inside = (
        numbers(lines[key])
        for key in (
            *("frequency_hz", "share_forward", "share_backward", "share_axial"),
            "share_in_the_frame",
        )
    )
    spans = [(r["from_rpm"], r["to_rpm"]) for r in found["unstable_ranges"]]
    kept = {
        **{"rpm": rpm, "multiples": lines["multiples"], "hertz": hertz},
        "kind": np.array(lines["kind"]),
    }
    total = forward + backward + axial
    fixed = FrequencyLines(**kept, share=total, forward=forward + 0.5 * axial)
    turning = FrequencyLines(**kept, share=inside, forward=None)
    return [
        lines_chart(fixed, "fixed axes", spans),
        lines_chart(turning, "axes of the body", spans),
    ]


def bodies_table(found: Mapping[str, Any]) -> Table:
    """Return how far bodies are from ones of revolution."""
    rows = [
        [
            name,
            1e3 * b["center_of_gravity_offset_m"],
            b["static_unbalance_kg_m"],
            b["diametral_inertia_kg_m2"][0],
            b["diametral_inertia_kg_m2"][1],
            b["product_of_inertia_kg_m2"],
            ", ".join(f"{s:.2%}" for s in b["free_frequency_split"][:3]) or "–",
        ]
        for name, b in found["bodies"].items()
    ]
    return Table(
        head=[
            *("body", "c.g. off the axis [mm]", "static unbalance [kg m]"),
            *(
                "smallest diametral inertia [kg m²]",
                "largest [kg m²]",
                "product of inertia [kg m²]",
            ),
            "first pairs of free frequencies apart by",
        ],
        rows=rows,
        title="Departure from a body of revolution",
    )
