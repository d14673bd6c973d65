"""Mass moments of a beam model: rings that hold its mass, and how each family moves them.

A cross-section, a rider or a fillet acts as a thin ring of its radius of gyration, or as two of
them where it has an inertia along the axis; a plate as two rings at every radius. Sums over rings
are the inertia of the model itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.beam_level_elements import Stretch, beam_shapes
from solidwhirl.beam_level_fillets import Lump
from solidwhirl.beam_level_nodes import Layout
from solidwhirl.beam_level_planes import Family, Pieces, PlateBlock, lump_node
from solidwhirl.beam_level_radial import line_of, plate_center_m, wall_of
from solidwhirl.beam_level_reduce import FamilyMap, ReducedFamily
from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.circumference import products_around
from solidwhirl.rotordyn.mass_moments import MassMoments


class Rings(NamedTuple):
    """Rings and their motion in one family, in amplitudes of its circumferential order.

    `mass_kg`, `radius_m` and `place_m` have the shape (q,), `amplitudes` (3, q, m): radial,
    tangential and axial, per coordinate of the reduced family.
    """

    mass_kg: FloatArray
    radius_m: FloatArray
    place_m: FloatArray
    amplitudes: FloatArray


def family_rings(
    layout: Layout,
    pieces: Pieces,
    reduced: ReducedFamily,
    blocks: Sequence[PlateBlock],
    lumps: Sequence[Lump],
) -> Rings:
    """Return the rings of a beam model and how one family of motions moves them.

    Parameters
    ----------
    layout, pieces, lumps
        The model.
    reduced
        The family.
    blocks
        Its plates.

    Returns
    -------
    Rings
        The same rings in the same order for every family.
    """
    family, shapes = reduced.family, reduced.shapes
    parts = [
        _of_element(layout, k, piece, family, shapes) for k, piece in enumerate(pieces.stretches)
    ]
    carriers = sorted({rider.element for rider in pieces.riders})
    parts += [_of_riders(layout, pieces, k, family, shapes) for k in carriers]
    parts += [_of_lump(layout, lump, family, shapes) for lump in lumps]
    start = (2 if family == "lateral" else 1) * layout.nodes_m.size
    for index in range(len(layout.plate_nodes)):
        own = [block for block in blocks if block.plate == index]
        motions = []
        for block in own:
            edges = block.edges @ shapes[: block.edges.shape[1]]
            stop = start + block.extra
            motions.append(block.matrices.fields @ np.vstack((edges, shapes[start:stop])))
            start = stop
        parts.append(_of_plate(layout, index, family, motions))
    return Rings(
        np.concatenate([part.mass_kg for part in parts]),
        np.concatenate([part.radius_m for part in parts]),
        np.concatenate([part.place_m for part in parts]),
        np.concatenate([part.amplitudes for part in parts], axis=1),
    )


def beam_moments(
    families: Sequence[ReducedFamily], maps: Sequence[FamilyMap], rings: Sequence[Rings]
) -> MassMoments:
    """Return the mass moments of all coordinates.

    Parameters
    ----------
    families, maps, rings
        Reduced families of a body, their coordinates among those of the body, and their rings.
    """
    first = rings[0]
    zero = np.zeros_like(first.mass_kg)
    # the place itself, and the translation along the axis, as fields of order 0
    position = np.array([[first.radius_m, zero], [zero, zero], [first.place_m, zero + 1.0]])
    position = position.transpose(0, 2, 1)
    size = maps[0].in_x.shape[0]
    reference, second = np.zeros((3, 3, 2, size)), np.zeros((3, 3, size, size))
    around = [1 if family.family == "lateral" else 0 for family in families]
    spread = [m.in_x if m.in_y is None else np.hstack((m.in_x, m.in_y)) for m in maps]
    loads = [r.amplitudes * (first.mass_kg / (2.0 * np.pi))[:, None] for r in rings]
    for order, columns, load in zip(around, spread, loads, strict=True):
        reference += products_around(0, order, _products(position, load)) @ columns.T
        for other, rows, ring in zip(around, spread, rings, strict=True):
            products = products_around(other, order, _products(ring.amplitudes, load))
            second += rows @ products @ columns.T
    return MassMoments(
        displacement_kg=reference[2, :, 1], first_kg_m=reference[:, :, 0], second_kg=second
    )


def _products(left: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(left.transpose(0, 2, 1)[:, None] @ right)


def _at(nodes: Sequence[int], family: Family, shapes: FloatArray) -> FloatArray:
    """Rows of the coordinates of nodes."""
    per_node = 2 if family == "lateral" else 1
    return shapes[[per_node * node + k for node in nodes for k in range(per_node)]]


def _rings(
    mass_kg: FloatArray,
    radius_m: FloatArray,
    place_m: FloatArray,
    family: Family,
    moved: FloatArray,
    turned: FloatArray,
) -> Rings:
    """Rings that move and tilt rigidly; of order 0 the one motion, along the axis or about it."""
    amplitudes = np.zeros((3, *moved.shape))
    if family == "lateral":
        amplitudes[0], amplitudes[1], amplitudes[2] = moved, -moved, -radius_m[:, None] * turned
    elif family == "axial":
        amplitudes[2] = moved
    else:
        amplitudes[1] = radius_m[:, None] * moved
    return Rings(mass_kg, radius_m, place_m, amplitudes)


def _section(
    piece: Stretch, xi: FloatArray, arms_m: FloatArray, family: Family, ends: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Motion, at the ends of arms along the axis, and tilt of cross-sections of an element."""
    if family != "lateral":
        moved = np.column_stack((1.0 - xi, xi)) @ ends
        return moved, np.zeros_like(moved)
    deflection, slope = beam_shapes(piece, xi)
    return (deflection + arms_m[:, None] * slope) @ ends, slope @ ends


