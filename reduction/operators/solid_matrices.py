"""Matrices of the solid that act on every Cartesian component alike, from those of one component.

∫ρ v·u, ∫ρ v·Du, ∫ρ Dv·Du and ∫σ0:(∇uᵀ∇v) do not mix the components of u. Each is assembled for one
component, a ninth of the entries, and a matrix of vectors is a sum Σ C ⊗ A of 3 by 3 arrays C and
component matrices A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray
from petsc4py import PETSc

from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat, forms
from solidwhirl.reduction.operators.dofs import Unknowns
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.solvers.vectors import apply, as_complex
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix

# e_z × u, and the components that it turns
_QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
_LATERAL = np.diag([1.0, 1.0, 0.0])
_ALL = np.eye(3)


@dataclass(frozen=True, kw_only=True, eq=False)
class ComponentMatrices:
    """Matrices of one component on the nodes of a vector space, PETSc AIJ of one pattern.

    The derivatives along the spin are those of the inertial frame; None without.
    """

    mass: Any
    spin: Any = None
    softening: Any = None


def component_matrices(
    space: Any, kin: Kinematics, matter: forms.Medium, dx: Any, *, along_spin: bool
) -> ComponentMatrices:
    """Assemble the matrices that need no prestress.

    `space`: vector space of the displacement on a solid mesh. `along_spin`: whether derivatives
    along the spin are among them.
    """
    nodes = _node_space(space)
    u, v = ufl.TrialFunction(nodes), ufl.TestFunction(nodes)
    forms_of = {"mass": forms.mass_form}
    if along_spin:
        forms_of |= {"spin": forms.spin_form, "softening": forms.softening_form}
    made = {
        name: compat.assemble_matrix(compat.compiled(form(kin, matter, u, v, dx)))
        for name, form in forms_of.items()
    }
    # of a body of revolution point masses lie on the axis, where nothing changes along the spin
    _add_point_masses(made["mass"], space, kin, matter)
    return ComponentMatrices(**made)


def component_mass(space: Any, kin: Kinematics, matter: forms.Medium, dx: Any) -> Any:
    """M of one component."""
    nodes = _node_space(space)
    u, v = ufl.TrialFunction(nodes), ufl.TestFunction(nodes)
    mass = compat.assemble_matrix(compat.compiled(forms.mass_form(kin, matter, u, v, dx)))
    if kin.dimension == 3:
        _add_point_masses(mass, space, kin, matter)
    return mass


def _add_point_masses(mass: Any, space: Any, kin: Kinematics, matter: forms.Medium) -> None:
    if not len(matter.point_masses):
        return
    first, _ = mass.getOwnershipRange()
    for node, own in zip(*forms.at_nodes(space, kin, matter), strict=True):
        mass.setValue(first + int(node), first + int(node), own, addv=True)
    mass.assemble()


def component_stiffening(space: Any, kin: Kinematics, prestress: Any, dx: Any) -> Any:
    """Kσ of one component."""
    nodes = _node_space(space)
    u, v = ufl.TrialFunction(nodes), ufl.TestFunction(nodes)
    return compat.assemble_matrix(compat.compiled(forms.stiffening_form(kin, prestress, u, v, dx)))


def _node_space(space: Any) -> Any:
    """Scalar space whose unknown i is the node i of a vector space."""
    nodes = compat.scalar_space(space.mesh, "Lagrange", compat.polynomial_degree(space))
    if not np.array_equal(compat.cell_unknowns(nodes), compat.cell_unknowns(space)):
        raise ReductionError("scalar and vector elements number the nodes of a mesh differently")
    return nodes


def vector_matrix(name: str, parts: ComponentMatrices) -> Any:
    """Matrix of the displacement u, by name.

    "mass": M. "gyroscopic": G = ∫ρ (v·Du - u·Dv), exactly skew. "turn": ∫ρ v·Ju. "circulation":
    ∫ρ Jv·Ju with J u = e_z × u - D u, see `forms`; its mixed terms are -∫ρ (e_z×v)·Du - ∫ρ
    Dv·(e_z×u), and (e_z×)ᵀ = -(e_z×).
    """
    if name == "mass":
        terms = [(_ALL, parts.mass)]
    elif name == "turn":
        terms = [(_QUARTER, parts.mass), (-_ALL, parts.spin)]
    elif name == "gyroscopic":
        terms = [(_ALL, _skew_twice(parts.spin))]
    elif name == "spin_softening":
        terms = [(_ALL, parts.softening)]
    else:
        skew = _skew_twice(parts.spin)
        terms = [(_LATERAL, parts.mass), (_QUARTER, skew), (_ALL, parts.softening)]
    return on_vectors(terms)


@dataclass(frozen=True, kw_only=True, eq=False)
class SectorStiffness:
    """Operator Tᴴ A T of a sector, with the matrix A of all of u."""

    unknowns: Unknowns
    matrix: Any  #: A, PETSc

    def times(self, block: Matrix) -> Matrix:
        """Operator times every column."""
        return self.unknowns.loads(_real_times(self.matrix, self.unknowns.displacement(block)))

    def diagonal(self) -> FloatArray:
        """Diagonal in the free unknowns, without what two nodes of one unknown have in common."""
        found = self.matrix.getDiagonal()
        out = self.unknowns.diagonal(found.array_r)
        found.destroy()
        return out

    def folded(self) -> Any:
        """As a PETSc matrix of the unknowns û; A is destroyed."""
        return self.unknowns.folded(self.matrix)

    def destroy(self) -> None:
        """Free the matrix."""
        self.matrix.destroy()


@dataclass(frozen=True, kw_only=True, eq=False)
class SectorOperator:
    """Operator Tᴴ (C ⊗ A + B) T of a sector or a whole solid, with one component's matrix A.

    As a product with blocks alone it costs a tenth of what the matrix of the unknowns û would.
    """

    unknowns: Unknowns
    component: Any  #: A, PETSc matrix of nodes
    directions: Matrix  #: C, (3, 3)
    beside: Any = None  #: B, PETSc matrix of all of u with few entries; None: zero

    def times(self, block: Matrix) -> Matrix:
        """Operator times every column."""
        full = np.asfortranarray(self.unknowns.displacement(block))
        nodes, k = len(full) // 3, block.shape[1]
        # stored by columns, as products want it: one copy there, one back
        field = self._directed(full.reshape((3, nodes, k), order="F"))
        load = _real_times(self.component, field.reshape((nodes, 3 * k), order="F"))
        back = np.empty((3, nodes, k), dtype=load.dtype, order="F")
        back[:] = load.reshape((nodes, 3, k), order="F").transpose(1, 0, 2)
        if self.beside is not None:
            back += _real_times(self.beside, full).reshape(back.shape, order="F")
        return self.unknowns.loads(back.reshape((3 * nodes, k), order="F"))

    def _directed(self, field: Matrix) -> Matrix:
        """C Φ of nodes, (nodes, 3, k), from Φ, (3, nodes, k)."""
        _, nodes, k = field.shape
        dtype = np.result_type(self.directions, field)
        out = np.zeros((nodes, 3, k), dtype=dtype, order="F")
        for i, j in np.argwhere(self.directions):
            out[:, i] += self.directions[i, j] * field[j]
        return out

    def folded(self) -> Any:
        """As a PETSc matrix of the unknowns û."""
        out = self.unknowns.folded(on_vectors([(self.directions.real, self.component)]))
        if self.directions.imag.any():
            # Re[(V1 - iV2) iC (U1 + iU2)] = V2 C U1 - V1 C U2
            product = self.unknowns.crossed(on_vectors([(self.directions.imag, self.component)]))
            out.axpy(-1.0, product, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            product.transpose()
            out.axpy(-1.0, product, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            product.destroy()
        if self.beside is not None:
            other = self.unknowns.folded(self.beside.copy())
            out.axpy(1.0, other, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            other.destroy()
        return out

    def destroy(self) -> None:
        """Free the matrices."""
        for matrix in (self.component, self.beside):
            if matrix is not None:
                matrix.destroy()


class HalfSectorSpin(SectorOperator):
    """Skew operator of the real fields Φ1 + Φ2 of half a sector.

    Φ1 is symmetric and Φ2 antisymmetric in the mirror plane; a quarter turn exchanges them.
    """

    def _directed(self, field: Matrix) -> Matrix:
        return np.asarray(1j * super()._directed(field).conj())

    def folded(self) -> Any:
        """As a PETSc matrix: Re[(V1 - iV2) iC (U1 - iU2)] = V1 C U2 + V2 C U1, C skew."""
        out = self.unknowns.crossed(on_vectors([(self.directions.real, self.component)]))
        transposed = out.copy()
        transposed.transpose()
        out.axpy(-1.0, transposed, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        transposed.destroy()
        return out


def _real_times(matrix: Any, field: Matrix) -> Matrix:
    """A real matrix times a block that may be complex."""
    if not np.iscomplexobj(field):
        return apply(matrix, field)
    count = field.shape[1]
    both = np.empty((len(field), 2 * count), order="F")
    both[:, :count], both[:, count:] = field.real, field.imag
    both = apply(matrix, both)
    return as_complex(both[:, :count], both[:, count:])


def sector_spin(unknowns: Unknowns, families: int, mass: Any) -> dict[str, SectorOperator]:
    """Return N = M - iC of two families, or G = 2C of one, and S; they share a component's mass."""
    if families == 2:
        spin = SectorOperator(unknowns=unknowns, component=mass, directions=_ALL - 1j * _QUARTER)
        softening = _LATERAL + _ALL - 2j * _QUARTER
    else:
        kind = SectorOperator if unknowns.imaginary is None else HalfSectorSpin
        spin = kind(unknowns=unknowns, component=mass, directions=2.0 * _QUARTER)
        softening = _LATERAL
    return {
        "gyroscopic": spin,
        "spin_softening": SectorOperator(unknowns=unknowns, component=mass, directions=softening),
    }


