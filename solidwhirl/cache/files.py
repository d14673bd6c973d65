"""Completed stages of runs on disk, found again by what went into them.

An entry is one file, named by the SHA-256 of all that its stage was made from. It is written under
another name and renamed, and holds the SHA-256 of its own content: what is not whole is no entry.
"""

from __future__ import annotations

import contextlib
import hashlib
import hmac
import os
import platform
import shutil
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import contextmanager
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from solidwhirl.cache.codec import PACKAGES, CodecError, Seen, fingerprint, pack, unpack
from solidwhirl.core.versions import package_versions, program_digest
from solidwhirl.files.locks import lock_file, release
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.foreign import ForeignError, refuse_irregular

Note = Callable[[str], None]

_MAGIC = b"solidwhirl-stage-1\n"
_DIGEST = 64
_SUFFIX = ".stage"
_LOCK_SUFFIX = ".lock"
# Temporary files of other processes are left alone for this long, in seconds.
_PATIENCE_S = 86_400.0
# Room for entries that the last run had no use for.
_ROOM_BYTES = 200_000_000
_ELEMENT = "solidwhirl.rotordyn.superelement.record.Superelement"
# How an element was made says nothing about its numbers.
_SEEN = Seen(
    left_out={_ELEMENT: frozenset({"provenance"})},
    large=frozenset({_ELEMENT, "solidwhirl.meshing.records.Mesh"}),
)
# What changes bits besides the packages of `package_versions`.
_MORE_PACKAGES = ("matplotlib", "pydantic", "fenics-ffcx", "fenics-ufl", "fenics-basix")
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class StageStore:
    """A folder of completed stages; several processes may use it at once.

    `folder`: made when something is kept first. `packages`: whose frozen dataclasses entries may
    hold.
    """

    def __init__(self, folder: str | Path, packages: Set[str] = PACKAGES) -> None:
        self.folder = Path(folder)
        self._packages = packages
        self._used: set[str] = set()

    def key(self, stage: str, *parts: Any) -> str:
        """Name of an entry: SHA-256 of the stage, of what goes into it, and of the program.

        `parts`: everything that the result depends on; where elements came from does not count.
        """
        return fingerprint([stage, surroundings(), list(parts)], _SEEN)

    def find(self, key: str, note: Note) -> Any | None:
        """Return what is kept under a key; None if there is nothing, or nothing whole.

        `note`: called with one line where an entry is there but is no good; it is removed then.
        """
        path = self._path(key)
        try:
            if path.exists():
                refuse_irregular(path)  # a pipe would be waited for
            data = path.read_bytes()
            value = _content(data, key, self._packages)
        except FileNotFoundError:
            return None
        except (OSError, MemoryError, ForeignError) as error:
            note(f"{path} can not be read ({error}); the stage is computed again")
            return None
        except CodecError as error:
            note(f"{path} is damaged: {error}; the stage is computed again")
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        self._used.add(key)
        with contextlib.suppress(OSError):
            os.utime(path)
        return value

    def keep(self, key: str, stage: str, value: Any, note: Note) -> None:
        """Keep a result; what can not be written is noted and given up.

        `note`: called with one line if it can not be kept.
        """
        path = self._path(key)
        self._used.add(key)
        try:
            pieces = pack(value, self._packages)
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

        `note`: called with one line if another process has it.
        """
        made = not self.folder.exists()
        path = self.folder / f".{key}{_LOCK_SUFFIX}"
        wait = "another process computes the same stage; this one waits for it"
        lock = None
        with contextlib.suppress(OSError):
            lock = lock_file(path, lambda _: note(wait))
        try:
            yield
        finally:
            if lock is not None:
                release(path, lock)
            if made:
                with contextlib.suppress(OSError):
                    self.folder.rmdir()  # only if nothing was kept

    def prune(self, room_bytes: int = _ROOM_BYTES) -> None:
        """Remove entries that were neither found nor kept since this store was opened.

        Of these, the ones that were used last stay as far as there is room: who tries a value often
        goes back to the one before.
        """
        with contextlib.suppress(OSError):
            others = [p for p in self.folder.glob(f"*{_SUFFIX}") if p.stem not in self._used]
            found = {path: path.stat() for path in others}
            for path in sorted(others, key=lambda p: found[p].st_mtime, reverse=True):
                room_bytes -= found[path].st_size
                if room_bytes < 0:
                    path.unlink(missing_ok=True)

    def remove(self) -> None:
        """Remove all entries, and the folder if nothing else is in it."""
        with contextlib.suppress(OSError):
            for path in self.folder.glob(f"*{_SUFFIX}"):
                path.unlink(missing_ok=True)
            self.folder.rmdir()

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


class MemoryStore(StageStore):
    """A store in the memory of one process.

    `most`: entries that stay, those that were used last; None: all.
    """

    def __init__(self, most: int | None = None) -> None:
        super().__init__("")
        self._values: dict[str, Any] = {}
        self._most = most
        self._lock = threading.Lock()

    def find(self, key: str, note: Note) -> Any | None:
        """Return what is kept under a key, or None."""
        with self._lock:
            found = self._values.pop(key, None)
            if found is not None:
                self._values[key] = found  # the last one now
        return found

    def keep(self, key: str, stage: str, value: Any, note: Note) -> None:
        """Keep a result, which nobody changes."""
        with self._lock:
            self._values[key] = value
            while self._most is not None and len(self._values) > self._most:
                del self._values[next(iter(self._values))]

    @contextmanager
    def alone(self, key: str, note: Note) -> Iterator[None]:
        """Wait for nobody."""
        yield


def _content(data: bytes, key: str, packages: Set[str]) -> Any:
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
    return unpack(body, packages)


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
