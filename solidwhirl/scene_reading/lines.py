"""Messages about a file that a user wrote, with the line and column they are about."""

from __future__ import annotations

import re
import stat
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from solidwhirl.core.errors import KeyPath, Problem, SceneError
from solidwhirl.scene_reading.paths import leading_steps
from solidwhirl.scene_reading.toml_places import Places, Position

_LARGEST_BYTES = 4_000_000
# What follows the key in a message.
_AFTER = (":", " (")
# What geometry, which knows no keys, says before the name of an entry, and the list it is in.
_LISTS = {
    "section": "sections",
    "gap between": "sections",
    "interface": "interfaces",
    "rigid disk": "rigid_disks",
    "blade": "blades",
    "hole": "holes",
    "slot": "slots",
    "keyway": "keyways",
    "flat": "flats",
    "cut": "cuts",
    "stages": "stage_groups",
    "stage group": "stage_groups",
}
_NAMED = re.compile(rf"\b({'|'.join(_LISTS)})s? (?:are called )?'([^']*)'(?: and '([^']*)')?")
_BODIES = ("bodies", "mesh_bodies", "beams")


def with_lines(error: SceneError) -> SceneError:
    """The same problems, each behind the line and column that it is about.

    Lines of the message are `file:line:column: key: problem`; what belongs to no line, and all of a
    file that can't be read again, stays as it is.
    """
    text = _text(Path(error.path))
    if text is None:
        return error
    places = Places(text)
    found = [_located(places, problem) for problem in error.problems]
    shown = [
        known or (f"{place.line}:{place.column}" if place else "")
        for known, place in zip(error.places, found, strict=True)
    ]
    return SceneError(error.path, error.problems, shown)


def line_of(path: Path, message: str) -> str:
    """A message that begins with a key of a file, behind the file and the key's line and column."""
    return str(with_lines(SceneError(path, [message])))


def _located(places: Places, problem: str) -> Position | None:
    """Where the key of a problem stands, or the nearest table around it."""
    if isinstance(problem, Problem):
        return _nearest(places, problem.path)
    steps, end = leading_steps(problem)
    if not problem.startswith(_AFTER, end):
        return None
    path = tuple(int(s[1:-1]) if s[0] == "[" and s[1:-1].isdigit() else s for s in steps)
    if len(path) == 2 and path[0] in _BODIES:
        path += _entry(places.text, path, problem[end:])
    return _nearest(places, path)


def _nearest(places: Places, path: KeyPath) -> Position | None:
    """Where a path, or the longest part of it that the file has, stands."""
    for length in range(len(path), 0, -1):
        found = places.position(path[:length])
        if found is not None:
            return found
    return None


def _entry(text: str, path: KeyPath, message: str) -> KeyPath:
    """Path within a body of the entry that a message of its geometry names, of two the later one.

    Such as `("sections", 1)`, with `"material"` where that is unknown; empty if it names none.
    """
    try:
        body = tomllib.loads(text)[str(path[0])][path[1]]
    except (ValueError, KeyError, TypeError, RecursionError):  # changed since it was read
        return ()
    if not isinstance(body, Mapping):
        return ()
    named = _NAMED.search(message)
    found = (
        () if named is None else _listed(body, _LISTS[named[1]], {named[2], named[3] or named[2]})
    )
    if "unknown material" in message:
        entry = _entries(body, found[0])[found[1]] if found else body
        if "material" in entry:
            return (*found, "material")
        return ("material",) if "material" in body else found
    return found


def _listed(body: Mapping[str, Any], key: str, names: set[str]) -> tuple[str, int] | tuple[()]:
    """The last entry of a list that has one of some names; sections may come from stages."""
    found = [
        k
        for k, entry in enumerate(_entries(body, key))
        if entry.get("name") in names or (key == "stage_groups" and entry.get("table") in names)
    ]
    if found:
        return key, found[-1]
    groups = [
        k
        for k, entry in enumerate(_entries(body, "stage_groups"))
        if key == "sections" and any(name.startswith(f"{entry.get('name')}_") for name in names)
    ]
    return ("stage_groups", groups[-1]) if groups else ()


def _entries(body: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    """Tables of a list; an element that is none is empty."""
    listed = body.get(key)
    if not isinstance(listed, list):
        return []
    return [entry if isinstance(entry, Mapping) else {} for entry in listed]


def _text(path: Path) -> str | None:
    """Content of a file of usual size; None of a device, a pipe, and what can't be read."""
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode) or found.st_size > _LARGEST_BYTES:
            return None
        return path.read_bytes().decode("utf-8", "replace")
    except (OSError, ValueError):
        return None
