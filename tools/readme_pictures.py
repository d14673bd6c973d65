"""Draw the pictures of the README from what was measured: docs/readme_*.png.

Accuracy against time from docs/study/reference_solid.json (solidwhirl study), effects from
docs/data/effects.json (bench/effects.py). Hard cases have a tool of their own.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from solidwhirl.rotordyn.plots.frame import picture  # noqa: E402

DOCS = ROOT / "docs"
_WIDTH_MM, _HEIGHT_MM = 120.0, 84.0
# Ladder of the study, what the legend says, mark and colour.
_LEVELS = (
    ("beam", "Timoshenko beams", "s", "#999999"),
    ("harmonic, order 2, graded", "meridian", "o", "#0072B2"),
    ("solid, order 2, graded", "solid, one sector", "^", "#D55E00"),
)
_PEERS = ("P", "X", "D", "v")
_ON, _OFF = "#0072B2", "#B9D9EB"


def accuracy() -> None:
    """Error of the diagram against processor time: beams, meridians, solids, other programs."""
    study = json.loads((DOCS / "study" / "reference_solid.json").read_text(encoding="utf-8"))
    title = f"{study['scene']['title']}: error against time"
    with picture(DOCS / "readme_accuracy.png", title, _HEIGHT_MM, width_mm=_WIDTH_MM) as (_, axes):
        for series, label, mark, color in _LEVELS:
            own = [c for c in study["cases"] if c["series"] == series and c["campbell"]]
            points = sorted((_seconds(c), 100.0 * c["campbell"]["true"]) for c in own)
            x, y = np.array(points).T
            axes.plot(x, y, marker=mark, color=color, label=label, markersize=5)
        for mark, program in zip(_PEERS, _programs(study), strict=False):
            own = [p for p in study["peers"] if p["program"] == program]
            x, y = ([p["cpu_s"] for p in own], [100.0 * p["error"] for p in own])
            axes.plot(x, y, linestyle="none", marker=mark, color="#333333", label=program)
        axes.set(
            xscale="log",
            yscale="log",
            xlabel="processor time [s], start of the program included",
            ylabel="largest error of a frequency [%]",
        )
        axes.legend(loc="lower right")


def _programs(study: dict[str, Any]) -> list[str]:
    return list(dict.fromkeys(peer["program"] for peer in study["peers"]))


def _seconds(case: dict[str, Any]) -> float:
    """Time of a case without error estimates where it was run without."""
    return float((case["without_estimates"] or case["with_estimates"])["cpu_s"])


def effects() -> None:
    """Cost of effects that the scenes call for, and of those that they leave out."""
    scenes = json.loads((DOCS / "data" / "effects.json").read_text(encoding="utf-8"))
    rows = [
        (f"{scene['scene']}: {row['effect'].replace('_', ' ')}", row["on"], row["cost_s"])
        for scene in scenes
        for row in scene["rows"]
        if abs(row["cost_s"]) > 0.1 * scene["cpu_s"]
    ]
    title = "Effects: seconds of a run"
    height = 30.0 + 5.0 * len(rows)
    with picture(DOCS / "readme_effects.png", title, height, width_mm=_WIDTH_MM) as (_, axes):
        for is_on, label, color in ((True, "on", _ON), (False, "left out", _OFF)):
            own = [k for k, row in enumerate(rows) if row[1] == is_on]
            axes.barh(own, [rows[k][2] for k in own], color=color, label=label)
        axes.set_yticks(range(len(rows)), [row[0] for row in rows])
        axes.invert_yaxis()
        axes.set(xlabel="processor time [s]")
        axes.legend(loc="best")


def main() -> None:
    """Draw both."""
    accuracy()
    effects()


if __name__ == "__main__":
    main()
