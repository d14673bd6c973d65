"""`solidwhirl run` with a defect on one rank: the last rank raises, the others wait for it.

defect.py KIND RUN-ARGUMENTS..., with KIND "defect" or "memory"
"""

from __future__ import annotations

import sys

from mpi4py import MPI

import solidwhirl.pipeline.run
from solidwhirl.cli import main


def broken(*_arguments, **_options):
    """Stand in for `run_scene`."""
    comm = MPI.COMM_WORLD
    if comm.rank == comm.size - 1:
        if kind == "memory":
            raise MemoryError("Unable to allocate 1 PiB")
        raise RuntimeError("a defect")
    comm.Barrier()


kind, *sys.argv[1:] = sys.argv[1:]
solidwhirl.pipeline.run.run_scene = broken
main()
