"""`solidwhirl watch`: a page that follows a scene file, or moves the supports of a run."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from solidwhirl.commands import options
from solidwhirl.console.exit_handling import Terminated
from solidwhirl.console.guard import guarded
from solidwhirl.core.errors import SceneError

if TYPE_CHECKING:
    from solidwhirl.watch.session import Session

    Opener = Callable[[Callable[[str], None]], Session]

EXAMPLES = options.examples(
    "solidwhirl watch scenes/ferraris.toml",
    "solidwhirl watch out/ferraris",
    "solidwhirl watch scenes/ferraris.toml --no-open --port 8765",
)


@dataclass(frozen=True, kw_only=True)
class WatchOptions:
    """What `watch` takes."""

    scene: Annotated[
        Path, typer.Argument(metavar="SCENE.toml|DIR", help="The scene file, or a run's folder.")
    ]
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="N", help="Of the page; 0: any that is free.")
    ] = 0
    opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the page in the browser.")
    ] = True
    store: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            envvar="SOLIDWHIRL_STORE",
            help="Folder of completed stages; without, they are gone at the end.",
        ),
    ] = None


@options.taking(WatchOptions)
def watch(asked: WatchOptions) -> None:
    """Show a scene on a page that follows its file, with sliders for supports and speeds.

    Save the file, and diagram, critical speeds and drawing change; errors stand at their line.
    Of the folder of a run the sliders move its saved bodies.
    The page is on this machine alone; its address has a token that others do not know. Ctrl-C ends.
    """

    def work() -> None:
        with tempfile.TemporaryDirectory(prefix="solidwhirl-watch-") as scratch:
            is_ended = _served(asked, _opener(asked, asked.store or Path(scratch)), Path(scratch))
        if not is_ended:  # a library computes, and would be torn down at its work
            sys.stdout.flush()
            os._exit(0)

    guarded(asked.scene, work)


def _served(asked: WatchOptions, opened: Opener, own: Path) -> bool:
    """Serve until Ctrl-C; whether all that computes has ended then.

    `own`: a folder that others can not read.
    """
    from solidwhirl.watch.server import Server

    server = Server(opened, asked.port)

    def ready() -> None:
        typer.echo(server.address)
        typer.echo(f"follows {asked.scene}; Ctrl-C ends it", err=True)
        if asked.opened:
            import webbrowser

            # all users see the words that a browser is started with: they name a file, which leads
            # to the address with its token
            file = own / "watch.html"
            leads = f'<meta http-equiv="refresh" content="0; url={server.address}">'
            file.write_text(leads, encoding="utf-8")
            webbrowser.open(file.as_uri())

    try:
        server.run(ready)
    except Terminated:
        raise
    except KeyboardInterrupt:  # the usual end
        return server.end_work()
    return server.end_work()


def _opener(asked: WatchOptions, store: Path) -> Opener:
    """What makes the session when the page is served.

    Raises UserError: there is no such file, or the folder is none of a run.
    """
    if asked.scene.is_dir():
        from solidwhirl.watch.saved_run import read_run

        run = read_run(asked.scene)
    elif not asked.scene.is_file():
        raise SceneError(asked.scene, ["there is no such file or folder"])

    def opened(tell: Callable[[str], None]) -> Session:
        from solidwhirl.watch.scene_file import SceneFile
        from solidwhirl.watch.session import Session

        if asked.scene.is_dir():
            return Session(run, tell)
        return Session(SceneFile(asked.scene, store), tell)

    return opened
