"""Compute every table and figure of Müller and Hennings; write docs/paper.md and its data.

`python tools/paper` runs the scenes that belong to the paper and writes the page with its pictures.
"""

from __future__ import annotations

import json
import shutil
import sys
import time
from functools import cached_property
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from paper.engine import engine_sections  # noqa: E402
from paper.rows import Row, document  # noqa: E402
from paper.twin_rotor import twin_sections  # noqa: E402

from solidwhirl.core.versions import package_versions  # noqa: E402
from solidwhirl.output.documents import write_results  # noqa: E402
from solidwhirl.pipeline.run import Results, run_scene  # noqa: E402
from solidwhirl.scene_reading.reader import read_scene, scene_hash  # noqa: E402

PAGE = ROOT / "docs" / "paper.md"
DATA = ROOT / "docs" / "data" / "paper.json"
PICTURES = ROOT / "docs" / "paper"

HEAD = """# The paper, figure by figure

T. S. Müller and H. Hennings, *Rotordynamic Validation of a Twin Rotor-bearing System Considering
Gyroscopic Forces and Bearing Dynamics with a Multibody Formulation: Application to a Geared UHBR
Gas Turbine* (German Aerospace Center): what it prints beside what this program computes. Written by
`make paper` from the scenes named below; all rows are in [data/paper.json](data/paper.json).

The column *input* says where ours comes from: *paper*, all input is printed there; *inferred*,
positions follow from the printed results; *identified*, geometry was fitted to the printed masses
and frequencies ([identify.md](identify.md)); *assumed*, the paper does not say.

"""


class Run:
    """Results of a scene, as records and as plain data, and the folder with its files.

    A folder that was written from the same scene by the same program is used again.
    """

    def __init__(self, name: str, folder: Path) -> None:
        scene = read_scene(ROOT / "scenes" / f"{name}.toml")
        self.name, self.folder = name, folder / name
        self._scene = scene
        known = self.folder / "results.json"
        if known.exists():
            self.document: dict[str, Any] = json.loads(known.read_text(encoding="utf-8"))
            same_scene = self.document["scene"]["sha256"] == scene_hash(scene)
            same_packages = self.document["packages"] == package_versions()
            if same_scene and same_packages and known.stat().st_mtime > _last_change():
                print(f"{name}: as computed before", file=sys.stderr)
                return
        start = time.perf_counter()
        results = run_scene(scene, progress=lambda text: print(f"  {text}", file=sys.stderr))
        assert results is not None
        write_results(results, self.folder)
        self.document = json.loads(known.read_text(encoding="utf-8"))
        print(f"{name}: {time.perf_counter() - start:.0f} s", file=sys.stderr)

    @cached_property
    def results(self) -> Results:
        """The records, computed anew if need be."""
        results = run_scene(self._scene)
        assert results is not None
        return results

    def picture(self, file: str, text: str) -> str:
        """Copy a picture beside the page and return the Markdown that shows it."""
        target = PICTURES / f"{self.name}_{file}"
        shutil.copyfile(self.folder / file, target)
        return f"![{text}](paper/{target.name})"


def _last_change() -> float:
    """When a file of the program was last written."""
    folders = ("geometry", "meshing", "reduction", "rotordyn", "solidwhirl")
    return max(f.stat().st_mtime for name in folders for f in (ROOT / name).rglob("*.py"))


def main() -> None:
    """Run the scenes and write the page."""
    PICTURES.mkdir(exist_ok=True)
    names = ("ferraris", "ferraris_paper", "uhbr_fan", "uhbr_lp", "uhbr_hp", "uhbr_engine")
    chosen = sys.argv[1:] or names
    runs = {name: Run(name, ROOT / "out" / "paper") for name in chosen}
    if set(runs) != set(names):
        return
    told: dict[str, list[Row]] = {}
    sections = [*twin_sections(runs, told), *engine_sections(runs, told)]
    PAGE.write_text(HEAD + "\n\n".join(sections) + "\n", encoding="utf-8")
    DATA.write_text(document(told), encoding="utf-8")
    print(f"written: {PAGE}", file=sys.stderr)


if __name__ == "__main__":
    main()
