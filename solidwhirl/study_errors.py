"""Diagrams and critical speeds as plain data, and how those of one case differ from the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from solidwhirl.pipeline import Results
from solidwhirl.rotordyn import Campbell, CriticalSpeed, campbell, critical_speeds
from solidwhirl.rotordyn.differences import campbell_differences, critical_speed_differences

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int_]
Document = Mapping[str, Any]

# Branches and speed range that the truth has more, so that those at the edge find their partners.
_MORE_BRANCHES, _MORE_HZ, _MORE_SPEED = 4, 1.3, 1.05
# Frequencies below this share of the largest are those of motions that nothing holds.
_FREE = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class MatchedErrors:
    """How the branches of a model differ from the truth.

    Attributes
    ----------
    partner
        Branch of the truth for each of the model's, -1 for none, (b,).
    error
        f / f_truth - 1, (b, s); nan without a partner.
    """

    partner: IntArray
    error: FloatArray


def diagram_document(diagram: Campbell) -> dict[str, Any]:
    """Return a Campbell diagram as plain data."""
    return {
        "speed_rad_s": diagram.speeds_rad_s.tolist(),
        "frequency_hz": _numbers(diagram.frequency_hz),
        "whirl": diagram.whirl.tolist(),
    }


def critical_document(critical: Sequence[CriticalSpeed]) -> list[dict[str, Any]]:
    """Return critical speeds as plain data."""
    return [
        {
            "speed_rad_s": float(c.speed_rad_s),
            "frequency_hz": float(c.frequency_hz),
            "whirl": str(c.whirl),
        }
        for c in critical
    ]


def wider_diagram(results: Results) -> Campbell:
    """Return the diagram of a run with some branches more, for others to be held against."""
    top = results.scene.campbell.frequency_max_hz
    speeds = results.plan.speeds_rad_s
    if top is not None:
        return campbell(results.system, speeds, frequency_max_hz=_MORE_HZ * top)
    count = len(results.campbell.frequency_hz) + _MORE_BRANCHES
    return campbell(results.system, speeds, branch_count=count)


def wider_critical_speeds(results: Results) -> list[CriticalSpeed]:
    """Return the critical speeds of a run a little beyond its range."""
    top = _MORE_SPEED * float(results.plan.speeds_rad_s.max())
    if top == 0.0:
        return []
    top = min(top, results.system.speed_limit_rad_s)
    ratios = sorted({abs(r) for r in results.scene.speed_ratios().values() if r})
    return [
        c
        for ratio in ratios
        for c in critical_speeds(results.system, excitation_ratio=ratio, speed_max_rad_s=top)
    ]


def matched_errors(model: Document, truth: Document) -> MatchedErrors:
    """Return the relative errors of the branches of a model.

    Parameters
    ----------
    model, truth
        From `diagram_document`, over the same speeds. Branches that are near zero frequency
        everywhere (free motions) are left out of the model's.
    """
    first, second = _held(_diagram(model)), _held(_diagram(truth))
    found = campbell_differences(first, second)
    # differences are relative to the model; errors to the truth
    return MatchedErrors(partner=found.partner, error=found.frequency / (1.0 - found.frequency))


def critical_errors(
    model: Sequence[Document], truth: Sequence[Document]
) -> tuple[IntArray, FloatArray]:
    """Return partners and relative errors of critical speeds, (k,) each, nan without a partner.

    Parameters
    ----------
    model, truth
        From `critical_document`.
    """
    found = critical_speed_differences(_criticals(model), _criticals(truth))
    return found.partner, np.asarray(found.speed / (1.0 - found.speed))


def held_branches(model: Document) -> npt.NDArray[np.bool_]:
    """Return which branches of a diagram are not those of free motions, (b,)."""
    return _not_free(_diagram(model))


def _numbers(values: FloatArray) -> list[list[float | None]]:
    """Plain lists; JSON has no nan."""
    return [[float(v) if np.isfinite(v) else None for v in row] for row in values]


def as_array(rows: Sequence[Any]) -> FloatArray:
    """Return numbers from JSON as an array, null as nan."""
    return np.array(rows, dtype=float)


def _diagram(data: Document) -> Campbell:
    frequency = as_array(data["frequency_hz"])
    return Campbell(
        speeds_rad_s=np.array(data["speed_rad_s"], dtype=float),
        eigenvalues=2j * np.pi * frequency,
        frequency_hz=frequency,
        log_decrement=np.zeros_like(frequency),
        whirl=np.array(data["whirl"], dtype=str),
        overlap=np.ones_like(frequency),
        notes=(),
    )


def _not_free(diagram: Campbell) -> npt.NDArray[np.bool_]:
    highest = np.nanmax(np.where(np.isfinite(diagram.frequency_hz), diagram.frequency_hz, 0.0), 1)
    return np.asarray(highest > _FREE * highest.max(initial=0.0))


def _held(diagram: Campbell) -> Campbell:
    keep = _not_free(diagram)
    names = ("eigenvalues", "frequency_hz", "log_decrement", "whirl", "overlap")
    return replace(diagram, **{name: getattr(diagram, name)[keep] for name in names})


def _criticals(data: Sequence[Document]) -> list[CriticalSpeed]:
    return [
        CriticalSpeed(
            speed_rad_s=c["speed_rad_s"],
            frequency_hz=c["frequency_hz"],
            whirl=c["whirl"],
            shape=np.zeros(1, dtype=complex),
            log_decrement=0.0,
        )
        for c in data
    ]
