"""Superelements of asymmetric solids, against all unknowns of their mesh.

The matrices of all unknowns have forms of their own (`whole_circle`), with a stress from a static
solution of their own.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
from mpi4py import MPI
from reduced import reduced_to, whole_of
from whole_circle import Turning, _material, _turning, rates

sys.path.append(str(Path(__file__).parents[1] / "meshing"))
from shapes import bladed_disk, plane, section
from shapes import body as body_of
from sometimes import often

from solidwhirl.meshing import MeshSize
from solidwhirl.meshing.own.features.sector import mesh_whole_body
from solidwhirl.reduction.operators import compat
from solidwhirl.rotordyn import check_superelement
from solidwhirl.rotordyn.superelement.free_body import free_body_matrices

pytestmark = pytest.mark.solver

COARSE = MeshSize(size_m=0.04, corner_size_m=0.02, growth=1.0)
TOP = 2500.0
ASKED = {
    "orders": (),
    "components": ("ux", "uy", "uz", "rx", "ry", "rz"),
    "maximum_speed_rad_s": TOP,
    "gyroscopic": True,
    "centrifugal": True,
}


def reduced(modes, body=None):
    body = body or bladed_disk(2)
    mesh = mesh_whole_body(body, COARSE)
    return reduced_to(body, "solid", mesh=mesh, modes=modes, **ASKED)[0]


@pytest.fixture(scope="module")
def fan():
    """Two blades on a disk: the superelement, and (K, M, iC, K2) of all unknowns, its bore held."""
    body = bladed_disk(2)
    mesh = mesh_whole_body(body, COARSE)
    element, work = reduced_to(body, "solid", mesh=mesh, modes=8, **ASKED)
    domain, cells, facets = compat.distribute(mesh, 3, MPI.COMM_SELF)
    space = compat.vector_space(domain, 2, 3)
    every = Turning(*(a.tocsr() for a in _turning(space, _material(domain, cells, mesh.materials))))
    from dolfinx import fem

    tags = facets["bore"]
    held = fem.locate_dofs_topological(space, tags.dim, tags.indices)
    still = np.zeros(len(space.tabulate_dof_coordinates()), dtype=bool)
    still[held] = True
    return element, work, every.kept(np.flatnonzero(~np.repeat(still, 3)))


def held_rates(element, speed):
    """Angular frequencies of the superelement with its interfaces held, of either sign."""
    modal = np.array([c.kind == "modal" for c in element.coordinates])
    own = np.ix_(modal, modal)
    change = (element.stress_stiffening - element.spin_softening)[own]
    stiffness = element.stiffness[own] + speed**2 * change
    mass, turned = element.mass[own], speed * element.gyroscopic[own]
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    first = np.block([[zero, one], [-stiffness, -turned]])
    values = la.eigvals(first, la.block_diag(one, mass))
    # undamped below the speed at which it diverges
    assert np.abs(values.real).max() < 1e-6 * np.abs(values).max()
    return np.sort(values.imag)


def test_frame(fan):
    element, work, _ = fan
    assert element.frame == "rotating"
    checks = (*check_superelement(element), *work.checks)
    # so few elements around do not fill the circle
    failed = {c.name for c in checks if c.passed is False}
    assert failed <= {"mass properties of the mesh"}
    # the disk and two blades: one plane has all of the blades' inertia
    inertia = element.inertia_kg_m2
    assert abs(inertia[0, 0] - inertia[1, 1]) > 0.05 * inertia[2, 2]


@pytest.mark.verify
def test_held_frequencies_at_speed(fan):
    """With prestress, spin softening and Coriolis forces: one basis for all speeds."""
    element, _, every = fan
    richer = reduced(20)
    for speed in (0.0, 1000.0, TOP):
        known, _ = rates(every, speed, 8)
        worst = [
            max(np.abs(held_rates(e, speed) / value - 1.0).min() for value in known)
            for e in (element, richer)
        ]
        if not speed:
            assert max(worst) < 1e-8
            continue
        # what Coriolis forces bring of modes beyond the basis, by the square of the speed
        assert worst[0] < 6e-4 * (speed / TOP) ** 2
        assert worst[1] < 0.25 * worst[0]


def test_rigid_motion_of_what_turns(fan):
    """A free body that stands still in space needs no force: (K2 + G T-terms) R = 0."""
    element, _, _ = fan
    bare = element.stress_stiffening - element.spin_softening
    mended = free_body_matrices(element).centrifugal_stiffness
    rigid = element.rigid_body_modes
    size = np.abs(rigid.T @ element.spin_softening @ rigid).max()
    assert np.abs(rigid.T @ (mended - bare) @ rigid).max() < 1e-6 * size


def test_a_mesh_that_turns_by_another_angle(fan):
    """The same body, its blades along another direction: the same frequencies, axes turned."""
    element, _, _ = fan
    body = bladed_disk(2)
    (blades,) = body.features
    turned = replace(body, features=(replace(blades, angle_deg=30.0),))
    other = reduced(8, turned)
    angle = np.radians(30.0)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    expected = turn @ element.inertia_kg_m2 @ turn.T
    assert other.inertia_kg_m2 == pytest.approx(expected, abs=1e-9 * expected.max())
    assert other.free_frequencies_hz == pytest.approx(element.free_frequencies_hz, rel=1e-5)


@pytest.mark.parametrize("flatter", often([0.0, 4e-3], 4e-3))
def test_what_a_mean_over_turns_changes_is_half_of_what_pairs_are_apart(flatter):
    """A rod that is a little elliptic, as a body of revolution, against its own axes."""
    rod = body_of(section("rod", 0.0, 0.3, 0.0, 0.02), interfaces=(plane("end", 0.0),))
    body, mesh = whole_of(rod, MeshSize(size_m=0.03, corner_size_m=0.03, growth=1.0, around=6))
    mesh = replace(mesh, points=mesh.points * [1.0 + flatter, 1.0 - flatter, 1.0])
    asked = ASKED | {"modes": 4, "maximum_speed_rad_s": 0.0, "gyroscopic": False}
    asked |= {"centrifugal": False, "accuracy": 1e-3}
    _, work = reduced_to(body, "solid", mesh=mesh, **(asked | {"orders": (1,)}))
    told = next(c for c in work.checks if c.name == "the mesh is the same in all directions")
    own = replace(body, request=replace(body.request, shape="asymmetric"))
    frequencies = reduced_to(own, "solid", mesh=mesh, **asked)[0].free_frequencies_hz[:4]
    first, second = frequencies[0::2], frequencies[1::2]
    apart = ((second - first) / (second + first)).max()
    assert told.value == pytest.approx(apart, rel=2e-2, abs=1e-6)
    # a slender rod is as stiff as it is thick
    assert told.value == pytest.approx(flatter, rel=0.1, abs=1e-6)
    assert told.passed is (flatter == 0.0)
