"""Coordinates of a system that no matrix couples, such as torsion beside lateral motion."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import IntArray
from solidwhirl.rotordyn.core.dense import uncoupled

# Couplings below this fraction of the diagonals are what rounding leaves of joints.
_ROUNDING = 1e-13


def uncoupled_groups(assembled: AssembledSystem) -> list[IntArray]:
    """Return groups of coordinates that no matrix couples at any speed, each rising."""
    mass = np.sqrt(np.abs(np.diag(assembled.mass)))
    stiff = np.sqrt(np.abs(np.diag(assembled.stiffness)))
    between = np.sqrt(mass * stiff)
    sizes = (
        (assembled.mass, mass),
        (assembled.gyroscopic, mass),
        (assembled.centrifugal_stiffness, mass),
        (assembled.damping, between),
        (assembled.circulatory_stiffness, between),
        (assembled.stiffness, stiff),
    )
    coupled = (np.abs(matrix) > _ROUNDING * np.outer(size, size) for matrix, size in sizes)
    motions = (np.abs(joint.motion) > _ROUNDING for joint in assembled.law_joints)
    return uncoupled(*coupled, motions=motions)
