"""Multigrid hierarchy of an elastic stiffness: PETSc's GAMG makes it, blocks of vectors go through.

Smoothed aggregation with the six rigid motions as near-null space (Vaněk, Mandel and Brezina,
Computing 56 (1996) 179-196). GAMG's levels are taken out and cycled here for many right-hand sides
at once: a matrix is read from memory once for all of them, which one vector at a time can not have.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from solidwhirl.reduction.solvers.halo_exchange import values_of_owners
from solidwhirl.reduction.solvers.vectors import apply, dense_matrix, inner
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray

# Part of its diagonal that is added to the stiffness, so that rigid motions have some.
_LIFT = 1e-6
# Unknowns that are solved for directly; steps of the smoother before and after, the part of the
# spectrum it damps, and how far the power iteration may be below the largest eigenvalue.
_COARSEST = 1000
_STEPS = 2
_LOWEST_PART = 0.1
_SAFETY = 1.1
_POWER_STEPS = 12
# Coarse unknowns with a smaller part of the largest stiffness have none.
_NOTHING = 1e-12
_OPTIONS = {
    "pc_gamg_type": "agg",
    "pc_gamg_agg_nsmooths": 1,
    "pc_gamg_threshold": 0.05,
    "pc_gamg_coarse_eq_limit": _COARSEST,
    "mg_levels_ksp_type": "chebyshev",
    "mg_levels_pc_type": "jacobi",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class BlockPlaces:
    """Where unknowns stand in blocks of three: a node, the displacement or turn of a master."""

    place: IntArray  #: (local,) rising; 3 times the block plus the component
    blocks: int
    #: (local, 6) rigid motions of the body in the unknowns, whatever its symmetry
    rigid: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Level:
    """One level: its matrix, 1 / diagonal, largest eigenvalue of their product, way from below."""

    matrix: Any
    inverse_diagonal: FloatArray
    largest: float
    prolongation: Any

    def smoothed(self, load: FloatArray, start: FloatArray | None) -> FloatArray:
        """Chebyshev steps, from zero or from a start (Adams et al., J. Comp. Phys. 188 (2003))."""
        high = _SAFETY * self.largest
        low = _LOWEST_PART * high
        middle, half = 0.5 * (high + low), 0.5 * (high - low)
        scale = self.inverse_diagonal[:, None]
        left = load if start is None else load - apply(self.matrix, start)
        step = scale * left / middle
        out = step if start is None else start + step
        rho = half / middle
        for _ in range(_STEPS - 1):
            left = left - apply(self.matrix, step)
            after = 1.0 / (2.0 * middle / half - rho)
            step = (after * rho) * step + (2.0 * after / half) * (scale * left)
            rho = after
            out = out + step
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class Hierarchy:
    """A symmetric positive V-cycle for a stiffness."""

    finest: Any  #: The stiffness, which is another's
    levels: tuple[Level, ...]  #: From the finest on, without the coarsest
    coarsest: FloatArray  #: Inverse of the coarsest matrix, this rank's rows
    comm: Any

    def cycle(self, load: FloatArray, level: int = 0) -> FloatArray:
        """Approximate solution for a block of loads (local, k)."""
        if level == len(self.levels):
            return np.asarray(self.coarsest @ np.vstack(self.comm.allgather(load)))
        here = self.levels[level]
        out = here.smoothed(load, None)
        left = load - apply(here.matrix, out)
        coarse = self.cycle(_restricted(here.prolongation, left), level + 1)
        return here.smoothed(load, out + apply(here.prolongation, coarse))

    @property
    def memory_bytes(self) -> int:
        """Memory of all matrices but the finest, on all ranks."""
        stored = [level.prolongation for level in self.levels]
        stored += [level.matrix for level in self.levels[1:]]
        where = PETSc.Mat.InfoType.GLOBAL_SUM
        entries = sum(int(matrix.getInfo(where)["nz_used"]) for matrix in stored)
        return 12 * entries + 8 * self.coarsest.shape[1] ** 2

    def destroy(self) -> None:
        """Free all matrices but the finest, which is another's."""
        for k, level in enumerate(self.levels):
            level.prolongation.destroy()
            if k:
                level.matrix.destroy()


