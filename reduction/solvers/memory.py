"""Memory of this machine: what is left of it, and giving it back."""

from __future__ import annotations

import ctypes
from typing import Any

from solidwhirl.rotordyn.core.available_memory import available_memory


def available_memory_bytes(comm: Any) -> int | None:
    """Return the memory that each rank may still take, None where the system does not tell.

    `comm`: mpi4py communicator; ranks of one machine share what it has, and the least is returned.
    """
    from mpi4py import MPI

    neighbours = comm.Split_type(MPI.COMM_TYPE_SHARED)
    share = neighbours.size
    neighbours.Free()
    own = available_memory()
    least = comm.allreduce(-1 if own is None else own // share, op=MPI.MIN)
    return int(least) if least >= 0 else None


def return_free_memory() -> None:
    """Give the system back what the C library keeps in pieces between blocks in use.

    Without it a process that reduces one body after the other grows by up to 15 MB each time.
    glibc only; elsewhere nothing is done.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
