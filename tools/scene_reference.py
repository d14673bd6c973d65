"""Write docs/scene_keys.md: every key of a scene file, from the records that read it.

Types, units, defaults and what is allowed come from the records of `solidwhirl.scene`, meanings
from the tables of docs/scene.md. `--check` writes nothing, and fails if the page is not current.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from solidwhirl.scene import Scene
from solidwhirl.scene_base import Record

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "scene_keys.md"
PROSE = ROOT / "docs" / "scene.md"
HEAD = """\
# Keys of a scene file

Every table and key, in the order of the file. This page is made of the program itself by
`tools/scene_reference.py`; [scene.md](scene.md) explains the keys with examples, and
[howto.md](howto.md) begins with questions.

*Number* may be written as `2`, `2.0` or `2e7`; *name* is a letter followed by up to 63 letters,
digits, `_` or `-`; *place* is `"body.interface"`. Keys without default have to be given. The unit
is the end of the key's name. Lists have up to 2001 entries where nothing else is said.
"""
# How a table is written in the file, and the headings of docs/scene.md that explain its keys.
TABLES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "Scene": ("top of the file", ("Top level",)),
    "MaterialSpec": ("[materials.NAME]", ("Materials",)),
    "BodySpec": ("[bodies.NAME]", ("Bodies",)),
    "SectionSpec": ("sections of [bodies.NAME]", ("Sections",)),
    "StageGroupSpec": ("stage_groups of [bodies.NAME]", ("Stage groups",)),
    "WebSpec": ("webs of a stage group", ("Stage groups",)),
    "ConeSpec": ("cones of a stage group", ("Stage groups",)),
    "InterfaceSpec": ("interfaces of [bodies.NAME]", ("Interfaces",)),
    "RigidDiskSpec": ("rigid_disks of a body", ("Rigid disks",)),
    "InternalDampingSpec": ("internal_damping of a body", ("Internal damping",)),
    "BeamSpec": ("[beams.NAME]", ("Beams",)),
    "BeamDiskSpec": ("disks of [beams.NAME]", ("Beams",)),
    "RigidBodySpec": ("[rigid_bodies.NAME]", ("Rigid bodies",)),
    "ImportedSpec": ("[imported.NAME]", ("Imported bodies",)),
    "MeshBodySpec": ("[mesh_bodies.NAME]", ("Mesh bodies", "Bodies")),
    "AxisSpec": ("axis of [mesh_bodies.NAME]", ()),
    "MeshInterfaceSpec": ("interfaces of [mesh_bodies.NAME]", ("Mesh bodies",)),
    "BearingSpec": ("[[bearings]]", ("Bearings",)),
    "PolynomialLawSpec": ('[speed_laws.NAME], kind = "polynomial"', ("Speed laws",)),
    "TableLawSpec": ('[speed_laws.NAME], kind = "table"', ("Speed laws",)),
    "PresetLawSpec": ('[speed_laws.NAME], kind = "preset"', ()),
    "GearSpec": ("[[gears]]", ("Gears",)),
    "SpeedSpec": ("[speeds]", ("Speeds",)),
    "CampbellSpec": ("[campbell]", ("Campbell diagram",)),
    "EffectsSpec": ("[effects]", ()),
    "ModelSpec": ("[model]", ("Model",)),
    "UnbalanceSpec": ("unbalances of an analysis", ()),
    "OperatingSpec": ("[[operating]]", ("Operating speeds and criteria",)),
    "CriteriaSpec": ("[criteria]", ("Operating speeds and criteria",)),
    "RecoveryStateSpec": ("states of recovery", ("Recovery",)),
    "ReferenceSpec": ("[[references]]", ("References",)),
    "SweepSpec": ("[sweep]", ("Sweep",)),
    "SweepParameterSpec": ("[[sweep.parameters]]", ("Sweep",)),
}
# Meanings of keys that docs/scene.md explains in its text and not in a table.
MEANINGS: Mapping[str, Mapping[str, str]] = {
    "Scene": {
        "speeds": "[speeds](scene.md#speeds) of the diagram",
        "campbell": "[branches](scene.md#campbell-diagram) of the diagram",
        "criteria": "[which modes count](scene.md#operating-speeds-and-criteria)",
        "effects": "[effects](scene.md#effects) that are computed or left out",
        "model": "[level, accuracy](scene.md#model) and mesh",
    },
    "MaterialSpec": {
        "density_kg_per_m3": "mass per volume",
        "youngs_modulus_pa": "modulus of elasticity",
        "poissons_ratio": "Poisson's ratio",
    },
    "SectionSpec": {"material": "of this section; the body's where not given"},
    "StageGroupSpec": {"material": "of the rings and spacers; the body's where not given"},
    "RigidDiskSpec": {"mass_kg": "mass"},
    "InterfaceSpec": {"kind": "which [surface](scene.md#interfaces) of the body"},
    "WaterfallSpec": {"speed_count": "number of speeds"},
    "StabilitySpec": {"from_rpm": "lowest speed", "to_rpm": "highest speed"},
    "RunUpSpec": {"unbalances": "unbalances that excite during the run-up"},
    "ConeSpec": {"shaft_radius_m": "surface that the foot sits on"},
    "BeamDiskSpec": {
        "name": "unique in the beam",
        "at_m": "place on the axis",
        "mass_kg": "mass",
        "polar_inertia_kg_m2": "about the axis; at most twice the diametral one",
        "diametral_inertia_kg_m2": "about a diameter through its own centre",
    },
    "AxisSpec": {
        "origin": "point of the file that becomes z = 0, in the file's unit",
        "direction": "direction of the file that becomes z",
        "x_direction": "direction of the file that becomes x",
    },
    "PresetLawSpec": {"kind": "the law comes with the program", "preset": "which one"},
    "PolynomialLawSpec": {"kind": "factors of the bearing's own coefficients"},
    "TableLawSpec": {"kind": "coefficients at given speeds"},
    "UnbalanceSpec": {
        "at": "where; on a body that turns",
        "moment_kg_m": "mass times its distance from the axis; needed where there is no grade",
        "phase_deg": "angle from +x towards +y at time 0",
        "grade": "instead of the moment: balance quality grade G of ISO 21940, in mm/s",
        "at_rpm": "with the grade: maximum service speed of the body itself",
        "share": "with the grade: part of the permissible unbalance in this plane",
    },
    "EffectsSpec": {
        "gyroscopic": "gyroscopic terms of bodies that turn",
        "stress_stiffening": "stiffness from the centrifugal stress; together with the next",
        "spin_softening": "softening by the rotation; together with the one above",
        "bearing_damping": "damping of bearings and gears",
        "internal_damping": "damping of materials, which turns with the body",
        "speed_dependent_bearings": "laws of bearings",
        "tilt": "rotations rx, ry of interfaces",
        "axial": "motion uz of interfaces",
        "torsion": "rotation rz of interfaces, and gears",
    },
}
UNITS = (
    ("_n_m_s_per_rad", "N m s/rad"),
    ("_n_m_per_rad", "N m/rad"),
    ("_n_s_per_m", "N s/m"),
    ("_n_per_m", "N/m"),
    ("_kg_per_m3", "kg/m³"),
    ("_m_per_s2", "m/s²"),
    ("_kg_m2", "kg m²"),
    ("_kg_m", "kg m"),
    ("_kg", "kg"),
    ("_pa", "Pa"),
    ("_rpm", "rpm"),
    ("_hz", "Hz"),
    ("_deg", "deg"),
    ("_s", "s"),
    ("_m", "m"),
)
# Limits that hold for all numbers and lists are said once, in the head.
_LARGEST, _MOST = 1e30, 2001
# What a validator that runs before the type makes acceptable besides.
_ALSO = {
    "_pair": "number, or [number, number] at the two ends",
    "_matrix": "number, [x, y], or [[xx, xy], [yx, yy]]",
    "_switch": '`"auto"`, `"on"`, `"off"`',
    "_several": "number, or list of numbers",
}
_PATTERNS = {"[A-Za-z0-9_-]{0,63}\\.": "place", "^[A-Za-z][A-Za-z0-9_-]{0,63}$": "name"}


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of the file: how it is written, and the record that reads it."""

    title: str
    record: type[Record]
    headings: tuple[str, ...]


