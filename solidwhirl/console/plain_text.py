"""Paragraphs, lists and tables as plain text of a width; loads no library for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from textwrap import wrap

from solidwhirl.core.blocks import Part, Table
from solidwhirl.core.errors import clean

# Between two columns.
_GAP = "  "


def plain_text(parts: Sequence[Part], width: int) -> str:
    """Return paragraphs, lists of lines and tables of texts, on lines of at most a width."""
    return "\n\n".join("\n".join(_lines(part, width)) for part in parts)


def _lines(part: Part, width: int) -> Iterator[str]:
    if isinstance(part, Table):
        yield from _table_lines(part, width)
    elif isinstance(part, str):
        yield from wrap(clean(part), width)
    else:
        for line in part:
            yield from wrap(clean(line), width, initial_indent="- ", subsequent_indent="  ")


def _table_lines(table: Table, width: int) -> Iterator[str]:
    rows = [[clean(cell) for cell in row] for row in (table.head, *table.rows)]
    widths = _column_widths(list(zip(*rows, strict=True)), width - 1)
    for number, row in enumerate(rows):
        cells = [
            [cell] if len(cell) <= size else wrap(cell, size)
            for cell, size in zip(row, widths, strict=True)
        ]
        for line in zip_longest(*cells, fillvalue=""):
            padded = (text.ljust(size) for text, size in zip(line, widths, strict=True))
            yield f" {_GAP.join(padded)}".rstrip()
        if number == 0:
            yield f" {'-' * (sum(widths) + len(_GAP) * (len(widths) - 1))}"


def _column_widths(columns: Sequence[Sequence[str]], width: int) -> list[int]:
    """As wide as they need; where that is too wide, the widest are wrapped, between words first."""
    widths = [max(map(len, column)) for column in columns]
    longest = [max((len(w) for cell in c for w in cell.split()), default=0) for c in columns]
    room = max(width - len(_GAP) * (len(widths) - 1), len(widths))
    while sum(widths) > room:
        parted = [k for k, size in enumerate(widths) if size > longest[k]] or range(len(widths))
        widths[max(parted, key=widths.__getitem__)] -= 1
    return widths
