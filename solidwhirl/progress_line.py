"""What a command says while it works."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console


@contextmanager
def telling(quiet: bool) -> Iterator[Callable[[str], None]]:
    """Give a function that says what is being done: in place on a terminal, else line by line.

    Parameters
    ----------
    quiet
        Say nothing.
    """
    console = Console(stderr=True, quiet=quiet)
    with console.status("") as status:

        def progress(text: str) -> None:
            status.update(text)
            if not console.is_terminal:
                console.print(text)

        yield progress
