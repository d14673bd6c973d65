"""Picture of what takes part in modes: shares of bodies and joints in their energies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.participation import Participation
from solidwhirl.rotordyn.plots.frame import (
    COLORS,
    SMALL_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    draw_grid,
    mode_name,
    new_figure,
    styled,
    write_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Of bodies, and of joints.
_BODY_HATCHES = ("", "....", "----", "||||", "**")
_JOINT_HATCHES = ("//////", "\\\\\\\\\\\\", "xxxx", "++++", "oo", "OO")
# Joints with a smaller part of every mode are drawn as one.
_NO_BAR = 0.005
_MOST_BARS = 16


@styled
def draw_participation(
    result: Participation,
    path: str | Path,
    title: str,
    *,
    numbers: Sequence[int] | None = None,
) -> None:
    """Draw the shares of bodies and joints in the energies of the modes as bars.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    result
        At most 16 modes. Centrifugal parts count to their body; negative ones lie below zero.
        Joints with less than 0.5 % of every mode are drawn as one.
    numbers
        What the modes are called, 0 for no number; None counts them.

    Raises
    ------
    AnalysisError
        If there are no modes or too many.
    """
    count = result.eigenvalues.size
    if not 1 <= count <= _MOST_BARS:
        raise AnalysisError(f"there are {count} modes; 1 to {_MOST_BARS} can be drawn")
    figure = new_figure(path, TWO_COLUMNS_MM, 124.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    bodies = result.strain_bodies + result.centrifugal_bodies
    _stack(upper, result.kinetic_bodies, result.bodies, 0)
    _stack(lower, bodies, result.bodies, 0)
    joints, large = _large_joints(result)
    _stack(lower, joints, large, len(result.bodies), below=bodies)
    upper.set_ylabel("share of the\nkinetic energy [1]")
    lower.set_ylabel("share of the\npotential energy [1]")
    hertz = result.eigenvalues.imag / (2.0 * np.pi)
    lower.set_xticks(
        range(count),
        [f"{mode_name(numbers, k)}\n{f:.4g}" for k, f in enumerate(hertz)],
        fontsize=SMALL_PT,
    )
    lower.set_xlabel("mode, frequency [Hz]")
    for axes in (upper, lower):
        axes.axhline(0.0, color="black", linewidth=0.6)
        axes.set_ylim(*_with_room(axes.get_ylim()))
        draw_grid(axes, "major", "y")
    figure.suptitle(fill(title, 80), fontsize=TITLE_PT)
    handles, labels = lower.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False, fontsize=SMALL_PT)
    write_figure(figure, path)


def _large_joints(result: Participation) -> tuple[FloatArray, list[str]]:
    """Return the shares and names of the joints, small ones summed up at the end."""
    shares = np.nan_to_num(result.strain_joints)
    large = (np.abs(shares) >= _NO_BAR).any(axis=1)
    names = [name for name, kept in zip(result.joints, large, strict=True) if kept]
    if large.all():
        return shares, names
    others = shares[~large].sum(axis=0, keepdims=True)
    return np.vstack((shares[large], others)), [*names, "other joints"]


def _stack(
    axes: Axes,
    shares: FloatArray,
    names: Sequence[str],
    place: int,
    below: FloatArray | None = None,
) -> None:
    """Draw bars on top of each other, negative parts under zero; joints above the bodies."""
    modes = np.arange(shares.shape[1])
    before = np.zeros((0, modes.size)) if below is None else below
    positive, negative = (f(before, 0.0).sum(axis=0) for f in (np.maximum, np.minimum))
    hatches = _BODY_HATCHES if below is None else _JOINT_HATCHES
    for order, (row, name) in enumerate(zip(np.nan_to_num(shares), names, strict=True)):
        axes.bar(
            modes,
            row,
            bottom=np.where(row >= 0, positive, negative),
            width=0.7,
            color=COLORS[(place + order) % len(COLORS)],
            hatch=hatches[order % len(hatches)],
            edgecolor="white",
            linewidth=0.5,
            label=name,
        )
        positive, negative = positive + np.maximum(row, 0.0), negative + np.minimum(row, 0.0)


def _with_room(limits: tuple[float, float]) -> tuple[float, float]:
    """Limits of shares that hold 0 and 1 with room above."""
    low, high = min(limits[0], 0.0), max(limits[1], 1.0)
    return low, high + 0.04 * (high - low)
