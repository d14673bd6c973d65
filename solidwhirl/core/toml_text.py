"""Words of TOML: those that are written, and keys that take long to read."""

from __future__ import annotations

import json
import re

_BARE = re.compile(r"[A-Za-z0-9_-]+")
#: A name in a key, as a pattern.
KEY = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*')"""
# Keys joined by more dots than any table has levels; the time to read them grows with their square.
_LONG_KEY = re.compile(rf"(?:\.[ \t]*{KEY}[ \t]*){{16}}")
#: What to say of such a key.
LONG_KEY = "a key of more than 16 names joined by dots"


def long_key(text: str) -> int | None:
    """Return where a key of more than 16 names begins; None if there is none."""
    found = _LONG_KEY.search(text)
    return None if found is None else found.start()


def toml_key(key: str) -> str:
    """Return a key as it is written: bare, or in quotes where it must be."""
    return key if _BARE.fullmatch(key) else toml_text(key)


def toml_text(text: str) -> str:
    """Return a basic string; TOML does not allow the delete character that JSON does."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
