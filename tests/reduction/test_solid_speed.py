"""What makes the solid level cheap gives the numbers of the plain way."""

from __future__ import annotations

import dataclasses
import resource
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from shapes import body as body_of
from shapes import plane, section

from solidwhirl.meshing import MeshSize, mesh_revolved
from solidwhirl.meshing.own.whole import whole_mesh
from solidwhirl.reduction import ReductionError

pytestmark = pytest.mark.solver

SIZE = MeshSize(size_m=0.1, corner_size_m=0.1, growth=1.5, around=4)
TOP = 5000.0


@pytest.fixture
def operators():
    """Function: operators of a coarse rod, of an index of its sector, or None: of the whole."""
    from mpi4py import MPI

    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    ends = (plane("a", 0.0), plane("b", 0.2))
    body = body_of(section("rod", 0.0, 0.2, 0.0, 0.08), interfaces=ends)
    mesh = mesh_revolved(body, SIZE)
    carried = {i.name: ("ux", "uy") for i in body.interfaces}

    def build(order):
        whole = order is None
        effects = OperatorEffects(
            gyroscopic=True,
            centrifugal=True,
            components=carried,
            shape="round" if whole else "cyclic",
        )
        own = whole_mesh(mesh)[0] if whole else mesh
        return build_operators(body, own, MPI.COMM_SELF, order=order, degree=2, effects=effects)

    return build


def test_component_matrices_are_those_of_vectors(operators):
    """Against forms written with vectors, which know nothing of components."""
    import ufl

    from solidwhirl.reduction.operators import compat, forms

    body = operators(None)
    kin, matter = body.ingredients.kinematics, body.ingredients.matter
    u, v = ufl.TrialFunction(body.space), ufl.TestFunction(body.space)
    dx = ufl.Measure("dx", domain=body.space.mesh, metadata={"quadrature_degree": 4})

    def turned(w):
        return ufl.as_vector((-w[1], w[0], 0.0 * w[2])) - kin.spin(w)

    weight = matter.density * kin.weight
    for name, form in (
        ("mass", forms.mass_form(kin, matter, u, v, dx)),
        ("gyroscopic", forms.gyroscopic_form(kin, matter, u, v, dx)),
        ("spin_softening", forms.softening_form(kin, matter, u, v, dx)),
        ("circulation", weight * ufl.inner(turned(u), turned(v)) * dx),
        ("turn", weight * ufl.inner(turned(u), v) * dx),
    ):
        expected = compat.assemble_matrix(compat.compiled(form))
        x, y = expected.createVecs()
        x.array[:] = np.random.default_rng(1).standard_normal(x.getLocalSize())
        expected.mult(x, y)
        z = y.duplicate()
        getattr(body, name).mult(x, z)
        np.testing.assert_allclose(z.array, y.array, rtol=0, atol=1e-12 * np.abs(y.array).max())


def test_modes_at_speed_are_those_of_a_factor_at_speed(operators):
    """Dense eigenvalues of the held body at speed; no factor at speed, no Krylov space."""
    from solidwhirl.reduction.basis.spinning_modes import MARGIN, Spinning, modes_at_speed
    from solidwhirl.reduction.solvers.constrained import eigenpairs, factorise
    from solidwhirl.reduction.solvers.vectors import apply

    body = operators(1)
    rows = body.coupling.rows
    n = len(rows)
    factor = factorise(body.stiffness, rows)
    at_rest, start = eigenpairs(factor, body.mass, shift=0.0, count=10)

    def centrifugal(block):
        return apply(body.stress_stiffening, block) - apply(body.spin_softening, block)

    k, m, c = apply(body.stiffness, np.eye(n)), apply(body.mass, np.eye(n)), centrifugal(np.eye(n))
    held = scipy.linalg.null_space(rows.T)
    k, m, c = (held.T @ a @ held for a in (k, m, 0.5 * (c + c.T)))
    dense = scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=[0, 9])
    np.testing.assert_allclose(at_rest[:10], dense, rtol=1e-8)
    free = np.empty((n, 0))
    pencil = Spinning(operators=body, speed_rad_s=TOP, factor=factor, free=free)
    found = modes_at_speed(pencil, start, lambda values, _: np.arange(len(values)) < 2)
    assert found is not None
    dense, shapes = scipy.linalg.eigh(k + TOP**2 * c, m, subset_by_index=[0, 9])
    assert np.abs(dense[:8] / at_rest[:8] - 1.0).max() > 1e-4  # the spin does show
    np.testing.assert_allclose(found[0][:2], dense[:2], rtol=1e-9)
    for known in (10, 9, 5):  # a start that cuts a pair in two ends no worse
        got = modes_at_speed(pencil, start[:, :known], lambda values, _: np.arange(len(values)) < 2)
        assert got is not None
        inside = held.T @ got[1][:, :2]
        beside = inside - shapes[:, :2] @ (shapes[:, :2].T @ m @ inside)
        # measured 1e-12; 4e-10 without the last corrections, which a merged basis divides by 3e-4
        assert np.sqrt(np.diag(beside.T @ m @ beside)).max() < 3e-11
    # a solver that does not help is given up before the last sweep
    random, asked = np.random.default_rng(0), []

    class Useless:
        def solve(self, loads, _):
            asked.append(1)
            return 1e-3 * random.standard_normal(loads.shape)

    lost = dataclasses.replace(pencil, factor=Useless())
    assert modes_at_speed(lost, start, lambda values, _: np.arange(len(values)) < 2) is None
    assert len(asked) < 6
    # the softest direction to 1 % of itself or of the margin that it has to keep, twice for safety
    softest = scipy.linalg.eigh(c, k, eigvals_only=True, subset_by_index=[0, 0])[0]
    left = pencil.remaining_stiffness
    close = 0.02 * max(TOP**2 * abs(softest), MARGIN)
    assert left == pytest.approx(1.0 + TOP**2 * softest, abs=close)


