"""Runs that meet a full disk, a read-only one, too little memory, or a signal; prints JSON.

limits.py SCENE FOLDER LENGTH WHAT...

LENGTH is "short" or "long" and says how many limits are set; WHAT is "disk" (needs a mount
namespace of its own), "files", "memory" or "signals".
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from forked import Run, leftovers, numbers, problems

import solidwhirl.pipeline.run
from solidwhirl.files.run_folder import claimed

_MIB = 1 << 20
# KiB of disks, bytes of files, MiB of memory; on Debian 13 a run gets along with 260 MiB.
_LIMITS = {
    "short": {"disk": (40, 200), "files": (100_000,), "memory": (150, 230, 312)},
    "long": {
        "disk": (40, 120, 200),
        "files": (30_000, 100_000),
        "memory": (150, 230, 290, 312, 325, 400),
    },
}


def _state(run, code, out, expected):
    """What a run said and left, and whether the next one finishes."""
    said = [line for line in run.said().splitlines() if line.startswith("error: ")]
    return {
        "code": code,
        "errors": said,
        "traceback": "Traceback" in run.said(),
        "problems": problems(out),
        "right": numbers(out) == expected,
        "leftovers": leftovers(out),
        "said": run.said()[-600:],
    }


def _next(scene, out, expected):
    """The run after it, without limits."""
    run = Run(scene, out)
    return {"next_code": run.end(), "next_right": numbers(out) == expected and not problems(out)}


def disks(scene, folder, expected, sizes):
    """File systems of some sizes, and one that can be read only."""
    found = {}
    for size in sizes:
        place = folder / f"disk{size}"
        place.mkdir()
        _mount(place, f"size={size}k")
        run = Run(scene, place / "out")
        state = _state(run, run.end(), place / "out", expected)
        _mount(place, "remount,size=64m")
        found[f"{size} KiB"] = state | _next(scene, place / "out", expected)
    # over old results: filled up after the first run
    _mount(place, "remount,ro")
    start = time.monotonic()
    run = Run(scene, place / "out", "--fresh")
    found["read-only"] = _state(run, run.end(), place / "out", expected)
    found["read-only"]["seconds"] = time.monotonic() - start
    _mount(place, "remount,rw")
    with contextlib.suppress(OSError), (place / "filler").open("wb", buffering=0) as filler:
        while filler.write(bytes(4096)):
            pass
    run = Run(scene, place / "out", "--fresh")
    found["full, old results"] = _state(run, run.end(), place / "out", expected)
    return found


def _mount(place, options):
    kind = () if options.startswith("remount") else ("-t", "tmpfs")
    subprocess.run(["mount", *kind, "-o", options, "none", str(place)], check=True)


def files(scene, folder, expected, sizes):
    """A limit on the size of files, with which every larger write fails."""
    found = {}
    for size in sizes:
        out = folder / f"files{size}"

        def limit(size=size):
            import mpi4py.MPI  # noqa: F401  has large files of its own

            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

        run = Run(scene, out, before=limit)
        state = _state(run, run.end(), out, expected)
        found[f"{size} bytes"] = state | _next(scene, out, expected)
    return found


def memory(scene, folder, expected, sizes):
    """Limits on the address space beyond what the process has."""
    found = {}
    for more in sizes:
        out = folder / f"memory{more}"

        def limit(more=more):
            import mpi4py.MPI  # noqa: F401  its own helper process waits where it gets no memory

            # what was predicted is refused before; here the limit itself is to be met
            solidwhirl.pipeline.run.refuse_too_large = lambda *known: None
            pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
            most = pages * resource.getpagesize() + more * _MIB
            resource.setrlimit(resource.RLIMIT_AS, (most, most))

        run = Run(scene, out, before=limit)
        start = time.monotonic()
        state = _state(run, run.end(), out, expected) | {"seconds": time.monotonic() - start}
        if state["code"] != 0:
            state |= _next(scene, out, expected)
        found[f"{more} MiB"] = state
        shutil.rmtree(out)
    return found


def signals(scene, folder, expected, _sizes):
    """SIGTERM and SIGINT while it works, and two runs in one folder."""
    found = {}
    for name in ("SIGTERM", "SIGINT"):
        out = folder / name
        run = Run(scene, out, before=_listen)
        while "mesh rotor" not in run.said():
            time.sleep(0.002)
        code = run.signal_after(0.0, getattr(signal, name))
        found[name] = _state(run, code, out, expected) | _next(scene, out, expected)
    with claimed(out):
        second = Run(scene, out)
        found["second"] = _state(second, second.end(), out, expected) | {"pid": os.getpid()}
    return found


def _listen():
    """As a shell starts programs, and not in the background."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


if __name__ == "__main__":
    scene, folder, length, *asked = sys.argv[1:]
    scene, folder = Path(scene), Path(folder)
    whole = Run(scene, folder / "whole")
    assert whole.end() == 0, whole.said()
    known = numbers(folder / "whole")
    work = {"disk": disks, "files": files, "memory": memory, "signals": signals}
    sizes = _LIMITS[length]
    print(json.dumps({w: work[w](scene, folder, known, sizes.get(w, ())) for w in asked}))
