"""Stability of a page: smallest damping over the speed, thresholds, bearing laws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.page.campbell_lines import Lines, branches
from solidwhirl.page.least_damped import (
    LeastDamped,
    least_of_branches,
    least_traces,
    undamped_branches,
)
from solidwhirl.page.records import Chart, Choice, Option, Run, Section, Text
from solidwhirl.page.traces import (
    SPEED_AXIS,
    FloatArray,
    Trace,
    analyses_of_kind,
    axis,
    line,
    metric,
    numbers,
    series_style,
    slug,
)

# Decrements and growth rates below this are those of undamped motion.
_NOTHING = 1e-9


def section(run: Run) -> Section | None:
    """Return stability charts and bearing laws; None where the scene has none."""
    blocks: list[Any] = []
    for name, entry in analyses_of_kind(run.document, "stability").items():
        blocks += stability_blocks(name, entry, branches(run.document))
    for name, entry in analyses_of_kind(run.document, "bearing_laws").items():
        blocks += law_blocks(name, entry)
    if not blocks:
        return None
    return Section(
        name="stability",
        title="Stability and bearing laws",
        blocks=blocks,
        note="Whether a motion grows by itself, and how bearings change with the speed.",
    )


def stability_blocks(name: str, entry: Mapping[str, Any], lines: Lines | None = None) -> list[Any]:
    """Return the smallest decrement over the speed with the threshold.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    lines
        Branches of the Campbell diagram, whose smallest decrement is then shown at first.
    """
    every = _least_of_all(entry)
    shown = None if lines is None else least_of_branches(lines)
    growth = numbers(entry["largest_growth_rate_per_s"])
    found, rpm = entry["threshold"], every.rpm
    if found is None:
        text = f"No motion grows up to {rpm.max():g} rpm."
    else:
        text = (
            f"**A motion grows ({found['kind']}) from {found['speed_rpm']:.1f} rpm**, "
            f"at {found['frequency_hz'] or 0.0:.4g} Hz."
        )
    least = np.nanmax(np.abs(every.decrement), initial=0.0)
    nothing = found is None and max(least, np.nanmax(growth, initial=0.0)) < _NOTHING
    if nothing:
        text += " At every speed there is motion that nothing damps, such as torsion: the smallest "
        text += "decrement of all modes is 0"
        if shown is None:
            return [Text(text=f"{text}, and there is no curve to draw.")]
        text += "."
    said = [] if shown is None else [f"- Least damped in the Campbell diagram: {shown.said}"]
    if not nothing and np.isfinite(every.decrement).any():
        said.append(f"- Least damped of all modes: {every.said}")
    text += "".join(f"\n{line}" for line in said)
    blocks: list[Any] = [Text(text=text, kind="plain" if found is None else "warning")]
    missing = 0 if lines is None or shown is None else undamped_branches(lines)
    return [*blocks, _stability_chart(name, entry, shown, every, missing)]


def _least_of_all(entry: Mapping[str, Any]) -> LeastDamped:
    growth = numbers(entry["largest_growth_rate_per_s"])
    hertz = numbers(entry["frequency_hz"])
    texts = [
        f"{f:.5g} Hz, {n} growing, largest rate {g:.4g} 1/s"
        for f, n, g in zip(hertz, entry["growing_motions"], growth, strict=True)
    ]
    decrement = numbers(entry["smallest_log_decrement"])
    return LeastDamped(numbers(entry["speed_rpm"]), decrement, hertz, texts)


def _stability_chart(
    name: str,
    entry: Mapping[str, Any],
    shown: LeastDamped | None,
    every: LeastDamped,
    missing: int,
) -> Chart:
    traces: list[Trace] = [] if shown is None else least_traces(shown)
    options = []
    if shown is not None:
        options.append(Option(label="decrement, Campbell diagram", traces=[0, 1]))
    at = len(traces)
    traces += least_traces(every)
    options.append(Option(label="decrement, all modes", traces=[at, at + 1]))
    traces.append(
        line(
            every.rpm,
            numbers(entry["largest_growth_rate_per_s"]),
            "largest growth rate",
            series_style(1),
            mode="lines+markers",
            text=every.texts,
            hovertemplate="%{x:,.0f} rpm<br><b>%{y:.4g}</b><br>%{text}<extra></extra>",
        )
    )
    growth = {"yaxis.title.text": "growth rate [1/s]", "yaxis2.visible": False}
    options.append(Option(label="largest growth rate", traces=[at + 2], layout=growth))
    caption = (
        "Smallest logarithmic decrement and the frequency of the mode that has it, or the largest "
        "growth rate of all motions; the engine is stable where the decrement of all modes is "
        "above and the growth rate below zero. The least damped of all modes may lie far above "
        "what the engine excites."
    )
    if missing:
        are = "branch that nothing damps is" if missing == 1 else "branches that nothing damps are"
        caption += f" Of the Campbell diagram {missing} {are} left out."
    return Chart(
        name=f"stability-{slug(name)}",
        title=f"Least damped motion over the speed ({name})",
        caption=caption,
        alt="Smallest logarithmic decrement over the speed and the frequency of its mode.",
        traces=traces,
        layout={
            "xaxis": axis(SPEED_AXIS, range=[float(every.rpm.min()), float(every.rpm.max())]),
            "yaxis": axis(
                "logarithmic decrement [1]",
                zeroline=True,
                zerolinecolor="@muted",
                rangemode="tozero",
            ),
            "yaxis2": axis(
                "frequency [Hz]",
                overlaying="y",
                side="right",
                showgrid=False,
                rangemode="tozero",
                tickmode="auto",
            ),
            "shapes": _threshold(entry["threshold"]),
            "margin": {"r": 64},
        },
        height_px=380,
        controls=[Choice(label="shown", options=options)],
    )


def _threshold(found: Mapping[str, Any] | None) -> list[dict[str, Any]]:
    if found is None:
        return []
    return [
        {
            "type": "line",
            "x0": found["speed_rpm"],
            "x1": found["speed_rpm"],
            "yref": "paper",
            "y0": 0.0,
            "y1": 1.0,
            "line": {"color": "@bad", "width": 2, "dash": "dash"},
            "label": {"text": "threshold", "font": {"color": "@bad"}, "textposition": "end"},
        }
    ]


def law_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return stiffness and damping of bearings over the speed; arguments `stability_blocks`."""
    blocks: list[Any] = []
    for quantity, key, unit in (
        ("Stiffness", "stiffness_n_per_m", "N/m"),
        ("Damping", "damping_n_s_per_m", "N s/m"),
    ):
        if entry["bearings"]:
            blocks.append(law_chart(name, entry["bearings"], quantity, key, unit))
    blocks += [Text(text=note, kind="warning") for note in entry["notes"]]
    return blocks


