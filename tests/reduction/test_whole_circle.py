"""All cyclic indices of a sector have the frequencies of the whole circle of its mesh, at speed.

The whole is assembled by forms of its own, in the frame that turns, with the stress of its own
static solution; both are unreduced, so that rounding alone is between them. It is eps times the
ratio of the highest to the lowest squared frequency of a mesh, 2e-16 · 1e6 here.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "meshing"))
from mesh_makers import request
from sector_makers import bladed, of_msh
from shapes import bladed_disk, plane, section
from shapes import body as body_of
from sometimes import often
from whole_circle import WholeCircle, rates, unreduced

from solidwhirl.meshing import MeshSize, mesh_revolved
from solidwhirl.meshing.imported.body import body_of_mesh, mesh_of
from solidwhirl.meshing.imported.records import MeshInterface
from solidwhirl.meshing.own.features.sector import mesh_sector

pytestmark = pytest.mark.solver
COARSE = MeshSize(size_m=0.04, corner_size_m=0.02, growth=1.0)


def _revolved(folder):
    """Half a sector of a shaft with a disk, held at one end."""
    shaft, disk = section("shaft", 0.0, 0.1, 0.0, 0.02), section("disk", 0.03, 0.05, 0.02, 0.1)
    body = body_of(shaft, disk, interfaces=(plane("bore", 0.0, "rigid"),))
    return body, mesh_revolved(body, MeshSize(size_m=0.05, corner_size_m=0.03, growth=1.0))


def _blades(stagger_deg, count):
    body = bladed_disk(count, stagger_deg)
    return body, mesh_sector(body, COARSE)


def _given(folder):
    """A sector of six that gmsh wrote to a file, its blades over the cuts; held at the bore."""
    bladed(folder / "given.msh", count=6, stagger_deg=60.0)
    around = MeshInterface(name="bore", coupling="rigid", box_m=((-0.031,) * 3, (0.031,) * 3))
    asked = request("given.msh", shape="cyclic", sectors=6, interfaces=(around,))
    mesh = mesh_of(of_msh(folder / "given.msh"), asked, "disk")
    return body_of_mesh("disk", asked, mesh), mesh


CASES = {
    "revolved half sector": _revolved,
    "blades along the axis": lambda folder: _blades(0.0, 6),
    "staggered blades": lambda folder: _blades(30.0, 5),
    "given mesh": _given,
}


@pytest.mark.verify
@pytest.mark.parametrize("case", CASES)
def test_all_indices_are_the_whole_circle(case, tmp_path):
    """At rest and at 1500 rad/s, where the prestress lifts blades by 6 % and waves split by 1 %."""
    body, mesh = CASES[case](tmp_path)
    whole, count = WholeCircle(mesh), 12
    circle = whole.matrices.kept(whole.free("bore"))
    for speed in (0.0, 1500.0):
        found = []
        for index in range(mesh.sector.count // 2 + 1):
            operators, matrices = unreduced(body, mesh, index, held=True)
            own = rates(matrices, speed, count)[0]
            # a positive and a negative ω are two waves, of a real field one motion
            found += list(np.abs(own) if operators.families == 2 else own[own > 0.0])
            operators.release()
        # up to here every index has told its own
        known = np.sort(found)[: count // 2]
        same = rates(circle, speed, 2 * len(known) + 8)[0]
        same = np.sort(same[same > 0.0])[: len(known)]
        np.testing.assert_allclose(known, same, rtol=1e-10)


@pytest.mark.parametrize(
    "case", often(["revolved half sector", "staggered blades"], "staggered blades")
)
def test_modes_laid_around_the_circle_are_its_modes(case, tmp_path):
    """No force is left over at any node, and the quotient of the whole has the sector's rate."""
    body, mesh = CASES[case](tmp_path)
    whole, speed = WholeCircle(mesh), 1500.0
    free = whole.free("bore")
    stiffness, mass, turned, change = whole.matrices.kept(free)
    stiffness = stiffness + speed**2 * change
    for index in (0, 1, 2):
        operators, matrices = unreduced(body, mesh, index, held=True)
        omega, shapes = rates(matrices, speed, 6)
        unknowns = operators.coupling.unknowns
        padded = np.zeros((unknowns.count, 6), dtype=complex)
        padded[: len(shapes)] = shapes
        if operators.families == 1 or not unknowns.is_complex:
            # the amplitudes of real unknowns have a real and an imaginary part each
            laid = whole.fields(operators, padded.real) + 1j * whole.fields(operators, padded.imag)
        else:
            laid = whole.fields(operators, padded)
        laid = laid[free]
        terms = (stiffness @ laid, 2.0 * speed * omega * (turned @ laid), omega**2 * (mass @ laid))
        left = np.abs(terms[0] + terms[1] - terms[2])
        assert left.max() < 1e-10 * np.abs(stiffness).sum(axis=1).max() * np.abs(laid).max()
        a, b, c = (np.einsum("ij,ij->j", laid.conj(), x @ laid).real
                   for x in (mass, 2.0 * speed * turned, stiffness))  # fmt: skip
        root = (b + np.sign(omega) * np.sqrt(b**2 + 4.0 * a * c)) / (2.0 * a)
        np.testing.assert_allclose(root, omega, rtol=1e-10)
        operators.release()
