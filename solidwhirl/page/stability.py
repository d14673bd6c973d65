"""Stability of a page: unstable speeds, damping of the first modes, bearing laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.page.marks import whirl_text
from solidwhirl.page.operating import unstable_shapes
from solidwhirl.page.records import Chart, Choice, Option, Run, Section, Table, Text
from solidwhirl.page.traces import (
    SPEED_AXIS,
    FloatArray,
    Trace,
    WhirlStyle,
    analyses_of_kind,
    axis,
    hertz_text,
    line,
    metric,
    numbers,
    series_style,
    slug,
    style_of,
)


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
    return [*blocks, _stability_chart(name, entry)]


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


def _stability_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    rpm = numbers(entry["speed_rpm"])
    traces: list[Trace] = [
        _decrement_line(rpm, entry[f"first_{whirl}"], f"first {whirl} mode", style_of(whirl))
        for whirl in ("forward", "backward")
    ]
    smallest = {
        "log_decrement": entry["smallest_log_decrement"], "frequency_hz": entry["frequency_hz"]
    }  # fmt: skip
    below = f"below {entry['frequency_max_hz']:.4g} Hz"
    traces.append(_decrement_line(rpm, smallest, f"least damped mode {below}", series_style(2)))
    growth = numbers(entry["largest_growth_rate_per_s"])
    traces.append(
        line(
            rpm,
            growth,
            "largest growth rate of all modes",
            series_style(1),
            hovertemplate="%{x:,.0f} rpm<br><b>%{y:.4g} 1/s</b><extra></extra>",
        )
    )
    options = [
        Option(label="decrement, first modes", traces=[0, 1]),
        Option(label=f"decrement, least damped {below}", traces=[2]),
        Option(
            label="growth rate", traces=[3], layout={"yaxis.title.text": "growth rate [1/s]"}
        ),
    ]  # fmt: skip
    return Chart(
        name=f"stability-{slug(name)}",
        title=f"Damping over the speed ({name})",
        caption="First modes: the lowest lateral modes that vibrate in each direction of whirl. "
        "Below zero, or where the growth rate is above zero, and in the shaded speeds the system "
        "is unstable.",
        alt="Logarithmic decrement of the first forward and backward mode over the speed.",
        traces=traces,
        layout={
            "xaxis": axis(SPEED_AXIS, range=[float(rpm.min()), float(rpm.max())]),
            "yaxis": axis(
                "logarithmic decrement [1]",
                zeroline=True,
                zerolinecolor="@muted",
                rangemode="tozero",
            ),
            "shapes": unstable_shapes(entry["unstable_intervals"]),
        },
        height_px=380,
        controls=[Choice(label="shown", options=options)],
    )


def _decrement_line(
    rpm: FloatArray, found: Mapping[str, Any], name: str, style: WhirlStyle
) -> Trace:
    hertz = numbers(found["frequency_hz"])
    decrement = numbers(found["log_decrement"])
    # where a mode exists without damping its decrement is rounding, which the document leaves out
    shown = np.where(np.isfinite(hertz) & ~np.isfinite(decrement), 0.0, decrement)
    return line(
        rpm,
        shown,
        name,
        style,
        mode="lines+markers",
        text=[hertz_text(f) if np.isfinite(f) else "" for f in hertz.tolist()],
        hovertemplate="%{x:,.0f} rpm<br><b>%{y:.4g}</b><br>%{text}<extra></extra>",
        marker={"symbol": style.symbol, "size": 5, "color": style.color},
        connectgaps=False,
    )


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