def sector_componentwise(unknowns: Unknowns, component: Any) -> SectorOperator:
    """Operator of a sector or a whole that acts on every component alike, as M and Kσ."""
    return SectorOperator(unknowns=unknowns, component=component, directions=_ALL)


def _skew_twice(matrix: Any) -> Any:
    """A - Aᵀ."""
    transposed = matrix.copy()
    transposed.transpose()
    out = matrix.copy()
    out.axpy(-1.0, transposed, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    transposed.destroy()
    return out


def on_vectors(terms: Sequence[tuple[FloatArray, Any]]) -> Any:
    """Σ C ⊗ A with the three components of a node next to each other.

    `terms`: pairs of C, (3, 3), and A, a PETSc AIJ matrix of nodes; all A have one pattern.
    """
    first = terms[0][1]
    indptr, columns, _ = first.getValuesCSR()
    values = [a.getValuesCSR()[2] for _, a in terms]
    blocks = {}
    for i, j in np.argwhere(np.any([c != 0.0 for c, _ in terms], axis=0)):
        parts = [c[i, j] * v for (c, _), v in zip(terms, values, strict=True) if c[i, j] != 0.0]
        blocks[int(i), int(j)] = parts[0] if len(parts) == 1 else np.sum(parts, axis=0)
    rows, cells, data = _interleaved(np.asarray(indptr, dtype=np.int64), columns, blocks)
    (local, size), _ = first.getSizes()
    out = PETSc.Mat().createAIJ(
        size=((3 * local, 3 * size), (3 * local, 3 * size)),
        csr=(rows.astype(PETSc.IntType), cells.astype(PETSc.IntType), data),
        comm=first.comm,
    )
    out.assemble()
    return out


def _interleaved(
    indptr: IntArray, columns: NDArray[Any], blocks: dict[tuple[int, int], FloatArray]
) -> tuple[IntArray, IntArray, FloatArray]:
    """CSR of a matrix of 3 by 3 blocks, from the entries of every place in the block."""
    counts = np.diff(indptr)
    start, length = np.repeat(indptr[:-1], counts), np.repeat(counts, counts)
    within = np.arange(len(columns)) - start
    across = [[j for j in range(3) if (i, j) in blocks] for i in range(3)]
    cells = np.empty(len(columns) * len(blocks), dtype=np.int64)
    data = np.empty(len(cells))
    before = 0
    for i in range(3):
        for k, j in enumerate(across[i]):
            at = start * len(blocks) + length * before + within * len(across[i]) + k
            cells[at] = 3 * columns.astype(np.int64) + j
            data[at] = blocks[i, j]
        before += len(across[i])
    per_row = np.outer(counts, [len(a) for a in across]).ravel()
    return np.concatenate([[0], np.cumsum(per_row)]), cells, data
