"""Doubts about supports: bodies whose lateral motion nothing holds."""

from __future__ import annotations

from solidwhirl.core.warnings import Doubt
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.modes.free_motions import FreeMotion, free_lateral_motions

# A body on one bearing tilts about it, in two planes.
_TILTS = 2


def support_doubts(system: AssembledSystem) -> tuple[Doubt, ...]:
    """Return a doubt for every group of bodies that is free to move laterally.

    None if every lateral motion is held; free axial motion and torsion are usual.
    """
    return tuple(_doubt(motion) for motion in free_lateral_motions(system))


def _doubt(motion: FreeMotion) -> Doubt:
    one = motion.count == 1
    return Doubt(
        key="bearings",
        found=f"{_held(motion)}: {motion.count} lateral motion{'' if one else 's'} at 0 Hz "
        f"{'is' if one else 'are'} left out of the lists of modes",
        usual="two bearings per shaft, stiff in both directions",
        mistake="Free on purpose? Then this is as it should be; else a bearing or a stiffness is "
        "missing.",
    )


def _held(motion: FreeMotion) -> str:
    bodies, single = _listed(motion.bodies), len(motion.bodies) == 1
    are = "is" if single else "are"
    if not motion.held_by:
        return f"nothing holds {bodies} laterally"
    holders = _listed(motion.held_by)
    if len(motion.held_by) > 1:
        return f"{bodies} {are} held by {holders} and can move laterally all the same"
    moves = "tilt freely" if single and motion.count == _TILTS else "move laterally all the same"
    return f"{bodies} {are} held by one bearing only ({holders}) and can {moves}"


def _listed(names: tuple[str, ...]) -> str:
    *first, last = (repr(name) for name in names)
    return f"{', '.join(first)} and {last}" if first else last
