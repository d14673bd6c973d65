"""Other numbers in the text of a TOML file; comments and all else stay byte for byte."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping

import numpy as np

from solidwhirl.core.errors import KeyPath
from solidwhirl.scene_reading.paths import with_entries
from solidwhirl.scene_reading.toml_places import Places

_WHOLE = re.compile(r"[+-]?[0-9_]+")


def with_numbers(text: str, numbers: Mapping[KeyPath, float]) -> str:
    """Return the text of a TOML file with other numbers at some places.

    `numbers`: finite ones, by keys and numbers of entries from the top of the file. They are
    written as those before: whole where they can, with an exponent where that one had one.

    Raises ValueError: no number stands at a place, or the text is no TOML.
    """
    places = Places(text)
    changes = []
    for path, number in numbers.items():
        span = places.word(path)
        if span is None:
            raise ValueError(f"no number stands at {'.'.join(map(str, path))}")
        changes.append((*span, _written(number, text[slice(*span)])))
    found = text
    for begin, end, word in sorted(changes, reverse=True):
        found = found[:begin] + word + found[end:]
    # the parser has the last word on what the reader of places found
    if tomllib.loads(found) != with_entries(tomllib.loads(text), dict(numbers)):
        raise ValueError("the numbers can not be told apart from what stands around them")
    return found


def _written(number: float, before: str) -> str:
    if _WHOLE.fullmatch(before) and float(number).is_integer() and abs(number) < 2.0**53:
        return str(int(number))
    plain = repr(float(number))
    if "e" in before.lower() and "x" not in before.lower():
        short = np.format_float_scientific(number, trim="-", exp_digits=1).replace("e+", "e")
        return min(plain, short, key=len)
    return plain
