"""The bladed disk of the verification page by adaptive refinement, against extrapolated values.

    python bench/bladed_disk.py                  table, rows in out/bladed_disk.json
    python bench/bladed_disk.py --accuracies 0.01 --data FILE

Every run refines the sector from its own error estimate, for the modes of the engine, and gives the
nodal diameters 0 and 1 at rest and at 6000 rpm on the last mesh. The values in the frame that turns
with the disk are extrapolated and good to 0.15 %.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.pipeline.run import run_for_page
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import read_scene

ROOT = Path(__file__).resolve().parents[1]
ACCURACIES = (0.02, 0.01, 0.005, 0.003)
#: Modes 1 and 2 [Hz] by nodal diameter: at rest, and at 6000 rpm backward and forward
EXTRAPOLATED_HZ = {
    0: ((1075.86, 1539.90), (1088.12, 1546.19), (1088.12, 1546.19)),
    1: ((1067.58, 1508.74), (1079.89, 1517.01), (1079.55, 1515.73)),
}
#: Relative error of these values
DOUBT = 1.5e-3


def scene(accuracy: float) -> Scene:
    """The scene with an accuracy, and only the nodal diameters that are known."""
    given = read_scene(ROOT / "scenes" / "bladed_disk.toml")
    asked = {"nodal_diameters": tuple(EXTRAPOLATED_HZ), "count": 2, "mistuning": None}
    analyses = tuple(a.model_copy(update=asked) for a in given.analyses)
    return given.model_copy(
        update={
            "model": given.model.model_copy(update={"accuracy": accuracy}),
            "analyses": analyses,
            "references": (),
        }
    )


def measure(accuracy: float) -> dict[str, Any]:
    """One run: rounds of refinement, and every mode beside its extrapolated value."""
    start = time.process_time()
    found = run_for_page(scene(accuracy))
    cpu_s = time.process_time() - start
    document = found.analyses["nodal_diameters"].document
    rows = []
    for k, index in enumerate(document["nodal_diameter"]):
        for state, known in zip(
            ("rest", "backward", "forward"), EXTRAPOLATED_HZ[index], strict=True
        ):
            direction = "backward" if state == "rest" else state
            at = 0 if state == "rest" else -1
            hz = np.array(document["frequency_hz"][direction])[k, at]
            estimate = np.array(document["frequency_error_estimate"][direction])[k, at]
            rows += [
                {
                    "nodal_diameter": index,
                    "state": state,
                    "mode": mode + 1,
                    "frequency_hz": float(hz[mode]),
                    "extrapolated_hz": value,
                    "difference": float(hz[mode] / value - 1.0),
                    "estimate": float(estimate[mode]),
                }
                for mode, value in enumerate(known)
            ]
    return {
        "accuracy": accuracy,
        "cpu_s": cpu_s,
        "rounds": [{"unknowns": r.unknowns["disk"], "estimate": r.estimate} for r in found.rounds],
        "modes": rows,
    }


def told(row: dict[str, Any]) -> str:
    """One run as text."""
    rounds = ", ".join(f"{r['unknowns']} ({100 * r['estimate']:.2f} %)" for r in row["rounds"])
    lines = [f"accuracy {row['accuracy']:g}, {row['cpu_s']:.0f} s; unknowns by round: {rounds}"]
    for m in row["modes"]:
        lines.append(
            f"  h = {m['nodal_diameter']} {m['state']:8} mode {m['mode']}: "
            f"{m['frequency_hz']:8.2f} Hz, {100 * m['difference']:+.3f} % off, "
            f"{100 * m['estimate']:.3f} % estimated"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--accuracies", type=float, nargs="+", default=list(ACCURACIES))
    parser.add_argument("--data", type=Path, default=ROOT / "out" / "bladed_disk.json")
    asked = parser.parse_args()
    rows = []
    for accuracy in asked.accuracies:
        rows.append(measure(accuracy))
        print(told(rows[-1]), flush=True)
        asked.data.parent.mkdir(parents=True, exist_ok=True)
        asked.data.write_text(json.dumps({"rows": rows}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
