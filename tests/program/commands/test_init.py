"""Scenes that `solidwhirl init` writes: they run as they are, and what they comment is so."""

from __future__ import annotations

import math
import tomllib

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.commands.init import KINDS
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.scene_reading.reader import parse_scene, read_scene


def init(*arguments):
    return CliRunner().invoke(app, ["init", *map(str, arguments)])


@pytest.mark.parametrize("kind", KINDS)
def test_scene_is_planned(tmp_path, kind):
    path = tmp_path / "new" / f"my_{kind}.toml"
    done = init(path, "--kind", kind)
    assert done.exit_code == 0, done.stderr
    assert f"solidwhirl run {path}\n" in done.stdout
    scene = read_scene(path)
    assert scene.name == f"my_{kind}"
    assert len(make_plan(scene, build_bodies(scene)).analyses) >= 2
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    assert str(path) in text
    assert max(map(len, lines)) <= 100 + len(str(path))
    assert sum("#" in line for line in lines) > 12
    # keys in comments work, all lines that begin with "#=" at once
    assert text.count("\n#= ") >= 2
    after = parse_scene(tomllib.loads(text.replace("\n#= ", "\n")))
    make_plan(after, build_bodies(after))
    assert after != scene


def test_default_file_that_is_there_is_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "rotor.toml"
    path.write_text("mine", encoding="utf-8")
    done = init(path)
    assert done.exit_code == 2
    assert done.stderr == f"error: {path}: is there already; --force replaces it\n"
    assert path.read_text(encoding="utf-8") == "mine"
    assert init("--force").exit_code == 0
    assert read_scene(path).name == "rotor"


def test_name_that_is_none_and_file_that_needs_quotes(tmp_path):
    path = tmp_path / "2 rotors & more.toml"
    done = init(path, "--kind", "twin")
    assert done.exit_code == 0
    assert f"solidwhirl plan '{path}'" in done.stdout
    assert read_scene(path).name == "twin"
    odd = tmp_path / "a\nname = 3.toml"
    assert init(odd).exit_code == 0
    assert read_scene(odd).name == "laval"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("x.toml", "--kind", "car"), "--kind: found 'car'; allowed are laval, twin, engine"),
        (("/dev/null/x.toml",), "can not be written: /dev/null is not a folder"),
    ],
)
def test_refusals(tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    done = init(*arguments)
    assert done.exit_code == 2
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.verify
@pytest.mark.solver
@pytest.mark.parametrize("kind", KINDS)
def test_scene_runs_with_everything(tmp_path, kind):
    path = tmp_path / f"{kind}.toml"
    init(path, "--kind", kind)
    done = CliRunner().invoke(app, ["run", str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.stderr


@pytest.mark.solver
def test_first_critical_speed_of_the_first_scene(tmp_path):
    """Between a disk that leaves the shaft as it is and one that makes it rigid where it sits.

    The massless shaft between simple supports has k = 6 E I / (L/2 - a)^3 with a rigid middle of
    length 2 a, in series with two bearings; 17/35 of its mass move with the disk. Shear, left out,
    takes less than 0.6 % of the stiffness.
    """
    from solidwhirl.pipeline.run import run_scene

    path = tmp_path / "a.toml"
    init(path)
    scene = read_scene(path)
    model = scene.model.model_copy(update={"level": "beam", "estimates": "off"})
    beams = scene.model_copy(update={"model": model})
    found = run_scene(beams.model_copy(update={"analyses": ()}))
    inertia, length = math.pi / 4 * 0.015**4, 0.6
    disk_kg = 7800 * math.pi * (0.12**2 - 0.015**2) * 0.04
    mass_kg = disk_kg + 17 / 35 * 7800 * math.pi * 0.015**2 * length
    speeds = [c.critical.speed_rad_s for c in found.critical_speeds[:2]]
    for speed, bearing in zip(speeds, (2e7, 3e7), strict=True):
        bounds = []
        for rigid_half in (0.0, 0.02):
            shaft_n_per_m = 6 * 2.0e11 * inertia / (length / 2 - rigid_half) ** 3
            stiffness = 1 / (1 / shaft_n_per_m + 1 / (2 * bearing))
            bounds.append(math.sqrt(stiffness / mass_kg))
        assert 0.997 * bounds[0] < speed < bounds[1]
