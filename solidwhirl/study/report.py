"""A study as plain data, as a summary in Markdown and as one picture."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, PositiveInt

from solidwhirl.core.errors import markdown_row, markdown_text
from solidwhirl.core.machine import machine_speed
from solidwhirl.core.plain_data import plain_data
from solidwhirl.core.versions import package_versions
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import scene_hash
from solidwhirl.study.table import LEVEL_SPAN, Outcome, StudyRow, StudyTable

SCHEMA = "solidwhirl-study-2"
#: Files of a study.
DOCUMENT, REPORT, PICTURE = "study.json", "study.md", "study.png"
# Axes of the picture, with their units.
_COSTS = (
    ("processor time", "s"), ("peak memory", "GiB"), ("unknowns before reduction", "1"),
)  # fmt: skip


class PeerPoint(BaseModel):
    """What another program took for the same scene, and its error against the same truth."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    program: Annotated[str, Field(min_length=1, max_length=80)]
    model: Annotated[str, Field(max_length=80)] = ""
    unknowns: PositiveInt
    error: PositiveFloat
    cpu_s: PositiveFloat
    peak_memory_gib: PositiveFloat


@dataclass(frozen=True, kw_only=True)
class Study:
    """A whole study; the reference is the first of its outcomes."""

    scene: Scene
    quick: bool
    outcomes: tuple[Outcome, ...]
    table: StudyTable
    peers: tuple[PeerPoint, ...] = ()

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers of cases that are done, failed and skipped."""
        found = [o.status for o in self.outcomes]
        return tuple(found.count(status) for status in ("done", "failed", "skipped"))

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence per case that is missing and per level without a real ladder."""
        notes = [
            f"{o.case.name}: {o.status}, {o.message}" for o in self.outcomes if o.status != "done"
        ]
        notes += [
            f"Level {level}{'' if level in self.table.shown_levels else ' is not shown'}: its "
            f"unknowns span a factor {span:.3g}, a ladder has {LEVEL_SPAN:g}"
            for level, span in self.table.spans.items()
            if level != "beam" and span < LEVEL_SPAN
        ]
        lost = [r.outcome.case.name for r in self.table.rows if r.campbell.unmatched]
        if lost:
            notes.append(
                "Branches that are off by more than 25 % or missing, no error is given: "
                f"{', '.join(lost)}"
            )
        return tuple(notes)


def study_document(study: Study) -> dict[str, Any]:
    """Return everything that study.json holds; units are in the keys, absent values are null."""
    table, reference = study.table, study.outcomes[0]
    assert reference.measured is not None
    speed = machine_speed()
    document = {
        "schema": SCHEMA,
        "scene": {
            "name": study.scene.name,
            "title": study.scene.title,
            "sha256": scene_hash(study.scene),
        },
        "quick": study.quick,
        "machine": {
            "system": platform.platform(),
            "processor": platform.processor() or platform.machine(),
            "cores": os.cpu_count(),
            "memory_gib": os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1024.0**3,
            **asdict(speed),
        },
        "packages": package_versions(),
        "notes": study.notes,
        "reference": {
            "accuracy": reference.case.settings["accuracy"],
            "estimate": table.floor,
            "speed_rad_s": reference.measured.campbell.speeds_rad_s,
            "frequency_hz": reference.measured.campbell.frequency_hz,
            "critical_speed_rad_s": [c.speed_rad_s for c in reference.measured.critical_speeds],
        },
        "cases": [_case(row) for row in table.rows],
        "peers": [peer.model_dump() for peer in study.peers],
        "pareto": {"error_cpu_s": table.time_front, "error_peak_memory": table.memory_front},
        "spans": table.spans,
        "slopes": [asdict(s) for s in table.slopes],
    }
    return plain_data(document)  # type: ignore[no-any-return]


def _case(row: StudyRow) -> dict[str, Any]:
    case, found = row.outcome.case, row.outcome.measured
    head = {
        "name": case.name,
        "series": case.series,
        "settings": case.settings,
        "status": row.outcome.status,
        "message": row.outcome.message,
    }
    if found is None:
        return head
    used = {
        "startup": found.startup, "without_estimates": found.plain,
        "with_estimates": found.estimated,
    }  # fmt: skip
    return {
        **head,
        **{k: getattr(found, k) for k in ("unknowns", "coordinates", "bodies", "wall_s")},
        **{k: None if usage is None else asdict(usage) for k, usage in used.items()},
        "campbell": asdict(row.campbell),
        "critical_speeds": asdict(row.critical_speeds),
        "estimated_parts": found.parts,
    }


