"""The solid level against CalculiX on the same mesh, and against converged harmonic figures."""

from __future__ import annotations

import numpy as np
import pytest
from calculix import calculix_body, calculix_rows

from solidwhirl.meshing import MeshSize, mesh_revolved
from solidwhirl.meshing.own.whole import whole_mesh
from solidwhirl.reduction import ReductionRequest, reduce_body

pytestmark = [pytest.mark.verify, pytest.mark.solver]


def calculix_frequencies(mesh, modes, folder):
    """Free vibration of the mesh."""
    steps = ["*STEP", "*FREQUENCY", f"{modes}", "*END STEP"]
    return calculix_rows([*calculix_body(mesh), *steps], folder, columns=5)[:, 3]


def test_free_frequencies_equal_those_of_calculix(reference_rotor, tmp_path, four_points):
    """A sector, and the same all around; both integrate at four points of each element."""
    from mpi4py import MPI

    mesh = mesh_revolved(reference_rotor, MeshSize(size_m=0.1, corner_size_m=0.02, growth=1.0))
    theirs = calculix_frequencies(whole_mesh(mesh)[0], 30, tmp_path)
    request = ReductionRequest(
        level="solid", orders=(1,), components=(), degree=2, modes=3, maximum_speed_rad_s=0.0,
        gyroscopic=False, centrifugal=False,
    )  # fmt: skip
    element, _ = reduce_body(reference_rotor, mesh, MPI.COMM_SELF, request, {})
    for f in element.free_frequencies_hz[:6]:
        # CalculiX prints seven digits
        assert np.abs(theirs / f - 1.0).min() < 1e-6
