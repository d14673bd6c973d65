"""Stability of a page: unstable speeds, damping of the first modes, bearing laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.drawing.modes import hertz_text
from solidwhirl.page.frame.marks import whirl_text
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Run, Section, Table, Text
from solidwhirl.page.frame.traces import (
    FloatArray,
    analyses_of_kind,
    numbers,
    slug,
)
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.campbell import unstable_spans


def section(run: Run) -> Section | None:
    """Return stability charts and bearing laws; None where the scene has none."""
    blocks: list[Any] = []
    for name, entry in analyses_of_kind(run.document, "stability").items():
        blocks += stability_blocks(name, entry)
    for name, entry in analyses_of_kind(run.document, "bearing_laws").items():
        blocks += law_blocks(name, entry)
    if not blocks:
        return None
    return Section(
        name="stability",
        title="Stability and bearing laws",
        blocks=blocks,
        note="Where the system is unstable, how its first modes are damped, and how bearings "
        "change with the speed.",
    )


def stability_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return where the system is unstable, and the damping of its first modes over the speed.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    rpm, found = numbers(entry["speed_rpm"]), entry["unstable_intervals"]
    blocks: list[Any] = []
    if found:
        blocks.append(_intervals_table(name, found))
    else:
        blocks.append(Text(text=f"Stable from {rpm.min():g} to {rpm.max():g} rpm."))
    if entry["at_operating"]:
        blocks.append(_operating_table(name, entry["at_operating"]))
    return [*blocks, page_chart(stability_chart(entry), name)]


def _intervals_table(name: str, found: Sequence[Mapping[str, Any]]) -> Table:
    return Table(
        title=f"Unstable speeds ({name})",
        head=[
            "from [rpm]", "to [rpm]", "kind", "whirl", "frequency at onset [Hz]",
            "largest growth rate [1/s]", "at [rpm]",
        ],
        rows=[
            [
                f"{i['from_rpm']:.1f}",
                f"{i['to_rpm']:.1f}" if i["closes"] else "beyond the range",
                i["kind"],
                whirl_text(i["whirl"]),
                i["frequency_hz"] if i["kind"] == "flutter" else None,
                i["largest_growth_rate_per_s"],
                f"{i['largest_growth_at_rpm']:.0f}",
            ]
            for i in found
        ],
    )  # fmt: skip


def _operating_table(name: str, found: Sequence[Mapping[str, Any]]) -> Table:
    whirls = ("first_forward", "first_backward")
    return Table(
        title=f"Damping at operating speeds ({name})",
        head=[
            "shaft", "its speed [rpm]", "stable",
            "log. decrement, first forward [1]", "[Hz]",
            "log. decrement, first backward [1]", "[Hz]",
        ],
        rows=[
            [
                o["shaft"],
                f"{o['shaft_speed_rpm']:.6g}",
                o["stable"],
                *(o[whirl][key] for whirl in whirls for key in ("log_decrement", "frequency_hz")),
            ]
            for o in found
        ],
    )  # fmt: skip


def stability_chart(entry: Mapping[str, Any]) -> charts.Chart:
    """Return the damping of the first modes and the largest growth rate over the speed.

    Parameters
    ----------
    entry
        Part of `results.json` of a stability analysis.
    """
    rpm = numbers(entry["speed_rpm"])
    first = [
        _decrement(rpm, entry[f"first_{whirl}"], f"first {whirl} mode", charts.whirl_look(whirl))
        for whirl in ("forward", "backward")
    ]
    below = f"below {entry['frequency_max_hz']:.4g} Hz"
    smallest = {
        "log_decrement": entry["smallest_log_decrement"], "frequency_hz": entry["frequency_hz"]
    }  # fmt: skip
    least = _decrement(rpm, smallest, f"least damped mode {below}", charts.series_look(2))
    growth = charts.Curve(
        x=rpm,
        y=numbers(entry["largest_growth_rate_per_s"]),
        name="largest growth rate of all modes",
        look=replace(charts.series_look(1), mark=""),
    )
    rate = charts.Axis(label="growth rate", unit="1/s", digits=".4g")
    options = [
        charts.Option(label="decrement, first modes", marks=first),
        charts.Option(label=f"decrement, least damped {below}", marks=[least]),
        charts.Option(label="growth rate", marks=[growth], y=rate),
    ]
    unstable = [
        (i["from_rpm"] / RPM_PER_RAD_S, i["to_rpm"] / RPM_PER_RAD_S)
        for i in entry["unstable_intervals"]
    ]
    zero = charts.Rule(at=0.0, along="y", look=charts.Look("@muted", "solid", width=1.0))
    return charts.Chart(
        name="stability",
        title="Damping over the speed",
        caption="First modes: the lowest lateral modes that vibrate in each direction of whirl. "
        "Below zero, or where the growth rate is above zero, and in the shaded speeds the system "
        "is unstable.",
        alt="Logarithmic decrement of the first forward and backward mode over the speed.",
        x=charts.speed_axis(float(rpm.min()), float(rpm.max())),
        y=charts.Axis(label="logarithmic decrement", unit="1", digits=".4g"),
        parts=[*unstable_spans(unstable), zero, charts.Choice(label="shown", options=options)],
        notes=[note for curve in first for note in _least_note(curve)],
        height_px=380,
    )


def _decrement(
    rpm: FloatArray, found: Mapping[str, Any], name: str, look: charts.Look
) -> charts.Curve:
    hertz, decrement = numbers(found["frequency_hz"]), numbers(found["log_decrement"])
    # where a mode exists without damping its decrement is rounding, which the document leaves out
    shown = np.where(np.isfinite(hertz) & ~np.isfinite(decrement), 0.0, decrement)
    texts = [hertz_text(f) if np.isfinite(f) else "" for f in hertz.tolist()]
    return charts.Curve(x=rpm, y=shown, name=name, look=replace(look, size=5.0), texts=texts)


def _least_note(curve: charts.Curve) -> list[str]:
    """The frequency of a mode where its decrement is least."""
    if not np.isfinite(curve.y).any():
        return []
    return [f"{curve.name}: {curve.texts[int(np.nanargmin(curve.y))]} where least damped"]


def law_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return stiffness and damping of bearings over the speed; arguments `stability_blocks`."""
    blocks: list[Any] = []
    for quantity, key, unit in (
        ("Stiffness", "stiffness_n_per_m", "N/m"),
        ("Damping", "damping_n_s_per_m", "N s/m"),
    ):
        if entry["bearings"]:
            blocks.append(page_chart(law_chart(entry["bearings"], quantity, key, unit), name))
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