def summary(study: Study, document: Mapping[str, Any]) -> str:
    """Return the summary of a study in Markdown."""
    table, machine = study.table, document["machine"]
    lines = [
        f"# Accuracy against cost: {markdown_text(study.scene.title or study.scene.name)}",
        "",
        f"Errors are the largest of all branches and speeds, relative to the "
        f"{study.outcomes[0].case.level} level at accuracy "
        f"{document['reference']['accuracy']:g}, whose own estimate is {table.floor:.1e}. "
        f"Time is processor time of the whole process, its start included, without error estimates "
        f"except for adaptive runs, which need them. Machine: {machine['processor']}, "
        f"{machine['gflops']:.3g} GFLOP/s, {machine['gbytes_per_s']:.3g} GB/s on one core.",
        "",
        f"![Error against cost]({PICTURE})",
        "",
        *(f"- {markdown_text(note)}" for note in study.notes),
        "",
        "## Cases",
        "",
        "| case | unknowns | CPU [s] | memory [GiB] | error | estimate | effectivity | "
        "critical speeds | fronts |",
        "|---|---|---|---|---|---|---|---|---|",
        *(_row(row, table) for row in table.rows if row.outcome.measured),
        "",
        "Fronts: T, no case is both faster and more accurate; M, none needs both less memory and "
        "is more accurate. Effectivity: estimated over true error.",
        "",
        *_peer_lines(study.peers),
        "## Slopes over the unknowns",
        "",
        "| series | quantity | slope | ± | scatter [decades] | points | left out |",
        "|---|---|---|---|---|---|---|",
        *(
            markdown_row(
                (
                    *(s.series, s.quantity, f"{s.slope:.2f}", f"{s.standard_error:.2f}"),
                    *(f"{s.scatter_log10:.2f}", s.points, s.left_out),
                )
            )
            for s in table.slopes
        ),
    ]
    return "\n".join(lines) + "\n"


def _peer_lines(peers: Sequence[PeerPoint]) -> list[str]:
    if not peers:
        return []
    return [
        "## Other programs",
        "",
        "| program | model | unknowns | CPU [s] | memory [GiB] | error |",
        "|---|---|---|---|---|---|",
        *(
            markdown_row(
                (
                    *(peer.program, peer.model, peer.unknowns, f"{peer.cpu_s:.2f}"),
                    *(f"{peer.peak_memory_gib:.3f}", _short(peer.error)),
                )
            )
            for peer in peers
        ),
        "",
    ]


def _row(row: StudyRow, table: StudyTable) -> str:
    found, name = row.outcome.measured, row.outcome.case.name
    assert found is not None
    reference = row.outcome.case.ladder == "reference"
    return markdown_row(
        (
            *(name, found.unknowns, f"{found.usage.cpu_s:.2f}"),
            f"{found.usage.peak_memory_gib:.3f}",
            "" if reference else _short(row.campbell.true),
            _short(table.floor if reference else row.campbell.estimate),
            _short(row.campbell.effectivity, ".2g"),
            "" if reference else _short(row.critical_speeds.true),
            "T" * (name in table.time_front) + "M" * (name in table.memory_front),
        )
    )


def _short(value: float, kind: str = ".1e") -> str:
    return format(value, kind) if math.isfinite(value) else ""


def study_chart(study: Study) -> charts.Chart:
    """Return error against processor time, memory and unknowns, a line for each ladder."""
    table = study.table
    rows = [row for row in table.rows if table.shown(row)]
    costs = np.array([_costs(row) for row in rows]).reshape(-1, 3)
    errors = np.array([max(row.campbell.true, table.floor) for row in rows])
    options = []
    for k, (name, unit) in enumerate(_COSTS):
        column, curves = costs[:, k], _peer_curves(study.peers, k)
        for number, series in enumerate(dict.fromkeys(r.outcome.case.series for r in rows)):
            own = np.flatnonzero([r.outcome.case.series == series for r in rows])
            own = own[np.argsort(column[own])]
            slopes = "".join(
                f", error ~ N^{s.slope:.2f}"
                for s in table.slopes
                if (s.series, s.quantity) == (series, "error")
            )
            look = replace(charts.series_look(number), dash="solid", width=1.1, size=7.7)
            curves.append(
                charts.Curve(x=column[own], y=errors[own], name=series + slopes, look=look)
            )
        options.append(
            charts.Option(label="", marks=curves, x=charts.Axis(label=name, unit=unit, is_log=True))
        )
    floor = charts.Rule(
        at=table.floor,
        along="y",
        text="estimated error of the reference",
        look=charts.Look("@muted", "dot"),
    )
    label = "largest relative error of all branches and speeds"
    return charts.Chart(
        name="study",
        title=f"Error against cost: {study.scene.title or study.scene.name}",
        x=charts.Axis(label=""),
        y=charts.Axis(label=label, unit="1", is_log=True),
        parts=[
            *([floor] if table.floor > 0.0 else []),
            charts.Choice(label="cost", options=options, on_paper="each"),
        ],
    )


def _peer_curves(peers: Sequence[PeerPoint], cost: int) -> list[charts.Curve]:
    """Marks of other programs over the cost of that number, a curve for each."""
    curves = []
    for k, program in enumerate(dict.fromkeys(peer.program for peer in peers)):
        own = [peer for peer in peers if peer.program == program]
        places = [(p.cpu_s, p.peak_memory_gib, float(p.unknowns))[cost] for p in own]
        look = replace(charts.series_look(k), color="@ink", dash="", size=9.0)
        errors = np.array([peer.error for peer in own])
        curves.append(charts.Curve(x=np.array(places), y=errors, name=program, look=look))
    return curves


def _costs(row: StudyRow) -> tuple[float, float, float]:
    found = row.outcome.measured
    assert found is not None
    return found.usage.cpu_s, found.usage.peak_memory_gib, float(found.unknowns)
