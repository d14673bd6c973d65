"""Environment of programs that run on several ranks, in processes of their own."""

from __future__ import annotations

import os

_SETTINGS = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
# a process of tests may have MPI running; its children must not think that they are its ranks
_OF_MPI = ("OMPI_", "PMIX_", "ORTE_")
CLEAN = {k: v for k, v in os.environ.items() if not k.startswith(_OF_MPI)} | _SETTINGS
