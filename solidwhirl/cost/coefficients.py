"""Coefficients of the cost model, written by `python bench/scaling.py --fit`."""

from __future__ import annotations

#: Where they were measured, and the rates of one core there [1e9/s, 1e9 bytes/s].
MACHINE = "AMD EPYC, 2 cores, 24 GiB, one thread"
GFLOPS, GBYTES_PER_S = 43.5, 46.13
#: Largest number of unknowns measured, by level; beyond it the laws are extrapolated.
LARGEST = {"harmonic": 62451, "revolved": 60736, "solid": 166995}
#: Memory of the program with its solvers [GiB].
BASE_GIB = 0.142
#: "level.order.stage": seconds at 1e5 unknowns and 10 columns, powers of unknowns and columns.
LAWS: dict[str, tuple[float, float, float]] = {
    "harmonic.2.assembly": (0.2018, 0.95, 0),
    "harmonic.2.eigensolutions": (0.4311, 1.021, 0.3763),
    "harmonic.2.estimate": (1.626, 1.077, 0.84),
    "harmonic.2.factorisation": (0.8684, 1.297, 0),
    "harmonic.2.projection": (0.4282, 1.01, 0.833),
    "harmonic.2.static_solutions": (0.1186, 1.13, 0.5806),
    "harmonic.3.assembly": (0.2204, 0.95, 0),
    "harmonic.3.eigensolutions": (0.5057, 1.112, 0.4342),
    "harmonic.3.estimate": (2.048, 1.074, 0.7569),
    "harmonic.3.factorisation": (0.9541, 1.293, 0),
    "harmonic.3.projection": (0.7301, 1.152, 0.7681),
    "harmonic.3.static_solutions": (0.09954, 1.126, 0.5848),
    "harmonic.4.assembly": (0.3251, 0.95, 0),
    "harmonic.4.eigensolutions": (0.5443, 1.035, 0.3516),
    "harmonic.4.estimate": (2.626, 1.044, 0.7442),
    "harmonic.4.factorisation": (1.026, 1.17, 0),
    "harmonic.4.projection": (0.8344, 1.025, 0.721),
    "harmonic.4.static_solutions": (0.1004, 1.06, 0.5766),
    "harmonic.5.factorisation": (1.425, 1.29, 0),
    "harmonic.5.static_solutions": (0.09065, 1.053, 0.6989),
    "revolved.2.assembly": (0.6373, 0.95, 0),
    "revolved.2.eigensolutions": (2.394, 1.267, 1.444),
    "revolved.2.estimate": (13.59, 1.115, 0.8947),
    "revolved.2.factorisation": (1.805, 1.425, 0),
    "revolved.2.projection": (0.555, 1.045, 1.239),
    "revolved.2.static_solutions": (0.1558, 1.272, 0.5325),
    "revolved.3.assembly": (1.132, 0.9531, 0),
    "revolved.3.eigensolutions": (2.859, 1.242, 1.269),
    "revolved.3.estimate": (16.75, 1.076, 0.6856),
    "revolved.3.factorisation": (2.098, 1.42, 0),
    "revolved.3.projection": (0.7246, 1.042, 1.243),
    "revolved.3.static_solutions": (0.1742, 1.285, 0.5211),
    "solid.2.assembly": (0.543, 1.021, 0),
    "solid.2.eigensolutions": (0.6951, 1.163, 2),
    "solid.2.estimate": (0.2771, 1.3, 1),
    "solid.2.factorisation": (5.307, 1.609, 0),
    "solid.2.projection": (0.1875, 1.081, 1.355),
    "solid.2.static_solutions": (0.2274, 1.308, 0.3707),
}
#: Level: seconds per mesh, per cell, and per cell and graded place.
MESHING: dict[str, tuple[float, float, float]] = {
    "harmonic": (0.01023, 8.504e-05, 2.136e-06),
    "revolved": (0.01023, 4e-05, 1e-06),
    "solid": (0.07807, 5.789e-05, 3.001e-06),
}
#: "level.order.what": GiB at 1e5 unknowns, its power, and copies of the columns of the basis.
MEMORY: dict[str, tuple[float, float, float]] = {
    "harmonic.2.estimate": (1.758, 1, 65.97),
    "harmonic.2.reduction": (0.7422, 1, 5.63),
    "harmonic.3.estimate": (1.922, 1, 53.6),
    "harmonic.3.reduction": (0.9177, 1, 5.346),
    "harmonic.4.estimate": (2.239, 1, 48.17),
    "harmonic.4.reduction": (1.136, 1, 4.818),
    "revolved.2.estimate": (1.557, 1, 63.8),
    "revolved.2.reduction": (0.4115, 1, 27.64),
    "revolved.3.estimate": (2.164, 1, 33.67),
    "revolved.3.reduction": (0.6455, 1, 22.61),
    "solid.2.reduction": (0.4356, 1.1, 26.03),
}
