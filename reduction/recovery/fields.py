"""The displacement fields behind the coordinates of a superelement, made again where asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.reduction.basis.reduced_block import ReducedBlock, joined_rows
from solidwhirl.reduction.body.reduced_order import reduce_order
from solidwhirl.reduction.body.request import ReductionRequest, order_operators, solved_orders
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.matrices import Ingredients
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.superelement.record import Superelement

# The same coordinates to rounding, and how far those of another machine may miss the space.
_SAME, _SAME_SPACE = 1e-9, 1e-5


@dataclass(frozen=True, kw_only=True, eq=False)
class OrderFields:
    """Fields of one circumferential order, or of the solid."""

    harmonic: int | None  #: Order, None for the solid
    #: Displacement space, and what the matrices were assembled from
    space: Any
    ingredients: Ingredients
    values: FloatArray  #: (unknowns of the space, n) fields of one family
    rows: IntArray  #: (m,) coordinates of the superelement, m = n times families
    signs: FloatArray
    order: IntArray

    def family_amplitudes(self, motion: NDArray[Any]) -> NDArray[Any]:
        """Return the amplitudes of the fields of each family, (families, n), for coordinates q."""
        own = np.zeros(len(self.signs), dtype=motion.dtype)
        own[self.order] = motion[self.rows]
        return (own * self.signs).reshape(-1, self.values.shape[1])


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyFields:
    """All fields of one body."""

    name: str
    materials: tuple[Any, ...]  #: Of the mesh, by number
    orders: tuple[OrderFields, ...]
    #: (n, n) takes coordinates of the superelement to those of the fields; None: they are one
    turn: FloatArray | None

    @property
    def is_averaged(self) -> bool:
        """Whether the superelement's matrices are means over turns, not those of the mesh.

        So it is with bodies of revolution on a mesh that no turn leaves as it is.
        """
        return any(order.ingredients.effects.shape == "round" for order in self.orders)

    def own_motion(self, motion: NDArray[Any]) -> NDArray[Any]:
        """Coordinates of the fields from those of the superelement."""
        return motion if self.turn is None else np.asarray(self.turn @ motion)


def body_fields(
    body: AnyBody, mesh: Mesh, request: ReductionRequest, element: Superelement
) -> BodyFields:
    """Reduce a body once more, in this process alone, and keep its fields.

    Raises ReductionError: the second reduction does not span the motions of the superelement.

    The answer of a reduction is the same to the last bit in the same process layout. With another
    number of ranks or another machine, modes of equal frequency may be mixed and signs exchanged:
    the fields' coordinates are then an orthogonal mixture of the superelement's (both are
    M-orthonormal), found from the displacement of its points (Schönemann 1966, Psychometrika 31).
    """
    points = element.recovery_points_m
    found: list[dict[str, Any]] = []
    blocks: list[ReducedBlock] = []
    for order in solved_orders(body, request):
        operators = order_operators(body, mesh, MPI.COMM_SELF, request, order)
        basis, block = reduce_order(operators, request, points)
        blocks.append(block)
        found.append(
            {
                "harmonic": order,
                "space": operators.space,
                "ingredients": operators.ingredients,
                "values": operators.coupling.unknowns.displacement(basis.vectors),
                "signs": block.signs,
                "order": block.order,
            }
        )
        basis.factor.destroy()
        operators.release()
    rows = joined_rows(body, blocks)
    if (size := sum(len(own) for own in rows)) != element.size:
        raise ReductionError(
            f"body {body.name!r}: the second reduction has {size} coordinates, the "
            f"superelement {element.size}"
        )
    again = np.zeros_like(element.recovery_modes)
    for own, block in zip(rows, blocks, strict=True):
        again[:, :, own] = block.recovery
    orders = tuple(OrderFields(**f, rows=own) for f, own in zip(found, rows, strict=True))
    _refuse_other_cells(body, orders)
    return BodyFields(
        name=body.name, materials=mesh.materials, orders=orders, turn=_turn(body, element, again)
    )


def _refuse_other_cells(body: AnyBody, orders: tuple[OrderFields, ...]) -> None:
    """All orders must number nodes and cells alike, as they are added up."""
    first, *others = (compat.curved_cells(order.space.mesh) for order in orders)
    for other in others:
        if not all(np.array_equal(a, b) for a, b in zip(first, other, strict=True)):
            raise ReductionError(f"body {body.name!r}: the orders number the mesh differently")


def _turn(body: AnyBody, element: Superelement, again: FloatArray) -> FloatArray | None:
    """Mixture of the modal coordinates between both reductions, None where there is none."""
    known = element.recovery_modes.reshape(-1, element.size)
    found = again.reshape(-1, element.size)
    scale = np.abs(known).max(axis=0, initial=1e-300)
    if (np.abs(found - known).max(axis=0, initial=0.0) <= _SAME * scale).all():
        return None
    modal = np.flatnonzero([c.kind == "modal" for c in element.coordinates])
    left, _, right = np.linalg.svd(found[:, modal].T @ known[:, modal])
    turn = np.eye(element.size)
    turn[np.ix_(modal, modal)] = left @ right
    if (np.abs(found @ turn - known).max(axis=0) > _SAME_SPACE * scale).any():
        raise ReductionError(
            f"body {body.name!r}: the second reduction does not span the motions of the "
            "superelement; remove the kept stages and run again"
        )
    return turn
