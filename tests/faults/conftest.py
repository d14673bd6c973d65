"""Scenes and scripts of the tests of faults."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent


@pytest.fixture(scope="session")
def scene_path():
    """Function: path of a scene of these tests."""
    return lambda name: FOLDER / f"{name}.toml"


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
