"""Kept results of a study: only what was written whole is taken, whatever lies in the folder."""

from __future__ import annotations

import json
import random
from types import SimpleNamespace

import pytest

from solidwhirl.study_runner import _digest, _kept
from solidwhirl.study_settings import CASE_SCHEMA

RESULT = {"status": "done", "cpu_s": 1.5, "campbell": {"true": [1e-3, None]}}
GOOD = {"schema": CASE_SCHEMA, "case": {}, "sha256": _digest(RESULT), "result": RESULT}


@pytest.fixture
def kept(tmp_path):
    """Function: what is taken from a file with this content."""

    def take(content):
        (tmp_path / "key.json").write_bytes(content)
        return _kept(SimpleNamespace(key="key"), tmp_path)

    return take


def test_whole_record_is_taken(kept):
    assert kept(json.dumps(GOOD, indent=1).encode()) == RESULT


@pytest.mark.parametrize(
    "content",
    [
        b"", b"[]", b"null", b"{}", b"{", b"\xff", b"[" * 100_000, b'{"result": [1]}',
        b'{"result": {"status": "done"}}', b'{"result": ' * 50_000, b"1" * 6000,
        json.dumps({**GOOD, "result": []}).encode(),
        json.dumps({**GOOD, "schema": "other"}).encode(),
        json.dumps({**GOOD, "sha256": None}).encode(),
        json.dumps({**GOOD, "result": {**RESULT, "cpu_s": 1.6}}).encode(),
        json.dumps({**GOOD, "result": {**RESULT, "status": "failed"}}).encode(),
    ],
)  # fmt: skip
def test_anything_else_is_computed_again(kept, content):
    assert kept(content) is None


def test_damaged_bytes_are_never_another_result(kept):
    """300 inputs: what is taken is what was written."""
    content = json.dumps(GOOD).encode()
    for seed in range(300):
        rng = random.Random(seed)
        changed = bytearray(content)
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
        assert kept(bytes(changed[: rng.choice((None, rng.randrange(len(changed))))])) in (
            None,
            RESULT,
        )
