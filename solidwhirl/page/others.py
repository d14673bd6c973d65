"""Analyses that have no section of their own on a page: what they found, in one line each."""

from __future__ import annotations

from solidwhirl.page.records import Run, Section, Table

# Kinds that other sections of the page show.
SHOWN = frozenset(
    (
        "unbalance_response",
        "place_map",
        "waterfall",
        "critical_speed_map",
        "stiffness_study",
        "rotating_campbell",
        "mode_shapes",
        "separation_margins",
        "stability",
        "bearing_laws",
        "run_up",
        "state_space",
        "recovery",
    )
)


def section(run: Run) -> Section | None:
    """Return the analyses of kinds that no other section knows; None where there are none."""
    found = {n: o for n, o in run.results.analyses.items() if o.kind not in SHOWN}
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
