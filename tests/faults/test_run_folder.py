"""The folder of a run: one run at a time, whole or recognisably not."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from jobs import forked

from solidwhirl.core.errors import OutputError
from solidwhirl.files.run_folder import MANIFEST, claimed, replacing_files, reserve, verify_folder

OLD = {"results.json": "old", "bodies/a.h5": "old a", "bodies/b.h5": "old b", "x.png": "old x"}
NEW = {"results.json": "new", "bodies/a.h5": "new a", "report.md": "new r"}


def write(out, files):
    with claimed(out) as folder, replacing_files(folder) as scratch:
        for name, text in files.items():
            (scratch / name).parent.mkdir(exist_ok=True)
            (scratch / name).write_text(text, encoding="utf-8")


def content(out):
    """Files of the folder by name, the manifest left out."""
    return {
        p.relative_to(out).as_posix(): p.read_text(encoding="utf-8")
        for p in Path(out).rglob("*")
        if p.is_file() and p.name != MANIFEST
    }


def cut_off(out):
    """The manifest without its last sign."""
    path = out / MANIFEST
    path.write_bytes(path.read_bytes()[:-1])


def append(out, line):
    text = (out / MANIFEST).read_text(encoding="utf-8")
    (out / MANIFEST).write_text(text + line, encoding="utf-8")


# -- manifest -------------------------------------------------------------------------------------


def test_manifest_is_that_of_sha256sum(tmp_path):
    write(tmp_path / "out", NEW)
    assert verify_folder(tmp_path / "out") == []
    command = ["sha256sum", "--check", "--strict", MANIFEST]
    said = subprocess.check_output(command, cwd=tmp_path / "out", text=True)
    assert said.count(": OK") == len(NEW)


def test_new_run_takes_the_place_of_the_old_one(tmp_path):
    out = tmp_path / "out"
    write(out, OLD)
    (out / "mine.txt").write_text("mine", encoding="utf-8")
    write(out, NEW)
    assert content(out) == NEW | {"mine.txt": "mine"}
    assert verify_folder(out) == []
    write(out, {"results.json": "last"})
    assert not (out / "bodies").exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda out: (out / "report.md").write_text("new s"), "report.md: differs"),
        (lambda out: (out / "report.md").write_text("new r\n"), "report.md: differs"),
        (lambda out: (out / "bodies" / "a.h5").unlink(), "a.h5: is missing"),
        (lambda out: (out / MANIFEST).unlink(), "the run was not finished"),
        (lambda out: (out / MANIFEST).write_text(""), "does not list results.json"),
        (lambda out: (out / MANIFEST).write_bytes(b"\xff"), "can not be read"),
        (cut_off, "cut off"),
        (lambda out: append(out, "0 x\n"), "no checksum and name"),
        (lambda out: append(out, f"{'0' * 64}  ../x\n"), "outside the folder"),
        (lambda out: append(out, f"{'0' * 64}  /etc/passwd\n"), "outside the folder"),
    ],
)
def test_what_was_changed_is_found(tmp_path, change, said):
    out = tmp_path / "out"
    write(out, NEW)
    change(out)
    found = verify_folder(out)
    assert len(found) == 1
    assert said in found[0]


def test_manifest_that_is_cut_anywhere_is_no_good(tmp_path):
    out = tmp_path / "out"
    write(out, NEW)
    whole = (out / MANIFEST).read_bytes()
    first = whole.index(b"\n", whole.index(b"results.json")) + 1
    assert first == len(whole)  # the last line: every cut loses some of it
    for length in range(len(whole)):
        (out / MANIFEST).write_bytes(whole[:length])
        assert verify_folder(out), length


def test_forged_manifest_removes_nothing_outside(tmp_path):
    (tmp_path / "else").mkdir()
    (tmp_path / "else" / "x").write_text("kept", encoding="utf-8")
    out = tmp_path / "out"
    write(out, NEW)
    (out / "link").symlink_to(tmp_path / "else")
    for name in ("../else/x", str(tmp_path / "else" / "x"), "link/x", "bodies"):
        append(out, f"{'0' * 64}  {name}\n")
    write(out, NEW)
    assert (tmp_path / "else" / "x").read_text(encoding="utf-8") == "kept"
    assert verify_folder(out) == []


# -- broken off -----------------------------------------------------------------------------------


def test_block_that_raises_changes_nothing(tmp_path):
    out = tmp_path / "out"
    write(out, OLD)
    before = content(out)
    for error in (RuntimeError("defect"), KeyboardInterrupt()):
        with pytest.raises(type(error)), claimed(out) as folder, replacing_files(folder) as scratch:
            (scratch / "results.json").write_text("half", encoding="utf-8")
            raise error
        assert content(out) == before
        assert verify_folder(out) == []
    with (
        pytest.raises(OutputError, match="out: can not be written: No space"),
        claimed(out) as folder,
        replacing_files(folder),
    ):
        raise OSError(28, "No space left on device")


def test_killed_at_every_step_of_writing(tmp_path):
    """At each operation on files in turn: never good unless whole; the next run clears it all."""
    out = tmp_path / "out"
    good = 0
    for step in range(1, 200):
        shutil.rmtree(out, ignore_errors=True)
        write(out, OLD)
        ended = forked(step, lambda: write(out, NEW))
        if not verify_folder(out):
            shown = {k: v for k, v in content(out).items() if not k.startswith(".")}
            assert shown in (OLD, NEW), step
            good += 1
        write(out, {"results.json": "next"})
        assert content(out) == {"results.json": "next"}, step
        assert verify_folder(out) == []
        if ended == 0:
            assert step > 30, "the hook saw nothing"
            assert good < step
            return
    raise AssertionError("it never ended")


# -- one at a time --------------------------------------------------------------------------------


def test_second_run_is_refused(tmp_path):
    out = tmp_path / "out"
    with claimed(out), pytest.raises(OutputError) as refused, claimed(out):
        raise AssertionError("two runs in one folder")
    assert f"{out / '.lock'}: process {os.getpid()} since 2" in str(refused.value)
    assert not out.exists()  # made for the run, left empty by it
    write(out, NEW)
    with claimed(out):
        pass
    assert not (out / ".lock").exists()


def test_dead_process_holds_nothing(tmp_path):
    out = tmp_path / "out"
    read, written = os.pipe()
    pid = os.fork()
    if pid == 0:
        with claimed(out):
            os.write(written, b"x")
            signal.pause()
    os.read(read, 1)
    with pytest.raises(OutputError, match=f"process {pid} since"), claimed(out):
        pass
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    assert (out / ".lock").exists()
    (out / ".writing-x").mkdir()
    (out / f".results.json.{'0' * 32}.tmp").write_text("half", encoding="utf-8")
    with claimed(out):
        assert [p.name for p in out.iterdir()] == [".lock"]


def test_many_at_once(tmp_path):
    """Processes that take and leave the folder all the time: never two of them have it."""
    out = tmp_path / "out"
    out.mkdir()
    held = tmp_path / "held"
    pids = []
    for _ in range(4):
        pid = os.fork()
        if pid == 0:
            os._exit(take_often(out, held))
        pids.append(pid)
    assert [os.waitstatus_to_exitcode(os.waitpid(p, 0)[1]) for p in pids] == [0] * 4


def take_often(out, held):
    try:
        for _ in range(150):
            try:
                with claimed(out):
                    held.mkdir()  # fails if another has it
                    held.rmdir()
            except OutputError:
                continue
    except BaseException:
        return 1
    return 0


def test_room_is_asked_for(tmp_path):
    reserve(tmp_path / "x", 1000)
    assert not (tmp_path / "x").exists()
    with pytest.raises(OSError, match=r"No space left|File too large"):
        reserve(tmp_path / "x", 1 << 60)
    assert not (tmp_path / "x").exists()


# -- what is somebody else's ----------------------------------------------------------------------


def _mine(path):
    path.parent.mkdir(exist_ok=True)
    path.write_text("mine", encoding="utf-8")
    return path


FOREIGN = {
    "results": lambda out: _mine(out / "results.json"),
    "a later name": lambda out: _mine(out / "bodies" / "a.h5"),
    "manifest": lambda out: (
        _mine(out / "mine") and (out / MANIFEST).write_text(f"{'0' * 64}  mine\n")
    ),
    "link elsewhere": lambda out: (out / "bodies").symlink_to(
        _mine(out.parent / "else" / "a.h5").parent
    ),
    "link for a file": lambda out: (out / "report.md").symlink_to(_mine(out.parent / "mine")),
    "lock": lambda out: _mine(out / ".lock"),
    "link for a lock": lambda out: (out / ".lock").symlink_to(_mine(out.parent / "mine")),
    "folder": lambda out: (out / "results.json").mkdir(),
}


@pytest.mark.parametrize("what", FOREIGN)
def test_what_no_run_wrote_is_not_replaced(tmp_path, what):
    out = tmp_path / "out"
    out.mkdir()
    FOREIGN[what](out)
    before = content(tmp_path)
    with pytest.raises(OutputError, match=r"no run wrote it|link to another|no file of a run"):
        write(out, NEW)
    assert content(tmp_path) == before


def test_temporary_files_of_others_stay(tmp_path):
    write(tmp_path, NEW)
    (tmp_path / ".mine.tmp").write_text("mine", encoding="utf-8")
    with claimed(tmp_path):
        pass
    assert content(tmp_path) == NEW | {".mine.tmp": "mine"}


@pytest.mark.parametrize("name", ["notes.txt", "results.json", ".profile", "bodies/shaft.h5"])
def test_folder_of_others_is_refused_before_anything_is_written(tmp_path, name):
    """Whatever one file is called; a folder with a lock, a store or a manifest is that of a run."""
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="is not empty"), claimed(tmp_path):
        pass
    assert content(tmp_path) == {name: "mine"}
    (tmp_path / ".stages").mkdir()
    with claimed(tmp_path):
        pass


@pytest.mark.parametrize("damage", [lambda m: m.unlink(), lambda m: m.write_text("0 x\n")])
def test_run_whose_manifest_is_lost_is_replaced(tmp_path, damage):
    old = OLD | {"results.json": '{\n "schema": "solidwhirl-results-1"\n}\n'}
    write(tmp_path, old)
    damage(tmp_path / MANIFEST)
    write(tmp_path, NEW)
    assert verify_folder(tmp_path) == []


def _replaced(path, by):
    """Put something else in the place of a file or folder."""
    moved = shutil.move(path, path.parents[1] / path.name)
    os.mkfifo(path) if by == "pipe" else path.symlink_to("/dev/zero" if by == "device" else moved)


@pytest.mark.parametrize(
    ("name", "by"),
    [(name, by) for name in ("report.md", MANIFEST) for by in ("pipe", "device")]
    + [("bodies", "link")],
)
def test_pipes_devices_and_links_are_not_read(tmp_path, name, by):
    out = tmp_path / "out"
    write(out, NEW)
    _replaced(out / name, by)
    (found,) = verify_folder(out)
    assert "no regular file" in found or "behind a link" in found


def test_folder_inside_one_that_is_claimed_is_refused(tmp_path):
    """That of a case in the folder of a batch that runs; its own cases are let in."""
    with claimed(tmp_path / "batch") as batch:
        with pytest.raises(OutputError, match="is writing the folder"), claimed(batch / "a"):
            pass
        with claimed(batch / "a", within=batch):
            pass
    with claimed(tmp_path / "batch" / "a"):
        pass
