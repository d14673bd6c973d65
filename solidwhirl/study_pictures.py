"""Pictures of a study: error against time and memory, convergence, estimates, the map of beams."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.pictures.labels import spread
from solidwhirl.rotordyn.picture_frame import (
    MINOR_PAD_PT,
    SMALL_PT,
    TEXT_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    USUAL_HEIGHT_MM,
    add_legend,
    draw_grid,
    new_figure,
    number_text,
    styled,
    write_figure,
)
from solidwhirl.study_document import Study
from solidwhirl.study_styles import (
    FARTHEST,
    LIMITS,
    axis_label,
    drawn_error,
    drawn_series,
    label_of,
    map_grid,
    modes_of,
    series_style,
)
from solidwhirl.study_table import StudyRow, StudyTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ERROR = "largest relative error\nof all branches and speeds [1]"
_LEAST_ERROR = 1e-12
# Axes that span less than the first are widened; below the second they have more numbers.
_SHORT, _PLAIN = 8.0, 200.0
# Height of a line of letters over that of a frame, width of the picture of one map, and the error
# above which cells are bright.
_LETTER, _ONE_MAP_MM, _BRIGHT = 0.065, 110.0, 5e-3
Value = Callable[[StudyRow], float]


@styled
def draw_study(study: Study, document: Mapping[str, Any], out: Path) -> tuple[Path, ...]:
    """Draw all pictures of a study.

    Parameters
    ----------
    study
        The study.
    document
        From `solidwhirl.study_document.study_document`.
    out
        The folder; files of earlier runs are replaced.

    Returns
    -------
    The files, without those that have nothing to show.
    """
    title = study.scene.title or study.scene.name
    table = study.table
    paths = []
    for name, key, label, front in (
        ("time", "cpu_s", "processor time, start of the program included [s]", table.time_front),
        ("memory", "peak_memory_gib", "peak memory [GiB]", table.memory_front),
    ):
        path = out / f"error-{name}.png"
        _draw_cost(table, key, label, front, path, f"Error against {name}: {title}")
        paths.append(path)
    _draw_convergence(table, out / "convergence.png", f"Convergence: {title}")
    _draw_estimates(table, out / "estimates.png", f"Estimated against true error: {title}")
    paths += [out / "convergence.png", out / "estimates.png"]
    if document["beam_map"]:
        _draw_maps(document["beam_map"], out / "beam-map.png")
        paths.append(out / "beam-map.png")
    return tuple(paths)


def _draw_cost(
    table: StudyTable, key: str, label: str, front: Sequence[str], path: Path, title: str
) -> None:
    """Error against one cost, with the Pareto front."""
    figure = new_figure(path)
    axes = figure.add_subplot()
    _draw_series(axes, table, lambda r: r.measured(key), lambda r: drawn_error(r, table))
    rows = {r.outcome.case.name: r for r in table.rows}
    steps = [(rows[n].measured(key), drawn_error(rows[n], table)) for n in front]
    if steps:
        cost, error = np.array(steps).T
        axes.step(cost, error, where="post", color="#595959", linewidth=1.2, marker="o",
                  markersize=8.5, markerfacecolor="none", label="Pareto front")  # fmt: skip
    _draw_floor(axes, table)
    axes.set_xlabel(label)
    axes.set_ylabel(_ERROR)
    _log(axes, "xy")
    figure.suptitle(fill(title, 80), fontsize=TITLE_PT)
    add_legend(figure, (axes,), place="outside right center")
    write_figure(figure, path)


def _draw_series(axes: Axes, table: StudyTable, x: Value, y: Value, *, line: bool = False) -> None:
    for series, rows in drawn_series(table.rows).items():
        style = series_style(series)
        place, value = (np.array([v(r) for r in rows]) for v in (x, y))
        order = np.argsort(place)
        axes.plot(place[order], value[order], color=style.color, marker=style.marker,
                  markersize=4.5, markerfacecolor="none" if style.hollow else style.color,
                  linewidth=0.8, linestyle=("--" if style.hollow else "-") if line else "none",
                  label=label_of(series))  # fmt: skip


def _draw_floor(axes: Axes, table: StudyTable) -> None:
    if table.floor > 0.0:
        axes.axhline(table.floor, color="#999999", linestyle=(0, (1, 2)), linewidth=1.2,
                     label="estimated error of the reference")  # fmt: skip


def _draw_convergence(table: StudyTable, path: Path, title: str) -> None:
    """Error, time and memory over the unknowns with slopes; error over the number of modes."""
    figure = new_figure(path, TWO_COLUMNS_MM, 165.0)
    frames = figure.subplots(2, 2)
    panels: tuple[tuple[Axes, str, str, Value], ...] = (
        (frames[0, 0], "error", _ERROR, lambda r: drawn_error(r, table)),
        (frames[0, 1], "cpu_s", "processor time\nwithout start [s]", lambda r: r.solve_cpu_s),
        (
            frames[1, 0],
            "memory_gib",
            "peak memory\nbeyond the program's own [GiB]",
            lambda r: r.solve_memory_gib,
        ),
    )
    for axes, quantity, label, value in panels:
        ends = _draw_over_unknowns(axes, table, quantity, value)
        axes.set_ylabel(label)
        axes.set_xlabel("unknowns before reduction [1]")
        _log(axes, "xy")
        _write_slopes(axes, ends)
    _draw_floor(frames[0, 0], table)
    _draw_modes(frames[1, 1], table)
    figure.suptitle(fill(title, 80), fontsize=TITLE_PT)
    add_legend(figure, list(frames.ravel()), place="outside lower center", columns=3)
    write_figure(figure, path)


def _draw_over_unknowns(
    axes: Axes, table: StudyTable, quantity: str, value: Value
) -> list[tuple[float, float, float, str]]:
    """Points of the meshes and the power laws through them; right ends, slopes and colours."""
    ends = []
    for series, rows in drawn_series(table.rows).items():
        points = [
            (r.measured("unknowns"), value(r))
            for r in rows
            if r.outcome.case.group in ("mesh", "dial", "beam") and value(r) > 0.0
        ]
        if not points:
            continue
        style = series_style(series)
        fitted = [s for s in table.slopes if (s.series, s.quantity) == (series, quantity)]
        unknowns, values = np.array(points).T
        axes.plot(unknowns, values, linestyle="none", color=style.color, marker=style.marker,
                  markersize=4.5, markerfacecolor="none" if style.hollow else style.color,
                  label=label_of(series))  # fmt: skip
        for slope in fitted:
            along = np.array([unknowns.min(), unknowns.max()])
            law = slope.slope.factor * along**slope.slope.slope
            axes.plot(along, law, color=style.color, linewidth=1.0,
                      linestyle="--" if style.hollow else "-")  # fmt: skip
            ends.append((float(along[1]), float(law[1]), slope.slope.slope, style.color))
    return ends


def _write_slopes(axes: Axes, ends: Sequence[tuple[float, float, float, str]]) -> None:
    """Exponents beside the frame, each with a line to the end of its power law."""
    low, high = np.log(axes.get_ylim())
    heights = [(np.log(value) - low) / (high - low) for _, value, _, _ in ends]
    places = spread(heights, [_LETTER] * len(ends))
    for (unknowns, value, slope, color), place in zip(ends, places, strict=True):
        axes.annotate(f"{slope:.2f}".replace("-", "\u2212"), (unknowns, value),
                      xytext=(1.03, place), textcoords="axes fraction", fontsize=SMALL_PT,
                      color=color, va="center", annotation_clip=False,
                      arrowprops={"arrowstyle": "-", "color": color, "linewidth": 0.5,
                                  "shrinkA": 0.0, "shrinkB": 3.0})  # fmt: skip


def _draw_modes(axes: Axes, table: StudyTable) -> None:
    """Error over the number of fixed-interface modes."""
    for series, rows in drawn_series(table.rows).items():
        if series[2] != "modes":
            continue
        style = series_style(series)
        count = [modes_of(r) for r in rows]
        axes.plot(count, [drawn_error(r, table) for r in rows], color=style.color, marker="P",
                  markerfacecolor="none", markersize=5, linewidth=0.8, linestyle="--",
                  label=label_of(series))  # fmt: skip
    _draw_floor(axes, table)
    axes.set_xlabel("fixed-interface modes [1]")
    axes.set_ylabel(_ERROR)
    _log(axes, "y")


def _draw_estimates(table: StudyTable, path: Path, title: str) -> None:
    """Estimated over true error of every case, and the lines where the ratio is 1 and 10."""
    figure = new_figure(path, TWO_COLUMNS_MM, USUAL_HEIGHT_MM + 8.0)
    axes = figure.add_subplot()
    for series, rows in drawn_series(table.rows).items():
        style = series_style(series)
        points = [(max(r.campbell.true, _LEAST_ERROR), r.campbell.estimate) for r in rows
                  if np.isfinite(r.campbell.estimate)]  # fmt: skip
        if points:
            true, estimate = np.array(points).T
            axes.plot(true, estimate, color=style.color, marker=style.marker, linestyle="none",
                      markerfacecolor="none" if style.hollow else style.color, markersize=4.5,
                      label=label_of(series))  # fmt: skip
    _log(axes, "xy")
    low, high = axes.get_xlim()
    for ratio, dashes in ((1.0, "solid"), (10.0, (0, (5, 3)))):
        axes.plot([low, high], [ratio * low, ratio * high], color="#595959", linewidth=1.0,
                  linestyle=dashes, label=f"estimate = {ratio:g} × error")  # fmt: skip
    if table.floor > 0.0:
        axes.axvline(table.floor, color="#999999", linestyle=(0, (1, 2)), linewidth=1.2,
                     label="estimated error of the reference")  # fmt: skip
    axes.set_xlim(low, high)
    axes.set_xlabel(_ERROR.replace("\n", " "))
    axes.set_ylabel("largest estimated relative error [1]")
    figure.suptitle(fill(title, 80), fontsize=TITLE_PT)
    add_legend(figure, (axes,), place="outside right center")
    write_figure(figure, path)


def _draw_maps(maps: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Error of the beam level over two ratios of a disk, a frame for each map."""
    from matplotlib.colors import LogNorm

    width = TWO_COLUMNS_MM if len(maps) > 1 else _ONE_MAP_MM
    figure = new_figure(path, width, 92.0)
    frames = figure.subplots(1, len(maps), squeeze=False)[0]
    shown: Any = None
    limits: dict[str, Any] = {}
    for axes, found in zip(frames, maps, strict=True):
        x, y, error = map_grid(found["points"])
        shown = axes.pcolormesh(
            _edges(x), _edges(y), error, cmap="cividis",
            norm=LogNorm(1e-4, FARTHEST), edgecolors="white", linewidth=0.5,
        )  # fmt: skip
        _write_values(axes, x, y, error, shown)
        if min(error.shape) > 1 and np.isfinite(error).any():
            limits |= {row.get_label(): row for row in _draw_limits(axes, x, y, error)}
        for failed in (p for p in found["points"] if p["status"] == "failed"):
            axes.text(
                failed["x"], failed["y"], "failed", ha="center", va="center", fontsize=SMALL_PT
            )
        axes.set(xscale="log", yscale="log")
        axes.set_facecolor("#E5E5E5")
        axes.set_xticks(x, [f"{v:.3g}" for v in x], minor=False)
        axes.set_yticks(y, [f"{v:.3g}" for v in y], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_yticks([], minor=True)
        axes.set_xlabel(axis_label(found["x_name"]))
        axes.set_ylabel(axis_label(found["y_name"]))
        blank = any(p["status"] == "absent" for p in found["points"])
        note = " (grey: web as wide as the rim)" if blank else ""
        axes.set_title(found["map"] + note, fontsize=TEXT_PT)
    figure.colorbar(shown, ax=frames, label="largest relative error of beams\n"
                    "in the first two whirl pairs [1]", extend="both")  # fmt: skip
    title = "Beams against solids: frequencies of a disk on a shaft, error in % in the cells"
    figure.suptitle(title, fontsize=TITLE_PT)
    if limits:
        figure.legend(list(limits.values()), list(limits), loc="outside lower center", ncols=2,
                      frameon=False, fontsize=SMALL_PT)  # fmt: skip
    write_figure(figure, path)


def _edges(places: Sequence[float]) -> Any:
    """Edges of cells around places, in the middle of neighbours in the logarithm."""
    logs = np.log(places)
    if len(logs) == 1:
        return np.exp([logs[0] - 0.2, logs[0] + 0.2])
    middles = 0.5 * (logs[1:] + logs[:-1])
    ends = [2.0 * logs[0] - middles[0]], [2.0 * logs[-1] - middles[-1]]
    return np.exp(np.concatenate([ends[0], middles, ends[1]]))


def _write_values(
    axes: Axes, x: Sequence[float], y: Sequence[float], error: Any, shown: Any
) -> None:
    """The error in per cent in each cell, black on bright and white on dark colours."""
    from matplotlib.patheffects import withStroke

    for row, height in enumerate(y):
        for column, place in enumerate(x):
            value = error[row, column]
            if not np.isfinite(value):
                continue
            text = "> 25" if value >= FARTHEST else f"{100.0 * value:.2g}"
            # the colour of the cell around the letters keeps contours off them
            around = withStroke(linewidth=2.5, foreground=shown.to_rgba(value))
            axes.text(place, height, text, ha="center", va="center", fontsize=SMALL_PT, zorder=4,
                      color="black" if value > _BRIGHT else "white",
                      path_effects=[around])  # fmt: skip


def _draw_limits(axes: Axes, x: Sequence[float], y: Sequence[float], error: Any) -> list[Any]:
    """Contours at 1 % and 5 %; their rows in a legend."""
    from matplotlib.lines import Line2D

    low, high = np.nanmin(error), np.nanmax(error)
    rows = []
    for limit, color, dashes in zip(LIMITS, ("#D55E00", "#000000"), ("-", "--"), strict=True):
        if low < limit < high:
            # in the logarithm, so that it lies between cells where it should
            axes.contour(x, y, np.log10(error), [np.log10(limit)], colors=color,
                         linestyles=dashes, linewidths=1.5)  # fmt: skip
            rows.append(Line2D([], [], color=color, linestyle=dashes, linewidth=1.5,
                               label=f"error {100.0 * limit:.0f} %"))  # fmt: skip
    return rows


def _log(axes: Axes, which: str) -> None:
    """Logarithmic axes with plain numbers, also where they span less than a decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    for name in which:
        getattr(axes, f"set_{name}scale")("log")
        low, high = getattr(axes, f"get_{name}lim")()
        if high < _SHORT * low:
            wider = (_SHORT * low / high) ** 0.5
            getattr(axes, f"set_{name}lim")(low / wider, high * wider)
        axis = getattr(axes, f"{name}axis")
        if high < _PLAIN * low:
            axis.set_major_formatter(FuncFormatter(_plain_number))
            axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
            axis.set_minor_formatter(FuncFormatter(_plain_number))
            axis.set_tick_params(which="minor", pad=MINOR_PAD_PT)
    draw_grid(axes, "both", "both")


def _plain_number(value: float, _: object) -> str:
    return number_text(value)
