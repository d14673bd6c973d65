"""Units, names and labels of numbers, read from their keys."""

from __future__ import annotations

import re

_WORDS = "kg|m2|m3|m|s2|s|n|pa|hz|rpm|rad|deg|j|gib|percent|a"
_UNIT = re.compile(
    rf"^(?P<name>.+?)_(?P<unit>(?!a(?:\[|$))(?:{_WORDS})(?:_(?:{_WORDS}))*(?:_per_(?:{_WORDS})(?:_(?:{_WORDS}))*)?"
    rf"|per_(?:{_WORDS}))(?P<index>\[[^\]]*\])?$"
)
_SYMBOLS = {
    "m2": "m²",
    "m3": "m³",
    "s2": "s²",
    "n": "N",
    "a": "A",
    "pa": "Pa",
    "hz": "Hz",
    "j": "J",
    "gib": "GiB",
    "deg": "°",
    "percent": "%",
}


def unit_of(key: str) -> str:
    """Return the unit that a key ends with as it is printed, empty if it ends with none.

    `key`: such as `bearings[left].stiffness_n_per_m`, which gives N/m.
    """
    found = _UNIT.match(key)
    if found is None:
        return ""
    # the usual name of an angular frequency leaves out "per"
    unit = {"rad_s": "rad_per_s"}.get(found["unit"], found["unit"])
    if unit.startswith("per_"):
        unit = f"1_{unit}"
    over, _, under = unit.partition("_per_")
    printed = [
        "·".join(_SYMBOLS.get(word, word) for word in part.split("_"))
        for part in (over, under)
        if part
    ]
    if len(printed) == 2 and "·" in printed[1]:
        printed[1] = f"({printed[1]})"
    return "/".join(printed)


def name_of(key: str) -> str:
    """Return a key without its unit: `outer_radius_m[0]` gives `outer_radius[0]`."""
    found = _UNIT.match(key)
    return key if found is None else found["name"] + (found["index"] or "")


def label_of(key: str) -> str:
    """Return the name and the unit in brackets, as on an axis."""
    unit = unit_of(key)
    return f"{name_of(key)} [{unit}]" if unit else key


def wrapped(text: str, width: int) -> str:
    """Return a label in lines no longer than a width where dots, spaces and the like allow it."""
    lines = [""]
    for piece in re.split(r"(?<=[.\] _])(?![.\[])|(?<=/)(?=[a-z]{3})", text):
        if lines[-1] and len(lines[-1]) + len(piece.rstrip()) > width:
            lines.append("")
        lines[-1] += piece
    return "\n".join(line.strip() for line in lines)
