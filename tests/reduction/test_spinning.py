"""Centrifugal field, stiffening, softening and Coriolis terms against closed forms."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from reduced import reduced_to

from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.own.whole import whole_mesh
from solidwhirl.reduction import ReductionError
from solidwhirl.rotordyn import Rotor, assemble, modes_at_speed

pytestmark = pytest.mark.solver


def frequencies_rad_s(mass, coupling, stiffness):
    """|Im λ| of M λ² + G λ + K."""
    one = np.eye(len(mass))
    below = np.linalg.solve(mass, np.hstack([-stiffness, -coupling]))
    return np.abs(np.linalg.eigvals(np.vstack([np.hstack([0.0 * one, one]), below])).imag)


@pytest.fixture(scope="module")
def turning_ring(spinning_ring):
    """Superelement of the ring, n = 2."""
    return reduced_to(
        spinning_ring,
        orders=(2,),
        components=(),
        degree=3,
        modes=3,
        size=MeshSize(size_m=0.001, corner_size_m=0.001),
        maximum_speed_rad_s=1000.0,
        gyroscopic=True,
        centrifugal=True,
    )[0]


@pytest.mark.parametrize("omitted", [None, "stress_stiffening", "spin_softening", "gyroscopic"])
def test_spinning_ring(turning_ring, omitted):
    """Bryan's ring, n = 2 at 1000 rad/s: inextensional closed form in the rotating frame,

    |w| = sqrt(K/(1+n²) + Ω² n²(n²-1)²/(n²+1)²) -+ 2nΩ/(n²+1), K = E I n²(n²-1)²/(ρ A R⁴):
    102.325 and 356.973 Hz. In the fixed frame 2Ω is added to the forward and taken from the
    backward wave. Every term that is left out must show.
    """
    n, speed = 2, 1000.0
    radius, side, E, rho = 0.1, 0.002, 2.1e11, 7850.0
    stiffness = E * side**2 / 12 * n**2 * (n**2 - 1) ** 2 / (rho * radius**4)
    root = np.sqrt(stiffness / (1 + n**2) + (speed * n * (n**2 - 1) / (n**2 + 1)) ** 2)
    shift = 2 * n * speed / (n**2 + 1)
    matrices = {
        name: getattr(turning_ring, name) * (0.0 if name == omitted else 1.0)
        for name in ("stress_stiffening", "spin_softening", "gyroscopic")
    }
    stress, softening, gyroscopic = matrices.values()
    k = turning_ring.stiffness + speed**2 * (stress - softening)
    found = frequencies_rad_s(turning_ring.mass, speed * gyroscopic, k)
    expected = np.array([abs(root - shift + n * speed), abs(root + shift - n * speed)])
    # the ring has out-of-plane modes nearby: each expected frequency is looked for; the error is
    # relative to the rotating-frame frequency, 643 rad/s
    error = max(np.abs(found - w).min() for w in expected) / (root - shift)
    if omitted is None:
        assert error < 1.5e-3
    else:
        assert error > 0.03


@pytest.mark.parametrize("level", ["harmonic", "solid"])
def test_annular_disk_growth_and_stress(annular_disk, level):
    """Plane stress: u(a) = 62.4963, u(b) = 67.7530 µm at 1000 rad/s; hoop stress at the bore

    (3+ν)/8 ρΩ² (a²+b²+b² - (1+3ν)/(3+ν) a²) = 262.484 MPa.
    """
    import ufl
    from mpi4py import MPI

    from solidwhirl.reduction.operators import compat, forms, kinematics
    from solidwhirl.reduction.operators.cyclic import CyclicIndex
    from solidwhirl.reduction.operators.prestress import centrifugal_displacement

    if level == "harmonic":
        mesh = mesh_meridian(annular_disk, MeshSize(size_m=0.005, corner_size_m=0.005))
    else:
        mesh = mesh_revolved(annular_disk, MeshSize(size_m=0.02, corner_size_m=0.02, around=24))
    domain, tags, _ = compat.distribute(mesh, mesh.dimension, MPI.COMM_SELF)
    kin = (
        kinematics.harmonic(domain, 0)
        if level == "harmonic"
        else kinematics.sector(domain, CyclicIndex(sector=mesh.sector, index=0, symmetric=True))
    )
    matter = forms.medium(domain, tags, mesh.materials)
    space = compat.vector_space(domain, 2, 3)
    dx = ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": 6})
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    stiffness = compat.assemble_matrix(compat.compiled(forms.stiffness_form(kin, matter, u, v, dx)))
    field, hoop = centrifugal_displacement(space, kin, matter, dx, stiffness)
    x = space.tabulate_dof_coordinates()
    values = field.x.array.reshape(-1, 3)[: len(x)] * 1000.0**2
    if level == "harmonic":
        radius, radial = x[:, 1], values[:, 0]
        middle = np.abs(x[:, 0] - 0.005) < 0.0026
    else:
        radius = np.hypot(x[:, 0], x[:, 1])
        radial = (values[:, :2] * x[:, :2]).sum(axis=1) / radius
        middle = np.abs(x[:, 2] - 0.005) < 0.0026
    # plane stress is the mean over the thickness; the mid-plane bulges by ν-terms of (t/b)²
    for r, expected in ((0.05, 62.4963e-6), (0.2, 67.7530e-6)):
        at = middle & (np.abs(radius - r) < 1e-6)
        assert radial[at].mean() == pytest.approx(expected, rel=1.5e-3)
    # at the free bore σθ = E u/r
    assert hoop * 1000.0**2 * 2.1e11 == pytest.approx(262.484e6, rel=1.5e-3)


def test_speed_beyond_linear_prestress_is_refused(reference_rotor):
    with pytest.raises(ReductionError, match=r"hoop strain is .* good to 0.05, that is to \d+"):
        reduced_to(
            reference_rotor, maximum_speed_rad_s=2e4, gyroscopic=True, centrifugal=True, modes=2
        )


@pytest.mark.verify
def test_frames_agree(reference_rotor):
    """Inertial frame against the rotating frame of the same solid: ω_inertial = |ω_rot ± Ω|.

    The rotating frame has Coriolis 2∫ρ v·(e_z×u) and spin softening ∫ρ (e_z×v)·(e_z×u); its
    matrices are assembled here, on the same mesh and prestress.
    """
    import ufl
    from mpi4py import MPI

    from solidwhirl.reduction.basis.craig_bampton import reduction_basis
    from solidwhirl.reduction.operators import compat
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
    from solidwhirl.reduction.solvers.vectors import project

    size = MeshSize(size_m=0.05, corner_size_m=0.02, growth=1.0, around=12)
    mesh = mesh_revolved(reference_rotor, size)
    effects = OperatorEffects(gyroscopic=True, centrifugal=True, components={}, shape="round")
    bare = dataclasses.replace(reference_rotor, interfaces=())
    operators = build_operators(
        bare, whole_mesh(mesh)[0], MPI.COMM_SELF, order=None, degree=2, effects=effects
    )
    basis = reduction_basis(operators, modes=4, maximum_speed_rad_s=1000.0)
    domain = operators.space.mesh
    matter, weight = operators.ingredients.matter, operators.ingredients.kinematics.weight
    u, v = ufl.TrialFunction(operators.space), ufl.TestFunction(operators.space)
    dx = ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": 4})

    def around(w):
        return ufl.as_vector((-w[1], w[0], 0.0 * w[2]))

    rotating = {}
    for name, form in (
        ("coriolis", 2.0 * weight * matter.density * ufl.inner(around(u), v) * dx),
        ("softening", weight * matter.density * ufl.inner(around(u), around(v)) * dx),
    ):
        matrix = compat.assemble_matrix(compat.compiled(form))
        rotating[name] = project(matrix, basis.vectors, MPI.COMM_SELF)
    m = project(operators.mass, basis.vectors, MPI.COMM_SELF)
    k = project(operators.stiffness, basis.vectors, MPI.COMM_SELF)
    sigma = project(operators.stress_stiffening, basis.vectors, MPI.COMM_SELF)
    speed = 1000.0
    stiffness = k + speed**2 * (sigma - rotating["softening"])
    turning = frequencies_rad_s(m, speed * rotating["coriolis"], stiffness)
    spin = {"maximum_speed_rad_s": speed, "gyroscopic": True, "centrifugal": True}
    element, _ = reduced_to(reference_rotor, "solid", mesh=mesh, modes=4, **spin)
    system = assemble({"rotor": Rotor(element=element, speed_ratio=1.0)}, ())
    fixed = 2 * np.pi * modes_at_speed(system, speed).frequency_hz[:5]
    mapped = np.concatenate([np.abs(turning + speed), np.abs(turning - speed)])
    for w in fixed:
        # the frames agree to the discretisation of the flow around the axis, not to round-off
        assert np.abs(mapped / w - 1.0).min() < 2e-4
