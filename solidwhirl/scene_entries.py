"""Which entry of a body a message is about that names it: a section, an interface, a disk."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from solidwhirl.toml_places import Part

# What a message says before a name in quotes: the list it is in, and keys that may hold the name.
_LISTS = {
    "section": ("sections", ("name",)),
    "interface": ("interfaces", ("name",)),
    "rigid disk": ("rigid_disks", ("name",)),
    "stages": ("stage_groups", ("name",)),
    "stage group": ("stage_groups", ("name", "table")),
    "gap between": ("sections", ("name",)),
}
_NAMED = re.compile(
    r"\b(section|interface|rigid disk|stages|stage group|gap between)s? (?:are called )?"
    r"'([^']*)'(?: and '([^']*)')?"
)
_MATERIAL = "unknown material"


def entry_path(body: Any, message: str) -> tuple[Part, ...]:
    """Path within a body of the entry that a message names first; of two the later one.

    Parameters
    ----------
    body
        Content of its table.
    message
        What is wrong.

    Returns
    -------
    tuple of str or int
        Such as `("sections", 1)`, with `"material"` where that is unknown; empty if the message
        names nothing that the body has.
    """
    if not isinstance(body, Mapping):
        return ()
    named = _NAMED.search(message)
    path: tuple[Part, ...] = () if named is None else _listed(body, named)
    if _MATERIAL in message:
        entry = _entries(body, str(path[0]))[int(path[1])] if path else body
        if "material" in entry:
            return (*path, "material")
        return ("material",) if "material" in body else path
    return path


def _listed(body: Mapping[str, Any], named: re.Match[str]) -> tuple[str, int] | tuple[()]:
    """The place of a name in its list, the last of several."""
    key, holders = _LISTS[named[1]]
    found = [
        k
        for k, entry in enumerate(_entries(body, key))
        if any(entry.get(holder) in (named[2], named[3] or named[2]) for holder in holders)
    ]
    if found:
        return key, found[-1]
    if key != "sections":
        return ()
    groups = [  # whose sections begin with their name
        k
        for k, entry in enumerate(_entries(body, "stage_groups"))
        if (named[3] or named[2]).startswith(f"{entry.get('name')}_")
    ]
    return ("stage_groups", groups[-1]) if groups else ()


def _entries(body: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    """Tables of a list; an element that is none is empty."""
    listed = body.get(key)
    if not isinstance(listed, list):
        return []
    return [entry if isinstance(entry, Mapping) else {} for entry in listed]
