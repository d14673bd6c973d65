"""The unknowns that are left when surfaces are rigid and the field has a symmetry."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

from solidwhirl.meshing.imported.records import AnyInterface
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.kinematics import COMPONENTS, Kinematics
from solidwhirl.reduction.operators.symmetry import symmetric_unknowns
from solidwhirl.reduction.solvers.halo_exchange import values_of_owners
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray


def node_of(interface: AnyInterface) -> float | FloatArray:
    """Place of an interface's master node: z on the axis, else (3,) [m]."""
    x, y, z = interface.position_m
    return float(z) if x == y == 0.0 else np.array([x, y, z], dtype=float)


def motion_vectors(space: Any, kin: Kinematics, z0: float | FloatArray) -> dict[str, FloatArray]:
    """Nodal values (local rows) of the rigid motions about (0, 0, z0) or a point, by component.

    Rigid motions are linear in the coordinates, so the second-order elements hold them exactly.
    """
    x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    return {c: motion(x, z0).ravel() for c, motion in kin.rigid_motions.items()}


def unknowns_transformation(
    space: Any, kin: Kinematics, facet_tags: dict[str, Any], rigid: list[AnyInterface]
) -> tuple[Any, IntArray]:
    """Map û of free unknowns and rigid masters to all unknowns u = T û.

    `kin`: kinematics; its symmetry leaves the unknowns of one sector. `rigid`: interfaces whose
    nodes follow a master. Returns transformation, kept: T as PETSc matrix (None if T is the
    identity) and the local unknowns that û holds, in order; the masters of all interfaces, each
    with the kinematics' motions, come last on the last rank. Raises ReductionError: two rigid
    interfaces share nodes, or the mesh lacks the symmetry.
    """
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    related = symmetric_unknowns(space, kin.symmetry)
    owner, follow = _rigid_followers(space, kin, facet_tags, rigid, motions)
    kept = np.flatnonzero(related.kept & (owner < 0))
    if not rigid and kin.symmetry.turns == 1:
        return None, kept
    comm, n_local = space.mesh.comm, len(owner)
    own, total = _own_columns(comm, n_local, kept)
    masters = len(rigid) * len(motions)
    free = np.flatnonzero((owner < 0) & (related.source >= 0))
    tied = np.flatnonzero(owner >= 0)
    counts = np.zeros(n_local, dtype=np.int64)
    counts[free], counts[tied] = 1, len(motions)
    indptr = np.concatenate([[0], np.cumsum(counts)])
    indices, data = np.empty(indptr[-1], dtype=np.int64), np.empty(indptr[-1])
    indices[indptr[free]] = values_of_owners(own, related.source[free], comm)
    data[indptr[free]] = related.sign[free]
    for i in tied:
        span = slice(indptr[i], indptr[i + 1])
        indices[span] = total + owner[i] * len(motions) + np.arange(len(motions))
        data[span] = follow[i]
    local_columns = len(kept) + (masters if comm.rank == comm.size - 1 else 0)
    rows = space.dofmap.index_map.size_global * space.dofmap.index_map_bs
    out = PETSc.Mat().createAIJ(
        size=((n_local, rows), (local_columns, total + masters)),
        csr=(indptr.astype(PETSc.IntType), indices.astype(PETSc.IntType), data),
        comm=comm,
    )
    out.assemble()
    return out, kept


def _own_columns(comm: Any, n_local: int, kept: IntArray) -> tuple[IntArray, int]:
    """Column in û of every unknown of this rank (-1: none), and how many there are on all."""
    start = comm.scan(len(kept)) - len(kept)
    own = np.full(n_local, -1, dtype=np.int64)
    own[kept] = start + np.arange(len(kept))
    return own, comm.allreduce(len(kept))


def _rigid_followers(
    space: Any,
    kin: Kinematics,
    facet_tags: dict[str, Any],
    rigid: list[AnyInterface],
    motions: list[str],
) -> tuple[IntArray, FloatArray]:
    """Interface that each local unknown follows (-1: none), and its factors of the motions."""
    index_map, bs = space.dofmap.index_map, space.dofmap.index_map_bs
    n_local = index_map.size_local * bs
    owner = np.full(n_local, -1, dtype=np.int64)
    follow = np.zeros((n_local, len(motions)))
    for k, interface in enumerate(rigid):
        tags = facet_tags[interface.name]
        blocks = fem.locate_dofs_topological(space, tags.dim, tags.indices)
        blocks = blocks[blocks < index_map.size_local]
        unknowns = (blocks[:, None] * bs + np.arange(bs)).ravel()
        if space.mesh.comm.allreduce(int(np.sum(owner[unknowns] >= 0))):
            raise ReductionError(f"rigid interface {interface.name!r} shares nodes with another")
        values = motion_vectors(space, kin, node_of(interface))
        owner[unknowns] = k
        if motions:
            follow[unknowns] = np.column_stack([values[c] for c in motions])[unknowns]
    return owner, follow
