"""Cases of a batch on teams of ranks: the largest first, each to the team that is free."""

from __future__ import annotations

import _thread
import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from solidwhirl.batch_case import CaseSettings, run_case
from solidwhirl.batch_coordinator import NONE_LEFT, Coordinator
from solidwhirl.batch_desks import Desk, OwnDesk, RemoteDesk
from solidwhirl.batch_memory import MemoryRoom
from solidwhirl.batch_schedule import (
    Layout,
    Predicted,
    TimeToGo,
    largest_first,
    predicted_cost,
    team_layout,
)
from solidwhirl.batch_service import Service
from solidwhirl.batch_team import team_communicator, told_by_first, wait_for_all
from solidwhirl.errors import SceneError
from solidwhirl.machine import MachineSpeed, available_memory_gib, machine_speed
from solidwhirl.sweep import case_scene
from solidwhirl.sweep_records import BatchCase, BatchRow

# Rows of other ranks that were asked to end are waited for so long: mpirun kills after 1 s [s].
_LAST_ROWS_S = 0.4
_REFUSED = Predicted(seconds=0.0, peak_memory_gib=0.0)


@dataclass(frozen=True, kw_only=True)
class Work:
    """What a batch computes; the same on all ranks.

    Attributes
    ----------
    cases
        All cases.
    todo
        Indices of those that have no good row.
    last
        Of these, those that failed before.
    settings
        What they have in common.
    """

    cases: tuple[BatchCase, ...]
    todo: tuple[int, ...]
    last: tuple[int, ...]
    settings: CaseSettings


def predicted_costs(work: Work, world: Any) -> dict[int, Predicted]:
    """Predict the cost of all cases to compute, each rank a part of them.

    Parameters
    ----------
    work
        The batch.
    world
        Communicator of all ranks.

    Returns
    -------
    By index of the case, on all ranks; nothing for cases that a run refuses.
    """
    # of rank 0 for all: an order must not come from how busy the others are at the moment
    machine = world.bcast(machine_speed() if world.rank == 0 else None)
    own = {n: _predicted(work, n, machine) for n in work.todo[world.rank :: world.size]}
    return {n: cost for part in world.allgather(own) for n, cost in part.items()}


def _predicted(work: Work, number: int, machine: MachineSpeed) -> Predicted:
    settings = work.settings
    try:
        scene = case_scene(work.cases[number], level=settings.level, accuracy=settings.accuracy)
        return predicted_cost(scene, machine, pictures=settings.pictures)
    except Exception:  # whatever it is, the case tells it when its turn comes
        return _REFUSED


def layout_of(world: Any, ranks_per_scene: int) -> Layout:
    """Teams of the ranks of a communicator.

    Parameters
    ----------
    world
        Communicator of all ranks.
    ranks_per_scene
        Size of a team.

    Raises
    ------
    SceneError
        More ranks for a scene than there are.
    """
    from mpi4py import MPI

    answers = MPI.Query_thread() >= MPI.THREAD_MULTIPLE
    try:
        return team_layout(world.size, ranks_per_scene, answers_while_busy=answers)
    except ValueError as error:
        raise SceneError("command line", [str(error)]) from error


