"""Messages about a file that a user wrote, with the line and column they are about."""

from __future__ import annotations

import re
import stat
import tomllib
from pathlib import Path

from solidwhirl.errors import SceneError
from solidwhirl.scene_entries import entry_path
from solidwhirl.scene_file import shown_key
from solidwhirl.toml_places import Part, Places, Position

_LARGEST_BYTES = 4_000_000
_STEP = re.compile(r"\.?([A-Za-z0-9_-]+)|\.?('(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\")|\[(\d+)\]")
# What follows the key in a message.
_AFTER = (":", " (", ".kind:")
_SYNTAX = re.compile(r" ?\(at line (\d+), column (\d+)\)$")
_AT_END = re.compile(r" ?\(at end of document\)$")
_LINE = re.compile(r"line (\d+): ")
_BODY = re.compile(r"(bodies|mesh_bodies|beams)\.([\w-]+): ")
# What tomllib says behind the whole part of a number with a decimal comma, and the text there.
_BEHIND_NUMBER = (
    ("Expected newline or end of document", re.compile(r"\d$"), re.compile(r",\d")),
    ("Expected '=' after a key", re.compile(r"\d,\d[\w+-]*\s*$"), re.compile("")),
)
_COMMA = "; a decimal point is wanted, not a comma"
_BYTE = re.compile(r"is not UTF-8 text \(byte (\d+)\)$")


def with_lines(error: SceneError) -> SceneError:
    """The same problems, each behind the line and column that it is about.

    Parameters
    ----------
    error
        Problems of one file.

    Returns
    -------
    SceneError
        Its message has lines `file:line:column: key: problem`; what belongs to no line, and all of
        a file that can't be read again, stays as it is.
    """
    text = _text(Path(error.path))
    if text is None:
        return error
    places = Places(text.decode("utf-8", "replace"))
    found = [_located(places, text, problem) for problem in error.problems]
    shown = [f"{place.line}:{place.column}" if place else "" for place in found]
    said = [_without_place(text, problem) for problem in error.problems]
    return SceneError(error.path, said, shown)


def line_of(path: Path, message: str) -> str:
    """A message that begins with a key of a file, behind the file and the key's line and column.

    Parameters
    ----------
    path
        The file.
    message
        What is wrong.
    """
    return str(with_lines(SceneError(path, [message])))


def position_of(places: Places, problem: str) -> Position | None:
    """Where the key stands that a problem begins with, or the nearest table around it.

    Parameters
    ----------
    places
        Of the file.
    problem
        As in a `SceneError`: `bearings[0].stiffness_n_per_m: ...`.
    """
    path: list[Part] = []
    found: Position | None = None
    at = 0
    while True:
        step = _STEP.match(problem, at)
        if step is None:
            break
        if step[3] is not None:
            part: Part | None = int(step[3])
        else:
            part = _key_shown_as(step[1] or step[2], places.keys(path))
        place = None if part is None else places.position([*path, part])
        if part is None or place is None:
            return found if found is None or _is_key(problem, step.end()) else None
        path.append(part)
        found, at = place, step.end()
    return found if problem.startswith(_AFTER, at) else None


def _is_key(problem: str, at: int) -> bool:
    """Whether the words before are a key, although the file does not have all of it."""
    while True:
        step = _STEP.match(problem, at)
        if step is None:
            return problem.startswith(_AFTER, at)
        at = step.end()


def _key_shown_as(shown: str, keys: tuple[Part, ...]) -> str | None:
    """The key of a table that is written so in messages, where it may be quoted and cut."""
    if shown in keys:
        return shown
    for key in keys:
        if isinstance(key, str) and shown_key(key) == shown:
            return key
    return None


def _located(places: Places, content: bytes, problem: str) -> Position | None:
    """Where a problem is, of the text or of a key."""
    if syntax := _SYNTAX.search(problem):
        return Position(line=int(syntax[1]), column=int(syntax[2]))
    if _AT_END.search(problem):
        return places.at(len(content.decode("utf-8", "replace")))
    if line := _LINE.match(problem):
        return Position(line=int(line[1]), column=1)
    if byte := _BYTE.match(problem):
        return places.at(len(content[: int(byte[1])].decode("utf-8", "replace")))
    return _entry(places, content, problem) or position_of(places, problem)


def _entry(places: Places, content: bytes, problem: str) -> Position | None:
    """Where the entry of a body stands that a problem of its geometry names."""
    body = _BODY.match(problem)
    if body is None:
        return None
    try:
        table = tomllib.loads(content.decode("utf-8", "replace")).get(body[1])
    except (ValueError, RecursionError):  # changed since it was read
        return None
    own = table.get(body[2]) if isinstance(table, dict) else None
    path = entry_path(own, problem[body.end() :])
    return places.position([body[1], body[2], *path]) if path else None


def _without_place(content: bytes, problem: str) -> str:
    """The problem without the place of a syntax error, which stands before it; with a hint."""
    syntax = _SYNTAX.search(problem)
    if syntax is None:
        return _AT_END.sub(" at the end", problem)
    said = problem[: syntax.start()]
    lines = content.decode("utf-8", "replace").split("\n")
    if int(syntax[1]) > len(lines):
        return said
    line, at = lines[int(syntax[1]) - 1], int(syntax[2]) - 1
    is_comma = any(
        words in said and before.search(line[:at]) and behind.match(line[at:])
        for words, before, behind in _BEHIND_NUMBER
    )
    return said + (_COMMA if is_comma else "")


def _text(path: Path) -> bytes | None:
    """Content of a file of usual size; None of a device, a pipe, and what can't be read."""
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode) or found.st_size > _LARGEST_BYTES:
            return None
        return path.read_bytes()
    except (OSError, ValueError):
        return None
