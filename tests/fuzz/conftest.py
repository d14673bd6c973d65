"""Generators of bad input, and what a refusal must look like."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
ROOT = Path(__file__).resolve().parents[2]
LONGEST_MESSAGE = 4000


@pytest.fixture(scope="session")
def scenes(tmp_path_factory):
    """Copy of the scene and problem files: function from kind and name to path."""
    folder = tmp_path_factory.mktemp("scenes")
    for path in sorted((ROOT / "scenes").glob("**/*.toml")):
        copy = folder / path.relative_to(ROOT / "scenes")
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(path.read_bytes())
    return folder


@pytest.fixture(scope="session")
def check_message():
    """Function: a refusal names the file and a place, and is short, printable and one message."""

    def check(message, path, place):
        assert 0 < len(message) < LONGEST_MESSAGE, len(message)
        head = re.match(rf"{re.escape(str(path))}(:\d+:\d+)?: ", message)
        assert head, message[:200]
        assert "Traceback" not in message
        assert all(c.isprintable() or c == "\n" for c in message), repr(message)[:300]
        rest = message[head.end() :]
        assert re.match(place, rest), rest[:300]

    return check
