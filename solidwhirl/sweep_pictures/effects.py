"""Tornado of a sweep: how strongly each parameter moves each result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.plots.frame import (
    SMALL_PT,
    TWO_COLUMNS_MM,
    add_legend,
    draw_grid,
    new_figure,
    number_text,
    styled,
    write_figure,
)
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.labels import unit_of, wrapped
from solidwhirl.sweep.sensitivity import Sensitivity
from solidwhirl.sweep_pictures.parts import (
    cases_text,
    parameter_label,
    value_text,
    write_title,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LOW, _HIGH, _RANK = "#D55E00", "#0072B2", "#000000"
# Bars of one of the two colours are hatched, so that they differ in grey too.
_HATCH = {_LOW: "/////", _HIGH: ""}
# Frames, and bars in one frame.
_FRAMES, _BARS = 6, 10
# Changes are per cent of the baseline where no value is more than so many times that.
_MANY = 4.0


@styled
def draw_tornado(found: SweepAnalysis, settings: SweepPictureSettings, path: Path) -> None:
    """Draw the sensitivities of the first results to a picture file."""
    shown = found.sensitivities[:_FRAMES]
    bars = min(_BARS, max(len(s.one_at_a_time) + len(s.regressions) for s in shown))
    across = min(2, len(shown))
    down = -(-len(shown) // across)
    figure = new_figure(path, TWO_COLUMNS_MM, max(70.0, (28.0 + 8.0 * bars) * down + 20.0))
    frames = figure.subplots(down, across, squeeze=False)
    for axes, item in zip(frames.ravel(), shown, strict=False):
        if item.kind == "one_at_a_time":
            _draw_single(axes, found.design, item, settings)
        else:
            _draw_samples(axes, item, settings)
    for axes in frames.ravel()[len(shown) :]:
        axes.set_visible(False)
    kind = shown[0].kind
    how = (
        "each parameter from its lowest to its highest value, the others at the baseline"
        if kind == "one_at_a_time"
        else f"with {100 * settings.confidence:g} % confidence limits"
    )
    title = f"Sensitivities: {found.design.scene}, {cases_text(found)}; {how}"
    write_title(figure, title)
    more = len(found.sensitivities) - len(shown)
    note = f"{more} more results in sweep.json" if more else ""
    add_legend(figure, list(frames.ravel()), note, "outside lower center", 4)
    write_figure(figure, path)


def _draw_single(
    axes: Axes, design: SweepDesign, item: Sensitivity, settings: SweepPictureSettings
) -> None:
    """Change of the result, a bar for each end of a parameter."""
    effects = item.one_at_a_time[:_BARS]
    reference = effects[0].at_baseline
    relative = _is_relative(reference, [v for e in effects for v in (e.smallest, e.largest)])
    percent = 100.0 / abs(reference) if relative else 1.0
    for row, effect in enumerate(effects):
        ends = ((effect.at_low, effect.low, _LOW, "at the lowest value"),
                (effect.at_high, effect.high, _HIGH, "at the highest value"))  # fmt: skip
        between = [percent * (v - reference) for v in (effect.smallest, effect.largest)]
        axes.plot(between, [row, row], color="black", linewidth=1.0, zorder=2.5, marker="|",
                  label="all values between")  # fmt: skip
        sides: dict[bool, list[str]] = {}
        for result, value, color, name in ends:
            change = percent * (result - reference)
            if np.isfinite(change):
                _bar(axes, row, change, 0.55, color, name)
            sides.setdefault(bool(change > 0.0), []).append(
                value_text(design, effect.parameter, value)
            )
        for right, texts in sides.items():
            edge = percent * ((effect.largest if right else effect.smallest) - reference)
            axes.annotate(", ".join(texts), (edge, row), xytext=(5 if right else -5, 0),
                          textcoords="offset points", ha="left" if right else "right",
                          va="center", fontsize=SMALL_PT)  # fmt: skip
    axes.axvline(0.0, color="black", linewidth=0.8)
    low, high = (percent * (f(v for e in effects for v in (e.smallest, e.largest)) - reference)
                 for f in (min, max))  # fmt: skip
    span = (high - low) or 1.0
    axes.set_xlim(low - 0.42 * span, high + 0.42 * span)  # for the values at the ends
    unit = "%" if relative else (unit_of(item.quantity) or "1")
    axes.set_xlabel(f"change from {number_text(reference, 5)}\nat the baseline [{unit}]")
    names = []
    for effect in effects:
        power = _power(effect.elasticity)
        bent = "" if effect.linear else ", not linear"
        names.append(_name(effect.parameter, settings) + power + (bent if power else bent[1:]))
    _finish(axes, names, item, settings, "")


def _is_relative(reference: float, values: Sequence[float]) -> bool:
    """Whether changes say most in per cent: not of what passes zero, or is small by chance."""
    return all(v * reference > 0.0 and abs(v) <= _MANY * abs(reference) for v in values)


def _draw_samples(axes: Axes, item: Sensitivity, settings: SweepPictureSettings) -> None:
    """Standardised regression coefficients and rank correlations with their limits."""
    effects = item.regressions[:_BARS]
    for row, effect in enumerate(effects):
        low, high = effect.coefficient_limits
        color = _HIGH if effect.coefficient > 0.0 else _LOW
        _bar(axes, row - 0.14, effect.coefficient, 0.42, color, None)
        axes.errorbar(effect.coefficient, row - 0.14, fmt="none", ecolor="black", capsize=3.0,
                      xerr=[[effect.coefficient - low], [high - effect.coefficient]],
                      elinewidth=1.2)  # fmt: skip
        low, high = effect.rank_limits
        axes.errorbar(effect.rank_correlation, row + 0.25, fmt="D", color=_RANK, markersize=3.8,
                      markerfacecolor="white", capsize=3.0, elinewidth=1.0,
                      label="rank correlation",
                      xerr=[[effect.rank_correlation - low], [high - effect.rank_correlation]],
                      )  # fmt: skip
    _bar(axes, np.nan, np.nan, 0.42, _HIGH, "coefficient, rises with it")
    _bar(axes, np.nan, np.nan, 0.42, _LOW, "coefficient, falls with it")
    axes.axvline(0.0, color="black", linewidth=0.8)
    widest = max(
        abs(v) for e in effects for v in (*e.coefficient_limits, *e.rank_limits, e.coefficient)
    )
    axes.set_xlim(-1.08 * max(widest, 1.0), 1.08 * max(widest, 1.0))
    axes.set_xlabel("standardised coefficient,\nrank correlation [1]")
    names = []
    for effect in effects:
        power = _power(effect.elasticity)
        names.append(_name(effect.parameter, settings) + power)
    note = f"\n{item.cases} samples, R² = {item.r_squared:.3f}"
    _finish(axes, names, item, settings, note if item.linear else f"{note}, not linear")


def _power(elasticity: float) -> str:
    """A line that says the power; zero has no sign."""
    if not np.isfinite(elasticity):
        return ""
    return f"\npower {round(elasticity, 2) + 0.0:+.2f}".replace("-", "\u2212")


def _bar(
    axes: Axes, row: float, length: float, height: float, color: str, label: str | None
) -> None:
    axes.barh(row, length, height=height, color=color, hatch=_HATCH[color], edgecolor="white",
              linewidth=0.4, label=label)  # fmt: skip


def _name(parameter: str, settings: SweepPictureSettings) -> str:
    return wrapped(parameter_label(parameter, settings), 24)


def _finish(
    axes: Axes, names: list[str], item: Sensitivity, settings: SweepPictureSettings, note: str
) -> None:
    axes.set_yticks(range(len(names)), names, fontsize=SMALL_PT)
    axes.set_ylim(len(names) - 0.45, -0.55)
    label = settings.labels.get(item.quantity, item.label)
    axes.set_title(wrapped(label, 42) + note, fontsize=SMALL_PT)
    draw_grid(axes, "major", "x")
