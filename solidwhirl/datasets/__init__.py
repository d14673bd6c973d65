"""Results as labelled xarray datasets.

Named dimensions, units, errors as variables; netCDF files.
In: results or a folder of a run. Out: datasets.
"""
