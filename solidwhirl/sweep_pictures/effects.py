"""Tornado of a sweep: how strongly each parameter moves each result."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from solidwhirl.core.key_units import unit_of, wrapped
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots.chart import (
    Axis,
    Bars,
    Chart,
    Choice,
    Curve,
    Label,
    Look,
    Mark,
    Option,
    Rule,
)
from solidwhirl.rotordyn.plots.frame import number_text
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.sensitivity import OneAtATime, Sensitivity
from solidwhirl.sweep_pictures.parts import cases_text, parameter_label, value_text

_LOW, _HIGH, _ZERO = Look("@c1"), Look("@c0"), Look("@ink", "solid", width=1.0)
_BETWEEN = Look("@ink", "solid", "line-ns", 10.0, 1.4)
_RANK = Look("@ink", "", "diamond-open")
# Frames, and bars in one frame.
_FRAMES, _BARS = 6, 10
# Changes are per cent of the baseline where no value is more than so many times that.
_MANY = 4.0


def tornado_chart(found: SweepAnalysis, settings: SweepPictureSettings) -> Chart:
    """Return the sensitivities of the first results."""
    shown = found.sensitivities[:_FRAMES]
    options = [
        _single(found.design, item, settings)
        if item.kind == "one_at_a_time"
        else _samples(item, settings)
        for item in shown
    ]
    how = (
        "each parameter from its lowest to its highest value, the others at the baseline"
        if shown[0].kind == "one_at_a_time"
        else f"with {100 * settings.confidence:g} % confidence limits"
    )
    more = len(found.sensitivities) - len(shown)
    rows = max((o.y for o in options if o.y is not None), key=lambda y: len(y.places))
    return Chart(
        name="tornado",
        title=f"Sensitivities: {found.design.scene}, {cases_text(found)}; {how}",
        x=Axis(label=""),
        y=rows,
        parts=[
            Rule(at=0.0, look=_ZERO),
            Choice(label="result", options=options, on_paper="each"),
        ],
        notes=[f"{more} more results in sweep.json"] if more else [],
    )


def _single(design: SweepDesign, item: Sensitivity, settings: SweepPictureSettings) -> Option:
    """Change of the result, a bar for each end of a parameter."""
    effects = item.one_at_a_time[:_BARS]
    reference = effects[0].at_baseline
    reach = np.array([(e.smallest, e.largest) for e in effects])
    relative = _is_relative(reference, reach.ravel().tolist())
    percent = 100.0 / abs(reference) if relative else 1.0

    def change(values: Sequence[float]) -> FloatArray:
        return percent * (np.array(values) - reference)

    marks: list[Mark] = [
        Bars(values=change([e.at_low for e in effects]), name="at the lowest value", look=_LOW),
        Bars(values=change([e.at_high for e in effects]), name="at the highest value", look=_HIGH),
    ]
    for row, effect in enumerate(effects):
        ends = change([effect.smallest, effect.largest])
        at = np.full(2, float(row))
        marks.append(Curve(x=ends, y=at, name="all values between", look=_BETWEEN))
        marks += _ends(design, effect, ends, row, reference)
    low, high = change([reach.min(), reach.max()])
    span = (high - low) or 1.0
    unit = "%" if relative else (unit_of(item.quantity) or "1")
    label = f"change from {number_text(reference, 5)} at the baseline"
    names = []
    for effect in effects:
        words = [_power(effect.elasticity), "" if effect.linear else "not linear"]
        said = ", ".join(filter(None, words))
        names.append("\n".join(filter(None, [_name(effect.parameter, settings), said])))
    # room for the values at the ends
    x = Axis(label=label, unit=unit, low=low - 0.42 * span, high=high + 0.42 * span)
    return Option(label=_title(item, settings), marks=marks, x=x, y=_rows(names))


def _ends(
    design: SweepDesign, effect: OneAtATime, reach: FloatArray, row: int, reference: float
) -> Iterator[Label]:
    """Values of a parameter beside the ends of its bar."""
    sides: dict[bool, list[str]] = {}
    for result, value in ((effect.at_low, effect.low), (effect.at_high, effect.high)):
        text = value_text(design, effect.parameter, value)
        sides.setdefault(bool(result > reference), []).append(text)
    for right, texts in sides.items():
        side = "right" if right else "left"
        yield Label(x=float(reach[int(right)]), y=float(row), text=", ".join(texts), side=side)


def _is_relative(reference: float, values: Sequence[float]) -> bool:
    """Whether changes say most in per cent: not of what passes zero, or is small by chance."""
    return all(v * reference > 0.0 and abs(v) <= _MANY * abs(reference) for v in values)


def _samples(item: Sensitivity, settings: SweepPictureSettings) -> Option:
    """Standardised regression coefficients and rank correlations with their limits."""
    effects = item.regressions[:_BARS]
    found = np.array([e.coefficient for e in effects])
    rows = np.arange(float(len(effects)))
    rank = np.array([e.rank_correlation for e in effects])
    coefficient_limits = [e.coefficient_limits for e in effects]
    rank_limits = [e.rank_limits for e in effects]
    marks: list[Mark] = [
        Bars(values=np.where(found > 0.0, found, np.nan), name="coefficient, rises with it",
             look=_HIGH),
        Bars(values=np.where(found > 0.0, np.nan, found), name="coefficient, falls with it",
             look=_LOW),
        *_intervals(coefficient_limits, rows - 0.1),
        *_intervals(rank_limits, rows + 0.25),
        Curve(x=rank, y=rows + 0.25, name="rank correlation", look=_RANK),
    ]  # fmt: skip
    widest = max(1.0, float(np.abs([*coefficient_limits, *rank_limits]).max()))
    note = f"{item.cases} samples, R² = {item.r_squared:.3f}"
    note += "" if item.linear else ", not linear"
    names = [
        "\n".join(filter(None, [_name(e.parameter, settings), _power(e.elasticity)]))
        for e in effects
    ]
    label = "standardised coefficient, rank correlation"
    x = Axis(label=label, unit="1", low=-1.08 * widest, high=1.08 * widest)
    return Option(label=f"{_title(item, settings)}\n{note}", marks=marks, x=x, y=_rows(names))


def _intervals(limits: Sequence[tuple[float, float]], rows: FloatArray) -> list[Curve]:
    return [
        Curve(x=np.array(ends), y=np.full(2, row), name="confidence limits", look=_BETWEEN)
        for ends, row in zip(limits, rows, strict=True)
    ]


def _power(elasticity: float) -> str:
    """The power of a parameter in words; zero has no sign."""
    if not np.isfinite(elasticity):
        return ""
    return f"power {round(elasticity, 2) + 0.0:+.2f}".replace("-", "\u2212")


def _name(parameter: str, settings: SweepPictureSettings) -> str:
    return wrapped(parameter_label(parameter, settings), 24)


def _title(item: Sensitivity, settings: SweepPictureSettings) -> str:
    return wrapped(settings.labels.get(item.quantity, item.label), 42)


def _rows(names: Sequence[str]) -> Axis:
    return Axis(label="", places=names, low=len(names) - 0.45, high=-0.55)
