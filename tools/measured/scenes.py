"""Scenes of the measured machines, and their readings."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from measured.readings import READINGS

from solidwhirl.scene_reading.paths import place_steps, with_entries

SCENES = Path(__file__).resolve().parents[2] / "scenes" / "measured"
CASES: list[dict[str, Any]] = tomllib.loads(
    Path(__file__).with_name("cases.toml").read_text(encoding="utf-8")
)["cases"]


def scene_of(case: Mapping[str, Any], *readings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data of the scene of a case in a reading, which may be made of several steps."""
    path = SCENES / f"{case.get('scene', case['name'])}.toml"
    data = tomllib.loads(path.read_text(encoding="utf-8"))
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
