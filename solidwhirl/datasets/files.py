"""Datasets as netCDF files, complex numbers included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from solidwhirl.rotordyn.core.atomic import replacing

_REAL, _IMAGINARY = "__real", "__imag"


def write_netcdf(dataset: xr.Dataset, path: str | Path) -> Path:
    """Write a dataset as a netCDF 3 file, which needs no library but scipy.

    A complex variable `a` becomes `a__real` and `a__imag`.

    `dataset`: one of this program's; lists among the attributes become lines of a text. `path`: the
    file; a file there is replaced when the new one is complete. Returns the file.
    """
    plain = dataset.copy()
    for name in [str(n) for n, v in dataset.data_vars.items() if v.dtype.kind == "c"]:
        variable = dataset[name].variable
        attributes = variable.attrs
        plain = plain.drop_vars(name)
        plain[name + _REAL] = (variable.dims, variable.values.real, attributes)
        plain[name + _IMAGINARY] = (variable.dims, variable.values.imag, attributes)
    for key, value in dataset.attrs.items():
        if isinstance(value, list | tuple):
            plain.attrs[key] = "\n".join(map(str, value))
        elif isinstance(value, bool):
            plain.attrs[key] = int(value)
    path = Path(path)
    with replacing(path) as temporary:
        plain.to_netcdf(temporary, engine="scipy")
    return path


def read_netcdf(path: str | Path) -> xr.Dataset:
    """Read a dataset that `write_netcdf` wrote.

    Returns in memory, complex variables put together again. Raises OSError: the file can't be read.
    """
    found = xr.load_dataset(path, engine="scipy")
    for name in [str(n) for n in found.data_vars if str(n).endswith(_REAL)]:
        whole = name.removesuffix(_REAL)
        real, imaginary = found[name], found[whole + _IMAGINARY]
        found[whole] = (real.dims, real.values + 1j * imaginary.values, real.attrs)
        found = found.drop_vars([name, whole + _IMAGINARY])
    for key in found.variables:
        if found[key].dtype == object:  # texts of all lengths
            texts = found[key]
            found[key] = (texts.dims, np.asarray(texts.values, dtype=str), texts.attrs)
    return found
