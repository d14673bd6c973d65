"""The unknowns that are left when surfaces are rigid and the field has a cyclic index."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

from solidwhirl.meshing.imported.records import AnyInterface
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.cyclic import CyclicUnknowns, cyclic_unknowns
from solidwhirl.reduction.operators.joined import JointField, joint_entries, joint_field
from solidwhirl.reduction.operators.kinematics import COMPONENTS, Kinematics
from solidwhirl.reduction.solvers.vectors import apply, as_complex, folded, paired, unpaired
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray, Matrix


def node_of(interface: AnyInterface) -> float | FloatArray:
    """Place of an interface's master node: z on the axis, else (3,) [m]."""
    x, y, z = interface.position_m
    return float(z) if x == y == 0.0 else np.array([x, y, z], dtype=float)


def motion_vectors(space: Any, kin: Kinematics, z0: float | FloatArray) -> dict[str, Matrix]:
    """Nodal values (local rows) of the rigid motions about (0, 0, z0) or a point, by component.

    Rigid motions are linear in the coordinates, so the second-order elements hold them exactly.
    """
    x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    moves = np.ones((len(x), 1))
    if kin.joined is not None:  # copies of a drum have the next orders alone
        moves[kin.joined.copied(space)] = 0.0
    return {c: (moves * motion(x, z0)).ravel() for c, motion in kin.rigid_motions.items()}


