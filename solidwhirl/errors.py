"""Errors that a user caused, told apart from defects of the program."""

from __future__ import annotations

from pathlib import Path


class SceneError(ValueError):
    """A scene that can not be run; the message names file, key, finding and what is allowed."""

    def __init__(self, path: Path | str, problems: list[str]) -> None:
        self.path = str(path)
        self.problems = problems
        super().__init__("\n".join(f"{path}: {problem}" for problem in problems))


class OutputError(OSError):
    """Results that could not be written."""
