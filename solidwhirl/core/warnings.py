"""What a doubt about a scene says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Doubt:
    """Something in a scene that its author may not mean, such as a number in another unit."""

    key: str
    #: The number with its unit, or what else was found
    found: str
    usual: str
    mistake: str

    @property
    def message(self) -> str:
        """One sentence with all of it."""
        return f"{self.key}: {self.found}; usual is {self.usual}. {self.mistake}"
