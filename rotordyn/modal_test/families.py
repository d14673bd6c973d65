"""Natural modes in families of one frequency: a round rotor at rest has each in two planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.dense import solve_standing
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modal_test.places import axial_rows, lateral_rows
from solidwhirl.rotordyn.modes.eigen import modes_at_speed, scaled_stiffness

# Relative difference below which frequencies are one.
_EQUAL = 1e-6
# Largest motion times the root of the mass below which a mode has none.
_NO_MOTION = 1e-6
#: Motions that points may see, by the name of their kind
_ROWS = {"lateral": lateral_rows, "axial": axial_rows}
LATERAL = frozenset({"lateral"})


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ModeFamilies(ReadOnlyArrays):
    """Hold the natural modes of a system, without motions at 0 Hz.

    `frequency_hz`: of each mode, rising, shape (m,). `shapes`: with unit modal mass, shape (n, m).
    `damping_ratio`: shape (m,). `family`: which family a mode belongs to, from 0, -1 for one
    without the motions that are looked at, shape (m,). Modes of a family have one frequency, and
    any combination of them is a mode.
    """

    frequency_hz: FloatArray
    shapes: FloatArray | ComplexArray
    damping_ratio: FloatArray
    family: IntArray

    @property
    def family_hz(self) -> FloatArray:
        """Frequency of each family, shape (g,)."""
        return np.array([self.frequency_hz[self.family == k].mean() for k in range(self.count)])

    @property
    def family_damping(self) -> FloatArray:
        """Damping ratio of each family, shape (g,)."""
        return np.array([self.damping_ratio[self.family == k].mean() for k in range(self.count)])

    @property
    def count(self) -> int:
        """Number of families."""
        return int(self.family.max(initial=-1)) + 1

    @property
    def sizes(self) -> IntArray:
        """Number of modes of each family, shape (g,)."""
        return np.bincount(self.family[self.family >= 0], minlength=self.count)

    def motion(self, rows: FloatArray, family: int) -> FloatArray | ComplexArray:
        """Return what rows (p, n) see of the modes of a family, shape (p, modes)."""
        return np.asarray(rows @ self.shapes[:, self.family == family])

    def with_damping(self, values: Sequence[float]) -> ModeFamilies:
        """Return the same modes with damping ratios by family.

        `values`: the last one holds for families beyond and for modes of none.
        """
        listed = np.asarray(values, dtype=float)
        at = np.where(self.family < 0, len(listed) - 1, self.family)
        return replace(self, damping_ratio=listed[np.minimum(at, len(listed) - 1)])


# several shapes of one model are asked for in turn
@lru_cache(maxsize=1)
def mode_families(system: AssembledSystem, kinds: frozenset[str] = LATERAL) -> ModeFamilies:
    """Find all undamped modes at rest and sort them into families.

    `kinds`: "lateral", "axial" or both: motions that count. Raises AnalysisError if bearings push,
    so that modes at rest grow.
    """
    scaled = scaled_stiffness(system, matrices_at_speed(system, 0.0))
    if scaled.negative_count:
        raise AnalysisError(
            "supports have negative stiffness at rest, so that the engine does not stay where it is"
        )
    omega, shapes = solve_standing(scaled)
    return ModeFamilies(
        frequency_hz=omega / (2.0 * np.pi),
        shapes=shapes,
        damping_ratio=np.zeros(omega.size),
        family=_families(system, kinds, omega, shapes),
    )


def families_at_speed(
    system: AssembledSystem, speed_rad_s: float, kinds: frozenset[str] = LATERAL
) -> ModeFamilies:
    """Sort the damped modes of a system at a speed into families; shapes are complex.

    `speed_rad_s`: of the reference shaft; `kinds`: as of `mode_families`.
    """
    modes = modes_at_speed(system, speed_rad_s)
    return ModeFamilies(
        frequency_hz=modes.frequency_hz,
        shapes=modes.shapes,
        damping_ratio=modes.damping_ratio,
        family=_families(system, kinds, modes.frequency_hz, modes.shapes),
    )


def _families(
    system: AssembledSystem,
    kinds: frozenset[str],
    frequency: FloatArray,
    shapes: FloatArray | ComplexArray,
) -> IntArray:
    """Number modes that move by their frequencies, which rise, shape (m,)."""
    rows = np.concatenate([_ROWS[kind](system) for kind in sorted(kinds)])
    mass = sum(rotor.element.mass_kg for rotor in system.system.rotors.values())
    reach = np.abs(rows @ shapes).max(axis=0, initial=0.0) * np.sqrt(mass)
    family, last, count = np.full(frequency.size, -1), -np.inf, -1
    for k in np.flatnonzero(reach > _NO_MOTION):
        count += int(frequency[k] > last * (1.0 + _EQUAL) or count < 0)
        family[k], last = count, frequency[k]
    return family
