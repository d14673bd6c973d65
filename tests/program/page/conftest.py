"""One browser, and one small run, for all tests of pages."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from browser import browser

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def driver():
    with browser() as found:
        yield found


@pytest.fixture(scope="session")
def laval():
    """The Laval rotor on the beam level, as a page reads it."""
    from solidwhirl.output.documents import results_document
    from solidwhirl.page.frame.records import Run
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.scene_reading.reader import read_scene, with_model

    path = ROOT / "scenes" / "laval.toml"
    results = run_scene(with_model(read_scene(path), level="beam", accuracy=None))
    return Run(
        results=results,
        document=results_document(results),
        scene_path=path,
        command="solidwhirl run scenes/laval.toml --level beam --out out/laval",
    )
