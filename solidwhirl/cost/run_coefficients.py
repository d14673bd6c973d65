"""Coefficients of whole runs, written by `python bench/forecast.py --fit`."""

from __future__ import annotations

#: Where they were measured, on one core.
MACHINE = "Intel(R) Xeon(R) Processor"
#: Rates of `solidwhirl.core.machine` there [1e9/s].
GFLOPS = 9.119
#: And of memory [1e9 bytes/s].
GBYTES_PER_S = 31.77
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
SOLVERS_S = 0.3413
#: How often the laws of meshes count.
MESHES = 0.8961
#: Kind of body: seconds of each reduction beside its law, and times that law.
BODIES: dict[str, tuple[float, float]] = {
    "harmonic": (0.1965, 0.9402),
    "revolved": (0.1965, 0.9309),
    "sector": (0.1965, 1.036),
    "whole": (0.1965, 0.9296),
    "asymmetric": (0.1965, 3.491),
}
#: Seconds a + b (n/100)^2 + c (n/100)^3 of one, in an engine of n coordinates.
UNITS: dict[str, tuple[float, float, float]] = {
    "undamped": (0, 0, 0.002483),
    "eigenproblem.hermitian": (0.001766, 0, 0.005694),
    "eigenproblem.damped": (0.0008927, 0.02159, 0),
    "eigenproblem.isotropic": (0.001796, 0.003361, 0),
    "eigenproblem.asymmetric": (0.0008927, 0.02159, 0),
    "eigenproblem.periodic": (0, 0, 8.959),
    "continued": (0.002, 0.003, 0),
    "factorisation": (0, 0.004844, 0),
    "solve": (0.0002943, 0.0001204, 0),
    "balance": (0.002, 0, 0),
    "step": (2.211e-05, 0, 0),
    "check": (0, 0.006549, 0),
    "result": (0.001108, 0, 0),
}
#: How often the laws count of bodies with either coupling of their interfaces.
COMPARED = 1
#: Seconds of the files: once, per 1e5 unknowns, per 1e6 numbers of records.
FILES: tuple[float, float, float] = (0.09707, 0.2789, 0)
#: Seconds of the page: once, per analysis, per 1e5 unknowns, per 1e6 numbers of records.
PAGE: tuple[float, float, float, float] = (0.2137, 0.06637, 0.3304, 0)
#: Seconds of the pictures: once, and of each.
PICTURES: tuple[float, float] = (0, 0.2987)
#: A nodal diameter beside a circumferential order of its body.
NODAL_DIAMETER = 0.8576
#: Seconds of the fields of a state in a body of 1e5 unknowns, 32 places around.
FIELDS_S = 6.458
