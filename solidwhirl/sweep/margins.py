"""Separation margins over two parameters of a sweep, between its cases by their critical speeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import QhullError

from solidwhirl.core.key_units import unit_of
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.tracks import CriticalTrack, Quantity

_ACROSS, _UP = 161, 121
# A grid with more holes than this share is none.
_FILLED = 0.7


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MarginMap(ReadOnlyArrays):
    """Least separation margin over two parameters."""

    title: str  # what the margin is of
    # x_name, y_name: the parameters
    x_name: str
    y_name: str
    # x, y: places of the map, empty without one
    x: FloatArray
    y: FloatArray
    # Least |margin| as a fraction, (y, x); nan outside the samples and where there is none
    margin: FloatArray
    case_margin: FloatArray  # margins of the cases themselves; nan where none is known
    # Parameters of which the map takes the least; without a map those that vary too
    least_over: tuple[str, ...]
    notes: tuple[str, ...]  # what a reader must know


def band_margin(speed_rpm: FloatArray, operating_rpm: tuple[float, float]) -> FloatArray:
    """Return (N_c - N_op) / N_op from the nearer end of a band, 0 inside it.

    `speed_rpm`: critical speeds of the reference shaft. `operating_rpm`: lowest and highest speed
    at which it runs; equal for a single speed.
    """
    low, high = operating_rpm
    below, above = (speed_rpm - low) / low, (speed_rpm - high) / high
    return np.where(speed_rpm < low, below, np.where(speed_rpm > high, above, 0.0 * speed_rpm))


def searched_rpm(design: SweepDesign) -> FloatArray:
    """Return by case the speed up to which critical speeds are known: the end of its diagram."""
    return np.array([max(row.campbell_speed_rpm, default=np.nan) for row in design.rows])


def margin_maps(
    design: SweepDesign,
    tracks: Sequence[CriticalTrack],
    others: Sequence[Quantity],
    operating_rpm: tuple[float, float] | None,
    pairs: Sequence[tuple[str, str]],
) -> tuple[MarginMap, ...]:
    """Return the maps of separation margins of a sweep.

    `design`, `tracks`: the cases and their critical speeds. `others`: responses; those whose name
    ends in "margin" are mapped where no operating speeds are given. `operating_rpm`: band of the
    reference shaft's speed. `pairs`: names of the parameters across and up.

    Between the cases every critical speed is interpolated linearly, and the margins are taken
    there: a band that lies between the critical speeds of two cases is not missed, as it
    would be between their margins. Critical speeds are known up to the end of the Campbell diagram
    alone: it counts as one, so that no margin is larger than what was searched. Critical speeds
    above the band that are not found in a case are taken to lie there.
    """
    if operating_rpm is not None:
        found = [_speed_map(design, tracks, operating_rpm, pair) for pair in pairs]
    else:
        known = [quantity for quantity in others if quantity.name.endswith("margin")]
        found = [_response_map(design, quantity, pair) for pair in pairs for quantity in known]
    return tuple(one for one in found if one is not None)


def parameter_pairs(
    design: SweepDesign, ranking: Sequence[str], most: int = 3
) -> tuple[tuple[str, str], ...]:
    """Return the pairs of parameters worth a map: numbers, the most influential first.

    `ranking`: names of parameters, the most influential first; others follow.
    """
    numbers = [p.name for p in design.parameters if not p.choices]
    ordered = list(dict.fromkeys([n for n in ranking if n in numbers] + numbers))
    pairs = sorted(combinations(range(len(ordered)), 2), key=lambda p: (p[1], p[0]))
    return tuple((ordered[a], ordered[b]) for a, b in pairs[:most])


def _least(values: FloatArray) -> FloatArray:
    """Smallest along the first axis, nan where all are."""
    found = np.where(np.isnan(values), np.inf, values).min(axis=0, initial=np.inf)
    return np.where(np.isinf(found), np.nan, found)


def _speed_map(
    design: SweepDesign,
    tracks: Sequence[CriticalTrack],
    operating_rpm: tuple[float, float],
    pair: tuple[str, str],
) -> MarginMap | None:
    low, high = operating_rpm
    band = f"{low:g} rpm" if low == high else f"{low:g} to {high:g} rpm"
    end = searched_rpm(design)
    columns, notes = [np.where(end > high, end, np.nan)], []
    known = end[end > high]
    if known.size:
        notes.append(
            f"searched up to {known.min():.0f} rpm: margins of {100 * (known.min() / high - 1):.0f}"
            " % and more are at least that"
        )
    for track in tracks:
        found = np.isfinite(track.speed_rpm)
        above = bool((track.speed_rpm[found] > high).all())
        columns.append(np.where(found, track.speed_rpm, end if above else np.nan))
        if not found.all() and not above:
            notes.append(f"{track.name} is not seen around cases where it was not found")
    doubtful = int(np.any([t.doubtful for t in tracks], axis=0).sum()) if tracks else 0
    if doubtful:
        notes.append(f"critical speeds of {doubtful} cases matched ambiguously")
    # of a case that was not searched beyond the band no margin is known
    speeds = np.where(end > high, np.array(columns), np.nan)
    return _map(
        design,
        pair,
        speeds,
        lambda values: _least(np.abs(band_margin(values, operating_rpm))),
        f"all critical speeds from {band}",
        notes,
    )


def _response_map(
    design: SweepDesign, quantity: Quantity, pair: tuple[str, str]
) -> MarginMap | None:
    scale = 0.01 if unit_of(quantity.name) == "%" else 1.0
    return _map(
        design, pair, scale * quantity.values[None], lambda v: _least(np.abs(v)), quantity.name, []
    )


def _map(
    design: SweepDesign,
    pair: tuple[str, str],
    columns: FloatArray,
    margin: Callable[[FloatArray], FloatArray],
    title: str,
    notes: list[str],
) -> MarginMap | None:
    """One map, with its places if the cases fill the plane; none without a case to show."""
    own = margin(columns)
    if not np.isfinite(own).any():
        return None
    numbers = [design.number(name) for name in pair]
    if (np.ptp(design.values[:, numbers], axis=0) == 0.0).any():
        return None  # it varies among the cases left out alone
    rest = [k for k in range(len(design.parameters)) if k not in numbers]
    axes = [_axis(design, k, n) for k, n in zip(numbers, (_ACROSS, _UP), strict=True)]
    sheets = _sheets(design, numbers, rest)
    every = (_sheet(design, numbers, columns[:, c], c, axes) for c in sheets)
    found = [sheet for sheet in every if sheet is not None]
    if not found:
        why = "samples that differ in more" if design.kind == "samples" else "no grid of both"
        notes = [*notes, f"no contours: {why}" + (" parameters" if rest else "")]
    return MarginMap(
        title=title,
        x_name=pair[0],
        y_name=pair[1],
        x=axes[0] if found else np.zeros(0),
        y=axes[1] if found else np.zeros(0),
        margin=_least(np.array([margin(s) for s in found])) if found else np.zeros((0, 0)),
        case_margin=own,
        least_over=tuple(design.parameters[k].name for k in rest),
        notes=tuple(notes),
    )


def _axis(design: SweepDesign, parameter: int, count: int) -> FloatArray:
    low, high = design.values[:, parameter].min(), design.values[:, parameter].max()
    spread = np.geomspace if design.parameters[parameter].logarithmic else np.linspace
    return np.asarray(spread(low, high, count))


def _sheets(design: SweepDesign, numbers: list[int], rest: list[int]) -> list[IntArray]:
    """Cases that differ in the two parameters alone and fill their plane, by the others' values."""
    if design.kind == "samples":
        return [] if rest else [np.arange(len(design.rows))]
    _, sheet = np.unique(design.values[:, rest], axis=0, return_inverse=True)
    cells = int(np.prod([len(np.unique(design.values[:, k])) for k in numbers]))
    parts = [np.flatnonzero(sheet == s) for s in np.unique(sheet)]
    return [p for p in parts if len(p) >= max(3.0, _FILLED * cells)]


def _sheet(
    design: SweepDesign,
    numbers: list[int],
    columns: FloatArray,
    cases: IntArray,
    axes: list[FloatArray],
) -> FloatArray | None:
    """Columns at all places of the map, (columns, y, x); None if the cases lie on a line."""
    places, targets = [], []
    for k, axis in zip(numbers, axes, strict=True):
        take = np.log if design.parameters[k].logarithmic else np.asarray
        low, span = take(axis[0]), np.ptp(take(axis))
        places.append((take(design.values[cases, k]) - low) / span)
        targets.append((take(axis) - low) / span)
    x, y = np.meshgrid(*targets)
    try:
        found = LinearNDInterpolator(np.column_stack(places), columns.T)(x, y)
    except QhullError:
        return None
    return np.asarray(np.moveaxis(found, -1, 0))
