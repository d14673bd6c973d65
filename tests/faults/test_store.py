"""The store: what is not whole is not there, and what can not be kept does not matter."""

from __future__ import annotations

import itertools
import os
import signal
from dataclasses import dataclass

import numpy as np
import pytest
from jobs import forked

from solidwhirl.cache.files import FreshStore, MemoryStore, StageStore


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    name: str
    values: np.ndarray


OWN = frozenset({__name__.split(".")[0]})
VALUE = Found(name="a", values=np.arange(3.0))


def refuse(text):
    raise AssertionError(text)


@pytest.fixture
def store(tmp_path):
    return StageStore(tmp_path / "kept", OWN)


@pytest.fixture
def entry(store):
    """Key and path of one small entry."""
    key = store.key("stage", 1, "a", np.arange(2))
    store.keep(key, "stage", VALUE, refuse)
    (path,) = store.folder.iterdir()
    return key, path


def test_kept_and_found(store, entry):
    key, path = entry
    found = store.find(key, refuse)
    assert (found.name, found.values.tobytes()) == (VALUE.name, VALUE.values.tobytes())
    assert path.name == f"{key}.stage"
    assert store.find(store.key("stage", 2, "a", np.arange(2)), refuse) is None
    other = StageStore(store.folder, OWN)
    assert other.key("stage", 1, "a", np.arange(2)) == key
    assert other.find(key, refuse) is not None


def test_a_store_in_memory_keeps_what_was_used_last():
    store = MemoryStore(most=2)
    for key in "ab":
        store.keep(key, "stage", key, refuse)
    assert store.find("a", refuse) == "a"
    store.keep("c", "stage", "c", refuse)
    assert [store.find(key, refuse) for key in "abc"] == ["a", None, "c"]


def damages(data):
    """An entry with any byte changed, cut anywhere, or longer."""
    for place, flip in itertools.product(range(len(data)), (0x01, 0x20, 0x80)):
        yield data[:place] + bytes([data[place] ^ flip]) + data[place + 1 :]
    yield from (data[:length] for length in range(len(data)))
    yield from (data + b"\0", 2 * data)


def test_every_damage_is_a_miss(store, entry):
    key, path = entry
    data = path.read_bytes()
    assert len(data) < 1000
    for changed in damages(data):
        notes = []
        path.write_bytes(changed)
        assert store.find(key, notes.append) is None, changed
        assert not path.exists()
        (note,) = notes
        assert str(path) in note


def test_entry_of_another_key_is_a_miss(store, entry):
    """Whole, but not what is asked for."""
    _, path = entry
    other = store.key("stage", 2)
    path.rename(path.with_name(f"{other}.stage"))
    notes = []
    assert store.find(other, notes.append) is None
    assert "checksum" in notes[0]


def test_entry_that_can_not_be_read_is_a_miss(store, entry):
    key, path = entry
    path.unlink()
    path.mkdir()
    notes = []
    assert store.find(key, notes.append) is None
    assert "can not be read" in notes[0]
    store.keep(key, "stage", VALUE, notes.append)  # nor can it be written
    assert "stage is not kept" in notes[1]


def test_what_can_not_be_kept_is_noted(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    notes = []
    StageStore(tmp_path / "file", OWN).keep("k", "mesh", VALUE, notes.append)
    StageStore(tmp_path / "kept").keep("k", "mesh", VALUE, notes.append)
    assert len(notes) == 2
    assert all("mesh is not kept" in note for note in notes)
    assert not list((tmp_path / "kept").glob("*"))


def test_fresh_store_looks_for_nothing_and_keeps(store, entry):
    key, path = entry
    path.unlink()
    fresh = FreshStore(store.folder, OWN)
    fresh.keep(key, "stage", VALUE, refuse)
    assert fresh.find(key, refuse) is None
    assert store.find(key, refuse) is not None


def test_prune_removes_what_was_not_used(store, entry):
    key, _ = entry
    other = store.key("other")
    store.keep(other, "other", 1.0, refuse)
    new = StageStore(store.folder, OWN)
    assert new.find(key, refuse) is not None
    new.prune(room_bytes=0)
    assert new.find(other, refuse) is None
    assert new.find(key, refuse) is not None


def test_all_entries_are_removed_and_nothing_else(store, entry):
    (store.folder / "mine").write_text("mine", encoding="utf-8")
    store.remove()
    assert [p.name for p in store.folder.iterdir()] == ["mine"]
    (store.folder / "mine").unlink()
    store.remove()
    assert not store.folder.exists()


def test_leftovers_of_today_may_be_another_process(store, entry):
    folder = store.folder
    for name in (".old.tmp", ".new.tmp"):
        (folder / name).write_text("", encoding="utf-8")
    (folder / ".writing-x").mkdir()
    for name in (".old.tmp", ".writing-x"):
        os.utime(folder / name, (0, 0))
    store.clear_leftovers()
    assert sorted(p.name for p in folder.glob(".*")) == [".new.tmp"]


def test_killed_at_every_step_of_keeping(tmp_path):
    """At each operation on files in turn: an entry is whole or it is not there."""
    store = StageStore(tmp_path / "kept", OWN)
    key = store.key("stage")
    for step in range(1, 60):
        ended = forked(step, lambda: store.keep(key, "stage", VALUE, refuse))
        found = store.find(key, refuse)
        assert found is None or found.values.tobytes() == VALUE.values.tobytes()
        if ended == 0:
            assert found is not None
            assert step > 5, "the hook saw nothing"
            return
        assert ended == -signal.SIGKILL
        if found is not None:
            (store.folder / f"{key}.stage").unlink()
    raise AssertionError("it never ended")
