"""Texts of scene and problem files: planned or refused with a message; nothing else happens."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest
from scene_damage import damage_text
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.core.errors import SceneError
from solidwhirl.geometry import GeometryError
from solidwhirl.identify.problem import read_problem
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.scene_reading.reader import read_scene

# After the name of the file: a key, or what is wrong with the whole file.
PLACE = (
    r"[\w\"'][^:\n]*: |is not valid TOML|is not UTF-8|begins with a byte order mark"
    r"|has [0-9]+ bytes|is no regular file|no such file|a key of more than 16 names"
    r"|can not be read|\[key\]"
)
# Longest time for one input [s of processor time]; all are far below on any machine.
LONGEST_S = 20.0


def outcome(path):
    """ "planned", or the message as the command line shows it."""
    try:
        if path.parent.name == "identify":
            read_problem(path)
        else:
            scene = read_scene(path)
            make_plan(scene, build_bodies(scene))
    except SceneError as error:
        return str(error)
    except GeometryError as error:
        return f"{path}: {error}"
    return "planned"


@pytest.fixture
def survive(scenes, check_message):
    """Function: damage texts and check every outcome; how many were planned and refused."""
    originals = sorted(p for p in scenes.glob("**/*.toml") if p.name != "damaged.toml")

    def check(first, count):
        planned = refused = 0
        for seed in range(first, first + count):
            rng = random.Random(seed)
            original = rng.choice(originals)
            text, what = damage_text(original.read_bytes(), rng)
            path = original.with_name("damaged.toml")
            path.write_bytes(text)
            begin = time.process_time()
            found = outcome(path)
            assert time.process_time() - begin < LONGEST_S, (seed, what)
            if found == "planned":
                planned += 1
                continue
            refused += 1
            file = path
            if found.startswith(f"{path}: the scene at the start"):
                file = f"{path}: the scene at the start"
            elif not found.startswith(str(path)):  # a problem file that names another scene
                file = found.partition(": ")[0]
                assert file.startswith(str(scenes)), found[:200]
            check_message(found, file, PLACE)
        return planned, refused

    return check


def test_damaged_text(survive):
    """500 inputs."""
    planned, refused = survive(0, 500)
    assert planned > 50
    assert refused > 325


@pytest.mark.verify
@pytest.mark.parametrize("part", range(2))
def test_many_more(survive, part):
    survive(100_000 + 3600 * part, 3600)


LARGE = {
    "comment": b"#" * 3_999_999,
    "key": b"k" * 3_999_000 + b" = 1",
    "text": b'name = "' + b"x" * 3_999_000 + b'"',
    "escapes": b'name = "' + b"\\n" * 1_900_000 + b'"',
    "array": b"notes = [" + b'"a",' * 200_000 + b"]",
    "numbers": b"speeds.list_rpm = [" + b"1," * 300_000 + b"]",
    "tables": b"[[bearings]]\n" * 40_000,
    "tables by name": b"".join(b"[bodies.b%d]\n" % k for k in range(30_000)),
    "keys": b"".join(b"k%d = 1\n" % k for k in range(40_000)),
    "dots": b"a." * 1_990_000 + b"a = 1",
    "spaced dots": b"a . " * 990_000 + b"a = 1",
    "quoted dots": b'"\\"" . ' * 600_000 + b"a = 1",
    "dots in a header": b"[" + b"a." * 1_990_000 + b"a]",
    "brackets": b"x = " + b"[" * 3_900_000,
    "tables in tables": b"x = " + b"{a = " * 700_000,
    "quotes": b"x = " + b"'" * 3_900_000,
    "spaces": b" " * 3_999_000,
    "lines": b"\n" * 3_999_999,
    "one byte too many": b"#" * 4_000_001,
}


@pytest.mark.parametrize("name", LARGE)
def test_large_files_are_refused_in_seconds(tmp_path, name, check_message):
    path = tmp_path / "large.toml"
    path.write_bytes(LARGE[name])
    begin = time.process_time()
    message = outcome(path)
    assert time.process_time() - begin < LONGEST_S
    check_message(message, path, PLACE)


def test_device_that_never_ends(check_message):
    check_message(outcome(Path("/dev/zero")), "/dev/zero", PLACE)


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        ("/dev/zero", "is no file"),
        ("..", "is no file"),
        ("/etc/passwd", "not valid TOML|can not be read"),
        ("a\\u0000b", "control character"),
        ("x" * 1001, "at most 1000 characters"),
        ("\\u001b[2J", "control character"),
    ],
)
def test_scene_that_a_problem_names(scenes, scene, said):
    original = (scenes / "identify" / "uhbr_fan.toml").read_text(encoding="utf-8")
    path = scenes / "identify" / "damaged.toml"
    path.write_text(original.replace("../uhbr_fan.toml", scene), encoding="utf-8")
    with pytest.raises(SceneError, match=said) as caught:
        read_problem(path)
    assert "\x1b" not in str(caught.value)


def commands(path, out):
    return {
        "run": ["run", str(path), "--out", str(out), "--quiet"],
        "plan": ["plan", str(path)],
        "study": ["study", str(path), "--out", str(out), "--quick", "--quiet"],
        "identify": ["identify", str(path), "--out", str(out / "scene.toml"), "--quiet"],
    }


def refused_inputs(scenes, kind, count):
    """Damaged files that are refused when they are read, of scenes or of problems."""
    pattern = "identify/*.toml" if kind == "identify" else "*.toml"
    originals = sorted(p for p in scenes.glob(pattern) if p.name != "damaged.toml")
    seed = 50_000
    while count:
        seed += 1
        rng = random.Random(seed)
        original = rng.choice(originals)
        text, _ = damage_text(original.read_bytes(), rng)
        path = original.with_name("damaged.toml")
        path.write_bytes(text)
        try:
            read_problem(path) if kind == "identify" else read_scene(path)
        except SceneError:
            count -= 1
            yield path


@pytest.mark.parametrize("command", ["run", "plan", "study", "identify"])
def test_command_line_refuses_without_a_trace(scenes, tmp_path, command):
    """8 inputs each: exit code 2, one message, no traceback, nothing written."""
    out = tmp_path / "out"
    for path in refused_inputs(scenes, command, 8):
        done = CliRunner().invoke(app, commands(path, out)[command])
        assert done.exit_code == 2, done.output
        assert isinstance(done.exception, SystemExit)
        assert done.stdout == ""
        assert done.stderr.startswith("error: ")
        assert "Traceback" not in done.stderr
        assert len(done.stderr) < 4000
        assert all(c.isprintable() or c == "\n" for c in done.stderr)
        assert list(tmp_path.iterdir()) == []
