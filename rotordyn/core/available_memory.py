"""Memory that this process may still take: what the machine has, and what it is allowed."""

from __future__ import annotations

import resource
from pathlib import Path

_ROOT = Path("/")
# Part of a limited address space for data: the rest is for libraries, stacks and gaps.
_ADDRESS_SHARE = 0.8
# Control groups of version 1 state no limit as a number near 2^63.
_NO_LIMIT = 1 << 60


def available_memory(root: Path = _ROOT) -> int | None:
    """Return the memory that this process may still take.

    `root`: where the folders proc and sys of the kernel are. Returns bytes; the least of what the
    machine has free, what the control groups of the process leave (containers, batch systems) and
    its own limit of address space (`ulimit -v`). None where the system tells none of them.
    """
    known = [_kilobytes(root / "proc/meminfo", "MemAvailable"), _of_groups(root), _of_process(root)]
    told = [size for size in known if size is not None]
    return max(0, min(told)) if told else None


def resident_memory(root: Path = _ROOT) -> int:
    """Return the bytes that this process has taken; 0 where the system does not tell."""
    return _kilobytes(root / "proc/self/status", "VmRSS") or 0


def _of_process(root: Path) -> int | None:
    """What the limit of the address space leaves."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return None
    taken = _kilobytes(root / "proc/self/status", "VmSize") or 0
    return int(_ADDRESS_SHARE * (limit - taken))


def _of_groups(root: Path) -> int | None:
    """The least that a control group of the process, or one around it, leaves."""
    left = []
    for line in _lines(root / "proc/self/cgroup"):
        _, kinds, place = line.split(":", 2)
        if kinds == "":
            top, names = root / "sys/fs/cgroup", ("memory.max", "memory.current")
        elif "memory" in kinds.split(","):
            top = root / "sys/fs/cgroup/memory"
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes")
        else:
            continue
        inner = top / place.strip("/")
        for folder in (inner, *inner.parents):
            room = _room(folder, *names)
            if room is not None:
                left.append(room)
            if folder == top:
                break
    return min(left) if left else None


def _room(folder: Path, limit: str, usage: str) -> int | None:
    """What one control group leaves; file pages that it can drop count as free."""
    most, taken = (_lines(folder / name) for name in (limit, usage))
    if not most or not taken or not most[0].isdigit() or int(most[0]) > _NO_LIMIT:
        return None
    statistics = dict(line.split(" ", 1) for line in _lines(folder / "memory.stat"))
    return int(most[0]) - int(taken[0]) + int(statistics.get("inactive_file", "0"))


def _kilobytes(path: Path, name: str) -> int | None:
    for line in _lines(path):
        found, _, value = line.partition(":")
        if found == name:
            return 1024 * int(value.split()[0])
    return None


def _lines(path: Path) -> list[str]:
    """Lines of a file of the kernel; none if it is not there."""
    try:
        return path.read_text(encoding="ascii").splitlines()
    except OSError:
        return []
