"""Two eigen-solvers on the same held body: SLEPc's Krylov-Schur and the block Krylov space."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import body as body_of
from shapes import plane, section

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def held():
    """Operators of a tube on the meridian and the factor of its held stiffness."""
    from mpi4py import MPI

    from solidwhirl.meshing import MeshSize, mesh_meridian
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
    from solidwhirl.reduction.solvers.constrained import factorise

    ends = (plane("a", 0.0), plane("b", 0.3))
    body = body_of(section("tube", 0.0, 0.3, 0.03, 0.05), interfaces=ends)
    components = {"a": ("ux", "uy", "rx", "ry"), "b": ("ux", "uy")}
    effects = OperatorEffects(gyroscopic=False, centrifugal=False, components=components)
    mesh = mesh_meridian(body, MeshSize(size_m=0.02, corner_size_m=0.02))
    operators = build_operators(body, mesh, MPI.COMM_SELF, order=1, degree=2, effects=effects)
    return operators, factorise(operators.stiffness, operators.coupling.rows)


def test_both_solvers_find_the_same_modes(held):
    """Neither shares code with the other but the factor; 1e-10 is above both tolerances."""
    from solidwhirl.reduction.solvers.constrained import eigenpairs
    from solidwhirl.reduction.solvers.slepc_modes import slepc_pairs

    operators, factor = held
    solvers = (eigenpairs, slepc_pairs)
    pairs = [solve(factor, operators.mass, shift=0.0, count=10) for solve in solvers]
    (block, first), (single, second) = ((v[:10], x[:, :10]) for v, x in pairs)
    np.testing.assert_allclose(single, block, rtol=1e-10)
    # the modes are simple: the same directions
    from solidwhirl.reduction.solvers.vectors import apply

    mac = np.abs(np.einsum("ij,ij->j", first, apply(operators.mass, second)))
    np.testing.assert_allclose(mac, 1.0, rtol=1e-8)


def test_held_means_held_and_the_factor_goes_on_solving(held):
    """SLEPc clears the solver that it was given, not the factor."""
    from solidwhirl.reduction.solvers.slepc_modes import slepc_pairs
    from solidwhirl.reduction.solvers.vectors import apply

    operators, factor = held
    rows = operators.coupling.rows
    load = np.ones((operators.mass.getLocalSize()[0], 1))
    before = factor.solve(load, None)
    _, vectors = slepc_pairs(factor, operators.mass, shift=0.0, count=6)
    size = np.abs(rows).sum(axis=0)[:, None] * np.abs(vectors).max(axis=0)
    assert np.all(np.abs(rows.T @ vectors) < 1e-9 * size)
    after = factor.solve(load, None)
    np.testing.assert_array_equal(before, after)
    residual = apply(operators.stiffness, after[: len(load)]) - load
    left = residual - rows @ np.linalg.lstsq(rows, residual, rcond=None)[0]
    assert np.abs(left).max() < 1e-6


def thin_rod(components, modes):
    """Operators and basis of a rod of 500 diameters, far softer than its elements, held at its end.

    Returned with them: the squared frequencies that Euler and Bernoulli give for κL = 1.
    """
    from mpi4py import MPI

    from solidwhirl.geometry import MATERIALS
    from solidwhirl.meshing import MeshSize, mesh_meridian
    from solidwhirl.reduction.basis.craig_bampton import reduction_basis
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    radius = 1e-3
    body = body_of(section("rod", 0.0, 1.0, 0.0, radius), interfaces=(plane("a", 0.0),))
    effects = OperatorEffects(gyroscopic=False, centrifugal=False, components={"a": components})
    mesh = mesh_meridian(body, MeshSize(size_m=2e-3, corner_size_m=2e-3))
    operators = build_operators(body, mesh, MPI.COMM_SELF, order=1, degree=2, effects=effects)
    steel = MATERIALS["steel"]
    unit = steel.youngs_modulus_pa / steel.density_kg_per_m3 * (radius / 2.0) ** 2
    return operators, reduction_basis(operators, modes=modes, maximum_speed_rad_s=0.0), unit


def test_softest_mode_of_a_thin_rod_is_kept():
    """Against Euler and Bernoulli (1.8751²).

    The mean clamping of the end section gives by a part of a diameter in the length, 1e-3.
    """
    _, found, unit = thin_rod(("ux", "uy", "rx", "ry"), modes=3)
    expected = np.array([1.8751041, 4.6940911, 7.8547574]) ** 4 * unit
    np.testing.assert_allclose(found.fixed_eigenvalues[:3], expected, rtol=2e-3)


@pytest.mark.parametrize("components", [("ux", "uy", "rx", "ry"), ("ux", "uy")])
def test_a_thin_rod_bends_freely(components):
    """Held at one end, or on a pivot, with all vectors in the basis: free rods (4.7300²).

    Shear and rotating sections take 3e-4 of the fifth squared frequency.
    """
    from scipy.linalg import eigh

    from solidwhirl.reduction.solvers.vectors import project

    operators, basis, unit = thin_rod(components, modes=6)
    held = basis.interface_count
    assert basis.vectors.shape[1] == held + basis.free.shape[1] + held + 6
    k, m = (
        project(a, basis.vectors, operators.comm) for a in (operators.stiffness, operators.mass)
    )
    found = eigh(k, m, eigvals_only=True)[2:7]
    expected = np.array([4.730041, 7.853205, 10.995608, 14.137165, 17.278760]) ** 4 * unit
    np.testing.assert_allclose(found, expected, rtol=5e-4)
