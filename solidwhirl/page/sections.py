"""The sections of a page in their order, and the whole page of a run."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from solidwhirl.analyses.base import CRITICAL_SPEEDS, MODE_SHAPES
from solidwhirl.core.blocks import AnalysisBlock, CutBodies, Table, TurningModes
from solidwhirl.core.outcome import PageSection
from solidwhirl.page.drawing import engine
from solidwhirl.page.frame.build import page_html
from solidwhirl.page.frame.in_space import cut_bodies_chart
from solidwhirl.page.frame.plotly_chart import page_chart, slug
from solidwhirl.page.frame.records import Block, Run, Section
from solidwhirl.page.modes import asymmetry, campbell, criticals, shapes
from solidwhirl.page.run import (
    accuracy,
    checks,
    comparison,
    inputs,
    joints,
    masses,
    meshes,
    provenance,
    summary,
)
from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.plots.chart import Chart

_COUNT = re.compile(r" \((\d+)\)$")
#: The page's own sections, by their order among those of analyses (`PageSection.order`).
SECTIONS: tuple[tuple[int, Callable[[Run], Section | None]], ...] = (
    (10, summary.section),
    (20, engine.section),
    (30, campbell.section),
    (45, asymmetry.section),
    (CRITICAL_SPEEDS.order, criticals.section),
    (MODE_SHAPES.order, shapes.section),
    (210, comparison.section),
    (220, inputs.section),
    (225, joints.section),
    (230, masses.section),
    (240, meshes.section),
    (250, accuracy.section),
    (260, checks.section),
    (270, provenance.section),
)


def page_of(run: Run) -> str:
    """Return the page of a run as HTML."""
    scene = run.results.scene
    return page_html(sections_of(run), title=scene.title or scene.name, name=scene.name)


def write_report(run: Run, path: Path) -> None:
    """Write the page of a run to a file, which is replaced when the new one is complete."""
    replace_text(path, page_of(run))


def sections_of(run: Run) -> tuple[Section, ...]:
    """Return the sections that a run has something for, in the order of the page."""
    found = {order: own for order, section in SECTIONS if (own := section(run)) is not None}
    for place, blocks in analysis_blocks(run).items():
        own = found.get(place.order) or Section.at(place, ())
        found[place.order] = replace(own, blocks=[*own.blocks, *blocks])
    return tuple(found[order] for order in sorted(found))


def analysis_blocks(run: Run) -> dict[PageSection, list[Block]]:
    """Return what analyses tell, by section; names stand in titles where kinds say too little."""
    outcomes = run.results.analyses
    kinds = Counter(outcome.kind for outcome in outcomes.values())
    found: dict[PageSection, list[Block]] = {}
    for name, outcome in outcomes.items():
        said = "" if name == outcome.kind and kinds[name] == 1 else name
        told = [] if outcome.blocks is None else outcome.blocks()
        if told:
            blocks = found.setdefault(outcome.section, [])
            blocks += [_page_block(block, name, said) for block in told]
    return found


def _page_block(block: AnalysisBlock, name: str, said: str) -> Block:
    """A block of an analysis of a name, with the name in its title where that is to be said."""
    if isinstance(block, Chart):
        return page_chart(replace(block, title=entitled(block.title, said)), name)
    if isinstance(block, TurningModes):
        shown = replace(block, name=f"{block.name}-{name}", title=entitled(block.title, said))
        return shapes.turning_viewer(shown)
    if isinstance(block, CutBodies):
        return cut_bodies_chart(replace(block, title=entitled(block.title, said)), slug(name))
    if isinstance(block, Table):
        title, folded = entitled(block.title, said), entitled(block.folded, said)
        return replace(block, title=title, folded=folded)
    return block


def entitled(title: str, name: str) -> str:
    """Return a title with a name in brackets, before a number that stands there."""
    if not (title and name):
        return title
    count = _COUNT.search(title)
    if count is None:
        return f"{title} ({name})"
    return f"{title[: count.start()]} ({name}, {count[1]})"
