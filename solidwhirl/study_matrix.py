"""How much a study runs: the full matrix and the quick one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Matrix:
    """How much a study runs.

    Attributes
    ----------
    reference_accuracy
        Of the harmonic run that counts as the truth.
    graded_rungs, uniform_rungs
        Rungs by element order; a rung is a number k of refinements.
    solid_factors
        Sizes over those of the first graded rung.
    dial
        Accuracies of adaptive runs.
    ladder_modes
        Fixed-interface modes of the mesh ladders: so many that the mesh's error shows.
    solid_modes
        The same for solids, whose meshes are coarser.
    modes
        Numbers of modes on the finest mesh of `modes_order` with `modes_rung`.
    beam_maps, beam_map_side
        Maps of beams against solids, and their points a side.
    coupling
        Whether both couplings of the interfaces are run.
    longest_s, solid_longest_s
        Cases whose predicted processor time is above are skipped.
    """

    reference_accuracy: float
    graded_rungs: Mapping[int, tuple[int, ...]]
    uniform_rungs: Mapping[int, tuple[int, ...]]
    solid_factors: tuple[float, ...]
    dial: tuple[float, ...]
    ladder_modes: int
    solid_modes: int
    modes: tuple[int, ...]
    modes_order: int
    modes_rung: int
    beam_maps: tuple[str, ...]
    beam_map_side: int
    coupling: bool
    longest_s: float
    solid_longest_s: float


FULL = Matrix(
    reference_accuracy=1e-6,
    graded_rungs={2: (0, 1, 2, 3, 4), 3: (0, 1, 2, 3), 4: (0, 1, 2)},
    uniform_rungs={2: (0, 1, 2), 3: (0, 1, 2), 4: (0, 1)},
    solid_factors=(2.0, 1.4, 1.0, 0.7),
    dial=(1e-2, 1e-3, 1e-4, 1e-5),
    ladder_modes=24,
    solid_modes=8,
    modes=(2, 4, 8, 16),
    modes_order=4,
    modes_rung=2,
    beam_maps=("solid disk", "webbed disk"),
    beam_map_side=6,
    coupling=True,
    longest_s=120.0,
    solid_longest_s=60.0,
)
QUICK = Matrix(
    reference_accuracy=1e-4,
    graded_rungs={2: (0, 1, 2)},
    uniform_rungs={},
    solid_factors=(),
    dial=(1e-2,),
    ladder_modes=6,
    solid_modes=4,
    modes=(),
    modes_order=2,
    modes_rung=2,
    beam_maps=("solid disk",),
    beam_map_side=2,
    coupling=False,
    longest_s=20.0,
    solid_longest_s=20.0,
)
