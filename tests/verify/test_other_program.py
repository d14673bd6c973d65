"""The solid level against CalculiX on the same mesh, and against converged harmonic figures."""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np
import pytest

from solidwhirl.meshing import MeshSize, mesh_revolved
from solidwhirl.meshing.own.whole import whole_mesh
from solidwhirl.reduction import ReductionRequest, reduce_body

pytestmark = [pytest.mark.verify, pytest.mark.solver]


def calculix_deck(mesh, modes):
    """Free vibration of the mesh with ten-node tetrahedra."""
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{k + 1},{x:.11e},{y:.11e},{z:.11e}" for k, (x, y, z) in enumerate(mesh.points)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=BODY")
    for k, cell in enumerate(mesh.cells[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]] + 1):
        lines.append(",".join(str(v) for v in (k + 1, *cell)))
    (material,) = mesh.materials
    lines += ["*MATERIAL, NAME=M", "*ELASTIC"]
    lines.append(f"{material.youngs_modulus_pa:.11e},{material.poissons_ratio:.11e}")
    lines += ["*DENSITY", f"{material.density_kg_per_m3:.11e}"]
    lines += ["*SOLID SECTION, ELSET=BODY, MATERIAL=M", "*STEP", "*FREQUENCY", f"{modes}"]
    return "\n".join([*lines, "*END STEP"]) + "\n"


def calculix_frequencies(mesh, modes, folder):
    program = shutil.which("ccx")
    assert program, "CalculiX is missing; `make verify` installs Debian's calculix-ccx"
    (folder / "free.inp").write_text(calculix_deck(mesh, modes))
    subprocess.run([program, "free"], cwd=folder, check=True, capture_output=True, timeout=900)
    table = (folder / "free.dat").read_text().split("E I G E N V A L U E   O U T P U T")[1]
    rows = re.findall(r"^\s*\d+\s+(\S+)\s+(\S+)\s+(\S+)\s+(\S+)\s*$", table, re.MULTILINE)
    return np.array([float(r[2]) for r in rows])


def test_free_frequencies_equal_those_of_calculix(reference_rotor, tmp_path):
    """A sector against the whole circle of it: same shape functions, same integration."""
    from mpi4py import MPI

    mesh = mesh_revolved(reference_rotor, MeshSize(size_m=0.1, corner_size_m=0.01, growth=1.0))
    theirs = calculix_frequencies(whole_mesh(mesh)[0], 30, tmp_path)
    request = ReductionRequest(
        level="solid", orders=(1,), components=(), degree=2, modes=3, maximum_speed_rad_s=0.0,
        gyroscopic=False, centrifugal=False,
    )  # fmt: skip
    element, _ = reduce_body(reference_rotor, mesh, MPI.COMM_SELF, request, {})
    for f in element.free_frequencies_hz[:6]:
        # CalculiX prints seven digits; its four-point rule integrates curved elements as ours
        assert np.abs(theirs / f - 1.0).min() < 2e-5
