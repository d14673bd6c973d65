"""Who may ask the server of the page: those with its token, by its address, from its page."""

from __future__ import annotations

import asyncio
import errno
import http.client
import json

import pytest
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from solidwhirl.core.errors import OutputError
from solidwhirl.watch.server import Server

# a whole number that no double can hold
HUGE = '{"do": "move", "positions": {"bearings.1.stiffness_n_per_m": 1' + "0" * 400 + "}}"


@pytest.fixture
def server(serve, follow, scene_path):
    return serve(follow(scene_path))


def _asked(server, path, host=None, method="GET", **headers):
    """Status and body of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    try:
        connection.putrequest(method, path, skip_host=True)
        connection.putheader("Host", host or f"127.0.0.1:{server.port}")
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, answer.read().decode("utf-8"), dict(answer.getheaders())
    finally:
        connection.close()


def test_the_page_and_its_library_need_nothing_else(server):
    status, page, headers = _asked(server, f"/{server.token}/")
    assert status == 200 and "solidwhirl watch" in page
    assert "http://" not in page.replace("http://www.w3.org", "") and "https://" not in page
    assert headers["Referrer-Policy"] == "no-referrer" and "Server" not in headers
    status, library, _ = _asked(server, f"/{server.token}/plotly.js")
    assert status == 200 and "plotly.js" in library[:500]


def test_requests_without_the_token_are_refused(server):
    for path in (
        "/",
        "//",
        "/x/",
        "/x/plotly.js",
        "/x/socket",
        "/x",
        f"/{server.token[:-1]}/",
        "*",
    ):
        assert _asked(server, path)[:2] == (403, "403\n"), path
    assert _asked(server, f"/{server.token}/other")[0] == 404
    assert _asked(server, f"/{server.token}/", method="POST", **{"Content-Length": "0"})[0] >= 400


def test_requests_by_another_name_or_from_elsewhere_are_refused(server):
    """A page elsewhere may let a name of its own point to this machine."""
    path = f"/{server.token}/"
    for host in ("example.org", f"example.org:{server.port}", "127.0.0.1", "127.0.0.1:1"):
        assert _asked(server, path, host)[0] == 403, host
    own = f"http://127.0.0.1:{server.port}"
    for origin in ("http://example.org", "null", own.replace("http", "https"), own + "0"):
        assert _asked(server, path, Origin=origin)[0] == 403, origin
    assert _asked(server, path, Origin=own)[0] == 200


def _connected(server, token=None, **headers):
    """The first messages of a connection."""

    async def first():
        url = f"ws://127.0.0.1:{server.port}/{token or server.token}/socket"
        socket = await websocket_connect(HTTPRequest(url, headers=headers))
        # what is no question is passed over
        for text in (
            "{",
            "[]",
            "3",
            '{"do": "move"}',
            '{"do": "move", "positions": {"x": 1}}',
            HUGE,
        ):
            await socket.write_message(text)
        await socket.write_message(b"\xff\xfe", binary=True)
        kinds = set()
        while "picture" not in kinds:
            kinds.add(json.loads(await asyncio.wait_for(socket.read_message(), 60))["kind"])
        socket.close()
        while await socket.read_message() is not None:
            pass
        return kinds

    return asyncio.run(first())


def test_a_connection_needs_token_and_origin_too(server):
    own = f"http://127.0.0.1:{server.port}"
    assert {"source", "scene", "drawing", "picture"} <= _connected(server, Origin=own)
    wrong = [{"token": "x"}, {"Origin": "http://example.org"}, {"Host": "example.org"}]
    # browsers tell what a request is of; a page of the same site is not this page
    wrong.append({"Origin": "http://localhost:80", "Sec-Fetch-Site": "same-origin"})
    for other in wrong:
        with pytest.raises(HTTPClientError, match="403"):
            _connected(server, **{"Origin": own, **other})
    # a program that is no browser need not tell, and could move sliders and write
    with pytest.raises(HTTPClientError, match="403"):
        _connected(server)


def test_a_port_that_is_taken_is_refused_and_tokens_differ(server, serve, follow, scene_path):
    with pytest.raises(
        OutputError, match=rf"--port {server.port}: can not be had: Address already"
    ):
        Server(follow(scene_path), port=server.port)
    other = serve(follow(scene_path))
    assert other.token != server.token and len(other.token) >= 32
    assert _asked(other, f"/{server.token}/")[0] == 403


def test_without_file_handles_new_connections_wait(server, capfd):
    """A line a second is said where there were thousands, and the page is there again after it."""
    error = OSError(errno.EMFILE, "Too many open files")
    for _ in range(3):
        server._loop.call_soon_threadsafe(server._take_error, server._loop, {"exception": error})
    assert _asked(server, f"/{server.token}/")[0] == 200
    assert capfd.readouterr().err.count("Too many open files; new connections wait") <= 3
