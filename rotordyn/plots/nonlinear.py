"""Chart of a nonlinear response: branches over the speed, unstable parts dashed, and jumps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.plots import chart as charts


@dataclass(frozen=True, kw_only=True, eq=False)
class BranchCurves:
    """A branch of p motions: speeds, whether they are stable and the speed turns, and radii."""

    speed_rpm: FloatArray
    is_stable: BoolArray
    is_turning: BoolArray
    #: Largest by place, shape (p,)
    radius_m: Mapping[str, FloatArray]
    #: Of the unbalance after which motions repeat
    turns: int = 1


class JumpMark(NamedTuple):
    """Radii by place before and after a jump; nan where unknown."""

    speed_rpm: float
    before_m: Mapping[str, float]
    after_m: Mapping[str, float]


def branch_chart(branches: Sequence[BranchCurves], jumps: Sequence[JumpMark]) -> charts.Chart:
    """Return the largest radius at each place over the speed along all branches."""
    every = [b.radius_m[p] for b in branches for p in b.radius_m]
    largest = max(float(np.nanmax(r)) for r in every)
    unit, factor = charts.metric(largest, "m")
    speeds = np.concatenate([b.speed_rpm for b in branches])
    marks: list[charts.Part] = []
    for number, place in enumerate(branches[0].radius_m):
        look = replace(charts.series_look(number), dash="solid", mark="")
        quiet = charts.is_quiet(number)
        for turns in sorted({b.turns for b in branches}):
            group = [b for b in branches if b.turns == turns]
            own = replace(look, width=look.width if turns == 1 else 1.0)
            name = place if turns == 1 else f"{place}, {turns} turns"
            marks += _curves(group, place, (name, factor, quiet), own)
        for jump in jumps:
            ends = factor * np.array([jump.before_m[place], jump.after_m[place]])
            if np.isfinite(ends).all():
                at, own = np.full(2, jump.speed_rpm), replace(look, dash="dot", width=1.2)
                marks.append(charts.Curve(x=at, y=ends, look=own, is_quiet=quiet))
    return charts.Chart(
        name="branches",
        title="Nonlinear response",
        caption="Largest distance from the axis at each place over the speed, along the branches "
        "of steady motion; thin where they repeat after several turns. Unstable motions are "
        "dashed; dotted lines are jumps, down or up from where a stable branch ends.",
        alt=f"Largest radius over the speed, up to {factor * largest:.4g} {unit}, with "
        f"{len(jumps)} jumps; the table of jumps has their numbers.",
        x=charts.speed_axis(float(speeds.min()), float(speeds.max())),
        y=charts.Axis(label="largest radius", unit=unit, low=0.0, high=1.05 * factor * largest,
                      digits=".4g"),
        parts=marks,
        height_px=460,
    )  # fmt: skip


def _curves(
    branches: Sequence[BranchCurves],
    place: str,
    told: tuple[str, float, bool],
    look: charts.Look,
) -> Iterator[charts.Curve]:
    """Yield the stable and the unstable motions at a place; `told`: name, unit, if it waits."""
    name, factor, quiet = told
    for stable, dash in ((True, "solid"), (False, "dash")):
        x, y = _parts(branches, place, stable)
        if x.size:
            own = name if stable else f"{name}, unstable"
            drawn = replace(look, dash=dash)
            yield charts.Curve(x=x, y=factor * y, name=own, look=drawn, is_quiet=quiet)


def _parts(
    branches: Sequence[BranchCurves], place: str, stable: bool
) -> tuple[FloatArray, FloatArray]:
    """Pieces of branches that are stable or not, with gaps between them."""
    xs, ys = [], []
    for branch in branches:
        own = branch.is_stable.copy()
        # a turning point belongs to the stable part beside it
        for at in np.flatnonzero(branch.is_turning[1:-1]) + 1:
            own[at] = branch.is_stable[at - 1] | branch.is_stable[at + 1]
        step = (own[1:] & own[:-1]) == stable
        shown = np.concatenate((step, [False])) | np.concatenate(([False], step))
        radius = branch.radius_m[place]
        for group in np.split(np.arange(own.size), np.flatnonzero(~step) + 1):
            group = group[shown[group]]
            if group.size > 1:
                xs.append(np.append(branch.speed_rpm[group], np.nan))
                ys.append(np.append(radius[group], np.nan))
    if not xs:
        return np.empty(0), np.empty(0)
    return np.concatenate(xs)[:-1], np.concatenate(ys)[:-1]
