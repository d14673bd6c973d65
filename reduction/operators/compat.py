"""The one place that knows how dolfinx 0.5.2 (Debian 12) and 0.9 (Debian 13) differ.

Nothing else in the project calls a dolfinx function whose name or signature differs.
"""

from __future__ import annotations

import ctypes
import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import combinations
from typing import Any, NamedTuple

# PyPI's wheel of dolfinx puts its MPI, PETSc and SLEPc in order, before any of them is loaded
with suppress(ModuleNotFoundError):
    import dolfinx_solver  # noqa: F401

import numpy as np
import ufl
from petsc4py import PETSc

from solidwhirl.core.reduction_work import BODIES
from solidwhirl.meshing import IntArray, Mesh
from solidwhirl.reduction.operators.form_cache import guard_compiler, silent


@contextmanager
def _hidden(name: str) -> Iterator[None]:
    """Let imports of a module fail for a while."""
    before = sys.modules.get(name)
    sys.modules[name] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules[name]
        if before is not None:
            sys.modules[name] = before


# Where it finds llvmlite, 0.9 loads all of PETSc's symbols for numba, which nothing here uses; then
# PETSc sees two MPI libraries where there is one. Without it, it warns.
with warnings.catch_warnings(), _hidden("llvmlite"):
    warnings.simplefilter("ignore", ImportWarning)
    import dolfinx
    import dolfinx.fem.petsc
    import ffcx.codegeneration.jit
    from dolfinx import cpp as _cpp
    from dolfinx import fem
    from dolfinx import mesh as _mesh

guard_compiler(ffcx.codegeneration.jit)

# MPI has malloc keep what is freed, for networks that remember addresses. A factor takes its memory
# as address space at once, which would stay with the process when it ends; beyond the memory of the
# machine the system grants no fork. Large blocks (32 MiB) are mapped, and end when they are freed.
_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_MMAP_MAX = -1, -3, -4
if sys.platform == "linux":
    with suppress(AttributeError):  # another C library than glibc
        for _option, _value in (
            (_M_MMAP_MAX, 65536),
            (_M_MMAP_THRESHOLD, 32 << 20),
            (_M_TRIM_THRESHOLD, 64 << 20),
        ):
            ctypes.CDLL(None).mallopt(_option, _value)

if np.dtype(PETSc.ScalarType).kind == "c":
    raise ImportError(
        "PETSc is compiled for complex numbers; real ones are needed", name="petsc4py"
    )

VERSION = tuple(int(n) for n in re.findall(r"\d+", dolfinx.__version__)[:3])
_OLD = not hasattr(fem, "functionspace")
_CELL = {2: "triangle", 3: "tetrahedron"}


def _coordinate_element(cell: str, gdim: int) -> Any:
    """Second-order coordinate element on equispaced nodes, as gmsh has them."""
    if _OLD:
        shape = ufl.Cell(cell, geometric_dimension=gdim)
        scalar = ufl.FiniteElement("Lagrange", shape, 2, variant="equispaced")
        return ufl.Mesh(ufl.VectorElement(scalar))
    import basix
    import basix.ufl

    variant = basix.LagrangeVariant.equispaced
    return ufl.Mesh(basix.ufl.element("Lagrange", cell, 2, variant, shape=(gdim,)))


def vector_space(mesh: Any, degree: int, components: int) -> Any:
    """Continuous Lagrange space of vectors."""
    if _OLD:
        return fem.VectorFunctionSpace(mesh, ("Lagrange", degree), dim=components)
    return fem.functionspace(mesh, ("Lagrange", degree, (components,)))


def scalar_space(mesh: Any, family: str, degree: int) -> Any:
    """Space of scalars."""
    space = fem.FunctionSpace if _OLD else fem.functionspace
    return space(mesh, (family, degree))


def polynomial_degree(space: Any) -> int:
    """Degree of a Lagrange space."""
    degree = space.ufl_element().degree
    return int(degree() if callable(degree) else degree)


