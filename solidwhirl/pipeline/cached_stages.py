"""Stages of a run that are taken from a store where they are there, and kept where they are not."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

from solidwhirl.cache.codec import fingerprint
from solidwhirl.cache.files import FreshStore, StageStore
from solidwhirl.core.outcome import Outcome, Write
from solidwhirl.core.stages import Progress
from solidwhirl.files.run_folder import writing_problem
from solidwhirl.model.static_loads import load_case
from solidwhirl.scene.records import Scene, without_folders

Origin = Literal["computed", "kept"]
# Parts of a scene that no number of its engine depends on; analyses stand for themselves.
_WORDS = frozenset({"name", "title", "notes", "operating", "analyses", "references", "sweep"})


open_store, open_fresh_store = StageStore, FreshStore


def engine_part(scene: Scene) -> dict[str, Any]:
    """The parts of a scene that numbers of its engine depend on.

    Its analyses are left out, but for one whose loads coefficients of bearings are taken at.
    """
    parts = {n: getattr(scene, n) for n in type(scene).model_fields if n not in _WORDS}
    case = load_case(scene)
    loads = {} if case is None else {"static_loads": case}
    return {**parts, **loads, **without_folders(scene)}


@dataclass(frozen=True, kw_only=True, eq=False)
class StageCache:
    """What a run asks for its stages."""

    #: Where they are kept; None: nowhere
    store: StageStore | None
    progress: Progress
    #: Where each stage came from, filled as the run goes on; empty without a store
    origins: dict[str, Origin] = field(default_factory=dict)

    def key(self, stage: str, *parts: Any) -> str:
        """Key of a stage by what goes into it; nothing without a store."""
        return "" if self.store is None else self.store.key(stage, *parts)

    def digest(self, value: Any) -> str:
        """Key of a value that goes into several stages; nothing without a store."""
        return self.key("value", value)

    def same(self, first: Any, second: Any) -> bool:
        """Whether two values are the same; without a store only if they are one."""
        if first is second:
            return True
        return self.store is not None and fingerprint(first) == fingerprint(second)

    def find(self, key: str) -> Any | None:
        """What is kept under a key, or None."""
        return None if self.store is None else self.store.find(key, self.progress)

    def keep(self, key: str, stage: str, value: Any) -> None:
        """Keep a value."""
        if self.store is not None:
            self.store.keep(key, stage, value, self.progress)

    def alone(self, key: str) -> AbstractContextManager[None]:
        """Have a stage for this process alone, see `StageStore.alone`."""
        return nullcontext() if self.store is None else self.store.alone(key, self.progress)

    def say(self, stage: str, origin: Origin) -> None:
        """Write down where a stage came from; further ones of the same name are numbered."""
        if self.store is None:
            return
        name, number = stage, 1
        while name in self.origins:
            number += 1
            name = f"{stage} ({number})"
        self.origins[name] = origin

    def stage(self, name: str, key: str, compute: Callable[[], Any]) -> Any:
        """The value of a stage, kept or computed."""
        with self.alone(key):
            found = self.find(key)
            self.say(name, "computed" if found is None else "kept")
            if found is None:
                found = compute()
                self.keep(key, name, found)
        return found

    def analysis(self, label: str, key: str, compute: Callable[[], Outcome]) -> Outcome:
        """An analysis of a name, kept or computed, with its files."""
        if self.store is None:
            return compute()
        name = f"analysis {label}"
        with self.alone(key):
            kept = self.find(key)
            self.say(name, "computed" if kept is None else "kept")
            if kept is None:
                found = compute()
                contents = self._contents(name, found)
                if contents is None:
                    return found
                kept = (replace(found, files={}), contents)
                self.keep(key, name, kept)
        outcome, contents = kept
        return replace(outcome, files={f: partial(_written, data) for f, data in contents.items()})

    def _contents(self, name: str, outcome: Outcome) -> dict[str, bytes] | None:
        """Content of the files of an analysis; None if they can't be written."""
        assert self.store is not None
        data: dict[str, bytes] = {}
        try:
            self.store.folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix=".writing-", dir=self.store.folder) as scratch:
                for file, write in outcome.files.items():
                    write(Path(scratch) / file)
                    data[file] = (Path(scratch) / file).read_bytes()
        except Exception as error:
            # libraries have their own errors for a full disk
            problem = writing_problem(self.store.folder)
            if problem is None and not isinstance(error, OSError):
                raise
            self.progress(f"{name} is not kept: {problem or error}")
            return None
        return data

    def picture_of(self, analysis: str, title: str, file: str, draw: Write) -> Write:
        """A function that writes a picture of an analysis of a key."""
        return self.picture(self.key("picture", analysis, title, file), draw)

    def picture(self, key: str, draw: Write) -> Write:
        """A function that writes a picture, from the store or by drawing it."""
        return KeptPicture(stage_cache=self, key=key, draw=draw)


@dataclass(frozen=True, kw_only=True, eq=False)
class KeptPicture:
    """Writes a picture, from the store or by drawing it.

    Each format of a picture is kept by itself: the ending of the file tells it.
    """

    stage_cache: StageCache
    key: str
    draw: Write

    def __call__(self, path: Path) -> None:
        """Write the picture to a file."""
        kept = self.find(path)
        if kept is None:
            self.draw(path)
            self.stage_cache.keep(self._own(path), path.name, path.read_bytes())
        else:
            path.write_bytes(kept)

    def find(self, path: Path) -> bytes | None:
        """The content of the file, or None where it is to be drawn."""
        return self.stage_cache.find(self._own(path))

    def _own(self, path: Path) -> str:
        return self.stage_cache.key("format of a picture", self.key, path.suffix)


def _written(data: bytes, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
