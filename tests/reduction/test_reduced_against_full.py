"""The superelement against the unreduced model, and couplings."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp
from reduced import reduced_to, sparse
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh
from shapes import STEEL, interface, plane, section
from shapes import body as body_of

from solidwhirl.geometry import Blade
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.rotordyn import Bearing, End, Rotor, assemble, check_superelement, modes_at_speed

pytestmark = pytest.mark.solver


def full_frequencies(body, mesh, stiffness, speed, count, tilt=0.0):
    """Lowest frequencies [Hz] of the unreduced model on springs at its interfaces.

    `stiffness`, `tilt`: of the springs along x and y, and about them.
    """
    from mpi4py import MPI
    from petsc4py import PETSc

    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    effects = OperatorEffects(
        gyroscopic=True,
        centrifugal=True,
        components={
            i.name: ("ux", "uy", "rx", "ry") if tilt else ("ux", "uy") for i in body.interfaces
        },
    )
    operators = build_operators(body, mesh, MPI.COMM_SELF, order=1, degree=2, effects=effects)

    def whole(matrix):
        return sparse(matrix.folded() if hasattr(matrix, "folded") else matrix)

    m, k, g, kg, s = (
        whole(getattr(operators, name))
        for name in ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
    )
    rows = sp.csr_matrix(operators.coupling.rows)
    springs = [{"u": stiffness, "r": tilt}[c[0]] for _, c in operators.coupling.coordinates]
    k = k + rows @ sp.diags(springs) @ rows.T + speed**2 * (kg - s)
    if speed == 0.0:  # all are double, which the general solver's LAPACK fails to sort
        squared = eigsh(sp.csc_matrix(k), count, sp.csc_matrix(m), sigma=0.0)[0]
        return np.sort(np.repeat(np.sqrt(squared) / (2.0 * np.pi), operators.families))
    if operators.families == 2:
        m, k = sp.block_diag([m, m]), sp.block_diag([k, k])
        g = sp.bmat([[None, 2.0 * g], [-2.0 * g, None]])
    matrices = []
    for matrix in (k, speed * g + 0.0 * m, m):
        a = sp.csr_matrix(matrix)
        a.sort_indices()
        matrices.append(PETSc.Mat().createAIJ(size=a.shape, csr=(a.indptr, a.indices, a.data)))
    return quadratic_frequencies(matrices, count)


def quadratic_frequencies(matrices, count):
    """|λ|/2π of K + λ C + λ² M nearest to zero by SLEPc's two-level orthogonal Arnoldi."""
    from petsc4py import PETSc
    from slepc4py import SLEPc

    pep = SLEPc.PEP().create(PETSc.COMM_SELF)
    pep.setOperators(matrices)
    pep.setType(SLEPc.PEP.Type.TOAR)
    pep.setTarget(0.0)
    pep.setWhichEigenpairs(SLEPc.PEP.Which.TARGET_MAGNITUDE)
    pep.setDimensions(nev=2 * count + 4, ncv=5 * count)
    pep.setTolerances(tol=1e-9)
    pep.setScale(SLEPc.PEP.Scale.SCALAR)
    st = pep.getST()
    st.setType(SLEPc.ST.Type.SINVERT)
    st.getKSP().setType("preonly")
    st.getKSP().getPC().setType("lu")
    st.getKSP().getPC().setFactorSolverType("mumps")
    pep.solve()
    assert pep.getConverged() >= 2 * count
    values = np.array([pep.getEigenpair(j) for j in range(pep.getConverged())])
    return np.sort(np.abs(values.imag) / (2.0 * np.pi))[::2][:count]


