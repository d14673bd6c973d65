"""Bearing loads where the coefficients of bearings depend on their loads."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.response.static import bearing_loads

Key = TypeVar("Key", bound=Hashable)
# Part of a step below which an iteration that swings is given up.
_SHORTEST = 1.0 / 64.0


# Rounds that the next loads are made of.
_DEPTH = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadEquilibrium(Generic[Key]):
    """Loads that bearings have with the coefficients that they have under these loads.

    `system`: assembled with `loads_n`, lateral loads √(Fx² + Fy²) by bearing, or whatever key tells
    a bearing at a speed; `vectors_n`: the loads that it has, (3,) each. `changes`: in each round
    the largest difference between loads that went in and that came out, over the largest load.
    `converged`: whether the last is below the tolerance; the loads are of no use if not.
    """

    system: AssembledSystem
    loads_n: Mapping[Key, float]
    vectors_n: Mapping[Key, FloatArray]
    changes: tuple[float, ...]
    converged: bool


def loads_in_equilibrium(
    assemble_with: Callable[[Mapping[Key, float]], AssembledSystem],
    start_n: Mapping[Key, float],
    loads_of: Callable[[AssembledSystem], Mapping[Key, FloatArray]] = bearing_loads,  # type: ignore[assignment]
    tolerance: float = 1e-9,
    most: int = 60,
) -> LoadEquilibrium[Key]:
    """Find the fixed point load -> coefficients -> load.

    `assemble_with`: makes a system with the coefficients of its bearings at given lateral loads,
    N. `start_n`: loads to begin with, of the bearings that depend on them. `loads_of`: loads of the
    bearings of a system by the same keys, names by themselves: `bearing_loads` with the loads and
    the speed that are wanted; a key may also be a bearing with a speed.
    `tolerance`: of the largest load. `most`: systems that are tried.

    Where supports are not redundant, the loads are those of a balance and the first round has
    them. Else each round moves a part of the way to the loads found; the part is halved whenever
    the difference has grown, as where a bearing softens with its load and its neighbours take it
    over. Raises AnalysisError if a bearing of `start_n` is not in the system or a load is not
    finite; it does not raise where there is no convergence, which `converged` tells.
    """
    names = list(start_n)
    loads = np.array([float(start_n[name]) for name in names])
    part, changes, rounds = 1.0, list[float](), list[tuple[FloatArray, FloatArray]]()
    for _ in range(most):
        system = assemble_with(dict(zip(names, loads.tolist(), strict=True)))
        vectors = loads_of(system)
        unknown = [name for name in names if name not in vectors]
        if unknown:
            raise AnalysisError(f"there are no bearings {unknown}; there are {list(vectors)}")
        found = np.array([float(np.hypot(*vectors[name][:2])) for name in names])
        if not np.isfinite(found).all():
            raise AnalysisError(f"loads of the bearings {names} are {found.tolist()}")
        scale = max(float(found.max(initial=0.0)), float(np.finfo(float).tiny))
        changes.append(float(np.abs(found - loads).max(initial=0.0)) / scale)
        if changes[-1] <= tolerance or part < _SHORTEST:
            break
        if len(changes) > 1 and changes[-1] >= changes[-2]:
            part, rounds = 0.5 * part, []
        rounds = [*rounds[-_DEPTH:], (loads, found - loads)]
        loads = np.maximum(_next_loads(rounds, part), 0.0)
    return LoadEquilibrium(
        system=system,
        loads_n=dict(zip(names, loads.tolist(), strict=True)),
        vectors_n=vectors,
        changes=tuple(changes),
        converged=changes[-1] <= tolerance,
    )


def _next_loads(rounds: Sequence[tuple[FloatArray, FloatArray]], part: float) -> FloatArray:
    """Loads and their differences of some rounds, the last one last: loads of the next round."""
    loads, difference = rounds[-1]
    if len(rounds) == 1:
        return np.asarray(loads + part * difference)
    steps, changes = (np.diff(np.array(values), axis=0).T for values in zip(*rounds, strict=True))
    weights, *_ = np.linalg.lstsq(changes, difference, rcond=1e-8)
    return np.asarray(loads + part * difference - (steps + part * changes) @ weights)
