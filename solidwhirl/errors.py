"""Errors that a user caused, told apart from defects of the program."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

# Characters of one problem, and of a message of many.
_LONGEST_PROBLEM = 600
_LONGEST_MESSAGE = 3000


def clean(text: str, longest: int = _LONGEST_MESSAGE) -> str:
    """Return a text for a message: control characters escaped, the end cut off where it is long.

    Parameters
    ----------
    text
        May hold what stands in a file.
    longest
        Number of characters kept.
    """
    cut = text if len(text) <= longest else f"{text[:longest]}..."
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in cut
    )


def markdown_text(text: str) -> str:
    """Return a text that Markdown shows as it is: no markup, no HTML, one line.

    Parameters
    ----------
    text
        May hold what stands in a file.
    """
    plain = markdown_cell(text)
    # these begin headings, lists, rules, definitions of links
    plain = re.sub(r"^(?=#|\[|[-+](?:\s|$)|(?:=+|-+)$)", r"\\", plain)
    return re.sub(r"^(\d+)(?=[.)](?:\s|$))", r"\1\\", plain)


def markdown_cell(text: str) -> str:
    """Return a text for a cell of a table, where numbers, signs and keys begin no markup.

    Parameters
    ----------
    text
        As for `markdown_text`.
    """
    plain = clean(" ".join(text.split("\n"))).strip()
    plain = re.sub(r"&(?=#?\w+;)", "&amp;", plain)
    # comparisons and arrows are no tags
    plain = re.sub(r"<(?=[A-Za-z/!?])", "&lt;", plain)
    plain = re.sub(r"(?<![\s-])>", "&gt;", plain)
    plain = re.sub(r"([\\`*|~$]|\](?=\())", r"\\\1", plain)
    # underscores within words are letters
    return re.sub(r"(?<!\w)(_+)|(_+)(?!\w)", lambda m: "".join(f"\\{c}" for c in m[0]), plain)


class SceneError(ValueError):
    """A scene that can not be run; the message names file, key, finding and what is allowed.

    Parameters
    ----------
    path
        The file.
    problems
        What is wrong, each begins with its key.
    places
        Line and column of each problem as text, `"17:5"`, or empty; none are known if not given.
    """

    def __init__(
        self, path: Path | str, problems: list[str], places: Sequence[str] | None = None
    ) -> None:
        self.path = str(path)
        self.problems = problems
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


class OutputError(OSError):
    """Results that could not be written."""