def test_a_factor_that_does_not_fit_is_refused(operators, monkeypatch):
    from solidwhirl.reduction.solvers import constrained

    body = operators(None)
    monkeypatch.setattr(constrained, "available_memory_bytes", lambda comm: 2_000_000)
    with pytest.raises(ReductionError, match=r"needs .* GB of memory .* 0.002 GB are available"):
        constrained.factorise(body.stiffness, body.coupling.rows)


def test_memory_of_a_factor_begins_with_what_is_expected_and_ends_with_its_last_reference(
    operators, monkeypatch
):
    """MUMPS takes address space at once: hundreds of factors of a process must not add up."""
    from solidwhirl.reduction.solvers import constrained

    def mapped():
        return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()

    body = operators(None)
    before = mapped()
    factor = constrained.factorise(body.stiffness, body.coupling.rows)
    held = mapped() - before
    assert 0.4 * constrained._FIRST_BYTES < held < 4 * constrained._FIRST_BYTES
    answer = factor.solve(None, np.eye(factor.border))
    del factor
    assert mapped() - before < 0.5 * held
    # too little at first is followed by all there is
    monkeypatch.setattr(constrained, "_FIRST_BYTES", 2_000_000)
    monkeypatch.setattr(constrained, "_OF_EXPECTED", 0.0)
    again = constrained.factorise(body.stiffness, body.coupling.rows)
    np.testing.assert_allclose(
        again.solve(None, np.eye(again.border)), answer, atol=1e-9 * np.abs(answer).max()
    )


@pytest.mark.parametrize(("coupling", "length"), [("rigid", 0.8), ("distributing", 0.2)])
def test_prestress_with_the_factor_of_the_held_body(coupling, length):
    """Against the free body's own factor; a short body is all neighbourhood of rigid ends."""
    import ufl
    from mpi4py import MPI

    from solidwhirl.reduction.operators import forms, prestress
    from solidwhirl.reduction.operators.matrices import OperatorEffects, assembled, build_operators
    from solidwhirl.reduction.solvers.vectors import apply

    def built(length_m):
        ends = (plane("a", 0.0, coupling), plane("b", length_m, coupling))
        body = body_of(section("rod", 0.0, length_m, 0.0, 0.04), interfaces=ends)
        effects = OperatorEffects(
            gyroscopic=False,
            centrifugal=True,
            components={i.name: ("ux", "uy", "uz", "rx", "ry", "rz") for i in ends},
            shape="asymmetric",
        )
        mesh = whole_mesh(mesh_revolved(body, MeshSize(size_m=0.04, corner_size_m=0.04, around=8)))
        return build_operators(body, mesh[0], MPI.COMM_SELF, order=None, degree=2, effects=effects)

    def whole_stiffness(operators):
        given = operators.ingredients
        u, v = ufl.TrialFunction(operators.space), ufl.TestFunction(operators.space)
        dx = forms.measure(operators.space.mesh, given.kinematics, 2)
        form = forms.stiffness_form(given.kinematics, given.matter, u, v, dx)
        return assembled(form), dx

    operators = built(length)
    stiffness, dx = whole_stiffness(operators)
    given = operators.ingredients
    rest = (given.kinematics, given.matter, dx, stiffness, given.component_mass)
    own, hoop = prestress.centrifugal_displacement(operators.space, *rest)
    known, found = own.x.array, given.centrifugal_field.x.array
    np.testing.assert_allclose(found, known, atol=1e-9 * np.abs(known).max(), rtol=0.0)
    assert operators.hoop_strain == pytest.approx(hoop, rel=1e-9)
    load = apply(stiffness, known[:, None])
    left = load - apply(stiffness, operators.held.released(stiffness, load))
    assert np.abs(left).max() < 1e-8 * np.abs(load).max()
    if coupling == "rigid":
        short = built(0.1)
        stiffness, _ = whole_stiffness(short)
        assert short.held.released(stiffness, np.zeros((stiffness.getSize()[0], 1))) is None
