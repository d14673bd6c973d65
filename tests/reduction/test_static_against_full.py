"""Sag and bearing loads of reduced bodies against the model that they were reduced from."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from reduced import reduced_to, sparse
from scipy.sparse.linalg import spsolve

from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.rotordyn import Bearing, End, Rotor, assemble
from solidwhirl.rotordyn.response.static import STANDARD_GRAVITY, static_response

pytestmark = pytest.mark.solver
STIFFNESS = {"A": 3e7, "B": 5e7, "C": 1e7}


def full_static(body, mesh):
    """Work of the weight along x [J], and motions of the interfaces, of the unreduced model."""
    from mpi4py import MPI

    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=False,
        components={i.name: ("ux", "uy") for i in body.interfaces},
    )
    operators = build_operators(body, mesh, MPI.COMM_SELF, order=1, degree=2, effects=effects)
    rows, coordinates = sp.csr_matrix(operators.coupling.rows), operators.coupling.coordinates
    springs = sp.diags([STIFFNESS[name] for name, _ in coordinates])
    k = sparse(operators.stiffness) + rows @ springs @ rows.T
    load = STANDARD_GRAVITY * sparse(operators.mass) @ operators.rigid_motions["ux"].ravel()
    moved = spsolve(sp.csc_matrix(k), load)
    places = dict(zip((name for name, _ in coordinates), rows.T @ moved, strict=True))
    return float(load @ moved), places


@pytest.mark.parametrize(("level", "corner"), [("harmonic", 2e-3), ("solid", 2e-2)])
@pytest.mark.parametrize("modes", [2, 8])
def test_work_of_the_weight_and_loads_of_three_bearings(twin_inner, level, corner, modes):
    """Redundant supports on a shaft with a wheel, whose sag between them has local bending."""
    size = MeshSize(size_m=0.05, corner_size_m=corner, growth=1.0, around=8)
    element, _ = reduced_to(twin_inner, level=level, size=size, modes=modes)
    held = tuple(
        Bearing(name=i, first=End(body="r", interface=i), stiffness_n_per_m=k * np.eye(2))
        for i, k in STIFFNESS.items()
    )
    system = assemble({"r": Rotor(element=element, speed_ratio=1.0)}, held)
    mesh = (mesh_meridian if level == "harmonic" else mesh_revolved)(twin_inner, size)
    work, places = full_static(twin_inner, mesh)
    found = static_response(system, (STANDARD_GRAVITY, 0.0, 0.0))
    own = float(found.load @ (system.transformation @ found.displacement))
    assert own == pytest.approx(work, rel=1e-9)
    for name, place in places.items():
        assert found.bearing_loads[name][0] == pytest.approx(STIFFNESS[name] * place, rel=1e-9)
    assert found.relative_residual < 1e-9
