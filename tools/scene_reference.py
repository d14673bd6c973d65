"""Write the tables of keys into docs/scene.md, from the records that read a scene file.

Types, defaults and what is allowed come from the records of `solidwhirl.scene`, meanings from
`solidwhirl/scene_reading/explanations.toml`; a table stands between `<!-- keys: RECORD -->` and
`<!-- end -->`. `--check` writes nothing, and fails if the page is not current.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from solidwhirl.analyses.base import Analysis
from solidwhirl.analyses.registry import KINDS
from solidwhirl.core.fields import Record, keys_of
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.schema import explanations, unit

_LINK = re.compile(r"\[[^]]*\]\(#([\w-]+)\)")
_MARK = re.compile(r"^<!-- keys: (\w+) -->$", re.MULTILINE)
_TABLE = re.compile(r"^(<!-- keys: (\w+) -->)\n.*?<!-- end -->", re.MULTILINE | re.DOTALL)
# Kind and name of an analysis are explained once, above the sections, which are named by kind.
_ANALYSES = {record.__name__ for record in KINDS.values()}
ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "scene.md"
# Limits that hold for all numbers and lists are said once, in the head.
_LARGEST, _MOST = 1e30, 2001
# What a validator that runs before the type makes acceptable besides.
_ALSO = {
    "_pair": "number, or [number, number] at the two ends",
    "_matrix": "matrix",
    "_switch": "switch",
    "several": "number, or list of numbers",
}
_PATTERNS = {"[A-Za-z0-9_-]{0,63}\\.": "place", "^[A-Za-z][A-Za-z0-9_-]{0,63}$": "name"}


def records() -> dict[str, type[Record]]:
    """Return all records that a scene file is made of, by name, in the order of the file."""
    found: dict[type[Record], None] = {}
    _walk(Scene, found)
    return {record.__name__: record for record in found}


def _walk(record: type[Record], found: dict[type[Record], None]) -> None:
    if record in found:
        return
    found[record] = None
    for field in record.model_fields.values():
        for part in _records_in(field.annotation):
            _walk(part, found)


def _records_in(annotation: Any) -> Iterator[type[Record]]:
    """Records that a type is made of."""
    if annotation is Analysis:
        yield from KINDS.values()
        return
    if isinstance(annotation, type) and issubclass(annotation, Record):
        yield annotation
    for part in getattr(annotation, "__args__", ()):
        yield from _records_in(part)


def page(text: str) -> str:
    """Return the page with its tables made anew.

    Raises
    ------
    SystemExit
        A record has no table, or a table no record.
    """
    marked = _MARK.findall(text)
    every, explained = records(), explanations()
    if sorted(marked) != sorted(every):
        raise SystemExit(f"tables and records differ: {sorted(set(marked) ^ set(every))}")
    owners = _owners(text)
    return _TABLE.sub(
        lambda m: f"{m[1]}\n{_table(every[m[2]], explained[m[2]], owners)}\n<!-- end -->", text
    )


def _owners(text: str) -> dict[str, str]:
    """Anchor of the heading below which each record has its table."""
    owners, anchor = {}, ""
    for line in text.splitlines():
        if line.startswith("#"):
            anchor = re.sub(r"[^\w\- ]", "", line.lstrip("# ").lower()).replace(" ", "-")
        found = _MARK.match(line)
        if found:
            owners[found[1]] = anchor
    return owners


def _table(record: type[Record], meanings: Mapping[str, str], owners: Mapping[str, str]) -> str:
    """Rows of a record's keys; those that differ in their names alone share one."""
    schema = record.model_json_schema(mode="validation")
    named = ("kind", "name") if record.__name__ in _ANALYSES else ()
    rows: dict[tuple[str, str, str], list[str]] = {}
    for key, field in keys_of(record).items():
        if key in named:
            continue
        shown = next(
            (_ALSO[n] for n in map(_validator, field.metadata) if n in _ALSO),
            None,
        ) or _shown(schema["properties"][key], owners)
        of = f" {unit(key)}" if unit(key) else ""
        meaning = meanings[key].replace("|", "\\|")
        linked = _LINK.fullmatch(meaning)
        if linked and f"(#{linked[1]})" in shown:
            meaning = ""
        value = re.sub("^number (?=.)", "", f"{shown}{of}")
        name = f"**`{key}`**" if field.is_required() else f"`{key}`"
        rows.setdefault((value, _default(field), meaning), []).append(name)
    lines = ["| key | value | default | meaning |", "|---|---|---|---|"]
    lines += [f"| {', '.join(keys)} | {' | '.join(rest)} |" for rest, keys in rows.items()]
    return "\n".join(lines)


