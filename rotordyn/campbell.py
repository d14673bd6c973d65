"""Campbell diagram: frequencies and damping of the branches over the speed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray, StringArray, freeze_arrays
from solidwhirl.rotordyn.branch_notes import TrackingNote, branch_notes, untracked_notes
from solidwhirl.rotordyn.branches import follow_below, follow_lowest
from solidwhirl.rotordyn.damping import log_decrement
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.reprs import campbell_text
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.tracking import Front
from solidwhirl.rotordyn.whirl import whirl_direction

# Frequencies closer than this (relative) at the first speed are equal.
_EQUAL = 1e-8


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Campbell:
    """Hold the tracked branches of a system over the speed.

    Attributes
    ----------
    speeds_rad_s
        Ω, shape (s,), rad/s.
    eigenvalues
        λ in 1/s, shape (b, s); nan where a branch has ended.
    frequency_hz
        Im λ / 2π, shape (b, s), Hz.
    log_decrement
        −2π Re λ / Im λ, shape (b, s); negative is unstable.
    whirl
        "forward", "backward", "mixed" or "planar", shape (b, s); empty where a branch has ended.
    overlap
        Likeness of each branch to its previous point, 0 to 1: the smallest on the way, shape
        (b, s); 1 at the first speed.
    notes
        Crossings, veerings and doubtful places.
    """

    speeds_rad_s: FloatArray
    eigenvalues: ComplexArray
    frequency_hz: FloatArray
    log_decrement: FloatArray
    whirl: StringArray
    overlap: FloatArray
    notes: tuple[TrackingNote, ...]

    def __post_init__(self) -> None:
        freeze_arrays(
            self,
            "speeds_rad_s",
            "eigenvalues",
            "frequency_hz",
            "log_decrement",
            "whirl",
            "overlap",
        )

    def __repr__(self) -> str:
        return campbell_text(self)


def campbell(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    *,
    branch_count: int | None = None,
    frequency_max_hz: float | None = None,
) -> Campbell:
    """Follow the modes of a system over a range of speeds.

    Parameters
    ----------
    assembled
        The system.
    speeds_rad_s
        Ω, strictly monotonic, shape (s,); begin at rest as a rule.
    branch_count
        Follow this many of the lowest modes of the first speed, and those of equal frequency that
        it would cut off from them; all, if there are fewer.
    frequency_max_hz
        Follow every mode that comes below this frequency at one of the speeds; one that is rigid
        or overdamped at the first speed has no branch and is noted. Exactly one of the two is
        given.

    Returns
    -------
    Campbell
        Branches by rising frequency at the first speed, equal ones by that at the second.

    Raises
    ------
    AnalysisError
        If the arguments have no meaning.

    Notes
    -----
    Branches are paired by the likeness of their states in the energy product, one pairing for all
    modes (assignment problem). A step is halved where a branch changes much, and looked into where
    two branches exchange their order: a veering wider than 1e-4 of the frequency is not taken for
    a crossing. Modes of equal frequency are turned within their subspace to match the neighbour.
    """
    speeds = _checked_speeds(speeds_rad_s)
    if (branch_count is None) == (frequency_max_hz is None):
        raise AnalysisError("give one of branch_count and frequency_max_hz, not both or none")
    if frequency_max_hz is not None and not frequency_max_hz > 0:
        raise AnalysisError(f"frequency_max_hz is {frequency_max_hz}; it must be positive")
    if branch_count is not None and branch_count < 1:
        raise AnalysisError(f"branch_count is {branch_count}; it must be 1 or more")
    if frequency_max_hz is not None:
        fronts = follow_below(assembled, speeds, frequency_max_hz)
        missing = untracked_notes(fronts, frequency_max_hz)
    else:
        missing = ()
        fronts = follow_lowest(assembled, speeds, branch_count or 1)
    if fronts[0].columns.size == 0:
        limit = "" if frequency_max_hz is None else f" that comes below {frequency_max_hz:g} Hz"
        raise AnalysisError(f"at {speeds[0]:.6g} rad/s there is no oscillatory mode{limit}")
    return _diagram(assembled, speeds, fronts, missing)


def _checked_speeds(speeds_rad_s: npt.ArrayLike) -> FloatArray:
    speeds = np.array(speeds_rad_s, dtype=float)
    steps = np.diff(speeds) if speeds.ndim == 1 else np.empty(0)
    monotonic = bool((steps > 0).all() or (steps < 0).all())
    if speeds.ndim != 1 or not speeds.size or not np.isfinite(speeds).all() or not monotonic:
        raise AnalysisError(
            f"speeds_rad_s needs finite, strictly monotonic speeds; found shape {speeds.shape}"
        )
    return speeds


def _diagram(
    assembled: AssembledSystem,
    speeds: FloatArray,
    fronts: list[Front],
    notes: tuple[TrackingNote, ...],
) -> Campbell:
    """Collect the fronts at the speeds asked for."""
    at = np.searchsorted(
        np.sign(speeds[-1] - speeds[0]) * np.array([f.modes.speed_rad_s for f in fronts]),
        np.sign(speeds[-1] - speeds[0]) * speeds,
    )
    first, second = (fronts[int(i)].values().imag for i in (at[0], at[min(1, len(at) - 1)]))
    # Frequencies equal to rounding at the first speed are ordered by the second.
    group = np.concatenate(([0], np.cumsum(np.diff(first) > _EQUAL * first[1:])))
    order = np.lexsort((second, group))
    fronts = [front.select(order) for front in fronts]
    eigenvalues = np.stack([fronts[int(i)].values() for i in at], axis=1)
    whirl = np.stack([_whirl(assembled, fronts[int(i)]) for i in at], axis=1)
    overlap = [fronts[0].overlap]
    for begin, end in pairwise(at):
        overlap.append(np.min([f.overlap for f in fronts[int(begin) + 1 : int(end) + 1]], axis=0))
    return Campbell(
        speeds_rad_s=speeds,
        eigenvalues=eigenvalues,
        frequency_hz=eigenvalues.imag / (2.0 * np.pi),
        log_decrement=log_decrement(eigenvalues),
        whirl=whirl,
        overlap=np.stack(overlap, axis=1),
        notes=(*notes, *branch_notes(assembled, fronts)),
    )


def _whirl(assembled: AssembledSystem, front: Front) -> StringArray:
    """Return the whirl of each branch; at rest no orbit has a direction."""
    alive = front.columns >= 0
    whirl = np.full(alive.size, "", dtype="<U8")
    if front.modes.speed_rad_s == 0 and assembled.is_conservative:
        whirl[alive] = "planar"
        return whirl
    directions = whirl_direction(assembled, front.modes.shapes[:, front.columns[alive]])
    if front.modes.speed_rad_s < 0:
        swap = {"forward": "backward", "backward": "forward"}
        directions = np.array([swap.get(str(d), str(d)) for d in directions])
    whirl[alive] = directions
    return whirl
