"""Coefficients of whole runs, written by `python bench/forecast.py --fit`."""

from __future__ import annotations

#: Where they were measured, and the rates of one core there [1e9/s, 1e9 bytes/s].
MACHINE = "Intel(R) Xeon(R) Processor"
GFLOPS, GBYTES_PER_S = 19.24, 44.08
#: Processor seconds of the standard jobs of `solidwhirl doctor --calibrate` there.
JOBS_S: dict[str, float] = {
    "start": 1.268,
    "meridian": 1.542,
    "solid": 2.629,
    "dense": 1.988,
    "page": 0.4992,
    "pictures": 2.38,
}
#: Seconds of the program's imports; where beams are tried, of each body and each of its sections.
START: tuple[float, float, float] = (1.021, 0.5036, 0.1403)
#: Seconds of the imports of mesher and solvers, and how often the laws of meshes count.
SOLVERS_S, MESHES = 0.1023, 0.8834
#: Kind of mesh: seconds of each reduction beside its law, and times that law.
BODIES: dict[str, tuple[float, float]] = {
    "harmonic": (0.3058, 1.007),
    "revolved": (0.3058, 1.239),
    "sector": (0.3058, 1.138),
    "whole": (0.3058, 1.113),
    "asymmetric": (0.3058, 3.609),
}
#: Seconds a + b (n/100)^2 + c (n/100)^3 of one, in an engine of n coordinates.
UNITS: dict[str, tuple[float, float, float]] = {
    "undamped": (0, 0, 0.002468),
    "eigenproblem.hermitian": (0.001811, 0, 0.005681),
    "eigenproblem.damped": (0.002456, 0.02422, 0),
    "eigenproblem.asymmetric": (0, 0, 7.861),
    "factorisation": (0, 0.003979, 0),
    "solve": (0.0003391, 0.0001101, 0),
    "step": (0.000136, 0, 0),
    "check": (0, 0.009111, 0),
    "result": (0.0006226, 0, 0),
}
#: Seconds of each body that error estimates compare with another model of it.
COMPARED_S = 0.3577
#: A nodal diameter beside a circumferential order of its body.
NODAL_DIAMETER = 1.75
#: Seconds of the fields of a state in a body of 1e5 unknowns, 32 places around.
FIELDS_S = 15
#: Seconds of the files: once, per 1e5 unknowns; of the page: once, per analysis, per 1e5 unknowns.
FILES: tuple[float, float] = (0.1049, 0.2612)
PAGE: tuple[float, float, float] = (0.2231, 0.06795, 0.3191)
#: Seconds of the pictures: once, and of each.
PICTURES: tuple[float, float] = (0, 0.3091)
