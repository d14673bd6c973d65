"""Rank 0 of a batch answers the teams of other ranks."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from solidwhirl.batch_coordinator import LATER, Coordinator
from solidwhirl.batch_messages import (
    ASK,
    ASK_SMALL,
    DONE,
    ENDED,
    ENDING_S,
    FROM_TEAM,
    LOST,
    ROW,
    TO_TEAM,
    row_of,
)
from solidwhirl.batch_schedule import Layout
from solidwhirl.batch_team import LOOK_S


class Service:
    """Answers the other ranks: in a thread where rank 0 computes, else in the main one.

    Parameters
    ----------
    coordinator
        Cases and rows.
    link
        Communicator of all ranks, for these messages alone.
    layout
        The teams.
    end
        Ends all ranks.
    interrupt
        Called when another rank was asked to end.
    """

    def __init__(
        self,
        coordinator: Coordinator,
        link: Any,
        layout: Layout,
        *,
        end: Callable[[], None],
        interrupt: Callable[[], None],
    ) -> None:
        self._coordinator, self._link, self._end = coordinator, link, end
        self._interrupt = interrupt
        self._teams = {layout.leader_of(team): team for team in range(layout.teams)}
        self._open = {rank for rank in self._teams if rank != 0}
        self._waiting: deque[int] = deque()
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()

    def start(self) -> None:
        """Answer in a thread from now on, if there is anyone."""
        if self._link.size == 1:
            return
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def finish(self) -> None:
        """Answer until all teams have stopped."""
        if self._thread is None:
            self._serve()
        while self._open:
            time.sleep(LOOK_S)
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def stop(self, patience_s: float) -> None:
        """Take the rows that are on their way, for a while, and answer nobody after that.

        Parameters
        ----------
        patience_s
            How long [s].
        """
        self._stop.set()
        if self._thread is not None:
            self._thread.join(ENDING_S)
        until = time.monotonic() + patience_s
        while self._open and time.monotonic() < until:
            if not self._look(answer=False):
                time.sleep(LOOK_S)

    def _serve(self) -> None:
        threaded = self._thread is not None
        while (threaded or self._open) and not self._stop.is_set():
            try:
                found = self._look(answer=True)
                self._answer_waiting()
                if not found:
                    time.sleep(LOOK_S)
            except Exception as error:
                self._coordinator.fail(error)  # rows are lost, but all teams have to stop

    def _look(self, *, answer: bool) -> bool:
        """Take one message; False if there is none."""
        from mpi4py import MPI

        status = MPI.Status()
        if not self._link.iprobe(source=MPI.ANY_SOURCE, tag=FROM_TEAM, status=status):
            return False
        rank = status.Get_source()
        kind, number, count = self._link.recv(source=rank, tag=FROM_TEAM)
        pieces = [self._link.recv(source=rank, tag=FROM_TEAM) for _ in range(count)]
        if kind == ASK_SMALL and answer:
            small = self._coordinator.take_small(self._teams[rank])
            self._link.send(small, dest=rank, tag=TO_TEAM)
        elif kind == ASK:
            self._waiting.append(rank)
        elif kind in (ROW, LOST):
            self._coordinator.put(number, row_of(pieces))
        if kind == DONE:
            self._open.discard(rank)
        if kind == LOST:
            self._end()
        if kind == ENDED:
            self._open.discard(rank)
            if answer:  # else this rank was asked to end as well
                self._interrupt()
        return True

    def _answer_waiting(self) -> None:
        """Give cases to the teams that asked, in their order; who gets none stays."""
        for _ in range(len(self._waiting)):
            rank = self._waiting.popleft()
            case = self._coordinator.take(self._teams[rank])
            if case == LATER:
                self._waiting.append(rank)
            else:
                self._link.send(case, dest=rank, tag=TO_TEAM)