def run_batch(
    work: Work,
    costs: dict[int, Predicted],
    layout: Layout,
    world: Any,
    keep: Callable[[BatchRow, float], None],
) -> None:
    """Compute all cases to do; every rank calls this.

    Parameters
    ----------
    work, costs, layout
        The batch, from `predicted_costs` and `layout_of`.
    world
        Communicator of all ranks.
    keep
        Writes a row down, with the time to go [s]; called on rank 0 only.

    Raises
    ------
    Exception
        What `keep` raised; the cases running then are finished first.
    """
    if world.size > 1:
        import solidwhirl.reduction  # noqa: F401  # the solvers start on all ranks together
    room = _memory_room(costs, layout, world)
    link = world.Dup()
    own = layout.team_of(world.rank)
    team = _team_of(world, own)

    def end() -> None:
        sys.stderr.write(
            "error: MPI can not save a team that a rank does not come back to; all ranks end, and "
            "the same command with --resume goes on\n"
        )
        sys.stderr.flush()
        world.Abort(1)

    if world.rank != 0:
        if team is not None:
            desk = RemoteDesk(link, has_reserve=layout.first == 0 and not work.last, end=end)
            _work_remotely(work, team, desk)
        wait_for_all(world)
        return
    available = available_memory_gib()
    # what is refused for its size takes no time
    seconds = {n: c.seconds * (c.least_memory_gib <= available) for n, c in costs.items()}
    every = [seconds.get(n, 0.0) for n in range(len(work.cases))]
    coordinator = Coordinator(
        largest_first(every, work.todo, work.last),
        TimeToGo(seconds, layout.teams),
        layout.teams,
        keep,
        room,
    )
    service = Service(coordinator, link, layout, end=end, interrupt=_interrupt)
    _coordinate(work, coordinator, service, team, end)
    wait_for_all(world)
    if coordinator.error is not None:
        raise coordinator.error


def _memory_room(costs: dict[int, Predicted], layout: Layout, world: Any) -> MemoryRoom:
    """Free memory of the nodes, and which team has how many of its ranks on which."""
    from mpi4py import MPI

    told = world.allgather((MPI.Get_processor_name(), available_memory_gib()))
    free: dict[str, float] = {}
    shares: list[dict[str, float]] = [{} for _ in range(layout.teams)]
    for rank, (node, gib) in enumerate(told):
        free[node] = min(gib, free.get(node, gib))
        team = layout.team_of(rank)
        if team is not None:
            part = shares[team].get(node, 0.0) + 1.0 / layout.ranks_per_team
            shares[team][node] = part
    return MemoryRoom(free, shares, {case: cost.peak_memory_gib for case, cost in costs.items()})


def _team_of(world: Any, own: int | None) -> Any | None:
    """Communicator of this rank's team; None for ranks in no team."""
    from mpi4py import MPI

    split = world.Split(MPI.UNDEFINED if own is None else own, world.rank)
    if own is None:
        return None
    return team_communicator(split) if split.size > 1 else split


def _coordinate(
    work: Work,
    coordinator: Coordinator,
    service: Service,
    team: Any | None,
    end: Callable[[], None],
) -> None:
    """Rank 0: answer the others, and compute with them if it is in a team."""
    try:
        if team is not None:
            service.start()
            _run_cases(work, team, OwnDesk(coordinator, 0, end))
        service.finish()
    except KeyboardInterrupt:
        service.stop(_LAST_ROWS_S)
        raise


def _work_remotely(work: Work, team: Any, desk: RemoteDesk) -> None:
    """Other ranks: compute until nothing is left."""
    try:
        _run_cases(work, team, desk)
        if team.rank == 0:
            desk.finished()
    except KeyboardInterrupt:
        desk.ended()
        raise


def _run_cases(work: Work, team: Any, desk: Desk) -> None:
    """Take cases until none is left; the first rank of the team asks and reports."""
    first = team.rank == 0
    while True:
        number = told_by_first(team, desk.next_case() if first else 0)
        if number == NONE_LEFT:
            return

        def lost(row: BatchRow, number: int = number) -> None:
            desk.lost(number, row)

        row = run_case(work.cases[number], work.settings, team, lost)
        if row is not None:
            desk.put(number, row)


def _interrupt() -> None:
    """Another rank was asked to end: this one is, too."""
    _thread.interrupt_main(signal.SIGTERM)  # nothing if it is ending already


def kept_cases(
    cases: Sequence[BatchCase], rows: Sequence[BatchRow], complete: Callable[[str], bool]
) -> frozenset[int]:
    """Return the indices of cases whose row and folder are those of what is asked.

    Parameters
    ----------
    cases
        All cases.
    rows
        Rows that are there.
    complete
        Says whether the folder of a name holds a whole run.
    """
    found = {row.case: row for row in rows if row.status != "failed"}
    return frozenset(
        n
        for n, case in enumerate(cases)
        if case.name in found and found[case.name].digest == case.digest and complete(case.name)
    )
