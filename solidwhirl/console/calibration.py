"""The calibration of forecasts: standard jobs in a process of their own, and what they took."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from solidwhirl.core.errors import UserError, writing
from solidwhirl.cost import run_coefficients as reference
from solidwhirl.cost.machine import GROUPS, calibration_file, keep_calibration, machine_name

_PATIENCE_S, _PASSES = 600.0, 2
_WORDS = {
    "start": "start of a run",
    "meridian": "meridians (level harmonic)",
    "solid": "sectors and solids",
    "dense": "the engine and its analyses",
    "page": "files and page",
    "pictures": "pictures",
}


class CalibrationError(UserError):
    """A calibration that can not be made."""


def calibrate() -> dict[str, float]:
    """Measure the standard jobs [s] and keep them for the forecasts of this machine.

    The least of two passes: beside other programs the same work takes more processor time.
    Raises CalibrationError: the jobs fail; OutputError: what they took can't be written.
    """
    passes = [_measured() for _ in range(_PASSES)]
    jobs = {group: min(each[group] for each in passes) for group in GROUPS}
    with writing(calibration_file()):
        keep_calibration(jobs)
    return jobs


def _measured() -> dict[str, float]:
    """What the standard jobs take in a process of their own [s]."""
    command = [sys.executable, "-m", "solidwhirl.console.standard_jobs"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_PATIENCE_S, env=environment
        )
        return {group: float(json.loads(done.stdout)[group]) for group in GROUPS}
    except subprocess.TimeoutExpired:
        raise CalibrationError("the standard jobs are not done within ten minutes") from None
    except (ValueError, KeyError):
        said = (done.stderr.strip().splitlines() or ["no word"])[-1]
        raise CalibrationError(f"the standard jobs failed: {said}") from None


def calibration_lines(jobs: Mapping[str, float]) -> Iterator[str]:
    """Say what the jobs took, beside the machine that the coefficients are of."""
    yield f"{machine_name()}; beside {reference.MACHINE}, where the coefficients are from:"
    width = max(map(len, _WORDS.values()))
    for group in GROUPS:
        factor = jobs[group] / reference.JOBS_S[group]
        yield f"  {_WORDS[group]:<{width}}  {jobs[group]:6.2f} s  x {factor:.2f}"
    yield f"kept in {calibration_file()}"


def calibration_document(jobs: Mapping[str, float], path: Path) -> dict[str, object]:
    """The same as plain data."""
    return {
        "schema": "solidwhirl-calibration-1",
        "machine": machine_name(),
        "file": str(path),
        "jobs_cpu_s": dict(jobs),
        "factors": {group: jobs[group] / reference.JOBS_S[group] for group in GROUPS},
    }
