"""The page's server: on the loopback address alone, and for those who know its token."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import hmac
import json
import secrets
import socket
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from solidwhirl.core.errors import OutputError
from solidwhirl.page.frame.assets import plotly_file
from solidwhirl.watch.page import watch_page

if TYPE_CHECKING:
    from solidwhirl.watch.session import Session

_ADDRESS = "127.0.0.1"
# Largest message of the page: some hundred sliders have a hundredth of it.
_LARGEST_BYTES = 1 << 20
# The connection is looked after this often, so that the page knows when it is lost.
_PING_S = 5.0
# Without file handles new connections wait for so long.
_BACK_OFF_S = 1.0


class Server:
    """Serves the page of a scene on this machine.

    Parameters
    ----------
    opened
        Makes the session, told where messages to the page go; called in a thread when the page is
        served already, for what it loads takes seconds.
    port
        0 for any that is free.
    token
        What addresses have to begin with; a random one if not given.

    Raises
    ------
    OutputError
        The port can't be had.
    """

    def __init__(
        self, opened: Callable[[Callable[[str], None]], Session], port: int = 0, token: str = ""
    ) -> None:
        self.token = token or secrets.token_urlsafe(24)
        try:
            self._socket = socket.create_server((_ADDRESS, port))
        except OSError as error:
            raise OutputError(f"--port {port}: can not be had: {error.strerror}") from error
        self._socket.setblocking(False)
        self.port: int = self._socket.getsockname()[1]
        self._opened = opened
        self.session: Session | None = None
        self._opening: threading.Thread | None = None
        self.pages: set[_Socket] = set()
        self._failure: BaseException | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ended: asyncio.Event | None = None

    @property
    def address(self) -> str:
        """Where a browser finds the page."""
        return f"http://{_ADDRESS}:{self.port}/{self.token}/"

    def run(self, ready: Callable[[], None] = lambda: None) -> None:
        """Serve until `stop`, or until an exception such as an interrupt ends it.

        `ready`: called when the page can be opened. Raises what making the session raises.
        """
        asyncio.run(self._serve(ready))
        if self._failure is not None:
            raise self._failure

    def stop(self) -> None:
        """End `run`, from any thread."""
        if self._loop is not None and self._ended is not None:
            with contextlib.suppress(RuntimeError):  # it has ended already
                self._loop.call_soon_threadsafe(self._ended.set)

    def end_work(self) -> bool:
        """End all that computes; whether it ended within seconds."""
        if self.session is not None:
            return self.session.end()
        return self._opening is None or not self._opening.is_alive()

    async def _serve(self, ready: Callable[[], None]) -> None:
        self._loop, self._ended = asyncio.get_running_loop(), asyncio.Event()
        known = {"server": self}
        application = Application(
            [(r"/[^/]*/", _Page, known), (r"/[^/]*/plotly\.js", _Library, known),
             (r"/[^/]*/socket", _Socket, known)],
            default_handler_class=_Nothing,
            default_handler_args=known,
            websocket_ping_interval=_PING_S,
            websocket_max_message_size=_LARGEST_BYTES,
            log_function=lambda handler: None,
        )  # fmt: skip
        http = HTTPServer(application, max_body_size=_LARGEST_BYTES)
        http.add_socket(self._socket)
        self._loop.set_exception_handler(self._take_error)
        try:
            ready()
            self._opening = threading.Thread(target=self._open, name="session", daemon=True)
            self._opening.start()
            await self._ended.wait()
        finally:
            http.stop()
            for page in list(self.pages):
                page.close()
            await http.close_all_connections()

    def _take_error(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Wait with new connections while there are no file handles for them."""
        error = context.get("exception")
        if not (isinstance(error, OSError) and error.errno in (errno.EMFILE, errno.ENFILE)):
            loop.default_exception_handler(context)
            return
        # tornado would ask again at once
        handle, tornado = self._socket.fileno(), IOLoop.current()
        tornado.update_handler(handle, 0)
        loop.call_later(_BACK_OFF_S, lambda: tornado.update_handler(handle, IOLoop.READ))
        print(f"watch: {error.strerror}; new connections wait", file=sys.stderr)

    def _open(self) -> None:
        """Begin to show the scene; where that can't be, the server ends."""
        try:
            self.session = self._opened(self._tell)
            self.session.start()
        except BaseException as error:
            self._failure = error
            self.stop()

    def _tell(self, text: str) -> None:
        """Send a message to all pages, from any thread."""
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._send, text)

    def _send(self, text: str) -> None:
        for page in list(self.pages):
            page.send(text)

    def refuses(self, handler: _Guarded) -> bool:
        """Whether a request comes by another name than the address, from elsewhere, or unknown.

        A page of somebody else can reach the loopback address by a name that it lets point there.
        What may move sliders and write has to say that it comes from the own page, as browsers do.
        """
        request = handler.request
        own = f"{_ADDRESS}:{self.port}"
        origin = request.headers.get("Origin")
        token = request.path.split("/")[1] if "/" in request.path else ""
        known = hmac.compare_digest(token.encode("utf-8"), self.token.encode("ascii"))
        return (
            not known
            or request.headers.get("Host") != own
            or origin not in ({f"http://{own}"} | ({None} if handler.may_only_read else set()))
        )


class _Guarded(RequestHandler):
    """Refuses all requests but those of the own page."""

    may_only_read = True

    def initialize(self, server: Server) -> None:
        self.server = server

    def prepare(self) -> None:
        if self.server.refuses(self):
            raise HTTPError(403)

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        self.set_header("Cache-Control", "no-store")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("X-Frame-Options", "DENY")

    def write_error(self, status_code: int, **more: Any) -> None:
        self.set_header("Content-Type", "text/plain")
        self.finish(f"{status_code}\n")


class _Page(_Guarded):
    """The page itself."""

    def get(self) -> None:
        self.finish(watch_page())


class _Library(_Guarded):
    """The drawing library."""

    def get(self) -> None:
        self.set_header("Content-Type", "text/javascript; charset=utf-8")
        self.finish(plotly_file().read_bytes())


class _Nothing(_Guarded):
    """What is not there."""

    def get(self) -> None:
        raise HTTPError(404)


class _Socket(_Guarded, WebSocketHandler):
    """The connection to an open page."""

    may_only_read = False

    def check_origin(self, origin: str) -> bool:
        return origin == f"http://{_ADDRESS}:{self.server.port}"

    def open(self, *arguments: str, **named: str) -> None:
        self.set_nodelay(True)  # else a picture waits for the answer to what was sent before it
        self.server.pages.add(self)
        for text in self.server.session.messages() if self.server.session else ():
            self.send(text)

    def send(self, text: str) -> None:
        """Send a message, unless the page is gone."""
        with contextlib.suppress(WebSocketClosedError):
            self.write_message(text)

    def on_message(self, message: str | bytes) -> None:
        session = self.server.session
        if session is None:
            return
        match _asked(message):
            case {"do": "move", "positions": dict() as positions}:
                session.move(positions)
            case {"do": "write", "name": str() as name}:
                session.write(name)

    def on_close(self) -> None:
        self.server.pages.discard(self)


def _asked(message: str | bytes) -> Any:
    """What a page asks; None if it is no JSON."""
    try:
        return json.loads(message)
    except (ValueError, RecursionError):
        return None