def law_chart(bearings: Mapping[str, Any], quantity: str, key: str, unit: str) -> charts.Chart:
    """Return one coefficient of all bearings with a law.

    Parameters
    ----------
    bearings
        Of the part of `results.json` of an analysis.
    quantity, key, unit
        What is drawn.
    """
    largest = max(float(np.nanmax(np.abs(numbers(b[key])))) for b in bearings.values())
    prefixed, factor = charts.metric(largest, unit)
    found = _curves(bearings, key)
    curves = [
        charts.Curve(
            x=curve.speed_rpm,
            y=factor * curve.values,
            name=f"{names} ({curve.law})",
            look=charts.Look(
                charts.series_look(number).color, "dot" if names.endswith("yy") else "solid"
            ),
        )
        for number, (curve, names) in enumerate(found)
    ]
    last = max(float(curve.speed_rpm.max()) for curve, _ in found)
    return charts.Chart(
        name=f"law-{slug(key)}",
        title=f"{quantity} of bearings with a speed law",
        caption="Over the speed of the rotor that the bearing carries. Along y alone lines are "
        "dotted; bearings with the same curve share it. A reference shaft that is not the rotor "
        "turns at another speed.",
        alt=f"{quantity} of {', '.join(bearings)} over the speed.",
        x=charts.speed_axis(0.0, last, "speed of the rotor itself"),
        y=charts.Axis(label=quantity.lower(), unit=prefixed, digits=".4g"),
        parts=curves,
        height_px=340,
    )