def _cell_nodes(mesh: Any) -> Any:
    """Nodes of the cells of this rank, (cells, nodes of a cell)."""
    nodes = mesh.geometry.dofmap if VERSION < (0, 11) else mesh.geometry.dofmaps[0]
    count = mesh.topology.index_map(mesh.topology.dim).size_local
    return nodes.array.reshape(count, -1) if hasattr(nodes, "array") else np.asarray(nodes)


def curved_cells(mesh: Any) -> tuple[Any, IntArray]:
    """Coordinates of the mesh's nodes and all nodes of its cells, corners first (one process).

    In dolfinx's order; cells come in the order of the cell-wise constants of the mesh.
    """
    return mesh.geometry.x[:, : mesh.topology.dim].copy(), _cell_nodes(mesh).astype(np.int64)


def straight_cells(mesh: Any) -> tuple[Any, IntArray]:
    """As `curved_cells`, of the cells the vertices alone."""
    points, nodes = curved_cells(mesh)
    return points, nodes[:, : mesh.topology.dim + 1]


def cell_unknowns(space: Any) -> IntArray:
    """Local unknowns (blocks of them) of every cell, flat."""
    cells = space.dofmap.list
    return np.asarray(cells.array if _OLD else cells, dtype=np.int64).ravel()


def reference_points(space: Any) -> Any:
    """Where the unknowns of a Lagrange space are in the reference cell, in their order in cells."""
    found = space.element.interpolation_points
    return np.asarray(found() if callable(found) else found)


def geometry_points(dimension: int) -> Any:
    """Where the nodes of `curved_cells` are in the reference cell: corners, middles of edges."""
    corners = np.vstack([np.zeros(dimension), np.eye(dimension)])
    edges = combinations(range(dimension + 1), 2)
    return np.vstack([corners, *(corners[list(e)].mean(axis=0) for e in reversed(list(edges)))])


def constant(mesh: Any, value: float) -> Any:
    """Constant of a form that is no part of its compiled code."""
    return fem.Constant(mesh, PETSc.ScalarType(value))


def owned_values(function: Any) -> Any:
    """Values of a function on this rank, an array that writes through.

    A function's PETSc vector would be kept by PETSc when Python drops it.
    """
    dofmap = function.function_space.dofmap
    return function.x.array[: dofmap.index_map.size_local * dofmap.index_map_bs]


