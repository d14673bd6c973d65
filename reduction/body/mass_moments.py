"""Mass moments of the reduced coordinates: integrals of products of displacement fields.

The mass matrix acts on the components of a displacement alike and does not mix them, so that of
one component, applied to the nodal values of all fields, gives every integral. On the meridian
the products of two circumferential orders are integrated over θ in closed form.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.reduced_block import ReducedBlock
from solidwhirl.reduction.operators.cyclic import CyclicIndex
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.solvers.vectors import apply
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.superelement.circumferential_orders import products_around
from solidwhirl.rotordyn.superelement.mass_moments import MassMoments

# Products of two fields of orders 0 and 1 with two Cartesian components change by no more than
# the order 4 in a turn, so that a mean over this many turns has what no turn changes alone.
_TURNS = 5


@dataclass(frozen=True, kw_only=True, eq=False)
class OrderFields:
    """Displacement of one circumferential order, or cyclic index, on the nodes of its mesh."""

    order: int
    places_m: FloatArray  #: (local nodes, 2) z and r, or (local nodes, 3)
    #: Three (local nodes, k): those of a, b and c, of one family, or of x, y, z for all amplitudes
    #: of a sector, whose mirror image follows it
    amplitudes: tuple[FloatArray, ...]
    #: How the block's coordinates came from those of both families: sign, then order
    signs: FloatArray
    rows: IntArray
    #: (k, k) change of a sector's amplitudes in a small turn
    generator: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class BlockMoments:
    """Mass moments of one reduced block, in its coordinates."""

    own: MassMoments
    #: ∫ φ_aj φ_bk dm of j in each earlier block and k in this one, (3, 3, n earlier, n)
    across_kg: tuple[FloatArray, ...]
    fields: OrderFields | None  #: For the blocks that follow; None on the solid, which is one block


def block_moments(
    operators: BodyOperators, basis: Basis, block: ReducedBlock, earlier: Sequence[BlockMoments]
) -> BlockMoments:
    """Integrate the fields of one circumferential order, or of the solid, over the mass."""
    if operators.ingredients.kinematics.cyclic is not None:
        return _sector_moments(operators, basis, block, earlier)
    signs, order = block.signs, block.order
    fields = _components(operators, basis.vectors)
    loads = tuple(apply(operators.ingredients.component_mass, field) for field in fields)
    if operators.harmonic is None:
        moments = _in_coordinates(_of_solid(operators, fields, loads), signs, order)
        if block.generator is not None:
            moments = evenly_turned_moments(moments, block.generator, _TURNS)
        return BlockMoments(own=moments, across_kg=(), fields=None)
    angle = np.pi * (2.0 if operators.families == 1 else 1.0)
    loads = tuple(load / angle for load in loads)
    here = OrderFields(
        order=operators.harmonic,
        places_m=_places(operators)[:, :2].copy(),
        amplitudes=fields,
        signs=signs,
        rows=order,
    )
    comm = operators.comm
    return BlockMoments(
        own=_in_coordinates(_of_order(here, loads, comm), signs, order),
        across_kg=tuple(
            _across(other.fields, here, loads, comm)
            for other in earlier
            if other.fields is not None
        ),
        fields=here,
    )


def joined_moments(blocks: Sequence[BlockMoments], order: IntArray) -> MassMoments:
    """Put the moments of all blocks of a body together.

    `order`: (n,) of the superelement's coordinates among those of the blocks.
    """
    sizes = [block.own.displacement_kg.shape[1] for block in blocks]
    starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
    second = np.zeros((3, 3, starts[-1], starts[-1]))
    for k, block in enumerate(blocks):
        here = slice(starts[k], starts[k + 1])
        second[:, :, here, here] = block.own.second_kg
        for j, across in enumerate(block.across_kg):
            there = slice(starts[j], starts[j + 1])
            second[:, :, there, here] = across
            second[:, :, here, there] = across.transpose(1, 0, 3, 2)
    return MassMoments(
        displacement_kg=np.hstack([b.own.displacement_kg for b in blocks])[:, order],
        first_kg_m=np.concatenate([b.own.first_kg_m for b in blocks], axis=2)[:, :, order],
        second_kg=second[:, :, order][..., order],
    )


def evenly_turned_moments(moments: MassMoments, generator: FloatArray, turns: int) -> MassMoments:
    """Return the mean of moments over turns about the axis.

    `moments`: of n coordinates of orders 0 and 1. `generator`: (n, n) L with entries -1, 0, 1.
    `turns`: how many of them make a full circle.

    A turn of the field by α takes q to (1 + sin α L + (1 - cos α) L²) q and turns both directions
    of the moments. The mean over five turns, of a body of revolution, is what every turn leaves as
    it is; the sum of the second moments of x, y and z is then that of the evenly turned mass.
    """
    simple, first, second = (np.zeros_like(a) for a in _arrays(moments))
    for turn, change in _changes(generator, turns):
        simple += np.einsum("bd,bj->dj", turn, moments.displacement_kg @ change)
        first += np.einsum("ac,bd,abj->cdj", turn, turn, moments.first_kg_m @ change)
        second += _turned_second(turn, change, moments.second_kg, change)
    return MassMoments(
        displacement_kg=simple / turns, first_kg_m=first / turns, second_kg=second / turns
    )


def _changes(generator: FloatArray, turns: int) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Turns of directions, and the change of coordinates with each."""
    for angle in 2.0 * np.pi * np.arange(turns) / turns:
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        yield turn, np.eye(len(generator)) + sin * generator + (1.0 - cos) * generator @ generator


