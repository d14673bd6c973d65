"""What each effect costs, and what leaving it out saves, for three scenes.

    python bench/effects.py                     all cases, to docs/data/effects.json
    python bench/effects.py --case SCENE EFFECT STATE

Every effect that a scene may switch is switched against what its plan chose, one at a time, and all
of them on at once; analyses are left out. Each case is a process of its own; its time is the
processor time of the run without loading the program. An effect that no part of
the scene calls for must not change its critical speeds: the largest change of the nearest is told.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.pipeline.run import run_for_page
from solidwhirl.scene.records import EffectsSpec, Scene
from solidwhirl.scene_reading.reader import read_scene

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "docs" / "data" / "effects.json"
SCENES = ("ferraris", "compressor", "turbocharger")
#: Effects that are switched together: one of the two alone is refused.
PAIR = ("stress_stiffening", "spin_softening")
EFFECTS = (*(e for e in EffectsSpec.model_fields if e != PAIR[1]), "estimates")


def scene_of(name: str) -> Scene:
    """Scene of a name without its analyses."""
    return read_scene(ROOT / "scenes" / f"{name}.toml").model_copy(update={"analyses": ()})


def switched(scene: Scene, effect: str, state: str) -> Scene:
    """The scene with an effect ("all": all of them; "none": as it is) switched."""
    if effect == "none":
        return scene
    if effect == "estimates":
        model = scene.model.model_copy(update={"estimates": state})
        return scene.model_copy(update={"model": model})
    names = EffectsSpec.model_fields if effect == "all" else PAIR if effect in PAIR else (effect,)
    effects = scene.effects.model_dump() | dict.fromkeys(names, state)
    return scene.model_copy(update={"effects": EffectsSpec.model_validate(effects)})


def chosen(scene: Scene) -> dict[str, bool]:
    """What the plan of a scene has on, by effect."""
    found = {effect.name: effect.on for effect in make_plan(scene, build_bodies(scene)).effects}
    return {effect: found.get(effect, scene.model.estimates == "on") for effect in EFFECTS}


def case(name: str, effect: str, state: str) -> dict[str, Any]:
    """Run one case in this process."""
    scene = switched(scene_of(name), effect, state)
    start = time.process_time()
    results = run_for_page(scene)
    seconds = time.process_time() - start
    speeds = [c.critical.speed_rad_s for c in results.critical_speeds]
    return {"cpu_s": seconds, "critical_rad_s": speeds}


def measured(name: str, effect: str, state: str) -> dict[str, Any]:
    """One case in a process of its own."""
    command = [sys.executable, __file__, "--case", name, effect, state]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def change(base: list[float], other: list[float]) -> float | None:
    """Largest relative distance of critical speeds from the nearest of others."""
    if not base or not other:
        return None
    away = np.abs(np.subtract.outer(base, other)).min(axis=1)
    return float((away / np.array(base)).max())


def rows_of(name: str) -> dict[str, Any]:
    """All cases of a scene."""
    states, base = chosen(scene_of(name)), measured(name, "none", "auto")
    rows = []
    for effect, is_on in states.items():
        other = measured(name, effect, "off" if is_on else "on")
        with_it, without = (base, other) if is_on else (other, base)
        rows.append(
            {
                "effect": effect,
                "on": is_on,
                "cost_s": with_it["cpu_s"] - without["cpu_s"],
                "critical_speed_change": change(base["critical_rad_s"], other["critical_rad_s"]),
            }
        )
        print(name, rows[-1], flush=True)
    everything = measured(name, "all", "on")
    return {
        "scene": name,
        "cpu_s": base["cpu_s"],
        "all_on_cpu_s": everything["cpu_s"],
        "rows": rows,
    }


def main() -> None:
    """Measure all cases, or one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", nargs=3, metavar=("SCENE", "EFFECT", "STATE"))
    asked = parser.parse_args()
    if asked.case:
        print(json.dumps(case(*asked.case)))
        return
    found = [rows_of(name) for name in SCENES]
    TARGET.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
