"""What an export wrote, and what its format could not carry."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Exported:
    """Say what was written.

    `files`: files, the one to open first before all others.
    `carried`: what of the body the files hold, a phrase each.
    `left_out`: what of the body they can't hold, or not as it is, a sentence each.
    """

    files: tuple[Path, ...]
    carried: tuple[str, ...]
    left_out: tuple[str, ...] = ()
