"""Checks of a reduction find what they are for, and pass bodies of every kind."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from reduced import reduced_to
from shapes import body as body_of
from shapes import plane, section

from solidwhirl.geometry import RigidDisk
from solidwhirl.meshing import MeshSize
from solidwhirl.reduction.basis import fixed_interface_modes as held_modes
from solidwhirl.rotordyn import check_superelement

pytestmark = pytest.mark.solver

COARSE = MeshSize(size_m=0.05, corner_size_m=0.02, growth=0.8, around=8)
MISSING, RESIDUAL = "no fixed-interface mode is missing", "residual of every fixed-interface mode"
ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
SPINNING = {"gyroscopic": True, "centrifugal": True, "maximum_speed_rad_s": 2000.0}


def bad(checks):
    return {check.name for check in checks if check.passed is False}


def shaft(*, interfaces=2, disk=False, coupling="distributing", fillet=0.0):
    """A stepped steel shaft with up to three planes."""
    places = {"a": 0.0, "b": 0.3, "c": 0.18}
    on_b = RigidDisk(
        name="disk",
        interface="b",
        mass_kg=3.0,
        polar_inertia_kg_m2=0.02,
        diametral_inertia_kg_m2=0.012,
    )
    return body_of(
        section("thin", 0.0, 0.1, 0.0, 0.02),
        section("thick", 0.1, 0.3, 0.0, 0.035),
        interfaces=[plane(n, z, coupling) for n, z in list(places.items())[:interfaces]],
        disks=(on_b,) if disk else (),
        fillet=fillet,
        name="shaft",
    )


@pytest.mark.parametrize(
    ("options", "request_"),
    [
        ({}, {}),
        ({}, {"orders": (1, 0), "components": ALL, **SPINNING}),
        ({"interfaces": 3}, {"components": ("ux", "uy", "rx", "ry"), **SPINNING}),
        ({"interfaces": 1}, {}),
        ({"interfaces": 0}, {}),
        ({"disk": True}, {"components": ("ux", "uy", "rx", "ry"), **SPINNING}),
        ({"coupling": "rigid"}, {"components": ALL, "orders": (1, 0)}),
        ({"fillet": 0.004}, SPINNING),
        ({}, {"modes": 1}),
        ({}, {"modes": 60}),
    ],
)
def test_good_meridians_pass(options, request_):
    element, work = reduced_to(shaft(**options), **request_)
    assert not bad(work.checks)
    orders = request_.get("orders", (1,))
    # residual, orthogonality, reciprocity and count of every order, all of them decided
    assert len(work.checks) == (4 if element.interfaces else 3) * len(orders)
    assert all(check.passed for check in work.checks)
    assert {check.where for check in work.checks} == {f"shaft, n={n}" for n in orders}
    assert not bad(check_superelement(element))


@pytest.mark.parametrize("orders", [(1,), (1, 0)])
def test_good_solids_pass(orders):
    components = ("ux", "uy") if orders == (1,) else ("ux", "uy", "uz", "rz")
    element, work = reduced_to(
        shaft(), level="solid", size=COARSE, modes=4, orders=orders, components=components
    )
    assert not bad(work.checks)
    assert not bad(check_superelement(element))
    count = next(check for check in work.checks if check.name == MISSING)
    assert count.passed, count.reason


def spoil(monkeypatch, solver, change, more=0):
    """Let an eigen-solver return its values and vectors changed, of some modes more than asked."""
    solve = getattr(held_modes, solver)

    def changed(*args, count, **options):
        return change(*solve(*args, count=count + more, **options))

    monkeypatch.setattr(held_modes, solver, changed)


def without(place):
    """The eigenpairs but one."""
    return lambda values, vectors: (np.delete(values, place), np.delete(vectors, place, axis=1))


@pytest.mark.parametrize("place", [0, 3, 7])
def test_a_dropped_mode_of_the_meridian_is_missed(monkeypatch, place):
    """Eight are kept; the last of them is seen to be missing by the eigenvalue beyond."""
    spoil(monkeypatch, "slepc_pairs", without(place), more=1)
    _, work = reduced_to(shaft())
    assert bad(work.checks) == {MISSING}
    check = next(c for c in work.checks if c.name == MISSING)
    assert check.value == 1.0
    assert "frequencies of the body" in check.concerns
    assert "9 modes counted, 8 found" in check.reason


def test_a_dropped_mode_of_the_solid_is_missed(monkeypatch):
    spoil(monkeypatch, "slepc_pairs", without(1), more=1)
    _, work = reduced_to(shaft(), level="solid", size=COARSE, modes=4)
    assert bad(work.checks) == {MISSING}


def test_a_wrong_eigenvalue_fails_its_residual(monkeypatch):
    """1e-6, which nothing else of the reduction would notice."""
    wrong = 1.0 + 1e-6 * (np.arange(100) == 2)
    spoil(monkeypatch, "slepc_pairs", lambda values, x: (values * wrong[: len(values)], x))
    element, work = reduced_to(shaft())
    assert bad(work.checks) == {RESIDUAL}
    check = next(c for c in work.checks if c.name == RESIDUAL)
    # the residual is the relative error of the eigenvalue, over its ratio to the lowest one
    lowest, _, _, _, third = element.fixed_interface_frequencies_hz[:5]
    assert check.value == pytest.approx(1e-6 * (lowest / third) ** 2, rel=1e-3)


def test_modes_that_are_not_orthonormal_fail(monkeypatch):
    long = 1.0 + 1e-6 * (np.arange(100) == 1)
    spoil(monkeypatch, "slepc_pairs", lambda values, x: (values, x * long[: x.shape[1]]))
    _, work = reduced_to(shaft())
    assert bad(work.checks) == {"modes of the basis are M-orthonormal"}


def test_interface_forces_that_are_not_reciprocal_fail(monkeypatch):
    """One constraint mode is off by 1e-3 of a fixed-interface mode: no longer in equilibrium."""
    from solidwhirl.reduction.body import verification

    solve = verification.verify_order

    def spoiled(operators, basis, orthogonality, where):
        vectors = np.array(basis.vectors)
        held = vectors[:, basis.interface_count]
        scale = np.abs(vectors[:, 0]).max() / np.abs(held).max()
        vectors[:, 0] += 1e-3 * scale * held
        return solve(operators, dataclasses.replace(basis, vectors=vectors), orthogonality, where)

    monkeypatch.setattr(verification, "verify_order", spoiled)
    _, work = reduced_to(shaft(interfaces=3))
    assert bad(work.checks) == {"interface forces are reciprocal"}
    check = next(c for c in work.checks if c.passed is False)
    assert check.concerns == "stiffness of the body between its bearings"


def test_wrong_mass_of_a_solid_fails(monkeypatch):
    from solidwhirl.reduction.body import superelements

    right = superelements.mesh_mass_properties
    monkeypatch.setattr(
        superelements,
        "mesh_mass_properties",
        lambda rigid: right(rigid)._replace(mass_kg=1.02 * right(rigid).mass_kg),
    )
    element, work = reduced_to(shaft(), level="solid", size=COARSE, modes=4)
    assert bad(work.checks) == {"mass properties of the mesh"}
    assert bad(check_superelement(element)) == {"mass properties"}


def test_no_gap_is_not_decided():
    """Eigenvalues that follow each other closely leave no room for a shift."""
    from types import SimpleNamespace

    from solidwhirl.reduction.body.verification import highest_gap

    values = 1e6 * (1.0 + 1e-5 * np.arange(6))
    basis = SimpleNamespace(fixed_eigenvalues=values, omitted_eigenvalue=values[-1] * (1 + 1e-5))
    assert highest_gap(basis) == (0.0, 0)
    values = np.array([1.0, 2.0, 3.0, 6.0, 6.6])
    basis = SimpleNamespace(fixed_eigenvalues=values, omitted_eigenvalue=6.61)
    assert highest_gap(basis) == (pytest.approx(np.sqrt(6.6 * 6.61)), 5)


@pytest.mark.verify
def test_the_count_of_a_solid_is_the_inertia_of_its_own_matrices():
    """All orders by Sylvester's law on the solid itself, against both solvers and the meridian."""
    from mpi4py import MPI

    from solidwhirl.meshing import mesh_meridian, mesh_revolved
    from solidwhirl.meshing.own.whole import whole_mesh
    from solidwhirl.reduction.body.verification import modes_below
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
    from solidwhirl.reduction.solvers.constrained import eigenpairs, factorise
    from solidwhirl.reduction.solvers.vectors import project

    components = {"a": ("ux", "uy"), "b": ("ux", "uy")}
    effects = OperatorEffects(
        gyroscopic=False, centrifugal=False, components=components, shape="round"
    )
    none = dataclasses.replace(effects, components={})
    fine = dataclasses.replace(COARSE, size_m=0.02, around=12)
    body = shaft()
    solid = build_operators(
        body,
        whole_mesh(mesh_revolved(body, fine))[0],
        MPI.COMM_SELF,
        order=None,
        degree=2,
        effects=effects,
    )
    rows = np.hstack([solid.coupling.rows, solid.coupling.anchors])
    factor = factorise(solid.stiffness, rows)
    values, vectors = eigenpairs(factor, solid.mass, shift=0.0, count=14)
    gaps = np.flatnonzero(np.diff(values) > 0.05 * values[1:])
    shifts = np.sqrt(values[gaps] * values[gaps + 1])
    assert len(shifts) >= 4
    # orders other than 0 and 1 move no interface; of order 0 the first one is held, as in the solid
    bare = dataclasses.replace(body, interfaces=())
    held = dataclasses.replace(effects, components={"a": (), "b": ()})
    own = {
        n: build_operators(
            body if n < 2 else bare,
            mesh_meridian(body if n < 2 else bare, fine),
            MPI.COMM_SELF,
            order=n,
            degree=2,
            effects={0: held, 1: effects}.get(n, none),
        )
        for n in range(6)
    }
    squared = np.diag(project(solid.circulation, vectors, MPI.COMM_SELF))
    for gap, shift in zip(gaps, shifts, strict=True):
        counted = modes_below(solid, float(shift))
        assert counted == gap + 1
        # a list with one mode less would be seen to be short
        assert counted != len(np.delete(values, 1)[:gap])
        # order by order on the meridian, pairs twice; the solid's orders from J²
        by_order = [(2 if n else 1) * modes_below(own[n], float(shift)) for n in own]
        assert sum(by_order) == counted
        orders = np.round(np.sqrt(np.maximum(squared[: gap + 1], 0.0)))
        found = [int(np.sum(orders == n)) for n in own]
        # in a group of equal frequencies the quotient of J² is a mean: compare sums
        assert sum(found) == counted