def hierarchy_of(matrix: Any, places: BlockPlaces) -> Hierarchy:
    """Make the hierarchy of a stiffness.

    `matrix`: (N, N) PETSc AIJ, symmetric, semidefinite; it stays in use as the finest level.
    """
    comm = matrix.comm.tompi4py()
    lifted = _lifted_blocks(matrix, places)
    pc = _gamg(lifted, _near_null_space(lifted, places, comm))
    count = pc.getMGLevels()
    made = [pc.getMGInterpolation(k) for k in range(count - 1, 0, -1)]
    matrices = [pc.getMGSmoother(k).getOperators()[0] for k in range(count - 2, 0, -1)]
    coarse = pc.getMGCoarseSolve().getOperators()[0]
    levels = []
    for k, prolongation in enumerate(made):
        own = matrix if k == 0 else matrices[k - 1]
        down = _rows_of(prolongation, places.place) if k == 0 else prolongation
        levels.append(_level(own, down, comm))
    rows = np.vstack(comm.allgather(_dense_rows(coarse)))
    first, end = coarse.getOwnershipRange()
    if not made:
        # the stiffness itself is small; its blocks' own numbering has to be left again
        rows = np.vstack(comm.allgather(_dense_rows(matrix)))
        rows[np.diag_indices(len(rows))] *= 1.0 + _LIFT
        first, end = matrix.getOwnershipRange()
    out = Hierarchy(
        finest=matrix, levels=tuple(levels), coarsest=_inverse(rows)[first:end], comm=comm
    )
    pc.destroy()
    lifted.destroy()
    return out


def _gamg(matrix: Any, near: Any) -> Any:
    """GAMG's preconditioner, of which only the levels are used."""
    matrix.setNearNullSpace(near)
    matrix.setOption(PETSc.Mat.Option.SPD, True)
    pc = PETSc.PC().create(matrix.comm)
    prefix = "solidwhirl_hierarchy_"
    options = PETSc.Options()
    for name, value in _OPTIONS.items():
        options[prefix + name] = value
    pc.setOptionsPrefix(prefix)
    pc.setType(PETSc.PC.Type.GAMG)
    pc.setOperators(matrix)
    pc.setFromOptions()
    pc.setUp()
    for name in _OPTIONS:
        options.delValue(prefix + name)
    near.destroy()
    return pc


def _level(matrix: Any, prolongation: Any, comm: Any) -> Level:
    """A level with the largest eigenvalue of D⁻¹ A, by power iteration."""
    diagonal = matrix.getDiagonal().array_r.copy()
    there = diagonal > _NOTHING * comm.allreduce(float(diagonal.max(initial=0.0)), op=MPI.MAX)
    inverse = np.where(there, 1.0 / np.where(there, diagonal, 1.0), 0.0)
    x = np.random.default_rng(comm.rank).standard_normal((len(diagonal), 1))
    largest = 1.0
    for _ in range(_POWER_STEPS):
        product = apply(matrix, x)
        energy = inner(x, product, comm)[0, 0]
        largest = float(energy / inner(x, diagonal[:, None] * x, comm)[0, 0])
        x = product * inverse[:, None]
        x = x / np.sqrt(inner(x, x, comm)[0, 0])
    return Level(
        matrix=matrix, inverse_diagonal=inverse, largest=largest, prolongation=prolongation
    )


def _inverse(matrix: FloatArray) -> FloatArray:
    """Inverse of a symmetric matrix on what has stiffness: small aggregates have rows too many."""
    diagonal = np.diag(matrix)
    scale = np.where(diagonal > _NOTHING * diagonal.max(), diagonal, np.inf) ** -0.5
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T) * np.outer(scale, scale))
    there = values > _NOTHING * values.max()
    half = scale[:, None] * vectors[:, there] / np.sqrt(values[there])
    return np.asarray(half @ half.T)


