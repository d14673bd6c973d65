"""One case of a study in a process of its own: `python -m solidwhirl.study_case CASE RESULT`.

The result is a file too. A case that can't be run leaves one with the message and ends with code 0;
any other end is a fault of the program or the machine.
"""

from __future__ import annotations

import json
import logging
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.pipeline import Results, run_scene
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.scene import Scene
from solidwhirl.scene_file import parse_scene
from solidwhirl.study_errors import (
    critical_document,
    diagram_document,
    wider_critical_speeds,
    wider_diagram,
)
from solidwhirl.study_map import run_map_row
from solidwhirl.study_measure import Progress, StageClock, cpu_seconds, peak_memory_gib


def run_case(payload: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Run what a payload says and measure this process.

    Parameters
    ----------
    payload
        Of a `solidwhirl.study_settings.StudyCase`.
    progress
        Called with one line per stage.

    Raises
    ------
    ValueError
        What the scene can't be run for, and a level that is not there.
    """
    start = time.perf_counter()
    if payload["kind"] == "map_row":
        found = run_map_row(payload, progress)
        return {**found, "cpu_s": cpu_seconds(), "wall_s": time.perf_counter() - start}
    scene = parse_scene(payload["scene"])
    if scene.model.level != "beam":
        import solidwhirl.reduction  # noqa: F401  (part of the start, not of the first body)
    begun = {"startup_cpu_s": cpu_seconds(), "startup_memory_gib": peak_memory_gib()}
    apart = payload["phases"] == "apart"
    results, used = _measured(_estimating(scene, "off") if apart else scene, progress)
    out = {**begun, **used, "wall_s": time.perf_counter() - start, **_described(results)}
    if apart:
        results, with_estimates = _measured(_estimating(scene, "on"), progress)
        # as if the estimated run had been the only one
        with_estimates["cpu_s"] += begun["startup_cpu_s"] - used["cpu_s"]
        out["with_estimates"] = with_estimates
    out["estimates"] = _estimates(results)
    if payload["margin"]:
        out["truth"] = {
            "campbell": diagram_document(wider_diagram(results)),
            "critical_speeds": critical_document(wider_critical_speeds(results)),
        }
    return out


def _estimating(scene: Scene, word: str) -> Scene:
    return scene.model_copy(update={"model": scene.model.model_copy(update={"estimates": word})})


def _measured(scene: Scene, progress: Progress) -> tuple[Results, dict[str, Any]]:
    """Run a scene; what this process has used by the end of it, and by stage within it."""
    clock = StageClock(progress)
    results = run_scene(scene, progress=clock.say)
    clock.stop()
    assert results is not None  # one process
    _refuse_other_level(scene, results)
    return results, {
        "cpu_s": cpu_seconds(),
        "peak_memory_gib": peak_memory_gib(),
        "stages_cpu_s": clock.seconds,
    }


def _refuse_other_level(scene: Scene, results: Results) -> None:
    for name in scene.bodies:
        level = results.elements[name].level
        if level != scene.model.level:
            raise ValueError(
                f"bodies.{name}: level {scene.model.level!r} was asked for and {level!r} was run"
            )


def _described(results: Results) -> dict[str, Any]:
    """Results of a run as far as a study needs them."""
    elements = [results.elements[name] for name in results.scene.bodies]
    return {
        "unknowns": sum(e.full_dofs for e in elements),
        "coordinates": sum(len(e.coordinates) for e in elements),
        "bodies": {
            name: {"element_order": r.discretisation.degree, "modes": r.discretisation.modes}
            for name, r in results.bodies.items()
        },
        "rounds": len(results.rounds),
        "campbell": diagram_document(results.campbell),
        "critical_speeds": critical_document([c.critical for c in results.critical_speeds]),
    }


def _estimates(results: Results) -> dict[str, Any] | None:
    """Error estimates of a run; null where there are none."""
    found = results.estimates
    if found is None or not found.campbell.parts:
        return None
    return {
        "campbell": _rows(found.campbell.total),
        "campbell_parts": {part: _most(v) for part, v in found.campbell.parts.items()},
        "critical_speeds": [_number(v) for v in found.critical_speeds.total],
        "bodies_without_estimate": list(found.campbell.bodies_without_estimate),
    }


def _rows(values: Any) -> list[list[float | None]]:
    return [[_number(v) for v in row] for row in values]


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _most(values: Any) -> float | None:
    known = np.asarray(values)[np.isfinite(values)]
    return float(known.max()) if known.size else None


def main(arguments: list[str]) -> None:
    """Read the case, run it, write the result."""
    logging.getLogger().setLevel(logging.WARNING)  # the form compiler talks at INFO level
    case, target = (Path(a) for a in arguments)
    payload = json.loads(case.read_text(encoding="utf-8"))
    try:
        result = {"status": "done", **run_case(payload, lambda text: None)}
    except (ValueError, ArithmeticError, MemoryError, np.linalg.LinAlgError) as error:
        result = {"status": "failed", "message": str(error) or type(error).__name__}
    with replacing(target) as temporary:
        temporary.write_text(json.dumps(result, allow_nan=False), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
