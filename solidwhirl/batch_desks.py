"""Where the first rank of a team gets its cases and leaves its rows."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

from solidwhirl.batch_coordinator import LATER, NONE_LEFT, Coordinator
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
    pieces_of,
)
from solidwhirl.batch_team import LOOK_S
from solidwhirl.sweep_records import BatchRow

# A team that gets no answer for so long computes the case that it has in hand [s].
_SLOW_S = 0.2


class Desk(Protocol):
    """Where a team gets its cases and leaves its rows."""

    def next_case(self) -> int:
        """Index of the next case, `NONE_LEFT` if there is none."""

    def put(self, case: int, row: BatchRow) -> None:
        """Report a row."""

    def lost(self, case: int, row: BatchRow) -> None:
        """Report a row of a team that can't go on; all ranks end."""


class OwnDesk:
    """The coordinator, for the team of rank 0.

    Parameters
    ----------
    coordinator
        On the same rank.
    team
        Index of the team.
    end
        Ends all ranks.
    """

    def __init__(self, coordinator: Coordinator, team: int, end: Callable[[], None]) -> None:
        self._coordinator, self._team, self._end = coordinator, team, end

    def next_case(self) -> int:
        """Index of the next case, `NONE_LEFT` if there is none."""
        while (case := self._coordinator.take(self._team)) == LATER:
            time.sleep(LOOK_S)
        return case

    def put(self, case: int, row: BatchRow) -> None:
        """Report a row."""
        self._coordinator.put(case, row)

    def lost(self, case: int, row: BatchRow) -> None:
        """Report a row of a team that can't go on; all ranks end."""
        self._coordinator.put(case, row)
        self._end()


class RemoteDesk:
    """The coordinator as other ranks see it.

    Where rank 0 computes, it may be inside a library for long and not answer. So a team has a small
    case in hand, one of those that come last anyway, and computes it instead of waiting.

    Parameters
    ----------
    link
        Communicator of all ranks, for these messages alone.
    has_reserve
        Whether to have a case in hand.
    end
        Ends all ranks, if rank 0 does not.
    """

    def __init__(self, link: Any, *, has_reserve: bool, end: Callable[[], None]) -> None:
        self._link, self._end = link, end
        self._sent: list[Any] = []
        self._asked = False
        self._wants, self._reserve = has_reserve, NONE_LEFT

    def next_case(self) -> int:
        """Index of the next case, `NONE_LEFT` if there is none."""
        if self._wants:
            self._wants = False
            self._tell(ASK_SMALL)
            self._tell(ASK)
            self._asked = True
            self._reserve = self._answer()
        if not self._asked:
            self._tell(ASK)
        self._asked = self._reserve != NONE_LEFT and not self._is_answered()
        case = NONE_LEFT if self._asked else self._answer()
        if case == NONE_LEFT:
            case, self._reserve = self._reserve, NONE_LEFT
        return case

    def finished(self) -> None:
        """Tell that this team computes nothing more."""
        self._tell(DONE)
        while not self._is_sent():
            time.sleep(LOOK_S)

    def put(self, case: int, row: BatchRow) -> None:
        """Report a row."""
        self._tell(ROW, case, row)

    def lost(self, case: int, row: BatchRow) -> None:
        """Report a row of a team that can't go on; all ranks end."""
        self._tell(LOST, case, row)
        time.sleep(ENDING_S)
        self._end()

    def ended(self) -> None:
        """Tell that this rank was asked to end, and wait for rank 0 to end all."""
        self._tell(ENDED)
        time.sleep(ENDING_S)

    def _tell(self, kind: str, case: int = 0, row: BatchRow | None = None) -> None:
        """Send a message and go on, even if rank 0 is inside a library for minutes.

        To wait until a message is sent is to wait for rank 0: Open MPI says so of more than some
        256 bytes when they are received, though it has copied them long before.
        """
        pieces = pieces_of(row)
        for message in ((kind, case, len(pieces)), *pieces):
            self._sent.append(self._link.isend(message, dest=0, tag=FROM_TEAM))
        self._is_sent()

    def _is_sent(self) -> bool:
        """Whether all messages have been sent; their memory is given free."""
        self._sent = [request for request in self._sent if not request.Test()]
        return not self._sent

    def _answer(self) -> int:
        while not self._link.iprobe(source=0, tag=TO_TEAM):
            time.sleep(LOOK_S)
        return int(self._link.recv(source=0, tag=TO_TEAM))

    def _is_answered(self) -> bool:
        """Whether rank 0 answers in time."""
        until = time.monotonic() + _SLOW_S
        while not self._link.iprobe(source=0, tag=TO_TEAM):
            if time.monotonic() > until:
                return False
            time.sleep(LOOK_S)
        return True
