"""Coefficients of whole runs, written by `python bench/forecast.py --fit`."""

from __future__ import annotations

#: Where they were measured, on one core.
MACHINE = "Intel(R) Xeon(R) Processor"
#: Rates of `solidwhirl.core.machine` there [1e9/s].
GFLOPS = 76.31
#: And of memory [1e9 bytes/s].
GBYTES_PER_S = 24.27
#: Processor seconds of the standard jobs of `solidwhirl doctor --calibrate` there.
JOBS_S: dict[str, float] = {
    "start": 1.017,
    "meridian": 1.699,
    "solid": 3.123,
    "dense": 1.688,
    "page": 0.3177,
    "pictures": 2.308,
}
#: Seconds of imports; where beams are tried, of each body and each of its sections.
START: tuple[float, float, float] = (1.025, 0.1258, 0.02212)
#: Seconds of the imports of mesher and solvers.
SOLVERS_S = 0.3689
#: How often the laws of meshes count.
MESHES = 0.7217
#: Kind of body: seconds of each reduction beside its law, and times that law.
BODIES: dict[str, tuple[float, float]] = {
    "harmonic": (0.1305, 1.109),
    "revolved": (0.1305, 0.9559),
    "sector": (0.1305, 1.207),
    "whole": (0.1305, 0.9116),
    "asymmetric": (0.1305, 3.471),
}
#: How often the law of memory counts for an asymmetric body.
ASYMMETRIC_MEMORY = 3.102
#: Seconds a + b (n/100)^2 + c (n/100)^3 of one, in an engine of n coordinates.
UNITS: dict[str, tuple[float, float, float]] = {
    "undamped": (0.0001298, 0, 0.001738),
    "eigenproblem.hermitian": (0.005034, 0, 0.001916),
    "eigenproblem.damped": (0.003954, 0.008069, 0),
    "eigenproblem.isotropic": (0.007523, 0.004428, 0),
    "eigenproblem.asymmetric": (0.01602, 0, 0),
    "eigenproblem.periodic": (0, 0, 6.451),
    "continued": (0.002687, 0.002351, 0),
    "factorisation": (0, 0.001189, 0),
    "solve": (4.282e-05, 9.884e-05, 0),
    "balance": (0.001961, 0, 0),
    "step": (1.905e-06, 1.643e-05, 0),
    "check": (0.001537, 0.006165, 0),
    "result": (0.0004345, 0, 0),
}
#: How often the laws count of bodies with either coupling of their interfaces.
COMPARED = 0.8224
#: Seconds of the files: once, per 1e5 unknowns, per 1e6 numbers of records.
FILES: tuple[float, float, float] = (0.08623, 0.2527, 0.1262)
#: Seconds of the page: once, per analysis, per 1e5 unknowns, per 1e6 record numbers, with fields.
PAGE: tuple[float, float, float, float, float] = (0.0682, 0.00743, 0.1857, 0.2498, 0.7843)
#: Seconds of the pictures: once, and of each.
PICTURES: tuple[float, float] = (0, 0.2912)
#: A nodal diameter beside a circumferential order of its body.
NODAL_DIAMETER = 0.7707
#: Seconds of the fields of a state in a body: once, per 1e5 unknowns with 32 places around.
FIELDS: tuple[float, float] = (0.3687, 0.03849)
