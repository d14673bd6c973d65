"""What a batch says while it runs: a bar on a terminal, else a line for each case."""

from __future__ import annotations

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn

from solidwhirl.console.terminal import duration_text
from solidwhirl.sweep.records import BatchRow

_WORDS = {"done": "done", "failed": "FAILED", "checks_failed": "CHECKS FAILED"}


def failure_line(row: BatchRow) -> str:
    """How a case ended, in one line."""
    first = f": {row.message.splitlines()[0]}" if row.message else ""
    return f"{row.case} {_WORDS[row.status]} in {duration_text(row.seconds)}{first}"


class BatchProgress:
    """Lines and bar of a batch, on the rank that coordinates."""

    def __init__(self, console: Console, total: int, kept: int) -> None:
        self._console, self._total, self._done = console, total, kept
        self._bar: Progress | None = None
        self._task = TaskID(0)
        if console.is_terminal and not console.quiet:
            self._bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TextColumn("{task.fields[left]}"),
                console=console,
                transient=True,
            )
            self._task = self._bar.add_task("cases", total=total, completed=kept, left="")
            self._bar.start()

    def say(self, text: str) -> None:
        """Write a line."""
        self._console.print(escape(text), highlight=False, soft_wrap=True)

    def finished(self, row: BatchRow, to_go_s: float) -> None:
        """Tell that a case is over."""
        self._done += 1
        left = self._total - self._done
        to_go = f"about {duration_text(to_go_s)} to go" if left else "all cases done"
        line = failure_line(row)
        if self._bar is None:
            self.say(f"[{self._done}/{self._total}] {line}; {to_go}")
            return
        if row.status != "done":
            self.say(line)
        self._bar.update(self._task, completed=self._done, left=to_go)

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()
