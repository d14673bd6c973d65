"""What the pictures of a study and its page share: series, colours, points and labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.study_document import series_name, settings_text
from solidwhirl.study_table import StudyRow, StudyTable

FloatArray = npt.NDArray[np.float64]
Series = tuple[str, int | None, str]


class SeriesStyle(NamedTuple):
    """How a series is drawn.

    Attributes
    ----------
    color
        Of Okabe and Ito, told apart with any colour vision.
    marker, symbol
        The same shape for matplotlib and for plotly.
    hollow
        Whether only the outline is drawn.
    """

    color: str
    marker: str
    symbol: str
    hollow: bool


_COLORS = {
    ("harmonic", 2): ("#56B4E9", "o", "circle"),
    ("harmonic", 3): ("#0072B2", "s", "square"),
    ("harmonic", 4): ("#CC79A7", "^", "triangle-up"),
    ("harmonic", None): ("#009E73", "D", "diamond"),
    ("solid", 2): ("#D55E00", "v", "triangle-down"),
    ("beam", None): ("#000000", "X", "x"),
}
_OTHER = ("#7F7F7F", "P", "cross")
_HOLLOW = ("uniform", "modes")
#: Contours of the maps.
LIMITS = (0.01, 0.05)
#: Beyond it beams and solids are no longer paired.
FARTHEST = 0.25


def series_style(series: Series) -> SeriesStyle:
    """Return how a series is drawn: colour by level and order, hollow for the second ladder."""
    level, order, ladder = series
    color, marker, symbol = _COLORS.get((level, order), _OTHER)
    if ladder == "modes":
        marker, symbol = "P", "cross"
    return SeriesStyle(color, marker, symbol, ladder in _HOLLOW)


def drawn_series(rows: Sequence[StudyRow]) -> dict[Series, list[StudyRow]]:
    """Return the rows that have an error to be drawn, by series."""
    found: dict[Series, list[StudyRow]] = {}
    for row in rows:
        if row.comparable:
            found.setdefault(row.series, []).append(row)
    return found


def drawn_error(row: StudyRow, table: StudyTable) -> float:
    """Return the error of a row, no smaller than what the truth itself is wrong by."""
    return max(row.campbell.true, table.floor)


def row_text(row: StudyRow) -> str:
    """Return what a reader wants to know about a point, in lines with <br> between."""
    case = row.outcome.case
    lines = [
        f"<b>{case.name}</b>",
        settings_text(case),
        f"{row.measured('unknowns'):.0f} unknowns",
        f"{row.measured('cpu_s'):.2f} s CPU, {row.measured('peak_memory_gib'):.3f} GiB",
        f"error {row.campbell.true:.2e}, estimate {row.campbell.estimate:.2e}",
        f"critical speeds {row.critical_speeds.true:.2e}, "
        f"estimate {row.critical_speeds.estimate:.2e}",
    ]
    return "<br>".join(line for line in lines if line).replace("nan", "none")


def modes_of(row: StudyRow) -> float:
    """Return the fixed-interface modes of a row, nan where they are not given."""
    value = row.outcome.case.settings.get("modes")
    return float(value) if isinstance(value, int | float) else float("nan")


def axis_label(name: str) -> str:
    """Return a label for an axis of a map."""
    return name.replace("_over_", " / ").replace("_", " ") + " [1]"


def label_of(series: Series) -> str:
    """Return the name of a series in a legend."""
    return series_name(series)


def map_grid(points: Sequence[Mapping[str, Any]]) -> tuple[list[float], list[float], FloatArray]:
    """Return the axes of a map and its errors (y by x): nan for none, 0.25 for unpaired."""
    x = sorted({p["x"] for p in points})
    y = sorted({p["y"] for p in points})
    error = np.full((len(y), len(x)), np.nan)
    for p in points:
        if p["status"] == "done":
            found = p["relative_error"]
            value = FARTHEST if found is None else min(found, FARTHEST)
            error[y.index(p["y"]), x.index(p["x"])] = value
    return x, y, error
