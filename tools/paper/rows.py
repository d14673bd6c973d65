"""Rows of the comparison with the paper, and their Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Row:
    """One figure of the paper beside ours.

    Attributes
    ----------
    what
        The quantity.
    paper, ours
        As printed and as computed.
    difference
        Ours less the paper's, in the unit or in per cent; empty if the two can't be compared.
    data
        "paper" if all input is the paper's, "inferred", "identified" or "assumed" otherwise.
    """

    what: str
    paper: str
    ours: str
    difference: str
    data: str


def per_cent(what: str, paper: float, ours: float, unit: str, data: str, digits: int = 5) -> Row:
    """Row of a number that is compared in per cent."""
    return Row(
        what=what,
        paper=f"{paper:.6g} {unit}",
        ours=f"{ours:.{digits}g} {unit}",
        difference=f"{100.0 * (ours / paper - 1.0):+.2f} %",
        data=data,
    )


def table(rows: Iterable[Row]) -> str:
    """Rows as a Markdown table."""
    head = ("quantity", "paper", "ours", "difference", "input")
    return markdown(head, ((r.what, r.paper, r.ours, r.difference, r.data) for r in rows))


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Any table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)
