"""Coefficients of whole runs, written by `python bench/forecast.py --fit`."""

from __future__ import annotations

#: Where they were measured, on one core.
MACHINE = "Intel(R) Xeon(R) Processor"
#: Rates of `solidwhirl.core.machine` there [1e9/s].
GFLOPS = 72.39
#: And of memory [1e9 bytes/s].
GBYTES_PER_S = 22.73
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
START: tuple[float, float, float] = (1.01, 0.1346, 0.02196)
#: Seconds of the imports of mesher and solvers.
SOLVERS_S = 0.3764
#: How often the laws of meshes count.
MESHES = 0.674
#: Kind of body: seconds of each reduction beside its law, and times that law.
BODIES: dict[str, tuple[float, float]] = {
    "harmonic": (0.1302, 1.109),
    "revolved": (0.1302, 0.9561),
    "sector": (0.1302, 1.302),
    "whole": (0.1302, 0.9118),
    "asymmetric": (0.1302, 3.471),
}
#: How often the law of memory counts for an asymmetric body.
ASYMMETRIC_MEMORY = 3.102
#: Seconds a + b (n/100)^2 + c (n/100)^3 of one, in an engine of n coordinates.
UNITS: dict[str, tuple[float, float, float]] = {
    "undamped": (0.0002662, 0, 0.001737),
    "eigenproblem.hermitian": (0.005039, 0, 0.001931),
    "eigenproblem.damped": (0.003928, 0.008552, 0),
    "eigenproblem.isotropic": (0.007065, 0.003605, 0),
    "eigenproblem.asymmetric": (0.01602, 0, 0),
    "eigenproblem.periodic": (0, 0, 6.451),
    "continued": (0.002716, 0.002759, 0),
    "factorisation": (0, 0.0006621, 0),
    "solve": (4.286e-05, 9.773e-05, 0),
    "balance": (0.001953, 0, 0),
    "step": (1.896e-06, 1.642e-05, 0),
    "check": (0.001563, 0.005946, 0),
    "result": (0.0004511, 0, 0),
}
#: How often the laws count of bodies with either coupling of their interfaces.
COMPARED = 0.8335
#: Seconds of the files: once, per 1e5 unknowns, per 1e6 numbers of records.
FILES: tuple[float, float, float] = (0.1017, 0.1912, 0.1432)
#: Seconds of the page: once, per analysis, per 1e5 unknowns, per 1e6 record numbers, with fields.
PAGE: tuple[float, float, float, float, float] = (0.07412, 0.008175, 0.1611, 0.2562, 0.782)
#: Seconds of the pictures: once, and of each.
PICTURES: tuple[float, float] = (0, 0.2899)
#: A nodal diameter beside a circumferential order of its body.
NODAL_DIAMETER = 0.7144
#: Seconds of the fields of a state in a body: once, per 1e5 unknowns with 32 places around.
FIELDS: tuple[float, float] = (0.3687, 0.03942)
