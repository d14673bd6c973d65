"""Measure every hard case and write docs/hard_cases.md."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "hard"))
from table import HardCase, all_cases  # noqa: E402

from solidwhirl.rotordyn.atomic import replacing  # noqa: E402

LEVELS = {
    "harmonic": "Bodies on the harmonic level",
    "solid": "Bodies on the solid level",
    "assembled": "Assembled systems",
    "reduced file": "Superelements through a file",
    "scene": "Scenes",
}
HEAD = """# Hard cases

Each row is a test (`tests/hard`) with a figure that could fail. `make hard` measures all of them
and writes this page. A figure is an error or a count of misses: smaller is better.

"""


def _row(case: HardCase, figure: float) -> str:
    cells = (
        case.case,
        case.elsewhere,
        f"{figure:.2g}",
        f"{case.limit:.2g}",
        f"{case.figure}; limit: {case.reason}",
    )
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def main() -> int:
    """Write the page; the exit code is 1 if a figure is above its limit."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    parts, missed, start = [HEAD], 0, time.perf_counter()
    cases = all_cases()
    unknown = {case.level for case in cases} - set(LEVELS)
    if unknown:
        raise SystemExit(
            f"hard cases of unknown levels {sorted(unknown)}; known are {list(LEVELS)}"
        )
    for level, title in LEVELS.items():
        chosen = [case for case in cases if case.level == level]
        if not chosen:
            continue
        parts.append(f"## {title}\n")
        parts.append("| case | what goes wrong elsewhere | ours | limit | what is measured |")
        parts.append("|---|---|---|---|---|")
        for case in chosen:
            figure = float(case.measure())
            missed += not figure <= case.limit
            parts.append(_row(case, figure))
            print(f"{level}: {case.case}: {figure:.2g} (limit {case.limit:.2g})", flush=True)
        parts.append("")
    parts.append(f"{len(cases)} cases, {missed} above their limit.")
    with replacing(ROOT / "docs" / "hard_cases.md") as path:
        path.write_text("\n".join(parts) + "\n", encoding="utf-8")
    print(f"{len(cases)} cases in {time.perf_counter() - start:.0f} s, {missed} above their limit")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
