"""Fields of one cyclic index on a sector of a body.

A body of N equal sectors of the angle α = 2π/N has its motions in fields u = Re[c Φ] with

    Φ(R x) = R e^{ihα} Φ(x),   R the turn by α about the axis,   h = 0, 1, ..., N/2

and Φ = Φ1 + iΦ2 needs to be known on one sector only (Thomas, Int. J. Numer. Methods Eng. 14 (1979)
81-102). Where the sector has a mirror plane, half of it is enough, and the amplitudes are real: Φ1
is then symmetric in that plane, Φ2 antisymmetric, and on the other cut face e^{-ihα/2} Φ is so. For
h = 0 and h = N/2 the fields are real: u = Φ1 + Φ2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from solidwhirl.meshing import Sector
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.solvers.halo_exchange import numbers_at_places, values_of_owners
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray

#: Fields (f, 3) of the unknowns of a node.
Fields = FloatArray | ComplexArray

# Nodes are on a cut face, on the axis, or turned into each other up to this part of the size.
_NEAR = 1e-9


@dataclass(frozen=True, kw_only=True)
class CyclicIndex:
    """One cyclic index of a sector."""

    sector: Sector
    index: int  #: h, from 0 to N/2
    #: Whether of half a sector only fields that are symmetric in the mirror plane are wanted, as
    #: that of the centrifugal load
    symmetric: bool = False

    @property
    def is_real(self) -> bool:
        """Whether the field of the whole body is the same as its conjugate: h = 0 and h = N/2."""
        return 2 * self.index % self.sector.count == 0

    @property
    def has_complex_amplitudes(self) -> bool:
        """Whether unknowns are complex: neither a mirror plane nor a real field."""
        return not (self.sector.mirrored or self.is_real)

    @property
    def has_two_parts(self) -> bool:
        """Whether Φ2 is needed beside Φ1."""
        return not self.is_real or (self.sector.mirrored and not self.symmetric)

    @property
    def weight(self) -> float:
        """Factor of an integral over the mesh that makes it one of the whole, per real amplitude.

        A real amplitude of a complex field has its square averaged around the circumference.
        """
        return self.mesh_copies * (1.0 if self.is_real else 0.5)

    @property
    def mesh_copies(self) -> int:
        """Turned and mirrored copies of the mesh in the whole."""
        return self.sector.count * (2 if self.sector.mirrored else 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class CyclicUnknowns:
    """How a field follows from the free unknowns û of this rank: Φ = Σ p û, one entry for each p.

    Rows are 3 node + component, of this rank.
    """

    rows: IntArray
    columns: IntArray  #: Numbers of unknowns, over all ranks
    factors: ComplexArray
    #: Of every unknown of this rank, the sum of |p|² over all rows that it moves
    norms: FloatArray


def cyclic_unknowns(
    space: Any, cyclics: Sequence[CyclicIndex], parts: IntArray, tied: BoolArray
) -> CyclicUnknowns:
    """Relate the nodes of a vector space on sector meshes to its free unknowns.

    `cyclics`: index of every part of the mesh. `parts`: part of every node of this rank. `tied`:
    nodes of this rank that follow something else, and have no unknowns. Raises ReductionError: a
    mesh is not the sector that it is said to be.
    """
    x, comm = _places(space), space.mesh.comm
    near = _NEAR * _size(x, comm)
    kinds: list[tuple[BoolArray, Fields]] = []
    led: list[tuple[IntArray, IntArray, Fields]] = []
    for k, cyclic in enumerate(cyclics):
        own = parts == k
        if cyclic.sector.mirrored:
            kinds += _half_conditions(x, cyclic, own, near, comm)
        else:
            first = space.dofmap.index_map.local_range[0]
            found, follows = _whole_conditions(x, cyclic, own, (near, first), comm)
            kinds += found
            led.append(follows)
    counts = np.zeros(len(x), dtype=np.int64)
    for nodes, fields in kinds:
        counts[nodes & ~tied] = len(fields)
    total = int(counts.sum())
    first = np.concatenate([[0], np.cumsum(counts)])[:-1] + _start(total, comm)
    entries = [_entries(np.flatnonzero(nodes & ~tied), first, fields) for nodes, fields in kinds]
    norms = np.ones(total)
    numbers = np.arange(len(x)) + space.dofmap.index_map.local_range[0]
    for followers, partner, fields in led:
        free = ~tied[followers]
        follower, leader = followers[free], partner[free]
        asked = numbers.copy()
        asked[follower] = leader
        entries.append(_entries(follower, values_of_owners(first, asked, comm), fields))
        leads = np.isin(numbers, np.concatenate(comm.allgather(leader)))
        norms[_unknowns_of(first - _start(total, comm), counts, leads)] = 2.0
    rows, columns, factors = (np.concatenate(part) for part in zip(*entries, strict=True))
    return CyclicUnknowns(rows=rows, columns=columns, factors=factors, norms=norms)


def _places(space: Any) -> FloatArray:
    return np.asarray(space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local])


def _size(x: FloatArray, comm: Any) -> float:
    return float(comm.allreduce(float(np.abs(x).max(initial=0.0)), op=MPI.MAX))


def _on_axis(index: int) -> Fields:
    """Fields that a point on the axis can have, (fields, 3)."""
    if index == 0:
        return np.array([[0.0, 0.0, 1.0]])
    return np.array([[1.0, 1.0j, 0.0]]) / np.sqrt(2.0) if index == 1 else np.empty((0, 3))


def _half_conditions(
    x: FloatArray, cyclic: CyclicIndex, own: BoolArray, near: float, comm: Any
) -> list[tuple[BoolArray, Fields]]:
    """Nodes of the half sector 0 <= θ <= π/N and their fields: real amplitudes, both cut faces."""
    half = np.pi / cyclic.sector.count
    # distance from the second face, along its normal
    beyond = x[:, 1] * np.cos(half) - x[:, 0] * np.sin(half)
    if comm.allreduce(int((own & ((x[:, 1] < -near) | (beyond > near))).sum())):
        raise ReductionError(
            f"the mesh is not half a sector of {cyclic.sector.count}: nodes lie outside of it"
        )
    axis = own & (np.hypot(x[:, 0], x[:, 1]) <= near)
    lower = own & ~axis & (np.abs(x[:, 1]) <= near)
    upper = own & ~axis & ~lower & (np.abs(beyond) <= near)
    inside = own & ~axis & ~lower & ~upper
    kinds: list[tuple[BoolArray, Fields]] = [
        (inside, np.vstack([np.eye(3), 1j * np.eye(3)])),
        (axis, _on_axis(cyclic.index)),
    ]
    for face, angle in ((lower, 0.0), (upper, half)):
        c, s = np.cos(angle), np.sin(angle)
        fields = np.array([[c, s, 0.0], [1j * s, -1j * c, 0.0], [0.0, 0.0, 1.0]])
        kinds.append((face, np.exp(1j * cyclic.index * angle) * fields))
    if cyclic.symmetric:
        return [(nodes, fields[~fields.imag.any(axis=1)]) for nodes, fields in kinds]
    return kinds


def _whole_conditions(
    x: FloatArray, cyclic: CyclicIndex, own: BoolArray, near_first: tuple[float, int], comm: Any
) -> tuple[list[tuple[BoolArray, Fields]], tuple[IntArray, IntArray, Fields]]:
    """Nodes of a whole sector and their fields; those of the second cut face follow the first's.

    Of these: nodes of this rank, numbers of those that they follow, and what these make of them.
    """
    near, first = near_first
    alpha = 2.0 * np.pi / cyclic.sector.count
    c, s = np.cos(alpha), np.sin(alpha)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    nodes = np.flatnonzero(own)
    # where the node would be that each one follows
    partner, gap = numbers_at_places(x[nodes], nodes + first, x[nodes] @ turn, near, comm)
    axis = np.hypot(x[:, 0], x[:, 1]) <= near
    follows = (gap <= near) & ~axis[nodes]
    if not comm.allreduce(int(follows.sum())):
        raise ReductionError(
            f"the mesh is no sector of {cyclic.sector.count}: no node turned by "
            f"{360.0 / cyclic.sector.count:.6g}° is another one"
        )
    free = own & ~axis
    free[nodes[follows]] = False
    kinds: list[tuple[BoolArray, Fields]] = [
        (own & axis, _on_axis(cyclic.index)), (free, np.eye(3))
    ]  # fmt: skip
    # columns of the turn are the answers to the components of the leading node
    fields = np.exp(1j * cyclic.index * alpha) * turn.T
    return kinds, (nodes[follows], partner[follows], fields)


def _start(own: int, comm: Any) -> int:
    """Number of unknowns of the ranks before this one."""
    return int(comm.scan(own)) - own


def _entries(
    nodes: IntArray, first: IntArray, fields: Fields
) -> tuple[IntArray, IntArray, ComplexArray]:
    """Rows, columns and factors of nodes whose unknowns move them as some fields (f, 3)."""
    unknown, component = np.nonzero(fields)
    rows = 3 * nodes[:, None] + component
    columns = first[nodes][:, None] + unknown
    factors = np.broadcast_to(fields[unknown, component].astype(complex), rows.shape)
    return rows.ravel(), columns.ravel(), factors.ravel()


def _unknowns_of(first: IntArray, counts: IntArray, chosen: BoolArray) -> IntArray:
    """Unknowns of chosen nodes."""
    return np.concatenate(
        [first[chosen & (counts > k)] + k for k in range(3)] or [np.empty(0, dtype=np.int64)]
    )
