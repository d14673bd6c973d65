"""Turbine rotors as solids, reduced to superelements, assembled into rotordynamics."""

import os

# One BLAS thread: more gave no gain in factorisations and cost up to twice the CPU time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

try:
    # Loaded before petsc4py or dolfinx brings Debian's HDF5 into the process: h5py's wheel has
    # its own and fails when it comes second.
    import h5py  # noqa: F401
except ValueError as error:
    raise ImportError(
        "h5py met another HDF5 library; import solidwhirl before dolfinx or petsc4py"
    ) from error

from solidwhirl.moved import point_to_moved_modules

point_to_moved_modules()
__version__ = "0.1.0"
