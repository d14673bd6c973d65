"""Cases of a batch on the ranks of a job: an executor of mpi4py for each node, teams of ranks."""

from __future__ import annotations

import contextlib
import gc
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from typing import Any

from solidwhirl.batch.case import ERROR_FILE, CaseSettings, follow_case, lead_case
from solidwhirl.batch.run import Dispatch, Keep, Place, Work, predicted_costs
from solidwhirl.batch.schedule import Layout, Predicted, team_layout
from solidwhirl.core.machine import available_memory_gib
from solidwhirl.cost.machine import this_machine
from solidwhirl.sweep.records import BatchCase, BatchRow

# A rank that failed waits so long for the others of its team to come out of the case [s].
PATIENCE_S = 30.0
# A rank that was asked to end gives rank 0, which was asked too, so long to end all in order [s].
_ENDING_S = 10.0
# Ranks that wait look so often [s]; an MPI call would keep a core busy.
_LOOK_S = 0.005
# Communicator of this rank's team, for cases that come from the executor.
_team: Any = None


class CaseEndedError(Exception):
    """The first rank of the team gave the case up; the others leave it where they are."""


class _End:
    """What a team's first rank sends when it is out of a case."""


def layout_of(world: Any, ranks_per_scene: int) -> Layout:
    """Return the teams of the ranks of a communicator, as `team_layout`."""
    from mpi4py import MPI

    answers = MPI.Query_thread() >= MPI.THREAD_MULTIPLE
    return team_layout(world.size, ranks_per_scene, answers_while_busy=answers)


def costs_on_ranks(work: Work, world: Any) -> dict[int, Predicted]:
    """Predict the cost of all cases to compute, each rank a part of them; all get all."""
    # of rank 0 for all: an order must not come from how busy the others are at the moment
    machine = world.bcast(this_machine() if world.rank == 0 else None)
    own = predicted_costs(work, work.todo[world.rank :: world.size], machine)
    return {n: cost for part in world.allgather(own) for n, cost in part.items()}


def run_on_ranks(
    work: Work, costs: Mapping[int, Predicted], layout: Layout, world: Any, keep: Keep
) -> None:
    """Compute all cases to do; every rank calls this.

    The first ranks of the teams on one node are the workers of one executor, so that it is known
    where a case runs. The others of a team join each case that their first one gets.

    `work`, `costs`, `layout`: the batch, from `costs_on_ranks` and `layout_of`. `world`:
    communicator of all ranks. `keep`: writes a row down, with the time to go [s]; called on rank 0
    only.
    Raises Exception: what `keep` raised; the cases running then are finished first.
    """
    from mpi4py import MPI

    global _team
    if world.size > 1:
        import solidwhirl.reduction  # noqa: F401  # the solvers start on all ranks together
    free, shares = _nodes(layout, world)
    own = layout.team_of(world.rank)
    split = world.Split(MPI.UNDEFINED if own is None else own, world.rank)
    _team = None if own is None else _team_communicator(split)
    if world.rank == 0:
        with _places(layout, world, shares) as places:
            Dispatch(work, costs, places, free, keep).run()
        _release_team()
        _wait_for_all(world)
        return
    try:
        if own is not None:
            _serve(layout, world, shares, own)
        _wait_for_all(world)
    except KeyboardInterrupt:
        time.sleep(_ENDING_S)
        raise


def _nodes(
    layout: Layout, world: Any
) -> tuple[dict[str, float], tuple[tuple[tuple[str, float], ...], ...]]:
    """Free memory of the nodes; by team, which part of its ranks is on which."""
    from mpi4py import MPI

    told = world.allgather((MPI.Get_processor_name(), available_memory_gib()))
    free: dict[str, float] = {}
    shares: list[dict[str, float]] = [{} for _ in range(layout.teams)]
    for rank, (node, gib) in enumerate(told):
        free[node] = min(gib, free.get(node, gib))
        team = layout.team_of(rank)
        if team is not None:
            shares[team][node] = shares[team].get(node, 0.0) + 1.0 / layout.ranks_per_team
    return free, tuple(tuple(sorted(own.items())) for own in shares)


def _pool(layout: Layout, world: Any, shares: Any, own: Any) -> Any | None:
    """The executor of rank 0 and the first ranks of the teams on the same nodes, if any."""
    from mpi4py.futures import MPICommExecutor

    leaders = [layout.leader_of(team) for team, at in enumerate(shares) if at == own]
    others = [rank for rank in leaders if rank != 0]
    if not others:
        return None
    return MPICommExecutor(world.Create_group(world.Get_group().Incl([0, *others])), root=0)


