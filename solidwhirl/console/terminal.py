"""What a command says while it works: a bar on a terminal, else a line for each stage."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import typer
from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, SpinnerColumn, Task, TextColumn
from rich.text import Text

from solidwhirl.console.schedule import Schedule, run_steps
from solidwhirl.core.stages import Progress as Told
from solidwhirl.core.stages import Stage

if TYPE_CHECKING:  # loads the mesher
    from solidwhirl.cost.forecast import Forecast
    from solidwhirl.model.plan_records import Plan

#: Of the JSON document that a run prints.
RUN_SCHEMA = "solidwhirl-run-1"
# Time to go that is worth a word in a line [s].
_WORTH_SAYING_S = 10.0
# Time to go that is not worth a number [s].
_SOON_S = 0.5
_NAME_WIDTH = 44


def duration_text(seconds: float) -> str:
    """Return a duration for people: seconds, minutes or hours."""
    if seconds < 99.5:
        return f"{seconds:.0f} s" if seconds >= 9.95 else f"{seconds:.1f} s"
    if seconds < 5970.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


def say(console: Console, line: str | Text) -> None:
    """Print a line as it is, whatever stands in it."""
    console.print(Text(line) if isinstance(line, str) else line, highlight=False, soft_wrap=True)


def print_document(document: Any) -> None:
    """Print a JSON document on the standard output."""
    typer.echo(json.dumps(document, indent=1, allow_nan=False))


@contextmanager
def telling(quiet: bool) -> Iterator[Told]:
    """Give a function that says what is being done: in place on a terminal, else line by line."""
    console = Console(stderr=True, quiet=quiet)
    with console.status("") as status:

        def progress(event: Stage | str) -> None:
            status.update(Text(str(event)))
            if not console.is_terminal:
                say(console, str(event))

        yield progress


class RunProgress:
    """The progress of a run on the error stream; a function of what the run says.

    On a terminal a finished stage leaves a line with its time, below which a bar stands with the
    stage that runs and the time to go; else there is a line for each stage that begins, with the
    time to go where that is long.
    """

    def __init__(
        self, *, quiet: bool = False, pictures: bool = True, console: Console | None = None
    ) -> None:
        self._console = console or Console(stderr=True, quiet=quiet)
        self._pictures = pictures
        self._schedule = Schedule()
        self._bar: _Bar | None = None
        if self._console.is_interactive and not self._console.quiet:
            self._bar = _Bar(self._console, self._schedule)

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        ended = self._schedule.end()
        if self._bar is not None:
            if error is None:
                self._finished(ended)
            self._bar.stop()

    def foresee(self, stages: Sequence[Stage]) -> None:
        """Take up stages with their predicted times."""
        self._schedule.foresee(stages)

    def foreseen(self, plan: Plan, expected: Forecast) -> None:
        """Take up what is to come."""
        self.foresee(run_steps(plan, expected, pictures=self._pictures))
        left, drawing = self._schedule.to_go_s() or 0.0, " and pictures" if self._pictures else ""
        text = f"about {duration_text(left)} until all is written, with analyses{drawing}"
        say(self._console, text)

    def __call__(self, event: Stage | str) -> None:
        """Tell that a stage begins, or a remark."""
        if isinstance(event, str):
            say(self._console, event)
            return
        ended = self._schedule.begin(event)
        if self._bar is None:
            say(self._console, f"{event}{self._long_to_go()}")
            return
        self._finished(ended)
        self._bar.show(str(event))

    def _finished(self, ended: tuple[Stage, float] | None) -> None:
        """Leave a line of a stage that is over."""
        if ended is None:
            return
        stage, spent = ended
        mark = "ok" if self._console.options.ascii_only else "✓"
        line = Text.assemble(
            (f"{mark} ", "green"),
            str(stage).ljust(_NAME_WIDTH),
            (f"{duration_text(spent):>8}", "dim"),
        )
        say(self._console, line)

    def _long_to_go(self) -> str:
        left = self._schedule.to_go_s()
        if left is None or left < _WORTH_SAYING_S:
            return ""
        return f" (about {duration_text(left)} to go)"


class _Bar(Progress):
    """One bar for the whole run, which follows its schedule."""

    def __init__(self, console: Console, schedule: Schedule) -> None:
        self._schedule = schedule
        super().__init__(
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[left]}", style="dim"),
            console=console,
            transient=True,
        )
        self._task = self.add_task("begin", total=1.0, left="")

    def show(self, text: str) -> None:
        """Name the stage that runs."""
        self.update(self._task, description=text)

    def get_renderables(self) -> Iterator[RenderableType]:
        """Give the bar as it is now."""
        task: Task | None = self.tasks[0] if self.tasks else None
        if task is not None:
            left = self._schedule.to_go_s()
            task.completed = self._schedule.share()
            to_go = f"about {duration_text(left)} to go" if left else ""
            task.fields["left"] = "almost done" if left is not None and left < _SOON_S else to_go
        yield from super().get_renderables()
