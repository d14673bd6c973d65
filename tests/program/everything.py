"""The run of `everything.toml`, once for the tests of sections, datasets and files."""

from __future__ import annotations

from functools import cache
from pathlib import Path

SCENE = Path(__file__).with_name("everything.toml")


@cache
def everything():
    """A run with every analysis of an engine without solids, as a page reads it."""
    from solidwhirl.output.documents import results_document
    from solidwhirl.page.frame.records import Run
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.scene_reading.reader import read_scene

    results = run_scene(read_scene(SCENE))
    return Run(results=results, document=results_document(results), scene_path=SCENE)
