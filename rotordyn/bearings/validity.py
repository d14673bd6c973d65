"""Where a bearing is used beyond what its theory is for."""

from __future__ import annotations

from typing import NamedTuple


class Exceeded(NamedTuple):
    """A figure beyond its limit: what it is of with its unit, both numbers, and why it matters."""

    quantity: str
    value: float
    limit: float
    why: str

    @property
    def text(self) -> str:
        """One line."""
        return f"{self.quantity} is {self.value:.3g}, limit {self.limit:.3g}: {self.why}"
