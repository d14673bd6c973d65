"""Measured child processes, and a store of what was measured before."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BENCH = ROOT / "bench"
OUT = ROOT / "out" / "peers"
PYTHON = ROOT / ".venv" / "bin" / "python"
SOLIDWHIRL = ROOT / ".venv" / "bin" / "solidwhirl"
EXUDYN = ROOT / ".venv-exudyn" / "bin" / "python"
ROSS = ROOT / ".venv-ross" / "bin" / "python"
ONE_THREAD = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "CCX_NPROC_EQUATION_SOLVER": "1",
    "CCX_NPROC_STIFFNESS": "1",
}


def run(command: list, folder: Path = OUT) -> dict:
    """Run a process to its end: CPU time (user and system) and peak memory of it.

    This process stays small: on Linux a child's peak memory starts at its parent's.
    """
    start = time.time()
    with (folder / "last.log").open("wb") as log:
        child = subprocess.Popen(
            [str(c) for c in command],
            cwd=folder,
            stdout=log,
            stderr=subprocess.STDOUT,
            env={**os.environ, **ONE_THREAD},
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        said = (folder / "last.log").read_text(errors="replace")[-2000:]
        raise RuntimeError(f"{' '.join(map(str, command))} ended with {child.returncode}:\n{said}")
    return {
        "cpu_s": usage.ru_utime + usage.ru_stime,
        "peak_gib": usage.ru_maxrss / 1024.0**2,
        "wall_s": time.time() - start,
        # other programs on the machine make CPU time longer too, by caches and memory they share
        "load": os.getloadavg()[0],
    }


def measured(command: list, written: Path, repeats: int = 1) -> dict:
    """Middle of some runs by CPU time, with what the process wrote."""
    runs = sorted((run(command) for _ in range(repeats)), key=lambda r: r["cpu_s"])
    return {**runs[repeats // 2], "cpu_all_s": [r["cpu_s"] for r in runs], **read(written)}


def read(path: Path) -> dict:
    """JSON document."""
    return json.loads(path.read_text())


def key_of(*parts: str) -> str:
    """Key of a measurement from everything its result depends on."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


@dataclass
class Store:
    """Measurements of other programs by what they depend on, one file each."""

    fresh: bool
    reused: list[str] = field(default_factory=list)

    def get(self, name: str, key: str, measure) -> dict:
        """Stored measurement, or a new one."""
        path = OUT / "store" / f"{name}_{key}.json"
        if path.exists() and not self.fresh:
            found = read(path)
            load = f"{found['load']:.1f}" if "load" in found else "unknown"
            self.reused.append(f"{name} ({found['date']}, load {load})")
            return found
        print(f"measuring {name}", flush=True)
        found = {**measure(), "date": time.strftime("%Y-%m-%d")}
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(found, indent=1))
        return found


def machine() -> dict:
    """Processor, system and cores."""
    listed = Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.split(":")[1].strip() for line in listed if line.startswith("model name")]
    return {
        "processor": names[0] if names else platform.machine(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
    }
