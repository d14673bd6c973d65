"""Times of ROSS on its own compressor example, written as JSON: `python ross_compressor.py`.

Runs inside the environment of ROSS, which solidwhirl is not part of; `bench/engine.py` calls it.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
import warnings

with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import numpy as np
    import ross

BRANCHES = 12
UNBALANCE_NODE = 29
TOP_RAD_S = 1200.0


def seconds_per_item(run, items, repeats=3):
    """Shortest of some repeats; each run gets its own number, as ROSS keeps its results."""
    times = []
    for repeat in range(repeats):
        start = time.process_time()
        with contextlib.redirect_stdout(io.StringIO()):
            run(repeat)
        times.append((time.process_time() - start) / items)
    return min(times)


def campbell(rotor, repeat):
    """Campbell diagram over 11 speeds."""
    rotor.run_campbell(np.linspace(0.0, TOP_RAD_S, 11) + 0.1 * repeat, frequencies=BRANCHES)


def unbalance(rotor, repeat):
    """Unbalance response at 21 speeds."""
    speeds = np.linspace(10.0, TOP_RAD_S, 21) + 0.1 * repeat
    rotor.run_unbalance_response(UNBALANCE_NODE, 1e-3, 0.0, frequency=speeds)


def critical_map(rotor, repeat):
    """Undamped critical speed map at 5 stiffnesses."""
    rotor.run_ucs(stiffness_range=(6, 9 + 0.01 * repeat), num=5, synchronous=True)


def run_up(rotor, repeat):
    """Newmark steps with rising speed, force given beforehand."""
    times = np.linspace(0.0, 0.1, 201)
    speeds = 300.0 + repeat + 100.0 * times
    force = np.zeros((times.size, rotor.ndof))
    force[:, UNBALANCE_NODE * rotor.number_dof] = 1.0
    rotor.run_time_response(speeds, force, times, method="newmark")


def point(rotor, repeat):
    """One point of speed and frequency of a waterfall: the transfer matrix ROSS forms for it."""
    for k in range(10):
        rotor.transfer_matrix(speed=300.0 + k, frequency=400.0 + repeat)


def main() -> None:
    """Measure and write."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rotor = ross.compressor_example()
        # compile and warm up, at speeds that are not used again
        with contextlib.redirect_stdout(io.StringIO()):
            rotor.run_modal(77.7, num_modes=2 * (BRANCHES + 2))
            run_up(rotor, 50)
        found = {
            "version": ross.__version__,
            "coordinates": rotor.ndof,
            "campbell": seconds_per_item(lambda k: campbell(rotor, k), 11),
            "unbalance": seconds_per_item(lambda k: unbalance(rotor, k), 21),
            "map": seconds_per_item(lambda k: critical_map(rotor, k), 5),
            "run_up": seconds_per_item(lambda k: run_up(rotor, k), 200),
            "point": seconds_per_item(lambda k: point(rotor, k), 10),
        }
    sys.stdout.write(json.dumps(found) + "\n")


if __name__ == "__main__":
    main()