def tables() -> list[Table]:
    """Return all tables that a scene file may have, each once, in the order of the file."""
    found: dict[type[Record], None] = {}
    _walk(Scene, found)
    return [Table(title=_title(r), record=r, headings=_headings(r)) for r in found]


def _walk(record: type[Record], found: dict[type[Record], None]) -> None:
    if record in found:
        return
    found[record] = None
    for field in record.model_fields.values():
        for part in _records_in(field.annotation):
            _walk(part, found)


def _records_in(annotation: Any) -> Iterator[type[Record]]:
    """Records that a type is made of."""
    if isinstance(annotation, type) and issubclass(annotation, Record):
        yield annotation
    for part in getattr(annotation, "__args__", ()):
        yield from _records_in(part)


def _kind(record: type[Record]) -> str | None:
    """The kind of an analysis."""
    if record.__name__ in TABLES:
        return None
    return str(record.model_fields["kind"].annotation.__args__[0])  # type: ignore[union-attr]


def _title(record: type[Record]) -> str:
    kind = _kind(record)
    return TABLES[record.__name__][0] if kind is None else f'[[analyses]], kind = "{kind}"'


def _headings(record: type[Record]) -> tuple[str, ...]:
    kind = _kind(record)
    if kind is None:
        return TABLES[record.__name__][1]
    heading = kind.replace("_", " ").capitalize().replace("Run up", "Run-up")
    return (heading.replace("campbell", "Campbell"), "Analyses")


