"""Completed stages of runs on disk, found again by what went into them.

An entry is one file, named by the SHA-256 of all that its stage was made from. It is written under
another name and renamed, and holds the SHA-256 of its own content: what is not whole is no entry.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import hmac
import os
import platform
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import metadata, util
from pathlib import Path
from typing import Any

from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.store_codec import CodecError, fingerprint, pack, unpack
from solidwhirl.versions import package_versions

Note = Callable[[str], None]

_MAGIC = b"solidwhirl-stage-1\n"
_DIGEST = 64
_SUFFIX = ".stage"
_LOCK_SUFFIX = ".lock"
# A lock whose file was removed between opening and locking is tried for again so often.
_ATTEMPTS = 1000
# Temporary files of other processes are left alone for this long, in seconds.
_PATIENCE_S = 86_400.0
# How an element was made says nothing about its numbers.
_LEFT_OUT = {"solidwhirl.rotordyn.superelement.Superelement": frozenset({"provenance"})}
# What changes bits besides the packages of `package_versions`.
_MORE_PACKAGES = ("matplotlib", "pydantic", "fenics-ffcx", "fenics-ufl", "fenics-basix")
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_STAGES = ("geometry", "meshing", "reduction", "rotordyn")


class StageStore:
    """A folder of completed stages; several processes may use it at once.

    Parameters
    ----------
    folder
        Made when something is kept first.
    records
        Records that entries may hold, by name.
    """

    def __init__(self, folder: str | Path, records: Mapping[str, type]) -> None:
        self.folder = Path(folder)
        self._records = dict(records)
        self._used: set[str] = set()

    def key(self, stage: str, *parts: Any) -> str:
        """Name of an entry: SHA-256 of the stage, of what goes into it, and of the program.

        Parameters
        ----------
        stage
            What is computed.
        parts
            Everything that the result depends on; where elements came from does not count.
        """
        return fingerprint([stage, surroundings(), list(parts)], _LEFT_OUT)

    def find(self, key: str, note: Note) -> Any | None:
        """Return what is kept under a key; None if there is nothing, or nothing whole.

        Parameters
        ----------
        key
            From `key`.
        note
            Called with one line where an entry is there but is no good; it is removed then.
        """
        path = self._path(key)
        try:
            data = path.read_bytes()
            value = _content(data, key, self._records)
        except FileNotFoundError:
            return None
        except (OSError, MemoryError) as error:
            note(f"{path} can not be read ({error}); the stage is computed again")
            return None
        except CodecError as error:
            note(f"{path} is damaged: {error}; the stage is computed again")
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        self._used.add(key)
        return value

    def keep(self, key: str, stage: str, value: Any, note: Note) -> None:
        """Keep a result; what can not be written is noted and given up.

        Parameters
        ----------
        key
            From `key`.
        stage
            What was computed, for the note.
        value
            The result.
        note
            Called with one line if it can not be kept.
        """
        path = self._path(key)
        self._used.add(key)
        try:
            pieces = pack(value, self._records)
            digest = hashlib.sha256(key.encode("ascii"))
            for piece in pieces:
                digest.update(piece)
            self.folder.mkdir(parents=True, exist_ok=True)
            with replacing(path) as temporary, temporary.open("xb") as file:
                file.write(_MAGIC + digest.hexdigest().encode("ascii") + b"\n")
                for piece in pieces:
                    file.write(piece)
        except OSError as error:
            note(f"{stage} is not kept: {path.parent}: {error.strerror or error}")
        except CodecError as error:
            note(f"{stage} is not kept: {error}")

    @contextmanager
    def alone(self, key: str, note: Note) -> Iterator[None]:
        """Have a stage for this process alone while it is looked for and computed.

        Another process that wants the same stage waits, and finds it kept then. The system gives
        a stage free when the process that has it ends, however it ends. On file systems without
        locks, or where nothing can be written, nobody waits: both compute the same bytes.

        Parameters
        ----------
        key
            From `key`.
        note
            Called with one line if another process has it.
        """
        made = not self.folder.exists()
        path = self.folder / f".{key}{_LOCK_SUFFIX}"
        lock = _lock(path, note)
        try:
            yield
        finally:
            if lock is not None:
                # removed while it is held; who opened it meanwhile sees that it is gone
                with contextlib.suppress(OSError):
                    path.unlink()
                os.close(lock)
            if made:
                with contextlib.suppress(OSError):
                    self.folder.rmdir()  # only if nothing was kept

    def prune(self) -> None:
        """Remove the entries that were neither found nor kept since this store was opened."""
        with contextlib.suppress(OSError):
            for path in self.folder.glob(f"*{_SUFFIX}"):
                if path.stem not in self._used:
                    path.unlink(missing_ok=True)

    def clear_leftovers(self) -> None:
        """Remove temporary files and locks that a killed process left a day ago or earlier."""
        with contextlib.suppress(OSError):
            left = [f".*{_LOCK_SUFFIX}", ".*.tmp", ".writing-*"]
            for path in [p for pattern in left for p in self.folder.glob(pattern)]:
                if time.time() - path.stat().st_mtime <= _PATIENCE_S:
                    continue
                if path.is_dir():
                    shutil.rmtree(path, ignore_errors=True)
                else:
                    path.unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{_SUFFIX}"


class FreshStore(StageStore):
    """A store that keeps results but looks for none."""

    def find(self, key: str, note: Note) -> Any | None:
        """Return None."""
        return None

    @contextmanager
    def alone(self, key: str, note: Note) -> Iterator[None]:
        """Wait for nobody: what others keep is not looked at."""
        yield


def _lock(path: Path, note: Note) -> int | None:
    """Wait until a file is locked, and return it; None where there are no locks."""
    told = False
    for _ in range(_ATTEMPTS):
        file = None
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                if not told:
                    note("another process computes the same stage; this one waits for it")
                told = True
                fcntl.flock(file, fcntl.LOCK_EX)
            if os.fstat(file).st_ino == path.stat().st_ino:
                return file
            os.close(file)  # the holder before removed it between opening and locking
        except BaseException as error:
            if file is not None:
                os.close(file)
            if isinstance(error, FileNotFoundError):
                continue
            if isinstance(error, OSError):
                return None
            raise
    return None


def _content(data: bytes, key: str, records: Mapping[str, type]) -> Any:
    """Value of an entry's bytes."""
    start = len(_MAGIC) + _DIGEST + 1
    if len(data) < start or not data.startswith(_MAGIC) or data[start - 1 : start] != b"\n":
        raise CodecError("it is no entry")
    body = memoryview(data)[start:]
    digest = hashlib.sha256(key.encode("ascii"))
    digest.update(body)
    said = data[len(_MAGIC) : start - 1]
    if not hmac.compare_digest(said, digest.hexdigest().encode("ascii")):
        raise CodecError("its checksum is wrong")
    return unpack(body, records)


@cache
def surroundings() -> Mapping[str, Any]:
    """What else results depend on: program, packages, processor family, threads."""
    more = {}
    for name in _MORE_PACKAGES:
        with contextlib.suppress(metadata.PackageNotFoundError):
            more[name] = metadata.version(name)
    return {
        "program": program_digest(),
        "packages": {**package_versions(), **more},
        "machine": platform.machine(),
        "threads": [os.environ.get(name, "") for name in _THREADS],
    }


@cache
def program_digest() -> str:
    """SHA-256 of the program's own source files."""
    digest = hashlib.sha256()
    for package in ("solidwhirl", *(f"solidwhirl.{stage}" for stage in _STAGES)):
        found = util.find_spec(package)
        assert found is not None
        for folder in found.submodule_search_locations or ():
            for path in sorted(Path(folder).glob("*.py")):
                content = path.read_bytes()
                digest.update(f"{package}/{path.name} {len(content)}\n".encode())
                digest.update(content)
    return digest.hexdigest()
