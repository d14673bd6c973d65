"""Bearings whose tables are over their load, at the loads that the static analysis finds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.scene.joints import BearingSpec, LoadTableLawSpec
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from solidwhirl.analyses.responses.static import StaticSpec
    from solidwhirl.rotordyn import AssembledSystem

#: Static load of bearings by name at each speed of their tables, N, shape (s,) each.
Loads = Mapping[str, FloatArray]


class _Row(NamedTuple):
    """A row of the table of a bearing."""

    bearing: str
    row: int


class _Loaded(NamedTuple):
    """A bearing with a table over its load, and the speeds Ω of the table's rows, rad/s."""

    bearing: BearingSpec
    law: LoadTableLawSpec
    speeds_rad_s: FloatArray


def load_case(scene: Scene) -> StaticSpec | None:
    """Return the static analysis that loads tables of a scene, None if it has no such table.

    `scene`: without problems: all its tables name one analysis.
    """
    named = [b.law.load_from for b in _loaded(scene)]
    found = [a for a in scene.analyses if a.kind == "static" and a.label in named]
    return found[0] if found else None


def loaded_bearings(scene: Scene) -> list[str]:
    """Return the names of the bearings with a table over their load."""
    return [b.bearing.name for b in _loaded(scene)]


def at_static_loads(
    scene: Scene, case: StaticSpec, assembled: Callable[[Loads], AssembledSystem]
) -> AssembledSystem:
    """Return the system whose tables are at the loads that it has, at each speed of each table.

    `assembled`: the system with given loads. Where supports are redundant, loads and coefficients
    depend on each other, and are iterated to their equilibrium. Above the speeds that bodies were
    reduced for the loads are those of the highest one.
    Raises AnalysisError: a load is beyond its table, or there is no equilibrium.
    """
    from solidwhirl.rotordyn.response.load_equilibrium import loads_in_equilibrium

    bearings = {b.bearing.name: b for b in _loaded(scene)}
    rows = [_Row(name, k) for name, b in bearings.items() for k in range(b.speeds_rad_s.size)]

    def gathered(loads: Mapping[_Row, float]) -> Loads:
        return {
            name: np.array([loads[_Row(name, k)] for k in range(b.speeds_rad_s.size)])
            for name, b in bearings.items()
        }

    def loads_of(system: AssembledSystem) -> Mapping[_Row, FloatArray]:
        top = system.speed_limit_rad_s
        speeds = {r: min(bearings[r.bearing].speeds_rad_s[r.row], top) for r in rows}
        found = {speed: case.response(system, speed) for speed in set(speeds.values())}
        return {r: found[speed].bearing_loads[r.bearing][:3] for r, speed in speeds.items()}

    start = {r: float(np.mean(bearings[r.bearing].law.load_n)) for r in rows}
    found = loads_in_equilibrium(lambda loads: assembled(gathered(loads)), start, loads_of)
    if not found.converged:
        raise AnalysisError(
            f"{case.label}: no loads of {', '.join(bearings)} are in equilibrium with the "
            f"coefficients that their tables have at them; the loads still change by "
            f"{100.0 * found.changes[-1]:.2g} % of the largest after {len(found.changes)} rounds"
        )
    for name, loads in gathered(found.loads_n).items():
        _refuse_beyond(case.label, bearings[name], loads)
    return found.system


def _refuse_beyond(case: str, bearing: _Loaded, loads: FloatArray) -> None:
    low, high = bearing.law.load_n[0], bearing.law.load_n[-1]
    slack = 1e-9 * high
    beyond = np.flatnonzero((loads < low - slack) | (loads > high + slack))
    if beyond.size:
        worst = beyond[np.argmax(np.abs(loads[beyond] - 0.5 * (low + high)))]
        name = bearing.bearing.name
        raise AnalysisError(
            f"bearing {name!r}: its static load is {loads[worst]:.6g} N at "
            f"{bearing.speeds_rad_s[worst] * RPM_PER_RAD_S:.6g} rpm of the reference shaft "
            f"(analysis {case!r}); the table {bearing.bearing.speed_law!r} has loads from {low:g} "
            f"to {high:g} N"
        )


def _loaded(scene: Scene) -> list[_Loaded]:
    found = []
    for bearing in scene.bearings:
        law = scene.law_of(bearing)
        if isinstance(law, LoadTableLawSpec):
            ratio = abs(scene.speed_ratio_at(bearing.first))
            speeds = np.array(law.tables[0].speed_rpm) * RAD_S_PER_RPM / ratio
            found.append(_Loaded(bearing, law, speeds))
    return found