def meanings(text: str) -> dict[str, dict[str, str]]:
    """Return what the tables of docs/scene.md say: by heading and key, the last cell of the row.

    Parameters
    ----------
    text
        The page.
    """
    found: dict[str, dict[str, str]] = {}
    heading, inside = "", False
    for line in text.splitlines():
        if line.startswith("#"):
            heading = line.lstrip("# ")
        if not line.startswith("|"):
            inside = False
            continue
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if cells[0] == "key":
            inside = True
        elif inside and not set(cells[0]) <= set("- "):
            for key in re.findall(r"`(\w+)`", cells[0]):
                found.setdefault(heading, {}).setdefault(key, cells[-1])
    return found


def page() -> str:
    """Return the text of docs/scene_keys.md."""
    explained = meanings(PROSE.read_text(encoding="utf-8"))
    pieces = [HEAD, "\n".join(f"- [{_plain(t)}](#{_anchor(t)})" for t in tables())]
    pieces += [_section(table, explained) for table in tables()]
    return "\n\n".join(piece.strip() for piece in pieces) + "\n"


def _plain(table: Table) -> str:
    return f"`{table.title}`" if "[" in table.title or "_" in table.title else table.title


def _anchor(table: Table) -> str:
    kept = re.sub(r"[^\w\- ]", "", table.title.lower())
    return kept.replace(" ", "-")


def _section(table: Table, explained: Mapping[str, Mapping[str, str]]) -> str:
    schema = table.record.model_json_schema(mode="validation")
    lines = [f"## {_plain(table)}", "", _sentence(table)]
    lines += ["", "| key | value | unit | default | meaning |", "|---|---|---|---|---|"]
    for key, field in table.record.model_fields.items():
        shown = _value(table, key, field, schema)
        meaning = _meaning(table, key, explained)
        lines.append(f"| `{key}` | {shown} | {unit(key)} | {_default(field)} | {meaning} |")
    return "\n".join(lines)


def _sentence(table: Table) -> str:
    summary = (table.record.__doc__ or "").strip().splitlines()[0]
    if not table.headings:
        return summary
    anchor = table.headings[0].lower().replace(" ", "-")
    return f"{summary} [Explained](scene.md#{anchor})."


def unit(key: str) -> str:
    """Return the unit that the end of a key's name says, empty for none.

    Parameters
    ----------
    key
        The key.
    """
    return next((text for end, text in UNITS if key.endswith(end)), "")


