"""How records show themselves, as text and in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

# Rows of a list before the rest is counted.
_MOST = 12
Row = tuple[str, ...]


def percent(value: float) -> str:
    """Return a relative error as text."""
    return f"{100.0 * value:.2g} %" if np.isfinite(value) else "unknown"


def titled(title: str) -> str:
    """Return a title behind a name, nothing for none."""
    return f": {title}" if title else ""


def counted(texts: Sequence[str]) -> list[str]:
    """Return the first texts, and how many more there are."""
    more = len(texts) - _MOST
    return [*texts[:_MOST], *([f"and {more} more"] if more > 0 else [])]


def indented(lines: Sequence[str]) -> list[str]:
    """Return lines two places further in."""
    return [f"  {line}" for line in lines]


def heading(text: str) -> str:
    """Return a heading in HTML."""
    return f"<p><strong>{escape(text)}</strong></p>"


def table(names: Row, rows: Sequence[Row]) -> str:
    """Return a table in HTML; nothing without rows."""
    if not rows:
        return ""
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return (
        f"<table>{f'<thead><tr>{head}</tr></thead>' if names else ''}<tbody>{body}</tbody></table>"
    )
