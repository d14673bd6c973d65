"""The folder of a run: one run at a time, complete or recognisably not, and checkable later."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path, PurePosixPath

from solidwhirl.core.errors import OutputError, clean, writing
from solidwhirl.files.locks import lock_file, release
from solidwhirl.files.picture_index import pictures_listed
from solidwhirl.rotordyn.core.atomic import replace_text

MANIFEST = "SHA256SUMS"
#: Where a run keeps its stages if it is not told another place.
STAGES = ".stages"
#: Rows of a batch, whose folder is none of a run.
JOURNAL = "batch.jsonl"
#: The scene of a run as it was run, options of the command line in it.
SCENE = "scene.json"
# A file that a whole run always has; it is moved into place last.
_LAST = "results.json"
# How it begins, by which it is known where the manifest is lost.
_BEGINNING = re.compile(rb'\s*\{\s*"schema":\s*"solidwhirl-results-')
_REPORTED = (_LAST, "report.md", "report.html")
_LOCK, _MOVING, _SCRATCH = ".lock", ".moving", ".writing-"
_HOLDER = b"process "
# What is in every folder that runs, batches or their pictures have written, half-written ones too.
_OURS = (MANIFEST, STAGES, JOURNAL, _LOCK, _MOVING)
# Names of half-written files of this program.
_TEMPORARY = re.compile(r"\..*[0-9a-f]{32}\.tmp|\.[0-9]+-probe\.tmp")
_LINE = re.compile(r"([0-9a-f]{64}) [ *](.+)")
_PROBE = 1 << 16


@contextmanager
def claimed(out: str | Path, within: Path | None = None) -> Iterator[Path]:
    """Make a folder and have it for this process alone; clear what killed runs left in it.

    The system gives the folder free when the process ends, however it ends.

    `within`: folder of a batch that this is a case of; None: of none, and no folder above may be
    claimed.
    A folder that was made for it and is still empty after it is removed.
    Raises OutputError: another process has the folder or one above it, it can't be written, or it
    is neither empty nor one that this program wrote.
    """
    out = Path(out)
    if within is None:
        _refuse_claimed_above(out)
        refuse_occupied(out)
    missing = [p for p in (out, *out.parents) if not p.exists()]
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
        lock = _locked(out / _LOCK)
    try:
        _clear_leftovers(out)
        yield out
    finally:
        release(out / _LOCK, lock)
        with contextlib.suppress(OSError):
            for folder in missing:
                folder.rmdir()


def refuse_occupied(out: Path, ours: Iterable[str] = _OURS) -> None:
    """Refuse a folder with files of others in it, such as the root of the system.

    `ours`: names of which one is in every folder that this program has written.
    Raises OutputError: it is not empty and has none of them.
    """
    if not out.is_dir() or any(os.path.lexists(out / name) for name in ours):
        return  # if not ours after all, told by what looks at the files themselves
    if _begins_as_results(out / _LAST) or pictures_listed(out):
        return
    with writing(out):
        others = sorted(p.name for p in out.iterdir() if not p.name.startswith(_SCRATCH))
    if others:
        some = ", ".join(others[:3]) + (", ..." if len(others) > 3 else "")
        raise OutputError(
            clean(f"{out}: is not empty ({some}) and no run wrote it; choose a new folder")
        )


def holder_of(folder: Path) -> str:
    """Return what says who has a folder now; empty if nobody has."""
    with contextlib.suppress(OSError):
        file = _regular(folder / _LOCK)
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return _holder(file)
        finally:
            os.close(file)
    return ""


def _refuse_claimed_above(out: Path) -> None:
    for above in out.absolute().parents:
        holder = holder_of(above)
        if holder:
            raise OutputError(
                f"{out}: another run is writing the folder {above} around it ({holder}); wait for "
                "it, end it, or choose another folder"
            )


def _locked(path: Path) -> int:
    """An open file with the lock; says who has it otherwise."""
    in_the_way = OutputError(f"{path}: is in the way and is no file of a run; remove it")
    if os.path.lexists(path) and not _is_regular(path):
        raise in_the_way

    def busy(file: int) -> None:
        raise OutputError(
            f"{path.parent}: another run is writing here ({path}: {_holder(file)}); wait for it, "
            "end it, or choose another folder"
        )

    file = lock_file(path, busy)
    if not _HOLDER.startswith(os.pread(file, len(_HOLDER), 0)):
        os.close(file)
        raise in_the_way
    # only for messages: a full disk must not stop the run here
    with contextlib.suppress(OSError):
        os.ftruncate(file, 0)
        since = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
        os.pwrite(file, f"process {os.getpid()} since {since}".encode(), 0)
    return file


def _holder(file: int) -> str:
    return os.pread(file, 200, 0).decode("utf-8", "replace") or "another process"


def _clear_leftovers(out: Path) -> None:
    """Remove what killed runs were writing."""
    with contextlib.suppress(OSError):
        for folder in (out, out / STAGES):
            for path in folder.glob(f"{_SCRATCH}*"):
                shutil.rmtree(path, ignore_errors=True)
            for path in folder.glob(".*.tmp"):
                if _TEMPORARY.fullmatch(path.name):
                    path.unlink(missing_ok=True)


@contextmanager
def replacing_files(out: Path) -> Iterator[Path]:
    """Give an empty folder whose files take the place of those of the last run, all or none.

    Files of the last run that the new one does not have are removed; files of others stay. A
    manifest of all files is removed before the first is replaced, and there again after the last.

    Yields where to write. Nothing happens to the folder of the run if the block raises.
    Raises OutputError: nothing can be written, as the disk is full, or a file is in the way that no
    run wrote.
    """
    refuse_foreign_results(out)
    with writing(out):
        scratch = Path(tempfile.mkdtemp(prefix=_SCRATCH, dir=out))
    try:
        yield scratch
        _move_into_place(scratch, out)
    except Exception as error:
        # libraries have their own errors for a full disk; asked while it is still full
        problem = writing_problem(out)
        if isinstance(error, OSError):
            problem = problem or error.strerror or str(error).splitlines()[0]
        if problem is None:
            raise
        raise OutputError(f"{out}: can not be written: {problem}") from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def forget_results(out: Path) -> None:
    """Remove the files of the last run, which are not those of what was asked now."""
    before = _written_before(out)
    (out / MANIFEST).unlink(missing_ok=True)
    _remove(out, before)
    (out / _MOVING).unlink(missing_ok=True)


def refuse_foreign(path: Path, words: str, said: str) -> None:
    """Refuse to replace a file that lacks the words by which this program knows its own.

    Raises OutputError: it is there; the message ends with what is `said`.
    """
    try:
        own = path.is_file() and words in path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        own = False
    if os.path.lexists(path) and not own:
        raise OutputError(f"{path}: is there already and {said}")


def reserve(path: Path, size_bytes: int) -> None:
    """Make sure that there is room for a file, by taking and freeing it.

    Libraries that write files in their own ways end in theirs where there is none.

    Raises OSError: there is no room.
    """
    try:
        with path.open("xb") as file:
            os.posix_fallocate(file.fileno(), 0, size_bytes)
    except OSError as error:
        if error.errno not in (errno.EOPNOTSUPP, errno.EINVAL):
            raise
    finally:
        path.unlink(missing_ok=True)


def writing_problem(folder: Path) -> str | None:
    """Say why nothing can be written to a folder that exists, by trying; None if it can."""
    probe = folder / f".{os.getpid()}-probe.tmp"
    try:
        with probe.open("wb") as file:
            file.write(bytes(_PROBE))
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        return error.strerror or str(error)
    finally:
        with contextlib.suppress(OSError):
            probe.unlink(missing_ok=True)
    return None


def _move_into_place(scratch: Path, out: Path) -> None:
    files = sorted(p.relative_to(scratch).as_posix() for p in scratch.rglob("*") if p.is_file())
    sums = {name: _digest(scratch / name) for name in files}
    before = _written_before(out)
    _refuse_in_the_way(out, files, before)
    (scratch / MANIFEST).write_text(_sums_text(sums), encoding="utf-8")
    # what a run that is killed from here on has to do with: the next one clears it
    known = sums | dict.fromkeys(before - set(sums), "0" * 64)
    replace_text(out / _MOVING, _sums_text(known))
    (out / MANIFEST).unlink(missing_ok=True)
    for name in sorted(files, key=lambda n: n == _LAST):
        (out / name).parent.mkdir(exist_ok=True)
        (scratch / name).replace(out / name)
    _remove(out, before - set(sums))
    (scratch / MANIFEST).replace(out / MANIFEST)
    (out / _MOVING).unlink()


def refuse_existing(paths: Iterable[Path], *, force: bool) -> None:
    """Refuse to replace files, unless told to.

    Raises OutputError: one is there, or a folder of its name.
    """
    for path in paths:
        if path.is_dir():
            raise OutputError(f"{path}: can not be written: it is a folder")
        if os.path.lexists(path) and not force:
            raise OutputError(f"{path}: is there already; --force replaces it")


def refuse_foreign_results(out: Path) -> None:
    """Refuse a folder whose results no run wrote, before anything is computed for it.

    Raises OutputError: results or a manifest of somebody else's, or a folder of a run that is a
    link elsewhere.
    """
    if os.path.lexists(out / MANIFEST) and not _is_of_a_run(out / MANIFEST):
        raise _foreign(out / MANIFEST)
    if os.path.lexists(out / JOURNAL):
        raise OutputError(f"{out}: is the folder of a batch; choose another one for a run")
    _refuse_in_the_way(out, _REPORTED, _written_before(out))
    for name in ("bodies", "meshes", STAGES):
        folder = out / name
        if os.path.lexists(folder) and not folder.is_dir():
            raise _foreign(folder)
        if folder.is_symlink() and name != STAGES:
            raise OutputError(f"{folder}: is a link to another place; results are not put there")


def _refuse_in_the_way(out: Path, names: Iterable[str], before: frozenset[str]) -> None:
    """Refuse to replace files that no run wrote, and to write through links to elsewhere."""
    # where the manifest is lost or damaged, all that has a run's name is taken for the run's
    known = _LAST not in _listed(out / MANIFEST) and _begins_as_results(out / _LAST)
    for name in names:
        path = out / name
        if os.path.lexists(path) and not known and name not in before:
            raise _foreign(path)
        if not path.parent.resolve().is_relative_to(out.resolve()):
            raise OutputError(f"{path.parent}: is a link to another place")


def _begins_as_results(path: Path) -> bool:
    try:
        with open(_regular(path), "rb") as file:
            return _BEGINNING.match(file.read(1000)) is not None
    except OSError:
        return False


def _foreign(path: Path) -> OutputError:
    return OutputError(
        f"{path}: is there already and no run wrote it; move it away or choose another folder"
    )


def _is_of_a_run(manifest: Path) -> bool:
    """Whether a manifest can be that of a run, or results of one lie beside it."""
    return _LAST in _listed(manifest) or _begins_as_results(manifest.with_name(_LAST))


def _written_before(out: Path) -> frozenset[str]:
    """Files that runs wrote into a folder, and `pictures` for them."""
    manifest = _listed(out / MANIFEST) if _is_of_a_run(out / MANIFEST) else frozenset()
    return manifest | _listed(out / _MOVING) | pictures_listed(out)


def _remove(out: Path, names: Iterable[str]) -> None:
    """Remove files of an earlier run and folders that they leave empty."""
    for name in names:
        path = out / name
        if path.is_dir() or not path.parent.resolve().is_relative_to(out.resolve()):
            continue  # no run wrote that
        path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            if path.parent != out:
                path.parent.rmdir()


def verify_folder(path: str | Path) -> list[str]:
    """Check the files of a run against its manifest.

    Returns one sentence for each problem; none if the run is complete and nothing was changed
    since.
    """
    folder = Path(path)
    manifest = folder / MANIFEST
    try:
        text = _text(manifest)
    except FileNotFoundError:
        return [f"{manifest}: is missing; the run was not finished"]
    except (OSError, UnicodeDecodeError) as error:
        return [f"{manifest}: can not be read: {error}"]
    sums, problems = _parsed(text)
    found = [f"{manifest}: {problem}" for problem in problems]
    if not problems and _LAST not in sums:
        found.append(f"{manifest}: does not list {_LAST}; it is no manifest of a run, or cut off")
    for name, digest in sums.items():
        file = folder / name
        try:
            if not file.parent.resolve().is_relative_to(folder.resolve()):
                found.append(f"{file}: lies outside the folder, behind a link")
            elif _digest(file) != digest:
                found.append(f"{file}: differs from what the run wrote")
        except FileNotFoundError:
            found.append(f"{file}: is missing")
        except OSError as error:
            found.append(f"{file}: can not be read: {error.strerror or error}")
    return found


def _sums_text(sums: Mapping[str, str]) -> str:
    return "".join(f"{digest}  {name}\n" for name, digest in sums.items())


def _parsed(text: str) -> tuple[Mapping[str, str], list[str]]:
    """Digests by name, and what is wrong with the other lines."""
    sums: dict[str, str] = {}
    problems = []
    if text and not text.endswith("\n"):
        problems.append("its last line is cut off")
    for number, line in enumerate(text.removesuffix("\n").split("\n") if text else (), 1):
        found = _LINE.fullmatch(line)
        if found is None:
            problems.append(f"line {number} is no checksum and name")
        elif not _is_inside(found[2]):
            problems.append(f"line {number} names a file outside the folder")
        else:
            sums[found[2]] = found[1]
    return sums, problems


def _is_inside(name: str) -> bool:
    path = PurePosixPath(name)
    return not path.is_absolute() and ".." not in path.parts and "\0" not in name


def _listed(manifest: Path) -> frozenset[str]:
    """Files of an earlier run; lines that name none are passed over."""
    try:
        return frozenset(_parsed(_text(manifest))[0])
    except (OSError, UnicodeDecodeError):
        return frozenset()


def _is_regular(path: Path) -> bool:
    return stat.S_ISREG(path.lstat().st_mode)


def _regular(path: Path) -> int:
    """Open a file to read; pipes, devices and links are refused without a wait or an effect."""
    if not _is_regular(path):
        raise OSError(errno.EINVAL, "is no regular file")
    return os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)


def _text(path: Path) -> str:
    with open(_regular(path), encoding="utf-8") as file:
        return file.read()


def _digest(path: Path) -> str:
    with open(_regular(path), "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
