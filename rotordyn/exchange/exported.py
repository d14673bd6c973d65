"""What an export wrote, and what its format could not carry; bodies that it can not have."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.record import Superelement


def refuse_rotating(element: Superelement) -> None:
    """Refuse a body whose matrices are not those of the inertial frame, which a format means.

    Raises SuperelementError.
    """
    if element.frame == "rotating":
        raise SuperelementError(
            f"superelement {element.name!r} is asymmetric: its matrices are those of "
            "the frame that turns with it, and the format means the inertial frame, where they "
            "change with the angle; allowed are formats with a moving frame, and the superelement "
            "file itself"
        )


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
