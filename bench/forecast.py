"""The forecast beside what runs took: `python bench/forecast.py DIR ...`, folders of cold runs.

Reads `predicted_cost` and `timings_s` of each results.json: processor seconds of bodies and engine,
and of each analysis. A ratio is truth over forecast.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

HEAD = "| scene | forecast s | took s | ratio | analyses: forecast / took s |"


def row(folder: Path) -> tuple[str, float]:
    """One line of the table, and the ratio."""
    document = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    predicted, spent = document["predicted_cost"], document["timings_s"]
    took = sum(spent.values())
    analyses = [
        f"{name} {seconds:.2g} / {spent.get(f'analysis {name}', 0.0):.2g}"
        for name, seconds in predicted["analyses_cpu_s"].items()
    ]
    ratio = took / predicted["cpu_s"]
    text = f"| {folder.name} | {predicted['cpu_s']:.3g} | {took:.3g} | {ratio:.2f} |"
    return f"{text} {'; '.join(analyses)} |", ratio


def main() -> None:
    """Print the table and how far the worst is off."""
    found = [row(Path(name)) for name in sys.argv[1:]]
    print(HEAD)
    print("|---|---|---|---|---|")
    for text, _ in found:
        print(text)
    ratios = np.array([ratio for _, ratio in found])
    off = np.maximum(ratios, 1.0 / ratios)
    within = int(np.count_nonzero(off <= 1.5))
    print(f"\nwithin 1.5: {within} of {off.size}")
    print(f"median {np.median(off):.2f}, worst {off.max():.2f}")


if __name__ == "__main__":
    main()
