"""All numbers of a document."""

from __future__ import annotations


def numbers(value, keys=()):
    """Numbers in their order, with the keys that lead to them; true and false are none."""
    if isinstance(value, bool):
        return []
    if isinstance(value, dict):
        return [n for key, item in value.items() for n in numbers(item, (*keys, key))]
    if isinstance(value, list):
        return [n for item in value for n in numbers(item, keys)]
    return [(value, keys)] if isinstance(value, int | float) else []
