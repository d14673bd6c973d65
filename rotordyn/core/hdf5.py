"""h5py, loaded before petsc4py or dolfinx brings Debian's HDF5 into the process.

h5py's wheel has its own and fails when it comes second.
"""

try:
    import h5py  # noqa: F401
except ValueError as error:
    raise ImportError(
        "h5py met another HDF5 library; import h5py before dolfinx or petsc4py"
    ) from error
