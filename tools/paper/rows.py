"""Rows of the comparison with the paper, their summary in Markdown and as a picture, and JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.output.plan_text import table as markdown_table
from solidwhirl.rotordyn.plots import chart as charts

# Differences beyond this are told beside the picture, not drawn, per cent.
_SHOWN = 10.0


@dataclass(frozen=True, kw_only=True)
class Row:
    """One figure of the paper beside ours.

    Attributes
    ----------
    family, what
        Group that the page sums up, and the quantity.
    paper, ours
        As printed and as computed, with the estimated error of ours.
    difference
        Ours over the paper's, less 1, in per cent.
    error
        Estimated error of ours, in per cent of it; 0 of a closed form.
    data
        "paper" if all input is the paper's, "inferred", "identified" or "assumed" otherwise.
    """

    family: str
    what: str
    paper: str
    ours: str
    difference: float
    error: float
    data: str


def per_cent(
    family: str, what: str, paper: float, ours: float, unit: str, data: str, error: float = 0.0
) -> Row:
    """Row of a number that is compared in per cent; `error` is relative."""
    return Row(
        family=family,
        what=what,
        paper=f"{paper:.6g} {unit}".rstrip(),
        ours=f"{with_error(ours, abs(ours) * error)} {unit}".rstrip(),
        difference=round(100.0 * (ours / paper - 1.0), 2),
        error=float(f"{100.0 * error:.2g}"),
        data=data,
    )


def with_error(value: float, error: float, digits: str = ".5g") -> str:
    """Return a number with its error bar, if it has one."""
    return f"{value:{digits}}" + (f" ± {float(f'{error:.1g}'):g}" if error else "")


def table(rows: Iterable[Row]) -> str:
    """One line of Markdown for each family: number of figures, differences, error of ours."""
    head = ("quantities", "figures", "difference", "error of ours", "input")
    return markdown(
        head,
        (
            (name, str(len(own)), _range([r.difference for r in own]), _bar(own), data)
            for (name, data), own in _families(rows).items()
        ),
    )


def listed(rows: Iterable[Row]) -> str:
    """A line of Markdown for each row."""
    head = ("quantity", "paper", "ours", "difference", "input")
    lines = ((r.what, r.paper, r.ours, f"{r.difference:+.2f} %", r.data) for r in rows)
    return markdown(head, lines)


def _families(rows: Iterable[Row]) -> dict[tuple[str, str], list[Row]]:
    families: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        families.setdefault((row.family, row.data), []).append(row)
    return families


def _bar(rows: Sequence[Row]) -> str:
    largest = max(row.error for row in rows)
    return f"≤ {largest:.2g} %" if largest else "closed form"


def _range(differences: Sequence[float]) -> str:
    ends = dict.fromkeys(f"{d + 0.0:+.2f}" for d in (min(differences), max(differences)))
    return " to ".join(ends) + " %"


def agreement_chart(tables: Mapping[str, Sequence[Row]]) -> charts.Chart:
    """All differences that fit into one frame, by table and family, with our error bars."""
    names, marks = list[str](), list[charts.Mark]()
    for number, (where, rows) in enumerate(tables.items()):
        for (family, _), every in _families(rows).items():
            own = [r for r in every if abs(r.difference) <= _SHOWN]
            left = len(every) - len(own)
            names.append(f"{where}, {family}" + (f" ({left} outside)" if left else ""))
            look = charts.Look(f"@c{number % 8}", "", "circle", 5.0)
            marks.append(
                charts.Curve(
                    x=np.array([r.difference for r in own]),
                    y=np.full(len(own), float(len(names) - 1)),
                    errors=np.array([r.error for r in own]),
                    look=look,
                )
            )
    return charts.Chart(
        name="agreement",
        title="All figures of the paper that have a number",
        x=charts.Axis(label="ours less the paper's", unit="%", low=-_SHOWN, high=_SHOWN),
        y=charts.Axis(label="", places=names, low=len(names) - 0.5, high=-0.5),
        parts=[charts.Rule(at=0.0), *marks],
        has_legend=False,
    )


def document(tables: Mapping[str, Iterable[Row]]) -> str:
    """All rows by table, as JSON with a line for each."""
    parts = []
    for name, rows in tables.items():
        lines = ",\n".join(f"    {json.dumps(vars(r), ensure_ascii=False)}" for r in rows)
        parts.append(f"  {json.dumps(name, ensure_ascii=False)}: [\n{lines}\n  ]")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Any table in Markdown."""
    return markdown_table(" | ".join(head), rows, str)


def words(values: Iterable[float], digits: str = ".4g") -> str:
    """Numbers in a sentence."""
    return ", ".join(f"{value:{digits}}" for value in values)
