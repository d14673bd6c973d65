"""Output that can not be written ends no command with a traceback, and loses no result."""

from __future__ import annotations

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


def in_shell(options, scene, out):
    """A run of the scene by a line of bash."""
    line = f'"$0" -m solidwhirl run "$1" --out "$2" --no-pictures {options}'
    return subprocess.run(
        ["bash", "-c", line, sys.executable, scene, out],
        capture_output=True,
        encoding="latin-1",
        timeout=120,
        check=False,
    )


def test_closed_streams_change_nothing(scene, tmp_path):
    """No file gets the descriptor of a closed stream, and with it what is printed there."""
    done = in_shell("1>&- 2>&- <&-", scene, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert verify_folder(tmp_path / "out") == []


def test_reader_that_leaves_early_is_no_failure(scene, tmp_path):
    line = "--json | head -c 1 > /dev/null; exit ${PIPESTATUS[0]}"
    done = in_shell(line, scene, tmp_path / "out")
    assert (done.returncode, "Traceback" in done.stderr) == (0, False)


@pytest.mark.parametrize(
    "encoding", ["ascii:strict", pytest.param("latin-1", marks=pytest.mark.verify)]
)
def test_letters_that_the_encoding_lacks_are_escaped(scene, tmp_path, monkeypatch, encoding):
    """And nothing is said where the messages can not be written."""
    monkeypatch.setenv("PYTHONIOENCODING", encoding)
    done = in_shell("2>/dev/full", scene, tmp_path / "out")
    assert done.returncode == 0
    assert r"\u2192 \u03c0" in done.stdout.splitlines()[0]
    assert verify_folder(tmp_path / "out") == []