@dataclass(frozen=True, kw_only=True, eq=False)
class Unknowns:
    """The unknowns û of a body, and the displacement that they make: u = T û.

    û holds what is free, then, on the last rank, the amplitudes of joints between parts and the
    motions of rigid masters. On a sector T is
    complex: its real and its imaginary part are two matrices, and complex û are paired.
    """

    real: Any  #: Re T as PETSc matrix; None: T is the identity
    imaginary: Any  #: Im T; None: zero
    #: (free of this rank,) squared norms of T's columns, which are orthogonal
    norms: FloatArray
    masters: int  #: Amplitudes of joints and motions of rigid masters on this rank
    joint: JointField | None  #: Field of the joints between parts; its amplitudes come first
    joint_count: int  #: Amplitudes of the joints, of all orders
    #: (free,) local components of u that û holds as they are; None on a sector
    kept: IntArray | None
    is_complex: bool

    @property
    def count(self) -> int:
        """Unknowns of this rank."""
        return len(self.norms) + self.masters

    @property
    def dtype(self) -> type:
        """Of vectors of unknowns."""
        return complex if self.is_complex else float

    def displacement(self, block: Matrix) -> Matrix:
        """Displacement u = T û of every column, (local u, k)."""
        if self.real is None:
            return block
        real = np.asfortranarray(paired(block))
        out = apply(self.real, real)
        return out if self.imaginary is None else as_complex(out, apply(self.imaginary, real))

    def of_motion(self, kin: Kinematics, component: str, values: Matrix) -> Matrix:
        """Unknowns (local û less the rigid masters) of a rigid motion about the origin.

        `values`: (local u,) what it is at the nodes.
        """
        free = self.of_displacement(values[:, None])[:, 0]
        if self.joint is None or not self.masters:
            return free
        amplitudes = np.zeros(self.joint_count, dtype=free.dtype)
        own = self.joint.of_motion(kin.rigid_motions[component])
        amplitudes[: len(own)] = own if np.iscomplexobj(amplitudes) else own.real
        return np.concatenate([free, amplitudes])

    def raised(self, coarse: Unknowns, block: Matrix, values: Matrix) -> Matrix:
        """Unknowns of a displacement that a coarser space has.

        `block`: (local û, n) its unknowns there; `values`: (local u, n) what it is here.
        """
        rows = [self.of_displacement(values)]
        rest = block[len(coarse.norms) :]
        if self.masters and self.joint is not None:
            assert coarse.joint is not None
            own, k = coarse.joint.count, self.joint.count
            amplitudes = np.zeros((self.joint_count, block.shape[1]), dtype=block.dtype)
            amplitudes[:k] = self.joint.raised(coarse.joint, rest[:own])
            rows.append(amplitudes)
            rest = rest[coarse.joint_count :]
        return np.vstack([*rows, rest])

    def loads(self, values: Matrix) -> Matrix:
        """Tᴴ f of columns of loads on u, (local û, k)."""
        if self.real is None:
            return values
        real, imaginary = self._transposed
        out = apply(real, values.real)
        if imaginary is not None:
            out += apply(imaginary, values.imag)
        return unpaired(out) if self.is_complex else out

    @cached_property
    def _transposed(self) -> tuple[Any, Any]:
        """Transposed matrices, which multiply blocks faster than the matrices from the left."""
        parts = (self.real, self.imaginary)
        return tuple(None if m is None else m.copy().transpose() for m in parts)  # type: ignore[return-value]

    def of_displacement(self, values: Matrix) -> Matrix:
        """Free unknowns (free, k) of displacements that they can make."""
        return np.asarray(self.loads(values)[: len(self.norms)] / self.norms[:, None])

    def diagonal(self, values: FloatArray) -> FloatArray:
        """Diagonal of |T|ᵀ diag(d) |T| in û, (local û,).

        `values`: (local u,) d.
        """
        out = np.zeros(self.count)
        for part in (self.real, self.imaginary):
            if part is None:
                continue
            squared = part.copy()
            indptr, columns, entries = part.getValuesCSR()
            squared.setValuesCSR(indptr, columns, entries**2)
            squared.assemble()
            own = apply(squared.transpose(), values[:, None])[:, 0]
            squared.destroy()
            out += own.reshape(self.count, -1)[:, 0]
        return out

    def folded(self, matrix: Any) -> Any:
        """Tᴴ A T of a PETSc matrix of u, which is destroyed."""
        out = self.folded_copy(matrix)
        if out is not matrix:
            matrix.destroy()
        return out

    def folded_copy(self, matrix: Any) -> Any:
        """Tᴴ A T of a PETSc matrix of u; A itself where T is the identity."""
        if self.real is None:
            return matrix
        out = folded(matrix, self.real)
        if self.imaginary is not None:
            other = folded(matrix, self.imaginary)
            out.axpy(1.0, other, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            other.destroy()
        return out

    def crossed(self, matrix: Any) -> Any:
        """(Re T)ᵀ A (Im T) of a PETSc matrix of u, which is destroyed."""
        product = matrix.matMult(self.imaginary)
        out = self.real.transposeMatMult(product)
        product.destroy()
        matrix.destroy()
        return out

    def destroy(self) -> None:
        """Free the matrices."""
        made = self.__dict__.get("_transposed", ())
        for matrix in (self.real, self.imaginary, *made):
            if matrix is not None:
                matrix.destroy()


def body_unknowns(
    space: Any, kin: Kinematics, facet_tags: dict[str, Any], rigid: list[AnyInterface]
) -> Unknowns:
    """Return the free unknowns and those of rigid masters, and how they make all displacements.

    `kin`: kinematics; its cyclic index leaves the unknowns of one sector. `rigid`: interfaces whose
    nodes follow a master; the masters come in their order, each with the kinematics' motions.
    Raises ReductionError: two rigid interfaces share nodes, or the mesh is not the sector it is
    said to be.
    """
    owner = _owners(space, facet_tags, rigid)
    if kin.cyclic is None and not rigid:
        count = 3 * len(owner)
        return Unknowns(real=None, imaginary=None, norms=np.ones(count), masters=0, joint=None,
                        joint_count=0, kept=np.arange(count), is_complex=False)  # fmt: skip
    tied = owner >= 0
    if kin.cyclic is None:
        return _with_masters(space, kin, rigid, owner, _whole_unknowns(space, tied))
    if kin.joined is None:
        cyclics, parts = [kin.cyclic], np.zeros(len(owner), dtype=np.int64)
    else:
        parts = kin.joined.node_parts(space)
        cyclics = [
            replace(kin.cyclic, sector=sector, index=kin.cyclic.index + (shift or 0))
            for sector, shift in zip(kin.joined.sectors, kin.joined.shifts, strict=True)
        ]
        tied = tied | kin.joined.joint_nodes(space) | kin.joined.still(parts)
    return _with_masters(space, kin, rigid, owner, cyclic_unknowns(space, cyclics, parts, tied))


def _whole_unknowns(space: Any, tied: BoolArray) -> CyclicUnknowns:
    """All components of the nodes that are not tied."""
    rows = np.flatnonzero(np.repeat(~tied, 3))
    start = int(space.mesh.comm.scan(len(rows))) - len(rows)
    return CyclicUnknowns(
        rows=rows,
        columns=start + np.arange(len(rows)),
        factors=np.ones(len(rows), dtype=complex),
        norms=np.ones(len(rows)),
    )


def _with_masters(
    space: Any, kin: Kinematics, rigid: list[AnyInterface], owner: IntArray, free: CyclicUnknowns
) -> Unknowns:
    """Matrices of the free unknowns and of the masters."""
    comm = space.mesh.comm
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    total, field, amplitudes = comm.allreduce(len(free.norms)), None, 0
    parts = [(free.rows, free.columns, free.factors)]
    if kin.joined is not None:
        assert kin.cyclic is not None
        degree, is_real = compat.polynomial_degree(space), not kin.cyclic.has_two_parts
        field = joint_field(kin.joined, degree, is_real=is_real)
        entries = joint_entries(space, kin.joined, field, kin.cyclic.index)
        rows, columns, factors, amplitudes = entries
        parts.append((rows, total + columns, factors))
    for k, interface in enumerate(rigid):
        values = motion_vectors(space, kin, node_of(interface))
        rows = np.flatnonzero(np.repeat(owner == k, 3))
        for j, c in enumerate(motions):
            column = np.full(len(rows), total + amplitudes + k * len(motions) + j)
            parts.append((rows, column, values[c][rows].astype(complex)))
    rows, columns, factors = (np.concatenate(part) for part in zip(*parts, strict=True))
    is_complex = kin.cyclic is not None and kin.cyclic.has_complex_amplitudes
    masters = amplitudes + len(rigid) * len(motions)
    own = masters if comm.rank == comm.size - 1 else 0
    size = (len(free.norms) + own, total + masters)
    nodes = space.dofmap.index_map
    height = (3 * nodes.size_local, 3 * nodes.size_global)
    if is_complex:
        # p (a + ib): a moves the real part by Re p and the imaginary one by Im p, b by -Im p, Re p
        rows = np.concatenate([rows, rows])
        columns = np.concatenate([2 * columns, 2 * columns + 1])
        factors = np.concatenate([factors, 1j * factors])
        size = (2 * size[0], 2 * size[1])
    parts_of_t = [_sparse(rows, columns, values, height, size, comm)
                  for values in (factors.real, factors.imag)]  # fmt: skip
    if kin.cyclic is None or not kin.cyclic.has_two_parts:
        parts_of_t.pop().destroy()
        parts_of_t.append(None)
    return Unknowns(
        real=parts_of_t[0],
        imaginary=parts_of_t[1],
        norms=free.norms,
        masters=own,
        joint=field,
        joint_count=amplitudes,
        kept=free.rows if kin.cyclic is None else None,
        is_complex=is_complex,
    )


def _sparse(
    rows: IntArray,
    columns: IntArray,
    values: FloatArray,
    height: tuple[int, int],
    width: tuple[int, int],
    comm: Any,
) -> Any:
    """PETSc matrix of entries in rows of this rank, zeros left out."""
    there = values != 0.0
    rows, columns, values = rows[there], columns[there], values[there]
    order = np.lexsort((columns, rows))
    indptr = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=height[0]))])
    out = PETSc.Mat().createAIJ(
        size=(height, width),
        csr=(
            indptr.astype(PETSc.IntType),
            columns[order].astype(PETSc.IntType),
            values[order],
        ),
        comm=comm,
    )
    out.assemble()
    return out


def _owners(space: Any, facet_tags: dict[str, Any], rigid: list[AnyInterface]) -> IntArray:
    """Rigid interface that each node of this rank follows, -1: none."""
    index_map = space.dofmap.index_map
    owner = np.full(index_map.size_local, -1, dtype=np.int64)
    for k, interface in enumerate(rigid):
        tags = facet_tags[interface.name]
        nodes = fem.locate_dofs_topological(space, tags.dim, tags.indices)
        nodes = nodes[nodes < index_map.size_local]
        if space.mesh.comm.allreduce(int(np.sum(owner[nodes] >= 0))):
            raise ReductionError(f"rigid interface {interface.name!r} shares nodes with another")
        owner[nodes] = k
    return owner
