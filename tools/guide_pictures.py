"""Make the pictures of docs/tutorial.md, howto.md and blades.md from the scenes that stand there.

Those of asymmetric_rotors.md come from files in scenes/, that of README.md (docs/report.png) from
the twin rotor.

.venv/bin/python tools/guide_pictures.py      # needs chromium, `tools/setup.sh browser`
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parents[1] / "docs"
FENCE = re.compile(r"^```toml\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: Pictures by page: the scene in its blocks, and files of the run.
PAGES = {
    "tutorial": ("pump", ("unbalance_response",)),
    "howto": (
        "machine",
        (
            "separation_margins",
            "unbalance_response",
            "place_map",
            "critical_speed_map",
            "mode_shapes_6000rpm_participation",
            "static",
            "waterfall",
            "run_up_spectrogram",
            "rotating_campbell",
        ),
    ),
    "blades": (
        "wheel",
        ("mesh_rotor", "mode_critical_1", "nodal_diameters", "nodal_diameters_interference"),
    ),
}
#: Pages on files in scenes/: name of a picture there, scene and picture of the run.
OF_FILES = {
    "asymmetric_rotors": {
        "keyway_response": ("keyway_shaft", "asymmetric_response"),
        "keyway_run_up": ("keyway_shaft", "run_up"),
        "generator_response": ("two_pole_generator", "asymmetric_response"),
        "fan_campbell": ("two_bladed_fan", "campbell"),
        "crank_response": ("crank_mesh", "asymmetric_response"),
    }
}
#: Of these, pictures that a run does not draw by itself.
FURTHER = {"blades": ("mesh_rotor", "mode_critical_1")}
WIDTH = 900


def main() -> None:
    """Run the scenes of pages, all or those named, and copy what their pages show."""
    for page in sys.argv[1:] or (*PAGES, *OF_FILES, "report"):
        if page == "report":
            _report()
            continue
        if page in OF_FILES:
            _of_files(page)
            continue
        scene, pictures = PAGES[page]
        texts = FENCE.findall((DOCS / f"{page}.md").read_text(encoding="utf-8"))
        target = DOCS / page
        target.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{scene}.toml"
            path.write_text("".join(t for t in texts if t.startswith(f"# {scene}.toml")))
            command = [sys.executable, "-m", "solidwhirl", "run", path, "--out", f"{folder}/out"]
            subprocess.run([*command, "--pictures"], check=True)
            if page in FURTHER:
                only = [word for name in FURTHER[page] for word in ("--only", name)]
                subprocess.run([*command[:3], "pictures", *command[4:], *only], check=True)
            for name in pictures:
                _smaller(Path(folder) / "out" / f"{name}.png", target / f"{name}.png")
            if page == "tutorial":
                _first_screen(Path(folder) / "out" / "report.html", target / "first_screen.png")


def _of_files(page: str) -> None:
    """Run the scenes of a page that are files, and copy its pictures."""
    (DOCS / page).mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for scene in dict.fromkeys(scene for scene, _ in OF_FILES[page].values()):
            path = DOCS.parent / "scenes" / f"{scene}.toml"
            command = [sys.executable, "-m", "solidwhirl", "run", path, "--pictures", "--out"]
            subprocess.run([*command, f"{folder}/{scene}"], check=True)
        for name, (scene, picture) in OF_FILES[page].items():
            _smaller(Path(folder) / scene / f"{picture}.png", DOCS / page / f"{name}.png")


def _report() -> None:
    """Run the twin rotor on its meridians, and take the first screen of its page."""
    scene = DOCS.parent / "scenes" / "ferraris.toml"
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "solidwhirl", "run", scene, "--level", "harmonic", "--out"]
        subprocess.run([*command, f"{folder}/out"], check=True)
        _first_screen(Path(folder) / "out" / "report.html", DOCS / "report.png")


def _smaller(source: Path, target: Path) -> None:
    with Image.open(source) as image:
        size = (WIDTH, round(image.height * WIDTH / image.width))
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(64).save(target, optimize=True)


def _first_screen(page: Path, target: Path) -> None:
    shot = page.with_suffix(".png")
    subprocess.run(
        [
            "chromium",
            "--headless=new",
            "--no-sandbox",
            "--hide-scrollbars",
            "--window-size=1400,900",
            "--virtual-time-budget=20000",
            f"--screenshot={shot}",
            page.as_uri(),
        ],
        check=True,
    )
    _smaller(shot, target)


if __name__ == "__main__":
    main()
