"""What the command refuses besides a wrong scene: files, options and folders."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", ["name: missing", "name: missing"]),
        (b"name = = 3", ["is not valid TOML", "line 1"]),
        (b'name = "a"\nname = "b"', ["is not valid TOML"]),
        (b'name = "\xff"', ["is not UTF-8 text (byte 8)"]),
        (b"\x00\x01\x02", ["is not valid TOML"]),
        (b"[" * 100_000, ["is not valid TOML"]),
        (b"#" * 4_000_001, ["larger than 4000000 bytes"]),
    ],
)
def test_file_that_is_no_scene(invoke, content, said, refusal):
    done, written = invoke(content)
    message = refusal(done, "bad.toml")
    for text in said:
        assert text in message
    assert not written


def test_file_that_can_not_be_read(tmp_path, refusal):
    for path, said in ((tmp_path / "none.toml", "No such file"), (tmp_path, "Is a directory")):
        for command in (["run", str(path), "--out", str(tmp_path / "out")], ["plan", str(path)]):
            message = refusal(CliRunner().invoke(app, command), path.name)
            assert f"can not be read: {said}" in message
            assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--level", "plate"), ["--level", "'auto', 'beam', 'harmonic' or", "found 'plate'"]),
        (("--accuracy", "5"), ["--accuracy", "less than or equal to 0.1", "found 5.0"]),
        (("--accuracy", "0"), ["--accuracy", "greater than or equal to 0.000001", "found 0.0"]),
        (("--accuracy", "nan"), ["--accuracy", "found nan"]),
    ],
)
def test_bad_option(invoke, ferraris, options, said, refusal):
    done, written = invoke(ferraris, *options)
    message = refusal(done, "command line")
    for text in said:
        assert text in message
    assert not written


def test_option_that_contradicts_the_scene(invoke, ferraris, changed, refusal):
    done, _ = invoke(changed(ferraris, "[model]", "[model]\norder = 4"), "--level", "solid")
    assert "--level: order = 4 with level 'solid'" in refusal(done, "command line")


def test_option_that_is_no_number(invoke, ferraris):
    """typer's own message."""
    done, written = invoke(ferraris, "--accuracy", "fine")
    assert done.exit_code == 2
    assert "--accuracy" in done.stderr
    assert "valid number" in done.stderr
    assert "Traceback" not in done.stderr
    assert not written


def test_output_that_is_no_folder(invoke, ferraris, tmp_path, refusal):
    (tmp_path / "taken").write_text("kept", encoding="utf-8")
    for out in ("taken", "taken/below/it"):
        done, _ = invoke(ferraris, out=out)
        message = refusal(done, out)
        assert "can not be written" in message
        assert "is not a folder" in message
        assert "mesh " not in message
    assert (tmp_path / "taken").read_text(encoding="utf-8") == "kept"


def test_output_without_permission(invoke, ferraris, tmp_path, monkeypatch, refusal):
    """By a stand-in for the system's answer, since root may write everywhere."""
    real = os.access

    def access(path, mode, **options):
        return Path(path) != tmp_path and real(path, mode, **options)

    monkeypatch.setattr(os, "access", access)
    done, written = invoke(ferraris)
    message = refusal(done, "results")
    assert "can not be written: no permission in" in message
    assert "mesh " not in message
    assert not written


def test_installed_command(tmp_path, ferraris, changed):
    """As a user starts it: exit code 2, one line on stderr, no traceback, no folder."""
    (tmp_path / "bad.toml").write_text(changed(ferraris, "1e10", "-inf"), encoding="utf-8")
    command = [str(Path(sys.executable).parent / "solidwhirl"), "run", "bad.toml", "--out", "out"]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env={**os.environ, "PYTHONWARNINGS": "error"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) <= 2  # both diagonal entries of the matrix
    assert "bad.toml: bearings[0].stiffness_n_per_m" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()
