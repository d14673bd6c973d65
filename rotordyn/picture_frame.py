"""What pictures of maps and margins share: the frame, the styles and the legend."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Literal, NamedTuple

from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.rotordyn.errors import AnalysisError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Style(NamedTuple):
    """Colour, dashes and marker of a line."""

    color: str
    dashes: str | tuple[int, tuple[int, ...]]
    marker: str


# Colours of Okabe and Ito, told apart with any colour vision and in grey by dashes and markers.
WHIRL_STYLES = {
    "forward": Style("#0072B2", "solid", "^"),
    "backward": Style("#D55E00", (0, (5, 2)), "v"),
    "mixed": Style("#009E73", (0, (6, 2, 1, 2)), "D"),
    "planar": Style("#595959", (0, (1, 1)), "s"),
}


@contextmanager
def picture(path: str | Path, title: str) -> Iterator[tuple[Figure, Axes]]:
    """Give a figure with one frame that is written to a file when the block ends."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    target = Path(path)
    kind = target.suffix.lower().lstrip(".")
    figure = Figure(figsize=(8.0, 5.0), dpi=150, layout="constrained")
    kinds = FigureCanvasAgg(figure).get_supported_filetypes()
    if kind not in kinds:
        raise AnalysisError(f"{target}: suffix {target.suffix!r}; allowed are {sorted(kinds)}")
    axes = figure.add_subplot()
    axes.set_title(fill(title, 60), fontsize=11)
    yield figure, axes
    with replacing(target) as temporary:
        figure.savefig(temporary, format=kind)


def draw_grid(axes: Axes, which: Literal["major", "both"], axis: Literal["both", "x"]) -> None:
    """Draw a grid behind everything."""
    axes.grid(visible=True, which=which, axis=axis, color="#E5E5E5", linewidth=0.6)
    axes.set_axisbelow(True)


def add_legend(figure: Figure, axes: Axes, note: str = "") -> None:
    """Put each label once beside the diagram."""
    from matplotlib.lines import Line2D

    handles, labels = axes.get_legend_handles_labels()
    rows = dict(zip(reversed(labels), reversed(handles), strict=True))
    names = list(dict.fromkeys(labels))
    if note:
        rows[note] = Line2D([], [], linestyle="none")
        names.append(note)
    figure.legend(
        [rows[name] for name in names],
        names,
        loc="outside right upper",
        frameon=False,
        fontsize=8,
    )
