"""What all pictures share: sizes, fonts, colours, dashes and markers, and writing the file.

matplotlib is imported inside the functions that draw.
"""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import wraps
from pathlib import Path
from textwrap import fill
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec, TypeAlias, TypeVar

from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.plots.chart import WHIRL_LOOKS, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

_P = ParamSpec("_P")
_R = TypeVar("_R")
Dashes: TypeAlias = str | tuple[int, tuple[int, ...]]

#: Widths of a picture in one and in two columns of a journal, and the height most have, mm.
ONE_COLUMN_MM, TWO_COLUMNS_MM, USUAL_HEIGHT_MM = 88.0, 180.0, 112.0
#: Sizes of letters at these widths, points.
TITLE_PT, TEXT_PT, SMALL_PT = 9.5, 8.0, 7.0
#: Letters of small print across a figure of two columns
LETTERS = 118
#: Distance of the numbers of minor ticks, which are shorter, so that all stand in one line.
MINOR_PAD_PT = 5.0
#: Lines of the grid, and of what stays in the background.
GRID_COLOR, QUIET_COLOR = "#E5E5E5", "#666666"
_INCH_MM = 25.4
#: Digits of an exponent.
SUPERSCRIPTS = MappingProxyType(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
_THIN_SPACE, _MINUS = "\u2009", "\u2212"
# Numbers from here on have groups of digits, or below here a power of ten; and the ratio of the
# ends of a logarithmic axis beyond which powers of ten alone are named.
_GROUPED, _SMALL_NUMBER, _DECADES = 1e4, 1e-3, 2e3
# Fonts are embedded as outlines with their names in PDF, and text stays text in SVG; the salt
# makes two drawings of one picture the same file. A dollar in a name or title is a dollar.
_SETTINGS = MappingProxyType(
    {
        "font.size": TEXT_PT,
        "axes.titlesize": TITLE_PT,
        "axes.labelsize": TEXT_PT,
        "xtick.labelsize": SMALL_PT,
        "ytick.labelsize": SMALL_PT,
        "legend.fontsize": SMALL_PT,
        "axes.linewidth": 0.7,
        "axes.formatter.limits": (-4, 7),
        "axes.formatter.use_mathtext": True,
        "text.parse_math": False,
        "hatch.linewidth": 0.5,
        "pdf.fonttype": 42,
        "svg.fonttype": "none",
        "svg.hashsalt": "solidwhirl",
    }
)
_NOT_OF_PICTURES = ("backend", "backend_fallback", "interactive", "toolbar", "timezone")
# What the formulas of matplotlib's own numbers consist of.
_FORMULA = re.compile(r"\^\{(?P<power>[^}]*)\}|\\times|\\mathdefault|[${}]")
# Neither file says when it was drawn.
_UNDATED: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


class Style(NamedTuple):
    """Colour, dashes and marker of a line, and whether the marker is open."""

    color: str
    dashes: Dashes
    marker: str
    is_open: bool = False

    @property
    def face(self) -> str:
        """Colour inside the marker."""
        return "white" if self.is_open else self.color


#: Colours of Okabe and Ito for things of equal rank, such as bodies, nodes and bearings.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#7F7F7F")


_COLORS_OF = MappingProxyType(
    {
        "ink": "#000000", "muted": "#7F7F7F", "faint": "#EFEFEF", "paper": "#FFFFFF",
        "forward": "#0072B2", "backward": "#D55E00", "mixed": "#666666", "straight": "#999999",
        "band": "#B9D9EA", "good": "#009E73", "bad": "#D55E00",
        **{f"c{k}": color for k, color in enumerate(COLORS)},
    }
)  # fmt: skip
#: Dashes of matplotlib by those of `Look`.
DASHES_OF: MappingProxyType[str, Dashes] = MappingProxyType(
    {
        "": "none", "solid": "solid", "dash": (0, (5, 2)), "dot": (0, (1, 1)),
        "dashdot": (0, (6, 2, 1, 2)), "longdash": (0, (8, 2)),
        "longdashdot": (0, (8, 2, 1, 2)),
    }
)  # fmt: skip
_MARKERS_OF = MappingProxyType(
    {
        "": "", "circle": "o", "square": "s", "diamond": "D", "triangle-up": "^", "x": "X",
        "triangle-down": "v", "cross": "P", "star": "*", "pentagon": "p", "triangle-left": "<",
        "triangle-right": ">", "x-thin": "x", "line-ns": "|", "hexagon": "h",
    }
)  # fmt: skip


def style_of(look: Look) -> Style:
    """Return a look with the colours, dashes and markers of matplotlib."""
    name, is_open = look.mark.removesuffix("-open"), look.mark.endswith("-open")
    return Style(color_of(look)[0], DASHES_OF[look.dash], _MARKERS_OF[name], is_open)


def color_of(look: Look) -> tuple[str, float]:
    """Return the colour and the opacity of a look."""
    name, _, opacity = look.color.partition("/")
    return _COLORS_OF.get(name.removeprefix("@"), name), float(opacity or 1.0)


#: Colours, dashes and markers of the directions of whirl.
WHIRL_STYLES = {whirl: style_of(look) for whirl, look in WHIRL_LOOKS.items()}


def in_style() -> AbstractContextManager[None]:
    """Give a block in which matplotlib has the settings of all pictures, and none of the user's."""
    named = None if "matplotlib" in sys.modules else os.environ.pop("MPLBACKEND", None)
    import matplotlib

    if named:  # a backend for windows, which need not exist for files
        os.environ["MPLBACKEND"] = named
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = named
    given = {k: v for k, v in matplotlib.rcParamsDefault.items() if k not in _NOT_OF_PICTURES}
    return matplotlib.rc_context({**given, **_SETTINGS})


def styled(draw: Callable[_P, _R]) -> Callable[_P, _R]:
    """Make a function draw with the settings of all pictures."""

    @wraps(draw)
    def drawn(*arguments: _P.args, **options: _P.kwargs) -> _R:
        with in_style():
            return draw(*arguments, **options)

    return drawn


def new_figure(
    path: str | Path, width_mm: float = TWO_COLUMNS_MM, height_mm: float = USUAL_HEIGHT_MM
) -> Figure:
    """Return an empty figure for a picture file: 200 dots per inch, constrained layout.

    Raises AnalysisError if the suffix is not a kind of picture that can be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    size = (width_mm / _INCH_MM, height_mm / _INCH_MM)
    figure = Figure(figsize=size, dpi=200, layout="constrained")
    kinds = FigureCanvasAgg(figure).get_supported_filetypes()
    suffix = Path(path).suffix
    if suffix.lower().lstrip(".") not in kinds:
        raise AnalysisError(f"{path}: suffix {suffix!r}; allowed are {sorted(kinds)}")
    return figure


def write_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure to its picture file, which is replaced when the new one is complete.

    The suffix chooses the kind. Fonts are embedded, text in SVG stays text, and the same figure
    gives the same file.
    """
    target = Path(path)
    kind = target.suffix.lower().lstrip(".")
    with replacing(target) as temporary, in_style():
        _without_formulas(figure)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Glyph .* missing")  # drawn as a box
            if kind == "png" and (layout := figure.get_layout_engine()):
                # drawn with the figure's own renderer: laid out here, it is not drawn twice
                layout.execute(figure)
                figure.set_layout_engine(None)
            figure.savefig(temporary, format=kind, metadata=_UNDATED.get(kind))


def _without_formulas(figure: Figure) -> None:
    """Let axes that matplotlib numbers itself write powers of ten in plain letters."""
    from matplotlib.ticker import LogFormatterMathtext, ScalarFormatter

    def write_plainly(formatter: Any) -> None:
        ticks, offset = formatter.format_ticks, formatter.get_offset
        formatter.format_ticks = lambda values: [plain_power(text) for text in ticks(values)]
        formatter.get_offset = lambda: plain_power(offset())

    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        for found in (axis.get_major_formatter(), axis.get_minor_formatter()):
            if isinstance(found, LogFormatterMathtext | ScalarFormatter):
                write_plainly(found)


def plain_power(formula: str) -> str:
    r"""Return a formula of matplotlib, `$\mathdefault{2\times10^{-3}}$`, as 2×10⁻³."""

    def plain(found: re.Match[str]) -> str:
        if found["power"] is not None:
            return found["power"].replace(_MINUS, "-").translate(SUPERSCRIPTS)
        return "×" if found[0] == "\\times" else ""

    return _FORMULA.sub(plain, formula)


@contextmanager
def picture(
    path: str | Path,
    title: str,
    height_mm: float = USUAL_HEIGHT_MM,
    letters: int = 60,
    width_mm: float = TWO_COLUMNS_MM,
) -> Iterator[tuple[Figure, Axes]]:
    """Give a figure with one frame that is written to a file when the block ends.

    Lines of its title have at most so many letters.
    """
    with in_style():
        figure = new_figure(path, width_mm, height_mm)
        axes = figure.add_subplot()
        axes.set_title(fill(title, letters), fontsize=TITLE_PT)
        yield figure, axes
        write_figure(figure, path)


# Letters that a mark takes beside its label.
_BEFORE_LABEL = 8


def add_legend(
    figure: Figure,
    frames: Sequence[Axes],
    note: str = "",
    place: str = "outside right upper",
    columns: int = 1,
) -> None:
    """Put each label of some frames once beside them, lines of a note below; nothing if none.

    The place is in the words of matplotlib; `columns` are as many as long labels leave.
    """
    from matplotlib.lines import Line2D

    rows: dict[str, Any] = {}
    for axes in frames:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            rows.setdefault(label, handle)
    nothing, lines = Line2D([], [], linestyle="none"), note.splitlines()
    if rows or lines:
        handles = [*rows.values(), *[nothing for _ in lines]]
        widest = max(map(len, (*rows, *lines))) + _BEFORE_LABEL
        columns = max(1, min(columns, LETTERS // widest))
        figure.legend(handles, [*rows, *lines], loc=place, ncols=columns, frameon=False,
                      fontsize=SMALL_PT)  # fmt: skip


def thousands(value: float, _: object = None) -> str:
    """Return a number for an axis of speeds: from 10 000 on its digits stand in groups of three."""
    if abs(value) < _GROUPED:
        return f"{value:.6g}".replace("-", _MINUS)
    return f"{value:,.0f}".replace(",", _THIN_SPACE).replace("-", _MINUS)


def number_text(value: float, digits: int = 3) -> str:
    """Return a number as it is printed, such as 5.01×10⁸, without zeros at the end."""
    text = f"{value:.{digits}g}"
    if "e" in text or 0.0 < abs(value) < _SMALL_NUMBER:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        if "." in mantissa:
            mantissa = mantissa.rstrip("0").rstrip(".")
        power = f"10{str(int(exponent)).translate(SUPERSCRIPTS)}"
        text = power if mantissa == "1" else f"{mantissa}×{power}"
    return text.replace("-", _MINUS)


def name_speeds(axis: Axis) -> None:
    """Write the numbers of an axis of speeds in rpm with groups of three digits.

    Its limits are set. Between the powers of ten of a logarithmic one 2 and 5 are named as well, if
    it has three or fewer.
    """
    from matplotlib.ticker import FuncFormatter, LogFormatter

    axis.set_major_formatter(FuncFormatter(thousands))
    low, high = axis.get_view_interval()
    if axis.get_scale() != "log":
        return
    if high > _DECADES * low:
        axis.set_minor_formatter(LogFormatter(labelOnlyBase=True))
        return

    def between(value: float, _: object) -> str:
        return thousands(value) if f"{value:e}"[0] in "25" else ""

    axis.set_minor_formatter(FuncFormatter(between))
    axis.set_tick_params(which="minor", pad=MINOR_PAD_PT, labelsize=SMALL_PT)


def mode_name(numbers: Sequence[int] | None, mode: int) -> str:
    """Return what a mode at a place from 0 is called; 0 is no number, None counts the modes."""
    if numbers is None:
        return str(mode + 1)
    return str(numbers[mode]) if numbers[mode] else "–"
