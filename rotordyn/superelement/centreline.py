"""Where the axis of a body is, and how it moves: from recovery points or interface nodes."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.superelement.circumferential_orders import body_turns
from solidwhirl.rotordyn.superelement.record import Superelement

# Points closer than this fraction of the body's size are at one place.
_SAME_PLACE = 1e-6
# A circle is a rim, not the axis, if circles smaller by this factor lie on both sides of it, not
# farther than this fraction of the length.
_LARGER = 1.05
_NEAR = 0.1


class Centreline(NamedTuple):
    """Points along the axis of one body, rising, ux and uy there per coordinate, (p, 2, n)."""

    axial_m: FloatArray
    modes: FloatArray


class InterfaceRows(NamedTuple):
    """Interface nodes that can move across the axis, and ux, uy per coordinate, (i, 2, n)."""

    names: tuple[str, ...]
    axial_m: FloatArray
    modes: FloatArray


@lru_cache(maxsize=8)  # an element is a record that never changes
def centreline_motion(element: Superelement) -> Centreline:
    """Return the lateral motion of the axis of a body from its recovery points.

    Points on the axis where the body has such; else, at each place along the axis, the mean of the
    points on the smallest circle, without those of rims round a shaft, whose webs and drums have a
    motion of their own. Interface nodes if there are no such points.

    Lateral motion of a ring is that of its centre plus ovalling, e^{2iθ}; the mean over points
    is that of the centre where the sum of e^{2iθ} over them vanishes, as for 0° and 90°. Other
    circles are left out. Where the body knows its spin generator, everything but lateral motion
    is taken out first, as radial growth or disk modes would spoil the mean.
    """
    places, modes, radii = _rings(element)
    kept = ~_is_outside(places, radii)
    places, modes = places[kept], modes[kept]
    if not places.size:
        nodes = interface_rows(element)
        places, modes = nodes.axial_m, nodes.modes
    turns = body_turns(element)
    if turns is not None:
        modes = modes @ turns.lateral()
    for array in (places, modes):
        array.setflags(write=False)
    return Centreline(places, modes)


def _rings(element: Superelement) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return place, motion and radius of the smallest usable circle at each place."""
    points, modes = element.recovery_points_m, element.recovery_modes
    if not len(points):
        return np.empty(0), np.empty((0, 2, element.size)), np.empty(0)
    radius = np.hypot(points[:, 0], points[:, 1])
    near = _SAME_PLACE * max(float(np.ptp(points[:, 2])), float(radius.max()))
    order = np.lexsort((radius, points[:, 2]))
    places, rows, radii, start = [], [], [], 0
    for stop in range(1, order.size + 1):
        if stop < order.size and points[order[stop], 2] - points[order[start], 2] <= near:
            continue
        ring = _smallest_ring(points, radius, order[start:stop], near)
        if ring.size:
            places.append(points[ring, 2].mean())
            rows.append(modes[ring, :2].mean(axis=0))
            radii.append(radius[ring[0]])
        start = stop
    return np.array(places), np.array(rows).reshape(-1, 2, element.size), np.array(radii)


def _is_outside(places: FloatArray, radii: FloatArray) -> BoolArray:
    """Whether a circle has smaller ones near on both sides, as a rim round a shaft has."""
    near = _NEAR * float(np.ptp(places)) if places.size else 0.0
    outside = np.zeros(places.size, dtype=bool)
    for k, (place, radius) in enumerate(zip(places, radii, strict=True)):
        small = places[(np.abs(places - place) <= near) & (radii < radius / _LARGER)]
        outside[k] = (small < place).any() and (small > place).any()
    return outside


def _smallest_ring(
    points: FloatArray, radius: FloatArray, candidates: IntArray, near: float
) -> IntArray:
    """Return the points of one plane on the smallest circle whose mean is the centre's motion."""
    left = candidates[np.argsort(radius[candidates], kind="stable")]
    while left.size:
        ring = left[radius[left] <= radius[left[0]] + near]
        left = left[ring.size :]
        if radius[ring[0]] <= near:
            return np.asarray(ring)
        doubled = ((points[ring, 0] + 1j * points[ring, 1]) / radius[ring]) ** 2
        if abs(doubled.sum()) <= _SAME_PLACE * ring.size:
            return np.asarray(ring)
    return np.empty(0, dtype=int)


def interface_rows(element: Superelement) -> InterfaceRows:
    """Return the lateral motion of the interface nodes of a body.

    The result is of the nodes that have ux or uy, in their order along the axis.
    """
    nodes = [
        node
        for node in sorted(element.interfaces, key=lambda node: float(node.position_m[2]))
        if {"ux", "uy"} & set(element.components_at(node.name))
    ]
    modes = np.zeros((len(nodes), 2, element.size))
    for k, node in enumerate(nodes):
        for at, component in enumerate(("ux", "uy")):
            if component in element.components_at(node.name):
                modes[k, at, element.interface_index(node.name, component)] = 1.0
    return InterfaceRows(
        tuple(node.name for node in nodes),
        np.array([float(node.position_m[2]) for node in nodes]),
        modes,
    )
