"""Where keys and values stand in the text of a TOML file, which the parser does not tell."""

from __future__ import annotations

import bisect
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

Part = str | int
_GAP = re.compile(r"[ \t\r\n]*")
_SPACE = re.compile(r"[ \t]*")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
# Numbers, words and times; a time may follow its date after one space.
_WORD = re.compile(r"[^,\]}\s#]+(?: \d\d:\d\d[^,\]}\s#]*)?")
# By how a text begins: what may end it, and what only looks like its end.
_ENDS = {
    '"""': re.compile(r'\\.|"{3,5}', re.DOTALL),
    "'''": re.compile(r"'{3,5}"),
    '"': re.compile(r'\\.|["\n]'),
    "'": re.compile(r"['\n]"),
}


@dataclass(frozen=True, kw_only=True)
class Position:
    """A place in a text; both count from 1."""

    line: int
    column: int


@dataclass(slots=True, eq=False)
class _Node:
    """A key or an element of a list: where it stands, and what is in it."""

    at: int
    inside: dict[Part, _Node] = field(default_factory=dict)
    is_list: bool = False
    is_named: bool = True  # False while only tables below it have been named

    def child(self, key: Part, at: int, *, named: bool = True) -> _Node:
        """The child of a key, made if there is none."""
        found = self.inside.get(key)
        if found is None:
            found = self.inside[key] = _Node(at=at, is_named=named)
        elif named and not found.is_named:
            found.at, found.is_named = at, True
        return found

    def added(self, at: int) -> _Node:
        """A new last element."""
        self.is_list = True
        node = self.inside[len(self.inside)] = _Node(at=at)
        return node

    def last(self) -> _Node:
        """The element of a list that what follows belongs to; else the node itself."""
        return self.inside[len(self.inside) - 1] if self.is_list and self.inside else self


class _LostError(Exception):
    """The text is no TOML from here on."""


class Places:
    """Positions of all keys and elements of lists in a text.

    Of a text that is not TOML those before its first error are known. The time is proportional to
    the length; nothing is nested by recursion.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._ends = [match.end() for match in re.finditer("\n", text)]

    @cached_property
    def _root(self) -> _Node:
        return _Reader(self.text).read()

    def position(self, path: Iterable[Part]) -> Position | None:
        """Where a key stands; for an element of a list its value, of a list of tables its header.

        Parameters
        ----------
        path
            Keys, and numbers of elements from 0, from the top of the file.

        Returns
        -------
        Position or None
            None if there is no such key.
        """
        node = self._root
        for part in path:
            found = node.inside.get(part)
            if found is None:
                return None
            node = found
        return None if node is self._root else self.at(node.at)

    def at(self, index: int) -> Position:
        """Line and column of a character."""
        line = bisect.bisect_right(self._ends, index)
        start = self._ends[line - 1] if line else 0
        return Position(line=line + 1, column=index - start + 1)


class _Reader:
    """Reads a text once, from its begin."""

    def __init__(self, text: str) -> None:
        self._text, self._at = text, 0

    def read(self) -> _Node:
        """All keys of the text, as far as it is TOML."""
        root = _Node(at=0)
        table = root
        try:
            while self._blank():
                if self._peek() == "[":
                    table = self._header(root)
                else:
                    self._assignment(table)
        except _LostError:
            pass
        return root

    def _peek(self) -> str:
        """The next character; empty at the end."""
        return self._text[self._at : self._at + 1]

    def _blank(self) -> str:
        """The next character that is no space, line end or comment; empty at the end."""
        self._take(_GAP)
        while self._peek() == "#":
            end = self._text.find("\n", self._at)
            self._at = len(self._text) if end < 0 else end
            self._take(_GAP)
        return self._peek()

    def _take(self, wanted: re.Pattern[str]) -> str:
        match = wanted.match(self._text, self._at)
        if match is None:
            raise _LostError
        self._at = match.end()
        return match.group()

    def _quoted(self) -> str:
        """A text with its quotes."""
        start = self._at
        quote = self._text[start]
        opening = 3 * quote if self._text.startswith(3 * quote, start) else quote
        self._at += len(opening)
        while True:
            end = _ENDS[opening].search(self._text, self._at)
            if end is None or end.group() == "\n":
                raise _LostError
            self._at = end.end()
            if not end.group().startswith("\\"):
                return self._text[start : self._at]

    def _skip(self, character: str) -> bool:
        if self._text.startswith(character, self._at):
            self._at += len(character)
            return True
        return False

    def _keys(self) -> list[tuple[str, int]]:
        """A key with dots: its names, and where each begins."""
        found = []
        while True:
            self._take(_SPACE)
            start = self._at
            quoted = self._peek() in ("'", '"')
            found.append((_unquoted(self._quoted()) if quoted else self._take(_BARE), start))
            self._take(_SPACE)
            if not self._skip("."):
                return found

    def _header(self, root: _Node) -> _Node:
        """The table that a line in brackets begins."""
        start = self._at
        is_list = self._skip("[[")
        if not is_list:
            self._skip("[")
        *path, (name, _) = self._keys()
        if not self._skip("]]" if is_list else "]"):
            raise _LostError
        table = root
        for key, _ in path:
            table = table.child(key, start, named=False).last()
        found = table.child(name, start)
        return found.added(start) if is_list else found.last()

    def _assignment(self, table: _Node) -> None:
        """A key, its value and all that is in it."""
        waiting: list[tuple[_Node, str]] = []
        self._value(self._assigned(table), waiting)
        while waiting:
            holder, closing = waiting[-1]
            if not self._blank():
                raise _LostError
            if self._skip(closing):
                waiting.pop()
            elif not self._skip(","):
                inner = self._assigned(holder) if closing == "}" else holder.added(self._at)
                self._value(inner, waiting)

    def _assigned(self, table: _Node) -> _Node:
        """The node of a key whose value comes next."""
        keys = self._keys()
        if not self._skip("="):
            raise _LostError
        for key, at in keys:
            table = table.child(key, at)
        return table

    def _value(self, node: _Node, waiting: list[tuple[_Node, str]]) -> None:
        """Read a value, or the bracket that opens one."""
        self._take(_SPACE)
        opening = self._peek()
        if opening in ("[", "{"):
            self._at += 1
            node.is_list = opening == "["
            waiting.append((node, "]" if node.is_list else "}"))
        elif opening in ("'", '"'):
            self._quoted()
        else:
            self._take(_WORD)


def _unquoted(key: str) -> str:
    """A key without its quotes."""
    if key[0] == "'" or "\\" not in key:
        return key[1:-1]
    try:
        read: Any = tomllib.loads(f"x = {key}")["x"]
    except ValueError as error:
        raise _LostError from error
    return str(read)
