"""Conjugate gradients for what the next element order adds to a solid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse
from petsc4py import PETSc
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from solidwhirl.meshing.own.refinement import first_at_place
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.solvers.multigrid import ConstrainedIteration, constrained_iteration
from solidwhirl.reduction.solvers.vectors import apply, paired, unpaired
from solidwhirl.rotordyn.core.arrays import IntArray, Matrix

# Nodes are in the plane θ = 0 up to this part of the size.
_NEAR = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class LineBlocks:
    """Preconditioner that solves for the unknowns of every line around the axis together.

    Elements of a revolved sector are slender: around the axis they are as wide as the sector,
    whatever their size on the meridian. What couples along the axis' circles is therefore solved,
    and the rest is as with the diagonal alone: it makes short work of errors that are orthogonal to
    a coarser space, and of no others.
    """

    inverse: Any  #: scipy matrix of this rank's unknowns, complex ones paired
    comm: Any

    @property
    def memory_bytes(self) -> int:
        """Memory on all ranks."""
        return int(self.comm.allreduce(self.inverse.data.nbytes + self.inverse.indices.nbytes))

    def cycle(self, load: Matrix) -> Matrix:
        """Approximate solution for a block of loads (local, k)."""
        out = self.inverse @ paired(load)
        return unpaired(out) if np.iscomplexobj(load) else np.asarray(out)

    def destroy(self) -> None:
        """Nothing is another's."""


def relaxation(finer: BodyOperators, free: Matrix, comm: Any) -> ConstrainedIteration:
    """Prepare conjugate gradients for the surplus of a finer space of a solid.

    `free`: (local û, f) rigid motions that the interfaces leave free. The surplus is orthogonal to
    the space that has been solved in, so that its rate depends neither on the size of the elements
    nor, with lines, on their slenderness.
    """
    return constrained_iteration(
        LineBlocks(inverse=_inverse(finer), comm=comm),
        finer.stiffness,
        finer.coupling.held,
        free=free[:, :0],
        momentum=apply(finer.mass, free),
        owns_matrix=False,
    )


def _inverse(finer: BodyOperators) -> Any:
    """Inverse of the stiffness of the lines, and of its diagonal beside them."""
    unknowns = finer.coupling.unknowns
    width = 2 if unknowns.is_complex else 1
    nodes = finer.space.dofmap.index_map.size_local
    # a whole mesh has no lines
    line = np.arange(nodes) if finer.rotating else _lines(finer.space)
    lines = unknowns.folded(_within(finer.stiffness.matrix, np.repeat(line, 3)))
    indptr, columns, values = lines.getValuesCSR()
    start, end = lines.getOwnershipRange()
    rows = np.repeat(np.arange(end - start), np.diff(indptr))
    own = width * len(unknowns.norms)  # joints and masters come after them
    kept = (rows < own) & (columns >= start) & (columns < start + own)
    rows, columns, values = rows[kept], columns[kept] - start, values[kept]
    lines.destroy()
    beside = np.arange(own, end - start)
    rest = np.repeat(finer.stiffness.diagonal(), width)[own:]
    entries = np.concatenate([values, rest])
    where = (np.concatenate([rows, beside]), np.concatenate([columns, beside]))
    matrix = scipy.sparse.csr_matrix((entries, where), shape=(end - start, end - start))
    unmoved = matrix.diagonal() <= 0.0
    return block_inverse(matrix + scipy.sparse.diags(unmoved.astype(float)))


def _lines(space: Any) -> IntArray:
    """Line around the axis that each node of this rank is on.

    Nodes of a revolved meridian are `degree` + 1 above each of those in the plane θ = 0; where more
    are nearest to one, as in tetrahedra of a mesher, each is for itself. Both sides of a joint are
    on one line, which its springs, however stiff, are then solved in.
    """
    x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    alone = len(x) + np.arange(len(x))
    flat = np.flatnonzero(np.abs(x[:, 1]) <= _NEAR * np.abs(x).max(initial=1e-300))
    if not len(flat):
        return alone
    z_r = np.column_stack([x[:, 2], np.hypot(x[:, 0], x[:, 1])])
    first = first_at_place(z_r[flat])
    nearest = first[cKDTree(z_r[flat]).query(z_r)[1]]
    most = (compat.polynomial_degree(space) + 1) * np.bincount(first, minlength=len(flat))[nearest]
    return np.where(np.bincount(nearest, minlength=len(flat))[nearest] <= most, nearest, alone)


def _within(matrix: Any, line: IntArray) -> Any:
    """Entries of a PETSc matrix whose row and column are on one line."""
    indptr, columns, values = matrix.getValuesCSR()
    start = matrix.getOwnershipRange()[0]
    rows = np.repeat(np.arange(len(line)), np.diff(indptr))
    local = columns - start
    own = (local >= 0) & (local < len(line))
    own[own] = line[local[own]] == line[rows[own]]
    counts = np.bincount(rows[own], minlength=len(line))
    indptr = np.concatenate([[0], np.cumsum(counts)]).astype(PETSc.IntType)
    csr = (indptr, columns[own], values[own])
    out = PETSc.Mat().createAIJ(size=matrix.getSizes(), csr=csr, comm=matrix.comm)
    out.assemble()
    return out


def block_inverse(matrix: Any) -> Any:
    """Inverse of a block diagonal matrix, (n, n) scipy."""
    count, block = connected_components(matrix, directed=False)
    order = np.argsort(block, kind="stable")
    sizes = np.bincount(block, minlength=count)
    starts = np.cumsum(sizes) - sizes
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order)) - np.repeat(starts, sizes)
    entries = matrix.tocoo()
    rows, columns, values = [], [], []
    for size in np.unique(sizes):
        same = np.flatnonzero(sizes == size)
        number = np.full(count, -1)
        number[same] = np.arange(len(same))
        mine = number[block[entries.row]] >= 0
        r, c = entries.row[mine], entries.col[mine]
        dense = np.zeros((len(same), size, size))
        dense[number[block[r]], place[r], place[c]] = entries.data[mine]
        where = order[starts[same][:, None] + np.arange(size)]
        rows.append(np.repeat(where, size, axis=1).ravel())
        columns.append(np.tile(where, (1, size)).ravel())
        values.append(np.linalg.inv(dense).ravel())
    data, row, column = (np.concatenate(part) for part in (values, rows, columns))
    return scipy.sparse.csr_matrix((data, (row, column)), shape=matrix.shape)
