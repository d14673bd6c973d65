"""Which pictures a run of a scene may have, by name, before it is run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from solidwhirl.core.errors import OutputError, meant

if TYPE_CHECKING:
    from solidwhirl.scene.records import Scene

_ALWAYS = (
    *("engine", "campbell", "campbell_annotated", "campbell_damped", "campbell_errors"),
    *("critical_speeds", "checks", "cost"),
)
_WILD = re.compile(r"[*?\[]")


def refuse_unknown_names(scene: Scene, only: Sequence[str], modes: int) -> None:
    """Refuse names, or patterns with * and ?, that no picture of a scene's run can have.

    What an analysis draws is known when it has run: of its pictures only the beginning is checked.
    At most so many modes are shown in space. Raises OutputError: a pattern fits none; the message
    lists the names.
    """
    meshed = [*scene.bodies, *scene.mesh_bodies]
    kinds = ("mode_critical", "mode")
    shapes = [f"{kind}_{k + 1}" for kind in kinds for k in range(modes)]
    names = [*_ALWAYS, *(f"mesh_{name}" for name in meshed), *shapes]
    names += [f"{name}_film" for name in shapes]
    begins = [spec.label for spec in scene.analyses]
    for pattern in only:
        fits = any(fnmatchcase(name, pattern) for name in names)
        if not (fits or _may_begin(pattern, begins)):
            known = [*_ALWAYS, *(f"mesh_{name}" for name in meshed)]
            known += [f"{kind}_K and {kind}_K_film, K = 1 to {modes}" for kind in kinds if modes]
            known += [f"{label}..." for label in begins]
            raise OutputError(
                f"--only: no picture {pattern!r}; {meant(pattern, [*names, *begins])}"
                f"there may be {', '.join(known)}"
            )


def _may_begin(pattern: str, begins: Sequence[str]) -> bool:
    """Whether something that begins with one of some words can fit the pattern."""
    found = _WILD.search(pattern)
    if found is None:
        return any(pattern.startswith(word) for word in begins)
    fixed = pattern[: found.start()]
    return any(word.startswith(fixed) or fixed.startswith(word) for word in begins)
