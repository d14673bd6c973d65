"""Doubts about supports: bodies whose lateral motion nothing holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from solidwhirl.core.warnings import Doubt

if TYPE_CHECKING:
    from solidwhirl.rotordyn import AssembledSystem

# A body on one bearing tilts about it, in two planes.
_TILTS = 2


def support_doubts(system: AssembledSystem) -> tuple[Doubt, ...]:
    """Return a doubt for every group of bodies that is free to move laterally.

    None if every lateral motion is held; free axial motion and torsion are usual.
    """
    from solidwhirl.rotordyn.modes.free_motions import free_lateral_motions

    found = free_lateral_motions(system)
    return tuple(free_motion_doubt(m.bodies, m.held_by, m.count) for m in found)


def free_motion_doubt(bodies: Sequence[str], held_by: Sequence[str], count: int) -> Doubt:
    """Return the doubt about bodies that move together: which, held by what, in how many ways."""
    motions = "lateral motion at 0 Hz is" if count == 1 else "lateral motions at 0 Hz are"
    return Doubt(
        key="bearings",
        found=f"{_held(bodies, held_by, count)}: {count} {motions} left out of the lists of modes",
        usual="two bearings per shaft, stiff in both directions",
        mistake="Free on purpose? Then this is as it should be; else a bearing or a stiffness is "
        "missing.",
    )


def _held(bodies: Sequence[str], held_by: Sequence[str], count: int) -> str:
    named, single = _listed(bodies), len(bodies) == 1
    are = "is" if single else "are"
    if not held_by:
        return f"nothing holds {named} laterally"
    holders = _listed(held_by)
    if len(held_by) > 1:
        return f"{named} {are} held by {holders} and can move laterally all the same"
    moves = "tilt freely" if single and count == _TILTS else "move laterally all the same"
    return f"{named} {are} held by one bearing only ({holders}) and can {moves}"


def _listed(names: Sequence[str]) -> str:
    *first, last = (repr(name) for name in names)
    return f"{', '.join(first)} and {last}" if first else last
