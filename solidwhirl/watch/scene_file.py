"""A scene file that is followed: read when it is saved, reduced again only where it must be."""

from __future__ import annotations

import contextlib
import fcntl
import os
import signal
import threading
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from solidwhirl.cache.files import MemoryStore, StageStore
from solidwhirl.core.errors import USER_ERRORS, KeyPath, SceneError, UserError
from solidwhirl.core.stages import Stage, silent
from solidwhirl.model.imported_bodies import files_of
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.reduced_scene import ReducedScene, reduce_scene
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import files_named, parse_scene, parse_toml, read_bytes
from solidwhirl.scene_reading.toml_numbers import with_numbers
from solidwhirl.watch.newest import Newest
from solidwhirl.watch.session import RESTS, Session, Shown, remarks_on

# How often the file is looked at. What is wrong in it is shown if it stays as long: it may be half
# written.
_EVERY_S = 0.2
# How many times it may be missing: some editors move a new one into its place.
_MISSING = 5
# How long a write waits for other programs to close the file.
_PATIENCE_S = 2.0


class _OutdatedError(Exception):
    """The file has changed while bodies of its last content were reduced."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Read:
    content: bytes
    data: Mapping[str, Any]
    scene: Scene


class SceneFile:
    """A file that is read again whenever it, or a file that it reads, is saved.

    `store`: folder where completed stages are kept.
    """

    writes_new_file = False

    def __init__(self, path: Path, store: Path) -> None:
        self.path = path
        self._store = StageStore(store)
        self._reader = Newest(self._take, "bodies")
        self._follower = threading.Thread(target=self._follow, name="file", daemon=True)
        self._ended = threading.Event()
        self._rests = MemoryStore(most=RESTS)
        self._beside: dict[Path, Any] = {}  # what other files were like when they were read
        self._last: _Read | None = None  # that is shown
        self._reduced: ReducedScene | None = None  # on the level of its scene

    def start(self, session: Session) -> None:
        """Show the file in a session, and follow it from now on."""
        self._session = session
        self._reader.start()
        self._follower.start()

    def end(self, patience_s: float) -> bool:
        """Follow no more; whether the work ended in time."""
        self._ended.set()
        return self._reader.end(patience_s)

    def write(self, numbers: Mapping[KeyPath, float], name: str) -> str:
        """Write other numbers into the file, all else as it is; returns what was done.

        Raises UserError, OSError: it has changed since it was read, or can't be written.
        """
        path = self.path.resolve()  # of a link what it leads to
        last = self._last
        if last is None:
            raise UserError(f"{self.path}: has not been read yet; nothing was written")
        try:
            text = with_numbers(last.content.decode("utf-8"), numbers)
        except ValueError as error:
            raise UserError(f"{self.path}: {error}; nothing was written") from error
        if not _rewritten(path, last.content, text.encode("utf-8")):
            raise UserError(f"{self.path}: has changed meanwhile; nothing was written")
        return f"{len(numbers)} number{'s' * (len(numbers) > 1)} written to {self.path}"

    def _follow(self) -> None:
        """Look at the files until the end; when one changes, the other thread gets the content."""
        seen, content, missing = None, b"", 0
        while True:
            try:
                now, beside = _mark(self.path.stat()), _marks(self._beside)
                is_other = beside != self._beside
                if now != seen or is_other:
                    fresh = read_bytes(self.path)
                    if seen is None or missing > _MISSING or fresh != content or is_other:
                        self._beside = beside
                        self._reader.ask(fresh)
                    seen, content = now, fresh
                missing = 0
            except (OSError, SceneError) as error:
                missing += 1
                if missing == _MISSING:
                    why = getattr(error, "strerror", None) or str(error)
                    self._session.refuse(SceneError(self.path, [f"can not be read: {why}"]))
                    seen = None
            if self._ended.wait(_EVERY_S):
                return

    def _take(self, content: bytes) -> None:
        """Show what a content of the file says, or what is wrong in it."""
        try:
            data = parse_toml(content, self.path)
            self._beside = _marks(files_named(data, self.path.parent))
            scene = parse_scene(data, self.path)
            further = (file for spec in scene.imported.values() for file in files_of(spec))
            self._beside = _marks(further) | self._beside
            self._show(_Read(content=content, data=data, scene=scene))
        except _OutdatedError:
            return
        except Exception as error:
            if not self._reader.is_outdated(_EVERY_S + 0.1):
                self._session.refuse(error)
        self._session.say_doing("")

    def _show(self, read: _Read) -> None:
        """Show a scene with the bodies that are there, or beams first and its own bodies then."""
        if self._reduced is not None:
            with contextlib.suppress(SceneError):
                self._put(read, self._reduced.in_scene(read.scene))
                return
        beams = _as_beams(read.scene)
        if beams is not None:
            # why bodies can be no beams is of no interest; what else is wrong, the others say too
            with contextlib.suppress(*USER_ERRORS):
                self._put(read, reduce_scene(beams, progress=self._progress), preliminary=True)
        self._put(read, reduce_scene(read.scene, progress=self._progress, store=self._store))

    def _put(self, read: _Read, reduced: ReducedScene, *, preliminary: bool = False) -> None:
        # from here on sliders ask, not this thread
        cache = StageCache(store=self._rests, progress=silent)
        reduced = reduced.with_job(replace(reduced.reduced.job, stage_cache=cache))
        levels = ", ".join(dict.fromkeys(e.level for e in reduced.reduced.elements.values()))
        self._last = read
        if not preliminary:
            self._reduced = reduced
        self._session.show(
            Shown(
                reduced=reduced,
                data=read.data,
                level="beams" if preliminary else levels,
                is_preliminary=preliminary,
                remarks=() if preliminary else remarks_on(reduced),
            )
        )

    def _progress(self, event: Stage | str) -> None:
        """Tell the page; end here what nobody wants any more."""
        if self._reader.is_outdated():
            raise _OutdatedError
        self._session.say_doing(str(event))


def _rewritten(path: Path, before: bytes, after: bytes) -> bool:
    """Write a file in place if it still has the content `before`; whether it was so.

    Owner, permissions and hard links stay. A lease on the file makes programs that begin to open it
    wait, and is given only while none has it open, so that no edit is overwritten; where the file
    system has no leases, only what was saved before the comparison is safe.

    Raises UserError: read-only, or open in another program for `_PATIENCE_S`; OSError: as it says.
    """
    if not path.stat().st_mode & 0o222:  # root may write all the same
        raise UserError(f"{path}: is read-only; nothing was written")
    file = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        _lease(file, path)
        opened, content = os.fstat(file), os.pread(file, len(before) + 1, 0)
        if content != before or not os.path.samestat(opened, path.stat()):
            return False
        try:
            os.pwrite(file, after, 0)
            os.ftruncate(file, len(after))
            os.fsync(file)
        except OSError:
            os.pwrite(file, before, 0)  # a full disk has room for what was there
            os.ftruncate(file, len(before))
            raise
        # an editor may have moved a new file into the place of this one
        return os.path.samestat(opened, path.stat())
    finally:
        os.close(file)


def _lease(file: int, path: Path) -> None:
    """Have nobody else open a file until it is closed; see `_rewritten`."""
    deadline = time.monotonic() + _PATIENCE_S
    # the usual signal for a lease that somebody waits for would end the program
    fcntl.fcntl(file, fcntl.F_SETSIG, signal.SIGURG)
    while True:
        try:
            fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_WRLCK)
            return
        except BlockingIOError as error:
            if time.monotonic() > deadline:
                said = "is open in another program, whose edit could be lost; nothing was written"
                raise UserError(f"{path}: {said}") from error
            time.sleep(0.01)
        except OSError:  # the file system has none
            return


def _mark(found: os.stat_result) -> tuple[int, ...]:
    """What changes when a file is saved."""
    return found.st_mtime_ns, found.st_size, found.st_ino


def _marks(files: Iterable[Path]) -> dict[Path, tuple[int, ...] | None]:
    """Marks of files; None of those that are not there."""
    marks: dict[Path, tuple[int, ...] | None] = {}
    for file in files:
        try:
            marks[file] = _mark(file.stat())
        except OSError:
            marks[file] = None
    return marks


def _as_beams(scene: Scene) -> Scene | None:
    """The scene with beams for its bodies, without estimates; None where there are none."""
    if not scene.bodies or scene.mesh_bodies or scene.model.level == "beam":
        return None
    model = scene.model.model_copy(update={"level": "beam", "estimates": "off"})
    return scene.model_copy(update={"model": model})
