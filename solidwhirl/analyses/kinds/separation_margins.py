"""Distance of critical speeds from operating speeds, and whether it suffices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import (
    AnalysisBlock,
    Table,
    Text,
    margin_words,
    numbers,
    whirl_text,
)
from solidwhirl.core.fields import MOST
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn import critical_speeds
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.search import is_searched
from solidwhirl.rotordyn.modes.kinds import moves_laterally, moves_torsionally
from solidwhirl.rotordyn.modes.whirl import excitation_by
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.response.separation_margins import (
    MarginMethod,
    OperatingRange,
    SeparationMargin,
    margin_verdict,
    resonances_of_modes,
    separation_margins,
)

# Rows of a table that is shown whole.
_MOST = 12
_VERDICTS = ("verdict_api_617", "verdict_15_percent", "verdict_20_percent")
_NUMBERS = (
    *("critical_speed_rpm", "amplification_factor", "operating_speed_rpm", "margin"),
    "required_api_617",
)


class SeparationMarginsSpec(base.Analysis):
    """Distance of critical speeds from operating speeds, sought up to a multiple of these."""

    section = base.CRITICAL_SPEEDS
    turning: ClassVar = {"shaft": "it has no operating speed"}
    sees_operating = True

    kind: Literal["separation_margins"]
    operating: Annotated[tuple[base.OperatingSpec, ...], Field(max_length=MOST)] = ()
    search_factor: Annotated[float, Field(ge=1, le=10, strict=True)] = 1.3
    method: Literal["api617", "percent"] | None = None
    percent: Annotated[float, Field(gt=0, lt=100, strict=True)] = 15.0

    @model_validator(mode="after")
    def _one_method(self) -> SeparationMarginsSpec:
        if self.method != "percent" and "percent" in self.model_fields_set:
            found = "without a method" if self.method is None else f"with method {self.method!r}"
            raise ValueError(f'percent is given {found}; use method "percent"')
        return self

    def operating_named(self) -> Iterator[base.OperatingSpec]:
        """Yield its own operating speeds, which stand in for those of the scene."""
        yield from self.operating

    def shaft_speeds(
        self, operating: Sequence[base.Operating], ratio: Callable[[str], float], where: str
    ) -> Iterator[tuple[float, str]]:
        """Yield the speeds up to which critical speeds are sought."""
        factor = self.search_factor
        for o in self.operating or operating:
            yield (
                factor * o.to_rpm / ratio(o.shaft),
                f"{factor:g} times the operating speed of {o.shaft!r}, {o.to_rpm:g} rpm, to which "
                f"{where} looks (search_factor)",
            )

    def work(self, size: EngineSize) -> Work:
        """Searches beyond what is searched already."""
        reached = {abs(ratio): size.top_rad_s for ratio in size.speed_ratios.values()}
        ratios = size.speed_ratios
        ranges = self.operating or size.operating
        limit = max(self._limit(o.to_rpm / abs(ratios[o.shaft])) for o in ranges)
        searches = sum(not is_searched(limit, known) for ratio, known in reached.items() if ratio)
        return size.search.times(searches).and_also(Work(results=float(len(reached))))

    def _limit(self, reference_rpm: float) -> float:
        """Speed of the reference shaft up to which critical speeds are sought [rad/s]."""
        return self.search_factor * reference_rpm * RAD_S_PER_RPM

    def run(self, engine: base.Engine) -> Outcome:
        """Margins of every shaft's critical speeds from its operating range, and the verdict."""
        found: list[SeparationMargin] = []
        damped: list[dict[str, Any]] = []
        ranges = engine.running(self.operating)
        for entry in ranges:
            limit = self._limit(entry.reference_rpm[1])
            critical = [
                c
                for c in critical_speeds(engine.system, entry.ratio, limit)
                # what unbalance or a torque may excite
                if moves_laterally(c.shares) or moves_torsionally(c.shares)
            ]
            counts = [c.counts(engine.damping_rule) for c in critical]
            damped += [
                {
                    "shaft": entry.shaft,
                    "critical_speed_rpm": 2.0 * np.pi * c.frequency_hz * RPM_PER_RAD_S,
                    "whirl": c.whirl,
                    "amplification_factor": c.amplification_factor,
                }
                for c, own in zip(critical, counts, strict=True)
                if not own
            ]
            counted = [c for c, own in zip(critical, counts, strict=True) if own]
            excitations = [excitation_by(engine.system, c.shape, entry.bodies) for c in counted]
            operating = OperatingRange(
                shaft=entry.shaft,
                speed_low_rad_s=entry.from_rpm * RAD_S_PER_RPM,
                speed_high_rad_s=entry.to_rpm * RAD_S_PER_RPM,
            )
            found += separation_margins(operating, resonances_of_modes(counted, excitations))
        method = MarginMethod(kind=self.method or "api617", percent=self.percent)
        verdict = margin_verdict(found, method)
        judged = base.judged_text(ranges, engine.speed_ratios)
        searched = f" up to {self.search_factor:g} times the operating speeds"
        why = verdict.why + ("" if verdict.worst else searched) + (f"; {judged}" if judged else "")
        return Outcome(
            kind=self.kind,
            document={
                "note": "in the manner of API 617; no statement of compliance",
                "operating": [
                    {
                        "shaft": own.shaft,
                        "from_rpm": own.from_rpm,
                        "to_rpm": own.to_rpm,
                        "bodies": list(own.bodies),
                        "follows": own.follows or None,
                    }
                    for own in ranges
                ],
                "verdict": {
                    "method": method.kind,
                    "chosen": self.method is not None,
                    "percent": self.percent if self.method == "percent" else None,
                    "passed": verdict.passed,
                    "why": why,
                    "judged": list(dict.fromkeys(b for entry in ranges for b in entry.bodies)),
                    "worst": _margin_document(verdict.worst, method) if verdict.worst else None,
                },
                "margins": [_margin_document(m, method) for m in found],
                "critically_damped": damped,
            },
            headline=f"{'pass' if verdict.passed else 'FAIL'} by {method.text}: {why}",
        )

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The margins, if there are any."""
        document = found.document
        return {"": lambda: [margin_chart(document)]} if document["margins"] else {}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Verdict, chart and table."""
        return margin_blocks(found.name, found.document)

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """One row for each resonance."""
        rows = document["margins"]
        kinds = dict.fromkeys(_NUMBERS, float) | dict.fromkeys(
            ("shaft", "whirl", "position", *_VERDICTS), str
        )
        return Labels(
            {
                key: ("resonance", np.array([row[key] for row in rows], kind))
                for key, kind in kinds.items()
            }
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield how near the nearest excited critical speed is, and what is left beyond the asked.

        Nothing is left where no margin would be enough: that number is infinite, and left out.
        """
        yield "passed", float(document["verdict"]["passed"])
        for shaft in dict.fromkeys(entry["shaft"] for entry in document["operating"]):
            own = [m for m in document["margins"] if m["shaft"] == shaft and m["exciters"]]
            yield f"{shaft}.smallest_margin", base.smallest_of(abs(m["margin"]) for m in own)
            missed = [m for m in own if m["verdict_api_617"] != "ok"]
            yield f"{shaft}.missed_margins_api_617", len(missed)
            if all(m["required_api_617"] is not None for m in own):
                left = [abs(m["margin"]) - m["required_api_617"] for m in own]
                yield f"{shaft}.smallest_excess_api_617", base.smallest_of(left)


def _margin_document(margin: SeparationMargin, method: MarginMethod) -> dict[str, Any]:
    resonance = margin.resonance
    return {
        "shaft": margin.shaft,
        "critical_speed_rpm": resonance.speed_rad_s * RPM_PER_RAD_S,
        "whirl": resonance.whirl,
        "kind": resonance.kind,
        "amplification_factor": resonance.amplification_factor,
        "exciters": list(resonance.exciters),
        "excited": resonance.excited,
        "excited_why": resonance.why,
        "operating_speed_rpm": margin.operating_speed_rad_s * RPM_PER_RAD_S,
        "position": margin.position,
        "margin": margin.margin,
        "required": method.required(margin),
        "required_api_617": margin.required_api_617,
        "verdict_api_617": margin.verdict_api_617,
        "verdict_15_percent": margin.verdict_15_percent,
        "verdict_20_percent": margin.verdict_20_percent,
    }


def margin_blocks(name: str, entry: Mapping[str, Any]) -> list[AnalysisBlock]:
    """Return verdict, chart and table of the separation margins of an analysis of a name."""
    rows, verdict = entry["margins"], entry["verdict"]
    word = "Pass" if verdict["passed"] else "FAIL"
    kind: Literal["plain", "warning"] = "plain" if verdict["passed"] else "warning"
    blocks: list[AnalysisBlock] = [
        Text(text=f"**{word} by {method_name(verdict)}** (`{name}`): {verdict['why']}.", kind=kind)
    ]
    judged = [m for m in rows if m["exciters"]]
    if judged:
        blocks += [margin_chart(entry), _margin_table(judged)]
    rest = [m for m in rows if not m["exciters"]]
    factor = "amplification factor [1]"
    for folded, others, head, key in (
        ("Not excited, not judged", rest, "why", "excited_why"),
        (
            "Critically damped, without margins",
            entry["critically_damped"],
            factor,
            "amplification_factor",
        ),
    ):
        if others:
            shown = [
                [m["shaft"], f"{m['critical_speed_rpm']:.1f}", whirl_text(m["whirl"]), m[key]]
                for m in others
            ]
            heads = ["shaft", "speed [rpm]", "whirl", head]
            blocks.append(Table(folded=f"{folded} ({len(others)})", head=heads, rows=shown))
    return blocks


def method_name(verdict: Mapping[str, Any]) -> str:
    """Return the method of a verdict in words."""
    if verdict["method"] == "api617":
        return "API 617"
    return f"a margin of {verdict['percent']:g} %"


def _margin_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    is_long = len(rows) > _MOST
    return Table(
        title="" if is_long else "Separation margins",
        folded=f"Separation margins ({len(rows)})" if is_long else "",
        head=[
            *("shaft", "critical speed [rpm]", "whirl", "excited by"),
            *("amplification factor [1]", "margin", "asked [%]"),
            *("API 617", "15 %", "20 %"),
        ],
        rows=[
            [
                m["shaft"],
                f"{m['critical_speed_rpm']:.1f}",
                whirl_text(m["whirl"]) + ", coupled" * (m["kind"] == "coupled"),
                " and ".join(m["exciters"]),
                m["amplification_factor"],
                margin_words(m["margin"]),
                "no margin is enough" if m["required"] is None else f"{100.0 * m['required']:.1f}",
                *(m[key] for key in _VERDICTS),
            ]
            for m in rows
        ],
        caption="In the manner of API 617; no statement of compliance. Of torsional ones 10 % from "
        "the speed of the shaft are asked; other orders of torque are not looked at. Speeds are "
        "those of the shaft itself.",
    )


def margin_chart(entry: Mapping[str, Any]) -> charts.Chart:
    """Return critical speeds and operating range of each shaft."""
    shafts = list(dict.fromkeys(o["shaft"] for o in entry["operating"]))
    parts: list[charts.Part] = []
    asked = f"asked by {method_name(entry['verdict'])}"
    for o in entry["operating"]:
        at, low, high = shafts.index(o["shaft"]), o["from_rpm"], o["to_rpm"]
        between = (at - 0.32, at + 0.32)
        below, above = (_most_asked(entry["margins"], o["shaft"], side) for side in (-1, 1))
        text = f"{asked}: {100.0 * below:.3g} % below, {100.0 * above:.3g} % above"
        parts += [
            charts.Span(low=low * (1.0 - below), high=high * (1.0 + above), between=between,
                        name=asked, text=text),
            charts.Span(low=low, high=high, between=between, is_hatched=True,
                        name="operating speed",
                        text=f"operating speed of {o['shaft']}, {low:g} to {high:g} rpm"),
        ]  # fmt: skip
    judged = [m for m in entry["margins"] if m["exciters"]]
    for whirl in charts.WHIRL_LOOKS:
        own = [m for m in judged if (m["whirl"] or "straight") == whirl]
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
        [m["critical_speed_rpm"] for m in judged]
        + [part.high for part in parts if isinstance(part, charts.Span)]
    )
    speeds = charts.speed_axis(0.0, 1.04 * last, "speed of the shaft itself")
    return charts.Chart(
        name="margins",
        title="Critical speeds and operating speeds",
        caption="Hatched: operating speeds of each shaft; plain around them: the largest margin "
        f"that is {asked} of a critical speed, on either side.",
        alt="Critical speeds of each shaft beside its operating range; the table below has the "
        "numbers.",
        x=replace(speeds, digits=",.1f"),
        y=charts.Axis(label="shaft", places=shafts, low=-0.5, high=len(shafts) - 0.5),
        parts=parts,
        height_px=180 + 60 * len(shafts),
    )


def _most_asked(rows: Sequence[Mapping[str, Any]], shaft: str, side: int) -> float:
    """The largest margin asked of judged critical speeds below (−1) or above (1) a range."""
    return max(
        (
            m["required"]
            for m in rows
            if m["shaft"] == shaft and m["exciters"] and m["required"] and side * m["margin"] > 0.0
        ),
        default=0.0,
    )


def _margin_text(m: Mapping[str, Any]) -> str:
    words = [f"{margin_words(m['margin'])} the operating speed"]
    if m["amplification_factor"] is not None:
        words.append(f"amplification factor {m['amplification_factor']:.3g}")
    words.append(f"15 %: {m['verdict_15_percent']}")
    return "\n".join(words)
