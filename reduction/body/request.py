"""What is asked of a reduction, and what is assembled for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody, MeshedBody, is_asymmetric
from solidwhirl.reduction.operators.matrices import BodyOperators, OperatorEffects, build_operators

_AXIAL = ("uz", "rz")


@dataclass(frozen=True, kw_only=True)
class ReductionRequest:
    """What a body's superelement has to hold."""

    level: str
    #: Circumferential orders, or cyclic indices of a sector: 1 lateral, 0 axial and torsional. They
    #: are solved one by one, but for the whole mesh of a solid, of whose modes they are kept. Empty
    #: for a solid of any shape, whose modes have no order.
    orders: tuple[int, ...]
    components: tuple[str, ...]  #: Interface coordinates, of ux, uy, uz, rx, ry, rz
    degree: int
    modes: int  #: Fixed-interface modes per order, pairs counted once
    maximum_speed_rad_s: float
    gyroscopic: bool
    centrifugal: bool
    #: Interfaces that carry fewer of them, by name; each costs a constraint mode
    interface_components: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    #: Speeds between rest and the top whose modes the basis takes in as well
    speeds_between_rad_s: tuple[float, ...] = ()
    #: Errors to estimate: "mode_truncation", and on the harmonic level "mesh", which compares with
    #: elements one order higher
    estimates: tuple[str, ...] = ()
    #: How systems of a whole mesh are solved: "direct", "iterative", or "auto": by the memory there
    #: is; those of sectors and meridians always directly
    solver: str = "auto"
    #: Of a body of joined parts: whether the orders next to 1 are taken in where they meet
    neighbours: bool = False
    #: Relative error of a frequency from which on static answers to the loads of
    #: the spin are in the basis (see `with_spin_answers`); 0: never
    spin_tolerance: float = 0.0
    #: Relative error of a frequency that the shape of a mesh taken as one of revolution may make
    accuracy: float = 1e-3


def shape_of(body: AnyBody) -> str:
    """Return what the reduction may assume of a solid, see `OperatorEffects.shape`."""
    if isinstance(body, MeshedBody):
        return body.request.shape
    return "asymmetric" if is_asymmetric(body) else "cyclic"


def solved_orders(body: AnyBody, request: ReductionRequest) -> tuple[int | None, ...]:
    """Return the orders or indices that are solved one by one; None is the whole solid."""
    whole = request.level == "solid" and shape_of(body) != "cyclic"
    return (None,) if whole else request.orders


def order_effects(body: AnyBody, request: ReductionRequest, order: int | None) -> OperatorEffects:
    """Return what is assembled for one circumferential order.

    `body`, `request`: the body and what its superelement has to hold. `order`: circumferential
    order; None for the solid. Axial motion and torsion live in order 0.
    """
    components = {}
    for interface in body.interfaces:
        carried = request.interface_components.get(interface.name, request.components)
        components[interface.name] = tuple(
            c
            for c in carried
            if c in request.components and (order is None or (c in _AXIAL) == (order == 0))
        )
    return OperatorEffects(
        gyroscopic=request.gyroscopic,
        centrifugal=request.centrifugal,
        components=components,
        shape=shape_of(body),
        solver=request.solver,
        neighbours=request.neighbours,
        maximum_speed_rad_s=request.maximum_speed_rad_s,
    )


def order_operators(
    body: AnyBody, mesh: Mesh | None, comm: Any, request: ReductionRequest, order: int | None
) -> BodyOperators:
    """Assemble the operators of one circumferential order; None: of the solid."""
    effects = order_effects(body, request, order)
    return build_operators(body, mesh, comm, order=order, degree=request.degree, effects=effects)
