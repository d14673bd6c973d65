"""Damping of the first modes over the speed, and where the engine is unstable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from solidwhirl.analyses import base
from solidwhirl.analyses.stability_summary import (
    Stability,
    interval_document,
    interval_text,
    intervals_up_to,
    stability_of,
    whirl_document,
)
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, Text, numbers, whirl_text
from solidwhirl.core.fields import Positive
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.plain_data import Labels, tabled
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.campbell import unstable_spans
from solidwhirl.rotordyn.stability.intervals import stability_chart as damping_of

# Speeds at which it is checked by other means, where bearings follow the speed.
_CHECKED = 100.0


class StabilitySpec(base.Sweep):
    """Smallest damping over the speed and where the engine becomes unstable."""

    section = base.STABILITY
    sees_operating = True
    axes = dict.fromkeys(
        ("smallest_log_decrement", "frequency_hz", "largest_growth_rate_per_s", "growing_motions"),
        ("speed_rpm",),
    )

    kind: Literal["stability"]
    count: base.Points = 61
    frequency_max_hz: Positive | None = None

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        each = 1.0 if size.kind == "hermitian" else 2.8 if size.whole else 1.4
        return Work(eigenproblems=each * self.count, checks=_CHECKED if size.laws else 0.0)

    def run(self, engine: base.Engine) -> Outcome:
        """Damping of the first modes over the speed, and where the engine.system is unstable."""
        speeds = self.speeds_rad_s
        highest = self.frequency_max_hz or _highest_frequency_hz(engine, self)
        chart = damping_of(engine.system, speeds, highest)
        intervals = intervals_up_to(engine.system, self.to_rpm)
        operating = base.given_speeds(engine.operating)
        stability = stability_of(engine.system, self.to_rpm, operating, intervals)
        first = stability.intervals[0] if stability.intervals else None
        document: dict[str, Any] = {
            "speed_rpm": (speeds * RPM_PER_RAD_S).tolist(),
            "frequency_max_hz": highest,
            "smallest_log_decrement": base.decrements(chart.log_decrement),
            "frequency_hz": chart.frequency_hz.tolist(),
            "largest_growth_rate_per_s": chart.growth_rate_1_s.tolist(),
            "growing_motions": chart.unstable_count.tolist(),
            **whirl_document(chart),
            "at_operating": list(stability.at_operating),
            "unstable_intervals": [interval_document(i) for i in stability.intervals],
            "threshold": None
            if first is None
            else {
                "speed_rpm": first.low_rad_s * RPM_PER_RAD_S,
                "kind": first.kind,
                "frequency_hz": first.frequency_hz,
            },
        }
        return Outcome(kind=self.kind, document=document, headline=_stability_headline(stability))

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """Damping of the first modes over the speed."""
        return {"": lambda: [stability_chart(found.document)]}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Unstable speeds, damping where the engine operates and over the speed."""
        return stability_blocks(found.document)

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Over the speed; the threshold is a number."""
        told = {f"threshold_{key}": value for key, value in (document["threshold"] or {}).items()}
        return tabled(document, cls.axes)._replace(attributes=told)

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the least damping, the fastest growth, and the speed from which on it grows."""
        pairs = zip(document["frequency_hz"], document["smallest_log_decrement"], strict=True)
        # a mode that exists without a decrement has none but rounding
        least = base.smallest_of(0.0 if d is None else d for f, d in pairs if f is not None)
        yield "smallest_log_decrement", least
        yield "largest_growth_rate_per_s", base.largest_of(document["largest_growth_rate_per_s"])
        yield "threshold_speed_rpm", (document["threshold"] or {}).get("speed_rpm")


# Frequencies of a stability analysis, per turn of the fastest body.
_ORDERS = 3.0


def _highest_frequency_hz(engine: base.Engine, spec: StabilitySpec) -> float:
    """Return up to which frequency modes are looked at where the analysis does not say.

    That of the Campbell diagram where it has one, else three times per turn of the fastest body.
    """
    if engine.campbell_max_hz is not None:
        return engine.campbell_max_hz
    fastest = max(abs(ratio) for ratio in engine.speed_ratios.values())
    return _ORDERS * (fastest or 1.0) * spec.to_rpm / 60.0


def _stability_headline(stability: Stability) -> str:
    """Return what an engineer acts on: the first unstable range, or the least damping."""
    if stability.intervals:
        return "; ".join(interval_text(i) for i in stability.intervals)
    head = f"stable up to {stability.high_rpm:.6g} rpm"
    for entry in stability.at_operating:
        own = entry["first_forward"]
        if own["log_decrement"] is not None and np.isfinite(own["log_decrement"]):
            head += (
                f"; log decrement {own['log_decrement']:.3g} of the first forward mode "
                f"({own['frequency_hz']:.4g} Hz) at {entry['shaft_speed_rpm']:.6g} rpm "
                f"of {entry['shaft']}"
            )
    return head


def stability_blocks(entry: Mapping[str, Any]) -> list[AnalysisBlock]:
    """Return where the system is unstable, and the damping of its first modes over the speed."""
    rpm, found = numbers(entry["speed_rpm"]), entry["unstable_intervals"]
    blocks: list[AnalysisBlock] = []
    if found:
        blocks.append(_intervals_table(found))
    else:
        blocks.append(Text(text=f"Stable from {rpm.min():g} to {rpm.max():g} rpm."))
    if entry["at_operating"]:
        blocks.append(_operating_table(entry["at_operating"]))
    return [*blocks, stability_chart(entry)]


def _intervals_table(found: Sequence[Mapping[str, Any]]) -> Table:
    return Table(
        title="Unstable speeds",
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


def _operating_table(found: Sequence[Mapping[str, Any]]) -> Table:
    whirls = ("first_forward", "first_backward")
    return Table(
        title="Damping at operating speeds",
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
    """Return the damping of the first modes and the largest growth rate over the speed."""
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
        notes=[
            f"{c.name}: least at {c.texts[int(np.nanargmin(c.y))]}"
            for c in first
            if np.isfinite(c.y).any()
        ],
        height_px=380,
    )


def _decrement(
    rpm: FloatArray, found: Mapping[str, Any], name: str, look: charts.Look
) -> charts.Curve:
    hertz, decrement = numbers(found["frequency_hz"]), numbers(found["log_decrement"])
    # where a mode exists without damping its decrement is rounding, which the document leaves out
    shown = np.where(np.isfinite(hertz) & ~np.isfinite(decrement), 0.0, decrement)
    texts = [charts.hertz_text(f) if np.isfinite(f) else "" for f in hertz.tolist()]
    return charts.Curve(x=rpm, y=shown, name=name, look=replace(look, size=5.0), texts=texts)
