"""Section: published or measured values beside those of the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from solidwhirl.core.blocks import warning
from solidwhirl.core.key_units import unit_of
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Block, Run, Section, Table
from solidwhirl.rotordyn.plots.chart import Axis, Bars, Chart, Curve, Look, Part, Rule

_PER_ROW = 26


def section(run: Run) -> Section | None:
    """References of the scene beside the results; None where it has none."""
    found = run.document.get("references", ())
    if not found:
        return None
    missed = [entry for entry in found if entry["met"] is False]
    said = [f"{_title(e)}: {_difference(e)}, allowed {_allowed(e)}" for e in missed]
    blocks: list[Block] = [*warning(said)]
    chart = _chart([e for e in found if e["relative_difference"] is not None])
    blocks += [page_chart(chart)] if chart else []
    blocks.append(_table(found))
    return Section(
        name="references",
        title="Against published values",
        blocks=blocks,
        note="Values that the scene names with their source, beside what this run computed.",
    )


def _title(entry: Mapping[str, Any]) -> str:
    return str(entry["title"] or entry["quantity"])


def _difference(entry: Mapping[str, Any]) -> str | None:
    relative = entry["relative_difference"]
    return None if relative is None else f"{100.0 * relative:+.2f} %"


def _allowed(entry: Mapping[str, Any]) -> str | None:
    tolerance = entry["tolerance"]
    return None if tolerance is None else f"{100.0 * tolerance:.3g} %"


def _table(found: Sequence[Mapping[str, Any]]) -> Table:
    words = {True: "met", False: "**missed**", None: None}
    head = ["quantity", "unit", "published", "this run", "difference", "source"]
    rows = [
        [_title(e), unit_of(e["quantity"]) or None, *(e[k] for k in ("value", "result")),
         _difference(e), e["source"]]
        for e in found
    ]  # fmt: skip
    if any(e["tolerance"] is not None for e in found):
        head[5:5] = ["allowed", ""]
        for row, e in zip(rows, found, strict=True):
            row[5:5] = [_allowed(e), words[e["met"]]]
    return Table(
        head=head,
        rows=rows,
        caption="Difference of this run from what is published, over what is published. A result "
        "that the run does not have is left open.",
    )


def _chart(found: Sequence[Mapping[str, Any]]) -> Chart | None:
    """Differences from top to bottom, with what is allowed as bars behind them."""
    if not found:
        return None
    names = [f"{_title(e)} · {e['source']}" for e in found]
    percent = np.array([100.0 * e["relative_difference"] for e in found])
    missed = np.array([e["met"] is False for e in found])
    largest = found[int(np.argmax(np.abs(percent)))]
    allowed = np.array([100.0 * e["tolerance"] if e["tolerance"] else np.nan for e in found])
    texts = [
        f"{name}\n{e['result']:.5g} instead of {e['value']:.5g} {unit_of(e['quantity'])}"
        for name, e in zip(names, found, strict=True)
    ]
    marks: list[Part] = []
    if np.isfinite(allowed).any():
        marks.append(
            Bars(values=2.0 * allowed, start=-allowed, name="allowed", look=Look("@band/0.6"))
        )
    for rows, name, look in (
        (np.flatnonzero(~missed), "this run", Look("@c0", "", "circle", 10.0)),
        (np.flatnonzero(missed), "this run, not met", Look("@bad", "", "x", 10.0)),
    ):
        own = [texts[k] for k in rows]
        mark = Curve(x=percent[rows], y=rows.astype(float), name=name, look=look, texts=own)
        marks += [mark] if rows.size else []
    more = "; bars show what the scene allows, crosses are outside" if len(marks) > 1 else ""
    return Chart(
        name="references-difference",
        title="Difference from what is published",
        caption=f"Results of this run over the published values, less one, in per cent{more}.",
        alt=f"{len(found)} differences; the largest is {_difference(largest)} at "
        f"{_title(largest)}.",
        x=Axis(label="difference", unit="%", digits="+.3g"),
        y=Axis(label="", places=names, low=len(found) - 0.4, high=-0.6),
        parts=[*marks, Rule(at=0.0, look=Look("@muted", "solid"))],
        has_legend=len(marks) > 1,
        height_px=110 + _PER_ROW * len(found),
    )