def _restricted(prolongation: Any, block: FloatArray) -> FloatArray:
    """Pᵀ times a block."""
    dense = dense_matrix(block, prolongation.getSize()[0], prolongation.comm)
    product = prolongation.transposeMatMult(dense)
    out = np.array(product.getDenseArray(), order="F")
    product.destroy()
    dense.destroy()
    return out


def _dense_rows(matrix: Any) -> FloatArray:
    """Rows of this rank, dense."""
    indptr, indices, data = matrix.getValuesCSR()
    out = np.zeros((len(indptr) - 1, matrix.getSize()[1]))
    out[np.repeat(np.arange(len(out)), np.diff(indptr)), indices] = data
    return out


def _rows_of(matrix: Any, rows: IntArray) -> Any:
    """Some of the rows of this rank, as a matrix."""
    first, _ = matrix.getOwnershipRange()
    chosen = PETSc.IS().createGeneral((first + rows).astype(PETSc.IntType), comm=matrix.comm)
    start, end = matrix.getOwnershipRangeColumn()
    every = PETSc.IS().createStride(end - start, first=start, step=1, comm=matrix.comm)
    out = matrix.createSubMatrix(chosen, every)
    chosen.destroy()
    every.destroy()
    return out


def _lifted_blocks(matrix: Any, places: BlockPlaces) -> Any:
    """The stiffness in whole blocks of three, with a little of its diagonal added.

    Unknowns that symmetry leaves out of a block come back with a diagonal and nothing else.
    """
    comm = matrix.comm.tompi4py()
    rows = 3 * places.blocks
    start = comm.scan(rows) - rows
    number = start + places.place
    indptr, indices, data = matrix.getValuesCSR()
    first, end = matrix.getOwnershipRange()
    columns = np.empty(len(indices), dtype=np.int64)
    own = (indices >= first) & (indices < end)
    columns[own] = number[indices[own] - first]
    columns[~own] = values_of_owners(number, indices[~own].astype(np.int64), comm)
    data = data.copy()
    diagonal = own & (indices == first + np.repeat(np.arange(end - first), np.diff(indptr)))
    data[diagonal] *= 1.0 + _LIFT
    lone = np.setdiff1d(np.arange(rows), places.place)
    before = indptr[np.searchsorted(places.place, lone)]
    typical = comm.allreduce(float(data[diagonal].sum())) / matrix.getSize()[0]
    columns = np.insert(columns, before, start + lone)
    data = np.insert(data, before, typical)
    counts = np.ones(rows, dtype=np.int64)
    counts[places.place] = np.diff(indptr)
    total = comm.allreduce(rows)
    out = PETSc.Mat().createAIJ(
        size=((rows, total), (rows, total)),
        csr=(
            np.concatenate([[0], np.cumsum(counts)]).astype(PETSc.IntType),
            columns.astype(PETSc.IntType),
            data,
        ),
        comm=comm,
    )
    out.setBlockSizes(3, 3)
    out.assemble()
    return out


def _near_null_space(matrix: Any, places: BlockPlaces, comm: Any) -> Any:
    """The rigid motions in whole blocks, orthonormal."""
    gram = inner(places.rigid, places.rigid, comm)
    length = np.sqrt(np.diag(gram))
    s, q = np.linalg.eigh(gram / np.outer(length, length))
    motions = places.rigid / length @ (q / np.sqrt(s))
    vectors = []
    for k in range(motions.shape[1]):
        v = matrix.createVecRight()
        v.set(0.0)
        values = v.array
        values[places.place] = motions[:, k]
        v.array[:] = values
        vectors.append(v)
    out = PETSc.NullSpace().create(vectors=vectors, comm=matrix.comm)
    for v in vectors:
        v.destroy()
    return out
