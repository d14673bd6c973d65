"""What a process has used: processor time by stage, peak memory."""

from __future__ import annotations

import resource
from collections.abc import Callable
from pathlib import Path

Progress = Callable[[str], None]

_STATUS = Path("/proc/self/status")
# Stages of a run by the first word of what it says when it begins them.
_STAGES = {
    "mesh": "meshing",
    "reduce": "reduction",
    "estimated": "other",
    "assemble": "assembly",
    "Campbell": "campbell",
    "critical": "critical_speeds",
    "error": "error_estimates",
}


def cpu_seconds() -> float:
    """Return the processor time of this process, its start included, user and system [s]."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def children_cpu_seconds() -> float:
    """Return the processor time of all processes that this one started and that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def peak_memory_gib(status: Path = _STATUS) -> float:
    """Return the largest resident memory of this process so far [GiB].

    Parameters
    ----------
    status
        Where the kernel tells. Its figure is that of this program alone; where there is no such
        file, the figure of getrusage is returned, which on some systems counts what the parent
        process had when it started this one.
    """
    if status.is_file():
        for line in status.read_text(encoding="ascii", errors="replace").splitlines():
            name, _, value = line.partition(":")
            if name == "VmHWM":
                return float(value.split()[0]) / 1024.0**2
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2


class StageClock:
    """Processor time by stage, told apart by what a run says when it begins one."""

    def __init__(self, progress: Progress) -> None:
        self.seconds: dict[str, float] = {}
        self._progress = progress
        self._stage = "other"
        self._since = cpu_seconds()

    def say(self, text: str) -> None:
        """Charge what was used since the last call to its stage, begin the next one, pass it on."""
        self.stop()
        words = text.split()
        self._stage = _STAGES.get(words[0], "other") if words else "other"
        self._progress(text)

    def stop(self) -> None:
        """Charge what was used since the last call to its stage."""
        now = cpu_seconds()
        self.seconds[self._stage] = self.seconds.get(self._stage, 0.0) + now - self._since
        self._since = now
