"""Output that can not be written ends no command with a traceback, and loses no result."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from solidwhirl.files.run_folder import verify_folder


def command(words, **options):
    return subprocess.run(
        [sys.executable, "-m", "solidwhirl", *map(str, words)],
        text=True,
        timeout=120,
        check=False,
        stderr=subprocess.PIPE,
        **options,
    )


@pytest.fixture
def scene(rigid_scene):
    return rigid_scene("Läufer → π")


@pytest.mark.parametrize("words", [["--help"], ["plan", "SCENE"]])
def test_full_disk_is_one_message(words, scene):
    words = [scene if word == "SCENE" else word for word in words]
    with Path("/dev/full").open("w") as full:
        done = command(words, stdout=full)
    assert done.returncode == 2
    assert done.stderr == (
        "error: the standard output can not be written: No space left on device\n"
    )


def test_results_are_kept_when_the_summary_can_not_be_written(scene, tmp_path):
    words = ["run", scene, "--out", tmp_path / "out", "--no-pictures", "--json"]
    with Path("/dev/full").open("w") as full:
        done = command(words, stdout=full)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("error: the standard output can not be written")
    assert verify_folder(tmp_path / "out") == []


@pytest.mark.parametrize("closing", ["1>&- 2>&- <&-", "2>/dev/full"])
def test_closed_streams_change_nothing(scene, tmp_path, closing):
    """No file gets the descriptor of a closed stream, and with it what is printed there."""
    line = f'exec "$0" -m solidwhirl run "$1" --out "$2" --no-pictures {closing}'
    out = tmp_path / "out"
    done = subprocess.run(
        ["sh", "-c", line, sys.executable, scene, out],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert verify_folder(out) == []


def test_reader_that_leaves_early_is_no_failure(scene, tmp_path):
    line = '"$0" -m solidwhirl run "$1" --out "$2" --no-pictures --json | head -c 1 > /dev/null; '
    done = subprocess.run(
        ["bash", "-c", line + "exit ${PIPESTATUS[0]}", sys.executable, scene, tmp_path / "out"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, "Traceback" in done.stderr) == (0, False)


@pytest.mark.parametrize("encoding", ["ascii:strict", "latin-1"])
def test_letters_that_the_encoding_lacks_are_escaped(scene, tmp_path, encoding):
    done = command(
        ["run", scene, "--out", tmp_path / "out", "--no-pictures"],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONIOENCODING": encoding},
        encoding="latin-1",
    )
    assert done.returncode == 0, done.stderr
    assert r"\u2192 \u03c0" in done.stdout.splitlines()[0]
