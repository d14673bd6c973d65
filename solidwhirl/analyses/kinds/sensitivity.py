"""Sensitivity of magnetic bearings over the speed, with the zones of ISO 14839-3."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from pydantic import model_validator

from solidwhirl.analyses import base
from solidwhirl.analyses.work import EngineSize, Work
from solidwhirl.core.blocks import AnalysisBlock, Table, Text, numbers
from solidwhirl.core.fields import Positive
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.plain_data import Labels
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.controlled import controlled
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.stability.magnetic_loops import (
    ZONE_LIMITS,
    Sensitivity,
    highest_of,
    sensitivities,
    system_sensitivity,
)

_FREQUENCIES = 400
# Lowest frequency of the curves, part of the highest.
_LOWEST = 1e-3


class SensitivitySpec(base.Sweep):
    """Largest sensitivity of each axis of the magnetic bearings over the speed, and its zone."""

    section = base.STABILITY

    kind: Literal["sensitivity"]
    count: base.Points = 11
    frequency_max_hz: Positive | None = None
    zone_limits: tuple[Positive, Positive, Positive] = ZONE_LIMITS

    @model_validator(mode="after")
    def _zones(self) -> SensitivitySpec:
        if list(self.zone_limits) != sorted(set(self.zone_limits)):
            raise ValueError("zone_limits must be increasing")
        return self

    def work(self, size: EngineSize) -> Work:
        """How much it has to solve."""
        return Work(eigenproblems=4.0 * self.count, solves=600.0 * self.count, results=10.0)

    def run(self, engine: base.Engine) -> Outcome:
        """Peaks over the speed, and the curves over the frequency at the highest speed."""
        highest = None if self.frequency_max_hz is None else 2.0 * np.pi * self.frequency_max_hz
        found = [
            system_sensitivity(engine.system, float(speed), highest, self.zone_limits)
            for speed in self.speeds_rad_s
        ]
        last = float(self.speeds_rad_s[-1])
        top = highest or highest_of(last)
        peaks = [axis.frequency_rad_s for axis in found[-1].axes]
        omega = np.unique(np.concatenate((np.geomspace(_LOWEST * top, top, _FREQUENCIES), peaks)))
        loops = controlled(engine.system).loops
        names = [f"{loop.name} {axis}" for loop in loops for axis in "xy"]
        curves = np.abs(sensitivities(engine.system, last, omega)).T
        document: dict[str, Any] = {
            "speed_rpm": (self.speeds_rad_s * RPM_PER_RAD_S).tolist(),
            "stable": [one.is_stable for one in found],
            "zone_limits": list(self.zone_limits),
            "axes": [_axis_document(name, place, found) for place, name in enumerate(names)],
            "curves": {
                "speed_rpm": last * RPM_PER_RAD_S,
                "frequency_hz": (omega / (2.0 * np.pi)).tolist(),
                "sensitivity": curves.tolist() if found[-1].is_stable else [],
            },
        }
        worst = min(range(len(found)), key=lambda k: _rank(found[k]))
        rpm = document["speed_rpm"][worst]
        headline = f"{found[worst].message}, at {rpm:.6g} rpm"
        return Outcome(kind=self.kind, document=document, headline=headline)

    def pictures(self, found: base.Found) -> Mapping[str, base.Charts]:
        """The sensitivity over the frequency above its peaks over the speed."""
        return {"": lambda: _charts(found.document)}

    def blocks(self, found: base.Found) -> Sequence[AnalysisBlock]:
        """The largest peak of each axis and its zone, and both charts."""
        document = found.document
        unstable = [
            f"{rpm:.6g}"
            for rpm, stable in zip(document["speed_rpm"], document["stable"], strict=True)
            if not stable
        ]
        text = f"Unstable at {', '.join(unstable)} rpm: no sensitivity is given there."
        warned = [Text(text=text, kind="warning")] if unstable else []
        return [*warned, _table(document), *_charts(document)]

    @classmethod
    def labels(cls, document: Mapping[str, Any]) -> Labels:
        """Peaks by axis over the speed, and curves over the frequency."""
        axes, curves = document["axes"], document["curves"]
        keys = ("peak", "at_hz", "zone")
        found = {key: (("axis", "speed_rpm"), [axis[key] for axis in axes]) for key in keys}
        if curves["sensitivity"]:
            found["sensitivity"] = (("axis", "frequency_hz"), curves["sensitivity"])
        return Labels(
            {**found, "stable": ("speed_rpm", document["stable"])},
            {
                "axis": ("axis", [axis["name"] for axis in axes]),
                "speed_rpm": ("speed_rpm", document["speed_rpm"]),
                "frequency_hz": ("frequency_hz", curves["frequency_hz"]),
            },
            {"curves_at_rpm": curves["speed_rpm"]},
        )

    @classmethod
    def scalars(cls, document: Mapping[str, Any]) -> base.Scalars:
        """Yield the largest sensitivity of all axes and speeds, none where a speed is unstable."""
        every = [peak for axis in document["axes"] for peak in axis["peak"]]
        yield "largest_sensitivity", None if None in every else base.largest_of(every)


def _rank(found: Sensitivity) -> tuple[float, float]:
    """Put what is unstable first, the fastest growth before others, then the largest peak."""
    if not found.is_stable:
        return -2.0, -float(found.eigenvalues.real.max())
    return -1.0, -max(axis.peak for axis in found.axes)


def _axis_document(name: str, place: int, found: Sequence[Sensitivity]) -> dict[str, Any]:
    axes = [one.axes[place] if one.axes else None for one in found]
    return {
        "name": name,
        "peak": [None if axis is None else axis.peak for axis in axes],
        "at_hz": [None if a is None else a.frequency_rad_s / (2.0 * np.pi) for a in axes],
        "zone": [None if axis is None else axis.zone for axis in axes],
    }


def _table(document: Mapping[str, Any]) -> Table:
    rows: list[list[Any]] = []
    for axis in document["axes"]:
        peaks = numbers(axis["peak"])
        if not np.isfinite(peaks).any():
            rows.append([axis["name"], None, None, None, "unstable"])
            continue
        at = int(np.nanargmax(peaks))
        rpm = f"{document['speed_rpm'][at]:.6g}"
        rows.append([axis["name"], axis["peak"][at], axis["at_hz"][at], rpm, axis["zone"][at]])
    return Table(
        title="Largest sensitivity of each axis",
        head=["axis", "largest |Gs| [1]", "at [Hz]", "reference shaft [rpm]", "zone"],
        rows=rows,
    )


def _charts(document: Mapping[str, Any]) -> list[charts.Chart]:
    limits = document["zone_limits"]
    curves, names = document["curves"], [axis["name"] for axis in document["axes"]]
    rpm = numbers(document["speed_rpm"])
    peaks = [numbers(axis["peak"]) for axis in document["axes"]]
    hertz = numbers(curves["frequency_hz"])
    frequency = charts.Axis(
        label="frequency", unit="Hz", low=float(hertz.min()), high=float(hertz.max()), is_log=True
    )
    over_speed = charts.speed_axis(float(rpm.min()), float(rpm.max()))
    found = [
        _chart("sensitivity-peaks", over_speed, list(zip(names, peaks, strict=True)), rpm, limits)
    ]
    if curves["sensitivity"]:
        gains = [numbers(gain) for gain in curves["sensitivity"]]
        pairs = list(zip(names, gains, strict=True))
        found.insert(0, _chart("sensitivity", frequency, pairs, hertz, limits))
    return found


def _chart(
    name: str,
    x: charts.Axis,
    curves: Sequence[tuple[str, FloatArray]],
    at: FloatArray,
    limits: Sequence[float],
) -> charts.Chart:
    over_frequency = name == "sensitivity"
    every = np.concatenate([gain for _, gain in curves])
    highest = max(float(np.nanmax(every, initial=0.0)), limits[-1])
    rules = [
        charts.Rule(at=limit, along="y", text=f"{first} to {then}")
        for limit, first, then in zip(limits, "ABC", "BCD", strict=True)
    ]
    lines = [
        charts.Curve(
            x=at,
            y=gain,
            name=axis,
            look=replace(charts.series_look(k), mark="" if over_frequency else "circle"),
        )
        for k, (axis, gain) in enumerate(curves)
    ]
    what = "over the frequency at the highest speed" if over_frequency else "over the speed"
    return charts.Chart(
        name=name,
        title="Sensitivity" if over_frequency else "Largest sensitivity",
        caption=f"{'|Gs|' if over_frequency else 'Largest |Gs|'} of each axis {what}, all other "
        "loops closed, with the limits of the zones A to D of ISO 14839-3.",
        alt=f"Sensitivity {what}, up to {highest:.4g}.",
        x=x,
        y=charts.Axis(
            label="sensitivity |Gs|", unit="1", low=0.0, high=1.08 * highest, digits=".4g"
        ),
        parts=[*rules, *lines],
        height_px=380,
    )