def _validator(extra: Any) -> str:
    return getattr(getattr(extra, "func", None), "__name__", "")


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return ""
    value = field.get_default(call_default_factory=True)
    if value is None or value in ((), {}) or isinstance(value, Record):
        return ""
    if isinstance(value, str):
        return f'`"{value}"`' if value else ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if value == ((0.0, 0.0), (0.0, 0.0)):
        return "0"
    if isinstance(value, tuple):
        return "`[" + ", ".join(_literal(v) for v in value) + "]`"
    return _literal(value)


def _literal(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


def _shown(node: Mapping[str, Any], owners: Mapping[str, str]) -> str:
    """A type in words."""
    if "$ref" in node:
        return f"[table](#{owners[str(node['$ref']).rsplit('/', 1)[-1]]})"
    if "anyOf" in node or "oneOf" in node:
        parts = [p for p in node.get("anyOf", node.get("oneOf", ())) if p.get("type") != "null"]
        shown = dict.fromkeys(_shown(p, owners) for p in parts)
        # the kinds of analyses have a section each
        return "table" if "discriminator" in node and len(shown) > 1 else " or ".join(shown)
    if "enum" in node or "const" in node:
        return ", ".join(_code(v) for v in node.get("enum", [node.get("const")]))
    return _of_type(node, owners)


def _code(value: Any) -> str:
    return f'`"{value}"`' if isinstance(value, str) else f"`{value}`"


def _of_type(node: Mapping[str, Any], owners: Mapping[str, str]) -> str:
    kind = node.get("type")
    if kind in ("number", "integer"):
        return ("number" if kind == "number" else "integer") + _limits(node)
    if kind == "boolean":
        return "`true`, `false`"
    if kind == "string":
        pattern = str(node.get("pattern", ""))
        return next((word for part, word in _PATTERNS.items() if part in pattern), "text")
    if kind == "object":
        values = [*node.get("patternProperties", {}).values(), node.get("additionalProperties")]
        return _many(_shown(next((v for v in values if v), {}), owners)) + " by name"
    if kind == "array" and "prefixItems" in node:
        return "[" + ", ".join(_shown(item, owners) for item in node["prefixItems"]) + "]"
    if kind == "array":
        low, high = node.get("minItems", 0), node.get("maxItems", _MOST)
        many = f", {low} at least" if low else ""
        if high < _MOST:
            many = f", {low} to {high}" if low < high else f", {low}"
        return f"list of {_many(_shown(node['items'], owners))}{many}"
    return "number or text"


def _many(shown: str) -> str:
    """A type in the plural."""
    return re.sub(r"\b(table|number|name|place)(?=]|\b(?!]))(?![-(])", r"\1s", shown)


def _limits(node: Mapping[str, Any]) -> str:
    low, high = node.get("minimum"), node.get("maximum")
    above, below = node.get("exclusiveMinimum"), node.get("exclusiveMaximum")
    high = None if high is not None and high >= _LARGEST else high
    low = None if low is not None and low <= -_LARGEST else low
    if low is not None and high is not None:
        return f" {low:g} to {high if isinstance(high, int) else f'{high:g}'}"
    words = [f"> {above:g}"] if above is not None else []
    words += [f"≥ {low:g}"] if low is not None else []
    words += [f"< {below:g}"] if below is not None else []
    words += [f"≤ {high}" if isinstance(high, int) else f"≤ {high:g}"] if high is not None else []
    return " " + ", ".join(words) if words else ""


def main() -> None:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if not current")
    before = PAGE.read_text(encoding="utf-8")
    text = page(before)
    if not parser.parse_args().check:
        PAGE.write_text(text, encoding="utf-8")
    elif before != text:
        sys.exit(f"{PAGE.relative_to(ROOT)}: not up to date; run tools/scene_reference.py")


if __name__ == "__main__":
    main()
