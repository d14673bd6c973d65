"""JSON schemas of scene files and of results.json, so that editors complete and check keys."""

from __future__ import annotations

import json
import re
import tomllib
from importlib import resources
from typing import Any

from solidwhirl.core.key_units import unit_of
from solidwhirl.scene.records import Scene

_DRAFT = "https://json-schema.org/draft/2020-12/schema"
_LINK = re.compile(r"\[((?:[^\[\]]|\[+[^\]]*\]+)*)\]\([^)]*\)")


def unit(key: str) -> str:
    """Return the unit that the end of a key says, in plain letters; empty for none."""
    return unit_of(key).replace("·", " ").replace("°", "deg")


def explanations() -> dict[str, dict[str, str]]:
    """Return what the keys of every record of a scene file mean, in Markdown."""
    text = resources.files(__package__).joinpath("explanations.toml").read_text("utf-8")
    return tomllib.loads(text)


def scene_schema() -> dict[str, Any]:
    """Return the JSON schema of scene files, with the meaning and unit of every key."""
    schema = Scene.model_json_schema(mode="validation")
    for record, meanings in explanations().items():
        node = schema if record == "Scene" else schema["$defs"][record]
        for key, meaning in meanings.items():
            of = f" [{unit(key)}]" if unit(key) else ""
            node["properties"][key]["description"] = _LINK.sub(r"\1", meaning) + of
    return {"$schema": _DRAFT, **schema, "title": "Scene of solidwhirl"}


def results_schema() -> dict[str, Any]:
    """Return the JSON schema of results.json.

    `tools/results_schema.py` makes it from the results of all scenes that come with the program.
    """
    text = resources.files(__package__).joinpath("results.schema.json").read_text("utf-8")
    found: dict[str, Any] = json.loads(text)
    return found
