"""Limits under which files of others are read."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
import tracemalloc

import pytest

from solidwhirl.rotordyn.core.foreign import Allowance, ForeignError, in_child, regular_bytes

LIMITS = {"seconds": 3, "memory_bytes": 1 << 28, "refused": KeyError}


def test_regular_files_alone_are_read(tmp_path):
    """A pipe that nobody writes to, a link to itself and an endless device end at once."""
    (tmp_path / "file").write_bytes(b"12345")
    assert regular_bytes(tmp_path / "file", 5) == b"12345"
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "circle").symlink_to(tmp_path / "circle")
    (tmp_path / "zero").symlink_to("/dev/zero")
    for name, said in {
        "file": "has 5 bytes, at most 4 are allowed",
        "pipe": "is no regular file",
        "circle": "can not be read: Too many levels",
        "zero": "is no regular file",
        ".": "is no regular file",
        "none": "no such file",
        "a\0b": "can not be read: embedded null",
    }.items():
        with pytest.raises(ForeignError, match=said):
            regular_bytes(tmp_path / name, 4)


def test_no_more_is_allocated_than_a_file_has(tmp_path):
    """Where MPI keeps malloc from giving back, the most allowed at each file filled the memory."""
    (tmp_path / "file").write_bytes(b"12345")
    tracemalloc.start()
    regular_bytes(tmp_path / "file")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1 << 20


def test_work_that_needs_a_child_is_not_done_without_one(monkeypatch):
    def no_memory():
        raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))

    monkeypatch.setattr(os, "fork", no_memory)
    with pytest.raises(ForeignError, match="needs a process of its own: Cannot allocate memory"):
        in_child(lambda: pytest.fail("done in the parent"), **LIMITS)


def test_an_allowance_is_spent():
    allowed = Allowance(10, "numbers")
    allowed.take(6)
    allowed.take(4)
    with pytest.raises(ForeignError, match="makes more than 10 numbers"):
        allowed.take(1)


def test_a_child_gives_its_result_or_its_refusal():
    # more than a pipe holds
    assert in_child(lambda: b"x" * 3_000_000, **LIMITS) == b"x" * 3_000_000
    with pytest.raises(KeyError, match="what is wrong"):
        in_child(lambda: {}["what is wrong"], **LIMITS)
    with pytest.raises(ForeignError, match="can not do with the memory"):
        in_child(lambda: bytes(1 << 30), **LIMITS)
    with pytest.raises(ForeignError, match=r"breaks down on it \(signal 11\)"):
        in_child(lambda: os.kill(os.getpid(), signal.SIGSEGV) or b"", **LIMITS)


def test_a_child_does_nothing_of_its_parents_on_signals():
    """PETSc's handler of crashes called MPI_Abort in the child, which ended the parent with it."""
    before = signal.signal(signal.SIGSYS, lambda *_: os._exit(0))
    try:
        with pytest.raises(ForeignError, match=rf"breaks down on it \(signal {signal.SIGSYS:d}\)"):
            in_child(lambda: os.kill(os.getpid(), signal.SIGSYS) or b"", **LIMITS)
    finally:
        signal.signal(signal.SIGSYS, before)


@pytest.mark.solver
def test_a_parent_with_petsc_outlives_a_child_that_crashes():
    program = """
import os, signal
from petsc4py import PETSc
from solidwhirl.rotordyn.core.foreign import ForeignError, in_child
try:
    in_child(lambda: os.kill(os.getpid(), signal.SIGSEGV) or b"", seconds=3, memory_bytes=1 << 28,
             refused=KeyError)
except ForeignError as error:
    print(error)
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout) == (0, "breaks down on it (signal 11)\n"), done.stderr


def test_a_child_ends_with_its_parent(tmp_path):
    """A parent that is killed leaves nobody at work: the child would write its mark after 1 s."""
    mark, began = tmp_path / "mark", tmp_path / "began"
    program = f"""
import pathlib, time
from solidwhirl.rotordyn.core.foreign import in_child
def late():
    pathlib.Path({str(began)!r}).touch()
    time.sleep(1.0)
    pathlib.Path({str(mark)!r}).touch()
    return b""
in_child(late, seconds=None, memory_bytes=1 << 28, refused=KeyError)
"""
    parent = subprocess.Popen([sys.executable, "-c", program])
    while not began.exists():
        assert parent.poll() is None
        time.sleep(0.01)
    parent.terminate()
    parent.wait()
    time.sleep(1.3)
    assert not mark.exists()
