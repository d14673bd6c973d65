"""Scenes and scripts of the tests of faults."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

RIGID = """
name = "rotor"
title = '{title}'
notes = {notes}
[speeds]
from_rpm = 0
to_rpm = 3000
count = 3
[campbell]
branches = 2
[rigid_bodies.rotor]
speed_ratio = 1.0
mass_kg = 10.0
center_of_gravity_m = [0.0, 0.0, 0.1]
inertia_kg_m2 = [0.1, 0.1, 0.15]
interfaces = {{ a = 0.0, b = 0.3 }}
[[bearings]]
name = "a"
first = "rotor.a"
stiffness_n_per_m = 1e6
[[bearings]]
name = "b"
first = "rotor.b"
stiffness_n_per_m = 1e6
"""
FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))


@pytest.fixture(scope="session")
def scene_path():
    """Function: path of a scene of these tests."""
    return lambda name: FOLDER / f"{name}.toml"


@pytest.fixture
def one_body(scene_path, tmp_path):
    """Function: path of the scene of one body under a name of its own, with texts replaced."""

    def write(name, **changes):
        text = scene_path("one_body").read_text(encoding="utf-8")
        for before, after in {'name = "one_body"': f'name = "{name}"', **changes}.items():
            assert before in text
            text = text.replace(before, after)
        path = tmp_path / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def rigid_scene(tmp_path):
    """Function: path of a new scene of a rigid rotor with a title and notes."""

    def write(title, notes=()):
        path = tmp_path / "scene.toml"
        path.write_text(RIGID.format(title=title, notes=json.dumps(notes)), encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="session")
def script():
    """Function: run one of the scripts beside this file, return what it prints."""

    def run(name, *arguments, prefix=()):
        done = subprocess.run(
            [*prefix, sys.executable, str(FOLDER / name), *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=1800,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run
