"""Standard jobs that tell how fast a machine is: `python -m solidwhirl.console.standard_jobs`.

Two small scenes are run from geometry to page and pictures. What each kind of work takes, in
processor seconds of a process of its own, is printed as JSON; `solidwhirl doctor --calibrate` keeps
it for forecasts (`solidwhirl.cost.machine`).
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

from solidwhirl.core.stages import Stage, StageName

# Pads whose stiffness and damping follow the speed: the engine's problems are general ones.
_PADS = {
    "kind": "table",
    "speed_rpm": [0, 4000, 8000, 15000],
    "stiffness_n_per_m": [[9.5e7, 1.1e8], [7e7, 9e7], [5e7, 7e7], [4e7, 5.5e7]],
    "damping_n_s_per_m": [[5e4, 6e4], [4e4, 5e4], [3e4, 4e4], [2e4, 3e4]],
}
_ROTOR: dict[str, Any] = {
    "material": "steel",
    "sections": [
        {"name": "shaft", "start_m": 0.0, "end_m": 1.2, "outer_radius_m": 0.04},
        {
            "name": "wheel", "start_m": 0.5, "end_m": 0.53,
            "inner_radius_m": 0.04, "outer_radius_m": 0.2,
        },
        {
            "name": "collar", "start_m": 1.0, "end_m": 1.02,
            "inner_radius_m": 0.04, "outer_radius_m": 0.085,
        },
    ],
    "interfaces": [
        {"name": "drive", "kind": "outer", "start_m": 0.12, "end_m": 0.16},
        {"name": "middle", "kind": "section", "at_m": 0.4},
        {"name": "free", "kind": "outer", "start_m": 0.88, "end_m": 0.92},
    ],
}  # fmt: skip
_UNBALANCE = [{"at": "rotor.middle", "moment_kg_m": 1e-4}]
#: A meridian in two rounds, with the engine's problems; all pictures of its analyses.
ENGINE: dict[str, Any] = {
    "name": "standard_engine",
    "model": {"level": "harmonic", "accuracy": 2e-3},
    "speeds": {"to_rpm": 12000, "count": 25},
    "bodies": {"rotor": _ROTOR},
    "bearings": [
        {"name": "drive", "first": "rotor.drive", "speed_law": "pads"},
        {"name": "free", "first": "rotor.free", "speed_law": "pads"},
    ],
    "speed_laws": {"pads": _PADS},
    "analyses": [
        {
            "kind": "unbalance_response", "to_rpm": 12000, "count": 101,
            "unbalances": _UNBALANCE, "observe": ["rotor.middle"],
        },
        {"kind": "stability", "to_rpm": 12000, "count": 31},
        {
            "kind": "run_up", "ramp_s": 1.0, "to_rpm": 6000, "sampling_hz": 4000,
            "record_hz": 2000, "unbalances": _UNBALANCE, "observe": ["rotor.middle"],
            "mount": "drive",
        },
    ],
}  # fmt: skip
#: The rotor as a sector, in two rounds.
SOLID: dict[str, Any] = {
    "name": "standard_solid",
    "model": {"level": "solid", "accuracy": 5e-3},
    "speeds": {"to_rpm": 10000, "count": 3},
    "bodies": {"rotor": _ROTOR},
    "bearings": [
        {"name": "drive", "first": "rotor.drive", "stiffness_n_per_m": 1e8},
        {"name": "free", "first": "rotor.free", "stiffness_n_per_m": 1e8},
    ],
}

_BODIES = (StageName.MESHING, StageName.REDUCTION)


class _Stages:
    """Processor time of the process at the beginning of each stage of a run."""

    def __init__(self) -> None:
        self.start_s = 0.0
        self._began: list[tuple[StageName | None, float]] = []

    def __call__(self, event: Stage | str) -> None:
        if isinstance(event, Stage):
            self._began.append((event.name, time.process_time()))

    def foreseen(self, *_: object) -> None:
        """Take down when the level of the bodies is known."""
        self.start_s = time.process_time()

    def end(self) -> None:
        """End the last stage."""
        self._began.append((None, time.process_time()))

    def spent(self, bodies: bool) -> float:
        """Seconds of the stages of bodies, or of all others."""
        pairs = pairwise(self._began)
        return sum(after - at for (name, at), (_, after) in pairs if (name in _BODIES) is bodies)


def measured() -> dict[str, float]:
    """Processor seconds of each kind of work, see `solidwhirl.cost.machine.GROUPS`."""
    from solidwhirl.output.documents import write_into
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.scene_reading.reader import parse_scene

    engine, solid = _Stages(), _Stages()
    results = run_scene(parse_scene(ENGINE), progress=engine, foreseen=engine.foreseen)
    assert results is not None  # one process
    engine.end()
    with tempfile.TemporaryDirectory() as folder:
        marks = [time.process_time()]
        for page in (True, False):
            out = Path(folder) / f"page_{page}"
            out.mkdir()
            write_into(results, out, pictures=not page, page=page)
            marks.append(time.process_time())
    run_scene(parse_scene(SOLID), progress=solid, foreseen=solid.foreseen)
    solid.end()
    return {
        "start": engine.start_s,
        "meridian": engine.spent(bodies=True),
        "solid": solid.spent(bodies=True),
        "dense": engine.spent(bodies=False),
        "page": marks[1] - marks[0],
        "pictures": marks[2] - marks[1],
    }


if __name__ == "__main__":
    json.dump(measured(), sys.stdout)
