"""Compare two folders of runs, `results.json` by `results.json`.

    .venv/bin/python tools/same_results.py REFERENCE NEW [--within 1e-12]

Every number that differs by more than the tolerance, relative to itself or to the largest number
of its list, and every key that came or went, is a line. Times, versions and places on disk are
not compared. The command ends with 1 if there is a line.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

# what differs between two runs of the same program
PASSED_OVER = {
    "cpu_s",
    "analyses_cpu_s",
    "dense_problems",
    "body_problems",
    "peak_memory_gib",
    "timings_s",
    "wall_time_per_step_s",
    "wall_time_s",
}


def main() -> int:
    """Print every difference; 1 if there is one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("reference", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--within", type=float, default=1e-12)
    asked = parser.parse_args()
    found = 0
    for path in sorted(asked.reference.glob("**/results.json")):
        name = path.relative_to(asked.reference)
        if not (asked.new / name).exists():
            print(f"{name}: not in {asked.new}")
            found += 1
            continue
        lines = list(_differences(_document(path), _document(asked.new / name), asked.within))
        print(f"{name}: {len(lines)} differences")
        for line in lines[:40]:
            print(f"  {line}")
        found += len(lines)
    return int(found > 0)


def _document(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _differences(a: Any, b: Any, within: float, at: str = "", size: float = 0.0) -> Iterator[str]:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted((a.keys() | b.keys()) - PASSED_OVER):
            if key not in a or key not in b:
                yield f"{at}.{key}: only in the {'reference' if key in a else 'new'}"
            else:
                yield from _differences(a[key], b[key], within, f"{at}.{key}")
    elif isinstance(a, list) and isinstance(b, list):
        if len(a) != len(b):
            yield f"{at}: {len(a)} and {len(b)} entries"
            return
        largest = max((abs(x) for x in a if _is_number(x)), default=0.0)
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from _differences(x, y, within, f"{at}[{i}]", largest)
    elif _is_number(a) and _is_number(b):
        if abs(a - b) > within * max(abs(a), size):
            yield f"{at}: {a!r} and {b!r}"
    elif a != b:
        yield f"{at}: {str(a)[:120]} and {str(b)[:120]}"


def _is_number(x: Any) -> bool:
    return isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x)


if __name__ == "__main__":
    raise SystemExit(main())
