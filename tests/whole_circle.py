"""The whole circle of a sector's mesh in the frame that turns with it, by forms of its own.

    M u'' + 2Ω C u' + (K + Ω² K2) u = f,    C = ∫ρ v·(e_z×u),    K2 = Kσ − ∫ρ (e_z×v)·(e_z×u)

with the stress at unit speed from a static solution of the whole. Nothing here knows of sectors but
`fields`, which lays a field of one cyclic index around the circle.
"""

from __future__ import annotations

from reduced import sparse  # loads h5py, which fails behind dolfinx

# isort: split
from typing import NamedTuple

import numpy as np
import scipy.sparse.linalg as spla
import ufl
from dolfinx import fem
from mpi4py import MPI

from solidwhirl.meshing.own.whole import whole_mesh
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

ALONG = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}


class Turning(NamedTuple):
    """K, M, iC and K2 at unit speed, Hermitian, sparse or not."""

    stiffness: object
    mass: object
    coriolis: object
    centrifugal: object

    def projected(self, basis):
        """VᴴAV of all."""
        return Turning(*(basis.conj().T @ (a @ basis) for a in self))

    def kept(self, free):
        """Rows and columns of some unknowns."""
        return Turning(*(a.tocsr()[free][:, free] for a in self))


class WholeCircle:
    """The whole mesh of a sector, and its matrices, three components of a node next to another."""

    def __init__(self, mesh):
        self.sector, (self.mesh, self.origin) = mesh.sector, whole_mesh(mesh)
        domain, cells, self.facets = compat.distribute(self.mesh, 3, MPI.COMM_SELF)
        self.space = compat.vector_space(domain, 2, 3)
        self.points = self.space.tabulate_dof_coordinates()
        self.matrices = _turning(self.space, _material(domain, cells, self.mesh.materials))
        # nodes of the mesh in the order of the space
        self.node = nearest(self.mesh.points, self.points)

    def on(self, interface):
        """Nodes of an interface."""
        tags = self.facets[interface]
        return fem.locate_dofs_topological(self.space, tags.dim, tags.indices)

    def free(self, *held):
        """Unknowns that are not at held interfaces."""
        still = np.zeros(len(self.points), dtype=bool)
        for interface in held:
            still[self.on(interface)] = True
        return np.flatnonzero(~np.repeat(still, 3))

    def fields(self, operators, unknowns):
        """Fields Φ (3 nodes, n) on the whole from unknowns (û, n) of one cyclic index."""
        count, index = self.sector.count, operators.harmonic
        places = operators.space.tabulate_dof_coordinates()
        there = nearest(places, self._seeds())
        own = operators.coupling.unknowns.displacement(unknowns).reshape(len(places), 3, -1)[there]
        back = self.origin.mirrored[self.node]
        mirror = np.where(back[:, None], [1.0, -1.0, 1.0], 1.0)[:, :, None]
        # Φ1 of half a sector is symmetric in the plane θ = 0, Φ2 antisymmetric
        own = mirror * np.where(back[:, None, None], own.conj(), own)
        angle = 2.0 * np.pi / count * self.origin.copy[self.node]
        c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
        x, y, z = own[:, 0], own[:, 1], own[:, 2]
        turned = np.stack([c * x - s * y, s * x + c * y, z], axis=1)
        turned = turned * np.exp(1j * index * angle)[:, None, None]
        turned = turned.reshape(3 * len(self.points), -1)
        # index 0 and N/2 of half a sector: Φ1 + Φ2
        return turned.real + turned.imag if 2 * index % count == 0 else turned

    def _seeds(self):
        """Places in the sector that the nodes of the whole are copies of."""
        angle = -2.0 * np.pi / self.sector.count * self.origin.copy
        c, s = np.cos(angle), np.sin(angle)
        x, y, z = self.mesh.points.T
        y = np.where(self.origin.mirrored, -1.0, 1.0) * (s * x + c * y)
        return np.column_stack([c * x - np.sin(angle) * self.mesh.points[:, 1], y, z])[self.node]


def nearest(points, places):
    """Numbers of the points at places; all are there."""
    from scipy.spatial import cKDTree

    gap, found = cKDTree(points).query(places)
    assert gap.max() < 1e-9 * np.abs(points).max()
    return found


def _material(domain, cells, materials):
    """Density, λ and μ of every cell."""
    e, nu = (
        np.array([getattr(m, n) for m in materials])
        for n in ("youngs_modulus_pa", "poissons_ratio")
    )
    fields = []
    for values in (
        np.array([m.density_kg_per_m3 for m in materials]),
        e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        e / (2.0 * (1.0 + nu)),
    ):
        field = fem.Function(compat.scalar_space(domain, "DG", 0))
        field.x.array[cells.indices] = values[cells.values]
        fields.append(field)
    return fields


