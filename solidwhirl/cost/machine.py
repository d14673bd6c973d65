"""How fast this machine is beside the one that the coefficients of the forecast are of.

`solidwhirl doctor --calibrate` measures standard jobs and keeps what they took in the user's cache
folder. Without that the rates of `solidwhirl.core.machine` stand in, one factor for all work.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from solidwhirl.core.machine import MachineSpeed, machine_speed, user_cache
from solidwhirl.cost import run_coefficients as measured

#: Kinds of work whose speed differs from machine to machine: imports and the choice of the level,
#: meridians, sectors and solids, the engine's dense problems, files and page, pictures.
GROUPS = tuple(measured.JOBS_S)
_SCHEMA = "solidwhirl-calibration-1"
# What a factor may be: anything beyond is no measurement.
_SLOWEST = 100.0


@dataclass(frozen=True, kw_only=True)
class Machine:
    """Times of this machine beside those that the coefficients are of, by kind of work."""

    factors: Mapping[str, float]
    calibrated: bool = False

    def factor(self, group: str) -> float:
        """How many times longer work of a kind takes here."""
        return self.factors[group]


#: The machine that the coefficients were measured on.
REFERENCE = Machine(factors=dict.fromkeys(GROUPS, 1.0))
REFERENCE_SPEED = MachineSpeed(gflops=measured.GFLOPS, gbytes_per_s=measured.GBYTES_PER_S)


def uniform(factor: float) -> Machine:
    """Return a machine on which all work takes so many times longer."""
    return Machine(factors=dict.fromkeys(GROUPS, factor))


def this_machine() -> Machine:
    """Return the calibration that is kept of this machine, else its rates, measured in 0.1 s."""
    return kept_calibration() or _by_rates()


@cache
def _by_rates() -> Machine:
    """Return this machine by its rates, which one process measures once."""
    return uniform(1.0 / machine_speed().relative_to(REFERENCE_SPEED))


def machine_name() -> str:
    """Processor of this machine: a home may be that of several."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def calibration_file() -> Path:
    """Where calibrations are kept, those of several machines that share a home in one file."""
    return user_cache() / "calibration.json"


def kept_calibration() -> Machine | None:
    """Return the calibration that is kept of this machine; None without one that can be read."""
    jobs = kept_jobs_s()
    if jobs is None:
        return None
    factors = {group: jobs[group] / measured.JOBS_S[group] for group in GROUPS}
    if not all(1.0 / _SLOWEST < factor < _SLOWEST for factor in factors.values()):
        return None
    return Machine(factors=factors, calibrated=True)


def kept_jobs_s() -> dict[str, float] | None:
    """Return what the standard jobs took on this machine [s]; None where that is not kept."""
    jobs: Any = _kept().get(machine_name())
    try:
        return {group: float(jobs[group]) for group in GROUPS}
    except (TypeError, KeyError, ValueError):
        return None


def keep_calibration(jobs_s: Mapping[str, float]) -> Path:
    """Keep what the standard jobs took on this machine [s], and return the file.

    Raises OSError: it can't be written.
    """
    path = calibration_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    machines = {**_kept(), machine_name(): dict(jobs_s)}
    text = json.dumps({"schema": _SCHEMA, "jobs_s": machines}, indent=1)
    scratch = path.with_name(f".{path.name}.{os.getpid()}")
    scratch.write_text(text + "\n", encoding="utf-8")
    scratch.replace(path)
    return path


def _kept() -> dict[str, Any]:
    """What the file holds, by machine; nothing where it can't be read."""
    try:
        document = json.loads(calibration_file().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    known = isinstance(document, dict) and document.get("schema") == _SCHEMA
    machines = document.get("jobs_s") if known else None
    return machines if isinstance(machines, dict) else {}
