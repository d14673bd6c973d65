"""Problems that are set up and solved, counted for who asks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal

# What is counted: matrices assembled, whole eigenproblems, and factorisations, of an engine for a
# few modes alone.
Problem = Literal["matrices", "eigenproblems", "factorisations"]


class Ledger:
    """Count problems of one kind of model, where somebody counts; of nested counts the inner."""

    def __init__(self, name: str) -> None:
        self._found: ContextVar[Counter[str] | None] = ContextVar(name, default=None)

    @contextmanager
    def counted(self) -> Iterator[Counter[str]]:
        """Count the problems within."""
        found: Counter[str] = Counter()
        before = self._found.set(found)
        try:
            yield found
        finally:
            self._found.reset(before)

    def add(self, problem: Problem) -> None:
        """Count one problem."""
        found = self._found.get()
        if found is not None:
            found[problem] += 1


#: Dense problems of assembled systems
SYSTEMS = Ledger("dense problems of systems")
solved = SYSTEMS.add
