"""Scene files that the program writes: TOML that says where identified numbers come from."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from solidwhirl.core.errors import one_line
from solidwhirl.core.toml_text import toml_key, toml_text
from solidwhirl.identify.problem import ProblemSpec
from solidwhirl.identify.targets import TargetSpec, is_mass_target

Steps = tuple[str | int, ...]
_WIDTH = 100
_NAMES = {
    "mass_kg": "mass",
    "center_of_gravity_m": "centre of gravity",
    "polar_inertia_kg_m2": "polar inertia",
    "diametral_inertia_kg_m2": "diametral inertia",
}


def scene_text(
    data: Mapping[str, Any], comments: Mapping[Steps, str], header: tuple[str, ...] = ()
) -> str:
    """Return the content of a scene file as TOML.

    `data`: content of a scene file, as `tomllib` reads it. `comments`: comments by the place of
    their number: keys and numbers of entries from the top. `header`: lines of the comment at the
    top.
    Returns one line per key; lists of plain records have one line per record, with the comments of
    its numbers above it.
    """
    lines = [*(f"# {one_line(line)}" for line in header), ""]
    lines += _table(data, (), comments)
    text = "\n".join(lines).strip("\n") + "\n"
    return re.sub(r"\n{3,}", "\n\n", text)


def _table(table: Mapping[str, Any], steps: Steps, comments: Mapping[Steps, str]) -> Iterator[str]:
    """Lines of a table's own keys, then of the tables inside it."""
    nested = {k: v for k, v in table.items() if _is_nested(v)}
    for key, value in table.items():
        if key not in nested:
            yield from _entry(key, value, (*steps, key), comments)
    for key, value in nested.items():
        here = (*steps, key)
        if isinstance(value, dict):
            own = any(not _is_nested(v) for v in value.values()) or not value
            yield from ["", f"[{_header(here)}]"] if own else []
            yield from _table(value, here, comments)
            continue
        for k, item in enumerate(value):
            yield from ["", f"[[{_header(here)}]]"]
            yield from _table(item, (*here, k), comments)


def _is_nested(value: Any) -> bool:
    """Whether a value needs a header of its own: tables, and lists of records that hold any."""
    if isinstance(value, dict):
        return True
    inner = [v for item in value for v in item.values()] if _is_records(value) else []
    return any(isinstance(v, dict) or _is_records(v) or _is_matrix(v) for v in inner)


def _is_records(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(v, dict) for v in value)


def _is_matrix(value: Any) -> bool:
    return isinstance(value, list) and any(isinstance(v, list) for v in value)


def _entry(key: str, value: Any, steps: Steps, comments: Mapping[Steps, str]) -> Iterator[str]:
    """Lines of one key with its comment."""
    said = _said(steps, comments)
    if _is_records(value):
        yield f"{toml_key(key)} = ["
        for k, item in enumerate(value):
            yield from (f"    # {text}" for text in _said((*steps, k), comments))
            yield f"    {_value(item)},"
        yield "]"
        return
    text = f"{toml_key(key)} = {_value(value)}"
    if isinstance(value, list) and len(text) > _WIDTH:
        yield f"{toml_key(key)} = ["
        yield from (f"    {_value(v)}," for v in value)
        yield "]"
    elif len(said) == 1 and len(text) + len(said[0]) < _WIDTH - 4:
        yield f"{text}  # {said[0].split(': ', 1)[-1]}"
    else:
        yield from (f"# {line}" for line in said)
        yield text


def _said(steps: Steps, comments: Mapping[Steps, str]) -> list[str]:
    """Comments on the numbers at or below a place, one line for those that say the same."""
    keys: dict[str, list[str]] = {}
    for place, text in comments.items():
        if place[: len(steps)] == steps:
            keys.setdefault(text, []).append(_name(place))
    return [f"{', '.join(names)}: {text}" for text, names in keys.items()]


def _name(place: Steps) -> str:
    """Key of a number, with its index in a list of numbers."""
    key, index = place[-1], ""
    if isinstance(key, int):
        key, index = place[-2], f"[{key}]"
    return f"{key}{index}"


def _header(steps: Steps) -> str:
    return ".".join(toml_key(s) for s in steps if isinstance(s, str))


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_text(value)
    if isinstance(value, list):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, dict):
        inner = ", ".join(f"{toml_key(k)} = {_value(v)}" for k, v in value.items())
        return "{ " + inner + " }" if inner else "{}"
    return repr(value)


def with_references(data: Mapping[str, Any], spec: ProblemSpec) -> dict[str, Any]:
    """Return the scene with a reference for every target that its results will hold.

    `data`: content of a scene file; its own references of other quantities stay. `spec`: the
    problem; targets at a speed are left out, for the results need not hold that speed.
    """
    targets = [t for t in spec.targets if is_mass_target(t) or (t.speed_rpm == 0.0 and not t.shape)]
    fitted = [_reference(target) for target in targets]
    known = {entry["quantity"] for entry in fitted}
    others = [entry for entry in data.get("references", ()) if entry["quantity"] not in known]
    return {**data, "references": [*fitted, *others]}


def _reference(target: TargetSpec) -> dict[str, Any]:
    if is_mass_target(target):
        title, quantity = (
            f"{target.body}: {_NAMES[target.quantity]}",
            f"bodies.{target.body}.{target.quantity}",
        )
        if target.quantity == "center_of_gravity_m":
            quantity += "[2]"
    else:
        assert target.mode is not None
        title = f"mode {target.mode} at rest"
        quantity = f"modes_at_rest.frequency_hz[{target.mode - 1}]"
    how = "identified from it" if target.use == "fit" else "kept aside"
    source = f"{target.source}; {how}" if target.source else how
    return {
        "quantity": quantity,
        "title": title,
        "value": target.value,
        "source": source,
        "tolerance": target.spread,
    }
