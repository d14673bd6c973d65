"""Growth of both solvers of a solid, written by `python bench/multigrid.py --fit`."""

from __future__ import annotations

#: Modes of one eigensolution, and unknowns solved for in the largest measurement.
MODES, LARGEST = 12, 187302
#: "solver.quantity": GiB or s at 1e5 unknowns solved for, their power as fitted, and by theory.
SOLVERS: dict[str, tuple[float, float, float]] = {
    "direct.memory_gib": (0.473957, 1.4218, 1.33333),
    "iterative.memory_gib": (0.259214, 1.0054, 1.0),
    "iterative.setup_s": (5.84713, 1.41323, 1.0),
    "iterative.static_s": (1.35362, 1.18389, 1.0),
    "iterative.modes_s": (32.9578, 1.13151, 1.0),
}
