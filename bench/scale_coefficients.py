"""Growth of both solvers of a solid, written by `python bench/multigrid.py --fit`."""

from __future__ import annotations

#: Where it was measured, on one thread.
MACHINE = "AMD EPYC"
#: Entries of a row of the stiffness, and modes of one eigensolution.
ROW_ENTRIES, MODES = 78.61, 12
#: By road and quantity, over the unknowns solved for; seconds of one solution, 12 modes.
MEASURED: dict[str, dict[str, tuple[float, ...]]] = {
    "direct": {
        "solved": (15896, 30802, 55938, 99112, 187302),
        "factor_entries": (3.7e06, 9.366e06, 2.296e07, 5.183e07, 1.342e08),
        "memory_gib": (0.03662, 0.08609, 0.2101, 0.459, 1.165),
        "setup_s": (0.2344, 0.989, 1.989, 3.915, 11.71),
        "static_s": (0.002031, 0.004767, 0.01098, 0.01762, 0.04259),
        "modes_s": (0.275, 0.5857, 1.369, 2.606, 5.89),
    },
    "iterative": {
        "solved": (15896, 30802, 55938, 99112, 187302),
        "memory_gib": (0.03875, 0.07503, 0.1419, 0.2842, 0.4707),
        "setup_s": (0.4337, 1.074, 2.494, 6.14, 13.94),
        "static_s": (0.1593, 0.325, 0.7007, 1.305, 2.866),
        "modes_s": (3.972, 8.198, 18.33, 32.56, 66.55),
    },
}
#: GiB of the program on each rank; of a reduction's matrices and vectors and of the mesh
#: on rank 0 while it is made, per 1e5 unknowns solved for.
PROGRAM_GIB = 0.145
OTHERS_GIB, MESH_GIB = 1.37, 0.1
#: Memory of several ranks over that of one, the program left out.
RANKS_FACTOR = {"direct": 1.45, "iterative": 1.45}
