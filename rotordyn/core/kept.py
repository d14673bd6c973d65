"""Results that are asked for again in one run, kept as long as there is room."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Hashable
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Kept(Generic[Value]):
    """Values by key, those used last, up to a number of bytes.

    `room_bytes`: of all values together; one that is larger is not kept. Values are never changed,
    so that threads may share them.
    """

    def __init__(self, room_bytes: int) -> None:
        self._room = room_bytes
        self._found: OrderedDict[Hashable, tuple[Value, int]] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: Hashable) -> Value | None:
        """Return what is kept under a key, or None."""
        with self._lock:
            if key not in self._found:
                return None
            self._found.move_to_end(key)
            return self._found[key][0]

    def keep(self, key: Hashable, value: Value, size_bytes: int) -> None:
        """Keep a value in the place of the one before it."""
        with self._lock:
            self._room += self._found.pop(key, (None, 0))[1]
            self._found[key] = value, size_bytes
            self._room -= size_bytes
            while self._room < 0:
                self._room += self._found.popitem(last=False)[1][1]
