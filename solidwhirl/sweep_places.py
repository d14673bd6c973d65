"""Where the values of a sweep go: places of numbers and texts in the data of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from solidwhirl.identify_places import PlaceError, place_steps, resolve_step
from solidwhirl.scene_sweep import SweepParameterSpec, SweepSpec

Steps = tuple[str | int, ...]
# Tables of a scene that may be left out as a whole: a sweep may name a key of them all the same.
_OPTIONAL = ("model", "effects", "speeds", "campbell", "criteria")


@dataclass(frozen=True, kw_only=True)
class Target:
    """A place that a sweep fills.

    Attributes
    ----------
    steps
        Keys and numbers of entries from the top of the scene.
    nominal
        What stands there in the scene file; None where the key is left out.
    """

    steps: Steps
    nominal: float | str | bool | None


def find_target(data: Mapping[str, Any], text: str) -> Target:
    """Find a place that can be filled, which may be a key that the file leaves out.

    Parameters
    ----------
    data
        Content of a scene file.
    text
        The place, as in `solidwhirl.identify_places.Place`.

    Raises
    ------
    PlaceError
        The text is no place, leads nowhere, or to a table or list.
    """
    value: Any = data
    steps: list[str | int] = []
    done = ""
    parts = place_steps(text)
    for k, part in enumerate(parts):
        if _is_left_out(value, parts[k:], at_top=k == 0):
            return Target(steps=(*steps, *parts[k:]), nominal=None)
        key = resolve_step(value, part, done or "the scene", text)
        steps.append(key)
        value = value[key]
        done += part if part.startswith("[") or not done else f".{part}"
    if isinstance(value, dict | list):
        found = "a table" if isinstance(value, dict) else "a list"
        raise PlaceError(f"{text!r} is {found} in the scene; one number or text is needed")
    if not isinstance(value, int | float | str):
        raise PlaceError(f"{text!r} is {value!r} in the scene; a number or text is needed")
    if steps[0] == "name":
        raise PlaceError("'name' stays as it is: folders and rows of the cases have it")
    return Target(steps=tuple(steps), nominal=value)


def place_problems(data: Mapping[str, Any], sweep: SweepSpec) -> Iterator[str]:
    """What is wrong with the places of a sweep: one line each, which begins with the key.

    Parameters
    ----------
    data
        Content of the scene file.
    sweep
        Its sweep.
    """
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
            if parameter.applies == "factor" and not _is_number(target.nominal):
                yield (
                    f"{where}: {text!r} is {_said(target.nominal)}; a factor needs a number there"
                )


def with_entries(data: Mapping[str, Any], entries: Mapping[Steps, Any]) -> dict[str, Any]:
    """Return the data with other entries at some places; what is not changed is shared.

    Parameters
    ----------
    data
        Content of a scene file.
    entries
        New value by the steps of its place; a table that is left out is added.
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


def entries_at(
    data: Mapping[str, Any], parameter: SweepParameterSpec, value: float | str
) -> dict[Steps, Any]:
    """Return what one value of a parameter puts where.

    Parameters
    ----------
    data
        Content of the scene file, checked.
    parameter
        The parameter; a factor multiplies what stands in the file.
    value
        Its value.
    """
    found = {}
    for text in parameter.places:
        target = find_target(data, text)
        entry = value
        if parameter.applies == "factor" and isinstance(target.nominal, int | float):
            entry = float(value) * target.nominal
        found[target.steps] = _whole(entry)
    return found


def _is_left_out(value: Any, parts: list[str], *, at_top: bool) -> bool:
    """Whether the next keys are ones that the file leaves out, and not a way that is wrong."""
    if not isinstance(value, dict) or parts[0] in value or any(p.startswith("[") for p in parts):
        return False
    if at_top:
        return len(parts) == 2 and parts[0] in _OPTIONAL
    return len(parts) == 1


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _said(value: Any) -> str:
    return "left out in the scene" if value is None else f"{value!r} in the scene"


def _whole(value: float | str) -> float | str:
    """Whole numbers stand for decimal ones in a scene, but not the other way round."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 2.0**53:
        return int(value)
    return value
