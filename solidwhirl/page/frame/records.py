"""What a page is made of: what its sections read, and the blocks that they return.

A section is a function ``section(run) -> Section | None`` in `solidwhirl.page.sections.SECTIONS`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from solidwhirl.core.blocks import Table as Table
from solidwhirl.core.blocks import Text as Text
from solidwhirl.core.outcome import PageSection
from solidwhirl.pipeline.run import Results

# Colours that traces and layouts may name. The page puts in those of the light or the dark theme;
# series c0 to c7 are Okabe and Ito's, lightened or darkened to be legible on the paper. A token may
# have an opacity behind it, as in "@forward/0.2".
COLOR_TOKENS = (
    "@ink", "@muted", "@faint", "@paper", "@panel",
    "@forward", "@backward", "@mixed", "@straight", "@band",
    "@good", "@bad",
    "@c0", "@c1", "@c2", "@c3", "@c4", "@c5", "@c6", "@c7",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """What a section reads."""

    #: The run, as arrays
    results: Results
    #: The contents of `results.json`; absent numbers are None
    document: Mapping[str, Any]
    #: The scene file; None where the scene was made in Python
    scene_path: Path | None = None
    #: The command line that repeats the run; empty if not known
    command: str = ""


@dataclass(frozen=True, kw_only=True)
class Listing:
    """Text of a file, as it is written there."""

    #: The text
    text: str
    #: Title of a fold that hides it until it is asked for; empty: always shown
    folded: str = ""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A still picture."""

    #: SVG as text (its colours may be the CSS variables of the page, ``var(--ink)`` for "@ink"), or
    #: the bytes of a PNG
    data: str | bytes
    #: What is to be seen
    caption: str
    #: For those who can't see it
    alt: str
    #: Above the picture
    title: str = ""
    #: Least width; on a narrower screen the picture scrolls sideways. 0: shrinks.
    scroll_px: int = 0
    #: Largest height; a higher picture shrinks. 0: any.
    height_px: int = 0


@dataclass(frozen=True, kw_only=True)
class Toggle:
    """A checkbox over a chart that shows or hides traces."""

    #: Beside the box
    label: str
    #: Indices of the traces
    traces: Sequence[int]
    #: At the start
    shown: bool = True


@dataclass(frozen=True, kw_only=True)
class Option:
    """One entry of a `Choice`."""

    #: In the list
    label: str
    #: Indices of the traces shown with it, beside those that are in no option
    traces: Sequence[int]
    #: Changes of the layout by plotly's dotted names, such as {"yaxis.title.text": "…"}
    layout: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A list over a chart of which one entry is shown: the first at the start.

    A trace shows if every toggle that names it is on, and of every choice that names it in an
    option the chosen one does.
    """

    label: str
    options: Sequence[Option]


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A chart drawn by plotly in the browser."""

    #: Identifier in the page: letters, digits, hyphens; one of its kind
    name: str
    #: Above the chart (in HTML, not in the layout)
    title: str
    #: Below: what is to be seen
    caption: str
    #: For those who can't see it
    alt: str
    #: Plotly traces as plain dictionaries. Numpy arrays stay arrays, which makes the page small;
    #: nan in them is a gap. Colours may be `COLOR_TOKENS`.
    traces: Sequence[Mapping[str, Any]]
    #: What differs from the page's layout, which has fonts, colours, margins, grid, legend above
    #: the chart and automatic margins. Axes need titles with units.
    layout: Mapping[str, Any]
    #: Without the controls
    height_px: int = 420
    #: Above the chart
    controls: Sequence[Toggle | Choice] = ()


@dataclass(frozen=True, kw_only=True)
class ModeViewer:
    """The viewer of mode shapes in 3D, drawn by `shapes.js`.

    The page makes ``<div id=name class="viewer">`` and, when it first comes near the screen (or is
    printed), calls ``solidwhirl.modeViewer(host, data, theme)``. ``theme`` maps color tokens
    without "@" to CSS colours and has ``dark`` (boolean). The function may return an object with
    ``theme(theme)``, called when the theme changes, ``pause()``, called when the viewer leaves the
    screen, and ``resume()``. ``solidwhirl.array(value)`` of `page.js` turns an array of ``data``
    (numpy there) into ``{values: typed array, shape: [...]}``; ``solidwhirl.tokens(value, theme)``
    puts colours in, ``solidwhirl.layout(layout, theme)`` gives the page's layout,
    ``solidwhirl.config`` plotly's configuration. The host has the attribute ``data-drawn`` once
    everything in it is drawn.
    """

    #: Identifier in the page
    name: str
    #: As those of a chart
    title: str
    caption: str
    alt: str
    #: Plain data and numpy arrays, as `shapes.js` reads them
    data: Mapping[str, Any]
    #: Of the host, at least
    height_px: int = 560


Single = Text | Table | Chart | ModeViewer | Picture | Listing


@dataclass(frozen=True, kw_only=True)
class Row:
    """Blocks side by side where the screen is wide enough, else one under the other."""

    blocks: Sequence[Single]


Block = Single | Row


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the page."""

    #: Anchor: letters, digits, hyphens; one of its kind
    name: str
    #: Heading, which also stands in the table of contents
    title: str
    #: From top to bottom
    blocks: Sequence[Block]
    #: One sentence under the heading; empty: none
    note: str = ""

    @classmethod
    def at(cls, place: PageSection, blocks: Sequence[Block]) -> Section:
        """Return what stands at a place that an analysis may name too."""
        return cls(name=place.name, title=place.title, blocks=blocks, note=place.note)

    @property
    def every_block(self) -> tuple[Single, ...]:
        """All blocks, those of rows one by one."""
        rows = ((b.blocks if isinstance(b, Row) else (b,)) for b in self.blocks)
        return tuple(block for row in rows for block in row)
