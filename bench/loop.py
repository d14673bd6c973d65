"""The loop of a user: a bearing is changed, and the scene computed again.

CPU seconds of processes of their own, on one core: a cold run, a run after a change of a bearing,
the same scene again, 20 bearings as a batch; against what the engine alone costs (imports, Campbell
diagram, critical speeds, estimates). And in one process: `run_scene` with a store, and the same
bodies as `ReducedScene`. Ratios are what to quote.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from solidwhirl.scene.records import Scene

ROOT = Path(__file__).resolve().parents[1]
CASES = 20
# A steel shaft with a disk on two springs, whose engine has 30 coordinates.
SMALL_MODES = 6
# Ranks on one machine: root is allowed, and waiting ranks sleep.
MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
}
# What the engine alone needs: nothing of a page, nothing of files.
FLOOR = """
import sys
from solidwhirl.pipeline.cached_stages import open_store
from solidwhirl.reduced_scene import reduce_scene
from solidwhirl.scene_reading.reader import read_scene

found = reduce_scene(read_scene(sys.argv[1]), store=open_store(sys.argv[2]))
found.estimates()
"""


def cpu_s(*command: str) -> float:
    """CPU seconds of a command and its children."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    # modules are compiled once, as where they are installed, also where the shell forbids it
    env = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"} | MPI
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=ROOT, env=env)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def changed(scene: Path, bearing: str, factor: float, analyses: bool, name: str = "") -> str:
    """The scene with another stiffness, as a file's text."""
    from solidwhirl.build import with_changes
    from solidwhirl.identify.scene import scene_text
    from solidwhirl.scene_reading.reader import read_scene

    found = read_scene(scene)
    own = next(b for b in found.bearings if b.name == bearing)
    given = own.stiffness_n_per_m
    value = (factor * np.array(given)).tolist()
    found = with_changes(found, {f"bearings[{bearing}].stiffness_n_per_m": value})
    if not analyses:
        found = found.model_copy(update={"analyses": ()})
    if name:
        found = found.model_copy(update={"name": name})
    return scene_text(found.model_dump(mode="json", exclude_unset=True, exclude_none=True), {})


def in_processes(scene: Path, bearing: str, analyses: bool) -> dict[str, float]:
    """A cold run, an edit, the same again, and the engine alone."""
    with tempfile.TemporaryDirectory() as folder:
        path, out = Path(folder) / "scene.toml", Path(folder) / "out"
        run = [sys.executable, "-m", "solidwhirl", "run", str(path), "--out", str(out), "-q"]

        def computed(factor: float) -> float:
            path.write_text(changed(scene, bearing, factor, analyses), encoding="utf-8")
            return cpu_s(*run)

        found = {"cold_s": computed(1.0), "edit_s": computed(1.1), "again_s": computed(1.1)}
        path.write_text(changed(scene, bearing, 1.2, False), encoding="utf-8")
        store = Path(folder) / "store"
        shutil.copytree(out / ".stages", store)
        found["engine_alone_s"] = cpu_s(sys.executable, "-c", FLOOR, str(path), str(store))
        found["batch_s"] = _batch(Path(folder), scene, bearing)
    return found


def _batch(folder: Path, scene: Path, bearing: str) -> float:
    """20 bearings on two ranks."""
    paths = []
    for k in range(CASES):
        paths.append(folder / f"case_{k:02}.toml")
        text = changed(scene, bearing, 1.0 + 0.05 * k, False, f"case_{k}")
        paths[-1].write_text(text, encoding="utf-8")
    command = ["mpirun", "-n", "2", sys.executable, "-m", "solidwhirl", "batch"]
    return cpu_s(*command, *map(str, paths), "--out", str(folder / "batch"))


def small(stiffness: float, damping: float) -> Scene:
    """A shaft with a disk on its meridian, on two bearings."""
    from solidwhirl.build import bearing, body, cylinder, scene

    rotor = body(
        cylinder("shaft", 0.0, 0.5, 0.02),
        cylinder("disk", 0.18, 0.22, 0.12, 0.02),
        interfaces={"left": 0.0, "disk": 0.2, "right": 0.5},
    )
    return scene(
        "small",
        bodies={"rotor": rotor},
        bearings=[
            bearing("left", "rotor.left", stiffness_n_per_m=stiffness, damping_n_s_per_m=damping),
            bearing("right", "rotor.right", stiffness_n_per_m=2e7, damping_n_s_per_m=damping),
        ],
        speeds_rpm=np.linspace(0.0, 20000.0, 21),
        branches=6,
        model={"modes": SMALL_MODES, "level": "harmonic"},
    )


def _edited(scenes: list[Scene]) -> tuple[float, float]:
    """Coordinates, and the CPU of `run_scene` with a store after a change of a bearing."""
    from solidwhirl.cache.files import MemoryStore
    from solidwhirl.pipeline.run import run_scene

    store, runs = MemoryStore(), []
    for one in scenes:
        begun = time.process_time()
        results = run_scene(one, store=store)
        runs.append(time.process_time() - begun)
    return float(results.system.size), min(runs[1:])


def in_one(scene: Path, bearing: str) -> dict[str, float]:
    """`run_scene` with a store and bearings changed, and the engine of a `ReducedScene`."""
    from solidwhirl.reduced_scene import ReducedScene, reduce_scene
    from solidwhirl.scene_reading.reader import parse_scene

    scenes = [
        parse_scene(tomllib.loads(changed(scene, bearing, 1.0 + 0.1 * k, False))) for k in range(4)
    ]
    size, spent = _edited(scenes)
    out = {"coordinates": size, "run_scene_s": spent}
    for name, damping in (("small", 0.0), ("small_damped", 200.0)):
        edits = [small(1e7 * (1.0 + 0.1 * k), damping) for k in range(4)]
        out[f"{name}_coordinates"], out[f"{name}_run_scene_s"] = _edited(edits)
    reduced = reduce_scene(scenes[0])
    for name in ("critical_speeds", "campbell", "estimates"):
        spent = []
        for one in scenes:
            other: ReducedScene = reduced.in_scene(one)
            begun = time.process_time()
            getattr(other, name)()
            spent.append(time.process_time() - begun)
        out[f"{name}_s"] = min(spent)
    return out


def main() -> None:
    """Print what is measured as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", type=Path, default=ROOT / "scenes" / "ferraris.toml")
    parser.add_argument("--bearing", default="kxx")
    parser.add_argument("--analyses", action="store_true", help="with the analyses of the scene")
    given = parser.parse_args()
    found = in_processes(given.scene, given.bearing, given.analyses)
    found["edit_over_engine_alone"] = found["edit_s"] / found["engine_alone_s"]
    found["batch_over_cold_run"] = found["batch_s"] / found["cold_s"]
    print(json.dumps(found | in_one(given.scene, given.bearing), indent=1))


if __name__ == "__main__":
    main()
