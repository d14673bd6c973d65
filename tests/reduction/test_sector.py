"""Sectors: against the whole circle, against each other's forms, joined stages; section 5 and 3."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg
from reduced import reduced_to, sparse
from shapes import bladed_disk, section
from shapes import body as body_of
from sometimes import often

from solidwhirl.geometry import Interface
from solidwhirl.meshing import MeshSize, mesh_revolved
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.meshing.own.joined import mesh_joined
from solidwhirl.meshing.own.revolved import unfolded
from solidwhirl.meshing.own.whole import whole_mesh

pytestmark = pytest.mark.solver

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
BORE = Interface(name="bore", kind="inner", coupling="rigid", start_m=-0.006, end_m=0.006)
TURNING = {"maximum_speed_rad_s": 600.0, "gyroscopic": True, "centrifugal": True}
SIZE = MeshSize(size_m=0.02, corner_size_m=0.006, growth=0.5)


def motions(element):
    """Rᵀ K2 R of the rigid motions over what rounding leaves of a sum this long."""
    rigid = element.rigid_body_modes
    found = rigid.T @ (element.stress_stiffening - element.spin_softening) @ rigid
    sizes = abs(element.stress_stiffening) + abs(element.spin_softening)
    terms = abs(rigid).T @ sizes @ abs(rigid)
    rounding = element.full_dofs * np.finfo(float).eps * terms.max()
    return found / rounding


@pytest.mark.parametrize("orders", [(1,), (0, 1)])
def test_half_and_whole_sector_are_one_model(orders):
    """Real amplitudes of half a sector, complex ones of the whole: one mesh of the circle."""
    from shapes import plane

    shaft = body_of(
        section("shaft", 0.0, 0.4, 0.0, 0.02),
        section("disk", 0.145, 0.175, 0.02, 0.15),
        interfaces=(plane("a", 0.0), plane("b", 0.4, "rigid")),
    )
    mesh = mesh_revolved(shaft, MeshSize(size_m=0.03, corner_size_m=0.01))
    asked = {"components": ALL if 0 in orders else ALL[:2], "orders": orders, **TURNING}
    half, whole = (reduced_to(shaft, "solid", mesh=m, **asked)[0] for m in (mesh, unfolded(mesh)))
    # forward and backward, at speed, on the interfaces' own stiffness
    np.testing.assert_allclose(at_speed(half), at_speed(whole), rtol=2e-9)
    for element in (half, whole):
        assert np.abs(motions(element)).max() < 1.0
        assert np.abs(np.trace(element.moments.second_kg) - element.mass).max() < 1e-12


def at_speed(element, speed=600.0, count=16):
    """Lowest angular frequencies of a body on springs at its interfaces."""
    m, g = element.mass, speed * element.gyroscopic
    k = element.stiffness + speed**2 * (element.stress_stiffening - element.spin_softening)
    for i, c in enumerate(element.coordinates):
        if c.kind == "interface":
            k[i, i] += 1e8 if c.component[0] == "u" else 1e5
    n = len(m)
    state = np.block(
        [[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), -np.linalg.solve(m, g)]]
    )
    found = np.linalg.eigvals(state).imag
    return np.sort(found[found > 1.0])[:count]


@pytest.mark.verify
def test_sector_of_staggered_blades_against_the_whole_circle():
    """Held modes at rest of index 0 and 1 are among those of the same mesh, all around."""
    from mpi4py import MPI

    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    body, components = bladed_disk(), {"bore": ()}
    mesh = mesh_sector(body, MeshSize(size_m=0.04, corner_size_m=0.02, growth=1.0))
    element, work = reduced_to(
        body, "solid", mesh=mesh, orders=(0, 1), components=ALL, modes=4, **TURNING
    )
    assert all(check.passed for check in work.checks)
    assert np.abs(motions(element)).max() < 1.0
    effects = OperatorEffects(
        gyroscopic=False, centrifugal=False, components=components, shape="any"
    )
    operators = build_operators(
        body, whole_mesh(mesh)[0], MPI.COMM_SELF, order=None, degree=2, effects=effects
    )
    free = len(operators.coupling.unknowns.norms)  # the masters after them are held
    k, m = (sparse(a)[:free, :free] for a in (operators.stiffness, operators.mass))
    known = scipy.sparse.linalg.eigsh(k.tocsc(), 40, m.tocsc(), sigma=0.0, which="LM")[0]
    hz = np.sqrt(known) / (2.0 * np.pi)
    for own in element.fixed_interface_frequencies_hz[:6]:
        assert np.abs(hz / own - 1.0).min() < 1e-9


def test_mirrored_and_turned_blades_have_the_same_modes():
    """Without stagger half a sector is enough; a stagger of rounding needs the whole one."""
    hz = []
    for stagger in (0.0, 1e-4):
        body = bladed_disk(stagger_deg=stagger)
        mesh = mesh_sector(body, SIZE)
        assert mesh.sector.mirrored == (stagger == 0.0)
        element, _ = reduced_to(
            body, "solid", mesh=mesh, orders=(0, 1), components=ALL, modes=3, **TURNING
        )
        hz.append(element.fixed_interface_frequencies_hz[:6])
    # two meshes of one body, each with an error of some per cent
    np.testing.assert_allclose(*hz, rtol=0.02)


def test_bladed_disk_comes_down_to_its_limit():
    """Held bore, at rest: 1067.58, 1067.58, 1075.86 Hz (extrapolated, 0.15 %); estimates hold."""
    exact = np.array([1067.58, 1067.58, 1075.86])
    errors = []
    for corner in (9e-3, 6e-3):
        mesh = mesh_sector(bladed_disk(), MeshSize(size_m=0.02, corner_size_m=corner, growth=0.5))
        element, _ = reduced_to(
            bladed_disk(),
            "solid",
            mesh=mesh,
            orders=(0, 1),
            components=ALL,
            modes=3,
            estimates=("mode_truncation", "mesh"),
        )
        errors.append(element.fixed_interface_frequencies_hz[:3] / exact - 1.0)
        estimated = estimate(element, "mesh")
        assert (errors[-1] < estimated + 2e-3).all()
        assert (estimated < 3.0 * errors[-1]).all()
    assert (errors[0] > 0.0).all()
    assert (errors[1] < errors[0]).all()


def estimate(element, part, count=3):
    """Relative errors of the lowest held frequencies at rest by a form."""
    form = next(f for f in element.error_forms if f.part == part)
    kept = [k for k, c in enumerate(element.coordinates) if c.kind == "modal"]
    at = np.ix_(kept, kept)
    squared, shapes = scipy.linalg.eigh(element.stiffness[at], element.mass[at])
    out = []
    for k in range(count):
        q = np.zeros(element.size)
        q[kept] = shapes[:, k]
        z = np.concatenate([q, -squared[k] * q, 0.0 * q, 0.0 * q])
        out.append(0.5 * form.safety * (z @ form.gram @ z) / squared[k])
    return np.array(out)


@pytest.mark.parametrize(("joint", "known"), often([(0.05, 1e-5), (0.08, 2.8e-4)], (0.05, 1e-5)))
def test_stages_joined_by_one_order(joint, known):
    """What the orders 1 ± N add where rim and hub meet: 280 ppm at 0.08 m, few at 0.05 m."""
    body = bladed_disk(joint=joint)
    mesh = mesh_joined(body, MeshSize(size_m=0.016, corner_size_m=0.006, growth=0.5))
    asked = {"orders": (0, 1), "components": ALL, "modes": 3, "estimates": ("mode_truncation",)}
    alone, work = reduced_to(body, "solid", mesh=mesh, **asked, **TURNING)
    assert all(check.passed for check in work.checks)
    both, _ = reduced_to(body, "solid", mesh=mesh, neighbours=True, **asked, **TURNING)
    stiffer = alone.fixed_interface_frequencies_hz[0] / both.fixed_interface_frequencies_hz[0] - 1.0
    assert known / 2.0 < stiffer < 2.0 * known
    assert stiffer / 3.0 < estimate(alone, "stage_joints")[0] < 3.0 * stiffer
    for element in (alone, both):
        assert np.abs(motions(element)).max() < 1.0
