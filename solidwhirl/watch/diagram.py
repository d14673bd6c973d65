"""What the page shows of reduced bodies on their supports: diagram, critical speeds, stability."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solidwhirl.analyses.base import Stability
from solidwhirl.analyses.stability_summary import interval_document
from solidwhirl.core.blocks import Table
from solidwhirl.core.stages import silent
from solidwhirl.drawing.bodies import silhouettes
from solidwhirl.estimates.documents import critical_speed_entry
from solidwhirl.estimates.results import Estimates
from solidwhirl.output.documents import critical_speed_numbers, excitation_document
from solidwhirl.page.drawing.engine import small_drawing
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.render import chart_data, inline_html, table_html, text_html
from solidwhirl.page.modes.campbell import campbell_view
from solidwhirl.page.run.summary import critical_speeds_block
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.pipeline.engine_stages import ExcitedCriticalSpeed
from solidwhirl.pipeline.verdict_text import stability_answers
from solidwhirl.reduced_scene import ReducedScene
from solidwhirl.rotordyn import Campbell
from solidwhirl.rotordyn.plots.campbell import campbell_chart
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.operating import operating_speeds

# Speeds of a diagram while a slider moves, and height of the diagram in pixels.
_FEW, _HIGH = 9, 460


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagram:
    """Campbell diagram and critical speeds of a scene, their errors as far as they are known."""

    scene: Scene
    campbell: Campbell
    critical_speeds: tuple[ExcitedCriticalSpeed, ...]
    stability: Stability
    estimates: Estimates | None = None


def is_asymmetric(reduced: ReducedScene) -> bool:
    """Whether a body is asymmetric, so that all of it takes seconds."""
    return any(e.frame != "inertial" for e in reduced.reduced.elements.values())


def diagram_of(reduced: ReducedScene) -> Diagram:
    """Compute the diagram at all speeds of a scene."""
    return Diagram(
        scene=reduced.scene,
        campbell=reduced.campbell(),
        critical_speeds=reduced.critical_speeds(),
        stability=reduced.stability(),
    )


def quick_diagram(reduced: ReducedScene) -> Diagram:
    """Compute the diagram at few speeds, without notes; critical speeds are the same."""
    job = reduced.reduced.job
    speeds = job.plan.speeds_rad_s
    if len(speeds) > _FEW:
        speeds = speeds[np.linspace(0, len(speeds) - 1, _FEW).round().astype(int)]
    quick = replace(
        job,
        plan=replace(job.plan, speeds_rad_s=speeds),
        stage_cache=StageCache(store=None, progress=silent),  # nobody asks for this again
    )
    found = diagram_of(reduced.with_job(quick))
    return replace(found, campbell=replace(found.campbell, notes=()))


def drawing_of(reduced: ReducedScene) -> str:
    """Return the drawing of the bodies as SVG."""
    found = reduced.reduced
    bodies = silhouettes(reduced.scene, found.elements, found.geometry)
    return str(small_drawing(reduced.scene, bodies).data)


def diagram_content(diagram: Diagram) -> dict[str, Any]:
    """Return a diagram as the page takes it: chart, table and verdict."""
    scene, campbell, stability = diagram.scene, diagram.campbell, diagram.stability
    view = campbell_view(
        scene, campbell, diagram.critical_speeds, diagram.estimates, stability.intervals
    )
    chart = None
    if np.isfinite(campbell.frequency_hz).any():
        chart = replace(page_chart(campbell_chart(campbell, view)), height_px=_HIGH)
    verdict = {
        "speed_range_rpm": [stability.low_rpm, stability.high_rpm],
        "unstable_intervals": [interval_document(i) for i in stability.intervals],
        "at_operating": stability.at_operating,
    }
    return {
        "chart": None if chart is None else chart_data(chart),
        "caption": "" if chart is None else str(inline_html(chart.caption)),
        "critical_speeds": _critical_speeds(diagram),
        "verdict": [
            {"about": a.about, "text": str(inline_html(a.marked)), "good": a.good}
            for a in stability_answers(verdict)
        ],
    }


def _critical_speeds(diagram: Diagram) -> str:
    """The table of critical speeds as HTML."""
    scene, rule = diagram.scene, diagram.scene.criteria.rule
    entries = [
        _entry(found, k, diagram.estimates)
        for k, found in enumerate(diagram.critical_speeds)
        if found.critical.counts(rule) and found.excitation.excited
    ]
    block = critical_speeds_block(entries, operating_speeds(scene), scene.speed_ratios())
    if not isinstance(block, Table):
        return str(text_html(block.text))
    return f'<div class="table"><table>{table_html(block)}</table></div>'


def _entry(
    found: ExcitedCriticalSpeed, number: int, estimates: Estimates | None
) -> Mapping[str, Any]:
    """A critical speed as `results.json` has it, as far as the table reads it."""
    return {
        **critical_speed_numbers(found.critical),
        **excitation_document(found),
        **({} if estimates is None else critical_speed_entry(estimates, number)),
    }
