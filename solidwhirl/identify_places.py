"""Places in the data of a scene file: `bodies.lp.sections[shaft].outer_radius_m[0]`."""

from __future__ import annotations

import copy
import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_STEP = re.compile(r"\.?([A-Za-z][A-Za-z0-9_-]*)|\[([A-Za-z0-9_-]+)\]")


class PlaceError(ValueError):
    """A text that is no place of a number in a scene; the message says why."""


@dataclass(frozen=True, kw_only=True)
class Place:
    """A number in the data of a scene file.

    Attributes
    ----------
    text
        As written: keys joined by dots; `[name]` picks the entry of a list whose `name` that is,
        `[0]` an entry by its number.
    steps
        Keys and numbers from the top of the scene, every `[name]` turned into a number.
    """

    text: str
    steps: tuple[str | int, ...]


def find_place(data: Mapping[str, Any], text: str) -> Place:
    """Find a number in the data of a scene file.

    Parameters
    ----------
    data
        Content of a scene file.
    text
        The place, see `Place`.

    Raises
    ------
    PlaceError
        The text is no place, leads nowhere, or to something that is no number.
    """
    value: Any = data
    steps: list[str | int] = []
    done = ""
    for step in place_steps(text):
        key = resolve_step(value, step, done or "the scene", text)
        steps.append(key)
        value = value[key]
        done += step if step.startswith("[") or not done else f".{step}"
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PlaceError(f"{text!r} is {_kind(value)} in the scene; a number is needed")
    return Place(text=text, steps=tuple(steps))


def value_at(data: Mapping[str, Any], place: Place) -> float:
    """Return the number at a place."""
    value: Any = data
    for step in place.steps:
        value = value[step]
    return float(value)


def with_values(data: Mapping[str, Any], values: Mapping[Place, float]) -> dict[str, Any]:
    """Return a copy of the data with other numbers at some places.

    Parameters
    ----------
    data
        Content of a scene file.
    values
        The numbers by place.
    """
    changed = copy.deepcopy(dict(data))
    for place, value in values.items():
        container: Any = changed
        for step in place.steps[:-1]:
            container = container[step]
        container[place.steps[-1]] = value
    return changed


def place_steps(text: str) -> list[str]:
    """Return the keys and `[entry]` of a place, as written.

    Parameters
    ----------
    text
        The place, see `Place`.

    Raises
    ------
    PlaceError
        The text is no place.
    """
    parts = []
    at = 0
    while at < len(text):
        found = _STEP.match(text, at)
        if found is None or (at == 0 and found[0].startswith((".", "["))):
            raise PlaceError(
                f"{text!r} is no place; allowed are keys joined by dots, with [name] or [number] "
                "behind a list, such as bodies.rotor.sections[shaft].outer_radius_m"
            )
        parts.append(found[1] or f"[{found[2]}]")
        at = found.end()
    if not parts:
        raise PlaceError("an empty text is no place")
    return parts


def resolve_step(value: Any, step: str, where: str, text: str) -> str | int:
    """Return the key or number that a step means in a table or list.

    Parameters
    ----------
    value
        The table or list.
    step
        One of `place_steps`.
    where, text
        What messages call the table or list, and the whole place.

    Raises
    ------
    PlaceError
        The step leads nowhere; the message says what is allowed.
    """
    if not step.startswith("["):
        if not isinstance(value, dict):
            raise PlaceError(f"{text!r}: {where} is {_kind(value)}, which has no key {step!r}")
        if step not in value:
            raise PlaceError(f"{text!r}: {where} has no {step!r}; {choice(step, list(value))}")
        return step
    entry = step[1:-1]
    if not isinstance(value, list):
        raise PlaceError(f"{text!r}: {where} is {_kind(value)}, {step} needs a list")
    names = [e.get("name") if isinstance(e, dict) else None for e in value]
    if entry in names:
        return names.index(entry)
    if entry.isdigit() and int(entry) < len(value):
        return int(entry)
    known = [n for n in names if isinstance(n, str)]
    raise PlaceError(
        f"{text!r}: {where} has no entry {step}; "
        + (choice(entry, known) if known else f"allowed are 0 to {len(value) - 1}")
    )


def choice(word: str, known: list[str]) -> str:
    """Return what is allowed, with the nearest proposed, for a message."""
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.6)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{hint}allowed are {', '.join(known) or 'none'}"


def _kind(value: Any) -> str:
    names = {dict: "a table", list: "a list", str: "a text", bool: "true or false"}
    return names.get(type(value), f"{value!r}")
