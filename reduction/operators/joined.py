"""Parts of one body with sectors of different counts, joined by their field of one order.

A drum and its stages of different blade counts have no common sector. Each part has its own cyclic
conditions; where stage and drum meet, along edges of the meridian, both follow the field

    Φ = Σ_j φ_j(s) (a_j e_r - i b_j e_θ + c_j e_z) e^{inθ}

with the shape functions φ_j of the edges. For n = h, the cyclic index of the whole, it belongs to
every count. What is left out are the orders h + N, h - N, ... of a stage with N sectors, which
always soften; a further copy of the drum for each of them takes them in.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from dolfinx import fem

from solidwhirl.meshing import Mesh, Sector
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray, Matrix

# Ends of edges are one place up to this part of the size of the mesh.
_NEAR = 1e-7
# Nodes of a joint may be off it by so much: elements that were folded have straight edges.
_OFF = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class JoinedParts:
    """Parts of the mesh of one body that meet at joints."""

    sectors: tuple[Sector, ...]  #: By part
    #: By part, of the drum and its copies: what is added to the cyclic index; None: a stage
    shifts: tuple[int | None, ...]
    cell_part: IntArray  #: Part of every cell of this rank, those of neighbours included
    facets: Any  #: Tags of the facets of all parts on joints
    edges_m: FloatArray  #: (e, 2, 2) ends (z, r) of the edges of the joints
    #: What is added to the cyclic index in the fields that parts meet by; the first is 0. Copies of
    #: the drum with other shifts do not move.
    orders: tuple[int, ...] = (0,)

    def every_order(self) -> JoinedParts:
        """The parts with all copies of the drum in motion."""
        return replace(self, orders=tuple(dict.fromkeys(s for s in self.shifts if s is not None)))

    def still(self, parts: IntArray) -> BoolArray:
        """Which nodes belong to copies of the drum that do not move, from their parts."""
        at_rest = [s is not None and s not in self.orders for s in self.shifts]
        return np.asarray(at_rest)[parts]

    def node_parts(self, space: Any) -> IntArray:
        """Part of every node of this rank."""
        cells = compat.cell_unknowns(space).reshape(len(self.cell_part), -1)
        out = np.zeros(int(cells.max()) + 1, dtype=np.int64)
        out[cells] = self.cell_part[:, None]
        return out[: space.dofmap.index_map.size_local]

    def copied(self, space: Any) -> BoolArray:
        """Which nodes of this rank belong to copies of the drum."""
        return np.asarray([bool(s) for s in self.shifts])[self.node_parts(space)]

    def joint_nodes(self, space: Any) -> BoolArray:
        """Which nodes of this rank lie on a joint."""
        count = space.dofmap.index_map.size_local
        out = np.zeros(count, dtype=bool)
        nodes = fem.locate_dofs_topological(space, self.facets.dim, self.facets.indices)
        out[nodes[nodes < count]] = True
        return out


_JOINT = "joint between parts"


def distributed(
    mesh: Mesh | None, dimension: int, materials: int, comm: Any
) -> tuple[Any, Any, dict[str, Any], JoinedParts | None]:
    """Distribute a mesh that may have parts: domain, material tags, facet tags, parts.

    `mesh`: on rank 0 only. `materials`: how many it has.
    """
    about = None
    if mesh is not None and mesh.parts is not None:
        parts = mesh.parts
        about = (parts.sectors, parts.shifts, parts.joint_edges_m)
        # the part of a cell travels with its material
        mesh = replace(
            mesh,
            cell_material=mesh.cell_material + materials * parts.cell_part,
            interfaces={**mesh.interfaces, _JOINT: parts.joint_facets},
        )
    about = comm.bcast(about, root=0)
    domain, tags, facets = compat.distribute(mesh, dimension, comm)
    if about is None:
        return domain, tags, facets, None
    count = domain.topology.index_map(3)
    cell_part = np.zeros(count.size_local + count.num_ghosts, dtype=np.int64)
    cell_part[tags.indices] = tags.values // materials
    joined = JoinedParts(
        sectors=about[0], shifts=about[1], cell_part=cell_part, facets=facets.pop(_JOINT),
        edges_m=about[2],
    )  # fmt: skip
    return domain, compat.retagged(tags, tags.values % materials), facets, joined


@dataclass(frozen=True, kw_only=True, eq=False)
class JointField:
    """Amplitudes (a, b, c) at places of the joints' edges, and what they are elsewhere on them."""

    places_m: FloatArray  #: (k, 2) places (z, r)
    edges_m: FloatArray  #: (e, 2, 2)
    number: IntArray  #: (e, p + 1) places along every edge
    #: Fields (3, 3) along r, θ, z of a unit of a, b and c at θ = 0
    directions: ComplexArray

    @property
    def count(self) -> int:
        """Amplitudes, three of each place."""
        return 3 * len(self.places_m)

    def weights(self, meridian: FloatArray) -> tuple[IntArray, FloatArray]:
        """Places (m, p + 1) and shape functions there of points (z, r) on the edges.

        Raises ReductionError: a point is on none.
        """
        a, b = self.edges_m[:, 0], self.edges_m[:, 1]
        along = b - a
        t = np.einsum("mei,ei->me", meridian[:, None] - a, along) / np.sum(along**2, axis=1)
        t = np.clip(t, 0.0, 1.0)
        off = np.linalg.norm(meridian[:, None] - a - t[..., None] * along, axis=2)
        edge = off.argmin(axis=1)
        row = np.arange(len(meridian))
        if len(off) and off[row, edge].max() > _OFF * np.abs(self.edges_m).max():
            raise ReductionError("parts of a body do not meet: a node of a joint is off its edges")
        return self.number[edge], _lagrange(t[row, edge], self.number.shape[1] - 1)

    def of_motion(self, motion: Any) -> Matrix:
        """Amplitudes of a rigid motion, values (m, 3) from places (m, 3)."""
        z, r = self.places_m.T
        values = motion(np.column_stack([r, np.zeros(len(r)), z]), 0.0)
        # directions are unit vectors, each of another component
        return np.asarray(np.einsum("kj,ij->ki", values, self.directions.conj()).ravel())

    def raised(self, coarse: JointField, amplitudes: Matrix) -> Matrix:
        """Amplitudes (count, n) of the field that a coarser one has, (coarse count, n)."""
        place, weight = coarse.weights(self.places_m)
        nodal = amplitudes.reshape(len(coarse.places_m), 3, -1)
        out = np.einsum("mp,mpcn->mcn", weight, nodal[place])
        return np.asarray(out.reshape(self.count, -1))