@contextlib.contextmanager
def _places(layout: Layout, world: Any, shares: Any) -> Iterator[tuple[Place, ...]]:
    """On rank 0: the executors, and itself where it computes.

    Where the block fails no executor is waited for: the command ends all ranks.
    """
    found, pools = [], []
    for own in dict.fromkeys(shares):
        pool = _pool(layout, world, shares, own)
        if pool is not None:
            pools.append(pool)
            workers = sum(at == own for at in shares) - (layout.first == 0 and own == shares[0])
            found.append(
                Place(executor=pool.__enter__(), workers=workers, shares=dict(own), task=_on_team)
            )
    if layout.first == 0:
        found.append(Place(executor=None, workers=1, shares=dict(shares[0]), task=_on_team))
    yield tuple(found)
    for pool in pools:
        pool.__exit__(None, None, None)


def _serve(layout: Layout, world: Any, shares: Any, own: int) -> None:
    """On other ranks: compute what the executor gives, or what the first rank of the team gets."""
    if _team.rank == 0:
        pool = _pool(layout, world, shares, shares[own])
        assert pool is not None
        with pool:
            pass
        _release_team()
        return
    while True:
        _wait_for_all(_team)
        given = _team.bcast()
        if given is None:
            return
        case, settings = given
        _leave_case(case, settings, follow_case(case, settings, _team))


def _release_team() -> None:
    """On the first rank of a team: no case is left."""
    if _team is not None and _team.size > 1:
        _wait_for_all(_team)
        _team.bcast(None)


def _on_team(case: BatchCase, settings: CaseSettings) -> BatchRow:
    """On the first rank of a team: run a case together with the others."""
    if _team.size > 1:
        _wait_for_all(_team)
        _team.bcast((case, settings))
    row, problem = lead_case(case, settings, _team)
    if _team.size > 1:
        _leave_case(case, settings, problem)
    if problem is not None:
        problem = None
        gc.collect()  # what the exception held, before the next case wants the memory
    return row


def _team_communicator(comm: Any) -> Any:
    """Return a communicator on which a team comes out of a case together.

    A case that fails on the first rank alone, where the others wait for its next message, is given
    up on all: they get the message that it is over instead, and raise `CaseEndedError`.
    """
    from mpi4py import MPI

    class TeamComm(MPI.Intracomm):
        def bcast(self, obj: Any = None, root: int = 0) -> Any:
            found = super().bcast(obj, root)
            if isinstance(found, _End):
                raise CaseEndedError
            return found

    return TeamComm(comm) if comm.size > 1 else comm


def _leave_case(case: BatchCase, settings: CaseSettings, failed: Exception | None) -> None:
    """Bring all ranks of a team out of a case; each calls this when it is out itself.

    Where this rank failed and others do not come out, all ranks of the job end: they wait inside a
    library for what this rank would have sent, and MPI has no way to call them back.
    """
    if isinstance(failed, CaseEndedError):
        _team.Barrier()
        return
    timer = threading.Timer(PATIENCE_S, _abort, [case, settings, failed])
    timer.daemon = True
    if failed is not None:
        timer.start()
    try:
        with contextlib.suppress(CaseEndedError):
            if _team.rank == 0:
                _team.bcast(_End())
            while _team.rank != 0:  # what else the first rank sends until it is out of the case
                _team.bcast()
        _team.Barrier()
    finally:
        timer.cancel()


def _abort(case: BatchCase, settings: CaseSettings, failed: Exception) -> None:
    """End all ranks; by the file in its folder the case comes last when the batch goes on."""
    from mpi4py import MPI

    text = str(failed).splitlines()[0] if str(failed) else type(failed).__name__
    said = f"rank {_team.rank} of the team failed and the others wait for it: {text}"
    with contextlib.suppress(OSError):
        (settings.out / case.name / ERROR_FILE).write_text(said + "\n", encoding="utf-8")
    sys.stderr.write(
        f"error: {case.name}: {said}; all ranks end, and the same command with --resume goes on\n"
    )
    sys.stderr.flush()
    MPI.COMM_WORLD.Abort(1)


def _wait_for_all(comm: Any) -> None:
    """Wait until all ranks are here, without keeping cores busy."""
    request = comm.Ibarrier()
    while not request.Test():
        time.sleep(_LOOK_S)
