"""Scenes that several tests share; what takes seconds is computed once per session."""

from __future__ import annotations

import copy
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from solidwhirl.build import cylinder
from solidwhirl.cli import app

ROOT = Path(__file__).resolve().parents[2]
# scenes that some tests build in the same way lie beside them
sys.path.insert(0, str(Path(__file__).parent))

# A shaft with a disk on two bearings: coarse, so that a run takes a tenth of a second.
SMALL = {
    "name": "small",
    "model": {"accuracy": 0.05, "modes": 3, "estimates": "off"},
    "campbell": {"branches": 4},
    "bodies": {
        "rotor": {
            "material": "steel",
            "sections": [
                cylinder("shaft", 0.0, 0.4, 0.02),
                cylinder("disk", 0.1, 0.14, 0.12, inner_radius_m=0.02),
            ],
            "interfaces": [
                {"name": "left", "kind": "section", "at_m": 0.0},
                {"name": "right", "kind": "section", "at_m": 0.4},
            ],
        }
    },
    "bearings": [
        {"name": "left", "first": "rotor.left", "stiffness_n_per_m": 1e7},
        {"name": "right", "first": "rotor.right", "stiffness_n_per_m": 1e7},
    ],
}


def build_small(rpm=(0.0, 15000.0, 30000.0), bearing=None, body=None, **tables):
    """The small scene as data; `bearing` and `body` are added to its first bearing and its body."""
    data = copy.deepcopy(SMALL)
    if rpm is not None:
        data["speeds"] = {"list_rpm": list(rpm)}
    data["bearings"][0].update(bearing or {})
    data["bodies"]["rotor"].update(body or {})
    for name, table in tables.items():
        data[name] = {**data.get(name, {}), **table}
    return data


@pytest.fixture(scope="session")
def root():
    return ROOT


def on_meridians(text):
    """The twin rotor's file without its solids, and without what is shown beside them."""
    shown, _, rest = text.partition("# The same engine with its bodies on their meridians")
    _, _, references = rest.partition("# Tables 2 and 3 of the source")
    assert references and 'level = "solid"\n' in shown
    return shown.replace('level = "solid"\n', "") + references.partition("\n")[2]


@pytest.fixture(scope="session")
def scene_data():
    """Function: content of a file in scenes/ by name; of the twin rotor as of `ferraris`."""

    def load(name):
        text = (ROOT / "scenes" / f"{name}.toml").read_text(encoding="utf-8")
        return tomllib.loads(on_meridians(text) if name == "ferraris" else text)

    return load


@pytest.fixture(scope="session")
def small_scene():
    """Function: the small scene as data, with changes."""
    return build_small


@pytest.fixture(scope="session")
def computed(scene_data):
    """Function: results of a file in scenes/, each computed once; all its checks pass."""
    from solidwhirl.pipeline.run import run_for_page
    from solidwhirl.scene_reading.reader import parse_scene

    found = {}

    def run(name):
        if name not in found:
            found[name] = run_for_page(parse_scene(scene_data(name), folder=ROOT / "scenes"))
        return found[name]

    return run


@pytest.fixture
def invoke(tmp_path):
    """Function: run the command on a text; what it did, and whether it wrote results.

    A run that is refused late leaves its completed stages, and nothing else.
    """

    def run(content, *options, out="results"):
        path = tmp_path / "bad.toml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        arguments = ["run", str(path), "--out", str(tmp_path / out), *options]
        done = CliRunner().invoke(app, arguments)
        folder = tmp_path / "results"
        return done, folder.exists() and [p.name for p in folder.iterdir()] != [".stages"]

    return run


@pytest.fixture(scope="session")
def ferraris(root):
    """Text of the twin rotor on its meridians."""
    return on_meridians((root / "scenes" / "ferraris.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def changed():
    """Function: the text with its first `old` replaced."""

    def replace(text, old, new):
        assert old in text, old
        return text.replace(old, new, 1)

    return replace


@pytest.fixture(scope="session")
def refusal():
    """Function: check how a command ended that refused its input, and return the message."""

    def check(done, name):
        assert done.exit_code == 2, done.output
        assert isinstance(done.exception, SystemExit)
        assert done.stdout == ""
        assert done.stderr.startswith("error: ")
        assert name in done.stderr.splitlines()[0]
        assert "Traceback" not in done.stderr
        return done.stderr

    return check
