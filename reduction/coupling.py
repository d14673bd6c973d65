"""Interfaces: surfaces of the mesh tied to a master node, rigid or distributing.

*Rigid* (RBE2): the surface's nodes follow the master's six motions; adds stiffness.
*Distributing* (RBE3): the master follows the surface's displacement, fitted by least squares over
the area with a rigid motion; adds none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray
from petsc4py import PETSc

from solidwhirl.geometry import Interface
from solidwhirl.reduction import compat
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.kinematics import COMPONENTS, Kinematics

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Coupling:
    """Interface maps of a body.

    Attributes
    ----------
    transformation
        PETSc matrix T, u = T û: û holds the free unknowns and the rigid masters; None if there
        are no rigid interfaces.
    rows
        (local û, b) rows B of the interface coordinates q = B û.
    coordinates
        (interface, component) of every row.
    anchors
        (local û, a) rows of axial motion and torsion at the first interface that are no
        coordinates. Held at zero they cost no modes: in a body of revolution both decouple from
        lateral motion.
    """

    transformation: Any
    rows: FloatArray
    coordinates: tuple[tuple[str, str], ...]
    anchors: FloatArray


def motion_vectors(space: Any, kin: Kinematics, z0: float) -> dict[str, FloatArray]:
    """Nodal values (local rows) of the rigid motions about (0, 0, z0), by component.

    Rigid motions are linear in the coordinates, so the second-order elements hold them exactly.
    """
    x = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
    return {c: motion(x, z0).ravel() for c, motion in kin.rigid_motions.items()}


def rigid_motion_at(component: str, z_m: float) -> dict[str, float]:
    """Motion of the point (0, 0, z) for a unit rigid motion about the origin, by component."""
    out = {component: 1.0}
    if component == "rx":
        out["uy"] = -z_m
    if component == "ry":
        out["ux"] = z_m
    return out


def couple(
    space: Any,
    kin: Kinematics,
    facet_tags: dict[str, Any],
    interfaces: tuple[Interface, ...],
    components: tuple[str, ...],
) -> Coupling:
    """Build the interface maps.

    Parameters
    ----------
    space
        Displacement space.
    kin
        Kinematics on its mesh.
    facet_tags
        Tags of the interfaces' facets, by name.
    interfaces
        The interfaces, in the order of their coordinates.
    components
        Which of the kinematics' components become coordinates.

    Raises
    ------
    ReductionError
        Two rigid interfaces share nodes.
    """
    wanted = [c for c in COMPONENTS if c in components and c in kin.rigid_motions]
    rigid = [i for i in interfaces if i.coupling == "rigid"]
    transformation = _rigid_transformation(space, kin, facet_tags, rigid) if rigid else None
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    columns, anchors = [], []
    for interface in interfaces:
        if interface.coupling == "rigid":
            first = (rigid.index(interface) - len(rigid)) * len(motions)
            maps = {c: _unit_from_end(transformation, first + k) for k, c in enumerate(motions)}
        else:
            means = _mean_motions(space, kin, facet_tags[interface.name], interface)
            maps = {c: _restrict(transformation, means[c]) for c in motions}
        columns += [maps[c] for c in wanted]
        if interface is interfaces[0]:
            anchors = [maps[c] for c in ("uz", "rz") if c in maps and c not in wanted]
    local = space.dofmap.index_map.size_local * space.dofmap.index_map_bs
    if transformation is not None:
        local = transformation.getLocalSize()[1]
    none = np.empty((local, 0))
    return Coupling(
        transformation=transformation,
        rows=np.column_stack(columns) if columns else none,
        coordinates=tuple((i.name, c) for i in interfaces for c in wanted),
        anchors=np.column_stack(anchors) if anchors else none,
    )


def reduced_motion(
    space: Any,
    kin: Kinematics,
    coupling: Coupling,
    interfaces: tuple[Interface, ...],
    component: str,
) -> FloatArray:
    """Rigid motion about the origin in the unknowns û (local rows)."""
    values = motion_vectors(space, kin, 0.0)[component]
    if coupling.transformation is None:
        return values
    kept = _kept_rows(coupling.transformation)
    out = np.zeros(coupling.transformation.getLocalSize()[1])
    out[: len(kept)] = values[kept]
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    masters = []
    for interface in (i for i in interfaces if i.coupling == "rigid"):
        at = rigid_motion_at(component, interface.position_m[2])
        masters += [at.get(c, 0.0) for c in motions]
    if len(out) > len(kept):  # the last rank holds the masters
        out[len(kept) :] = masters
    return out


def _mean_motions(
    space: Any, kin: Kinematics, tags: Any, interface: Interface
) -> dict[str, FloatArray]:
    """Rows W of the least-squares rigid motion of a surface about its master node."""
    comm = space.mesh.comm
    motions = motion_vectors(space, kin, float(interface.position_m[2]))
    field = fem.Function(space)
    vector = compat.petsc_vector(field)
    moment_form = compat.compiled(_on_surface(space, tags, field, kin.weight))
    moments = {}
    for c, values in motions.items():
        vector.array[:] = values
        field.x.scatter_forward()
        moments[c] = compat.assemble_vector(moment_form).array.copy()
    names = list(motions)
    gram = np.array([[comm.allreduce(motions[b] @ moments[a]) for b in names] for a in names])
    if np.linalg.cond(gram / np.sqrt(np.outer(np.diag(gram), np.diag(gram)))) > 1e12:
        raise ReductionError(
            f"interface {interface.name!r}: its surface does not determine a rigid motion"
        )
    rows = np.linalg.solve(gram, np.array([moments[c] for c in names]))
    return dict(zip(names, rows, strict=True))


def _on_surface(space: Any, tags: Any, field: Any, weight: Any) -> Any:
    """∫ field·v over tagged facets, whether they lie on the boundary or inside the body."""
    degree = {"quadrature_degree": 6}
    domain = space.mesh
    ds = ufl.Measure("ds", domain=domain, subdomain_data=tags, metadata=degree)
    inside = ufl.Measure("dS", domain=domain, subdomain_data=tags, metadata=degree)
    integrand = ufl.inner(field, ufl.TestFunction(space)) * weight
    return integrand * ds(1) + ufl.avg(integrand) * inside(1)


def _rigid_transformation(
    space: Any, kin: Kinematics, facet_tags: dict[str, Any], rigid: list[Interface]
) -> Any:
    """T: surface nodes of rigid interfaces follow their masters, all others stay."""
    index_map, bs = space.dofmap.index_map, space.dofmap.index_map_bs
    comm, n_local = space.mesh.comm, index_map.size_local * bs
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    owner = np.full(n_local, -1)
    follow = np.zeros((n_local, len(motions)))
    for k, interface in enumerate(rigid):
        tags = facet_tags[interface.name]
        blocks = fem.locate_dofs_topological(space, tags.dim, tags.indices)
        blocks = blocks[blocks < index_map.size_local]
        dofs = (blocks[:, None] * bs + np.arange(bs)).ravel()
        shared = np.flatnonzero(owner[dofs] >= 0)
        if comm.allreduce(len(shared)):
            raise ReductionError(f"rigid interface {interface.name!r} shares nodes with another")
        values = motion_vectors(space, kin, float(interface.position_m[2]))
        owner[dofs] = k
        follow[dofs] = np.column_stack([values[c] for c in motions])[dofs]
    kept = np.flatnonzero(owner < 0)
    start = comm.scan(len(kept)) - len(kept)
    total_kept = comm.allreduce(len(kept))
    masters = len(rigid) * len(motions)
    counts = np.where(owner < 0, 1, len(motions))
    indptr = np.concatenate([[0], np.cumsum(counts)])
    indices, data = np.empty(indptr[-1], dtype=PETSc.IntType), np.empty(indptr[-1])
    indices[indptr[kept]], data[indptr[kept]] = start + np.arange(len(kept)), 1.0
    for i in np.flatnonzero(owner >= 0):
        span = slice(indptr[i], indptr[i + 1])
        indices[span] = total_kept + owner[i] * len(motions) + np.arange(len(motions))
        data[span] = follow[i]
    columns = len(kept) + (masters if comm.rank == comm.size - 1 else 0)
    out = PETSc.Mat().createAIJ(
        size=((n_local, index_map.size_global * bs), (columns, total_kept + masters)),
        csr=(indptr.astype(PETSc.IntType), indices, data),
        comm=comm,
    )
    out.assemble()
    return out


def _kept_rows(transformation: Any) -> NDArray[np.int64]:
    """Local rows that T leaves as they are, in order."""
    indptr, _, data = transformation.getValuesCSR()
    singles = np.flatnonzero(np.diff(indptr) == 1)
    return np.asarray(singles[data[indptr[singles]] == 1.0])


def _unit_from_end(transformation: Any, offset: int) -> FloatArray:
    """Unit vector of a master; offset counts from the end (-1 is the last)."""
    comm = transformation.comm.tompi4py()
    out = np.zeros(transformation.getLocalSize()[1])
    if comm.rank == comm.size - 1:
        out[offset] = 1.0
    return out


def _restrict(transformation: Any, values: FloatArray) -> FloatArray:
    """Tᵀ values."""
    if transformation is None:
        return values
    x, y = transformation.createVecLeft(), transformation.createVecRight()
    x.array[:] = values
    transformation.multTranspose(x, y)
    return np.asarray(y.array_r.copy())
