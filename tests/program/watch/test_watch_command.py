"""`solidwhirl watch` as a user starts and ends it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app

PROGRAM = Path(sys.executable).parent / "solidwhirl"


@pytest.mark.parametrize(
    ("name", "said"),
    [("none.toml", "there is no such file or folder"), ("", "scene.json: no such file; run the")],
)
def test_what_can_not_be_watched_is_refused(tmp_path, refusal, name, said):
    done = CliRunner().invoke(app, ["watch", str(tmp_path / name), "--no-open"])
    assert said in refusal(done, str(tmp_path / name))


def test_it_prints_the_address_and_ends_with_an_interrupt(scene_path, tmp_path):
    (tmp_path / "tmp").mkdir()
    process = subprocess.Popen(
        [str(PROGRAM), "watch", scene_path.name, "--no-open"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONWARNINGS": "error", "TMPDIR": str(tmp_path / "tmp")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # a job in the background ignores interrupts, and so would its children
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        address = process.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(address, timeout=60) as page:
            assert b"solidwhirl watch" in page.read()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=120)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 0, said
    assert said.splitlines() == ["follows rotor.toml; Ctrl-C ends it"]
    assert list((tmp_path / "tmp").iterdir()) == []
    assert sorted(p.name for p in tmp_path.iterdir()) == ["rotor.toml", "tmp"]


def test_the_browser_is_not_started_with_the_token(scene_path, tmp_path):
    """Who lists processes sees the words that a browser is started with."""
    words, browser = tmp_path / "words", tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$@" > {words}.new && mv {words}.new {words}\n')
    browser.chmod(0o755)
    process = subprocess.Popen(
        [str(PROGRAM), "watch", scene_path.name],
        cwd=tmp_path,
        env={**os.environ, "BROWSER": str(browser)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        address = process.stdout.readline().strip()
        for _ in range(1200):
            if words.exists():
                break
            time.sleep(0.05)
        (said,) = words.read_text().split()
        assert address.split("/")[3] not in said
        page = Path(said.removeprefix("file://"))
        assert address in page.read_text() and page.parent.stat().st_mode & 0o077 == 0
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    finally:
        process.kill()
        process.communicate()
