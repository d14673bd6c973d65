"""Places in the data of a scene file, such as `bodies.lp.sections[shaft].outer_radius_m[0]`.

Keys are joined by dots; `[name]` picks the entry of a list whose `name` that is, `[0]` an entry by
its number. Messages, sweeps, identification and references spell their keys so.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from solidwhirl.core.errors import choice as choice
from solidwhirl.scene.sweep import SweepParameterSpec, SweepSpec

Steps = tuple[str | int, ...]
_STEP = re.compile(r"\.?([A-Za-z0-9_-]+)|\[([A-Za-z0-9_-]+)\]")
# Tables of a scene that may be left out as a whole: a sweep may name a key of them all the same.
_OPTIONAL = ("model", "effects", "speeds", "campbell", "criteria")


class PlaceError(ValueError):
    """A text that is no place of a number in a scene; the message says why."""


@dataclass(frozen=True, kw_only=True)
class Place:
    """A place of one number or text in the data of a scene file."""

    text: str
    steps: Steps  #: Keys and numbers from the top of the scene, every `[name]` turned into a number


@dataclass(frozen=True, kw_only=True)
class Target(Place):
    """A place that a sweep fills."""

    #: What stands there in the scene file; None where the key is left out
    nominal: float | str | bool | None


def leading_steps(text: str) -> tuple[tuple[str, ...], int]:
    """Return the steps that a text begins with, entries in their brackets, and where they end."""
    steps, at = [], 0
    while (found := _STEP.match(text, at)) is not None and (at or text[0] not in ".["):
        steps.append(found[1] or f"[{found[2]}]")
        at = found.end()
    return tuple(steps), at


def place_steps(text: str) -> tuple[str, ...]:
    """Return the keys and `[entry]` of a place, as written.

    Raises PlaceError: the text is no place.
    """
    if not text:
        raise PlaceError("an empty text is no place")
    steps, end = leading_steps(text)
    if end < len(text) or not text[0].isalpha():
        raise PlaceError(
            f"{text!r} is no place; allowed are keys joined by dots, with [name] or [number] "
            "behind a list, such as bodies.rotor.sections[shaft].outer_radius_m"
        )
    return steps


def find_target(data: Mapping[str, Any], text: str) -> Target:
    """Find a place that can be filled, which may be a key that the file leaves out.

    Raises PlaceError: the text is no place, leads nowhere, or to a table or list.
    """
    found = _walked(data, text, may_be_left_out=True)
    if isinstance(found.nominal, dict | list):
        raise PlaceError(
            f"{text!r} is {_kind(found.nominal)} in the scene; one number or text is needed"
        )
    if found.nominal is not None and not isinstance(found.nominal, int | float | str):
        raise PlaceError(f"{text!r} is {found.nominal!r} in the scene; a number or text is needed")
    if found.steps[0] == "name":
        raise PlaceError("'name' stays as it is: folders and rows of the cases have it")
    return found


def find_place(data: Mapping[str, Any], text: str) -> Place:
    """Find a number that stands in the data of a scene file.

    Raises PlaceError: the text is no place, leads nowhere, or to something that is no number.
    """
    found = _walked(data, text, may_be_left_out=False)
    if not is_number(found.nominal):
        raise PlaceError(f"{text!r} is {_kind(found.nominal)} in the scene; a number is needed")
    return Place(text=text, steps=found.steps)


def _walked(data: Mapping[str, Any], text: str, *, may_be_left_out: bool) -> Target:
    """The one walk along a place."""
    value: Any = data
    steps: list[str | int] = []
    done = ""
    written = place_steps(text)
    for k, step in enumerate(written):
        if may_be_left_out and _is_left_out(value, written[k:], at_top=k == 0):
            return Target(text=text, steps=(*steps, *written[k:]), nominal=None)
        key = resolved_step(value, step, done or "the scene", text)
        steps.append(key)
        value = value[key]
        done += step if step.startswith("[") or not done else f".{step}"
    return Target(text=text, steps=tuple(steps), nominal=value)


def resolved_step(value: Any, step: str, where: str, text: str) -> str | int:
    """Return the key or number that a step means in a table or list, which messages call `where`.

    Raises PlaceError: the step leads nowhere; the message says what is allowed.
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


def with_values(data: Mapping[str, Any], values: Mapping[Place, float]) -> dict[str, Any]:
    """Return the data with other numbers at some places."""
    return with_entries(data, {place.steps: value for place, value in values.items()})


def with_entries(data: Mapping[str, Any], entries: Mapping[Steps, Any]) -> dict[str, Any]:
    """Return the data with other entries at some places; what is not changed is shared.

    `entries`: new value by the steps of its place; a table that is left out is added.
    """
    changed = dict(data)
    for steps, value in entries.items():
        container: Any = changed
        for step in steps[:-1]:
            # every container on the way is copied anew for each entry; they are few and small
            inner = container.get(step, {}) if isinstance(container, dict) else container[step]
            container[step] = dict(inner) if isinstance(inner, dict) else list(inner)
            container = container[step]
        container[steps[-1]] = value
    return changed


def place_problems(data: Mapping[str, Any], sweep: SweepSpec) -> Iterator[str]:
    """What is wrong with the places of a sweep: one line each, which begins with the key."""
    base = {key: value for key, value in data.items() if key != "sweep"}
    filled: dict[Steps, str] = {}
    for k, parameter in enumerate(sweep.parameters):
        for number, text in enumerate(parameter.places):
            where = f"sweep.parameters[{k}].places[{number}]"
            try:
                target = find_target(base, text)
            except PlaceError as error:
                yield f"{where}: {error}"
                continue
            first = filled.setdefault(target.steps, where)
            if first != where:
                yield f"{where}: {text!r} is filled by {first} already; a place has one value"
            if parameter.applies == "factor" and not is_number(target.nominal):
                found = "left out" if target.nominal is None else repr(target.nominal)
                yield f"{where}: {text!r} is {found} in the scene; a factor needs a number there"


def entries_at(
    data: Mapping[str, Any], parameter: SweepParameterSpec, value: float | str
) -> dict[Steps, Any]:
    """Return what one value of a parameter puts where; a factor multiplies what the file has."""
    found = {}
    for text in parameter.places:
        target = find_target(data, text)
        entry = value
        if parameter.applies == "factor" and isinstance(target.nominal, int | float):
            entry = float(value) * target.nominal
        found[target.steps] = _whole(entry)
    return found


def _is_left_out(value: Any, steps: tuple[str, ...], *, at_top: bool) -> bool:
    """Whether the next keys are ones that the file leaves out, and not a way that is wrong."""
    if not isinstance(value, dict) or steps[0] in value or any(s[0] == "[" for s in steps):
        return False
    return len(steps) == 2 and steps[0] in _OPTIONAL if at_top else len(steps) == 1


def is_number(value: Any) -> bool:
    """Whether a value of a TOML file is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _kind(value: Any) -> str:
    names = {dict: "a table", list: "a list", str: "a text", bool: "true or false"}
    return names.get(type(value), f"{value!r}")


def _whole(value: float | str) -> float | str:
    """Whole numbers stand for decimal ones in a scene, but not the other way round."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 2.0**53:
        return int(value)
    return value
