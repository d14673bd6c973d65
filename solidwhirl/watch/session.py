"""What is shown now: reduced bodies, positions of the sliders, and the threads that follow them."""

from __future__ import annotations

import json
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from solidwhirl.console.guard import user_message
from solidwhirl.core.errors import USER_ERRORS, KeyPath, SceneError, UserError
from solidwhirl.reduced_scene import ReducedScene
from solidwhirl.scene_reading.lines import with_lines
from solidwhirl.watch.diagram import (
    Diagram,
    diagram_content,
    diagram_of,
    drawing_of,
    is_asymmetric,
    quick_diagram,
)
from solidwhirl.watch.newest import Newest
from solidwhirl.watch.sliders import Controls, controls_of, scene_at

#: What is kept in memory of places where sliders rested
RESTS = 100
# A slider that has not moved for this long rests.
_REST_S = 0.3
# Bodies whose picture takes longer are shown only when sliders rest.
_SLOW_S = 2.0
_ENDING_S = 3.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Shown:
    """Reduced bodies of a scene, and the content of its file that sliders start from."""

    reduced: ReducedScene
    data: Mapping[str, Any]
    #: How the bodies are modelled, in words
    level: str
    #: Whether better bodies of the same file are on their way
    is_preliminary: bool = False
    #: What the page has to say of it
    remarks: tuple[str, ...] = ()

    @cached_property
    def controls(self) -> Controls:
        """The sliders."""
        return controls_of(self.data)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Wanted:
    """A picture to compute: the bodies, positions of sliders, and whether one moves."""

    shown: Shown
    positions: Mapping[str, float]
    is_moving: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class _Rested:
    """A whole picture whose errors are to be estimated."""

    wanted: _Wanted
    reduced: ReducedScene
    diagram: Diagram


class Source(Protocol):
    """Where a scene comes from, and where its numbers go."""

    #: The file, and whether the page asks for the name of another one to write
    path: Path
    writes_new_file: bool

    def start(self, session: Session) -> None:
        """Show the scene in a session, and what comes of it later."""

    def write(self, numbers: Mapping[KeyPath, float], name: str) -> str:
        """Write numbers of the scene file; returns what was done.

        Raises UserError, OSError: nothing was written.
        """

    def end(self, patience_s: float) -> bool:
        """Begin nothing more; whether the work ended in time."""


