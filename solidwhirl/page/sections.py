"""The sections of a page in their order; each has a module of this package."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module

from solidwhirl.page.records import Block, Chart, Run, Section, Table

# Modules of this package, each with section(run).
ORDER: tuple[str, ...] = (
    "summary",
    "drawing",
    "campbell",
    "frames",
    "criticals",
    "shapes",
    "maps",
    "responses",
    "run_ups",
    "stability",
    "recovery",
    "state_space",
    "others",
    "comparison",
    "inputs",
    "masses",
    "meshes",
    "accuracy",
    "checks",
    "provenance",
)


def sections_of(run: Run) -> tuple[Section, ...]:
    """Return the sections that a run has something for, in the order of the page.

    Parameters
    ----------
    run
        The run.
    """
    found = (import_module(f"solidwhirl.page.{name}").section(run) for name in ORDER)
    kinds = {name: outcome.kind for name, outcome in run.results.analyses.items()}
    return tuple(without_needless_names(s, kinds) for s in found if s is not None)


def without_needless_names(section: Section, kinds: Mapping[str, str]) -> Section:
    """Leave the name of an analysis out of titles where it says no more than its kind does.

    Parameters
    ----------
    section
        Titles of its blocks end in " (name)" or " (name, count)".
    kinds
        Kind of every analysis by name. A name that is its kind's is left out if no other analysis
        is of this kind.
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
