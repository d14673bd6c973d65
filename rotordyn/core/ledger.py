"""Dense problems of a system that are solved, counted for who asks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal

# What is counted: whole eigenproblems, and factorisations for a few modes alone.
Problem = Literal["eigenproblems", "factorisations"]

_FOUND: ContextVar[Counter[str] | None] = ContextVar("dense problems", default=None)


@contextmanager
def counted() -> Iterator[Counter[str]]:
    """Count the dense problems that are solved within."""
    found: Counter[str] = Counter()
    before = _FOUND.set(found)
    try:
        yield found
    finally:
        _FOUND.reset(before)


def solved(problem: Problem) -> None:
    """Count one problem, where somebody counts."""
    found = _FOUND.get()
    if found is not None:
        found[problem] += 1
