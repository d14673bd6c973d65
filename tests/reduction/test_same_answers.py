"""The same question gets the same answer: run after run, on more threads, a thousand times."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.solver

TESTS = Path(__file__).resolve().parents[1]
PROGRAM = f"""
import sys

sys.path.insert(0, {str(TESTS)!r})
import numpy as np
from reduced import reduced_to
from shapes import body, plane, section

from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved


def case(level, coupling):
    # function that reduces a body, and its mesh
    shaft, disk = section("shaft", 0.0, 0.1, 0.0, 0.02), section("disk", 0.02, 0.04, 0.02, 0.04)
    shape = body(
        shaft, disk, interfaces=(plane("left", 0.0, coupling), plane("right", 0.1, coupling))
    )
    size = MeshSize(size_m=0.08, corner_size_m=0.04, growth=0.8, around=8)
    mesh = (mesh_meridian if level == "harmonic" else mesh_revolved)(shape, size)
    estimates = ("mode_truncation", "mesh") if level == "harmonic" else ("mode_truncation",)
    spin = dict(maximum_speed_rad_s=1000.0, gyroscopic=True, centrifugal=True)
    request = dict(mesh=mesh, modes=2, estimates=estimates, **spin)
    return lambda: reduced_to(shape, level, **request)[0], mesh
"""
ARRAYS = """
def arrays(element, mesh):
    names = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
    found = {name: getattr(element, name) for name in (*names, "recovery_modes")}
    found |= {form.part: form.gram for form in element.error_forms}
    return found | {"free": element.free_frequencies_hz, "points": mesh.points}

out = {}
for level in ("harmonic", "solid"):
    reduced, mesh = case(level, "distributing")
    for again in range(int(sys.argv[2])):
        out |= {f"{level} {again} {k}": v for k, v in arrays(reduced(), mesh).items()}
np.savez(sys.argv[1], **out)
"""
GROWTH = """
import ctypes
import gc

def resident():
    # what waits for the collector or is kept for reuse is not lost
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    lines = open("/proc/self/status").read().splitlines()
    return int(next(l for l in lines if l.startswith("VmRSS")).split()[1]) / 1024.0

first, last = int(sys.argv[3]), int(sys.argv[4])
reduced, _ = case(*sys.argv[1:3])
for k in range(last):
    reduced()
    if k == first:
        begin = resident()
print(resident() - begin)
"""


def run(program, *arguments, **variables):
    """Output of a program in a process of its own."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **variables}
    command = [sys.executable, "-c", PROGRAM + program, *map(str, arguments)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True)


@pytest.fixture(scope="module")
def arrays(tmp_path_factory):
    """Function: arrays of both levels, each so many times, from a process of its own."""
    folder, known = tmp_path_factory.mktemp("arrays"), {}

    def find(seed, threads, times=1):
        if (seed, threads) not in known:
            path = folder / f"{seed}-{threads}.npz"
            run(ARRAYS, path, times, PYTHONHASHSEED=seed, OPENBLAS_NUM_THREADS=threads)
            known[seed, threads] = dict(np.load(path))
        return known[seed, threads]

    return find


def test_runs_agree_bit_for_bit(arrays):
    """Twice in one process, and in another one with another order of hashes."""
    first = arrays("1", "1", 2)
    for found in (first, arrays("2", "1")):
        for name, values in found.items():
            known = first[name.replace(" 1 ", " 0 ")]
            assert values.tobytes() == known.tobytes(), name


def test_threads_of_the_linear_algebra_change_nothing_but_rounding(arrays):
    """Sums in another order; what doesn't depend on the directions within pairs agrees to 1e-10."""
    one, two = arrays("1", "1", 2), arrays("1", "2")
    for level in ("harmonic", "solid"):
        assert np.array_equal(one[f"{level} 0 points"], two[f"{level} 0 points"])
        np.testing.assert_allclose(one[f"{level} 0 free"], two[f"{level} 0 free"], rtol=1e-10)


# Measured: 0.1 MiB from the 5th to the 1000th reduction on the meridian, where losing one vector
# of an interface would be 5 MiB (1 in 200), and one matrix 500; 0.1 MiB from the 2nd to the 12th
# of solids. On Debian 13 the memory stays after 40 reductions: 0.9 MiB from the 5th, 0.1 then.
@pytest.mark.parametrize(
    ("level", "coupling", "first", "last", "most_mib"),
    [
        pytest.param("harmonic", "rigid", 5, 40, 1.5, marks=pytest.mark.verify),
        ("solid", "rigid", 2, 5, 0.5),
        pytest.param("harmonic", "distributing", 40, 240, 0.5, marks=pytest.mark.verify),
        pytest.param("solid", "distributing", 2, 22, 0.5, marks=pytest.mark.verify),
    ],
)
def test_memory_does_not_grow(level, coupling, first, last, most_mib):
    assert float(run(GROWTH, level, coupling, first, last).stdout) < most_mib
