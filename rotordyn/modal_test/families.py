"""Natural modes at rest in families of one frequency: a round rotor has each in two planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.dense import solve_standing
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modal_test.places import lateral_rows
from solidwhirl.rotordyn.modes.eigen import scaled_stiffness

# Relative difference below which frequencies are one.
_EQUAL = 1e-6
# Largest lateral motion times the root of the mass below which a mode has none.
_NO_LATERAL = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ModeFamilies(ReadOnlyArrays):
    """Hold the undamped natural modes of a system at rest, without motions at 0 Hz.

    `frequency_hz`: of each mode, rising, shape (m,). `shapes`: with unit modal mass, shape (n, m).
    `family`: which family a mode belongs to, from 0, -1 for one without lateral motion (axial,
    torsion), shape (m,). Modes of a family have one frequency, and any combination of them is a
    mode.
    """

    frequency_hz: FloatArray
    shapes: FloatArray
    family: IntArray

    @property
    def lateral_hz(self) -> FloatArray:
        """Frequency of each family, shape (g,)."""
        return np.array([self.frequency_hz[self.family == k].mean() for k in range(self.count)])

    @property
    def count(self) -> int:
        """Number of families."""
        return int(self.family.max(initial=-1)) + 1

    @property
    def sizes(self) -> IntArray:
        """Number of modes of each family, shape (g,)."""
        return np.bincount(self.family[self.family >= 0], minlength=self.count)

    def motion(self, rows: FloatArray, family: int) -> FloatArray:
        """Return what rows (p, n) see of the modes of a family, shape (p, modes)."""
        return np.asarray(rows @ self.shapes[:, self.family == family])


# several shapes of one model are asked for in turn
@lru_cache(maxsize=1)
def mode_families(system: AssembledSystem) -> ModeFamilies:
    """Find all undamped modes at rest and sort them into families.

    Raises AnalysisError if bearings push, so that modes at rest grow.
    """
    scaled = scaled_stiffness(system, matrices_at_speed(system, 0.0))
    if scaled.negative_count:
        raise AnalysisError(
            "supports have negative stiffness at rest, so that the engine does not stay where it is"
        )
    omega, shapes = solve_standing(scaled)
    mass = sum(rotor.element.mass_kg for rotor in system.system.rotors.values())
    reach = np.abs(lateral_rows(system) @ shapes).max(axis=0, initial=0.0) * np.sqrt(mass)
    family, last, count = np.full(omega.size, -1), -np.inf, -1
    for k in np.flatnonzero(reach > _NO_LATERAL):
        count += int(omega[k] > last * (1.0 + _EQUAL) or count < 0)
        family[k], last = count, omega[k]
    return ModeFamilies(frequency_hz=omega / (2.0 * np.pi), shapes=shapes, family=family)


def by_mode(families: ModeFamilies, values: Sequence[float]) -> FloatArray:
    """Return a value for each mode from those of the families, shape (m,).

    `values`: by family; the last one holds for those beyond and for modes without lateral motion.
    """
    listed = np.asarray(values, dtype=float)
    at = np.where(families.family < 0, len(listed) - 1, families.family)
    return np.asarray(listed[np.minimum(at, len(listed) - 1)])
