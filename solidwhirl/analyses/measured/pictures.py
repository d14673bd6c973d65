"""Charts and tables of a hammer test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.analyses.measured.records import UNITS
from solidwhirl.core.blocks import Table, numbers
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.plots import chart as charts

_PRINTED = {"receptance": "m/N", "mobility": "m/(s N)", "accelerance": "m/(s² N)"}
_COMPUTED = charts.Look("@c0", "solid")
_MEASURED = charts.Look("@c1", "dot")
# Pairs of a hammer and a sensor that a page offers.
_MOST = 40
_MARK = charts.Look("@c1", "", "circle", 8)


class _Function(NamedTuple):
    """A function from a hammer to a sensor, and what was measured of it over frequencies."""

    label: str
    computed: ComplexArray
    measured: Sequence[tuple[FloatArray, ComplexArray]]


def function_charts(document: Mapping[str, Any]) -> list[charts.Chart]:
    """Return size and phase of the functions over the frequency, measured ones over computed."""
    functions = _functions(document)
    return [_function_chart(document, functions, what) for what in ("size", "phase")]


def _function_chart(
    document: Mapping[str, Any], functions: Sequence[_Function], what: str
) -> charts.Chart:
    quantity, hertz = document["quantity"], numbers(document["frequency_hz"])
    options, sizes = [], []
    for function in functions:
        curves = [_curve(hertz, function.computed, what, "computed", _COMPUTED)]
        curves += [_curve(x, y, what, "measured", _MEASURED) for x, y in function.measured]
        sizes += [np.abs(y) for y in (function.computed, *(y for _, y in function.measured))]
        options.append(charts.Option(label=function.label, marks=curves))
    every = np.concatenate(sizes)
    every = every[every > 0.0]
    y = (
        charts.size_axis(quantity, _PRINTED[quantity], float(every.min()), float(every.max()))
        if what == "size" and every.size
        else charts.Axis(
            label="phase", unit="°", low=-185.0, high=185.0, step=90.0, digits=".1f"
        )
    )  # fmt: skip
    return charts.Chart(
        name=f"impact-{what}",
        title=quantity.capitalize() if what == "size" else "Phase",
        caption=f"{quantity.capitalize()} from a hammer to a sensor, "
        + ("its size." if what == "size" else "its phase against the force."),
        alt=f"{what} of the {quantity} over the frequency, computed and measured.",
        x=charts.Axis(label="frequency", unit="Hz", low=0.0, high=float(hertz[-1])),
        y=y,
        parts=[charts.Choice(label="from hammer to sensor", options=options)],
    )


def _functions(document: Mapping[str, Any]) -> list[_Function]:
    """Return functions that a page offers, those that were measured first."""
    unit = UNITS[document["quantity"]]
    values = numbers(document[f"real_{unit}"]) + 1j * numbers(document[f"imaginary_{unit}"])
    measured: dict[tuple[str, str], list[tuple[FloatArray, ComplexArray]]] = {}
    for f in (document.get("measured") or {}).get("functions") or ():
        curve = numbers(f["frequency_hz"]), numbers(f["real"]) + 1j * numbers(f["imaginary"])
        measured.setdefault((f["hammer"], f["sensor"]), []).append(curve)
    found = [
        _Function(f"{hammer} to {sensor}", values[h, s], measured.get((hammer, sensor), []))
        for h, hammer in enumerate(document["hammer"])
        for s, sensor in enumerate(document["sensor"])
    ]
    return sorted(found, key=lambda function: not function.measured)[:_MOST]


def _curve(
    x: FloatArray, values: ComplexArray, what: str, name: str, look: charts.Look
) -> charts.Curve:
    if what == "size":
        size = np.abs(values)
        return charts.Curve(x=x, y=np.where(size > 0.0, size, np.nan), name=name, look=look)
    phase = np.degrees(np.angle(values))
    jumps = np.abs(np.diff(phase, prepend=phase[:1])) > 180.0
    return charts.Curve(x=x, y=np.where(jumps, np.nan, phase), name=name, look=look)


def natural_table(document: Mapping[str, Any]) -> Table | None:
    """Return the computed frequencies; None without any in the range."""
    own = document["modes"]
    listed = zip(own["frequency_hz"], own["damping_ratio"], own["count"], strict=True)
    rows = [[k + 1, float(f), float(ratio), n] for k, (f, ratio, n) in enumerate(listed)]
    head = ["mode", "computed [Hz]", "damping ratio", "planes"]
    return Table(title="Natural frequencies", head=head, rows=rows) if rows else None


def frequency_table(document: Mapping[str, Any]) -> Table | None:
    """Return measured and computed frequencies side by side; None without measured ones."""
    modes = (document.get("measured") or {}).get("modes")
    if not modes:
        return None
    rows = [
        [
            k + 1,
            mode["frequency_hz"],
            mode["uncertainty_hz"],
            mode["computed"],
            mode["computed_hz"],
            _percent(mode["relative_difference"]),
            None if mode["mac"] is None else f"{mode['mac']:.3f}",
            mode["damping_ratio"],
        ]
        for k, mode in enumerate(modes)
    ]
    return Table(
        title="Frequencies side by side",
        head=[
            *("measured mode", "measured [Hz]", "± [Hz]", "computed mode", "computed [Hz]"),
            *("difference [%]", "MAC", "measured damping ratio"),
        ],
        rows=rows,
        caption="Difference of the computed frequency from the measured one. "
        + (
            "Pairs are those of the largest sum of MAC, 0.5 at least."
            if document["measured"]["mac"] and all(m["mac"] or not m["computed"] for m in modes)
            else "Pairs are those of the nearest frequencies, a quarter apart at most: not all "
            "measured modes have shapes."
        ),
    )


def _percent(value: float | None) -> str | None:
    return None if value is None else f"{100.0 * value:+.2f}"


def mac_table(document: Mapping[str, Any]) -> Table | None:
    """Return the MAC of measured and computed modes; None without measured shapes."""
    measured = document.get("measured") or {}
    mac: Sequence[Sequence[float | None]] | None = measured.get("mac")
    if not mac:
        return None
    computed = document["modes"]["frequency_hz"]
    rows = [
        [
            f"{k + 1}: {charts.hertz_text(mode['frequency_hz'])}",
            *(None if v is None else f"**{v:.2f}**" if v >= 0.8 else f"{v:.2f}" for v in row),
        ]
        for k, (mode, row) in enumerate(zip(measured["modes"], mac, strict=True))
    ]
    head = ["measured", *(f"{k + 1}: {charts.hertz_text(f)}" for k, f in enumerate(computed))]
    return Table(
        title="Modal assurance criterion",
        head=head,
        rows=rows,
        caption="Rows are measured modes, columns computed ones; of a mode in two planes the "
        "combination that is most like the measured one. 1: the same shape at the sensors.",
    )


def paired_modes(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the measured modes that belong to a computed one."""
    modes = (document.get("measured") or {}).get("modes") or []
    return [mode for mode in modes if mode["computed"] is not None]


