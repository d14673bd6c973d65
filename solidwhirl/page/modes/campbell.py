"""The Campbell diagram of a page: frequencies and damping of the branches over the speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.analyses.base import reference_ranges_rad_s
from solidwhirl.estimates.results import Estimates
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Chart, Run, Section, Table, Text
from solidwhirl.pipeline.engine_stages import ExcitedCriticalSpeed
from solidwhirl.pipeline.results import Results
from solidwhirl.rotordyn import Campbell
from solidwhirl.rotordyn.modes.kinds import motion_words
from solidwhirl.rotordyn.plots import campbell as plots
from solidwhirl.rotordyn.plots.campbell import CampbellView, campbell_chart, damping_chart
from solidwhirl.rotordyn.plots.chart import HZ_PER_RAD_S
from solidwhirl.rotordyn.stability.intervals import UnstableInterval
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.operating import operating_speeds

# The small diagram reaches this many times as far as excitation by unbalance.
_ROOM = 2.5


def section(run: Run) -> Section | None:
    """Return the Campbell diagram with its damping and notes; notes alone without branches."""
    campbell = run.results.campbell
    notes = _notes_table(run.document)
    if not np.isfinite(campbell.frequency_hz).any():
        text = Text(text="The engine has no oscillatory mode in this range.")
        title = "Campbell diagram"
        return Section(name="campbell", title=title, blocks=[text, *notes]) if notes else None
    blocks: list[Any] = [page_chart(campbell_chart(campbell, view_of(run.results)))]
    if np.nanmax(np.abs(campbell.log_decrement), initial=0.0) > plots.UNDAMPED:
        blocks.append(page_chart(damping_chart(campbell)))
    else:
        blocks.append(Text(text="There is no damping: all decrements are zero."))
    return Section(
        name="campbell",
        title="Campbell diagram",
        blocks=[*blocks, *notes],
        note="Natural frequencies in the inertial frame over the speed of the reference shaft.",
    )


def view_of(results: Results) -> CampbellView:
    """Return what a run shows in its Campbell diagram beside the branches."""
    return campbell_view(
        results.scene,
        results.campbell,
        results.critical_speeds,
        results.estimates,
        results.stability.intervals,
    )


def campbell_view(
    scene: Scene,
    campbell: Campbell,
    critical_speeds: Sequence[ExcitedCriticalSpeed],
    estimates: Estimates | None,
    unstable: Sequence[UnstableInterval],
) -> CampbellView:
    """Return what the Campbell diagram of a scene shows beside the branches."""
    rule = scene.criteria.rule
    found = [
        (c, None if estimates is None else float(estimates.critical_speeds.total[k]))
        for k, c in enumerate(critical_speeds)
        if c.critical.counts(rule)
    ]
    rings = [(c, error) for c, error in found if c.excitation.excited]
    rest = [(c, error) for c, error in found if not c.excitation.excited]
    values = campbell.eigenvalues
    return CampbellView(
        critical_speeds=[c.critical for c, _ in rings],
        critical_texts=[_meeting_text(*own) for own in rings],
        crossings=[c.critical for c, _ in rest],
        crossing_texts=[_meeting_text(*own) for own in rest],
        excitation_ratios=scene.speed_ratios(),
        operating_rad_s=reference_ranges_rad_s(operating_speeds(scene)),
        errors=None if estimates is None else estimates.campbell.total,
        damped=np.asarray(np.isfinite(values) & ~rule.counts(values)),
        unstable_rad_s=[(i.low_rad_s, i.high_rad_s) for i in unstable],
    )


def _meeting_text(found: ExcitedCriticalSpeed, error: float | None) -> str:
    """What a reader is told of a critical speed."""
    critical = found.critical
    words = [motion_words(critical.whirl, critical.shares)]
    if found.excitation.excited:
        words.append(f"excited by {', '.join(found.excited_by)}")
    else:
        words.append(f"not excited: {found.excitation.why}")
    if critical.log_decrement:
        words.append(f"log. decrement {critical.log_decrement:.4g}")
        words.append(f"amplification {critical.amplification_factor:.3g}")
    if error is not None:
        words.append(f"error {plots.error_words(error)}")
    return "\n".join(words)


def small_chart(results: Results) -> Chart | None:
    """Return the diagram without bands, notes and controls; None without branches."""
    campbell = results.campbell
    if not np.isfinite(campbell.frequency_hz).any():
        return None
    view = replace(view_of(results), errors=None)
    whole = campbell_chart(replace(campbell, notes=()), view)
    top = _top_of_small(results, view, whole.y.high or 1.0)
    # lines of excitation end at the top of the frame
    lines = plots.excitation_lines(view.excitation_ratios, whole.x.high or 1.0, top)
    small = page_chart(
        replace(
            whole,
            name="campbell-small",
            title="Campbell diagram",
            caption="",
            y=replace(whole.y, high=top),
            parts=[
                lines if getattr(part, "label", "") == lines.label else part for part in whole.parts
            ],
            height_px=360,
        )
    )
    above = bool((np.nan_to_num(campbell.frequency_hz) > top).any())
    return replace(
        small,
        caption="Higher modes are in the diagram further down." if above else "",
        layout={
            **small.layout,
            "margin": {"l": 56, "r": 16, "t": 8, "b": 44},
            "modebar": {"orientation": "v"},  # beside the curves, not over the legend
        },
        controls=(),
    )


def _top_of_small(results: Results, view: CampbellView, top: float) -> float:
    """Highest frequency of the small diagram: what unbalance may reach, and room above it."""
    campbell = results.campbell
    fastest = float(campbell.speeds_rad_s.max()) * HZ_PER_RAD_S
    excited = max(map(abs, view.excitation_ratios.values()), default=0.0) * fastest
    counting = np.where(view.where_damped(campbell), np.nan, campbell.frequency_hz)
    known = counting if np.isfinite(counting).any() else campbell.frequency_hz
    return min(top, _ROOM * max(excited, float(np.nanmin(known))))


def _notes_table(document: Mapping[str, Any]) -> list[Table]:
    notes = document["campbell"]["notes"]
    if not notes:
        return []
    return [
        Table(
            head=["speed [rpm]", "kind", "branches", "what it says"],
            rows=[
                [
                    float(n["speed_rpm"]),
                    n["kind"],
                    ", ".join(str(b + 1) for b in n["branches"]) or "all",
                    n["text"],
                ]
                for n in notes
            ],
            folded=f"Notes on the branches ({len(notes)})",
            caption="Veering: two branches come close, exchange their shapes and part. Crossing: "
            "they pass through each other.",
        )
    ]
