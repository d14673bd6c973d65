"""The sections of a page in their order; each has a module of this package."""

from __future__ import annotations

from importlib import import_module

from solidwhirl.page.records import Run, Section

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
    return tuple(s for s in found if s is not None)
