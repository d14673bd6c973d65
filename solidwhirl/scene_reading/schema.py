"""JSON schemas of scene files and of results.json, so that editors complete and check keys."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from importlib import resources
from typing import Any

from solidwhirl.scene.records import Scene

_DRAFT = "https://json-schema.org/draft/2020-12/schema"
_LINK = re.compile(r"\[((?:[^\[\]]|\[+[^\]]*\]+)*)\]\([^)]*\)")
#: What the end of a key says about the unit of its number, the longest first.
UNITS: Mapping[str, str] = {
    "_n_m_s_per_rad": "N m s/rad",
    "_n_m_per_rad": "N m/rad",
    "_n_s_per_m": "N s/m",
    "_n_per_m": "N/m",
    "_kg_per_m3": "kg/m³",
    "_m_per_s2": "m/s²",
    "_kg_m2": "kg m²",
    "_kg_m": "kg m",
    "_kg": "kg",
    "_pa": "Pa",
    "_rpm": "rpm",
    "_hz": "Hz",
    "_deg": "deg",
    "_s": "s",
    "_m": "m",
}


def unit(key: str) -> str:
    """Return the unit that the end of a key says, empty for none."""
    return next((text for end, text in UNITS.items() if key.endswith(end)), "")


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