def mode_chart(document: Mapping[str, Any]) -> charts.Chart | None:
    """Return the differences of paired frequencies; None without measured modes."""
    pairs = paired_modes(document)
    if not pairs:
        return None
    x = np.array([m["frequency_hz"] for m in pairs])
    y = 100.0 * np.array([m["relative_difference"] for m in pairs])
    errors = [100.0 * (m["uncertainty_hz"] or 0.0) / m["frequency_hz"] for m in pairs]
    texts = [
        f"measured {charts.hertz_text(m['frequency_hz'])}\n"
        f"computed {charts.hertz_text(m['computed_hz'])}"
        for m in pairs
    ]
    return charts.Chart(
        name="impact-modes",
        title="Computed frequencies against measured ones",
        caption="Difference of the computed frequency from the measured one; bars are the "
        "uncertainty of the measured ones where it is told.",
        alt=f"Differences from {y.min():.2f} to {y.max():.2f} %.",
        x=charts.Axis(label="measured frequency", unit="Hz"),
        y=charts.Axis(label="difference", unit="%"),
        parts=[
            charts.Rule(at=0.0, along="y"),
            charts.Curve(
                x=x,
                y=y,
                look=_MARK,
                texts=texts,
                errors=np.array(errors) if any(errors) else None,
                errors_along="y",
            ),
        ],
        height_px=300,
        has_legend=False,
    )
