"""A beam in a scene file with comments, and a server of it in a thread of the tests."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "page"))

from browser import browser
from watched_scene import SCENE, Told


@pytest.fixture(scope="session")
def driver():
    with browser() as found:
        yield found


@pytest.fixture
def scene_path(tmp_path):
    path = tmp_path / "rotor.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.fixture
def serve(monkeypatch):
    """Function: a server of a session in a thread, ended with the test."""
    from solidwhirl.watch.server import Server

    # what still computes ends as late as the thread may, on a machine that does other things
    monkeypatch.setattr("solidwhirl.watch.session._ENDING_S", 60.0)
    running = []

    def start(opened, **options):
        server, ready = Server(opened, **options), threading.Event()
        thread = threading.Thread(target=server.run, args=(ready.set,))
        thread.start()
        assert ready.wait(60)

        def end():
            server.stop()
            thread.join(60)
            assert not thread.is_alive() and server.end_work()

        running.append(end)
        server.end_here = end
        return server

    yield start
    for end in running:
        end()


@pytest.fixture
def follow(tmp_path):
    """Function: what makes the session of a scene file, as the command does."""

    def opener(path):
        def opened(tell):
            from solidwhirl.watch.scene_file import SceneFile
            from solidwhirl.watch.session import Session

            return Session(SceneFile(path, tmp_path / "stages"), tell)

        return opened

    return opener


@pytest.fixture
def watched(follow):
    """Function: a session of a file that runs, and what it tells."""
    running = []

    def start(path):
        told = Told()
        session = follow(path)(told)
        running.append(session)
        session.start()
        return session, told

    yield start
    for session in running:
        assert session.end()
