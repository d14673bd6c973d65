"""Pictures of a sweep: chooses and draws what its cases allow, with the numbers behind them."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.sweep.analysis import (
    SweepAnalysis,
    SweepPictureSettings,
    analyse_sweep,
    document_of,
)
from solidwhirl.sweep.records import BatchRow
from solidwhirl.sweep_pictures.bands import bands_chart
from solidwhirl.sweep_pictures.effects import tornado_chart
from solidwhirl.sweep_pictures.lines import critical_speeds_chart
from solidwhirl.sweep_pictures.margins import draw_margin_maps
from solidwhirl.sweep_pictures.parallel import parallel_page

#: File of the numbers behind the pictures.
DOCUMENT = "sweep.json"
Draw = Callable[[SweepAnalysis, SweepPictureSettings, Path], None]


def draw_batch(
    rows: Sequence[BatchRow], out: Path, *, settings: SweepPictureSettings | None = None
) -> tuple[Path, ...]:
    """Draw all pictures that the rows of a batch allow into a folder.

    Rows are of any number of scenes; those without a sweep have no pictures. Files of the same
    names are replaced.

    Returns
    -------
    tuple of Path
        The files: for each scene `<scene>-critical-speeds.png`, `-tornado.png`, `-parallel.html`,
        `-margins.png` and `-campbell-bands.png`, those that have something to show, then
        `sweep.json`. Nothing is written if no scene has a sweep of two cases that are done.

    Raises
    ------
    SweepPictureError
        If rows of one scene have different parameters, or a parameter asked for does not vary.
    """
    chosen = settings or SweepPictureSettings()
    found = analyse_sweep(rows, chosen)
    if not found:
        return ()
    out.mkdir(parents=True, exist_ok=True)
    written = []
    for sweep in found:
        for name, applies, draw in _PICTURES:
            if applies(sweep):
                path = out / f"{sweep.design.scene}-{name}"
                draw(sweep, chosen, path)
                written.append(path)
    path = out / DOCUMENT
    document = json.dumps(document_of(rows, found, chosen), indent=1, allow_nan=False)
    replace_text(path, document + "\n")
    return (*written, path)


def drawn_before(out: Path) -> tuple[Path, ...]:
    """Return the files of a folder that have names of pictures of sweeps, and `sweep.json`."""
    names = [*(name for name, _, _ in _PICTURES), *_EARLIER]
    found = [path for name in names for path in sorted(out.glob(f"*-{name}"))]
    return (*found, *out.glob(DOCUMENT))


def _drawn(build: Callable[[SweepAnalysis, SweepPictureSettings], Chart]) -> Draw:
    def draw(found: SweepAnalysis, settings: SweepPictureSettings, path: Path) -> None:
        chart = build(found, settings)
        draw_charts([chart], path, chart.title)

    return draw


def _has_bands(found: SweepAnalysis) -> bool:
    return found.bands is not None and bool(np.isfinite(found.bands.frequency_hz.value).any())


# Pictures of earlier releases.
_EARLIER = ("parallel.png",)
# By the end of their names: what they apply to, and who draws them.
_PICTURES: tuple[tuple[str, Callable[[SweepAnalysis], bool], Draw], ...] = (
    ("critical-speeds.png", lambda found: bool(found.tracks), _drawn(critical_speeds_chart)),
    ("tornado.png", lambda found: bool(found.sensitivities), _drawn(tornado_chart)),
    (
        "parallel.html",
        lambda found: bool(found.quantities),
        lambda found, settings, path: replace_text(path, parallel_page(found, settings)),
    ),
    ("margins.png", lambda found: bool(found.maps), draw_margin_maps),
    ("campbell-bands.png", _has_bands, _drawn(bands_chart)),
)
