"""Superelement files from strangers are read or refused with a message; nothing else happens."""

from __future__ import annotations

import ast
import multiprocessing
import random
import re
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import pytest
from damaged_reading import peak_mib, read_damaged
from superelement_damage import bomb, damage_content, make_originals, without_seal

from solidwhirl.rotordyn import SuperelementError, read_superelement

ROOT = Path(__file__).resolve().parents[2]
# What a message has to begin with after the name of the file.
PLACE = (
    r"attribute '"
    r"|(dof|interface|operators|body|recovery|frequencies|error_forms|moments|provenance)\b"
    r"|superelement\b|interface '|error form '|mass moments: |not a complete HDF5 file|damaged: "
    r"|an interface has|a superelement has"
)
# Memory beyond that of the imports [MiB]: a few files of 100 kB, and what they may declare.
LARGEST_MEMORY_MIB = 150.0
# Seconds until a batch is given up, which is a hang that no limit ended.
PATIENCE_S = 3600


def read_many(folder, kind, first, count):
    """Read damaged files in another process; outcome and message of each seed."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        before = pool.submit(peak_mib).result()
        seeds = range(first, first + count)
        reading = {seed: pool.submit(read_damaged, folder, kind, seed) for seed in seeds}
        # a crash is raised at the first seed that has no answer
        found = {seed: one.result(PATIENCE_S) for seed, one in reading.items()}
        assert pool.submit(peak_mib).result() - before < LARGEST_MEMORY_MIB
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("superelements")
    make_originals(folder)
    return folder


@pytest.fixture
def survive(folder, check_message, capfd):
    """Function: read damaged files and check every outcome; how many were read and refused."""

    def check(kind, first, count):
        outcomes = {"read": 0, "refused": 0, "leaked": 0}
        for seed, (outcome, message) in read_many(folder, kind, first, count).items():
            assert outcome != "leaked", f"seed {seed}: {message}"
            if outcome == "refused":
                check_message(message, folder / f"damaged_{kind}.h5", PLACE)
            outcomes[outcome] += 1
        assert capfd.readouterr().err == ""
        return outcomes

    return check


@pytest.mark.parametrize(
    ("kind", "count", "refused", "read"),
    [
        # the checksum finds all; a few changes leave the file as it was
        ("sealed", 40, 38, 0),
        # without a checksum, some of which crash or hang the HDF5 library
        ("bytes", 20, 12, 0),
        # what HDF5 itself finds in order, every kind of damage several times; harmless additions
        # and numbers that a body may have are read
        ("content", 56, 28, 6),
    ],
)
def test_damage_is_refused_or_read(survive, kind, count, refused, read):
    outcomes = survive(kind, 0, count)
    assert outcomes["refused"] >= refused and outcomes["read"] >= read


@pytest.mark.verify
@pytest.mark.parametrize("kind", ["sealed", "bytes", "content"])
def test_many_more(survive, kind):
    survive(kind, 10_000, {"sealed": 2500, "bytes": 800, "content": 1500}[kind])


def test_crash_and_hang_of_the_library_are_refused(folder, tmp_path):
    """The two are not left to chance: a stand-in for the library that does it."""
    from solidwhirl.rotordyn.storage.sandbox import refuse_harmful

    path = tmp_path / "body.h5"
    path.write_bytes(b"x")

    def crash(_):
        import ctypes

        ctypes.string_at(0)

    def hang(_):
        while True:
            pass

    def swell(_):
        bytearray(1 << 36)

    for read, said in (
        (crash, r"breaks down on it \(signal 11\)"),
        (hang, "does not come to an end with it in 2 s"),
        (swell, "can not do with the memory"),
    ):
        with pytest.raises(SuperelementError, match=said) as caught:
            refuse_harmful(path, read)
        assert str(caught.value).startswith(f"{path}: damaged: ")
    refuse_harmful(path, lambda _: None)


BOMBS = {
    "matrix": r"operators/M has shape \(1000000, 1000000\)",
    "many": r"operators/(M|K0) brings the numbers declared above|dof/node has",
    "chunk": "body/com has chunks of 3200000000 bytes",
    "swelling": "operators/M has a chunk",
    "texts": r"interface/name has (texts of|shape)",
    "wide": "frequencies/free brings the numbers declared above",
    "filter": "operators/K0 is packed by HDF5 filter",
    "packed": "recovery/xyz brings the numbers declared above",
}


@pytest.mark.parametrize("kind", BOMBS)
def test_bombs_are_refused_before_they_go_off(folder, tmp_path, kind):
    copy = tmp_path / "bomb.h5"
    one = partial(bomb, kind=kind)
    one.__name__ = kind
    damage_content(folder / "shaft.h5", copy, random.Random(1), one)
    assert copy.stat().st_size < 3_000_000
    with pytest.raises(SuperelementError, match=BOMBS[kind]) as caught:
        read_superelement(copy)
    assert str(caught.value).startswith(f"{copy}: ")


def test_links_to_other_files_are_never_opened(folder, tmp_path, monkeypatch):
    """A pipe that nobody writes to would block the first program that opens it."""
    import os

    import h5py

    os.mkfifo(tmp_path / "pipe")
    for kind in ("link", "external", "virtual"):
        copy = tmp_path / f"{kind}.h5"
        content = (folder / "shaft.h5").read_bytes()
        copy.write_bytes(without_seal(content))
        with h5py.File(copy, "r+") as file:
            del file["body/com"]
            if kind == "link":
                file["body/com"] = h5py.ExternalLink("pipe", "/x")
            elif kind == "external":
                file.create_dataset("body/com", shape=(3,), dtype="f8", external=[("pipe", 0, 24)])
            else:
                layout = h5py.VirtualLayout(shape=(3,), dtype="f8")
                layout[:] = h5py.VirtualSource("pipe", "x", shape=(3,))
                file.create_virtual_dataset("body/com", layout)
        with pytest.raises(SuperelementError, match=r"body/com (is a link|keeps its data in)"):
            read_superelement(copy)


def test_no_code_is_ever_read_from_data():
    """No pickle, no eval: nothing that turns bytes of a file into a program."""
    banned_modules = {"pickle", "cPickle", "dill", "shelve", "marshal", "joblib", "yaml"}
    banned_calls = {"eval", "exec", "compile", "__import__"}
    suspects = re.compile(rb"allow_pickle|" + "|".join(banned_modules | banned_calls).encode())
    for folder in ("geometry", "meshing", "reduction", "rotordyn", "solidwhirl"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if not suspects.search(path.read_bytes()):
                continue
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                where = f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"
                if isinstance(node, ast.Import):
                    names = {alias.name.split(".")[0] for alias in node.names}
                    assert not names & banned_modules, where
                if isinstance(node, ast.ImportFrom):
                    assert (node.module or "").split(".")[0] not in banned_modules, where
                if isinstance(node, ast.Call):
                    if isinstance(node.func, ast.Name):
                        assert node.func.id not in banned_calls, where
                    for keyword in node.keywords:
                        allowed = (
                            isinstance(keyword.value, ast.Constant) and not keyword.value.value
                        )
                        assert keyword.arg != "allow_pickle" or allowed, where
