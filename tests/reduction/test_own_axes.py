"""Superelements of solids that bend unlike in two planes, against all unknowns of their mesh.

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
from reduced import reduced_to
from whole_circle import Turning, _material, _turning, rates

sys.path.append(str(Path(__file__).parents[1] / "meshing"))
from shapes import bladed_disk

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
