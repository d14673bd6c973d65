"""The ranks of a team: one case after another on all of them, and out of it together."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

# A rank that failed waits so long for the others of its team to come out of the case [s].
PATIENCE_S = 30.0
# Ranks that wait for work look for it so often [s]; an MPI call would keep a core busy.
LOOK_S = 0.005


class CaseEndedError(Exception):
    """The first rank of the team gave the case up; the others leave it where they are."""


class _End:
    """What a team's first rank sends when it is out of a case."""


def team_communicator(comm: Any) -> Any:
    """Return a communicator on which a team comes out of a case together.

    A case that fails on the first rank alone, where the others wait for its next message, is given
    up on all: they get the message that it is over instead, and raise `CaseEndedError`.

    Parameters
    ----------
    comm
        mpi4py communicator of the team.
    """
    from mpi4py import MPI

    class TeamComm(MPI.Intracomm):
        def bcast(self, obj: Any = None, root: int = 0) -> Any:
            found = super().bcast(obj, root)
            if isinstance(found, _End):
                raise CaseEndedError
            return found

    return TeamComm(comm)


def leave_case(team: Any, failed: BaseException | None, lost: Callable[[str], None]) -> None:
    """Bring all ranks of a team out of a case; each calls this when it is out itself.

    Parameters
    ----------
    team
        From `team_communicator`.
    failed
        What the case raised on this rank, None if nothing.
    lost
        Called, in a thread, if this rank failed and others do not come out: they wait inside a
        library for what this rank would have sent, and MPI has no way to call them back.
    """
    if isinstance(failed, CaseEndedError):
        team.Barrier()
        return
    with _patience(failed, lost):
        if team.rank == 0:
            with contextlib.suppress(CaseEndedError):
                team.bcast(_End())
        else:
            _wait_for_end(team)
        team.Barrier()


def _wait_for_end(team: Any) -> None:
    """Pass over what else the first rank sends until it is out of the case."""
    while True:
        try:
            team.bcast()
        except CaseEndedError:
            return


@contextlib.contextmanager
def _patience(failed: BaseException | None, lost: Callable[[str], None]) -> Iterator[None]:
    if failed is None:
        yield
        return
    text = str(failed).splitlines()[0] if str(failed) else type(failed).__name__
    timer = threading.Timer(PATIENCE_S, lost, [text])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def told_by_first(team: Any, number: int) -> int:
    """Return a number of the team's first rank on all of them, without keeping cores busy.

    Parameters
    ----------
    team
        Communicator of the team.
    number
        On the first rank; passed over on others.
    """
    import numpy as np

    cell = np.array([number], dtype=np.int64)
    request = team.Ibcast(cell, root=0)
    while not request.Test():
        time.sleep(LOOK_S)
    return int(cell[0])


def wait_for_all(comm: Any) -> None:
    """Wait until all ranks are here, without keeping cores busy.

    Parameters
    ----------
    comm
        mpi4py communicator.
    """
    request = comm.Ibarrier()
    while not request.Test():
        time.sleep(LOOK_S)
