"""Coefficients of whole runs, written by `python bench/forecast.py --fit`."""

from __future__ import annotations

#: Where they were measured, and the rates of one core there [1e9/s, 1e9 bytes/s].
MACHINE = "Intel(R) Xeon(R) Processor"
GFLOPS, GBYTES_PER_S = 16.3, 41.0
#: Processor seconds of the standard jobs of `solidwhirl doctor --calibrate` there.
JOBS_S: dict[str, float] = {
    "start": 1.5,
    "meridian": 3.0,
    "solid": 3.0,
    "dense": 3.0,
    "page": 0.8,
    "pictures": 2.0,
}
#: Seconds of the program's imports; where beams are tried, of each body and of each of its nodes.
START: tuple[float, float, float] = (1.25, 0.3, 0.05)
#: Seconds of the imports of mesher and solvers, and how often the laws of meshes count.
SOLVERS_S, MESHES = 0.65, 1.0
#: Kind of mesh: seconds of each reduction beside its law, and times that law.
BODIES: dict[str, tuple[float, float]] = {
    "harmonic": (0.2, 1.3),
    "revolved": (0.2, 1.3),
    "solid": (0.2, 1.0),
}
#: Seconds a + b (n/100)^2 + c (n/100)^3 of one, in an engine of n coordinates.
UNITS: dict[str, tuple[float, float, float]] = {
    "undamped": (0.004, 0.0, 0.006),
    "eigenproblem.hermitian": (0.004, 0.0, 0.006),
    "eigenproblem.damped": (0.003, 0.02, 0.0),
    "eigenproblem.asymmetric": (0.2, 0.0, 0.9),
    "factorisation": (0.001, 0.004, 0.0),
    "solve": (0.0003, 0.0003, 0.0),
    "step": (1e-6, 2.5e-6, 0.0),
    "check": (0.003, 0.025, 0.0),
    "result": (0.0006, 0.0, 0.0),
}
#: Seconds of each body that error estimates compare with another model of it.
COMPARED_S = 0.2
#: Seconds of the fields of a state in a body of 1e5 unknowns, 32 places around.
FIELDS_S = 15.0
#: Seconds of the files: once, per 1e5 unknowns; of the page: once, per analysis, per 1e5 unknowns.
FILES: tuple[float, float] = (0.1, 0.8)
PAGE: tuple[float, float, float] = (0.25, 0.05, 0.5)
#: Seconds of the pictures: once, and of each.
PICTURES: tuple[float, float] = (0.5, 0.35)