@pytest.mark.parametrize(
    ("level", "corner", "fractions"), [("harmonic", 2e-3, (0.0, 0.5, 1.0)), ("solid", 2e-2, (1.0,))]
)
def test_first_ten_frequencies_at_speed(twin_inner, level, corner, fractions):
    """Eight modes per plane, at rest and at top speed: one basis for all speeds."""
    size = MeshSize(size_m=0.05, corner_size_m=corner, growth=1.0, around=8)
    mesh = (mesh_meridian if level == "harmonic" else mesh_revolved)(twin_inner, size)
    top = 20_000 * np.pi / 30.0
    element, _ = reduced_to(
        twin_inner,
        level=level,
        size=size,
        modes=8,
        maximum_speed_rad_s=top,
        gyroscopic=True,
        centrifugal=True,
    )
    springs = tuple(
        Bearing(name=i, first=End(body="r", interface=i), stiffness_n_per_m=1e8 * np.eye(2))
        for i in ("A", "B", "C")
    )
    system = assemble({"r": Rotor(element=element, speed_ratio=1.0)}, springs)
    for fraction in fractions:
        speed = fraction * top
        found = modes_at_speed(system, speed).frequency_hz[:10]
        full = full_frequencies(twin_inner, mesh, 1e8, speed, 14)
        np.testing.assert_allclose(found, full[:10], rtol=1e-4)


#: Blades that are as soft in the plane of rotation as out of it: length, width, radius at the root.
LONG, WIDE, ROOT = 0.3, 0.015, 0.03
RUBBER = dataclasses.replace(
    STEEL, name="rubber", youngs_modulus_pa=2e9, poissons_ratio=0.0, density_kg_per_m3=1200.0
)


def rotating_beam(speed, count=8):
    """First squared rates [1/s²] of a blade held at its root, out of the plane and in it.

    Ritz with polynomials: bending, and the centrifugal force ρAΩ²(ROOT (l - x) + (l² - x²)/2).
    """
    x, weight = (0.5 * LONG * a for a in np.polynomial.legendre.leggauss(40))
    x = x + 0.5 * LONG
    powers = [np.polynomial.Polynomial([0.0] * n + [1.0]) for n in range(2, 2 + count)]
    shape, slope, curve = (
        np.array([p.deriv(k)(x / LONG) / LONG**k for p in powers]) for k in (0, 1, 2)
    )
    area = RUBBER.density_kg_per_m3 * WIDE**2
    pull = area * (ROOT * (LONG - x) + 0.5 * (LONG**2 - x**2))
    mass = area * (weight * shape) @ shape.T
    bending = RUBBER.youngs_modulus_pa * WIDE**4 / 12.0 * (weight * curve) @ curve.T
    whole = bending + speed**2 * (weight * pull * slope) @ slope.T
    flap = eigh(whole, mass, eigvals_only=True)[0]
    return flap, flap - speed**2


def test_blades_that_are_soft_in_the_plane_of_rotation():
    """Their wave stands still in space where a blade has 1/rev: no loss of stiffness.

    There K + Ω² (Kσ - S) of index 1 is singular. Beyond it frequencies are those of the unreduced
    model, and of the beam: in fixed axes |ω ± Ω|. The root on a round hub
    makes 1 % of ω, and of the speed at which ω(Ω) = Ω somewhat more.
    """
    blades = Blade(
        name="blades", on="hub", count=4, length_m=LONG, chord_m=(WIDE, WIDE),
        thickness_m=(WIDE, WIDE), stagger_deg=(0.0, 0.0), material=RUBBER,
    )  # fmt: skip
    hub = section("hub", -WIDE, WIDE, 0.01, ROOT)
    bore = interface("bore", "inner", -WIDE, WIDE, coupling="rigid")
    body = dataclasses.replace(body_of(hub, interfaces=(bore,)), features=(blades,))
    lost = brentq(lambda speed: rotating_beam(speed)[1] - speed**2, 10.0, 300.0)
    top = 1.5 * lost
    mesh = mesh_sector(body, MeshSize(size_m=0.05, corner_size_m=0.02, growth=1.0))
    held = {"components": ("ux", "uy", "rx", "ry"), "gyroscopic": True, "centrifugal": True}
    element, work = reduced_to(body, "solid", mesh=mesh, maximum_speed_rad_s=top, **held)
    assert all(check.passed for check in (*work.checks, *check_superelement(element)))
    spring = Bearing(
        name="s",
        first=End(body="r", interface="bore"),
        stiffness_n_per_m=1e8 * np.eye(2),
        tilt_stiffness_n_m_per_rad=1e5 * np.eye(2),
    )
    system = assemble({"r": Rotor(element=element, speed_ratio=1.0)}, (spring,))
    k, k2 = system.stiffness, system.centrifugal_stiffness
    assert 1.0 / np.sqrt(-eigh(k2, k, eigvals_only=True)[0]) == pytest.approx(lost, rel=0.02)
    found = modes_at_speed(system, top).frequency_hz[:8]
    full = full_frequencies(body, mesh, 1e8, top, 10, tilt=1e5)
    np.testing.assert_allclose(found, full[:8], rtol=1e-4)
    flap, lag = np.sqrt(rotating_beam(top))
    beam = np.abs([flap - top, lag - top, flap + top, lag + top]) / (2.0 * np.pi)
    np.testing.assert_allclose(found[:4], np.sort(beam), rtol=0.0, atol=0.02 * lag / (2.0 * np.pi))


