"""Runs of the scenes of the paper, what the paper prints, and pictures beside the page."""

from __future__ import annotations

import json
import shutil
import sys
import tomllib
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from solidwhirl.cache.files import StageStore
from solidwhirl.core.blocks import numbers
from solidwhirl.core.versions import package_versions
from solidwhirl.output.documents import write_results
from solidwhirl.pipeline.run import run_for_page
from solidwhirl.reduced_scene import ReducedScene
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots.chart import Chart
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.scene_reading.reader import read_scene, scene_hash
from solidwhirl.watch.saved_run import read_run

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "paper.md"
PICTURES = ROOT / "docs" / "paper"
FOLDER = ROOT / "out" / "paper"
#: What the paper prints
SOURCE: dict[str, Any] = tomllib.loads(
    Path(__file__).with_name("source.toml").read_text(encoding="utf-8")
)
#: Where stages and variants are kept
STORE = StageStore(FOLDER / "stages")


class Run:
    """Results of a scene, as records and as plain data, and the folder with its files.

    A folder that was written from the same scene by the same program is used again.
    """

    def __init__(self, name: str) -> None:
        scene = read_scene(ROOT / "scenes" / f"{name}.toml")
        self.name, self.folder, self.scene = name, FOLDER / name, scene
        known = self.folder / "results.json"
        if known.exists():
            self.document: dict[str, Any] = json.loads(known.read_text(encoding="utf-8"))
            same_scene = self.document["scene"]["sha256"] == scene_hash(scene)
            same_packages = self.document["packages"] == package_versions()
            passed = not self.document["accuracy"]["failed_checks"]
            is_new = known.stat().st_mtime > _last_change()
            if same_scene and same_packages and passed and is_new:
                print(f"{name}: as computed before", file=sys.stderr)
                return
        results = run_for_page(scene, progress=_told, store=STORE)
        write_results(results, self.folder)
        self.document = json.loads(known.read_text(encoding="utf-8"))

    @cached_property
    def saved(self) -> ReducedScene:
        """The bodies of the run on its supports, from its files."""
        return read_run(self.folder).reduced

    def analysis(self, name: str) -> dict[str, Any]:
        """What an analysis found."""
        found: dict[str, Any] = self.document["analyses"][name]
        return found

    def branches(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Speeds of the Campbell diagram, rpm, and a quantity of its branches there, (b, s)."""
        found = self.document["campbell"]
        speeds = numbers(found["speed_rpm"])
        return speeds, numbers(found[key]).reshape(-1, speeds.size)

    @property
    def errors_at_rest(self) -> list[float]:
        """Estimated relative errors of the frequencies at rest."""
        return list(self.document["modes_at_rest"]["frequency_error_estimate"])

    def picture(self, file: str, text: str) -> str:
        """Copy a picture beside the page and return the Markdown that shows it."""
        target = PICTURES / f"{self.name}_{file}"
        PICTURES.mkdir(exist_ok=True)
        shutil.copyfile(self.folder / file, target)
        return f"![{text}](paper/{target.name})"


def drawn(charts: Sequence[Chart], file: str, title: str, text: str) -> str:
    """Draw charts beside the page and return the Markdown that shows them."""
    PICTURES.mkdir(exist_ok=True)
    draw_charts(charts, PICTURES / file, title)
    return f"![{text}](paper/{file})"


def _told(text: str) -> None:
    print(f"  {text}", file=sys.stderr)


def _last_change() -> float:
    """When a file of the program was last written."""
    folders = ("geometry", "meshing", "reduction", "rotordyn", "solidwhirl")
    return max(f.stat().st_mtime for name in folders for f in (ROOT / name).rglob("*.py"))
