"""Errors that a user caused, told apart from defects of the program."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from solidwhirl.rotordyn.core.errors import AnalysisError, AssemblyError, SuperelementError

# Characters of one problem, and of a message of many.
_LONGEST_PROBLEM = 600
_LONGEST_MESSAGE = 3000
# Characters of a word that is compared with others: the time grows with their square.
_LONGEST_WORD = 60


def clean(text: str, longest: int = _LONGEST_MESSAGE) -> str:
    """Return a text for a message: control characters escaped, the end cut off where it is long."""
    cut = text if len(text) <= longest else f"{text[:longest]}..."
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in cut
    )


def one_line(text: str) -> str:
    """Return a name that a file of others gives, for messages and files of one line each."""
    return clean(text).replace("\n", "\\n")


def markdown_text(text: str) -> str:
    """Return a text that Markdown shows as it is: no markup, no HTML, one line."""
    plain = markdown_cell(text)
    # these begin headings, lists, rules, definitions of links
    plain = re.sub(r"^(?=#|\[|[-+](?:\s|$)|(?:=+|-+)$)", r"\\", plain)
    return re.sub(r"^(\d+)(?=[.)](?:\s|$))", r"\1\\", plain)


def markdown_cell(text: str) -> str:
    """Return a text for a cell of a table, where numbers, signs and keys begin no markup."""
    plain = clean(" ".join(text.split("\n"))).strip()
    plain = re.sub(r"&(?=#?\w+;)", "&amp;", plain)
    # comparisons and arrows are no tags
    plain = re.sub(r"<(?=[A-Za-z/!?])", "&lt;", plain)
    plain = re.sub(r"(?<![\s-])>", "&gt;", plain)
    plain = re.sub(r"([\\`*|~$]|\](?=\())", r"\\\1", plain)
    # underscores within words are letters
    return re.sub(r"(?<!\w)(_+)|(_+)(?!\w)", lambda m: "".join(f"\\{c}" for c in m[0]), plain)


def markdown_row(cells: Iterable[object]) -> str:
    """Return a row of a table in Markdown."""
    return "| " + " | ".join(markdown_cell(str(cell)) for cell in cells) + " |"


def meant(word: str, known: Iterable[str]) -> str:
    """Return "did you mean 'x'? " with the nearest known word; nothing if none is near."""
    near = difflib.get_close_matches(word[:_LONGEST_WORD], list(known), n=1, cutoff=0.6)
    return f"did you mean {near[0]!r}? " if near else ""


def choice(word: str, known: Sequence[str], none: str = "none") -> str:
    """Return what is allowed, with the nearest proposed, for a message."""
    return f"{meant(word, known)}allowed are {', '.join(known) or none}"


def unknown(kind: str, name: str, allowed: Sequence[str], none: str = "none") -> str:
    """Return words for a name that does not exist, with the nearest that does."""
    return f"no {kind} {name!r}; {choice(name, allowed, none)}"


def repeated(key: str, names: Sequence[str]) -> Iterator[str]:
    """Yield a line for each entry of a list whose name one before it has."""
    for k, name in enumerate(names):
        first = names.index(name)
        if first != k:
            yield f"{key}[{k}].name: {name!r} is the name of {key}[{first}] too"


KeyPath = tuple[str | int, ...]


class Problem(str):
    """A line on what is wrong with a file, which begins with its key, and the path of that key."""

    path: KeyPath

    def __new__(cls, text: str, path: KeyPath = ()) -> Problem:
        """Take the line, and keys and numbers of entries from the top of the file."""
        made = super().__new__(cls, text)
        made.path = path
        return made


class UserError(ValueError):
    """Something that a user asked for and can not have; ends in one message, no traceback."""


class SceneError(UserError):
    """A scene that can not be run; the message names file, key, finding and what is allowed.

    Parameters
    ----------
    problems
        What is wrong, each begins with its key; a `Problem` knows the path of that key.
    places
        Line and column of each problem as text, `"17:5"`, or empty; none are known if not given.
    """

    def __init__(
        self, path: Path | str, problems: Sequence[str], places: Sequence[str] | None = None
    ) -> None:
        self.path = str(path)
        self.problems = tuple(problems)
        self.places = tuple(places or [""] * len(problems))
        heads = [f"{path}:{place}" if place else str(path) for place in self.places]
        lines = [
            f"{head}: {clean(problem, _LONGEST_PROBLEM)}"
            for head, problem in zip(heads, problems, strict=True)
        ]
        shown, length = 0, 0
        while shown < len(lines) and (shown == 0 or length + len(lines[shown]) < _LONGEST_MESSAGE):
            length += len(lines[shown]) + 1
            shown += 1
        left = len(lines) - shown
        more = [f"{path}: and {left} more like these"] if left else []
        super().__init__("\n".join(lines[:shown] + more))

    def __reduce__(self) -> tuple[Any, ...]:
        """Let an error cross from one process to another."""
        return type(self), (self.path, self.problems, self.places)


#: What ends in one message: the errors of the program, and of rotordyn, which stands alone.
USER_ERRORS = (UserError, SuperelementError, AssemblyError, AnalysisError)


class OutputError(OSError):
    """Results that could not be written."""


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Tell what the system says while a path is written as an `OutputError`."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        said = error.strerror or str(error).partition("\n")[0]
        raise OutputError(clean(f"{path}: can not be written: {said}")) from error
