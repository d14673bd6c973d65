"""Tables of a bearing over its static load: a law of the speed once the loads are known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solidwhirl.rotordyn.assembly.bearing_laws import TableLaw
from solidwhirl.rotordyn.assembly.frequency_laws import FrequencyTableLaw
from solidwhirl.rotordyn.core.arrays import FloatArray, freeze_arrays
from solidwhirl.rotordyn.core.errors import AssemblyError

_AXES = ("speeds_rad_s", "frequencies_rad_s")
_VALUES = ("stiffness_n_per_m", "damping_n_s_per_m", "mass_kg")


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class LoadTable:
    """Laws of one bearing at several static loads, between which coefficients are linear.

    `loads_n`: lateral loads √(Fx² + Fy²), rising, shape (l,), l ≥ 2; `laws`: of the same kind at
    the same speeds and frequencies, one for each load. Raises AssemblyError if they are not.
    """

    loads_n: FloatArray
    laws: tuple[TableLaw, ...] | tuple[FrequencyTableLaw, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "loads_n")
        loads, first = self.loads_n, self.laws[0]
        problems = []
        if loads.size < 2 or loads.size != len(self.laws) or not (np.diff(loads) > 0).all():
            problems.append(f"{len(self.laws)} laws at loads {loads.tolist()}; they must rise")
        for law in self.laws[1:]:
            axes = [(getattr(first, a, 0.0), getattr(law, a, 0.0)) for a in _AXES]
            if type(law) is not type(first) or not all(np.array_equal(a, b) for a, b in axes):
                problems.append("the speeds and frequencies differ from load to load")
                break
        if problems:
            raise AssemblyError(tuple(f"law {first.name!r}: {text}" for text in problems))

    @property
    def speeds_rad_s(self) -> FloatArray:
        """Spin speeds of the rows, shape (s,)."""
        return self.laws[0].speeds_rad_s

    def at(self, static_loads_n: FloatArray) -> TableLaw | FrequencyTableLaw:
        """Return the law of a bearing by its load at each speed of the rows, shape (s,).

        Beyond the loads of the table the nearest end value holds.
        """
        loads = np.clip(static_loads_n, *self.loads_n[[0, -1]])
        above = np.clip(np.searchsorted(self.loads_n, loads), 1, self.loads_n.size - 1)
        low, high = self.loads_n[above - 1], self.loads_n[above]
        share, rows = (loads - low) / (high - low), np.arange(loads.size)

        def between(name: str) -> FloatArray:
            every = np.stack([getattr(law, name) for law in self.laws])
            part = share.reshape(-1, *[1] * (every.ndim - 2))
            return np.asarray((1.0 - part) * every[above - 1, rows] + part * every[above, rows])

        names = [name for name in _VALUES if hasattr(self.laws[0], name)]
        changed: dict[str, Any] = {name: between(name) for name in names}
        return replace(self.laws[0], **changed, static_loads_n=np.array(static_loads_n))