def _meaning(table: Table, key: str, explained: Mapping[str, Mapping[str, str]]) -> str:
    own = MEANINGS.get(table.record.__name__, {})
    if key in own:
        return own[key]
    for heading in table.headings:
        text = explained.get(heading, {}).get(key)
        if text:
            return re.sub(r"\]\(#", "](scene.md#", re.sub(r",? see below", "", text))
    raise SystemExit(f"{table.title}: {key} is explained neither in docs/scene.md nor here")


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "**required**"
    value = field.get_default(call_default_factory=True)
    if value is None or value in ((), {}) or isinstance(value, Record):
        return ""
    if isinstance(value, str):
        return f'`"{value}"`' if value else ""
    if value == ((0.0, 0.0), (0.0, 0.0)):
        return "0"
    if isinstance(value, tuple):
        return "`[" + ", ".join(_literal(v) for v in value) + "]`"
    return _literal(value)


def _literal(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


def _value(table: Table, key: str, field: FieldInfo, schema: Mapping[str, Any]) -> str:
    for extra in field.metadata:
        name = getattr(getattr(extra, "func", None), "__name__", "")
        if name in _ALSO:
            return _ALSO[name]
    return _shown(schema["properties"][key], schema.get("$defs", {}))


def _shown(node: Mapping[str, Any], defs: Mapping[str, Any]) -> str:
    """A type in words."""
    if "$ref" in node:
        return _reference(str(node["$ref"]).rsplit("/", 1)[-1])
    if "anyOf" in node or "oneOf" in node:
        parts = [p for p in node.get("anyOf", node.get("oneOf", ())) if p.get("type") != "null"]
        shown = dict.fromkeys(_shown(p, defs) for p in parts)
        return " or ".join(shown)
    if "enum" in node or "const" in node:
        return ", ".join(_code(v) for v in node.get("enum", [node.get("const")]))
    return _of_type(node, defs)


def _code(value: Any) -> str:
    return f'`"{value}"`' if isinstance(value, str) else f"`{value}`"


def _reference(name: str) -> str:
    table = next(t for t in tables() if t.record.__name__ == name)
    kind = re.search(r'kind = "(\w+)"', table.title)
    return f"[{kind[1] if kind else 'table'}](#{_anchor(table)})"


def _of_type(node: Mapping[str, Any], defs: Mapping[str, Any]) -> str:
    kind = node.get("type")
    if kind in ("number", "integer"):
        return ("number" if kind == "number" else "whole number") + _limits(node)
    if kind == "string":
        pattern = str(node.get("pattern", ""))
        return next((word for part, word in _PATTERNS.items() if part in pattern), "text")
    if kind == "object":
        values = [*node.get("patternProperties", {}).values(), node.get("additionalProperties")]
        return "table from name to " + _shown(next((v for v in values if v), {}), defs)
    if kind == "array" and "prefixItems" in node:
        return "[" + ", ".join(_shown(item, defs) for item in node["prefixItems"]) + "]"
    if kind == "array":
        low, high = node.get("minItems", 0), node.get("maxItems", _MOST)
        many = f", up to {high}" if high < _MOST else ""
        least = f", {low} at least" if low else ""
        inner = _shown(node["items"], defs)
        return f"list of {inner.replace('[table]', '[tables]')}{least}{many}"
    return "number or text"


def _limits(node: Mapping[str, Any]) -> str:
    low, high = node.get("minimum"), node.get("maximum")
    above, below = node.get("exclusiveMinimum"), node.get("exclusiveMaximum")
    high = None if high is not None and high >= _LARGEST else high
    low = None if low is not None and low <= -_LARGEST else low
    words = [f"> {above:g}"] if above is not None else []
    words += [f"≥ {low:g}"] if low is not None else []
    words += [f"< {below:g}"] if below is not None else []
    words += [f"≤ {high}" if isinstance(high, int) else f"≤ {high:g}"] if high is not None else []
    return " " + ", ".join(words) if words else ""


def main() -> None:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if not current")
    text = page()
    if not parser.parse_args().check:
        PAGE.write_text(text, encoding="utf-8")
    elif not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != text:
        sys.exit(f"{PAGE.relative_to(ROOT)}: not up to date; run tools/scene_reference.py")


if __name__ == "__main__":
    main()
