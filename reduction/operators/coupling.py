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
from solidwhirl.reduction.operators.dofs import Unknowns, body_unknowns, motion_vectors, node_of
from solidwhirl.reduction.operators.kinematics import COMPONENTS, Kinematics
from solidwhirl.reduction.solvers.vectors import squares
from solidwhirl.rotordyn.core.arrays import Matrix

# Rows of two interfaces that differ by less, relative to their length, are rounding apart.
_EQUAL_ROWS = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class Coupling:
    """Interface maps of a body."""

    unknowns: Unknowns  #: û, and the displacement u = T û
    rows: Matrix  #: (local û, b) rows B of the interface coordinates q = Bᴴ û
    coordinates: tuple[tuple[str, str], ...]  #: (interface, component) of every row
    #: (local û, a) rows of axial motion and torsion at the first interface where neither is a
    #: coordinate. Held at zero they cost no modes: in a body of revolution both decouple from
    #: lateral motion. Where one of them is a coordinate the other is free.
    anchors: Matrix
    #: Rigid motions about the origin by component, local rows of û
    rigid_motions: Mapping[str, Matrix]

    @property
    def held(self) -> Matrix:
        """Rows that the interfaces and the anchors hold, (local û, b + a)."""
        return np.hstack([self.rows, self.anchors])


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
    body that is not the same in all directions axial motion and torsion couple to lateral motion,
    and nothing is held that is no coordinate. Raises ReductionError: two rigid interfaces share
    nodes.
    """
    wanted = {
        i.name: [c for c in COMPONENTS if c in components[i.name] and c in kin.rigid_motions]
        for i in interfaces
    }
    coordinates = tuple((i.name, c) for i in interfaces for c in wanted[i.name])
    turns_even = shape not in ("any", "asymmetric")
    anchored = turns_even and not any(c in ("uz", "rz") for _, c in coordinates)
    rigid = [i for i in interfaces if i.coupling == "rigid"]
    unknowns = body_unknowns(space, kin, facet_tags, rigid)
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    none: Matrix = np.empty((unknowns.count, 0), dtype=unknowns.dtype)
    columns, anchors = [none], [none]
    for interface in interfaces:
        if interface.coupling == "rigid":
            first = (rigid.index(interface) - len(rigid)) * len(motions)
            maps = {c: _unit_from_end(unknowns, first + k) for k, c in enumerate(motions)}
        else:
            means = _mean_motions(space, kin, facet_tags[interface.name], interface)
            maps = {c: unknowns.loads(means[c][:, None]) for c in motions}
        columns += [maps[c] for c in wanted[interface.name]]
        if interface is interfaces[0] and anchored:
            anchors += [maps[c] for c in ("uz", "rz") if c in maps]
    rows = np.hstack(columns)
    _refuse_equal(rows, coordinates, space.mesh.comm)
    return Coupling(
        unknowns=unknowns,
        rows=rows,
        coordinates=coordinates,
        anchors=np.hstack(anchors),
        rigid_motions={
            c: _rigid_motion(space, kin, unknowns, interfaces, c) for c in kin.rigid_motions
        },
    )


def _refuse_equal(rows: Matrix, coordinates: tuple[tuple[str, str], ...], comm: Any) -> None:
    """Two interfaces at one place have the same coordinates twice."""
    length = np.sqrt(squares(rows, rows, comm))
    for j, (interface, component) in enumerate(coordinates):
        for i in range(j):
            other, same = coordinates[i]
            if component != same or length[i] == 0.0 or length[j] == 0.0:
                continue
            apart = rows[:, i] / length[i] - rows[:, j] / length[j]
            if comm.allreduce(float(np.vdot(apart, apart).real)) < _EQUAL_ROWS**2:
                raise ReductionError(
                    f"interfaces {other!r} and {interface!r} are at one place on the mesh and "
                    f"move as one ({component}); keep one of them, or move them apart"
                )


def _rigid_motion(
    space: Any,
    kin: Kinematics,
    unknowns: Unknowns,
    interfaces: tuple[AnyInterface, ...],
    component: str,
) -> Matrix:
    """Rigid motion about the origin in the unknowns û (local rows)."""
    values = motion_vectors(space, kin, 0.0)[component]
    out: Matrix = np.zeros(unknowns.count, dtype=unknowns.dtype)
    own = unknowns.of_motion(kin, component, values)
    out[: len(own)] = own
    motions = [c for c in COMPONENTS if c in kin.rigid_motions]
    masters = []
    for interface in (i for i in interfaces if i.coupling == "rigid"):
        at = rigid_motion_at(component, interface.position_m)
        masters += [at.get(c, 0.0) for c in motions]
    if unknowns.masters:  # on the last rank
        out[len(own) :] = masters
    return out


def _mean_motions(
    space: Any, kin: Kinematics, tags: Any, interface: AnyInterface
) -> dict[str, Matrix]:
    """Rows W of the least-squares rigid motion of a surface about its master node."""
    comm = space.mesh.comm
    motions = motion_vectors(space, kin, node_of(interface))
    moment = _Moment(space, tags, kin.weight)
    moments = {c: moment.of(values) for c, values in motions.items()}
    names = list(motions)
    gram = np.array(
        [[comm.allreduce(np.vdot(motions[a], moments[b])) for b in names] for a in names]
    )
    size = np.sqrt(np.diag(gram).real)
    if np.linalg.cond(gram / np.outer(size, size)) > 1e12:
        raise ReductionError(
            f"interface {interface.name!r}: its surface does not determine a rigid motion"
        )
    rows = np.linalg.solve(gram.conj(), np.array([moments[c] for c in names]))
    return dict(zip(names, rows, strict=True))


class _Moment:
    """∫ field·v over tagged facets for fields that may be complex."""

    def __init__(self, space: Any, tags: Any, weight: Any) -> None:
        self._field = fem.Function(space)
        self._form = compat.compiled(_on_surface(space, tags, self._field, weight))

    def of(self, values: Matrix) -> Matrix:
        """Local rows of the integral of a field."""
        if np.iscomplexobj(values):
            return np.asarray(self.of(values.real) + 1j * self.of(values.imag))
        compat.owned_values(self._field)[:] = values
        self._field.x.scatter_forward()
        return np.asarray(compat.assembled_vector(self._form))


def _on_surface(space: Any, tags: Any, field: Any, weight: Any) -> Any:
    """∫ field·v over tagged facets, whether they lie on the boundary or inside the body."""
    degree = {"quadrature_degree": 6}
    domain = space.mesh
    ds = ufl.Measure("ds", domain=domain, subdomain_data=tags, metadata=degree)
    inside = ufl.Measure("dS", domain=domain, subdomain_data=tags, metadata=degree)
    integrand = ufl.inner(field, ufl.TestFunction(space)) * weight
    return integrand * ds(1) + ufl.avg(integrand) * inside(1)


def _unit_from_end(unknowns: Unknowns, offset: int) -> Matrix:
    """Unit vector of a master, (local û, 1); offset counts from the end (-1 is the last)."""
    out: Matrix = np.zeros((unknowns.count, 1), dtype=unknowns.dtype)
    if unknowns.masters:
        out[offset] = 1.0
    return out
