"""Fields with the symmetry of a mesh that is unchanged by a part of a turn.

Under a turn R of 360°/k about the axis a field of a body of revolution can be sought with
``u(R x) = χ R u(x)``: k = 2, χ = -1 holds all lateral motion (odd circumferential orders),
k = 4, χ = +1 the centrifugal field (order 0, and multiples of 4). Only the unknowns of one sector
remain, and what belongs to other orders costs nothing. The mesh that is worked on may be the
sector itself (`sector_mesh`); then only its cut faces are tied to each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from mpi4py import MPI

from solidwhirl.meshing import Mesh
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.solvers.halo_exchange import numbers_at_places
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray

# Nodes are on a cut face or turned into each other up to this part of the size of the mesh.
_NEAR = 1e-9
# Nodes that are missing are looked for as far as this part of it.
_OFF = 1e-6


@dataclass(frozen=True, kw_only=True)
class Symmetry:
    """u(R x) = character · R u(x), R a turn of 360°/turns about z."""

    turns: int  #: 1 (no symmetry), 2 or 4: the turns whose matrices are signed permutations
    character: int  #: +1 or -1

    def power(self, m: int) -> FloatArray:
        """(χ R)^m as a (3, 3) matrix of 0, 1 and -1."""
        turn = {
            1: np.eye(3),
            2: np.diag([-1.0, -1.0, 1.0]),
            4: np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        }[self.turns]
        return np.asarray(np.linalg.matrix_power(self.character * turn, m))


NONE = Symmetry(turns=1, character=1)
LATERAL = Symmetry(turns=2, character=-1)
AXISYMMETRIC = Symmetry(turns=4, character=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class SymmetricUnknowns:
    """How the local unknowns follow from those of one sector."""

    source: IntArray  #: (n local unknowns,) global unknown that each follows, -1: zero by symmetry
    sign: FloatArray  #: (n,) its factor
    kept: BoolArray  #: (n,) whether it is one of the sector's own unknowns


def symmetric_unknowns(space: Any, symmetry: Symmetry) -> SymmetricUnknowns:
    """Relate the unknowns of a vector space of three components to those of one sector.

    Raises ReductionError: the mesh does not have the symmetry.
    """
    nodes, comm = space.dofmap.index_map, space.mesh.comm
    first, count = nodes.local_range[0], nodes.size_local
    if symmetry.turns == 1:
        own = 3 * first + np.arange(3 * count, dtype=np.int64)
        return SymmetricUnknowns(
            source=own, sign=np.ones(len(own)), kept=np.ones(len(own), dtype=bool)
        )
    x = space.tabulate_dof_coordinates()[:count]
    scale = comm.allreduce(float(np.abs(x).max(initial=0.0)), op=MPI.MAX)
    on_axis = np.hypot(x[:, 0], x[:, 1]) <= _NEAR * scale
    steps, home = _sent_home(x, symmetry.turns, _NEAR * scale)
    representative = np.arange(count) + first
    away = steps > 0
    representative[away] = _owners(home, away, first, symmetry.turns, scale, comm)
    source = np.empty((count, 3), dtype=np.int64)
    sign = np.empty((count, 3))
    for m in range(symmetry.turns):
        matrix = symmetry.power(m)
        rows = np.flatnonzero(steps == m)
        column = np.abs(matrix).argmax(axis=1)
        source[rows] = 3 * representative[rows, None] + column
        sign[rows] = matrix[np.arange(3), column]
    # on the axis only what the turn leaves alone can be
    fixed = np.diag(symmetry.power(1)) == 1.0
    source[np.ix_(on_axis, ~fixed)] = -1
    kept = ~away[:, None] & (source >= 0)
    return SymmetricUnknowns(source=source.ravel(), sign=sign.ravel(), kept=kept.ravel())


def _sent_home(x: FloatArray, turns: int, near: float) -> tuple[IntArray, FloatArray]:
    """Turns that lead from the first sector, 0 <= θ < 360°/turns, to every node; the place there.

    Nodes on the axis stay where they are.
    """
    steps = np.zeros(len(x), dtype=np.int64)
    home = x.copy()
    off = np.hypot(x[:, 0], x[:, 1]) > near
    for _ in range(turns - 1):
        a, b = home[:, 0], home[:, 1]
        if turns == 2:
            inside = (b > near) | ((np.abs(b) <= near) & (a > 0.0))
            turned = np.column_stack([-a, -b, home[:, 2]])
        else:
            inside = (a > near) & (b > -near)
            turned = np.column_stack([b, -a, home[:, 2]])
        outside = off & ~inside
        home[outside] = turned[outside]
        steps[outside] += 1
    return steps, home


def _owners(
    home: FloatArray, away: BoolArray, first: int, turns: int, scale: float, comm: Any
) -> IntArray:
    """Global node of the first sector at the home of every node away from it."""
    stay = np.flatnonzero(~away)
    # on a sector only nodes of the first cut face are looked for
    wanted = comm.allreduce(float(home[away, 1].max(initial=0.0)), op=MPI.MAX)
    stay = stay[home[stay, 1] <= wanted + _NEAR * scale]
    # as far as the message can tell how far a node is off
    near = _OFF * scale
    owner, gap = numbers_at_places(home[stay], stay + first, home[away], near, comm)
    largest = comm.allreduce(float(gap.max(initial=0.0)), op=MPI.MAX)
    if largest > _NEAR * scale:
        raise ReductionError(
            f"the mesh is not unchanged by a turn of {360 // turns}°: a node is off by "
            f"{min(largest, scale):.3g} m"
        )
    return owner


def sector_mesh(mesh: Mesh, turns: int) -> Mesh:
    """Return the cells of a solid mesh at 0 <= θ <= 180°, of which turned copies make the rest.

    `mesh`: of the whole solid, unchanged by a half turn. `turns`: copies that make the whole; 1
    returns the mesh, 2 its half. Raises ReductionError: half of the cells do not make half of the
    mesh.
    """
    if turns == 1:
        return mesh
    centre = mesh.points[mesh.cells[:, :4], 1].mean(axis=1)
    inside = centre > 0.0
    cells = mesh.cells[inside]
    used = np.zeros(len(mesh.points), dtype=bool)
    used[cells] = True
    scale = np.abs(mesh.points).max()
    if 2 * len(cells) != len(mesh.cells) or mesh.points[used, 1].min() < -_NEAR * scale:
        raise ReductionError("the mesh is not cut in halves by the plane y = 0")
    number = np.cumsum(used) - 1
    return replace(
        mesh,
        points=mesh.points[used],
        cells=number[cells],
        cell_material=mesh.cell_material[inside],
        cell_section=mesh.cell_section[inside],
        interfaces={
            name: number[facets[mesh.points[facets[:, :3], 1].mean(axis=1) > 0.0]]
            for name, facets in mesh.interfaces.items()
        },
        outline=number[mesh.outline[used[mesh.outline]]],
    )


def whole_node_count(space: Any, turns: int) -> int:
    """Nodes of the whole body when the mesh of a space is a sector of it."""
    nodes, comm = space.dofmap.index_map, space.mesh.comm
    if turns == 1:
        return int(nodes.size_global)
    x = space.tabulate_dof_coordinates()[: nodes.size_local]
    scale = comm.allreduce(float(np.abs(x).max(initial=0.0)), op=MPI.MAX)
    steps, _ = _sent_home(x, turns, _NEAR * scale)
    axis = np.hypot(x[:, 0], x[:, 1]) <= _NEAR * scale
    own = turns * int(np.sum((steps == 0) & ~axis)) + int(np.sum(axis))
    return int(comm.allreduce(own))
