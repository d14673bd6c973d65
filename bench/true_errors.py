"""Errors of a run against a far finer run of the same scene, beside what the run estimates."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.pipeline.run import Results, run_scene
from solidwhirl.rotordyn import campbell, critical_speeds, modes_at_speed
from solidwhirl.rotordyn.estimates.campbell_errors import campbell_errors
from solidwhirl.rotordyn.estimates.critical_speed_errors import critical_speed_errors
from solidwhirl.rotordyn.estimates.differences import (
    campbell_differences,
    critical_speed_differences,
)
from solidwhirl.rotordyn.estimates.eigenvalue_errors import frequency_errors
from solidwhirl.scene.records import Scene

#: A reference is asked for this fraction of the finest accuracy, with elements of this order.
FINER, REFERENCE_ORDER = 0.05, 4
#: Errors below this are rounding.
ROUND_OFF = 1e-9
# The reference has so many branches more, and its critical speeds go so much higher.
_MORE, _HIGHER = 4, 1.03


@dataclass(frozen=True, kw_only=True)
class Pair:
    """One frequency of a run: what it is estimated to be wrong by, and what it is wrong by.

    Attributes
    ----------
    kind
        "campbell", "critical_speed" or "at_rest".
    place
        Branch and speed, or number in the list.
    frequency_hz
        Of the run.
    estimate, parts
        Relative: total, and by part.
    true
        |f - f_ref| / f.
    doubt
        What the reference itself is estimated to be wrong by.
    """

    kind: str
    place: tuple[int, ...]
    frequency_hz: float
    estimate: float
    parts: dict[str, float]
    true: float
    doubt: float

    @property
    def effectivity(self) -> float:
        """Estimate over error."""
        return self.estimate / self.true

    @property
    def known(self) -> bool:
        """Whether the reference is good enough to tell the error: to a fifth of it."""
        return self.true > ROUND_OFF and self.doubt < 0.2 * max(self.true, self.estimate / 3.0)


def run(scene: Scene, **model: object) -> tuple[Results, float]:
    """Run the harmonic level of a scene without its analyses; results and processor time [s].

    Parameters
    ----------
    scene
        The scene.
    model
        Entries of [model] to replace.
    """
    own = scene.model.model_copy(update={"level": "harmonic", "compare_coupling": "off", **model})
    start = time.process_time()
    results = run_scene(scene.model_copy(update={"model": own, "analyses": ()}))
    assert results is not None
    return results, time.process_time() - start


def reference(scene: Scene, finest: float) -> tuple[Results, float]:
    """Run a scene so finely that errors of runs down to an accuracy can be told.

    Parameters
    ----------
    scene
        The scene.
    finest
        Finest accuracy of the runs.
    """
    accuracy = max(FINER * finest, 1e-6)
    return run(scene, accuracy=accuracy, order=REFERENCE_ORDER)


def pairs(results: Results, finer: Results) -> list[Pair]:
    """Compare a run with its reference.

    Parameters
    ----------
    results
        Of a scene, with estimates.
    finer
        Its reference.
    """
    return [
        *_of_campbell(results, finer),
        *_of_critical_speeds(results, finer),
        *_at_rest(results, finer),
    ]


def largest(found: Sequence[Pair], attribute: str) -> float:
    """Largest estimate or error of the diagram and the critical speeds."""
    return max((getattr(p, attribute) for p in found if p.kind != "at_rest"), default=0.0)


def _of_campbell(results: Results, reference: Results) -> list[Pair]:
    mine = results.campbell
    count = len(mine.frequency_hz) + _MORE
    finer = campbell(reference.system, mine.speeds_rad_s, branch_count=count)
    doubt = campbell_errors(reference.system, finer).total
    difference = campbell_differences(mine, finer)
    errors = results.estimates.campbell
    out = []
    for b, s in zip(*np.nonzero(np.isfinite(difference.frequency)), strict=True):
        out.append(
            Pair(
                kind="campbell",
                place=(int(b), int(s)),
                frequency_hz=float(mine.frequency_hz[b, s]),
                estimate=float(errors.total[b, s]),
                parts={name: float(values[b, s]) for name, values in errors.parts.items()},
                true=float(abs(difference.frequency[b, s])),
                doubt=float(doubt[difference.partner[b], s]),
            )
        )
    return out


def _of_critical_speeds(results: Results, reference: Results) -> list[Pair]:
    mine = [c.critical for c in results.critical_speeds]
    top = _HIGHER * float(results.campbell.speeds_rad_s.max())
    top = min(top, reference.system.speed_limit_rad_s)
    ratios = {round(2.0 * np.pi * c.frequency_hz / c.speed_rad_s, 9) for c in mine}
    finer = [
        c
        for ratio in sorted(ratios)
        for c in critical_speeds(reference.system, excitation_ratio=ratio, speed_max_rad_s=top)
    ]
    doubt = critical_speed_errors(reference.system, finer).total
    difference = critical_speed_differences(mine, finer)
    errors = results.estimates.critical_speeds
    return [
        Pair(
            kind="critical_speed",
            place=(int(k),),
            frequency_hz=mine[k].frequency_hz,
            estimate=float(errors.total[k]),
            parts={name: float(values[k]) for name, values in errors.parts.items()},
            true=float(abs(difference.speed[k])),
            doubt=float(doubt[difference.partner[k]]),
        )
        for k in np.flatnonzero(np.isfinite(difference.speed))
    ]


def _at_rest(results: Results, reference: Results) -> list[Pair]:
    """As many modes at rest as the diagram has branches, in the order of their frequencies."""
    finer = modes_at_speed(reference.system, 0.0)
    doubt = frequency_errors(reference.system, finer).total
    mine, errors = results.at_rest, results.estimates.at_rest
    count = min(len(results.campbell.frequency_hz), len(mine.frequency_hz))
    return [
        Pair(
            kind="at_rest",
            place=(k,),
            frequency_hz=float(mine.frequency_hz[k]),
            estimate=float(errors.total[k]),
            parts={name: float(values[k]) for name, values in errors.parts.items()},
            true=float(abs(finer.frequency_hz[k] / mine.frequency_hz[k] - 1.0)),
            doubt=float(doubt[k]),
        )
        for k in range(count)
    ]
