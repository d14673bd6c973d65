"""Scenes of the measured machines, their readings, and runs of them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from measured.readings import READINGS

from solidwhirl.cache.files import StageStore
from solidwhirl.core.stages import silent
from solidwhirl.pipeline.run import Results, run_for_page
from solidwhirl.scene_reading.paths import place_steps, with_entries
from solidwhirl.scene_reading.reader import load_toml, parse_scene

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes" / "measured"
#: Where stages of all runs are kept
STORE = StageStore(ROOT / "out" / "measured" / "stages")
CASES: list[dict[str, Any]] = tomllib.loads(
    Path(__file__).with_name("cases.toml").read_text(encoding="utf-8")
)["cases"]


def scene_name(case: Mapping[str, Any]) -> str:
    """Return the name of the file of a case."""
    return str(case.get("scene", case["name"]))


def scene_of(case: Mapping[str, Any], *readings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data of the scene of a case in a reading, which may be made of several steps."""
    data = load_toml(SCENES / f"{scene_name(case)}.toml")
    for step in readings:
        entries = {place_steps(p): value for p, value in step.get("changes", {}).items()}
        if name := step.get("reading"):
            place, added = READINGS[name]
            steps = place_steps(place)
            own: Any = data
            for key in steps:
                own = own[key]
            entries[steps] = [*own, *added]
        data = with_entries(data, entries)
    return data


def run_of(data: Mapping[str, Any]) -> Results:
    """Run a scene."""
    return run_for_page(parse_scene(data, folder=SCENES), progress=silent, store=STORE)
