"""What is asked of a reduction, and one circumferential order of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from solidwhirl.meshing.user_mesh_records import AnyBody
from solidwhirl.reduction.craig_bampton import Basis, reduction_basis
from solidwhirl.reduction.mesh_bodies import shape_of
from solidwhirl.reduction.operators import BodyOperators, OperatorEffects
from solidwhirl.reduction.pairing import paired
from solidwhirl.reduction.superelements import ReducedBlock, reduce_block

FloatArray = NDArray[np.float64]
_AXIAL = ("uz", "rz")


@dataclass(frozen=True, kw_only=True)
class ReductionRequest:
    """What a body's superelement has to hold.

    Attributes
    ----------
    level
        "harmonic" or "solid".
    orders
        Circumferential orders: 1 lateral, 0 axial and torsional (solid: which modes are kept;
        harmonic: which problems are solved; others than 0 and 1 load no interface). Empty for a
        solid of any shape, whose modes have no order.
    components
        Interface coordinates, of ux, uy, uz, rx, ry, rz.
    interface_components
        Interfaces that carry fewer of them, by name; each costs a constraint mode.
    degree
        Polynomial degree of the displacement.
    modes
        Fixed-interface modes per order, pairs counted once.
    maximum_speed_rad_s
        Largest speed of this body.
    gyroscopic, centrifugal
        Effects that are assembled.
    speeds_between_rad_s
        Speeds between rest and the top whose modes the basis takes in as well.
    estimates
        Errors to estimate: "mode_truncation", and on the harmonic level "mesh", which compares
        with elements one order higher.
    solver
        How systems of a solid are solved: "direct", "iterative", or "auto": by the memory there is.
    """

    level: str
    orders: tuple[int, ...]
    components: tuple[str, ...]
    degree: int
    modes: int
    maximum_speed_rad_s: float
    gyroscopic: bool
    centrifugal: bool
    interface_components: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    speeds_between_rad_s: tuple[float, ...] = ()
    estimates: tuple[str, ...] = ()
    solver: str = "auto"


def order_effects(body: AnyBody, request: ReductionRequest, order: int | None) -> OperatorEffects:
    """Return what is assembled for one circumferential order.

    Parameters
    ----------
    body, request
        The body and what its superelement has to hold.
    order
        Circumferential order; None for the solid. Axial motion and torsion live in order 0.
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
        lateral_only=request.orders == (1,) and shape_of(body) == "quartered",
        shape=shape_of(body),
        solver=request.solver,
    )


def reduce_order(
    operators: BodyOperators, request: ReductionRequest, points: FloatArray
) -> tuple[Basis, ReducedBlock]:
    """Return the basis of one order, and what it makes of the operators.

    Parameters
    ----------
    operators
        Of the order.
    request
        What the superelement has to hold.
    points
        Recovery points, (m, 3) [m].

    Raises
    ------
    ReductionError
        See `reduction_basis`.
    """
    basis = reduction_basis(
        operators,
        modes=request.modes if request.orders else 2 * request.modes,
        maximum_speed_rad_s=request.maximum_speed_rad_s,
        orders=request.orders,
        speeds_between_rad_s=request.speeds_between_rad_s,
    )
    if operators.ingredients.effects.shape == "round":
        basis = paired(operators, basis, request.orders)
    return basis, reduce_block(operators, basis, points)
