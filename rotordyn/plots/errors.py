"""Charts of error estimates: Campbell diagrams with bands, critical speeds with bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed
from solidwhirl.rotordyn.estimates.campbell_errors import CampbellErrors
from solidwhirl.rotordyn.estimates.critical_speed_errors import CriticalSpeedErrors
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.campbell import CampbellView, campbell_chart
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.superelement.residual_energy import NOT_SUMMED

# Relative errors below this are not drawn: they are rounding.
_LEAST = 1e-12
# Critical speeds drawn, from the lowest.
_ROWS = 24
# Colours other than those of whirl, told apart by dashes and marks too.
_LOOKS = {
    "mesh": charts.Look("#8C510A", "solid", "circle"),
    "circumferential": charts.Look("@c5", "dash", "square"),
    "stage_joints": charts.Look("@c5", "dash", "star"),
    "joint_lift": charts.Look("@c1", "longdash", "diamond"),
    "mode_truncation": charts.Look("@c3", "dashdot", "triangle-up"),
    "speed_interpolation": charts.Look("@c4", "dot", "triangle-left"),
    "interface_coupling": charts.Look("@c7", "longdash", "cross"),
    "beam_theory": charts.Look("#882255", "longdashdot", "x"),
    "eigen_solver": charts.Look("#999999", "dot", "pentagon"),
    "harmonics": charts.Look("#117733", "dash", "hexagon"),
    "total": charts.Look("@ink", "solid", "diamond-open"),
}


def parts_chart(errors: CampbellErrors) -> charts.Chart:
    """Return the largest estimate of all branches by part, and the total of each (thin)."""
    rpm = errors.campbell.speeds_rad_s * RPM_PER_RAD_S
    thin = charts.Look("#BBBBBB", "solid", width=1.0)
    curves = [
        charts.Curve(x=rpm, y=_visible(total), name="total of a branch", look=thin)
        for total in errors.known
    ]
    curves += [
        charts.Curve(
            x=rpm,
            # the largest of all branches at each speed, nan where all are absent
            y=_visible(np.fmax.reduce(values, axis=0, initial=np.nan)),
            name=_part_name(part),
            look=_LOOKS[part],
        )
        for part, values in {**errors.parts, "total": errors.known}.items()
        if part == "total" or (values > _LEAST).any()
    ]
    return charts.Chart(
        name="campbell-errors",
        title="Estimated errors over the speed",
        x=charts.speed_axis(float(rpm.min()), float(rpm.max())),
        y=_decades("largest estimated relative error", errors.known, errors.parts),
        parts=curves,
        height_px=330,
    )


def draw_campbell_errors(
    errors: CampbellErrors,
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float] | None = None,
) -> None:
    """Draw a Campbell diagram with error bands, and the estimates over the speed below it.

    Bands are frequency · (1 ± total). Bodies without an estimate are named at the speed axis; the
    other arguments and errors are as in `draw_campbell`.
    """
    view = CampbellView(
        excitation_ratios=excitation_ratios or {}, operating_rad_s={}, errors=errors.known
    )
    parts = parts_chart(errors)
    label = _with_gaps(parts.x.label, errors.bodies_without_estimate)
    diagram = campbell_chart(replace(errors.campbell, notes=()), view)
    draw_charts([diagram, replace(parts, x=replace(parts.x, label=label))], path, title)


def draw_critical_speed_errors(
    critical_speeds: Sequence[CriticalSpeed],
    errors: CriticalSpeedErrors,
    path: str | Path,
    title: str,
) -> None:
    """Draw the first 24 critical speeds with error bars, and below them the estimates by part.

    `path` and `title` as in `draw_campbell`. Raises AnalysisError if there are no critical speeds,
    the estimates are of another number of them, or the suffix is not a kind of picture that can be
    written.
    """
    if not critical_speeds or errors.known.size != len(critical_speeds):
        raise AnalysisError(
            f"there are {len(critical_speeds)} critical speeds and {errors.known.size} estimates; "
            "one or more with an estimate each are needed"
        )
    speed = np.array([c.speed_rad_s for c in critical_speeds]) * RPM_PER_RAD_S
    order = np.argsort(speed, kind="stable")[:_ROWS]
    names = [f"{speed[k]:.0f} rpm, {critical_speeds[k].frequency_hz:.1f} Hz" for k in order]
    rows = charts.Axis(label="critical speed", places=names, low=order.size - 0.4, high=-0.6)
    marks = [
        charts.Curve(
            x=speed[[k]],
            y=np.array([float(row)]),
            name=charts.whirl_name(critical_speeds[k].whirl),
            look=replace(charts.whirl_look(critical_speeds[k].whirl), dash="", size=8.0),
            errors=speed[[k]] * errors.known[[k]],
        )
        for row, k in enumerate(order)
    ]
    end = 1.08 * float((speed * (1.0 + errors.known))[order].max())
    bars = charts.Chart(
        name="critical-speed-errors", title="Critical speeds with their estimated errors", y=rows,
        x=charts.speed_axis(0.0, end, "critical speed with its estimated error"), parts=marks,
    )  # fmt: skip
    label = _with_gaps("estimated relative error", errors.bodies_without_estimate)
    parts = charts.Chart(
        name="critical-speed-parts", title="Estimated errors by part",
        x=_decades(label, errors.known[order], errors.parts), y=rows,
        parts=_parts_of_rows(errors, order),
    )  # fmt: skip
    draw_charts([bars, parts], path, title)


def _parts_of_rows(errors: CriticalSpeedErrors, order: IntArray) -> list[charts.Curve]:
    """Marks of the estimates of each row by part, and the total."""
    return [
        charts.Curve(
            x=_visible(values[order]),
            y=np.arange(float(order.size)),
            name=_part_name(part),
            look=replace(_LOOKS[part], dash="", size=10.0),
        )
        for part, values in {**errors.parts, "total": errors.known}.items()
        if (values[order] > _LEAST).any()
    ]


def _part_name(part: str) -> str:
    return part.replace("_", " ") + (" (not summed)" if part in NOT_SUMMED else "")


def _visible(values: FloatArray) -> FloatArray:
    return np.where(values > _LEAST, values, np.nan)


def _decades(label: str, total: FloatArray, parts: Mapping[str, FloatArray]) -> charts.Axis:
    """A logarithmic axis over whole decades that holds all that is drawn."""
    drawn = np.concatenate([total.ravel(), *[values.ravel() for values in parts.values()]])
    drawn = drawn[np.isfinite(drawn) & (drawn > _LEAST)]
    ends = (drawn.min(), drawn.max()) if drawn.size else (_LEAST, 1.0)
    low, high = 10.0 ** np.floor(np.log10(ends[0])), 10.0 ** np.ceil(np.log10(ends[1]))
    return charts.Axis(label=label, unit="1", low=low, high=max(high, 10.0 * low), is_log=True)


def _with_gaps(label: str, missing: Sequence[str]) -> str:
    """A label that names the bodies without an estimate."""
    return label + (f", no estimate for {', '.join(missing)}" if missing else "")
