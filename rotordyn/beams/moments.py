"""Mass moments of a beam model: rings that hold its mass, and how each family moves them.

A cross-section acts as a thin ring of its radius of gyration at each Gauss point, so that sums over
rings are the inertia of the model itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.beams.elements import Family, Segment, section_motion
from solidwhirl.rotordyn.beams.families import Attached, ReducedFamily, family_maps, node_rows
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.circumferential_orders import products_around
from solidwhirl.rotordyn.superelement.mass_moments import MassMoments


class Rings(NamedTuple):
    """Rings and their motion in one family, in amplitudes of its circumferential order.

    `mass_kg`, `radius_m` and `place_m` have the shape (q,), `amplitudes` (3, q, m): radial,
    tangential and axial, per coordinate of the reduced family.
    """

    mass_kg: FloatArray
    radius_m: FloatArray
    place_m: FloatArray
    amplitudes: FloatArray


def joined_rings(parts: Iterable[Rings]) -> Rings:
    """Return all rings in one record."""
    mass, radius, place, amplitudes = zip(*parts, strict=True)
    flat = (np.concatenate(part) for part in (mass, radius, place))
    return Rings._make([*flat, np.concatenate(amplitudes, axis=1)])


def rigid_rings(
    rings: tuple[FloatArray, FloatArray, FloatArray],
    family: Family,
    moved: FloatArray,
    tilted: FloatArray,
) -> Rings:
    """Return rings that move and tilt rigidly; of order 0 along the axis or about it.

    `rings`: mass, radius of gyration and place, shape (q,) each; `moved`, `tilted`: deflection,
    axial displacement or twist, and tilt, shape (q, m).
    """
    radius = rings[1][:, None]
    amplitudes = np.zeros((3, *moved.shape))
    if family == "lateral":
        amplitudes[0], amplitudes[1], amplitudes[2] = moved, -moved, -radius * tilted
    elif family == "axial":
        amplitudes[2] = moved
    else:
        amplitudes[1] = radius * moved
    return Rings(*rings, amplitudes)


def segment_rings(piece: Segment, nodes: tuple[int, int], reduced: ReducedFamily) -> Rings:
    """Return the rings of a beam between two nodes."""
    xi = (piece.places_m - piece.start_m) / piece.length_m
    ends = reduced.shapes[node_rows(nodes, reduced.family)]
    moved, tilted = section_motion(piece, xi, reduced.family)
    radius = np.sqrt(2.0 * piece.second / piece.mass)
    rings = (piece.mass * piece.weights_m, radius, piece.places_m)
    return rigid_rings(rings, reduced.family, moved @ ends, tilted @ ends)


def attached_rings(part: Attached, z_m: FloatArray, reduced: ReducedFamily) -> Rings:
    """Return rings with the inertia of a rigid ring, also of one without mass or length.

    Its length, ∫x² dm, is that of a pair on both sides of the centre, whose mass the centre lacks.
    """
    along = part.diametral_kg_m2 - 0.5 * part.polar_kg_m2
    own = part.mass_kg or 1.0
    reach = float(np.sqrt(abs(along) / own)) or 1.0
    side = 0.5 * along / reach**2
    mass = np.array([part.mass_kg - own - 2.0 * side, own, side, side])
    radius = np.array([0.0, np.sqrt(part.polar_kg_m2 / own), 0.0, 0.0])
    place = part.z_m + np.array([0.0, 0.0, -reach, reach])
    first, *rest = reduced.shapes[node_rows([part.node], reduced.family)]
    tilt = rest[0] if rest else np.zeros_like(first)
    moved = first + np.outer(place - z_m[part.node], tilt)
    return rigid_rings((mass, radius, place), reduced.family, moved, np.tile(tilt, (4, 1)))


def beam_moments(
    interfaces: Sequence[str], families: Sequence[ReducedFamily], rings: Sequence[Rings]
) -> MassMoments:
    """Return the mass moments of all coordinates."""
    first = rings[0]
    zero = np.zeros_like(first.mass_kg)
    # the place itself, and the translation along the axis, as fields of order 0
    position = np.array([[first.radius_m, zero], [zero, zero], [first.place_m, zero + 1.0]])
    position = position.transpose(0, 2, 1)
    around = [1 if family.family == "lateral" else 0 for family in families]
    spread = [np.hstack(planes) for planes in family_maps(interfaces, families)]
    size = len(spread[0])
    reference, second = np.zeros((3, 3, 2, size)), np.zeros((3, 3, size, size))
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
