"""The commands that the documentation shows run as shown, and print what it says they print."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from pages import FOLLOWED, ROOT, blocks
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.pipeline.run import run_for_page
from solidwhirl.scene_reading.reader import read_scene

# Of the lines that a run prints: what differs from machine to machine.
VARYING = (
    (re.compile(r" \(about .* to go\)"), ""),
    (re.compile(r"^time .*"), "time"),
    (re.compile(r"\d[\d.]*( s\b| GiB)"), r"#\1"),
    (re.compile(r"\d+ unknowns"), "# unknowns"),
)


def even(line):
    """A printed line without what differs between machines, and with single spaces."""
    for pattern, replaced in VARYING:
        line = pattern.sub(replaced, line)
    return " ".join(line.split())


def assert_shown(shown, printed):
    """Every line shown is printed, in this order; `...` stands for lines left out."""
    lines = iter([even(line) for line in printed.splitlines()])
    for line in (even(line) for line in shown.splitlines() if line.strip()):
        if line != "...":
            assert line in lines, f"not printed, or not in this order: {line}\n{printed}"


def write_file(text, folder):
    """Write a TOML block to the file that its first line names, or at the end of it."""
    told = re.match(r"# (\S+\.toml)(, continued)?\n", text)
    if told is None:
        return
    path = folder / told[1]
    path.write_text((path.read_text() + "\n" if told[2] else "") + text)


def run_lines(text, folder):
    """Run the lines of a sh block one by one; what they print, errors among it."""
    here = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        ["sh", "-c", text],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=1200,
        check=False,
        env=os.environ | {"PATH": here, "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "200"},
    )
    return done.returncode, done.stdout


def run_here(text, folder):
    """The same with the commands of the program in this process, which has loaded it already."""
    code, printed = 0, []
    for chunk in re.findall(r"(?:^solidwhirl .*\n)|(?:^(?!solidwhirl ).*\n)+", text, re.MULTILINE):
        if not chunk.startswith("solidwhirl "):
            code, told = run_lines(chunk, folder)
        else:
            with contextlib.chdir(folder):
                done = CliRunner().invoke(app, shlex.split(chunk)[1:], env={"COLUMNS": "200"})
            code, told = done.exit_code, done.output
        printed.append(told)
    return code, "".join(printed)


def follow(page, folder, wanted, run=run_lines):
    """Do what a page says; how many blocks of commands were run."""
    (folder / "scenes").symlink_to(ROOT / "scenes", target_is_directory=True)
    count, printed = 0, None
    for mark, language, text in blocks(page):
        if language == "toml":
            write_file(text, folder)
        elif language == "text":
            if printed is not None:
                assert_shown(text, printed)
            printed = None
            continue
        printed = None
        if language == "sh" and mark in wanted:
            code, printed = run(text, folder)
            # a page may show an error, which is then what it prints
            assert code == 0 or printed.startswith("error:"), f"{page}: {text}{printed}"
            count += 1
    return count


@pytest.mark.parametrize("page", FOLLOWED)
def test_cheap_commands_of_a_page(page, tmp_path):
    assert follow(page, tmp_path, {"test"}, run_here) > 0


@pytest.mark.verify
@pytest.mark.solver
@pytest.mark.parametrize("page", FOLLOWED)
def test_all_commands_of_a_page(page, tmp_path):
    assert follow(page, tmp_path, {"test", "test: verify"}) > 0


def scene_files(page):
    """Files that the TOML blocks of a page are written to, in their order."""
    named = [re.match(r"# (\S+\.toml)\n", text) for _, kind, text in blocks(page) if kind == "toml"]
    return [told[1] for told in named if told]


# Solids take a quarter of a minute, the machine of all analyses some minutes.
LONG = ("keyed.toml", "machine.toml")


@pytest.mark.solver
@pytest.mark.parametrize(
    "file",
    [
        pytest.param(file, marks=[pytest.mark.verify] if file in LONG else [])
        for file in scene_files("docs/howto.md")
    ],
)
def test_scenes_of_the_how_tos_run_as_written(file, tmp_path):
    """All blocks of a scene together, with the options that it has by default."""
    for _, language, text in blocks("docs/howto.md"):
        if language == "toml":
            write_file(text, tmp_path)
    results = run_for_page(read_scene(tmp_path / file))
    assert list(results.analyses) == [spec.label for spec in results.scene.analyses]


def test_a_line_that_is_not_printed_would_be_found():
    printed = "one\n two  three\nfour 12.5 s\n"
    assert_shown("one\n...\ntwo three\nfour 3 s\n", printed)
    for wrong in ("two\n", "two three\none\n", "four 12.5 Hz\n"):
        with pytest.raises(AssertionError):
            assert_shown(wrong, printed)
