"""Compute every table and figure of Müller and Hennings; write docs/paper.md and its data.

`python tools/paper` runs the scenes that belong to the paper and writes the page with its pictures.
"""

from __future__ import annotations

import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from paper.blades import blade_sections  # noqa: E402
from paper.engine import engine_sections  # noqa: E402
from paper.rows import Row, agreement_chart, document, table  # noqa: E402
from paper.runs import PAGE, PICTURES, Run, drawn  # noqa: E402
from paper.twin_rotor import twin_sections  # noqa: E402
from paper.units import SEARCHES, unit_sections  # noqa: E402

DATA = ROOT / "docs" / "data" / "paper.json"

HEAD = """# The paper, figure by figure

T. S. Müller and H. Hennings, *Rotordynamic Validation of a Twin Rotor-bearing System Considering
Gyroscopic Forces and Bearing Dynamics with a Multibody Formulation: Application to a Geared UHBR
Gas Turbine* (German Aerospace Center). For each figure and table: what the paper did, what we did,
the picture, how well both agree, and what of ours is inferred. `make paper` computes all of it from
the scenes named below and writes this page; what the paper prints is in
[source.toml](../tools/paper/source.toml), every compared number in
[data/paper.json](data/paper.json).

The column *input* says where ours comes from: *paper*, all input is printed there; *inferred*,
positions follow from the printed results; *identified*, geometry was fitted to the printed masses
and frequencies ([identify.md](identify.md)); *assumed*, the paper does not say. *Error of ours* is
estimated by the run ([accuracy](accuracy.md)): of mesh, truncation of modes, interpolation over the
speed and solver. It says nothing of inputs. ± is the same, or the difference from a second
computation where the text says so. Numbers without ±: mass properties, one-term model and
polynomials are closed forms; ranges over many units are spreads, of which the error is told beside
them; what is read off a map or a spectrum is known to its step. No error is estimated of heights of
responses and forces, their differences, damping and times, nor of rigid blades, which have the mesh
of elastic ones.
"""


def _done(task: partial[Any]) -> None:
    start = time.perf_counter()
    task()
    print(
        f"{task.func.__name__} {task.args[:2]}: {time.perf_counter() - start:.0f} s",
        file=sys.stderr,
    )


def main() -> None:
    """Run the scenes and write the page."""
    names = ("uhbr_engine", "uhbr_lp", "uhbr_hp", "uhbr_fan", "ferraris", "ferraris_paper")
    scenes = [partial(Run, name) for name in names]
    # What they find is kept in files, where it is read below.
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(_done, (*SEARCHES, *scenes)))
    runs = {name: Run(name) for name in names}
    told: dict[str, list[Row]] = {}
    writers = (twin_sections, unit_sections, engine_sections, blade_sections)
    sections = [text for write in writers for text in write(runs, told)]
    every = [row for rows in told.values() for row in rows]
    agreement = drawn([agreement_chart(told)], "agreement.png", "Agreement", "All differences")
    said = f"{len(every)} numbers of the paper are compared."
    first = ["## Agreement", agreement, said, table(every)]
    text = "\n\n".join([HEAD.rstrip(), *first, *sections]) + "\n"
    for picture in PICTURES.iterdir():
        if f"paper/{picture.name})" not in text:
            picture.unlink()
    PAGE.write_text(text, encoding="utf-8")
    DATA.write_text(document(told), encoding="utf-8")
    print(f"written: {PAGE}", file=sys.stderr)


if __name__ == "__main__":
    main()
