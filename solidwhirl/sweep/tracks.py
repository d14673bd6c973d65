"""Critical speeds and other single numbers of a sweep, as columns over its cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.core.key_units import label_of
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.matching import Kind, match_curves
from solidwhirl.sweep.records import BatchRow

# Ratios of frequency and speed closer than this are those of one shaft.
_SAME_RATIO = 1e-4
# Columns that differ by less, relative, are constant.
_CONSTANT = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CriticalTrack(ReadOnlyArrays):
    """One critical speed through all cases (n)."""

    number: int  # from 1 by rising median speed
    whirl: str  # the most frequent whirl; all of them joined by "/" if they differ
    excitation_ratio: float  # frequency over speed of the reference shaft, median
    # speed_rpm, frequency_hz, error_estimate: by case, nan where it was not found; the error is
    # relative, nan if not known
    speed_rpm: FloatArray
    frequency_hz: FloatArray
    error_estimate: FloatArray
    doubtful: BoolArray

    @property
    def name(self) -> str:
        """Such as "critical speed 2, backward", with the ratio where it is not 1."""
        same = abs(self.excitation_ratio - 1.0) < _SAME_RATIO
        ratio = "" if same else f", {self.excitation_ratio:.4g}×"
        return f"critical speed {self.number}, {self.whirl}{ratio}"


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Quantity(ReadOnlyArrays):
    """One number of every case."""

    name: str  # critical speed or response
    label: str  # with the unit
    values: FloatArray  # by case (n), nan where absent
    doubtful: BoolArray  # cases in which it may be another critical speed's


def critical_tracks(design: SweepDesign) -> tuple[CriticalTrack, ...]:
    """Return the critical speeds of a sweep, matched through its cases.

    `design`: the cases. Critical speeds are told apart by the shaft that excites them (frequency
    over speed), then matched by their shapes and speeds; by whirl and speed where rows have no
    shapes. See `match_curves`.
    """
    rows = design.rows
    curves = [np.array(r.critical_speed_rpm, dtype=float).reshape(-1, 1) for r in rows]
    kinds = _kinds(rows)
    shapes = shapes_of(
        [row.critical_motion for row in rows], [len(row.critical_speed_rpm) for row in rows]
    )
    # the shape tells the whirl, which may change from case to case
    apart = kinds if shapes is None else [[(n, "") for n, _ in own] for own in kinds]
    found = match_curves(design.scaled, curves, apart, shapes)
    tracks = []
    for number, index in enumerate(found.index):
        speed = _column(rows, "critical_speed_rpm", index)
        frequency = _column(rows, "critical_frequency_hz", index)
        whirls = Counter(kinds[c][k][1] for c, k in enumerate(index) if k >= 0)
        tracks.append(
            CriticalTrack(
                number=number + 1,
                whirl="/".join(w for w, _ in whirls.most_common()),
                excitation_ratio=float(np.nanmedian(60.0 * frequency / speed)),
                speed_rpm=speed,
                frequency_hz=frequency,
                error_estimate=_column(rows, "critical_error_estimate", index),
                doubtful=found.doubtful[number],
            )
        )
    return tuple(tracks)


def quantities(design: SweepDesign, tracks: Sequence[CriticalTrack]) -> tuple[Quantity, ...]:
    """Return critical speeds, then responses that are found in two cases and differ there."""
    found = [
        Quantity(name=t.name, label=f"{t.name} [rpm]", values=t.speed_rpm, doubtful=t.doubtful)
        for t in tracks
    ]
    keys = dict.fromkeys(k for row in design.rows for k in row.responses)
    # what a design review asks for comes first
    for key in sorted(keys, key=lambda k: not k.startswith("verdict.")):
        values = np.array([row.responses.get(key, np.nan) for row in design.rows], dtype=float)
        sure = np.zeros(len(values), dtype=bool)
        found.append(Quantity(name=key, label=label_of(key), values=values, doubtful=sure))
    return tuple(q for q in found if _differs(q.values) and not _is_truth(q.values))


def _is_truth(values: FloatArray) -> bool:
    """Whether a number is a yes or no, such as whether a case is stable: it has no gradient."""
    return set(values[np.isfinite(values)].tolist()) <= {0.0, 1.0}


def _differs(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return bool(known.size >= 2 and np.ptp(known) > _CONSTANT * np.abs(known).max())


def _column(rows: Sequence[BatchRow], key: str, index: Sequence[int]) -> FloatArray:
    values = [getattr(row, key) for row in rows]
    return np.array(
        [v[k] if 0 <= k < len(v) else np.nan for v, k in zip(values, index, strict=True)],
        dtype=float,
    )


def shapes_of(
    motions: Sequence[Sequence[Sequence[float]]], counts: Sequence[int]
) -> list[ComplexArray] | None:
    """Return motions of the same places in the modes of all cases; None if not all have them.

    `motions`: by case and mode, from `solidwhirl.rotordyn.campbell.branch_numbers`. `counts`: modes
    of each case.
    """
    lengths = {len(motion) for own in motions for motion in own}
    whole = [len(own) for own in motions] == list(counts)
    if len(lengths) != 1 or lengths == {0} or not whole:
        return None
    (length,) = lengths
    return [np.array(own, dtype=float).reshape(-1, length).view(complex) for own in motions]


def _kinds(rows: Sequence[BatchRow]) -> list[list[Kind]]:
    """Number of the ratio of frequency and speed, and whirl, of all critical speeds."""
    ratios = [
        60.0 * np.array(r.critical_frequency_hz) / np.array(r.critical_speed_rpm) for r in rows
    ]
    groups = [_clusters(r) for r in ratios]
    together = _clusters(np.concatenate(ratios)) if rows else np.zeros(0)
    most = max((len(set(g.tolist())) for g in groups), default=0)
    if len(set(together.tolist())) == most:
        ends = np.cumsum([len(r) for r in ratios])[:-1]
        groups = np.split(together, ends)
    # else the ratios themselves are varied, and each case numbers its own by their size
    return [
        [(int(g), str(w) or "no whirl") for g, w in zip(group, row.critical_whirl, strict=True)]
        for group, row in zip(groups, rows, strict=True)
    ]


def _clusters(ratios: FloatArray) -> FloatArray:
    """Number of the cluster of each ratio, by rising ratio."""
    if not len(ratios):
        return np.zeros(0)
    order = np.argsort(ratios)
    number = np.zeros(len(ratios))
    number[order[1:]] = np.cumsum(np.diff(ratios[order]) > _SAME_RATIO * ratios[order[1:]])
    return number
