"""From blocks to HTML: marked-up text, tables, data of charts as JSON."""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

import numpy as np
from markupsafe import Markup, escape

from solidwhirl.core.blocks import WHIRL_SIGNS
from solidwhirl.page.frame.records import Chart, ModeViewer, Picture, Table

_BOLD = re.compile(r"\*\*(.+?)\*\*")
_CODE = re.compile(r"`([^`]+)`")
_NUMBER = re.compile(r"[-+±<>≤≥ ]*\d")
_SIGNS = {sign: whirl for whirl, sign in WHIRL_SIGNS.items()}
_ABSENT = "–"
# Letters beyond which the cells of a column are sentences.
_PROSE = 36


def inline_html(text: str) -> Markup:
    """Mark up one line: **bold**, `code`; everything else shows as it is written."""
    parts = []
    for k, piece in enumerate(_CODE.split(text)):
        if k % 2:
            parts.append(f"<code>{escape(piece)}</code>")
        else:
            parts.append(_BOLD.sub(r"<strong>\1</strong>", str(escape(piece))))
    return Markup("".join(parts))


def text_html(text: str) -> Markup:
    """Mark up paragraphs, parted by blank lines, and lists, whose lines begin with "- "."""
    parts = []
    for block in re.split(r"\n\s*\n", text.strip()):
        for is_list, group in groupby(block.splitlines(), lambda line: line.startswith("- ")):
            if is_list:
                items = "".join(f"<li>{inline_html(line[2:])}</li>" for line in group)
                parts.append(f"<ul>{items}</ul>")
            else:
                parts.append(f"<p>{inline_html(' '.join(group))}</p>")
    return Markup("".join(parts))


def cell_text(value: Any) -> str:
    """Write a cell: floats with five digits, nothing for what is absent."""
    if value is None or (isinstance(value, float | np.floating) and not math.isfinite(value)):
        return _ABSENT
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{value:.5g}"
    return str(value)


def table_html(table: Table) -> Markup:
    """Make a table; columns of numbers stand at the right.

    Raises ValueError if a row has not as many cells as the head.
    """
    rows = [[cell_text(value) for value in row] for row in table.rows]
    for row in rows:
        if len(row) != len(table.head):
            raise ValueError(
                f"table {table.title or list(table.head)}: a row has {len(row)} cells, the head "
                f"{len(table.head)}"
            )
    kinds = [_kind([row[k] for row in rows]) for k in range(len(table.head))]
    head = "".join(
        f'<th scope="col"{kind}>{inline_html(str(title))}</th>'
        for title, kind in zip(table.head, kinds, strict=True)
    )
    body = "".join(
        "<tr>"
        + "".join(f"<td{kind}>{_cell(cell)}</td>" for cell, kind in zip(row, kinds, strict=True))
        + "</tr>"
        for row in rows
    )
    # a head without words would be an empty line
    named = any(str(title) for title in table.head)
    top = f"<thead><tr>{head}</tr></thead>" if named else ""
    return Markup(f"{top}<tbody>{body}</tbody>")


def _kind(cells: Sequence[str]) -> str:
    """Class of a column: numbers stand at the right, and long texts are not squeezed."""
    told = [cell for cell in cells if cell != _ABSENT]
    if told and all(_NUMBER.match(cell) and ", " not in cell for cell in told):
        return ' class="number"'
    if any(len(cell) > _PROSE for cell in told):
        return ' class="prose"'
    if any(cell[:1] in _SIGNS for cell in told):
        return ' class="whole"'
    return ""


def _cell(text: str) -> Markup:
    """A cell; the sign of a whirl before the word stands in its colour."""
    sign = text[:1]
    if sign in _SIGNS and text[1:2] == " ":
        mark = Markup(f'<span class="mark" style="color:var(--{_SIGNS[sign]})">{sign}</span> ')
        return mark + inline_html(text[2:])
    return inline_html(text)


def picture_html(picture: Picture) -> Markup:
    """Make the picture itself, SVG in place and PNG as data."""
    if isinstance(picture.data, bytes):
        data = base64.b64encode(picture.data).decode("ascii")
        return Markup(f'<img alt="{escape(picture.alt)}" src="data:image/png;base64,{data}">')
    return Markup(picture.data)


def data_json(block: Chart | ModeViewer) -> Markup:
    """What the script needs of a chart or viewer, as JSON that is safe inside a script element."""
    data = chart_data(block) if isinstance(block, Chart) else plain(dict(block.data))
    text = json.dumps(data, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    return Markup(text.replace("<", "\\u003c").replace("\u2028", " ").replace("\u2029", " "))


def chart_data(chart: Chart) -> Any:
    """Plain data of a chart, as the script of a page draws it."""
    return plain(
        {
            "traces": list(chart.traces),
            "layout": dict(chart.layout),
            "height": chart.height_px,
            "controls": [asdict(c) for c in chart.controls],
        }
    )


def plain(value: Any) -> Any:
    """Plain data for JSON: arrays as bytes, other numbers with seven digits, nan as null."""
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, float | np.floating):
        return float(f"{value:.7g}") if math.isfinite(value) else None
    if isinstance(value, int | np.integer):
        return int(value)
    if value is None or isinstance(value, str):
        return value
    raise TypeError(f"a page can not hold {type(value).__name__}")


def _array(array: Any) -> Any:
    """An array as base64 of little-endian 4-byte numbers with its shape; texts as lists."""
    if array.dtype.kind in "UOS" or array.ndim == 0:
        return plain(array.tolist())
    kind = "<f4" if array.dtype.kind == "f" else "<i4"
    data = np.ascontiguousarray(array.astype(kind)).tobytes()
    return {
        "dtype": kind[1:],
        "shape": list(array.shape),
        "bdata": base64.b64encode(data).decode("ascii"),
    }
