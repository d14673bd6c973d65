"""Critical speed map: undamped critical speeds over the stiffness of chosen bearings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import FloatArray, StringArray, freeze_arrays
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.map_branches import MapPoint, follow_branches
from solidwhirl.rotordyn.map_points import (
    MapRequest,
    MapSolver,
    rigid_speeds,
    stiffness_at_rest,
)
from solidwhirl.rotordyn.reprs import critical_speed_map_text
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.whirl import whirl_direction
from solidwhirl.rotordyn.whirl_pencils import Pencil


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CriticalSpeedMap:
    """Hold undamped critical speeds over the stiffness of some bearings.

    Attributes
    ----------
    bearings
        Names of the bearings that were varied, all to the same stiffness k·I.
    stiffness_n_per_m
        k, rising, shape (s,), N/m; the stiffness at rest times a factor where a law depends on
        the speed.
    excitation_ratio
        α: frequency of the excitation over Ω.
    speed_rad_s
        Ω of each branch, shape (b, s), rad/s; nan where a branch is above the limit or absent.
    whirl
        "forward", "backward", "mixed" or "planar", shape (b, s); empty where the speed is nan.
    likeness
        Of the shape to that at the previous stiffness, 0 to 1: the smallest on the way, shape
        (b, s); 1 where a branch begins, 0 where there is none.
    chosen_stiffness_n_per_m
        k_xx and k_yy at rest of the bearings as the system has them, shape (len(bearings), 2).
    free_rad_s, free_whirl
        Critical speeds without the bearings, shape (f,): where the branches come from. Empty as
        well if a free body then whirls without force at any speed.
    rigid_rad_s, rigid_whirl
        Critical speeds with ux and uy joined rigidly, shape (r,): where the branches go to.
    """

    bearings: tuple[str, ...]
    stiffness_n_per_m: FloatArray
    excitation_ratio: float
    speed_rad_s: FloatArray
    whirl: StringArray
    likeness: FloatArray
    chosen_stiffness_n_per_m: FloatArray
    free_rad_s: FloatArray
    free_whirl: StringArray
    rigid_rad_s: FloatArray
    rigid_whirl: StringArray

    def __post_init__(self) -> None:
        freeze_arrays(
            self,
            "stiffness_n_per_m",
            "speed_rad_s",
            "whirl",
            "likeness",
            "chosen_stiffness_n_per_m",
            "free_rad_s",
            "free_whirl",
            "rigid_rad_s",
            "rigid_whirl",
        )

    def __repr__(self) -> str:
        return critical_speed_map_text(self)


def critical_speed_map(
    assembled: AssembledSystem,
    bearings: Sequence[str],
    stiffnesses_n_per_m: npt.ArrayLike,
    *,
    excitation_ratio: float = 1.0,
    branch_count: int | None = None,
    speed_max_rad_s: float | None = None,
) -> CriticalSpeedMap:
    """Compute the undamped critical speeds over the stiffness of some bearings.

    Parameters
    ----------
    assembled
        The system; its damping is left out.
    bearings
        Names of the bearings that get the stiffness k·I on (ux, uy) instead of their own. One with
        a `PolynomialLaw` keeps it: k is its stiffness before the factor of the law.
    stiffnesses_n_per_m
        k, positive, strictly rising, shape (s,), N/m. Spaced by equal factors as a rule.
    excitation_ratio
        α, as for `critical_speeds`.
    branch_count
        Lowest branches wanted of each whirl direction; twice that number in all where directions
        cannot be told apart beforehand (anisotropic supports). None is all below the limit.
    speed_max_rad_s
        Leave out what lies above; None is the range the bodies were made for.

    Returns
    -------
    CriticalSpeedMap
        Lateral critical speeds only. Branches by rising speed where they begin. Where a bearing
        stiffens faster than Ω² a curve may turn back over k: it is then cut into branches that
        begin or end there, and all of them are found if no `branch_count` is given.

    Raises
    ------
    AnalysisError
        If the arguments have no meaning, a bearing to vary is rigid, the stiffness is not
        symmetric, or neither a limit nor a number of branches is known.

    Notes
    -----
    Each point is solved directly (see `critical_speeds`), forward and backward whirl apart where
    the system is isotropic; nothing is assembled anew but where k passes the stiffness of
    another bearing, because the coordinates follow the stiffest path of joints. Branches are
    paired by the likeness of shapes in the energy product of the stiffness. See Müller and
    Hennings, section 5.3 and figure 9.
    """
    stiffness = _checked_stiffness(stiffnesses_n_per_m)
    request = _checked_request(assembled, bearings, excitation_ratio, branch_count, speed_max_rad_s)
    solver = MapSolver(assembled, request)
    found = [
        branch
        for place in range(len(solver.lateral))
        for branch in _branches(solver, place, stiffness)
    ]
    found.sort(key=lambda branch: branch.speeds[np.isfinite(branch.speeds)][0])
    shape = (len(found), stiffness.size)
    free, free_whirl = solver.free()
    rigid, rigid_whirl = rigid_speeds(assembled, request)
    chosen = [stiffness_at_rest(assembled, name) for name in request.names]
    return CriticalSpeedMap(
        bearings=request.names,
        stiffness_n_per_m=stiffness,
        excitation_ratio=request.ratio,
        speed_rad_s=np.array([branch.speeds for branch in found]).reshape(shape),
        whirl=np.array([branch.whirl for branch in found], dtype="<U8").reshape(shape),
        likeness=np.array([branch.likeness for branch in found]).reshape(shape),
        chosen_stiffness_n_per_m=np.array(chosen),
        free_rad_s=free,
        free_whirl=free_whirl,
        rigid_rad_s=rigid,
        rigid_whirl=rigid_whirl,
    )


class _Branch(NamedTuple):
    """Critical speed (nan where absent), whirl and likeness over the stiffness, each (s,)."""

    speeds: FloatArray
    whirl: list[str]
    likeness: FloatArray


def _branches(solver: MapSolver, place: int, stiffness: FloatArray) -> Iterator[_Branch]:
    """Follow the branches of one pencil that are among those wanted at some stiffness."""
    pencil, request = solver.lateral[place], solver.request
    points = [solver.point(place, float(k)) for k in stiffness]
    wanted = _wanted(points, request, pencil)
    points, branches = follow_branches(
        points, partial(solver.point, place), partial(solver.metric, place), wanted
    )
    for columns, likeness in zip(branches.columns, branches.likeness, strict=True):
        if not ((columns >= 0) & (columns < wanted)).any():
            continue
        speeds = np.array(
            [p.speeds[c] if c >= 0 else np.nan for p, c in zip(points, columns, strict=True)]
        )
        speeds[~(speeds <= request.limit)] = np.nan
        if np.isfinite(speeds).any():
            whirl = _branch_whirl(solver, pencil, points, columns, speeds)
            yield _Branch(speeds, whirl, likeness)


def _wanted(points: Sequence[MapPoint], request: MapRequest, pencil: Pencil) -> int:
    """Return how many of the lowest critical speeds of a pencil are looked at."""
    below = max(int(np.count_nonzero(point.speeds <= request.limit)) for point in points)
    if request.branch_count is None:
        return below
    return min(below, request.branch_count * (1 if pencil.whirl else 2))


def _branch_whirl(
    solver: MapSolver,
    pencil: Pencil,
    points: Sequence[MapPoint],
    columns: npt.NDArray[np.int_],
    speeds: FloatArray,
) -> list[str]:
    """Return the whirl of one branch at each stiffness."""
    if pencil.whirl:
        return [pencil.whirl if np.isfinite(speed) else "" for speed in speeds]
    return [
        str(
            whirl_direction(solver.reference.assembled, pencil.expand(point.shapes[:, [column]]))[0]
        )
        if np.isfinite(speed)
        else ""
        for point, column, speed in zip(points, columns, speeds, strict=True)
    ]


def _checked_stiffness(stiffnesses_n_per_m: npt.ArrayLike) -> FloatArray:
    values = np.array(stiffnesses_n_per_m, dtype=float)
    fits = values.ndim == 1 and values.size > 0 and np.isfinite(values).all()
    if not fits or not values[0] > 0 or not (np.diff(values) > 0).all():
        raise AnalysisError(
            "stiffnesses_n_per_m needs positive, finite, strictly rising values; found shape "
            f"{values.shape}"
        )
    return values


def _checked_request(
    assembled: AssembledSystem,
    names: Sequence[str],
    excitation_ratio: float,
    branch_count: int | None,
    speed_max_rad_s: float | None,
) -> MapRequest:
    known = {bearing.name: bearing for bearing in assembled.system.bearings}
    if isinstance(names, str) or not names or any(name not in known for name in names):
        raise AnalysisError(f"bearings is {names!r}; one or more of {list(known)} are allowed")
    for name in names:
        if {"ux", "uy"} & set(known[name].rigid):
            raise AnalysisError(f"bearing {name!r} is rigid; its stiffness cannot be varied")
    if not assembled.has_symmetric_joints:
        raise AnalysisError(
            "the stiffness is not symmetric (cross-coupled bearings); a critical speed map is that "
            "of an undamped system with a symmetric one"
        )
    ratio = abs(float(excitation_ratio))
    if not np.isfinite(ratio) or ratio == 0:
        raise AnalysisError(f"excitation_ratio is {excitation_ratio}; finite and not 0 is allowed")
    if branch_count is not None and branch_count < 1:
        raise AnalysisError(f"branch_count is {branch_count}; it must be 1 or more, or None")
    limit = assembled.speed_limit_rad_s if speed_max_rad_s is None else float(speed_max_rad_s)
    if not limit > 0:
        raise AnalysisError(f"speed_max_rad_s is {speed_max_rad_s}; it must be positive")
    depends = any(known[j.bearing].speed_law is not None for j in assembled.law_joints)
    if not np.isfinite(limit) and (branch_count is None or depends):
        raise AnalysisError(
            "speed_max_rad_s is needed: there is no limit of the bodies, and "
            + ("bearings depend on the speed" if depends else "no branch_count is given")
        )
    return MapRequest(tuple(names), ratio, branch_count, limit)
