"""How fast this machine is beside another one, and how much memory it has left."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.core.available_memory import available_memory, resident_memory

# Rows of the matrices multiplied, and entries of the vectors swept, which no cache holds: together
# some 30 ms.
_ROWS = 256
_ENTRIES = 2_000_000
_REPEATS = 4


def user_cache() -> Path:
    """Return the folder of what is kept for this user from one run to the next."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "solidwhirl"


@dataclass(frozen=True, kw_only=True)
class MachineSpeed:
    """Rates of one core."""

    #: Floating-point operations of a product of dense matrices per processor second [1e9/s]
    gflops: float
    #: Memory moved by a sum of two long vectors per processor second [1e9 bytes/s]
    gbytes_per_s: float

    def relative_to(self, other: MachineSpeed) -> float:
        """How many times faster than another machine: the geometric mean of both ratios."""
        arithmetic = self.gflops / other.gflops
        return float(np.sqrt(arithmetic * self.gbytes_per_s / other.gbytes_per_s))


def machine_speed() -> MachineSpeed:
    """Measure this machine, in less than 0.1 s.

    Processor time is measured, the shortest of some repeats, so that other programs disturb
    little; threads of the linear algebra library count with the sum of their times.
    """
    square = np.full((_ROWS, _ROWS), 0.5)
    product = np.empty_like(square)
    multiply = _shortest(lambda: np.matmul(square, square, out=product))
    vector = np.ones(_ENTRIES)
    total = np.zeros(_ENTRIES)
    add = _shortest(lambda: np.add(vector, total, out=total))
    return MachineSpeed(
        gflops=2.0 * _ROWS**3 / multiply / 1e9, gbytes_per_s=3.0 * vector.nbytes / add / 1e9
    )


def _shortest(run: Callable[[], object]) -> float:
    """Shortest processor time of some repeats [s], wall time where its clock has coarse ticks."""
    times = []
    for _ in range(_REPEATS):
        start, wall = time.process_time(), time.perf_counter()
        run()
        times.append((time.process_time() - start) or (time.perf_counter() - wall))
    return max(min(times), 1e-9)


def available_memory_gib() -> float:
    """Memory that a new program can have without swapping [GiB].

    See `solidwhirl.rotordyn.core.available_memory`; where the system does not tell, the installed
    memory is returned.
    """
    known = available_memory()
    if known is None:
        known = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return known / 1024.0**3


def resident_memory_gib() -> float:
    """Memory that this process has taken [GiB]."""
    return resident_memory() / 1024.0**3
