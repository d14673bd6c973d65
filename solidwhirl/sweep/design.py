"""What the cases of a sweep vary: parameters, their scales, and whether it is a grid or samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray, ReadOnlyArrays
from solidwhirl.scene.sweep import SAMPLED
from solidwhirl.sweep.records import BatchRow

DesignKind = Literal["none", "one_at_a_time", "samples"]

# A parameter that spans less than this factor is never drawn over its logarithm.
_LEAST_SPAN = 5.0


class SweepPictureError(ValueError):
    """Rows or settings of which no picture can be made; the message says why."""


@dataclass(frozen=True, kw_only=True)
class SweepParameter:
    """One parameter that differs between the cases."""

    name: str  # as in the sweep
    choices: tuple[str, ...]  # the words it takes, in order of appearance; empty for a number
    logarithmic: bool  # whether its values are spread by factors rather than by differences


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class SweepDesign(ReadOnlyArrays):
    """The cases of one scene."""

    scene: str  # name of the scene
    rows: tuple[BatchRow, ...]  # cases that are done (n), in the order of the table
    left_out: tuple[BatchRow, ...]  # those that failed or whose checks failed
    parameters: tuple[SweepParameter, ...]  # parameters of more than one value (d)
    # values, left_out_values: values, (n, d) and (left out, d); the number of the choice for words
    values: FloatArray
    left_out_values: FloatArray
    # Coordinates for distances between cases, (n, columns): numbers from 0 to 1, their logarithm
    # where spread by factors; one column for each word
    scaled: FloatArray
    # `one_at_a_time`: from the baseline every parameter is varied alone; `samples`: not so; `none`:
    # nothing varies
    kind: DesignKind
    baseline: int  # row that the others are held against; -1 without

    @property
    def every_row(self) -> tuple[BatchRow, ...]:
        """Return all cases that have a row."""
        return (*self.rows, *self.left_out)

    @property
    def missing(self) -> int:
        """Return how many cases of the sweep have no row; 0 where the rows do not tell."""
        rows = self.every_row
        return max(max(row.sweep_cases for row in rows) - len(rows), 0)

    def number(self, name: str) -> int:
        """Return the column of a parameter.

        Raises SweepPictureError: if the parameter does not vary.
        """
        names = [p.name for p in self.parameters]
        if name not in names:
            raise SweepPictureError(
                f"{self.scene}: {name!r} is no parameter that varies; these do: {names}"
            )
        return names.index(name)


def sweep_designs(
    rows: Sequence[BatchRow], design: Literal["auto", "grid", "samples"] = "auto"
) -> tuple[SweepDesign, ...]:
    """Return the designs of the scenes of a table.

    `rows`: of any number of scenes. `design`: what the cases are; "auto" goes by the method of the
    sweep: Latin hypercubes and Sobol's points are samples. Grids and lists, and rows that do not
    tell, are varied one at a time if a case is there from which every parameter is varied alone,
    else they count as samples.
    """
    scenes = dict.fromkeys(row.scene for row in rows)
    return tuple(_design([row for row in rows if row.scene == s], design) for s in scenes)


def _design(rows: Sequence[BatchRow], asked: str) -> SweepDesign:
    names = dict.fromkeys(name for row in rows for name in row.values)
    for row in rows:
        if missing := [name for name in names if name not in row.values]:
            raise SweepPictureError(f"{row.case}: no value of {missing}, which other cases have")
    varied = [name for name in names if len({row.values[name] for row in rows}) > 1]
    parameters = tuple(_parameter(name, rows) for name in varied)
    done = [row for row in rows if row.status == "done"]
    left_out = [row for row in rows if row.status != "done"]
    values, failed = (_values(part, parameters) for part in (done, left_out))
    scaled = _scaled(values, np.vstack([values, failed]), parameters)
    if asked == "auto" and rows[0].method in SAMPLED:
        asked = "samples"
    kind, baseline = _kind(values, parameters, asked)
    return SweepDesign(
        scene=rows[0].scene,
        rows=tuple(done),
        left_out=tuple(left_out),
        parameters=parameters,
        values=values,
        left_out_values=failed,
        scaled=scaled,
        kind=kind,
        baseline=baseline,
    )


def _parameter(name: str, rows: Sequence[BatchRow]) -> SweepParameter:
    values = [row.values[name] for row in rows]
    if any(isinstance(v, str) for v in values):
        return SweepParameter(
            name=name, choices=tuple(dict.fromkeys(str(v) for v in values)), logarithmic=False
        )
    numbers = np.array(values, dtype=float)
    if not np.isfinite(numbers).all():
        raise SweepPictureError(f"{name}: values that are not finite, such as in {rows[0].scene}")
    return SweepParameter(name=name, choices=(), logarithmic=_spread_by_factors(numbers))


def _spread_by_factors(values: FloatArray) -> bool:
    """Whether the median lies nearer to the geometric middle of the range than to its middle."""
    low, middle, high = values.min(), np.median(np.unique(values)), values.max()
    if low <= 0.0 or high < _LEAST_SPAN * low:
        return False
    off_plain = abs(middle - 0.5 * (low + high)) / (high - low)
    off_log = abs(np.log(middle / np.sqrt(low * high))) / np.log(high / low)
    return bool(off_log < off_plain)


def _values(rows: Sequence[BatchRow], parameters: Sequence[SweepParameter]) -> FloatArray:
    found = [
        [
            float(p.choices.index(str(row.values[p.name])) if p.choices else row.values[p.name])
            for p in parameters
        ]
        for row in rows
    ]
    return np.array(found, dtype=float).reshape(len(rows), len(parameters))


def _scaled(
    values: FloatArray, everything: FloatArray, parameters: Sequence[SweepParameter]
) -> FloatArray:
    columns = [np.zeros((len(values), 0))]
    for number, p in enumerate(parameters):
        column, whole = values[:, number], everything[:, number]
        if p.choices:
            # two different words are one apart
            words = column[:, None] == np.arange(len(p.choices))
            columns.append(words / np.sqrt(2.0))
            continue
        if p.logarithmic:
            column, whole = np.log(column), np.log(whole)
        columns.append(((column - whole.min()) / np.ptp(whole))[:, None])
    return np.hstack(columns)


def _kind(
    values: FloatArray, parameters: Sequence[SweepParameter], asked: str
) -> tuple[DesignKind, int]:
    if not parameters or len(values) < 2:
        return "none", -1
    if asked == "samples":
        return "samples", -1
    # by case and parameter: how many others differ in that alone
    differ = (values != own for own in values)
    alone = np.array([d[d.sum(axis=1) == 1].sum(axis=0) for d in differ])
    # the case from which most parameters can be varied alone, then most cases, then the middle
    level = np.column_stack([np.unique(column, return_inverse=True)[1] for column in values.T])
    off = np.abs(level - 0.5 * level.max(axis=0)).sum(axis=1)
    best = np.lexsort((off, -alone.sum(axis=1), -(alone > 0).sum(axis=1)))[0]
    lacking = [p.name for p, n in zip(parameters, alone[best], strict=True) if not n]
    if not lacking:
        return "one_at_a_time", int(best)
    if asked == "grid":
        raise SweepPictureError(f"no grid: nowhere {lacking} is varied alone")
    return "samples", -1