class Session:
    """A scene that is watched.

    `tell`: called from any thread with the text of each message to the page, JSON with its `kind`.
    The last one of each kind is kept for pages that come later.
    """

    def __init__(self, source: Source, tell: Callable[[str], None]) -> None:
        self._source = source
        self._tell = tell
        self._lock = threading.Lock()
        self._messages: dict[str, str] = {}
        self._shown: Shown | None = None
        self._positions: dict[str, float] = {}
        self._slow: Shown | None = None  # of which a picture takes long
        self._pictures = Newest(self._draw, "pictures")
        self._errors = Newest(self._estimate, "error bands")

    def start(self) -> None:
        """Begin to show."""
        self._say("source", file=str(self._source.path), asks_name=self._source.writes_new_file)
        self._pictures.start()
        self._errors.start()
        self._source.start(self)

    def end(self) -> bool:
        """Begin nothing more; whether all work ended within seconds."""
        ends = [part.end(_ENDING_S) for part in (self._source, self._pictures, self._errors)]
        return all(ends)

    def messages(self) -> list[str]:
        """Return what a page that opens now has to know."""
        with self._lock:
            return list(self._messages.values())

    # -- asked by the source of the scene --------------------------------------------------------

    def show(self, shown: Shown) -> None:
        """Show bodies; positions of sliders stay where the file says the same as before."""
        with self._lock:
            before, self._shown = self._shown, shown
            if before is None or before.data != shown.data:
                self._positions = {}
            wanted = _Wanted(shown=shown, positions=dict(self._positions), is_moving=False)
            scene = self._messages["scene"] = self._scene_message()
        self._tell(scene)
        self._say("drawing", svg=drawing_of(shown.reduced))
        self._say("problems", problems=[])
        self._pictures.ask(wanted)

    def say_doing(self, text: str) -> None:
        """Say what is being computed; empty: nothing."""
        self._say("doing", text=text)

    def refuse(self, error: Exception) -> None:
        """Show what is wrong with the file; the last picture stays."""
        self._say("problems", problems=_problems(self._source.path, error))

    # -- asked by the page -----------------------------------------------------------------------

    def move(self, positions: Mapping[str, Any]) -> None:
        """Take positions of sliders by name; what is no slider or no number is left out."""
        with self._lock:
            if self._shown is None:
                return
            known = {s.name for s in self._shown.controls.sliders}
            self._positions = {
                name: float(value)
                for name, value in positions.items()
                if name in known
                and isinstance(value, int | float)
                and abs(value) <= sys.float_info.max
            }
            wanted = _Wanted(shown=self._shown, positions=dict(self._positions), is_moving=True)
            self._messages["scene"] = self._scene_message()  # of pages that come later
        self._pictures.ask(wanted)

    def write(self, name: str) -> None:
        """Write the positions of the sliders into the file, or a new one of a name."""
        with self._lock:
            shown = self._shown
            numbers = {} if shown is None else shown.controls.moved(self._positions)
        try:
            if not numbers:
                raise UserError("no slider has moved; nothing to write")
            said, is_done = self._source.write(numbers, name), True
        except (UserError, OSError) as error:
            said, is_done = str(error), False
        self._say("written", text=said, done=is_done, keep=False)

    # -- threads ---------------------------------------------------------------------------------

    def _draw(self, wanted: _Wanted) -> None:
        """Compute a picture: at once a quick one, the whole one as soon as nothing moves."""
        try:
            started = time.perf_counter()
            reduced = self._at(wanted)
            is_even = not is_asymmetric(reduced)
            is_slow = not is_even or self._slow is wanted.shown
            if wanted.is_moving and not is_slow:
                self._say_picture(wanted, quick_diagram(reduced), "moving", started)
            if wanted.is_moving and self._pictures.is_outdated(_REST_S):
                return
            if is_slow:
                self.say_doing("Campbell diagram")
            started = time.perf_counter()
            diagram = diagram_of(reduced)
            is_estimated = reduced.scene.model.estimates == "on" and is_even
            self._say_picture(wanted, diagram, "waiting" if is_estimated else "whole", started)
            if is_slow:
                self.say_doing("")
            if is_estimated:
                self._errors.ask(_Rested(wanted=wanted, reduced=reduced, diagram=diagram))
        except Exception as error:
            self.say_doing("")
            self._say("refused", problems=_problems(self._source.path, error))

    def _estimate(self, rested: _Rested) -> None:
        try:
            started = time.perf_counter()
            found = replace(rested.diagram, estimates=rested.reduced.estimates())
        except Exception as error:
            self._say("refused", problems=_problems(self._source.path, error))
            return
        with self._lock:
            now = (self._shown, self._positions)
        if now == (rested.wanted.shown, rested.wanted.positions):
            self._say_picture(rested.wanted, found, "whole", started)

    def _at(self, wanted: _Wanted) -> ReducedScene:
        """The bodies on the supports that the sliders say."""
        reduced = wanted.shown.reduced
        numbers = wanted.shown.controls.moved(wanted.positions)
        if not numbers:
            return reduced
        return reduced.in_scene(scene_at(reduced.scene, wanted.shown.data, numbers))

    def _scene_message(self) -> str:
        """What the page knows of the scene and its sliders, where they are now; with the lock."""
        assert self._shown is not None
        scene, controls = self._shown.reduced.scene, self._shown.controls
        return _text(
            "scene",
            {
                "title": scene.title or scene.name,
                "remarks": self._shown.remarks,
                "sliders": [slider.document() for slider in controls.sliders],
                "fixed": controls.fixed,
                "positions": self._positions,
            },
        )

    def _say_picture(self, wanted: _Wanted, diagram: Diagram, stage: str, started: float) -> None:
        content = diagram_content(diagram)
        seconds = time.perf_counter() - started
        if seconds > _SLOW_S and not diagram.estimates:
            self._slow = wanted.shown
        self._say("refused", problems=[])
        self._say(
            "picture",
            stage=stage,
            level=wanted.shown.level,
            preliminary=wanted.shown.is_preliminary,
            positions=dict(wanted.positions),
            seconds=round(seconds, 3),
            **content,
        )

    def _say(self, kind: str, *, keep: bool = True, **content: Any) -> None:
        """Tell all pages, and keep it for others unless it is said once."""
        text = _text(kind, content)
        if keep:
            with self._lock:
                self._messages[kind] = text
        self._tell(text)


def remarks_on(
    reduced: ReducedScene, without_bands: str = "No error bands: error estimates are off."
) -> tuple[str, ...]:
    """Return what the page does not show of a scene, or slower, and why.

    `without_bands`: what to say where nothing can be estimated.
    """
    scene, found = reduced.scene, []
    if is_asymmetric(reduced):
        found.append(
            "A body is asymmetric: the picture follows when the sliders rest, and has "
            "no error bands."
        )
    elif scene.model.estimates == "off":
        found.append(without_bands)
    if scene.analyses:
        kinds = ", ".join(dict.fromkeys(a.kind for a in scene.analyses))
        found.append(f"Not shown here: analyses ({kinds}); a run computes them.")
    if not scene.bearings:
        found.append("There is no bearing to move.")
    return tuple(found)


def _text(kind: str, content: Mapping[str, Any]) -> str:
    return json.dumps({"kind": kind, **content}, ensure_ascii=False, allow_nan=False)


def _problems(path: Path, error: Exception) -> list[dict[str, Any]]:
    """What is wrong, line by line, with its place in the file and what stands there."""
    if isinstance(error, SceneError):
        # a scene that has been changed is named by its name, not by its file
        found = with_lines(SceneError(path, error.problems, error.places))
    elif isinstance(error, USER_ERRORS):
        found = with_lines(SceneError(path, [str(error)]))
    else:
        said = user_message(path, error)
        if said is None:
            traceback.print_exception(error)
            said = f"the program failed: {type(error).__name__}: {error} (see the terminal)"
        found = SceneError(path, [said.removeprefix(f"{path}: ")])
    lines = _lines(path)
    problems = []
    for problem, place in zip(found.problems, found.places, strict=True):
        line = place.partition(":")[0]
        source = lines[int(line) - 1] if line and int(line) <= len(lines) else ""
        problems.append({"place": place, "line": line, "text": str(problem), "source": source})
    return problems


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