def _turning(space, material):
    density, first, second = material
    x, (u, v) = (
        ufl.SpatialCoordinate(space.mesh),
        (ufl.TrialFunction(space), ufl.TestFunction(space)),
    )
    dx = ufl.Measure("dx", domain=space.mesh, metadata={"quadrature_degree": 4})

    def stress(w):
        strain = ufl.sym(ufl.grad(w))
        return first * ufl.tr(strain) * ufl.Identity(3) + 2.0 * second * strain

    def turn(w):
        return ufl.as_vector((-w[1], w[0], 0.0 * w[0]))

    def matrix(form):
        found = compat.assemble_matrix(compat.compiled(form))
        out = sparse(found)
        found.destroy()
        return out

    stiffness = matrix(ufl.inner(stress(u), ufl.sym(ufl.grad(v))) * dx)
    pull = density * ufl.inner(ufl.as_vector((x[0], x[1], 0.0 * x[0])), v) * dx
    field = fem.Function(space)
    load = compat.assembled_vector(compat.compiled(pull))
    compat.owned_values(field)[:] = _balanced_answer(stiffness, load, space)
    pulled = ufl.inner(ufl.dot(ufl.grad(u), stress(field)), ufl.grad(v)) * dx
    return Turning(
        stiffness=stiffness,
        mass=matrix(density * ufl.inner(u, v) * dx),
        coriolis=1j * matrix(density * ufl.inner(turn(u), v) * dx),
        centrifugal=matrix(pulled) - matrix(density * ufl.inner(turn(u), turn(v)) * dx),
    )


def _balanced_answer(stiffness, load, space):
    """Displacement under a load without resultants; three nodes far apart hold six components."""
    x = space.tabulate_dof_coordinates()
    a = int(np.argmax(x[:, 0] - x[:, 2]))
    b = int(np.argmax(np.linalg.norm(x - x[a], axis=1)))
    line = (x[b] - x[a]) / np.linalg.norm(x[b] - x[a])
    c = int(np.argmax(np.linalg.norm(np.cross(x - x[a], line), axis=1)))
    across = np.abs(line[None, :]).argmax()
    rows = [3 * a, 3 * a + 1, 3 * a + 2, *[3 * b + k for k in range(3) if k != across]]
    # about the line from a to b the third node turns by this component
    rows.append(3 * c + int(np.abs(np.cross(line, x[c] - x[a])).argmax()))
    free = np.setdiff1d(np.arange(len(load)), rows)
    inside, out = stiffness[free][:, free].tocsc(), np.zeros(len(load))
    factor = spla.splu(inside, **ALONG)
    out[free] = factor.solve(load[free])
    out[free] += factor.solve(load[free] - inside @ out[free])
    return out


def unreduced(body, mesh, index, held):
    """Operators of one cyclic index, and its matrices with the held interfaces' unknowns gone."""
    effects = OperatorEffects(
        gyroscopic=True, centrifugal=True, components={i.name: () for i in body.interfaces}
    )
    operators = build_operators(body, mesh, MPI.COMM_SELF, order=index, degree=2, effects=effects)
    unknowns = operators.coupling.unknowns
    free = len(unknowns.norms) if held else unknowns.count
    names = ("stiffness", "mass", "gyroscopic", "stress_stiffening", "spin_softening")
    k, m, g, kept, softened = (_complex(getattr(operators, n), unknowns, free) for n in names)
    if operators.families == 1:
        return operators, Turning(k, m, 0.5j * g, kept - softened)
    # back from inertial coordinates: G = M − iC, S = S_c + M − 2iC
    return operators, Turning(k, m, m - g, kept - softened - m + 2.0 * g)


def _complex(operator, unknowns, free):
    matrix = operator if hasattr(operator, "getValuesCSR") else operator.folded()
    found = sparse(matrix)
    if unknowns.is_complex:
        found = found[::2, ::2] + 1j * found[1::2, ::2]
    return found[:free, :free]


def rates(matrices, speed, count):
    """Angular frequencies ω (count,) of either sign nearest to 0, and their modes.

    (K + Ω² K2 + 2ωΩ iC − ω² M) φ = 0 as an eigenvalue problem of 1/ω for (φ, ωφ), and once more the
    quadratic equation of φ, whose root has the square of the error of φ.
    """
    k, m, turned, change = matrices
    k = (k + speed**2 * change).tocsc()
    turned = 2.0 * speed * turned
    factor = spla.splu(k, **ALONG)
    n = k.shape[0]
    solve = (
        factor.solve
        if np.iscomplexobj(k.data)
        else lambda b: (
            factor.solve(np.ascontiguousarray(b.real))
            + 1j * factor.solve(np.ascontiguousarray(b.imag))
        )
    )

    def times(state):
        return np.concatenate([solve(m @ state[n:] - turned @ state[:n]), state[:n]])

    inverse = spla.LinearOperator((2 * n, 2 * n), matvec=times, dtype=complex)
    start = np.random.default_rng(5).standard_normal(2 * n).astype(complex)
    found, states = spla.eigs(inverse, count, v0=start, which="LM", ncv=2 * count + 20)
    order = np.argsort(np.abs(1.0 / found))
    # one more step leaves what rounding leaves of the forces at every node
    shapes = np.column_stack([times(state)[:n] for state in states[:, order].T])
    a, b, c = (np.einsum("ij,ij->j", shapes.conj(), x @ shapes).real for x in (m, turned, k))
    root = np.sqrt(b**2 + 4.0 * a * c)
    return (b + np.sign(found[order].real) * root) / (2.0 * a), shapes
