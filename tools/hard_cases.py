"""Measure every hard case: rows to docs/hard_cases.json, the page and its picture from them.

tools/hard_cases.py          measure all, write all
tools/hard_cases.py --page   page and picture from the rows that are there
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "hard"), str(ROOT / "tests")]
from table import cases_by_module  # noqa: E402

from solidwhirl.rotordyn.core.atomic import replacing  # noqa: E402
from solidwhirl.rotordyn.plots.frame import picture  # noqa: E402

DATA, PAGE = ROOT / "docs" / "hard_cases.json", ROOT / "docs" / "hard_cases.md"
PICTURE = ROOT / "docs" / "hard_cases.png"
# Families by the module of tests/hard that holds their cases.
FAMILIES = {
    "body_details": "small details of bodies",
    "body_matter": "Poisson's ratio near 1/2, contrasts of stiffness and density",
    "body_thin": "drums, disks, needles, the axis",
    "more_meshes": "folded elements, sizes, scales",
    "more_modes": "near interfaces, modes in groups",
    "more_overspeed": "rings and disks beyond their limits",
    "system_contrast": "stiffness and mass contrasts of systems",
    "system_free": "free systems, zeros counted",
    "system_overspeed": "systems beyond their critical speeds",
    "system_repeated": "repeated frequencies",
    "system_response": "responses and run-ups beside resonances",
    "system_spools": "counter-rotating and standing spools",
    "system_stability": "damping and stability limits",
    "system_supports": "supports from 1e2 N/m to rigid",
    "system_veering": "veering and crossing branches",
    "units": "numbers in wrong units",
}
HEAD = """# Hard cases

Each case is a test (`tests/hard`) with a figure that could fail: an error relative to a closed
form, an independent computation or a conservation law, with a limit that is derived, not tuned.
`make hard` measures all of them and writes this page; the rows, with what commonly goes wrong
elsewhere and where each limit comes from, are in [hard_cases.json](hard_cases.json).

| family | cases | above the limit | worst measured / limit | which |
|---|---|---|---|---|
"""
TAIL = """
![Measured over limit of all cases](hard_cases.png)

*One point for each case; the limit is 1. What is 0 stands at the left end.*

Counts that must be exactly zero, and are, have tests but no row here.
"""
Row = dict[str, Any]


def main() -> int:
    """Write the files; the exit code is 1 if a figure is above its limit."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    rows = json.loads(DATA.read_text("utf-8")) if "--page" in sys.argv[1:] else measured()
    rows = [row for row in rows if row["measured"] or row["limit"]]  # 0 against 0 tells nothing
    names = list(dict.fromkeys(row["family"] for row in rows))
    lines = [_family(name, [r for r in rows if r["family"] == name]) for name in names]
    for path, text in (
        (DATA, json.dumps(rows, indent=1, ensure_ascii=False)),
        (PAGE, HEAD + "\n".join(lines) + "\n" + TAIL),
    ):
        with replacing(path) as temporary:
            temporary.write_text(text.rstrip() + "\n", encoding="utf-8")
    draw(rows)
    return int(any(row["measured"] > row["limit"] for row in rows))


def measured() -> list[Row]:
    """Measure all cases."""
    rows, start = [], time.perf_counter()
    for module, case in cases_by_module():
        figure = float(case.measure())
        print(f"{case.level}: {case.case}: {figure:.2g} (limit {case.limit:.2g})", flush=True)
        rows.append(
            {
                "family": FAMILIES[module],
                "level": case.level,
                "case": case.case,
                "goes_wrong_elsewhere": case.elsewhere,
                "figure": case.figure,
                "measured": figure,
                "limit": case.limit,
                "limit_from": case.reason,
            }
        )
    missed = sum(not row["measured"] <= row["limit"] for row in rows)
    print(f"{len(rows)} cases in {time.perf_counter() - start:.0f} s, {missed} above their limit")
    return rows


def ratio(row: Row) -> float:
    """Return measured over limit; infinite where the limit is exactly 0 and missed."""
    return float(row["measured"] / row["limit"]) if row["limit"] else math.inf


def _family(name: str, rows: Sequence[Row]) -> str:
    worst = max(rows, key=ratio)
    missed = sum(ratio(row) > 1.0 for row in rows)
    case = worst["case"].replace("|", "\\|")
    return f"| {name} | {len(rows)} | {missed} | {ratio(worst):.2g} | {case} |"


def draw(rows: Sequence[Row]) -> None:
    """Draw measured over limit of every case, a line for each family."""
    names = list(dict.fromkeys(row["family"] for row in rows))[::-1]
    missed = sum(ratio(row) > 1.0 for row in rows)
    worst = max(map(ratio, rows))
    title = f"{len(rows)} hard cases, {missed or 'none'} above the limit, worst {worst:.2g} of it"
    with picture(PICTURE, title, 110.0) as (_, axes):
        places = [names.index(row["family"]) for row in rows]
        axes.plot([max(ratio(r), 1e-9) for r in rows], places, linestyle="none", marker="o",
                  markersize=3.5, alpha=0.5)  # fmt: skip
        axes.axvline(1.0, color="#D55E00", linewidth=1.2)
        axes.set(xscale="log", xlabel="measured / limit [1]")
        axes.set_yticks(range(len(names)), names)


if __name__ == "__main__":
    sys.exit(main())
