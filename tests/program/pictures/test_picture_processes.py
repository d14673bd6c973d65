"""Pictures of several processes are those of one, and fail as they do there."""

from __future__ import annotations

import importlib
import multiprocessing
import os
from functools import partial
from pathlib import Path

import pytest

from solidwhirl.core.outcome import Drawing
from solidwhirl.core.stages import silent
from solidwhirl.output import picture_processes
from solidwhirl.output.picture_processes import in_processes, in_turn
from solidwhirl.pictures.catalogue import pictures_of
from solidwhirl.pipeline.cached_stages import StageCache, open_store
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_titled_charts
from solidwhirl.scene_reading.reader import read_scene

SCENES = Path(__file__).parents[3] / "scenes"


@pytest.fixture(autouse=True)
def two_workers(monkeypatch):
    """Two processes, whatever the machine has."""
    monkeypatch.setattr(picture_processes, "_workers", lambda pictures: 2 if pictures > 1 else 1)


TELLING = """
import os
import sys

import solidwhirl.rotordyn.plots.matplotlib_chart

UNNEEDED = ("mpi4py", "petsc4py", "dolfinx", "gmsh", "pydantic", "solidwhirl.pipeline")


def tell(path):
    path.write_text(f"{os.getpid()} {[name for name in UNNEEDED if name in sys.modules]}")
"""


def well(path):
    path.write_text("drawn")


def no_ink(shown, path):
    raise AnalysisError(f"no ink for {shown}")


def drawn_by_the_parent(shown, path):
    """End a process of pictures as the system does where memory is short."""
    if multiprocessing.parent_process() is not None:
        os._exit(9)
    path.write_text(shown)


def test_they_are_the_same_and_what_is_kept_is_not_drawn_again(twin, tmp_path):
    """Diagrams, a mesh, and charts that an analysis makes of the run."""
    kept = StageCache(store=open_store(tmp_path / "stages"), progress=silent)
    response, *_ = read_scene(SCENES / "ferraris.toml").analyses
    asked = {"analyses": (response.model_copy(update={"count": 21}),)}
    run = run_scene(twin.scene.model_copy(update=asked))
    writes = {f"{p.name}.png": p.draw for p in pictures_of(run, modes=0)}
    assert any(isinstance(getattr(write, "draw", None), Drawing) for write in writes.values())
    found = []
    for begin in (in_turn, in_processes):
        folder = tmp_path / begin.__name__
        folder.mkdir()
        drawn = {
            folder / name: kept.picture(f"{begin.__name__} {name}", write)
            for name, write in writes.items()
        }
        with begin(drawn) as begun:
            for path, draw in begun.items():
                draw(path)
        found.append({path.name: path.read_bytes() for path in drawn})
    assert len(writes) > 5 and found[0] == found[1]
    with in_processes(drawn) as again:
        assert all(again[path] is draw for path, draw in drawn.items())


def test_the_processes_have_no_solvers(tmp_path, monkeypatch):
    """What draws a chart loads no more than that."""
    (tmp_path / "telling.py").write_text(TELLING)
    monkeypatch.syspath_prepend(tmp_path)
    telling = importlib.import_module("telling")
    pictures = {tmp_path / f"{k}.txt": telling.tell for k in range(2)}
    with in_processes(pictures) as begun:
        for path, draw in begun.items():
            draw(path)
    told = [path.read_text().partition(" ") for path in pictures]
    assert all(int(pid) != os.getpid() for pid, _, _ in told)
    assert {modules for _, _, modules in told} == {"[]"}


def test_one_that_fails_raises_at_its_turn_what_it_raised(tmp_path):
    pictures = {
        tmp_path / "a.txt": well,
        tmp_path / "b.txt": Drawing(shown=lambda: "b", draw=no_ink),
        tmp_path / "c.txt": Drawing(shown=partial(no_ink, "c", tmp_path), draw=draw_titled_charts),
        tmp_path / "d.txt": well,
    }
    with in_processes(pictures) as begun:
        for name, problem in (("b", "no ink for b"), ("c", "no ink for c")):
            with pytest.raises(AnalysisError, match=problem):
                begun[tmp_path / f"{name}.txt"](tmp_path / f"{name}.txt")
        begun[tmp_path / "d.txt"](tmp_path / "d.txt")
    assert (tmp_path / "d.txt").exists()


def test_what_an_ended_process_leaves_is_drawn_here(tmp_path):
    pictures = {
        tmp_path / f"{k}.txt": Drawing(shown=partial(str, k), draw=drawn_by_the_parent)
        for k in range(3)
    }
    with in_processes(pictures) as begun:
        for path, draw in begun.items():
            draw(path)
    assert [path.read_text() for path in pictures] == ["0", "1", "2"]
