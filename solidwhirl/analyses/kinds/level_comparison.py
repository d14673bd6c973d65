"""The same engine with its bodies on another level: frequencies and critical speeds beside it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from solidwhirl.analyses import base
from solidwhirl.core.blocks import AnalysisBlock, Table, numbers
from solidwhirl.core.outcome import Outcome, PageSection
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import Axis, Bars, Chart, Curve, Look

Document = Mapping[str, Any]
_CHECK = "levels agree within their estimates"
_PER_ROW = 26


@dataclass(frozen=True, kw_only=True, eq=False)
class LevelResults:
    """What is compared of an engine, with relative error estimates (nan where there are none)."""

    #: Levels of its bodies, and DOFs of their meshes, by name
    levels: Mapping[str, str]
    unknowns: Mapping[str, int]
    #: Lowest modes at rest, as many as the diagram has branches: (m,) Hz, and their errors
    frequency_hz: FloatArray
    frequency_error: FloatArray
    #: Critical speeds of the reference shaft: (c,) rad/s, rising, their errors, and who excites
    critical_rad_s: FloatArray
    critical_error: FloatArray
    excited_by: tuple[str | None, ...]


class LevelComparisonSpec(base.Analysis):
    """Frequencies and critical speeds with the bodies on another level, to the same accuracy."""

    section = PageSection(
        "level-comparison",
        "Levels side by side",
        "The same engine with its bodies on another level, refined to the same accuracy.",
        255,
    )

    kind: Literal["level_comparison"]
    level: Literal["beam", "harmonic", "solid"]

    def run(self, engine: base.Engine) -> Outcome:
        """Reduce the bodies on the other level and compute the engine with them."""
        from solidwhirl.rotordyn.superelement.invariants import compared

        own, other = engine.levels(self.level)
        rows = (
            []
            if own.levels == other.levels
            else [*_mode_rows(own, other), *_speed_rows(own, other)]
        )
        known = [r for r in rows if r["estimates_sum"] is not None]
        ratios = [abs(r["relative_difference"]) / r["estimates_sum"] for r in known]
        checks = []
        if ratios and self.level != "beam":  # whose estimate is a spread of theories
            checks = [compared(_CHECK, self.label, max(ratios), 1.0, "meshes and bases")]
        document = {
            "level": self.level,
            "bodies": {
                name: {
                    "level": own.levels[name],
                    "other_level": other.levels[name],
                    "unknowns": own.unknowns.get(name),
                    "other_unknowns": other.unknowns.get(name),
                }
                for name in own.levels
            },
            "rows": rows,
            "critical_speeds": len(own.critical_rad_s),
            "other_critical_speeds": len(other.critical_rad_s),
            "largest_relative_difference": base.largest_of(
                abs(r["relative_difference"]) for r in rows
            ),
            "checks": [asdict(check) for check in checks],
        }
        return Outcome(kind=self.kind, document=document, headline=_headline(document))

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """Differences over what the estimates allow."""
        return {"": lambda: [difference_chart(found.document)]} if found.document["rows"] else {}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """Differences as a chart, and all numbers."""
        drawn = [chart for charts in self.pictures(found).values() for chart in charts()]
        told = [_table(found.document)] if found.document["rows"] else []
        return [*drawn, *told, _bodies(found.document)]

    @classmethod
    def labels(cls, document: Document) -> Labels:
        """One row for each mode and critical speed."""
        rows = document["rows"]
        keys = ("relative_difference", "error_estimate", "other_error_estimate")
        return Labels(
            {key: ("row", np.array([r[key] for r in rows], float)) for key in keys},
            {"row": ("row", np.array([r["what"] for r in rows], str))},
        )

    @classmethod
    def scalars(cls, document: Document) -> base.Scalars:
        """Yield the largest difference."""
        yield "largest_relative_difference", document["largest_relative_difference"]


def _mode_rows(own: LevelResults, other: LevelResults) -> Iterator[dict[str, Any]]:
    pairs = zip(own.frequency_hz, other.frequency_hz, strict=False)
    for k, (value, second) in enumerate(pairs):
        yield {
            "what": f"mode {k + 1} at rest",
            "excited_by": None,
            "frequency_hz": float(value),
            "other_frequency_hz": float(second),
            **_difference(value, second, own.frequency_error[k], other.frequency_error[k]),
        }


def _speed_rows(own: LevelResults, other: LevelResults) -> Iterator[dict[str, Any]]:
    pairs = zip(own.critical_rad_s, other.critical_rad_s, strict=False)
    for k, (value, second) in enumerate(pairs):
        yield {
            "what": f"critical speed {k + 1}",
            "excited_by": own.excited_by[k],
            "speed_rpm": float(value) * RPM_PER_RAD_S,
            "other_speed_rpm": float(second) * RPM_PER_RAD_S,
            **_difference(value, second, own.critical_error[k], other.critical_error[k]),
        }


def _difference(value: float, second: float, error: float, other: float) -> dict[str, Any]:
    """Relative difference, and the estimates where there are some."""
    known = bool(np.isfinite([error, other]).all())
    return {
        "relative_difference": float(second / value - 1.0),
        "error_estimate": float(error) if np.isfinite(error) else None,
        "other_error_estimate": float(other) if np.isfinite(other) else None,
        "estimates_sum": float(error + other) if known else None,
    }


def _headline(document: Document) -> str:
    largest, level = document["largest_relative_difference"], document["level"]
    if largest is None:
        return f"nothing to compare: all bodies are on level {level} already, or nothing vibrates"
    said = f"level {level} beside it: largest difference {100 * largest:.2g} %"
    counts = document["critical_speeds"], document["other_critical_speeds"]
    if counts[0] != counts[1]:
        said += f"; {counts[0]} critical speeds, {counts[1]} on level {level}"
    return said


def difference_chart(document: Document) -> Chart:
    """Return differences from top to bottom, with the sum of both estimates as bars behind them."""
    rows = document["rows"]
    percent = 100.0 * numbers([r["relative_difference"] for r in rows])
    allowed = 100.0 * numbers([r["estimates_sum"] for r in rows])
    at = np.arange(len(rows), dtype=float)
    reach = 1.1 * float(np.nanmax(np.abs([percent, allowed])))
    texts = [
        f"{row['what']}\n{_pair(row)}, differs by {p:+.2g} %"
        for row, p in zip(rows, percent, strict=True)
    ]
    marks: list[Any] = []
    if np.isfinite(allowed).any():
        name = "sum of both error estimates"
        marks.append(Bars(values=2.0 * allowed, start=-allowed, name=name, look=Look("@band/0.6")))
    look = Look("@c0", "", "circle", 10.0)
    level = f"level {document['level']} less this run"
    return Chart(
        name="levels-difference",
        title="Difference between the levels",
        caption="Of the other level from this run, over this run. Both are refined until their own "
        "estimates are within the accuracy; bars show the sum of the estimates.",
        alt=f"{len(rows)} differences; the largest is "
        f"{100.0 * document['largest_relative_difference']:.2g} %.",
        x=Axis(label="difference", unit="%", digits="+.3g", low=-reach, high=reach),
        y=Axis(label="", places=[r["what"] for r in rows], low=len(rows) - 0.4, high=-0.6),
        parts=[*marks, Curve(x=percent, y=at, name=level, look=look, texts=texts)],
        height_px=110 + _PER_ROW * len(rows),
    )


def _pair(row: Document) -> str:
    if "frequency_hz" in row:
        return f"{row['frequency_hz']:.5g} Hz and {row['other_frequency_hz']:.5g} Hz"
    return f"{row['speed_rpm']:.5g} rpm and {row['other_speed_rpm']:.5g} rpm"


def _percent(value: float | None) -> str | None:
    return None if value is None else f"{100.0 * value:.2g}"


def _table(document: Document) -> Table:
    keys = ("frequency_hz", "speed_rpm")
    return Table(
        head=["", "excited by", "unit", "this run", "error [%]", f"level {document['level']}",
              "error [%]", "difference [%]"],
        rows=[
            [
                row["what"],
                row["excited_by"],
                "Hz" if key == "frequency_hz" else "rpm",
                row[key],
                _percent(row["error_estimate"]),
                row[f"other_{key}"],
                _percent(row["other_error_estimate"]),
                f"{100.0 * row['relative_difference']:+.2g}",
            ]
            for row in document["rows"]
            for key in keys
            if key in row
        ],
        folded=f"Both levels in numbers ({len(document['rows'])})",
    )  # fmt: skip


def _bodies(document: Document) -> Table:
    return Table(
        head=["body", "level", "DOFs of its mesh", "other level", "DOFs of its mesh"],
        rows=[
            [name, b["level"], b["unknowns"], b["other_level"], b["other_unknowns"]]
            for name, b in document["bodies"].items()
        ],
    )
