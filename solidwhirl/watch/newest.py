"""A thread that works on the newest request alone."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

Request = TypeVar("Request")


class Newest(Generic[Request]):
    """Works on one request after the other; what was asked before the newest is dropped.

    `work`: does one request; it raises nothing.
    """

    def __init__(self, work: Callable[[Request], None], name: str) -> None:
        self._work = work
        self._changed = threading.Condition()
        self._waiting: list[Request] = []  # one at most
        self._ended = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    def ask(self, request: Request) -> None:
        """Ask for something, instead of what has not been begun."""
        with self._changed:
            self._waiting = [request]
            self._changed.notify_all()

    def is_outdated(self, within_s: float = 0.0) -> bool:
        """Whether something newer is asked, or the end; waits for it as long as said."""
        with self._changed:
            return self._changed.wait_for(lambda: self._ended or bool(self._waiting), within_s)

    def end(self, patience_s: float) -> bool:
        """Begin nothing more; whether the work ended in time."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(patience_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ended or bool(self._waiting))
                if self._ended:
                    return
                request = self._waiting.pop()
            self._work(request)