@contextmanager
def _quiet_compiler() -> Iterator[None]:
    """Without the chatter of the form compiler, and what it leaves of files and deprecations."""
    with silent(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def compiled(form: Any) -> Any:
    """Compile a UFL form, or find it in the compiler's cache."""
    with _quiet_compiler():
        return fem.form(form)


def expression(value: Any, points: Any) -> Any:
    """Expression of fields, compiled for some points of the reference cell."""
    with _quiet_compiler():
        return fem.Expression(value, points)


def evaluated(found: Any, mesh: Any) -> Any:
    """Values of an expression in all cells of this rank, (cells, points times components)."""
    count = mesh.topology.index_map(mesh.topology.dim).size_local
    cells = np.arange(count, dtype=np.int32)
    return found.eval(cells) if _OLD else found.eval(mesh, cells)


def assembled_number(form: Any) -> float:
    """Value of a compiled form without arguments, the part of this rank."""
    return float(np.real(fem.assemble_scalar(form)))


def assemble_matrix(form: Any) -> Any:
    """Assembled PETSc matrix of a compiled bilinear form."""
    BODIES.add("matrices")
    matrix = dolfinx.fem.petsc.assemble_matrix(form)
    matrix.assemble()
    return matrix


def assembled_vector(form: Any) -> Any:
    """Assembled vector of a compiled linear form, the part of this rank."""
    vector = dolfinx.fem.petsc.assemble_vector(form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    out = vector.array.copy()
    vector.destroy()
    return out


def collect_garbage(comm: Any) -> None:
    """Free what PETSc kept of objects that Python has dropped; PETSc 3.18 and later only.

    From then on PETSc keeps them until all ranks agree, and never asks by itself.
    """
    clean = getattr(PETSc, "garbage_cleanup", None)
    if clean is not None:
        clean(comm)


def _permutation(dimension: int, nodes: int) -> IntArray:
    """Node order: dolfinx[i] = gmsh[permutation[i]]."""
    from importlib import import_module

    name = "dolfinx.io.gmshio" if _OLD or VERSION < (0, 10) else "dolfinx.io.gmsh"
    kind = getattr(_mesh.CellType, {1: "interval", 2: "triangle", 3: "tetrahedron"}[dimension])
    return np.asarray(import_module(name).cell_perm_array(kind, nodes), dtype=np.int64)


def _tags(mesh: Any, dimension: int, entities: IntArray, values: IntArray) -> Any:
    """Mesh tags from the nodes (dolfinx order, input numbering) of entities on any rank."""
    entities = np.ascontiguousarray(entities, dtype=np.int64)
    values32 = np.ascontiguousarray(values, dtype=np.int32)
    if _OLD:
        handle = mesh._mesh if hasattr(mesh, "_mesh") else mesh
        local, kept = _cpp.io.distribute_entity_data(handle, dimension, entities, values32)
        adjacency = _cpp.graph.AdjacencyList_int32(local)
    else:
        from dolfinx.io import distribute_entity_data

        local, kept = distribute_entity_data(mesh, dimension, entities, values32)
        adjacency = dolfinx.graph.adjacencylist(local)
    mesh.topology.create_connectivity(dimension, 0)
    mesh.topology.create_connectivity(dimension, mesh.topology.dim)
    return _mesh.meshtags_from_entities(mesh, dimension, adjacency, kept.astype(np.int32))


class Tags(NamedTuple):
    """Values of entities of a mesh."""

    indices: Any
    values: Any


def retagged(tags: Any, values: IntArray) -> Tags:
    """Tags of the same entities with other values."""
    return Tags(tags.indices, values)


def distribute(mesh: Mesh | None, dimension: int, comm: Any) -> tuple[Any, Any, dict[str, Any]]:
    """Distribute a mesh that rank 0 holds.

    `mesh`: the mesh on rank 0; ignored elsewhere. `dimension`: 2 or 3. Returns domain, material
    tags, facet tags by interface name: facets of an interface have the tag 1 in that interface's
    own tags (interfaces may share facets).
    """
    nodes, facet_nodes = {2: (6, 3), 3: (10, 6)}[dimension]
    cells = np.empty((0, nodes), dtype=np.int64)
    points = np.empty((0, dimension))
    material = np.empty(0, dtype=np.int64)
    interfaces: dict[str, IntArray] = {}
    if comm.rank == 0:
        assert mesh is not None
        cells = mesh.cells[:, _permutation(dimension, nodes)]
        points, material = mesh.points, mesh.cell_material
        order = _permutation(dimension - 1, facet_nodes)
        interfaces = {name: facets[:, order] for name, facets in mesh.facet_sets.items()}
    names = comm.bcast(list(interfaces), root=0)
    element = _coordinate_element(_CELL[dimension], dimension)
    cells = np.ascontiguousarray(cells)
    points = np.ascontiguousarray(points)
    # interior facet integrals (cross-section interfaces) need the neighbour's cells
    ghosts = _mesh.GhostMode.shared_facet
    if _OLD:
        domain = _mesh.create_mesh(comm, cells, points, element, ghosts)
    else:
        # from 0.11 on with the number of cells that share a facet
        shared = () if VERSION < (0, 11) else (2,)
        partitioner = _mesh.create_cell_partitioner(ghosts, *shared)
        domain = _mesh.create_mesh(comm, cells=cells, x=points, e=element, partitioner=partitioner)
    domain.topology.create_connectivity(dimension - 1, dimension)
    none = np.empty((0, facet_nodes), dtype=np.int64)
    facets = {}
    for name in names:
        own = interfaces.get(name, none)
        facets[name] = _tags(domain, dimension - 1, own, np.ones(len(own), dtype=np.int64))
    return domain, _tags(domain, dimension, cells, material), facets
