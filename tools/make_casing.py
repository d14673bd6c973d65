"""Make scenes/casing/casing.npz: the body of tools/casing.toml, reduced and exported."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solidwhirl.rotordyn import Superelement

ROOT = Path(__file__).resolve().parents[1]
SCENE = ROOT / "tools" / "casing.toml"
OUT = ROOT / "scenes" / "casing" / "casing.npz"


def thinned(element: Superelement) -> Superelement:
    """Return the body with a sixth of its points for pictures, for a small file.

    Parameters
    ----------
    element
        The body.
    """
    return dataclasses.replace(
        element,
        recovery_points_m=element.recovery_points_m[::6],
        recovery_modes=element.recovery_modes[::6],
    )


def main(out: Path = OUT) -> None:
    """Reduce the casing and write its matrices.

    Parameters
    ----------
    out
        The file.
    """
    from solidwhirl.pipeline.run import run_for_page
    from solidwhirl.rotordyn.exchange.matrices.arrays_npz import write_npz
    from solidwhirl.scene_reading.reader import read_scene

    results = run_for_page(read_scene(SCENE), progress=lambda stage: print(stage, file=sys.stderr))
    out.parent.mkdir(exist_ok=True)
    element = thinned(results.elements["casing"])
    exported = write_npz(element, out)
    hertz = ", ".join(f"{f:.2f}" for f in element.free_frequencies_hz[:6:2])
    sys.stdout.write(f"{exported.files[0]}: {element.size} coordinates, free at {hertz} Hz\n")


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
