"""What results are told with beside charts: texts and tables, whoever sets them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.modes.kinds import motion_words
from solidwhirl.rotordyn.plots.chart import Chart

#: Signs of the directions of whirl and kinds of motion, so that colour alone tells nothing.
WHIRL_SIGNS = {
    **{"forward": "●", "backward": "□", "mixed": "◆", "straight": "◇"},
    **{"torsional": "△", "axial": "▷", "coupled": "☆", "disk": "◎"},
}


@dataclass(frozen=True, kw_only=True)
class Text:
    """Paragraphs and lists."""

    #: Paragraphs parted by blank lines; lines that begin with "- " are a list. **bold**, `code` and
    #: nothing else is marked up; HTML in it shows as it is written.
    text: str
    #: "plain"; "note" and "warning" stand in a box with their name
    kind: Literal["plain", "note", "warning"] = "plain"


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; columns whose cells are all numbers, or begin with one, stand at the right."""

    #: Titles of the columns, with units in brackets
    head: Sequence[str]
    #: Cells as text, marked up as in `Text`; floats are written with five digits, None as "–", True
    #: and False as "yes" and "no"
    rows: Sequence[Sequence[Any]]
    #: Above and below
    title: str = ""
    caption: str = ""
    #: Title of a fold that hides the table until it is asked for; empty: always shown
    folded: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class TurningMode:
    """A mode in the frame that turns with its body."""

    label: str
    hertz: float
    #: "backward", "forward", or "straight" of a standing one
    whirl: str
    #: Waves n around the circumference: points move by Re[A e^{inθ} e^{iφ}] at the phase φ
    order: int
    #: A, (p, 3), along r, θ, z of a meridian, along x, y, z of a sector (whose copy k turns with
    #: it, and has the angle 2πk/N for θ)
    displacement: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False)
class TurningModes:
    """Modes of one body that are shown in space, turning."""

    #: As of a chart: identifier, title, what is to be seen, and the same for those who can't
    name: str
    title: str
    caption: str
    alt: str
    body: str
    #: (p, 2) z, r of a meridian or (p, 3) x, y, z of a sector, and edges or triangles of it
    points_m: FloatArray
    cells: IntArray
    #: Sectors; None of a meridian
    copies: int | None
    #: What is chosen first, and the modes behind it
    states: Sequence[tuple[str, Sequence[TurningMode]]]


@dataclass(frozen=True, kw_only=True, eq=False)
class CutBody:
    """Half of a body with a value on its surface and on its cut face."""

    #: In the list of bodies
    label: str
    #: (p, 3), (t, 3), and (p,)
    points_m: FloatArray
    triangles: IntArray
    values: FloatArray
    #: What the values are, their unit, and the largest of the whole body
    quantity: str
    unit: str
    largest: float


@dataclass(frozen=True, kw_only=True, eq=False)
class CutBodies:
    """Bodies that are cut open, shown in space, coloured by a value."""

    #: As of a chart: identifier, title, what is to be seen, and the same for those who can't
    name: str
    title: str
    caption: str
    alt: str
    bodies: Sequence[CutBody]


#: What a plan is told with: a paragraph, lines of a list, a table.
Part = str | Sequence[str] | Table
#: What an analysis tells its results with.
AnalysisBlock = Text | Table | Chart | TurningModes | CutBodies


def numbers(values: Any) -> FloatArray:
    """Return numbers of a document as an array; None becomes nan."""
    return np.asarray(values, dtype=float)


def whirl_text(whirl: str | None) -> str:
    """Word of a whirl (None and "" where there is none) with its sign before it."""
    return f"{WHIRL_SIGNS.get(whirl or 'straight', WHIRL_SIGNS['straight'])} {whirl or 'none'}"


def motion_text(entry: Mapping[str, Any]) -> str:
    """Say how a mode moves, with the sign of its whirl; `entry`: plain data with its shares."""
    words = motion_words(entry["whirl"], numbers(list(entry["shares"].values())))
    return f"{WHIRL_SIGNS[entry['whirl']]} {words}"


def margin_words(margin: float) -> str:
    """Return (N_c − N_op) / N_op in words, such as "66.3 % below", or "inside"."""
    if margin == 0.0:
        return "inside"
    size = 100.0 * abs(margin)
    said = f"{size:.1f}" if round(size, 1) > 0.0 else "less than 0.1"
    return f"{said} % {'above' if margin > 0.0 else 'below'}"


def warning(lines: Sequence[str]) -> list[Text]:
    """Return lines in a box; nothing where there are none."""
    said = "\n".join(f"- {line}" for line in lines)
    return [Text(text=said, kind="warning")] if lines else []
