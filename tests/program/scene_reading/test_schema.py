"""JSON schemas: scenes and results that the program takes or makes fit, others do not."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from solidwhirl.analyses.base import Analysis
from solidwhirl.analyses.registry import KINDS as ANALYSES
from solidwhirl.cli import app
from solidwhirl.core.fields import Record, keys_of
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.schema import explanations, results_schema, scene_schema, unit

ROOT = Path(__file__).resolve().parents[3]
KINDS = {
    "object": dict,
    "array": list,
    "string": str,
    "number": (int, float),
    "integer": int,
    "boolean": bool,
    "null": type(None),
}


def misfits(value, node, schema, where="$"):
    """Places that do not fit, by the part of JSON schema that pydantic and the tool write."""
    if "$ref" in node:
        node = schema["$defs"][node["$ref"].rsplit("/", 1)[-1]]
    for word in ("anyOf", "oneOf"):
        if word in node:
            found = [misfits(value, option, schema, where) for option in node[word]]
            return [] if [] in found else [m for f in found for m in f]
    if ("const" in node and value != node["const"]) or value not in node.get("enum", [value]):
        return [where]
    kinds = node.get("type", list(KINDS))
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if "type" in node and not any(isinstance(value, KINDS[k]) for k in kinds):
        return [where]
    return [*inside(value, node, schema, where)]


def inside(value, node, schema, where):
    if isinstance(value, dict):
        yield from (f"{where}.{k}" for k in node.get("required", ()) if k not in value)
        other = node.get("additionalProperties", {})
        named = node.get("patternProperties", {}).values()
        for key, item in value.items():
            below = node.get("properties", {}).get(key) or next(iter(named), other)
            if below is False:
                yield f"{where}.{key}"
            else:
                yield from misfits(item, {} if below is True else below, schema, f"{where}.{key}")
    elif isinstance(value, list):
        pairs = zip(value, node.get("prefixItems", [node.get("items", {})] * len(value)))  # noqa: B905
        for k, (item, below) in enumerate(pairs):
            yield from misfits(item, below, schema, f"{where}[{k}]")


@pytest.mark.parametrize("path", sorted(ROOT.glob("scenes/*.toml")), ids=lambda p: p.stem)
def test_scenes_fit(path):
    schema = scene_schema()
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    assert misfits(data, schema, schema) == []


def test_misspelt_and_missing_keys_do_not_fit():
    schema = scene_schema()
    data = {"model": {"acuracy": 1e-3}, "bearings": [{"name": "a"}]}
    found = set(misfits(data, schema, schema))
    assert found == {"$.name", "$.bearings[0].first", "$.model.acuracy"}


def test_every_key_is_explained_once():
    found = {"Scene": set(Scene.model_fields)}
    queue = [Scene]
    while queue:
        for field in queue.pop().model_fields.values():
            for record in records_in(field.annotation):
                if record.__name__ not in found:
                    found[record.__name__] = set(keys_of(record))
                    queue.append(record)
    assert {name: set(keys) for name, keys in explanations().items()} == found
    assert all(text for keys in explanations().values() for text in keys.values())


def records_in(annotation):
    if annotation is Analysis:
        yield from ANALYSES.values()
        return
    if isinstance(annotation, type) and issubclass(annotation, Record):
        yield annotation
    for part in getattr(annotation, "__args__", ()):
        yield from records_in(part)


def test_descriptions_have_meaning_and_unit():
    schema = scene_schema()
    key = schema["$defs"]["SectionSpec"]["properties"]["start_m"]
    assert key["description"] == "axial position of the ends, start < end [m]"
    assert unit("stiffness_n_per_m") == "N/m"
    assert unit("tilt_damping_n_m_s_per_rad") == "N m s/rad"
    assert "](#" not in json.dumps(schema)


@pytest.mark.solver
def test_results_fit(small_scene, tmp_path):
    from solidwhirl.identify.scene import scene_text

    path = tmp_path / "small.toml"
    path.write_text(scene_text(small_scene(), {}), encoding="utf-8")
    done = CliRunner().invoke(app, ["run", str(path), "--out", str(tmp_path / "out"), "--quiet"])
    assert done.exit_code == 0, done.output
    document = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    schema = results_schema()
    assert misfits(document, schema, schema) == []
    del document["campbell"]
    assert misfits(document, schema, schema) == ["$.campbell"]


def test_command_prints_both():
    for name in ("scene", "results"):
        done = CliRunner().invoke(app, ["schema", name])
        assert done.exit_code == 0
        assert json.loads(done.stdout)["type"] == "object"
    assert CliRunner().invoke(app, ["schema", "other"]).exit_code == 2