def _of_element(
    layout: Layout, index: int, piece: Stretch, family: Family, shapes: FloatArray
) -> Rings:
    element = layout.elements[index]
    xi = (piece.places_m - element.ends_m[0]) / piece.length_m
    mass = np.array([s.mass for s in piece.inertia])
    second = np.array([s.second for s in piece.inertia])
    moved = _section(piece, xi, np.zeros_like(xi), family, _at(element.nodes, family, shapes))
    radius = np.sqrt(2.0 * second / mass)
    return _rings(mass * piece.weights_m, radius, piece.places_m, family, *moved)


def _of_riders(
    layout: Layout, pieces: Pieces, index: int, family: Family, shapes: FloatArray
) -> Rings:
    element, piece = layout.elements[index], pieces.stretches[index]
    own = [rider for rider in pieces.riders if rider.element == index]
    mass, second, place, carrier = (
        np.array([getattr(rider, name) for rider in own])
        for name in ("mass_kg", "second_kg_m2", "z_m", "carrier_m")
    )
    xi = (carrier - element.ends_m[0]) / piece.length_m
    moved = _section(piece, xi, place - carrier, family, _at(element.nodes, family, shapes))
    return _rings(mass, np.sqrt(2.0 * second / mass), place, family, *moved)


def _of_lump(layout: Layout, lump: Lump, family: Family, shapes: FloatArray) -> Rings:
    """Two rings, apart as far as the inertia about a diameter asks for."""
    node = lump_node(layout, lump)
    apart = np.sqrt(max(lump.diametral_kg_m2 - 0.5 * lump.polar_kg_m2, 0.0) / lump.mass_kg)
    place = lump.z_m + np.array([-apart, apart])
    radius = np.full(2, np.sqrt(lump.polar_kg_m2 / lump.mass_kg))
    own = _at([node], family, shapes)
    if family == "lateral":
        moved = own[0] + np.outer(place - layout.nodes_m[node], own[1])
        turned = np.tile(own[1], (2, 1))
    else:
        moved = np.tile(own[0], (2, 1))
        turned = np.zeros_like(moved)
    return _rings(np.full(2, 0.5 * lump.mass_kg), radius, place, family, moved, turned)


def _of_plate(layout: Layout, index: int, family: Family, motions: list[FloatArray]) -> Rings:
    """Two rings at each radius; `motions` are values of the plate's fields at its own nodes."""
    plate = layout.skeleton.plates[index]
    line, center = line_of(plate.cells), plate_center_m(plate)
    walls = [wall_of(plate.cells[k], center) for k in line.cell]
    apart = np.sqrt([wall.rotary / wall.mass for wall in walls])[:, None]
    area = 2.0 * np.pi * line.radius * line.weight * np.array([wall.mass for wall in walls])
    values = [
        line.value @ field
        for motion in motions
        for field in motion.reshape(-1, line.value.shape[1], motion.shape[1])
    ]
    zero = np.zeros_like(values[0])
    if family == "lateral":
        deflection, radial, around, shift, across = values
    elif family == "axial":
        # the translation along the axis is ζ here, and −ζ in a tilt
        deflection, radial = -values[0], -values[1]
        around = shift = across = zero
    else:
        deflection = radial = around = shift = zero
        across = -values[0]
    sides = [(shift + x * radial, -(across + x * around), -deflection) for x in (-apart, apart)]
    return Rings(
        np.tile(0.5 * area, 2),
        np.tile(line.radius, 2),
        np.concatenate([center + x[:, 0] for x in (-apart, apart)]),
        np.concatenate([np.array(side) for side in sides], axis=1),
    )
