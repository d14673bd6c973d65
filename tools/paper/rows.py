"""Rows of the comparison with the paper, their summary in Markdown, and all of them as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Row:
    """One figure of the paper beside ours.

    Attributes
    ----------
    family, what
        Group that the page sums up, and the quantity.
    paper, ours
        As printed and as computed.
    difference
        Ours over the paper's, less 1, in per cent.
    data
        "paper" if all input is the paper's, "inferred", "identified" or "assumed" otherwise.
    """

    family: str
    what: str
    paper: str
    ours: str
    difference: float
    data: str


def per_cent(
    family: str, what: str, paper: float, ours: float, unit: str, data: str, digits: int = 5
) -> Row:
    """Row of a number that is compared in per cent."""
    return Row(
        family=family,
        what=what,
        paper=f"{paper:.6g} {unit}".rstrip(),
        ours=f"{ours:.{digits}g} {unit}".rstrip(),
        difference=round(100.0 * (ours / paper - 1.0), 2),
        data=data,
    )


def table(rows: Iterable[Row]) -> str:
    """One line of Markdown for each family: number of figures, smallest and largest difference."""
    families: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        families.setdefault((row.family, row.data), []).append(row.difference)
    head = ("quantities", "figures", "difference", "input")
    return markdown(
        head, ((name, str(len(d)), _range(d), data) for (name, data), d in families.items())
    )


def _range(differences: list[float]) -> str:
    ends = dict.fromkeys(f"{d + 0.0:+.2f}" for d in (min(differences), max(differences)))
    return " to ".join(ends) + " %"


def document(tables: Mapping[str, Iterable[Row]]) -> str:
    """All rows by table, as JSON with a line for each."""
    parts = []
    for name, rows in tables.items():
        lines = ",\n".join(f"    {json.dumps(vars(r), ensure_ascii=False)}" for r in rows)
        parts.append(f"  {json.dumps(name, ensure_ascii=False)}: [\n{lines}\n  ]")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Any table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)
