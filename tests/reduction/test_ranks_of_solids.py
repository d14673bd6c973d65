"""Bodies on several ranks, by a factorisation and without one: the same numbers."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from ranks import CLEAN

pytestmark = pytest.mark.solver
TESTS = Path(__file__).resolve().parents[1]
PROGRAM = f"""
import sys

sys.path.insert(0, {str(TESTS)!r})
import numpy as np
from reduced import reduced_to, whole_of
from shapes import bladed_disk, body, plane, section
from mpi4py import MPI

from solidwhirl.meshing import MeshSize
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.meshing.own.joined import mesh_joined

comm = MPI.COMM_WORLD
sections = section("shaft", 0.0, 0.1, 0.0, 0.02), section("disk", 0.02, 0.04, 0.02, 0.04)
"""
CASE = """

def reduced(name, solver):
    whole, kind = name.startswith("whole "), name.removeprefix("whole ")
    couplings = {"distributing": ("distributing",) * 2, "rigid": ("distributing", "rigid")}
    first, second = couplings.get(kind, couplings["distributing"])
    left, right = plane("left", 0.0, first), plane("right", 0.1, second)
    faces = () if kind == "free" else (left, right)
    all_motions = kind in ("rigid", "harmonic", "staggered", "joined")
    shape, mesh = body(*sections, interfaces=faces), None
    size = MeshSize(size_m=0.04, corner_size_m=0.04, growth=0.8, around=8)
    if whole:
        shape, mesh = whole_of(shape, size)
    elif kind in ("staggered", "joined"):
        shape = bladed_disk(5, joint=0.08 if kind == "joined" else None)
        make = mesh_joined if kind == "joined" else mesh_sector
        if comm.rank == 0:
            mesh = make(shape, MeshSize(size_m=0.02, corner_size_m=0.01, growth=1.0))
    return reduced_to(
        shape,
        "harmonic" if kind == "harmonic" else "solid",
        size,
        mesh=mesh if comm.rank == 0 else None,
        comm=comm,
        orders=(0, 1) if all_motions else (1,),
        components=("ux", "uy", "uz", "rx", "ry", "rz") if all_motions else ("ux", "uy"),
        modes=3,
        maximum_speed_rad_s=3000.0,
        gyroscopic=True,
        centrifugal=True,
        estimates=("mode_truncation",),
        solver=solver,
    )


def numbers(name, solver):
    # what does not depend on the directions within pairs of equal frequency
    element, work = reduced(name, solver)
    assert work.solver == solver
    out = {"free": element.free_frequencies_hz, "held": element.fixed_interface_frequencies_hz}
    m, k = element.mass, element.stiffness
    fast = k + 3000.0**2 * (element.stress_stiffening - element.spin_softening)
    below = -np.linalg.solve(m, np.hstack([fast, 3000.0 * element.gyroscopic]))
    state = np.vstack([np.eye(len(m), 2 * len(m), len(m)), below])
    whirl = np.linalg.eigvals(state).imag
    out["whirl"] = np.sort(whirl[whirl > 100.0])[:6]
    moved = element.surface.amplitudes
    out["surface"] = np.linalg.norm(moved, axis=(0, 1))[: 2 * (name != "free")]
    out["mass"] = np.append(element.mass_kg, np.diag(element.inertia_kg_m2))
    out["hoop"] = np.array([work.hoop_strain])
    # of interface motions, which are the same static fields whatever the distribution
    fixed = sum(c.kind == "interface" for c in element.coordinates)
    out["moments"] = element.moments.second_kg[:, :, :fixed, :fixed]
    out["first moments"] = element.moments.first_kg_m[..., :fixed]
    out["holds"] = np.array([check.passed is not False for check in work.checks])
    return {f"{name}.{key}": value for key, value in out.items()}

for_all = {}
for name in sys.argv[3].split(","):
    for_all |= numbers(name, sys.argv[2])
if comm.rank == 0:
    np.savez(sys.argv[1], **for_all)
"""

MPIRUN = [pytest.mark.mpi, pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun")]
LONG = pytest.mark.verify
PLACES = """
import numpy as np
from mpi4py import MPI

from solidwhirl.reduction.solvers.halo_exchange import numbers_at_places, values_of_owners

