"""Problems that are set up and solved, counted for who asks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal

# What is counted: matrices assembled, whole eigenproblems, and factorisations; of an engine those
# for a few modes alone, lowest modes continued from another speed, and points of speed and
# frequency whose response has a factorisation of its own.
Problem = Literal["matrices", "eigenproblems", "continued", "factorisations", "responses"]


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

    def add(self, problem: Problem, count: int = 1) -> None:
        """Count problems."""
        found = self._found.get()
        if found is not None:
            found[problem] += count


#: Dense problems of assembled systems
SYSTEMS = Ledger("dense problems of systems")
solved = SYSTEMS.add
