"""Where keys and values stand in the text of a TOML file, which the parser does not tell."""

from __future__ import annotations

import bisect
import contextlib
import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from solidwhirl.core.errors import KeyPath

# Spaces and comments; texts by their quotes; marks; numbers, words, keys with dots, and times,
# which may follow their date after one space.
_TOKEN = re.compile(
    r"""[ \t\r]+|\#[^\n]*"""
    r"""|(?P<text>\"{3}(?:\\.|[^\\])*?\"{3,5}|'{3}.*?'{3,5}|"(?:\\.|[^"\\\n])*"|'[^'\n]*')"""
    r"""|(?P<mark>[][{}=,\n])"""
    r"""|(?P<word>[^][{}=,\s#"']+(?:[ ]\d\d:\d\d[^]},\s#]*)?)""",
    re.DOTALL,
)
_BARE = re.compile(r"[A-Za-z0-9_-]+")


class _Token(NamedTuple):
    kind: str
    said: str
    at: int


@dataclass(frozen=True, kw_only=True)
class Position:
    """A place in a text; both count from 1."""

    line: int
    column: int


class Places:
    """Positions of all keys and elements of lists in a text.

    Of a text that is not TOML those before its first error are known; nothing is nested by
    recursion.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._ends = [match.end() for match in re.finditer("\n", text)]

    @cached_property
    def _read(self) -> _Reader:
        return _Reader(self.text)

    def position(self, path: Iterable[str | int]) -> Position | None:
        """Where a key stands; for an element of a list its value, of a list of tables its header.

        `path`: keys, and numbers of elements from 0, from the top of the file.
        Returns None if there is no such key.
        """
        index = self._read.found.get(tuple(path))
        if index is None:
            return None
        line = bisect.bisect_right(self._ends, index)
        start = self._ends[line - 1] if line else 0
        return Position(line=line + 1, column=index - start + 1)

    def word(self, path: Iterable[str | int]) -> tuple[int, int] | None:
        """Begin and end of a value that is a number or another word without quotes, None if not.

        `path`: as of `position`; a value, or an element of a list of them.
        """
        return self._read.words.get(tuple(path))


class _Reader:
    """Reads a text once, from its begin; `found`: where all keys begin, as far as it is TOML."""

    def __init__(self, text: str) -> None:
        self._tokens = _tokens(text)
        self.found: dict[KeyPath, int] = {}
        self.words: dict[KeyPath, tuple[int, int]] = {}  # values without quotes and brackets
        self._implied: set[KeyPath] = set()  # only tables below these have been named
        self._counts: dict[KeyPath, int] = {}  # elements of lists
        self._read()

    def _read(self) -> None:
        table: KeyPath = ()
        with contextlib.suppress(StopIteration, ValueError):
            while True:
                token = next(self._tokens)
                if token.said == "[":
                    table = self._header(token.at)
                elif token.said != "\n":
                    self._assignment(table, token)

    def _header(self, at: int) -> KeyPath:
        """The table that a line in brackets begins."""
        token = next(self._tokens)
        is_list = token.said == "["
        *path, (name, _) = self._keys(next(self._tokens) if is_list else token, "]")
        if is_list:
            next(self._tokens)
        table: KeyPath = ()
        for key, _ in path:
            table = self._last(self._named((*table, key), at, implied=True))
        table = self._named((*table, name), at)
        return self._element(table, at) if is_list else self._last(table)

    def _assignment(self, table: KeyPath, token: _Token) -> None:
        """A key, its value and all that is in it."""
        waiting: list[tuple[KeyPath, str]] = []
        self._value(self._assigned(table, token), next(self._tokens), waiting)
        while waiting:
            holder, closing = waiting[-1]
            token = next(self._tokens)
            if token.said == closing:
                waiting.pop()
            elif token.said not in (",", "\n"):
                if closing == "}":
                    self._value(self._assigned(holder, token), next(self._tokens), waiting)
                else:
                    self._value(self._element(holder, token.at), token, waiting)

    def _assigned(self, table: KeyPath, token: _Token) -> KeyPath:
        """The key whose value comes next."""
        for key, at in self._keys(token, "="):
            table = self._named((*table, key), at)
        return table

    def _value(self, path: KeyPath, token: _Token, waiting: list[tuple[KeyPath, str]]) -> None:
        """Take a value, or the bracket that opens one."""
        if token.said in ("[", "{"):
            waiting.append((path, "]" if token.said == "[" else "}"))
        elif token.kind == "word":
            self.words[path] = token.at, token.at + len(token.said)

    def _keys(self, token: _Token, end: str) -> list[tuple[str, int]]:
        """The names of a key with dots up to a mark, and where each begins."""
        found: list[tuple[str, int]] = []
        while token.said != end:
            if token.kind == "mark":
                raise ValueError
            if token.kind == "text":
                found.append((str(tomllib.loads(f"x = {token.said}")["x"]), token.at))
            else:
                found += [(m[0], token.at + m.start()) for m in _BARE.finditer(token.said)]
            token = next(self._tokens)
        return found

    def _named(self, path: KeyPath, at: int, *, implied: bool = False) -> KeyPath:
        """The path, whose place is that of its own name, else of the first one below it."""
        if path not in self.found:
            self.found[path] = at
            self._implied |= {path} if implied else set()
        elif path in self._implied and not implied:
            self.found[path] = at
            self._implied.discard(path)
        return path

    def _element(self, path: KeyPath, at: int) -> KeyPath:
        """A new last element of a list."""
        number = self._counts.get(path, 0)
        self._counts[path] = number + 1
        self.found[*path, number] = at
        return (*path, number)

    def _last(self, path: KeyPath) -> KeyPath:
        """The element of a list that what follows belongs to; else the path itself."""
        return (*path, self._counts[path] - 1) if self._counts.get(path) else path


def last_token(text: str, before: int) -> tuple[int, str] | None:
    """Return where the last value or mark before a place ends, and what it is; lines are none."""
    found = None
    for token in _tokens(text):
        if token.at >= before:
            break
        if token.said != "\n":
            said = token.said[: before - token.at]
            found = token.at + len(said), said
    return found


def _tokens(text: str) -> Iterator[_Token]:
    at = 0
    while match := _TOKEN.match(text, at):
        at = match.end()
        if match.lastgroup:
            yield _Token(match.lastgroup, match.group(), match.start())