def _turned_second(
    turn: FloatArray, left: FloatArray, second: FloatArray, right: FloatArray
) -> FloatArray:
    both = left.T @ second @ right
    return np.asarray(np.einsum("ac,bd,abjk->cdjk", turn, turn, both, optimize=True))


def _sector_moments(
    operators: BodyOperators, basis: Basis, block: ReducedBlock, earlier: Sequence[BlockMoments]
) -> BlockMoments:
    """Moments of one cyclic index: of the mesh and its mirror image, turned to all sectors."""
    cyclic = operators.ingredients.kinematics.cyclic
    assert cyclic is not None
    fields, places = _on_sector(operators, basis.vectors, cyclic)
    share = cyclic.sector.count / cyclic.weight
    parts = 2 if cyclic.sector.mirrored else 1
    mass = operators.ingredients.component_mass
    loads = tuple(
        share * np.vstack([apply(mass, np.asfortranarray(part)) for part in np.split(f, parts)])
        for f in fields
    )
    n = basis.vectors.shape[1]
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]]) if operators.families == 2 else np.zeros((1, 1))
    here = OrderFields(
        order=cyclic.index,
        places_m=places,
        amplitudes=fields,
        signs=block.signs,
        rows=block.order,
        generator=np.kron(quarter, np.eye(n)),
    )
    comm, turns = operators.comm, min(cyclic.sector.count, _TURNS)
    reference = _products(_with_axial_motion(*places.T), loads, comm)
    moments = _moments(reference, _products(fields, loads, comm))
    assert here.generator is not None
    even = evenly_turned_moments(moments, here.generator, turns)
    return BlockMoments(
        own=_in_coordinates(even, here.signs, here.rows),
        across_kg=tuple(
            _across_sectors(other.fields, here, loads, turns, comm)
            for other in earlier
            if other.fields is not None
        ),
        fields=here,
    )


def _on_sector(
    operators: BodyOperators, vectors: Matrix, cyclic: CyclicIndex
) -> tuple[tuple[FloatArray, ...], FloatArray]:
    """Displacement by component for real amplitudes, and places, of the mesh and its image."""
    full = operators.coupling.unknowns.displacement(vectors)
    x = _places(operators)
    moved, places = [], []
    for mirrored in (False, True) if cyclic.sector.mirrored else (False,):
        image = np.array([1.0, -1.0, 1.0]) if mirrored else np.ones(3)
        own = np.tile(image, len(x))[:, None] * (full.conj() if mirrored else full)
        both = own.real + own.imag if cyclic.is_real else np.hstack([own.real, own.imag])
        moved.append(both)
        places.append(x * image)
    stacked = np.vstack(moved)
    return tuple(np.asfortranarray(stacked[i::3]) for i in range(3)), np.vstack(places)


def _across_sectors(
    other: OrderFields, here: OrderFields, loads: tuple[FloatArray, ...], turns: int, comm: Any
) -> FloatArray:
    """Second moments of the amplitudes of an earlier index with those of this one."""
    assert other.generator is not None
    assert here.generator is not None
    left = amplitudes_at(other, here.places_m, comm)
    raw = _products(left, loads, comm)
    changes = zip(_changes(other.generator, turns), _changes(here.generator, turns), strict=True)
    second = sum(_turned_second(turn, own, raw, new) for (turn, own), (_, new) in changes) / turns
    return np.asarray(
        (second * np.outer(other.signs, here.signs))[:, :, other.rows][..., here.rows]
    )


