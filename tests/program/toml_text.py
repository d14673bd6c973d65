"""Plain data as TOML text."""

from __future__ import annotations

import json


def value_text(value):
    """A value of any kind, every table inline."""
    if isinstance(value, dict):
        items = (f"{json.dumps(k)} = {value_text(v)}" for k, v in value.items())
        return "{" + ", ".join(items) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_text(v) for v in value) + "]"
    return json.dumps(value)


def toml(data):
    return "".join(f"{key} = {value_text(value)}\n" for key, value in data.items())
