"""Coefficients of whole runs, written by `python bench/forecast.py --fit`."""

from __future__ import annotations

#: Where they were measured, on one core.
MACHINE = "Intel(R) Xeon(R) Processor"
#: Rates of `solidwhirl.core.machine` there [1e9/s].
GFLOPS = 19.2
#: And of memory [1e9 bytes/s].
GBYTES_PER_S = 44.51
#: Processor seconds of the standard jobs of `solidwhirl doctor --calibrate` there.
JOBS_S: dict[str, float] = {
    "start": 1.268,
    "meridian": 1.542,
    "solid": 2.629,
    "dense": 1.988,
    "page": 0.4992,
    "pictures": 2.38,
}
#: Seconds of imports; where beams are tried, of each body and each of its sections.
START: tuple[float, float, float] = (1.285, 0.3689, 0.1284)
#: Seconds of the imports of mesher and solvers.
SOLVERS_S = 0.1297
#: How often the laws of meshes count.
MESHES = 2.602
#: Kind of body: seconds of each reduction beside its law, and times that law.
BODIES: dict[str, tuple[float, float]] = {
    "harmonic": (0.2723, 0.8952),
    "revolved": (0.2723, 1.218),
    "sector": (0.2723, 1.336),
    "whole": (0.2723, 0.985),
    "asymmetric": (0.2723, 3.405),
}
#: Seconds a + b (n/100)^2 + c (n/100)^3 of one, in an engine of n coordinates.
UNITS: dict[str, tuple[float, float, float]] = {
    "undamped": (0, 0, 0.002489),
    "eigenproblem.hermitian": (0.00158, 0, 0.005959),
    "eigenproblem.damped": (0.0007376, 0.02176, 0),
    "eigenproblem.isotropic": (0, 0.004965, 0),
    "eigenproblem.asymmetric": (0, 0, 8.959),
    "factorisation": (0, 0.00463, 0),
    "solve": (0.0002968, 0.0001179, 0),
    "step": (2.209e-05, 0, 0),
    "check": (0.001978, 0.00485, 0),
    "result": (0.001121, 0, 0),
}
#: Seconds of each body that error estimates compare with another model of it.
COMPARED_S = 0.3372
#: A nodal diameter beside a circumferential order of its body.
NODAL_DIAMETER = 2.936
#: Seconds of the fields of a state in a body of 1e5 unknowns, 32 places around.
FIELDS_S = 6.111
#: Seconds of the files: once, and per 1e5 unknowns.
FILES: tuple[float, float] = (0.09513, 0.3062)
#: Seconds of the page: once, per analysis, per 1e5 unknowns.
PAGE: tuple[float, float, float] = (0.2192, 0.07235, 0.3208)
#: Seconds of the pictures: once, and of each.
PICTURES: tuple[float, float] = (0, 0.2987)
