"""`solidwhirl run` with a defect on one rank: it fails, the others wait for it.

defect.py KIND RUN-ARGUMENTS..., with KIND "defect" or "memory" (the last rank raises instead of
the run), or kill:RANK (that rank is killed where the reduction of a body begins)
"""

from __future__ import annotations

import os
import signal
import sys

from mpi4py import MPI

import solidwhirl.pipeline.run
import solidwhirl.reduction.body.reduce as reduction
from solidwhirl.cli import main


def broken(*_arguments, **_options):
    """Stand in for `run_scene`."""
    comm = MPI.COMM_WORLD
    if comm.rank == comm.size - 1:
        if kind == "memory":
            raise MemoryError("Unable to allocate 1 PiB")
        raise RuntimeError("a defect")
    comm.Barrier()


def killed(*_arguments, **_options):
    """Stand in for `order_operators`."""
    os.kill(os.getpid(), signal.SIGKILL)


kind, *sys.argv[1:] = sys.argv[1:]
if not kind.startswith("kill:"):
    solidwhirl.pipeline.run.run_scene = broken
elif MPI.COMM_WORLD.rank == int(kind.removeprefix("kill:")):
    reduction.order_operators = killed
main()
