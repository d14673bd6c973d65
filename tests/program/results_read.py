"""What tests read of results: a document that is strict JSON, and all its numbers."""

from __future__ import annotations

import json


def results_in(folder):
    """The content of results.json, in which NaN and infinity do not stand."""

    def refuse(text):
        raise AssertionError(f"{text} is no JSON")

    return json.loads((folder / "results.json").read_text(encoding="utf-8"), parse_constant=refuse)


def numbers(value, keys=()):
    """Numbers in their order, with the keys that lead to them; true and false are none."""
    if isinstance(value, bool):
        return []
    if isinstance(value, dict):
        return [n for key, item in value.items() for n in numbers(item, (*keys, key))]
    if isinstance(value, list):
        return [n for item in value for n in numbers(item, keys)]
    return [(value, keys)] if isinstance(value, int | float) else []
