"""The sections of a page in their order, and the whole page of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from solidwhirl.page.drawing import engine
from solidwhirl.page.frame.build import page_html
from solidwhirl.page.frame.records import Block, Chart, Run, Section, Table
from solidwhirl.page.modes import campbell, criticals, frames, shapes, stability
from solidwhirl.page.responses import maps, recovery, run_ups, state_space, unbalance
from solidwhirl.page.run import (
    accuracy,
    checks,
    comparison,
    inputs,
    masses,
    meshes,
    provenance,
    summary,
)
from solidwhirl.rotordyn.core.atomic import replacing


def others(run: Run) -> Section | None:
    """Return the analyses of kinds that no section knows; None where there are none."""
    shown = {kind for _, kinds in SECTIONS for kind in kinds}
    found = {n: o for n, o in run.results.analyses.items() if o.kind not in shown}
    if not found:
        return None
    return Section(
        name="other-analyses",
        title="Other analyses",
        blocks=[
            Table(
                head=["analysis", "kind", "in short", "files"],
                rows=[
                    [name, o.kind, o.headline, ", ".join(f"`{f}`" for f in o.files)]
                    for name, o in found.items()
                ],
            )
        ],
        note="Their numbers are in `results.json`.",
    )


#: Sections from top to bottom, and the kinds of analyses that each shows.
SECTIONS: tuple[tuple[Callable[[Run], Section | None], tuple[str, ...]], ...] = (
    (summary.section, ()),
    (engine.section, ()),
    (campbell.section, ()),
    (frames.section, ("rotating_campbell",)),
    (criticals.section, ("separation_margins", "critical_speed_map")),
    (shapes.section, ("mode_shapes",)),
    (maps.section, ("place_map", "waterfall", "stiffness_study")),
    (unbalance.section, ("unbalance_response",)),
    (run_ups.section, ("run_up",)),
    (stability.section, ("stability", "bearing_laws")),
    (recovery.section, ("recovery",)),
    (state_space.section, ("state_space",)),
    (others, ()),
    (comparison.section, ()),
    (inputs.section, ()),
    (masses.section, ()),
    (meshes.section, ()),
    (accuracy.section, ()),
    (checks.section, ()),
    (provenance.section, ()),
)


def page_of(run: Run) -> str:
    """Return the page of a run as HTML."""
    scene = run.results.scene
    return page_html(sections_of(run), title=scene.title or scene.name, name=scene.name)


def write_report(run: Run, path: Path) -> None:
    """Write the page of a run to a file, which is replaced when the new one is complete."""
    text = page_of(run)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def sections_of(run: Run) -> tuple[Section, ...]:
    """Return the sections that a run has something for, in the order of the page."""
    kinds = {name: outcome.kind for name, outcome in run.results.analyses.items()}
    found = (section(run) for section, _ in SECTIONS)
    return tuple(without_needless_names(s, kinds) for s in found if s is not None)


def without_needless_names(section: Section, kinds: Mapping[str, str]) -> Section:
    """Leave the name of an analysis out of titles where it says no more than its kind does.

    Titles of blocks end in " (name)" or " (name, count)"; `kinds` has the kind by name. A name that
    is its kind's is left out if no other analysis is of this kind.
    """
    every = list(kinds.values())
    needless = [name for name, kind in kinds.items() if name == kind and every.count(kind) == 1]

    def told(title: str) -> str:
        for name in needless:
            title = title.replace(f" ({name})", "").replace(f" ({name}, ", " (")
        return title

    def renamed(block: Block) -> Block:
        if isinstance(block, Table):
            return replace(block, title=told(block.title), folded=told(block.folded))
        return replace(block, title=told(block.title)) if isinstance(block, Chart) else block

    return replace(section, blocks=[renamed(block) for block in section.blocks])
