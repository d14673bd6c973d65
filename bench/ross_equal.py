"""Damped Campbell diagram and critical speed map of one shaft in ROSS and here: equal models.

`python bench/ross_equal.py`: 26 Timoshenko elements, three disks, three uneven bearings with
damping, 108 coordinates in both. Processor time per speed and per stiffness, and how far the
frequencies differ. In the map two bearings are varied; here the third has a speed law, which the
map of ROSS does not know: there all three are varied.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
import time
import warnings
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402

ROOT = Path(__file__).parents[1]
STATIONS = np.linspace(0.0, 2.0, 27)
RADIUS_M, E_PA, G_PA, DENSITY = 0.045, 211e9, 81.2e9, 7810.0
# station, mass, polar and diametral inertia
DISKS = ((4, 40.0, 1.2, 0.62), (13, 45.0, 1.5, 0.78), (22, 38.0, 1.9, 0.99))
# station, kx, ky, cx, cy
BEARINGS = ((2, 3e7, 2.1e7, 600.0, 420.0), (17, 5e7, 3.5e7, 1e3, 700.0), (25, 3e7, 2e7, 600.0, 4e2))
TOP_RAD_S, SPEEDS, BRANCHES, POINTS = 1000.0, 51, 12, 11


def shortest(run, items: int, repeats: int = 3) -> float:
    """Shortest processor time of some repeats per item, s; each run gets its own number."""
    times = []
    for repeat in range(repeats):
        start = time.process_time()
        run(repeat)
        times.append((time.process_time() - start) / items)
    return min(times)


def in_ross() -> None:
    """Write the times and frequencies of ROSS; runs in its own environment."""
    import ross
    from ross.utils import convert_6dof_to_4dof

    steel = ross.Material(name="steel", rho=DENSITY, E=E_PA, G_s=G_PA)
    shafts = [
        ross.ShaftElement(L=length, idl=0.0, odl=2 * RADIUS_M, material=steel)
        for length in np.diff(STATIONS)
    ]
    disks = [ross.DiskElement(n=n, m=m, Ip=polar, Id=across) for n, m, polar, across in DISKS]
    held = [
        ross.BearingElement(n=n, kxx=kx, kyy=ky, cxx=cx, cyy=cy) for n, kx, ky, cx, cy in BEARINGS
    ]
    rotor = convert_6dof_to_4dof(ross.Rotor(shafts, disks, held))
    speeds = np.linspace(0.0, TOP_RAD_S, SPEEDS)
    rotor.run_modal(77.7, num_modes=2 * BRANCHES)
    found = rotor.run_campbell(speeds, frequencies=BRANCHES)
    campbell = shortest(
        lambda k: rotor.run_campbell(speeds + 0.1 * (k + 1), frequencies=BRANCHES), SPEEDS
    )
    critical = shortest(
        lambda k: rotor.run_ucs(stiffness_range=(6, 9 + 0.01 * k), num=POINTS, synchronous=True),
        POINTS,
    )
    document = {
        "coordinates": rotor.ndof,
        "campbell_s": campbell,
        "map_s": critical,
        "rad_s": np.sort(np.asarray(found.wd), axis=1).tolist(),
    }
    Path(sys.argv[2]).write_text(json.dumps(document))


def here() -> dict[str, object]:
    """Times and frequencies of this program."""
    from solidwhirl import rotordyn as rd
    from solidwhirl.rotordyn.assembly.bearing_laws import PolynomialLaw
    from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map

    disks = [
        rd.Disk(
            name=f"disk {n}", position_m=float(STATIONS[n]), mass_kg=m, polar_kg_m2=polar,
            diametral_kg_m2=across,
        )
        for n, m, polar, across in DISKS
    ]  # fmt: skip
    seats = {f"seat {n}": float(STATIONS[n]) for n, *_ in BEARINGS}
    material = (E_PA, E_PA / (2 * G_PA) - 1, DENSITY)
    shaft = rd.beam_superelement("rotor", STATIONS, RADIUS_M, 0.0, material, seats, disks)
    law = PolynomialLaw(
        name="film", argument_unit="rad/s", argument_range=(0.0, 2 * TOP_RAD_S),
        stiffness_x=(1.0, 2e-4), stiffness_y=(1.0, 3e-4), damping_x=(1.0,), damping_y=(1.0,),
    )  # fmt: skip

    def system(at_second):
        held = [
            rd.Bearing(
                name=f"bearing {n}",
                first=rd.End(body="rotor", interface=f"seat {n}"),
                stiffness_n_per_m=np.diag([kx, ky]),
                damping_n_s_per_m=np.diag([cx, cy]),
                speed_law=at_second if place == 1 else None,
            )
            for place, (n, kx, ky, cx, cy) in enumerate(BEARINGS)
        ]
        return rd.assemble(
            {"rotor": rd.Rotor(element=shaft, speed_ratio=1.0)}, tuple(held), "rotor"
        )

    constant, filmed = system(None), system(law)
    speeds = np.linspace(0.0, TOP_RAD_S, SPEEDS)
    stiffness, named = np.logspace(6, 9, POINTS), [f"bearing {n}" for n in (2, 25)]
    lowest = [rd.modes_at_speed(constant, v, BRANCHES).eigenvalues.imag for v in speeds]
    return {
        "coordinates": constant.size,
        "campbell_s": shortest(
            lambda k: rd.campbell(constant, speeds + 0.1 * (k + 1), branch_count=12), SPEEDS
        ),
        "map_s": shortest(
            lambda _: critical_speed_map(
                filmed, named, stiffness, branch_count=4, speed_max_rad_s=2 * TOP_RAD_S
            ),
            POINTS,
        ),
        "rad_s": [one[:BRANCHES].tolist() for one in lowest],
    }


def main() -> None:
    """Measure both and print ratios."""
    python, out = ROOT / ".venv-ross" / "bin" / "python", ROOT / "out" / "ross_equal.json"
    out.parent.mkdir(exist_ok=True)
    subprocess.run([python, __file__, "ross", out], check=True)
    theirs, ours = json.loads(out.read_text()), here()
    first, second = (np.array(d["rad_s"])[:, :BRANCHES] for d in (theirs, ours))
    print(f"coordinates {theirs['coordinates']}, {ours['coordinates']}")
    print(f"largest relative difference of {BRANCHES} modes {np.abs(second / first - 1).max():.1e}")
    for name in ("campbell_s", "map_s"):
        a, b = theirs[name], ours[name]
        print(f"{name}: ROSS {1e3 * a:.1f} ms, here {1e3 * b:.1f} ms, ratio {a / b:.1f}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            in_ross()
    else:
        main()
