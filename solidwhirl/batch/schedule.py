"""Order and place of the cases of a batch: predicted costs, teams of ranks, memory, time to go."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from solidwhirl.core.errors import SceneError
from solidwhirl.cost.forecast import forecast
from solidwhirl.cost.machine import Machine
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.model.mesh_bodies import build_mesh_bodies
from solidwhirl.scene.records import Scene

# Up to so many teams rank 0 computes too; with more, its share is small and it only coordinates.
_COMPUTING = 8
# Finished cases that correct the predictions; the last ones, as stages are found kept later on.
_LAST = 16
# Reading, writing and the like of a case, which no law of the forecast holds [s].
_AROUND_S = 0.3


@dataclass(frozen=True, kw_only=True)
class Predicted:
    """What a case will cost, of one rank."""

    seconds: float
    peak_memory_gib: float
    least_memory_gib: float = 0.0  # with less, its first mesh is refused


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Which ranks compute a case together."""

    ranks_per_team: int  # size of each team
    teams: int  # number of teams
    first: int  # first rank of the first team: 0, or 1 where rank 0 only coordinates
    idle: int  # ranks that are left over

    def team_of(self, rank: int) -> int | None:
        """Team of a rank; None if it is in none."""
        team, left = divmod(rank - self.first, self.ranks_per_team)
        return team if rank >= self.first and left >= 0 and team < self.teams else None

    def leader_of(self, team: int) -> int:
        """First rank of a team."""
        return self.first + team * self.ranks_per_team


def predicted_cost(scene: Scene, machine: Machine) -> Predicted:
    """Predict what a scene costs, with its analyses and as if nothing were kept.

    Where the scene leaves the level to the program it counts as harmonic: to try whether beams are
    enough takes as long as a small case.

    `machine`: that they run on, the same for all cases that are compared. Raises ValueError:
    something that a run refuses as well.
    """
    level = "harmonic" if scene.model.level == "auto" else scene.model.level
    bodies, meshes = build_bodies(scene), build_mesh_bodies(scene)
    plan = make_plan(scene, bodies, level)
    found = forecast(scene, plan, {**bodies, **meshes}, machine=machine)
    return Predicted(
        seconds=found.seconds,
        peak_memory_gib=found.peak_memory_gib,
        least_memory_gib=max((c.peak_memory_gib for c in found.first.bodies.values()), default=0.0),
    )


def largest_first(
    seconds: Mapping[int, float], todo: Iterable[int], last: Iterable[int] = ()
) -> list[int]:
    """Order of the cases: the most expensive first, and those that failed before after all others.

    `seconds`: predicted time by case [s]. `todo`: indices of those to compute. `last`: of these,
    those that come last: what ended a whole job would end it again.

    Longest processing time first (Graham 1969): the whole takes at most 4/3 of the best order.
    """
    after = frozenset(last)
    return sorted(todo, key=lambda n: (n in after, -seconds.get(n, 0.0), n))


def team_layout(size: int, ranks_per_scene: int, *, answers_while_busy: bool) -> Layout:
    """Divide the ranks into teams.

    Rank 0 gives out the cases. It computes as well where teams are few; it only coordinates where
    they are many, where it is left over anyway, or where it could not answer while it computes.

    `ranks_per_scene`: size of a team. `answers_while_busy`: whether the MPI library lets a second
    thread of rank 0 answer.
    Raises SceneError: a team of more ranks than there are, or of none.
    """
    if not 1 <= ranks_per_scene <= size:
        said = f"{ranks_per_scene}, allowed are 1 to {size}, the number of ranks; start more with"
        raise SceneError("command line", [f"--ranks-per-scene: {said} mpirun -n"])
    whole, without = size // ranks_per_scene, (size - 1) // ranks_per_scene
    alone = without == whole or whole > _COMPUTING or (whole > 1 and not answers_while_busy)
    alone = alone and without > 0
    teams = without if alone else whole
    return Layout(
        ranks_per_team=ranks_per_scene,
        teams=teams,
        first=int(alone),
        idle=size - int(alone) - teams * ranks_per_scene,
    )


class TimeToGo:
    """Time that a batch still takes, from predicted costs corrected by those measured.

    `seconds`: predicted time by case [s]. `teams`: how many cases run at once.
    """

    def __init__(self, seconds: Mapping[int, float], teams: int) -> None:
        self._left = dict(seconds)
        self._teams = teams
        self._pairs: deque[tuple[float, float]] = deque(maxlen=max(_LAST, 2 * teams))

    @property
    def factor(self) -> float:
        """Measured over predicted time of the cases finished last; 1 before the first."""
        measured = sum(m for m, _ in self._pairs)
        return measured / sum(p for _, p in self._pairs) if self._pairs else 1.0

    def finished(self, case: int, measured_s: float | None) -> None:
        """Take a case off the list.

        `measured_s`: what it took [s]; None if it failed, which says nothing about the others.
        """
        predicted = self._left.pop(case, 0.0)
        if measured_s is not None:
            self._pairs.append((measured_s, max(predicted, _AROUND_S)))

    def seconds(self, running_s: Mapping[int, float]) -> float:
        """Time to go [s]: the work left by all teams, but not less than the longest case left.

        `running_s`: time since its start by running case [s].
        """
        factor = self.factor
        left = {
            case: max(factor * predicted - running_s.get(case, 0.0), 0.0)
            for case, predicted in self._left.items()
        }
        return max(sum(left.values()) / self._teams, max(left.values(), default=0.0))


@dataclass(frozen=True, kw_only=True)
class Memory:
    """Memory of the nodes [GiB], divided among the cases that run."""

    free_gib: Mapping[str, float]  # by node, before the first case
    # Of everyone who computes cases: part of a case's memory by node; the parts add up to 1
    places: Sequence[Mapping[str, float]]
    needs_gib: Mapping[int, float]  # predicted peak by case; one that is not in it needs none

    def allows(
        self, case: int, shares: Mapping[str, float], running: Mapping[int, Mapping[str, float]]
    ) -> bool:
        """Whether a case of these parts by node fits beside those that run, by their parts.

        One that fits nowhere, ever, runs alone: whether that can be done is for the case itself to
        say.
        """
        need = self.needs_gib.get
        beside = {
            node: sum(at.get(node, 0.0) * need(n, 0.0) for n, at in running.items())
            for node in shares
        }

        def fits(place: Mapping[str, float], taken: Mapping[str, float]) -> bool:
            return all(
                taken.get(node, 0.0) + part * need(case, 0.0) <= self.free_gib[node]
                for node, part in place.items()
            )

        if fits(shares, beside):
            return True
        return not any(beside.values()) and not any(fits(place, {}) for place in self.places)