comm = MPI.COMM_WORLD
rng = np.random.default_rng(1)
places = rng.random((400, 3)).round(1)  # many at one height
places = np.unique(places, axis=0)
numbers = rng.permutation(len(places))
share = np.array_split(np.arange(len(places)), comm.size)[comm.rank]
wanted = rng.integers(0, len(places), (comm.size, 100))[comm.rank]
noise = 1e-12 * rng.standard_normal((comm.size, 100, 3))[comm.rank]
found, gap = numbers_at_places(
    places[share], numbers[share], places[wanted] + noise, 1e-9, comm
)
assert np.array_equal(found, numbers[wanted])
assert gap.max() < 1e-11
missing, gap = numbers_at_places(places[share], numbers[share], np.full((1, 3), 7.0), 1e-9, comm)
assert missing[0] == -1 and np.isinf(gap[0])
assert np.array_equal(values_of_owners(numbers[share], wanted, comm), numbers[wanted])
"""


def run(ranks, code, *arguments):
    """A program on some ranks; an error on one of them ends all."""
    command = [sys.executable, "-m", "mpi4py", "-c", code, *map(str, arguments)]
    if ranks > 1:
        command = ["mpirun", "--oversubscribe", "-n", str(ranks), *command]
    done = subprocess.run(
        command, env=CLEAN, capture_output=True, text=True, timeout=1800, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def numbers(folder, ranks, solver, cases):
    path = folder / f"{ranks}-{solver}.npz"
    run(ranks, PROGRAM + CASE, path, solver, cases)
    return dict(np.load(path))


@pytest.fixture(scope="module")
def one_rank(tmp_path_factory):
    """Numbers of one process with a factorisation, by case."""
    folder, known = tmp_path_factory.mktemp("one"), {}

    def find(cases):
        for case in cases.split(","):
            if case not in known:
                known[case] = numbers(folder, 1, "direct", case)
        return {key: value for case in cases.split(",") for key, value in known[case].items()}

    return find


def compare(found, expected, tolerance, of_basis):
    """Numbers of two runs; the free body's frequencies depend on the basis to first order."""
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        allowed = of_basis if name.endswith(".free") else tolerance
        least = allowed * np.abs(value).max() if name.endswith("moments") and value.size else 0.0
        np.testing.assert_allclose(found[name], value, rtol=allowed, atol=least, err_msg=name)
        if name.endswith(".holds"):
            assert value.all()


# Rounding: other orders of sums and of elimination. Fixed-interface modes: measured 6e-12.
@pytest.mark.verify
@pytest.mark.parametrize(
    ("ranks", "case"),
    [
        pytest.param(2, "distributing,harmonic", marks=MPIRUN),
        pytest.param(4, "distributing", marks=[*MPIRUN, LONG]),
        pytest.param(2, "rigid", marks=[*MPIRUN, LONG]),
        pytest.param(4, "rigid", marks=[*MPIRUN, LONG]),
        pytest.param(2, "free", marks=[*MPIRUN, LONG]),
        pytest.param(2, "staggered", marks=[*MPIRUN, LONG]),
        pytest.param(3, "joined", marks=[*MPIRUN, LONG]),
    ],
)
def test_ranks_change_nothing_but_rounding(tmp_path, one_rank, ranks, case):
    # of blades two modes at speed are nearly in the span of those at rest; see BASIS
    of_basis = BASIS if case == "staggered" else 1e-8
    compare(numbers(tmp_path, ranks, "direct", case), one_rank(case), 1e-8, of_basis)


# Modes to 1e-10 and solutions to 1e-11 in the energy norm. An eigenvalue's error is the square of
# its mode's. But the basis takes modes at speed for what they have beyond those at rest, which may
# be as short as 3e-4: then 3e-7 of a direction. Measured about 1e-8 in the highest frequencies of
# the free body (51 kHz, where the lowest is 10 kHz).
BASIS = 3e-7


@pytest.mark.parametrize(
    ("ranks", "case"),
    [
        pytest.param(1, "whole distributing", marks=LONG),
        pytest.param(1, "whole rigid", marks=LONG),
        pytest.param(1, "whole free", marks=LONG),
        pytest.param(2, "whole distributing", marks=[*MPIRUN, LONG]),
        pytest.param(2, "whole rigid", marks=[*MPIRUN, LONG]),
    ],
)
def test_the_iteration_agrees_with_the_factorisation(tmp_path, one_rank, ranks, case):
    compare(numbers(tmp_path, ranks, "iterative", case), one_rank(case), 1e-8, BASIS)


@pytest.mark.mpi
@MPIRUN[1]
def test_ranks_find_places_and_values_of_each_other():
    run(3, PLACES)
