"""Write the JSON schema of results.json from the results of runs: OUT/results.json of every scene.

    tools/results_schema.py out/*/results.json

Keys of the top that stand in all results are required; below, what is absent is left out or null.
Tables whose keys are names of a scene (bodies, analyses, ...) allow any key; what stands below one
may stand below all.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

TARGET = (
    Path(__file__).resolve().parents[1] / "solidwhirl" / "scene_reading" / "results.schema.json"
)
# Tables from names of a scene, a file or the program's parts to values.
NAMED = {
    *("bodies", "materials", "packages", "seconds", "free_frequencies", "speed_ratios", "parts"),
    *("interfaces", "settings", "stages", "files", "couplings", "shafts", "limits", "bearings"),
    *("peaks", "bodies_of_several_materials", "assembled", "solved", "timings_s", "error_parts"),
    *("sidebands_m", "analyses_cpu_s", "dense_problems", "body_problems", "gear_forces_n"),
    *("law_loads", "bearing_cases", "laws"),
}
_TYPES = {str: "string", bool: "boolean", int: "number", float: "number", type(None): "null"}


def merged(values: list[Any], name: str = "") -> dict[str, Any]:
    """Return the schema of what stands at one place in several results."""
    tables = [v for v in values if isinstance(v, dict)]
    lists = [v for v in values if isinstance(v, list)]
    found = [{"type": t} for t in sorted(_scalars(values))]
    if lists:
        inner = merged([item for v in lists for item in v])
        found.append({"type": "array", "items": inner} if inner else {"type": "array"})
    if tables:
        found.append(_table(tables, name))
    if not found:
        return {}
    if name and (lists or tables) and {"type": "null"} not in found:
        found.append({"type": "null"})
    if len(found) > 1 and all(set(f) == {"type"} for f in found):
        return {"type": [f["type"] for f in found]}
    return found[0] if len(found) == 1 else {"anyOf": found}


def _scalars(values: list[Any]) -> set[str]:
    """Types of numbers and texts; a number or text that is absent elsewhere is null."""
    found = {_TYPES[type(v)] for v in values if type(v) in _TYPES}
    return found | {"null"} if found & {"number", "string", "boolean"} else found


def _table(tables: list[dict[str, Any]], name: str) -> dict[str, Any]:
    if name in NAMED or any("." in key for t in tables for key in t):
        inner = [v for t in tables for v in t.values()]
        return {"type": "object", "additionalProperties": merged(inner)}
    if name == "analyses":
        return {"type": "object", "additionalProperties": _by_kind(tables)}
    keys = dict.fromkeys(k for t in tables for k in t)
    properties = {k: merged([t[k] for t in tables if k in t], k) for k in keys}
    return {"type": "object", "properties": properties}


def _by_kind(tables: list[dict[str, Any]]) -> dict[str, Any]:
    """Schema of an analysis: one of those of the kinds."""
    found: dict[str, list[dict[str, Any]]] = {}
    for entry in (e for t in tables for e in t.values()):
        found.setdefault(entry["kind"], []).append(entry)
    schemas = []
    for kind, entries in sorted(found.items()):
        schema = merged(entries)
        schema["properties"]["kind"] = {"const": kind}
        schemas.append(schema)
    return {"anyOf": schemas}


def main() -> None:
    """Write the schema."""
    documents = [json.loads(Path(p).read_text(encoding="utf-8")) for p in sys.argv[1:]]
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "results.json of solidwhirl",
        **merged(documents),
        "required": [k for k in documents[0] if all(k in d for d in documents)],
    }
    TARGET.write_text(json.dumps(schema, separators=(",", ":")) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