def joint_field(joined: JoinedParts, degree: int, *, is_real: bool) -> JointField:
    """Return the field of joints with elements of a degree.

    `is_real`: whether amplitudes are those of a real field on whole sectors.
    """
    share = np.linspace(0.0, 1.0, degree + 1)[:, None]
    ends: Any = joined.edges_m
    places = ends[:, :1] * (1.0 - share) + ends[:, 1:] * share
    size = np.abs(joined.edges_m).max()
    rounded = np.round(places.reshape(-1, 2) / (_NEAR * size))
    _, first, number = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return JointField(
        places_m=np.asarray(places.reshape(-1, 2)[first], dtype=float),
        edges_m=joined.edges_m,
        number=np.asarray(number).reshape(len(joined.edges_m), degree + 1),
        directions=np.diag([1.0, 1.0 if is_real else -1j, 1.0]),
    )


def joint_entries(
    space: Any, joined: JoinedParts, field: JointField, index: int
) -> tuple[IntArray, IntArray, ComplexArray, int]:
    """Rows, columns and factors of the nodes on joints, and the number of columns.

    Columns are the amplitudes of order 0, then those of the other orders that any part has, as a
    copy need not be of the whole drum. `index`: cyclic index of the whole.
    """
    x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    on_joint, parts = joined.joint_nodes(space), joined.node_parts(space)
    rows, columns, factors = [], [], []
    for k, shift in enumerate(joined.orders):
        follows = np.array([_follows(joined, p, shift) for p in range(len(joined.shifts))])
        nodes = np.flatnonzero(on_joint & follows[parts])
        theta = np.arctan2(x[nodes, 1], x[nodes, 0])
        radius = np.hypot(x[nodes, 0], x[nodes, 1])
        place, weight = field.weights(np.column_stack([x[nodes, 2], radius]))
        c, s = np.cos(theta), np.sin(theta)
        zero = np.zeros_like(c)
        frame = np.stack([np.stack([c, s, zero], 1), np.stack([-s, c, zero], 1),
                          np.stack([zero, zero, zero + 1.0], 1)], axis=1)  # fmt: skip
        # (nodes, amplitude, component)
        unit = np.einsum("ij,njc->nic", field.directions, frame)
        unit = unit * np.exp(1j * (index + shift) * theta)[:, None, None]
        value = weight[:, :, None, None] * unit[:, None]
        shape = value.shape
        rows.append(np.broadcast_to(3 * nodes[:, None, None, None] + np.arange(3), shape).ravel())
        column = 3 * place[:, :, None, None] + np.arange(3)[:, None] + k * field.count
        columns.append(np.broadcast_to(column, shape).ravel())
        factors.append(value.ravel())
    row, column, factor = (np.concatenate(part) for part in (rows, columns, factors))
    had = np.zeros(len(joined.orders) * field.count, dtype=np.int64)
    had[: field.count] = 1
    # an end of an edge has rounding of its other places, where no part may be
    had[column[np.abs(factor) > _NEAR]] = 1
    had = space.mesh.comm.allreduce(had) > 0
    there = had[column]
    row, column, factor = row[there], column[there], factor[there]
    return row, (np.cumsum(had) - 1)[column], factor, int(np.sum(had))


def _follows(joined: JoinedParts, part: int, shift: int) -> bool:
    """Whether a part has a field whose order is shifted so."""
    own = joined.shifts[part]
    return shift % joined.sectors[part].count == 0 if own is None else own == shift


def _lagrange(t: FloatArray, degree: int) -> FloatArray:
    """Lagrange polynomials of evenly spaced nodes on (0, 1), (m, degree + 1)."""
    nodes = np.linspace(0.0, 1.0, degree + 1)
    out = np.ones((len(t), degree + 1))
    for j in range(degree + 1):
        for k in range(degree + 1):
            if k != j:
                out[:, j] *= (t - nodes[k]) / (nodes[j] - nodes[k])
    return out
