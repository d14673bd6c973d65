"""Campbell diagram of the reference rotor in ROSS: `python peers_ross.py disk|steps OUT.json`.

Runs inside the environment of ROSS, which solidwhirl is not part of. The wheel is a rigid disk on
the shaft, or steps of the shaft.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import warnings
from pathlib import Path

with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import numpy as np
    import ross
    from ross.utils import convert_6dof_to_4dof

SHAFT_M, DISK_M, WIDTH_M = 0.02, 0.15, 0.03
SPEEDS = 21
TOP_RPM = 20_000.0


def build(wheel):
    """Free rotor; ROSS asks for a bearing, which here holds with 1 N/m."""
    steel = ross.Material(name="steel", rho=7800.0, E=2e11, Poisson=0.3)
    places = np.concatenate(
        (np.linspace(0.0, 0.145, 11), [0.16], np.linspace(0.175, 0.4, 16)),
    )
    middle = 0.5 * (places[1:] + places[:-1])
    step = (wheel == "steps") & (middle > 0.145) & (middle < 0.175)
    shafts = [
        ross.ShaftElement(L=length, idl=0.0, odl=2.0 * radius, material=steel)
        for length, radius in zip(np.diff(places), np.where(step, DISK_M, SHAFT_M), strict=True)
    ]
    disks = []
    if wheel == "disk":
        disks.append(
            ross.DiskElement.from_geometry(
                n=11, material=steel, width=WIDTH_M, i_d=2 * SHAFT_M, o_d=2 * DISK_M
            )
        )
    hold = [ross.BearingElement(n=n, kxx=1.0, cxx=0.0) for n in (0, len(shafts))]
    return convert_6dof_to_4dof(ross.Rotor(shafts, disks, hold))


def main() -> None:
    """Draw the diagram and write its frequencies."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        rotor = build(sys.argv[1])
        # four of the fourteen are rigid motions
        found = rotor.run_campbell(np.linspace(0.0, TOP_RPM, SPEEDS) * np.pi / 30.0, frequencies=14)
    hz = (np.sort(np.asarray(found.wd), axis=1) / (2.0 * np.pi)).tolist()
    document = {
        "version": ross.__version__,
        "coordinates": rotor.ndof,
        "speed_rpm": np.linspace(0.0, TOP_RPM, SPEEDS).tolist(),
        "frequency_hz": hz,
    }
    Path(sys.argv[2]).write_text(json.dumps(document))


if __name__ == "__main__":
    main()
