"""Interfaces: surfaces of the mesh tied to a master node, rigid or distributing.

*Rigid* (RBE2): the surface's nodes follow the master's six motions; adds stiffness.
*Distributing* (RBE3): the master follows the surface's displacement, fitted by least squares over
the area with a rigid motion; adds none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from solidwhirl.meshing.imported.records import AnyInterface
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.dofs import motion_vectors, node_of, unknowns_transformation
from solidwhirl.reduction.operators.kinematics import COMPONENTS, Kinematics
from solidwhirl.reduction.solvers.vectors import apply, apply_transposed
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray

# Rows of two interfaces that differ by less, relative to their length, are rounding apart.
_EQUAL_ROWS = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class Coupling:
    """Interface maps of a body."""

    #: PETSc matrix T, u = T û: û holds the unknowns that are free (of one sector, if symmetry is
    #: used) and the rigid masters; None if that is all of u
    transformation: Any
    kept: IntArray  #: Local unknowns of u that û holds, in û's order; rigid masters come after them
    rows: FloatArray  #: (local û, b) rows B of the interface coordinates q = B û
    coordinates: tuple[tuple[str, str], ...]  #: (interface, component) of every row
    #: (local û, a) rows of axial motion and torsion at the first interface that are no coordinates.
    #: Held at zero they cost no modes: in a body of revolution both decouple from lateral motion.
    anchors: FloatArray

    @property
    def held(self) -> FloatArray:
        """Rows that the interfaces and the anchors hold, (local û, b + a)."""
        return np.hstack([self.rows, self.anchors])

    def displacement(self, block: FloatArray) -> FloatArray:
        """Displacement u = T û of every column, (local u, k)."""
        return block if self.transformation is None else apply(self.transformation, block)


def rigid_motion_at(component: str, place_m: tuple[float, float, float]) -> dict[str, float]:
    """Motion of a point for a unit rigid motion about the origin, by component."""
    x, y, z = place_m
    moved = {"rx": {"uy": -z, "uz": y}, "ry": {"ux": z, "uz": -x}, "rz": {"ux": -y, "uy": x}}
    return {component: 1.0, **moved.get(component, {})}


def couple(
    space: Any,
    kin: Kinematics,
    facet_tags: dict[str, Any],
    interfaces: tuple[AnyInterface, ...],
    components: Mapping[str, tuple[str, ...]],
    shape: str = "quartered",
) -> Coupling:
    """Build the interface maps.

    `interfaces`: the interfaces, in the order of their coordinates. `components`: which of the
    kinematics' components become coordinates, by interface. `shape`: as in `OperatorEffects`; in a
    body of any shape axial motion and torsion couple to lateral motion, and nothing is held that is
    no coordinate. Raises ReductionError: two rigid interfaces share nodes.
    """
    wanted = {
        i.name: [c for c in COMPONENTS if c in components[i.name] and c in kin.rigid_motions]
        for i in interfaces
    }
    coordinates = tuple((i.name, c) for i in interfaces for c in wanted[i.name])
    carried = {c for _, c in coordinates}
    rigid = [i for i in interfaces if i.coupling == "rigid"]
    transformation, kept = unknowns_transformation(space, kin, facet_tags, rigid)
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    columns, anchors = [], []
    for interface in interfaces:
        if interface.coupling == "rigid":
            first = (rigid.index(interface) - len(rigid)) * len(motions)
            maps = {c: _unit_from_end(transformation, first + k) for k, c in enumerate(motions)}
        else:
            means = _mean_motions(space, kin, facet_tags[interface.name], interface)
            maps = {c: _restrict(transformation, means[c]) for c in motions}
        columns += [maps[c] for c in wanted[interface.name]]
        if interface is interfaces[0] and shape != "any":
            anchors = [maps[c] for c in ("uz", "rz") if c in maps and c not in carried]
    local = space.dofmap.index_map.size_local * space.dofmap.index_map_bs
    if transformation is not None:
        local = transformation.getLocalSize()[1]
    none = np.empty((local, 0))
    rows = np.column_stack(columns) if columns else none
    _refuse_equal(rows, coordinates, space.mesh.comm)
    return Coupling(
        transformation=transformation,
        kept=kept,
        rows=rows,
        coordinates=coordinates,
        anchors=np.column_stack(anchors) if anchors else none,
    )


def _refuse_equal(rows: FloatArray, coordinates: tuple[tuple[str, str], ...], comm: Any) -> None:
    """Two interfaces at one place have the same coordinates twice."""
    gram = np.asarray(comm.allreduce(rows.T @ rows))
    length = np.sqrt(np.diag(gram))
    for j, (interface, component) in enumerate(coordinates):
        for i in range(j):
            other, same = coordinates[i]
            if component != same or length[i] == 0.0 or length[j] == 0.0:
                continue
            apart = comm.allreduce(np.sum((rows[:, i] / length[i] - rows[:, j] / length[j]) ** 2))
            if apart < _EQUAL_ROWS**2:
                raise ReductionError(
                    f"interfaces {other!r} and {interface!r} are at one place on the mesh and "
                    f"move as one ({component}); keep one of them, or move them apart"
                )


def reduced_motion(
    space: Any,
    kin: Kinematics,
    coupling: Coupling,
    interfaces: tuple[AnyInterface, ...],
    component: str,
) -> FloatArray:
    """Rigid motion about the origin in the unknowns û (local rows)."""
    values = motion_vectors(space, kin, 0.0)[component]
    if coupling.transformation is None:
        return values
    kept = coupling.kept
    out = np.zeros(coupling.transformation.getLocalSize()[1])
    out[: len(kept)] = values[kept]
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    masters = []
    for interface in (i for i in interfaces if i.coupling == "rigid"):
        at = rigid_motion_at(component, interface.position_m)
        masters += [at.get(c, 0.0) for c in motions]
    if len(out) > len(kept):  # the last rank holds the masters
        out[len(kept) :] = masters
    return out


def _mean_motions(
    space: Any, kin: Kinematics, tags: Any, interface: AnyInterface
) -> dict[str, FloatArray]:
    """Rows W of the least-squares rigid motion of a surface about its master node."""
    comm = space.mesh.comm
    motions = motion_vectors(space, kin, node_of(interface))
    field = fem.Function(space)
    own = compat.owned_values(field)
    moment_form = compat.compiled(_on_surface(space, tags, field, kin.weight))
    moments = {}
    for c, values in motions.items():
        own[:] = values
        field.x.scatter_forward()
        moments[c] = compat.assembled_vector(moment_form)
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
    return apply_transposed(transformation, values[:, None])[:, 0]
