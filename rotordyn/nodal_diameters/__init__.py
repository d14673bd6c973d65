"""Modes of blades and disks by nodal diameter: all cyclic indices of one body over its speed.

Branches in the turning frame, crossings with engine orders, veerings, interference diagrams, and
mistuned blades. In: `CyclicBody`, small matrices of every index. Out: frozen records of arrays.
"""

from __future__ import annotations

from solidwhirl.rotordyn.nodal_diameters.crossings import (
    Crossing,
    Veering,
    engine_order_crossings,
    margin,
    veerings,
)
from solidwhirl.rotordyn.nodal_diameters.interference import excited_index, zigzag
from solidwhirl.rotordyn.nodal_diameters.matrices import (
    CyclicBody,
    CyclicMatrices,
    OmittedEnergy,
    rotating_matrices,
)
from solidwhirl.rotordyn.nodal_diameters.mistuning import (
    AmplificationStatistics,
    MistunedModes,
    amplification_statistics,
    forced_response,
    mistuned_modes,
    random_deviations,
    tuned_frequencies,
    whitehead_bound,
)
from solidwhirl.rotordyn.nodal_diameters.modes import (
    HZ_PER_RAD_S,
    Direction,
    Family,
    NodalDiameterModes,
    directions_of,
    fixed_frame_hz,
    index_spectrum,
    nodal_diameter_modes,
)
from solidwhirl.rotordyn.nodal_diameters.root_stress import (
    BladeRoot,
    RootSection,
    RootStress,
    cycle_peak,
    root_stress,
)

__all__ = [
    "HZ_PER_RAD_S",
    "AmplificationStatistics",
    "BladeRoot",
    "Crossing",
    "CyclicBody",
    "CyclicMatrices",
    "Direction",
    "Family",
    "MistunedModes",
    "NodalDiameterModes",
    "OmittedEnergy",
    "RootSection",
    "RootStress",
    "Veering",
    "amplification_statistics",
    "cycle_peak",
    "directions_of",
    "engine_order_crossings",
    "excited_index",
    "fixed_frame_hz",
    "forced_response",
    "index_spectrum",
    "margin",
    "mistuned_modes",
    "nodal_diameter_modes",
    "random_deviations",
    "root_stress",
    "rotating_matrices",
    "tuned_frequencies",
    "veerings",
    "whitehead_bound",
    "zigzag",
]
