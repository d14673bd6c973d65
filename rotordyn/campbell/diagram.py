"""Campbell diagram: frequencies and damping of the branches over the speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.branches import (
    TrackingNote,
    all_below,
    branch_notes,
    follow,
    lowest,
)
from solidwhirl.rotordyn.campbell.matching import Tracked
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays, StringArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.reprs import lines_of, speed_range
from solidwhirl.rotordyn.modes.damping import log_decrement
from solidwhirl.rotordyn.modes.kinds import kinds
from solidwhirl.rotordyn.modes.whirl import Motion, motion_of, turned_with_speed
from solidwhirl.rotordyn.superelement.families import FAMILIES


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Campbell(ReadOnlyArrays):
    """Hold the tracked branches of a system over the speed.

    Attributes
    ----------
    speeds_rad_s
        Ω, shape (s,), rad/s.
    eigenvalues
        λ in 1/s, shape (b, s); nan where a branch does not exist: before it begins, after its end.
    frequency_hz
        Im λ / 2π, shape (b, s), Hz.
    log_decrement
        −2π Re λ / Im λ, shape (b, s); negative is unstable.
    whirl
        "forward", "backward", "mixed" or "straight" of lateral motion, else the kind: "torsional",
        "axial", "disk", "coupled"; shape (b, s), empty where there is no branch.
    shares
        Of the kinetic energy by family, lateral, torsional, axial and disk, shape (b, s, 4); nan
        where there is no branch.
    overlap
        MAC of each branch to its previous point, 0 to 1: the smallest on the way, shape
        (b, s); 1 where it begins.
    notes
        Crossings, veerings, beginnings, ends and doubtful places.
    """

    speeds_rad_s: FloatArray
    eigenvalues: ComplexArray
    frequency_hz: FloatArray
    log_decrement: FloatArray
    whirl: StringArray
    shares: FloatArray
    overlap: FloatArray
    notes: tuple[TrackingNote, ...]

    @property
    def kind(self) -> StringArray:
        """Lateral, torsional, axial, disk or coupled, shape (b, s); empty without a branch."""
        return kinds(self.shares)

    def __repr__(self) -> str:
        branches = []
        pairs = zip(self.frequency_hz, self.whirl, strict=True)
        for number, (frequency, whirl) in enumerate(pairs, start=1):
            alive = np.flatnonzero(np.isfinite(frequency))
            ends = [
                f"{frequency[k]:.2f} Hz {whirl[k]}" for k in alive[[0, -1] if alive.size else []]
            ]
            branches.append(f"{number}: {' to '.join(ends) or 'absent'}")
        notes = f", {len(self.notes)} notes" if self.notes else ""
        head = f"Campbell: {len(branches)} branches, {speed_range(self.speeds_rad_s)}{notes}"
        return lines_of(head, branches)


def campbell(
    assembled: AssembledSystem,
    speeds_rad_s: npt.ArrayLike,
    *,
    branch_count: int | None = None,
    frequency_max_hz: float | None = None,
) -> Campbell:
    """Follow the modes of a system over a range of speeds.

    `speeds_rad_s`: Ω, strictly monotonic, shape (s,); `branch_count`: hold every mode that is among
    this many lowest ones at one of the speeds or on the way there from rest, and those of equal
    frequency that it would cut off from them; all, if there are fewer; `frequency_max_hz`: hold
    every mode that comes below this frequency at one of the speeds. Exactly one of the two is
    given. Branches by rising frequency at rest, those that the spin lifts from zero first and equal
    ones by that at the next speed; then those that begin at a speed, by that speed. Modes are
    followed from rest, so that neither the branches nor their order depend on where the range
    begins. There may be none. Raises AnalysisError if the arguments have no meaning.

    Branches are paired by the MAC of their states in the energy product, one pairing for all
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
        selection = all_below(assembled, frequency_max_hz)
    else:
        selection = lowest(branch_count or 1)
    return _diagram(assembled, speeds, follow(assembled, speeds, selection))


def _checked_speeds(speeds_rad_s: npt.ArrayLike) -> FloatArray:
    speeds = np.array(speeds_rad_s, dtype=float)
    steps = np.diff(speeds) if speeds.ndim == 1 else np.empty(0)
    monotonic = bool((steps > 0).all() or (steps < 0).all())
    if speeds.ndim != 1 or not speeds.size or not np.isfinite(speeds).all() or not monotonic:
        raise AnalysisError(
            f"speeds_rad_s needs finite, strictly monotonic speeds; found shape {speeds.shape}"
        )
    return speeds


def _diagram(assembled: AssembledSystem, speeds: FloatArray, at_speeds: list[Tracked]) -> Campbell:
    """Collect the branches at the speeds asked for."""
    low, high = float(speeds.min()), float(speeds.max())
    at_speeds = [at_speed for at_speed in at_speeds if low <= at_speed.modes.speed_rad_s <= high]
    places = np.searchsorted(
        [at_speed.modes.speed_rad_s for at_speed in at_speeds], np.sort(speeds)
    )
    eigenvalues = np.stack([at_speeds[int(i)].values() for i in places], axis=1)
    motion = _motion(assembled, [at_speeds[int(i)] for i in places])
    overlap = np.ones(eigenvalues.shape)
    for column, (begin, end) in enumerate(pairwise(places), start=1):
        way = [at_speed.overlap for at_speed in at_speeds[int(begin) + 1 : int(end) + 1]]
        overlap[:, column] = np.min(way, axis=0)
    along = slice(None, None, -1 if speeds[-1] < speeds[0] else 1)
    eigenvalues = eigenvalues[:, along]
    return Campbell(
        speeds_rad_s=speeds,
        eigenvalues=eigenvalues,
        frequency_hz=eigenvalues.imag / (2.0 * np.pi),
        log_decrement=log_decrement(eigenvalues),
        whirl=motion.whirl[:, along],
        shares=motion.shares[:, along],
        overlap=overlap[:, along],
        notes=branch_notes(assembled, at_speeds[along]),
    )


def _motion(assembled: AssembledSystem, at_speeds: Sequence[Tracked]) -> Motion:
    """Return whirl (b, s) and shares (b, s, 4) of the branches at each speed."""
    shown = [at_speed.columns[at_speed.columns >= 0] for at_speed in at_speeds]
    shapes = [s.modes.shapes[:, own] for s, own in zip(at_speeds, shown, strict=True)]
    every = motion_of(assembled, np.hstack(shapes))
    size = (at_speeds[0].columns.size, len(at_speeds))
    whirl, shares = (
        np.full(size, "", dtype=every.whirl.dtype),
        np.full((*size, len(FAMILIES)), np.nan),
    )
    ends = np.cumsum([own.size for own in shown])[:-1]
    for place, (directions, parts) in enumerate(
        zip(np.split(every.whirl, ends), np.split(every.shares, ends), strict=True)
    ):
        modes, alive = at_speeds[place].modes, at_speeds[place].columns >= 0
        all_modes = np.full(modes.eigenvalues.size, "", dtype=every.whirl.dtype)
        all_modes[shown[place]] = directions
        own = turned_with_speed(assembled, all_modes, modes.eigenvalues, modes.speed_rad_s)
        whirl[alive, place], shares[alive, place] = own[shown[place]], parts
    return Motion(whirl, shares)
