"""Turbine rotors as solids, reduced to superelements, assembled into rotordynamics."""

import os

# One BLAS thread: more gave no gain in factorisations and cost up to twice the CPU time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from solidwhirl.moved import point_to_moved_modules

point_to_moved_modules()
__version__ = "0.1.0"
