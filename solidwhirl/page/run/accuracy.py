"""Section: how accurate the numbers are, and what they cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from solidwhirl.estimates.documents import (
    coupling_effect,
    coupling_text,
    followed_by,
    materials_text,
)
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Block, Run, Section, Table, Text
from solidwhirl.rotordyn.plots.chart import Axis, Bars, Chart, Look

_MET = {True: "met", False: "**not met**", None: "not known"}
_PER_BAR = 30


def section(run: Run) -> Section:
    """Accuracy and cost."""
    document = run.document
    return Section(
        name="accuracy",
        title="Accuracy and cost",
        blocks=(*accuracy_blocks(document), *_cost(document)),
        note="The estimates are of the discretisation: mesh, modes, and what is left out of the "
        "basis. Errors of the input, such as a bearing's stiffness, are not in them.",
    )


def accuracy_blocks(document: Mapping[str, Any]) -> Iterator[Block]:
    """Yield the estimates of `results.json`, their parts, and what they leave out."""
    found = document["accuracy"]
    largest = found["largest_error_estimate"]
    if largest is None and not found["rounds"]:
        yield Text(
            text="The scene has the error estimates off. What its mesh rule expects is in the "
            "summary; how the estimates are made is in `docs/accuracy.md`."
        )
        return
    said = "none" if largest is None else f"{100 * largest:.2g} %"
    without = found["bodies_without_estimate"]
    met = "**not estimated**" if without and found["met"] is None else _MET[found["met"]]
    lines = [
        f"Asked: **{100 * found['asked']:.2g} %** relative error of every frequency. Largest "
        f"estimate: **{said}**, {met}."
    ]
    lines += [f"- `{name}` {_why_not(document, name)}" for name in without]
    lines += [
        f"- `{name}` {materials_text(names)}"
        for name, names in found.get("bodies_of_several_materials", {}).items()
    ]
    effect = coupling_effect(document)
    if effect is not None:
        lines.append(f"- {coupling_text(effect)}")
    yield Text(text="\n".join(lines))
    given = without
    later = [n for n, b in document["bodies"].items() if b.get("source") and n not in given]
    parts = document["campbell"].get("error_parts", {})
    remarks = {"interface_coupling": "a choice of the model, not summed"}
    rows = [(p.replace("_", " "), _largest(v), remarks.get(p, "")) for p, v in parts.items()]
    if rows:
        yield Table(
            title="Where the error comes from",
            head=("part", "largest of all speeds", ""),
            rows=rows,
        )
    begun = any(r.get("from_other") for r in found["rounds"])
    if found["rounds"] and (len(found["rounds"]) > 1 or later or begun):
        yield _rounds(found["rounds"], later)


def _why_not(document: Mapping[str, Any], name: str) -> str:
    """Why a body has no estimate, and what to do."""
    if name in document["accuracy"]["meshes_without_estimate"]:
        return (
            "has an estimate of its modes, none of its mesh, which is a given one; compare with a "
            "finer mesh"
        )
    if document["bodies"][name]["level"] == "imported":
        return (
            "is not estimated: its matrices are taken as they are, and how well they describe the "
            "body is not in these numbers; compare with those of a finer mesh"
        )
    return "is not estimated: nothing of its own error is in these numbers"


def _largest(values: Any) -> str | None:
    known = [v for row in values for v in row if v is not None]
    return f"{max(known):.1e}" if known else None


_BEGUN = " The first round has the meshes and modes that these bodies had with other supports."


def _rounds(rounds: Any, compared: Sequence[str]) -> Table:
    later = (
        f" The mesh of {', '.join(compared)} is compared with a coarser one after the last round: "
        "it is in the largest estimate above and not in those of the rounds."
    )
    return Table(
        title="Rounds of refinement",
        head=("round", "largest estimate", "unknowns", "modes", "refined then"),
        rows=[
            (
                k + 1,
                f"{r['largest_error_estimate']:.1e}",
                ", ".join(f"{n} {u}" for n, u in r["unknowns"].items()),
                ", ".join(f"{n} {m}" for n, m in r["modes"].items()),
                followed_by(rounds, k) or None,
            )
            for k, r in enumerate(rounds)
        ],
        caption="Meshes are refined where the estimate says that the error arises, and modes are "
        "added, until the estimate is below what was asked or gets no better."
        + (_BEGUN if rounds[0].get("from_other") else "")
        + (later if compared else ""),
    )


def _cost(document: Mapping[str, Any]) -> Iterator[Block]:
    spent = {name: float(s) for name, s in document["timings_s"].items()}
    kept = {name for name, origin in document.get("stages", {}).items() if origin == "kept"}
    expected = document["predicted_cost"]
    text = (
        f"Together **{sum(spent.values()):.3g} s** of wall time, at most "
        f"**{document['peak_memory_gib']:.2g} GiB** of memory. Predicted: "
        f"{expected['cpu_s']:.2g} s of one core, {expected['peak_memory_gib']:.2g} GiB."
    )
    if kept:
        text += f"\n\nKept from an earlier run, and not computed again: {', '.join(sorted(kept))}."
    if spent:
        yield page_chart(time_chart(spent))
    yield Text(text=text)


def time_chart(spent: Mapping[str, float]) -> Chart:
    """Return the wall time [s] of the stages of a run, from top to bottom."""
    names = [name.replace("_", " ") for name in spent]
    seconds = np.array(list(spent.values()))
    return Chart(
        name="cost-time",
        title="Time by stage",
        caption="Wall time of the stages of this run [s], in their order from top to bottom.",
        alt="Bars of the wall time in seconds by stage: "
        + ", ".join(f"{name} {s:.2g}" for name, s in spent.items()),
        x=Axis(
            label="wall time", unit="s", low=0.0, high=1.15 * float(seconds.max()), digits=".3g"
        ),
        y=Axis(label="", places=names, low=len(names) - 0.4, high=-0.6),
        parts=[
            Bars(values=seconds, name="", look=Look("@c0"), texts=[f"{s:.3g} s" for s in seconds])
        ],
        has_legend=False,
        height_px=90 + _PER_BAR * len(names),
    )