def test_rigid_coupling_is_stiffer_than_distributing(twin_inner):
    """Both leave the free rigid motions alone; rigid planes stiffen, mean motions do not."""
    planes = [plane(i.name, i.start_m, "rigid") for i in twin_inner.interfaces]
    rigid = body_of(*twin_inner.sections, interfaces=planes, name="inner")
    # graded at the same places, so that all three have the same mesh but for the rigid ends
    size = MeshSize(size_m=0.02, corner_size_m=0.002)
    soft, _ = reduced_to(twin_inner, size=size, modes=14)
    hard, _ = reduced_to(rigid, size=size, modes=14)
    free, _ = reduced_to(twin_inner, size=size, modes=14, components=())
    # six retained modes beyond the compared ones keep the truncation below 1e-5
    np.testing.assert_allclose(
        soft.free_frequencies_hz[:6], free.free_frequencies_hz[:6], rtol=1e-5
    )
    assert np.all(hard.free_frequencies_hz[:6] > free.free_frequencies_hz[:6])
    assert hard.free_frequencies_hz[0] < 1.02 * free.free_frequencies_hz[0]


@pytest.mark.parametrize("coupling", ["rigid", "distributing"])
def test_levels_agree_on_an_interface_stiffness(coupling):
    """Static stiffness of a clamped stub against an Euler beam with shear, on both levels."""
    ends = (plane("clamp", 0.0, coupling), plane("tip", 0.2, coupling))
    body = body_of(section("stub", 0.0, 0.2, 0.0, 0.02), interfaces=ends)
    stiffness = []
    for level, size in (
        ("harmonic", MeshSize(size_m=0.01, corner_size_m=0.002)),
        ("solid", MeshSize(size_m=0.02, corner_size_m=0.008, around=16)),
    ):
        element, _ = reduced_to(
            body, level=level, size=size, components=("ux", "uy", "rx", "ry"), modes=2
        )
        tip = [element.interface_index("tip", c) for c in ("ux", "ry")]
        flexibility = np.linalg.inv(element.stiffness[np.ix_(tip, tip)])
        stiffness.append(1.0 / flexibility[0, 0])
    inertia, area, shear = np.pi * 0.02**4 / 4, np.pi * 0.02**2, 2e11 / 2.6
    kappa = 6 * 1.3 / (7 + 6 * 0.3)
    beam = 1.0 / (0.2**3 / (3 * 2e11 * inertia) + 0.2 / (kappa * shear * area))
    np.testing.assert_allclose(stiffness[0], stiffness[1], rtol=1e-2)
    # end effects of the clamp reach about one radius of ten: rigid planes stiffen, means soften
    assert stiffness[0] == pytest.approx(beam, rel=0.03)


def test_partly_restrained_bodies_keep_their_rigid_motions(reference_rotor):
    """One bearing plane with translations only leaves the tilt free."""
    body = body_of(*reference_rotor.sections, interfaces=(plane("a", 0.0),))
    size = MeshSize(size_m=0.02, corner_size_m=0.002)
    free, _ = reduced_to(reference_rotor, size=size, modes=12)
    held, _ = reduced_to(body, size=size, modes=12)
    assert held.rigid_body_present.tolist() == [True, True, False, True, True, False]
    np.testing.assert_allclose(
        held.free_frequencies_hz[:6], free.free_frequencies_hz[:6], rtol=1e-5
    )
