"""Rank 0 gives out the cases of a batch and gathers the rows."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence

from solidwhirl.batch_memory import MemoryRoom
from solidwhirl.batch_schedule import TimeToGo
from solidwhirl.sweep_records import BatchRow

#: Instead of a case: there is none left.
NONE_LEFT = -1
#: Instead of a case: none fits into memory beside those that run; ask again.
LATER = -2
# So many cases per team there must be for each team to have a small one in hand.
_ENOUGH = 3


class Coordinator:
    """Cases that are left, teams that compute, and rows; on rank 0, for several threads.

    Parameters
    ----------
    order
        Indices of the cases as they are begun.
    to_go
        Time that they need.
    teams
        Number of teams.
    keep
        Writes a row down, called by one thread at a time, with the time to go [s].
    room
        Memory of the nodes; None: all cases fit at once.
    """

    def __init__(
        self,
        order: Sequence[int],
        to_go: TimeToGo,
        teams: int,
        keep: Callable[[BatchRow, float], None],
        room: MemoryRoom | None = None,
    ) -> None:
        self._left = deque(order)
        self._to_go, self._teams, self._keep = to_go, teams, keep
        self._room = room or MemoryRoom({}, [{}] * teams, {})
        self._running: dict[int, float] = {}
        self._guard = threading.RLock()
        self.error: BaseException | None = None

    def take(self, team: int) -> int:
        """Give out the next case that fits into memory beside those that run.

        Parameters
        ----------
        team
            Index of the team that asks.

        Returns
        -------
        Index of the case; `LATER` if cases are left but none fits now, `NONE_LEFT` if none is left.
        """
        with self._guard:
            if self.error is not None or not self._left:
                return NONE_LEFT
            for case in self._left:
                if self._room.may_begin(team, case):
                    break
            else:
                return LATER
            self._left.remove(case)
            self._room.begin(team, case)
            self._running[case] = time.monotonic()
            return case

    def take_small(self, team: int) -> int:
        """Give out the last case, to have in hand; `NONE_LEFT` if cases are few or it is too large.

        Parameters
        ----------
        team
            Index of the team that asks.
        """
        with self._guard:
            if self.error is not None or len(self._left) <= _ENOUGH * self._teams:
                return NONE_LEFT
            if not self._room.may_begin(team, self._left[-1]):
                return NONE_LEFT
            case = self._left.pop()
            self._room.begin(team, case)
            return case

    def put(self, case: int, row: BatchRow) -> None:
        """Write a row down; where that fails, nothing more is given out.

        Parameters
        ----------
        case, row
            Index of the case, and what it came to.
        """
        with self._guard:
            self._running.pop(case, None)
            self._room.end(case)
            self._to_go.finished(case, None if row.status == "failed" else row.seconds)
            now = time.monotonic()
            running = {other: now - start for other, start in self._running.items()}
            if self.error is not None:
                return
            left_s = self._to_go.seconds(running)
            try:
                self._keep(row, left_s)
            except KeyboardInterrupt:
                self._keep(row, left_s)  # a row that was interrupted is not written yet
                raise
            except Exception as error:
                self.fail(error)

    def fail(self, error: BaseException) -> None:
        """Give out nothing more."""
        with self._guard:
            self.error = self.error or error
