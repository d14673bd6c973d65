"""One cold run with what each of its stages took: `python bench/forecast_run.py SCENE LEDGER.json`.

SCENE is a scene file, or its content as JSON. Times are those of the clocks of the process since it
began: wall, and processor. Everything is written twice, with the page and with the pictures.
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

_BEGAN = time.perf_counter() - time.process_time()


def clocks() -> dict[str, float]:
    """Seconds since the process began."""
    return {"wall_s": time.perf_counter() - _BEGAN, "cpu_s": time.process_time()}


def read(path: str) -> Any:
    """The scene of a file."""
    from solidwhirl.scene_reading.reader import parse_scene, read_scene

    if path.endswith(".json"):
        return parse_scene(json.loads(Path(path).read_text(encoding="utf-8")))
    return read_scene(path)


def measured(path: str) -> dict[str, Any]:
    """Run a scene cold and write its folder twice: with the page alone, and with the pictures."""
    scene = read(path)
    from solidwhirl.bodies import reduction
    from solidwhirl.cache.files import StageStore
    from solidwhirl.core.stages import Stage
    from solidwhirl.output.documents import write_into
    from solidwhirl.pipeline.run import run_scene

    # the ledger is kept in wall time; others who work on the machine are not to count here
    reduction.time = SimpleNamespace(perf_counter=time.process_time)  # type: ignore[attr-defined]
    events: list[dict[str, Any]] = []

    def told(event: Stage | str) -> None:
        if isinstance(event, Stage):
            events.append({"stage": event.name.value, "body": event.body, **clocks()})

    def foreseen(plan: Any, expected: Any) -> None:
        events.append({"stage": "foreseen", "body": "", **clocks()})

    with tempfile.TemporaryDirectory() as folder:
        store = StageStore(Path(folder) / "stages")
        results = run_scene(scene, progress=told, foreseen=foreseen, store=store)
        assert results is not None
        marks = [clocks()]
        for more in ({"page": False}, {}, {"page": False, "pictures": True}):
            out = Path(folder) / f"out{len(marks)}"
            out.mkdir()
            document = write_into(results, out, **{"pictures": False, **more})  # type: ignore[arg-type]
            marks.append(clocks())
    files, page, pictures = (
        {clock: after[clock] - before[clock] for clock in before}
        for before, after in pairwise(marks)
    )
    events.append({"stage": "writing", "body": "", **marks[0]})
    events.append({"stage": "end", "body": "", **{k: marks[0][k] + page[k] for k in page}})
    return {
        "scene": path,
        "events": events,
        "files_cpu_s": files["cpu_s"],
        "page_cpu_s": page["cpu_s"] - files["cpu_s"],
        "pictures_cpu_s": pictures["cpu_s"] - files["cpu_s"],
        "peak_memory_gib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2,
        "timings_cpu_s": dict(results.timings_s),
        "coordinates": len(results.system.mass),
        "levels": {name: own.level for name, own in results.plan.bodies.items()},
        "unknowns": [r["unknowns"] for r in document["accuracy"].get("rounds", [])],
        "dense_problems": {k: dict(v) for k, v in results.dense_problems.items()},
    }


if __name__ == "__main__":
    ledger = json.dumps(measured(sys.argv[1]), indent=1)
    Path(sys.argv[2]).write_text(ledger + "\n", encoding="utf-8")