class _Curve(NamedTuple):
    """A coefficient over the speed."""

    law: str
    speed_rpm: FloatArray
    values: FloatArray

    def is_same(self, other: _Curve) -> bool:
        """Whether one would lie on the other."""
        return (
            self.law == other.law
            and np.array_equal(self.speed_rpm, other.speed_rpm)
            and np.allclose(self.values, other.values, rtol=1e-9, atol=0.0)
        )


def _curves(bearings: Mapping[str, Any], key: str) -> list[tuple[_Curve, str]]:
    """Curves of a coefficient that differ, with the bearings and directions that have them."""
    found: list[tuple[_Curve, list[str]]] = []
    for bearing, entry in bearings.items():
        rpm, values = numbers(entry["speed_of_its_rotor_rpm"]), numbers(entry[key])
        same = bool(np.allclose(values[:, 0], values[:, 1], rtol=1e-9, atol=0.0))
        for k, direction in enumerate(("xx and yy",) if same else ("xx", "yy")):
            curve, name = _Curve(entry["law"], rpm, values[:, k]), f"{bearing} {direction}"
            names = next((names for other, names in found if curve.is_same(other)), None)
            if names is None:
                found.append((curve, [name]))
            else:
                names.append(name)
    return [(curve, ", ".join(names)) for curve, names in found]


def law_chart(name: str, bearings: Mapping[str, Any], quantity: str, key: str, unit: str) -> Chart:
    """Return one coefficient of all bearings with a law.

    Parameters
    ----------
    name
        Of the analysis.
    bearings
        Of its part of `results.json`.
    quantity, key, unit
        What is drawn.
    """
    traces: list[Trace] = []
    largest = max(float(np.nanmax(np.abs(numbers(b[key])))) for b in bearings.values())
    prefixed, factor = metric(largest, unit)
    last = 0.0
    for number, (curve, names) in enumerate(_curves(bearings, key)):
        rpm = curve.speed_rpm
        last = max(last, float(rpm.max()))
        traces.append(
            line(
                rpm,
                factor * curve.values,
                f"{names} ({curve.law})",
                series_style(number)._replace(dash="dot" if names.endswith("yy") else "solid"),
                hovertemplate=f"<b>{names}</b><br>%{{x:,.0f}} rpm<br>"
                f"%{{y:.4g}} {prefixed}<extra></extra>",
            )
        )
    return Chart(
        name=f"law-{slug(key)}-{slug(name)}",
        title=f"{quantity} of bearings with a speed law ({name})",
        caption="Over the speed of the rotor that the bearing carries. Along y alone lines are "
        "dotted; bearings with the same curve share it. A reference shaft that is not the rotor "
        "turns at another speed.",
        alt=f"{quantity} of {', '.join(bearings)} over the speed.",
        traces=traces,
        layout={
            "xaxis": axis("speed of the rotor itself [rpm]", range=[0.0, max(last, 1.0)]),
            "yaxis": axis(f"{quantity.lower()} [{prefixed}]"),
        },
        height_px=340,
    )
