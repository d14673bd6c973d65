"""Solids on several ranks, by a factorisation and without one: the same numbers."""

from __future__ import annotations

import os
import shutil
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
from dataclasses import replace

import numpy as np
from shapes import plane, section
from mpi4py import MPI

from solidwhirl.geometry import Body
from solidwhirl.meshing import MeshSize, mesh_solid
from solidwhirl.reduction import ReductionRequest, reduce_body

comm = MPI.COMM_WORLD
sections = section("shaft", 0.0, 0.1, 0.0, 0.02), section("disk", 0.02, 0.04, 0.02, 0.04)
"""
CASE = """

def reduced(name, solver):
    couplings = {"distributing": ("distributing",) * 2, "rigid": ("distributing", "rigid")}
    first, second = couplings.get(name, couplings["distributing"])
    left, right = plane("left", 0.0, first), plane("right", 0.1, second)
    faces = () if name == "free" else (left, right)
    body = Body(name="rotor", sections=sections, interfaces=faces)
    size = MeshSize(size_m=0.04, corner_size_m=0.04, growth=0.8)
    mesh = mesh_solid(body, size) if comm.rank == 0 else None
    all_motions = name == "rigid"
    request = ReductionRequest(
        level="solid",
        orders=(0, 1) if all_motions else (1,),
        components=("ux", "uy", "uz", "rx", "ry", "rz") if all_motions else ("ux", "uy"),
        degree=2,
        modes=3,
        maximum_speed_rad_s=3000.0,
        gyroscopic=True,
        centrifugal=True,
        estimates=("mode_truncation",),
        solver=solver,
    )
    return reduce_body(body, mesh, comm, request, {})


def numbers(name, solver):
    # what does not depend on the directions within pairs of equal frequency
    element, work = reduced(name, solver)
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
    out["holds"] = np.array([check.passed is not False for check in work.checks])
    return {f"{name}.{key}": value for key, value in out.items()}

for_all = {}
for name in sys.argv[3].split(","):
    for_all |= numbers(name, sys.argv[2])
if comm.rank == 0:
    np.savez(sys.argv[1], **for_all)
"""

RANKS = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
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
    # this process may have MPI running; its children must not think that they are its ranks
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "PMIX_", "ORTE_"))}
    done = subprocess.run(
        command, env={**clean, **RANKS}, capture_output=True, text=True, timeout=1800, check=False
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

    def find(case):
        if case not in known:
            known[case] = numbers(folder, 1, "direct", case)
        return known[case]

    return find


def compare(found, expected, tolerance, of_basis):
    """Numbers of two runs; the free body's frequencies depend on the basis to first order."""
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        allowed = of_basis if name.endswith(".free") else tolerance
        np.testing.assert_allclose(found[name], value, rtol=allowed, err_msg=name)
        if name.endswith(".holds"):
            assert value.all()


# Rounding: sums in another order, another order of elimination. Held modes: measured 6e-12.
@pytest.mark.parametrize(
    ("ranks", "case"),
    [
        pytest.param(2, "distributing", marks=MPIRUN),
        pytest.param(4, "distributing", marks=[*MPIRUN, LONG]),
        pytest.param(2, "rigid", marks=[*MPIRUN, LONG]),
        pytest.param(4, "rigid", marks=[*MPIRUN, LONG]),
        pytest.param(2, "free", marks=[*MPIRUN, LONG]),
    ],
)
def test_ranks_change_nothing_but_rounding(tmp_path, one_rank, ranks, case):
    compare(numbers(tmp_path, ranks, "direct", case), one_rank(case), 1e-8, 1e-8)


# Modes to 1e-10 and solutions to 1e-11 in the energy norm. An eigenvalue's error is the square of
# its mode's. But the basis takes modes at speed for what they have beyond those at rest, which may
# be as short as 3e-4: then 3e-7 of a direction. Measured about 1e-8 in the highest frequencies of
# the free body (51 kHz, where the lowest is 10 kHz).
BASIS = 3e-7


@pytest.mark.parametrize(
    ("ranks", "case"),
    [
        (1, "distributing"),
        pytest.param(1, "rigid", marks=LONG),
        pytest.param(1, "free", marks=LONG),
        pytest.param(2, "distributing", marks=[*MPIRUN, LONG]),
        pytest.param(2, "rigid", marks=[*MPIRUN, LONG]),
    ],
)
def test_the_iteration_agrees_with_the_factorisation(tmp_path, one_rank, ranks, case):
    compare(numbers(tmp_path, ranks, "iterative", case), one_rank(case), 1e-8, BASIS)


@pytest.mark.parametrize("ranks", [pytest.param(n, marks=MPIRUN) for n in (2, 3)])
def test_ranks_find_places_and_values_of_each_other(ranks):
    run(ranks, PLACES)
