"""Jobs under mpirun for the tests of faults, and processes that are killed at their n-th step."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

SETTINGS = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
# a process of tests may have MPI running; its children must not think that they are its ranks
OF_MPI = ("OMPI_", "PMIX_", "ORTE_")
CLEAN = {k: v for k, v in os.environ.items() if not k.startswith(OF_MPI)} | SETTINGS
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
