"""Jobs under mpirun for the tests of faults, and processes that are killed at their n-th step."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

from ranks import CLEAN

# Changes that make the body of `one_body` a small solid.
SOLID = {
    'level = "harmonic"': 'level = "solid", order = 2, size_m = 0.08, corner_size_m = 0.08',
    "modes = 3": "modes = 2",
    "accuracy = 0.05, ": "",
    "end_m = 0.4": "end_m = 0.1",
    "at_m = 0.4": "at_m = 0.1",
    "start_m = 0.1, end_m = 0.14, inner_radius_m = 0.02, outer_radius_m = 0.12": (
        "start_m = 0.04, end_m = 0.05, inner_radius_m = 0.02, outer_radius_m = 0.025"
    ),
}
FILE_WORK = ("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.truncate")


def mpirun(ranks, *words):
    """Python with these words on so many ranks."""
    return subprocess.Popen(
        ["mpirun", "--oversubscribe", "-n", str(ranks), sys.executable, *map(str, words)],
        env=CLEAN,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ranks_of(job, word):
    """Processes that mpirun started whose command has a word."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            status = (folder / "stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
            command = (folder / "cmdline").read_bytes()
        except OSError:
            continue
        if int(status[1]) == job.pid and word.encode() in command:
            found.append(int(folder.name))
    return sorted(found)


def forked(step, work):
    """Exit code of a copy of this process, killed at its n-th operation on files of some work."""
    pid = os.fork()
    if pid == 0:
        left = [step]

        def count(event, _arguments):
            if event in FILE_WORK:
                left[0] -= 1
                if left[0] == 0:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(count)
        work()
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
