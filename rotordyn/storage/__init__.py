"""Superelement files: HDF5, written atomically and read with suspicion.

Every read is checked for kind, shape and size first, in a child process if need be.
In: `Superelement` or a path. Out: a file, or the record again.
"""

# first of all
import solidwhirl.rotordyn.core.hdf5  # noqa: F401
