"""Coordinates of a system that no matrix couples, such as torsion beside lateral motion."""

from __future__ import annotations

import numpy as np
import scipy

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import IntArray

# Couplings below this fraction of the diagonals are what rounding leaves of joints.
_ROUNDING = 1e-13


def uncoupled_groups(assembled: AssembledSystem) -> list[IntArray]:
    """Return groups of coordinates that no matrix couples at any speed, each rising."""
    mass = np.sqrt(np.abs(np.diag(assembled.mass)))
    stiff = np.sqrt(np.abs(np.diag(assembled.stiffness)))
    between = np.sqrt(mass * stiff)
    coupled = np.zeros((assembled.size,) * 2, dtype=bool)
    for matrix, size in (
        (assembled.mass, mass),
        (assembled.gyroscopic, mass),
        (assembled.centrifugal_stiffness, mass),
        (assembled.damping, between),
        (assembled.circulatory_stiffness, between),
        (assembled.stiffness, stiff),
    ):
        coupled |= np.abs(matrix) > _ROUNDING * np.outer(size, size)
    for joint in assembled.law_joints:
        touched = np.abs(joint.motion).max(axis=0) > _ROUNDING
        coupled |= np.outer(touched, touched)
    count, group = scipy.sparse.csgraph.connected_components(coupled, directed=False)
    return [np.flatnonzero(group == k) for k in range(count)]