def amplitudes_at(fields: OrderFields, places_m: FloatArray, comm: Any) -> tuple[FloatArray, ...]:
    """Return the amplitudes of one order at the nodes of another, on the same meridian.

    `places_m`: (local nodes, 2) z and r of the nodes of the second, which another distribution of
    the mesh may number differently.
    """
    if comm.allreduce(int(not np.array_equal(fields.places_m, places_m))) == 0:
        return fields.amplitudes
    there = comm.gather((fields.places_m, np.stack(fields.amplitudes)), root=0)
    here = comm.gather(places_m, root=0)
    parts = None
    if comm.rank == 0:
        tree = cKDTree(np.vstack([places for places, _ in there]))
        values = np.concatenate([amplitudes for _, amplitudes in there], axis=1)
        parts = [values[:, tree.query(places)[1]] for places in here]
    return tuple(comm.scatter(parts, root=0))


def _places(operators: BodyOperators) -> FloatArray:
    """Places of the local nodes, (nodes, 3)."""
    count = operators.space.dofmap.index_map.size_local
    return np.asarray(operators.space.tabulate_dof_coordinates()[:count])


def _components(operators: BodyOperators, block: FloatArray) -> tuple[FloatArray, ...]:
    """The three components of û at the local nodes, each (nodes, k) and stored by columns."""
    full = operators.coupling.unknowns.displacement(block)
    return tuple(np.asfortranarray(full[i::3]) for i in range(3))


def _with_axial_motion(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, ...]:
    """The place itself as a field, and beside it the translation along z, by component."""
    zero = np.zeros_like(z)
    return tuple(np.column_stack(pair) for pair in ((x, zero), (y, zero), (z, zero + 1.0)))


def _products(left: Sequence[FloatArray], loads: Sequence[FloatArray], comm: Any) -> FloatArray:
    """Products of every component on the left with every load, (3, 3, k, m)."""
    local = np.array([[field.T @ load for load in loads] for field in left])
    return np.asarray(comm.allreduce(local))


def _of_solid(
    operators: BodyOperators, fields: tuple[FloatArray, ...], loads: tuple[FloatArray, ...]
) -> MassMoments:
    """Moments of the fields as they are on the mesh."""
    position = _with_axial_motion(*_places(operators).T)
    reference = _products(position, loads, operators.comm)
    second = _products(fields, loads, operators.comm)
    return _moments(reference, second)


def _of_order(here: OrderFields, loads: tuple[FloatArray, ...], comm: Any) -> MassMoments:
    """Moments of both families of one circumferential order."""
    z, r = here.places_m.T
    position = _with_axial_motion(r, np.zeros_like(r), z)
    return _moments(
        products_around(0, here.order, _products(position, loads, comm)),
        products_around(here.order, here.order, _products(here.amplitudes, loads, comm)),
    )


def _across(
    other: OrderFields, here: OrderFields, loads: tuple[FloatArray, ...], comm: Any
) -> FloatArray:
    """Second moments of the coordinates of an earlier order with those of this one."""
    left = amplitudes_at(other, here.places_m, comm)
    second = products_around(other.order, here.order, _products(left, loads, comm))
    return (second * np.outer(other.signs, here.signs))[:, :, other.rows][..., here.rows]


def _moments(reference: FloatArray, second: FloatArray) -> MassMoments:
    """Moments from the products with the place and with the translation along z."""
    return MassMoments(
        displacement_kg=reference[2, :, 1], first_kg_m=reference[:, :, 0], second_kg=second
    )


def _in_coordinates(moments: MassMoments, signs: FloatArray, order: IntArray) -> MassMoments:
    """Moments of coordinates whose sign and then order is changed."""
    simple, first, second = _arrays(moments)
    return MassMoments(
        displacement_kg=(simple * signs)[:, order],
        first_kg_m=(first * signs)[:, :, order],
        second_kg=(second * np.outer(signs, signs))[:, :, order][..., order],
    )


def _arrays(moments: MassMoments) -> tuple[FloatArray, FloatArray, FloatArray]:
    return moments.displacement_kg, moments.first_kg_m, moments.second_kg
