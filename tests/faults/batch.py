"""The command `batch` with defects that a test asks for.

batch.py KIND ARGUMENT ...: KIND is none, or a scene's name and what its run raises:
NAME:defect, NAME:memory, NAME:first (on the first rank of the team alone), NAME:other (on another
rank of it alone). Or room:GIB:FILE, as if so much memory were free, and every run writes when it
began and ended.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import solidwhirl.batch.case
import solidwhirl.batch.ranks
from solidwhirl.cli import main

kind = sys.argv.pop(1)
whole = solidwhirl.batch.case.run_scene


def run_scene(scene, *, comm, **options):
    """The run of a scene, or what is asked for instead."""
    name, _, fault = kind.partition(":")
    if scene.name == name:
        if fault == "memory":
            raise MemoryError("no room for a matrix")
        if fault == "defect" or (fault == "first" and comm.rank == 0):
            raise RuntimeError("a defect")
        if fault == "first":
            comm.bcast()  # as a rank that waits for what the first one makes
            raise AssertionError("never here")
        if fault == "other":
            if comm.rank == 1:
                raise RuntimeError("a defect")
            comm.Barrier()  # as inside a library
    if name == "room":
        began = time.monotonic()
        found = whole(scene, comm=comm, **options)
        time.sleep(0.5)  # long enough for another to come into it
        with Path(fault.split(":")[1]).open("a", encoding="ascii") as file:
            file.write(f"{began} {time.monotonic()}\n")
        return found
    return whole(scene, comm=comm, **options)


if kind.startswith("room:"):
    solidwhirl.batch.ranks.available_memory_gib = lambda: float(kind.split(":")[1])
solidwhirl.batch.case.run_scene = run_scene
solidwhirl.batch.ranks.PATIENCE_S = 1.0
sys.argv[0] = "solidwhirl"
main()
