"""Recovered fields in space: meridians and sectors turned about the axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.meshing.own.quality import doubled_areas
from solidwhirl.reduction.recovery.sectors import turned
from solidwhirl.reduction.recovery.stresses import FieldPoints, FieldTerm, RecoveredFields
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.superelement.surface import around_axis, family_factors

# VTK's numbers of cells.
_TETRAHEDRON, _WEDGE, _PYRAMID, _QUADRATIC_TETRAHEDRON = 10, 13, 14, 24
# Linear triangles of a second-order one, dolfinx's order of nodes; VTK's order of a tetrahedron.
_PARTS = ((0, 5, 4), (5, 1, 3), (4, 3, 2), (5, 3, 4))
_VTK_TETRAHEDRON = [0, 1, 2, 3, 9, 6, 8, 7, 5, 4]
# A point lies on the axis below this part of the largest radius.
_ON_AXIS = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class SpatialFields:
    """One body in one state, in space."""

    #: (P, 3); a point of a meridian stands once for every half plane, of a sector for every copy
    points_m: FloatArray
    #: (P,) point of `FieldPoints` and the angle that each is turned by
    point: IntArray
    theta_rad: FloatArray
    material: IntArray  #: (P,) number of the material
    #: VTK's number of a kind of cell, and points of such cells
    cells: tuple[tuple[int, IntArray], ...]
    #: (P, 3) and (P, 6) along and about x, y, z; xx, yy, zz, xy, yz, xz. Real or complex.
    displacement_m: NDArray[Any]
    stress_pa: NDArray[Any]
    #: Of the centrifugal load, None where it was not computed
    steady_displacement_m: FloatArray | None
    steady_stress_pa: FloatArray | None


def in_space(found: RecoveredFields, sectors: int) -> SpatialFields:
    """Return the fields of a body in space.

    `sectors`: half planes around the circumference of a meridian; of no effect on a solid.
    """
    points = found.points
    flat = points.points_m.shape[1] == 2
    theta = points.theta_rad(sectors)
    moved, stress = values_at(found.terms, points, theta)
    steady = None if found.steady is None else values_at((found.steady,), points, theta)
    count = len(points.points_m)
    return SpatialFields(
        points_m=places(points.points_m, theta).reshape(-1, 3),
        point=np.tile(np.arange(count), len(theta)),
        theta_rad=np.repeat(theta, count),
        material=np.tile(points.point_material, len(theta)),
        cells=_wedges(points, sectors) if flat else _tetrahedra(points),
        displacement_m=moved.reshape(-1, 3),
        stress_pa=stress.reshape(-1, 6),
        steady_displacement_m=None if steady is None else steady[0].reshape(-1, 3),
        steady_stress_pa=None if steady is None else steady[1].reshape(-1, 6),
    )


def values_at(
    terms: Sequence[FieldTerm], points: FieldPoints, theta: FloatArray, kept: IntArray | None = None
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return displacement (s, p, 3) and stress (s, p, 6) along x, y, z at angles of a meridian.

    `terms`, `points`: of one body; no terms are fields of zeros. `theta`: (s,) angles; of a solid
    those that copies of the sector are turned by, of a whole one 0. `kept`: points that are wanted;
    None: all.
    """
    own = np.arange(len(points.points_m)) if kept is None else kept
    moved: Any = np.zeros((len(theta), len(own), 3))
    stress: Any = np.zeros((len(theta), len(own), 6))
    for term in terms:
        u, s = term.displacement_m[own], term.stress_pa[own]
        if points.points_m.shape[1] == 2:
            moved = moved + around_axis(u, term.order, term.family, theta)
            stress = stress + _tensors_around(s, term.order, term.family, theta)
            continue
        factor = (np.cos, np.sin)[term.family](term.order * theta)[:, None, None]
        moved = moved + factor * turned(u, theta)
        stress = stress + factor * turned(s, theta)
    return moved, stress


def _tensors_around(
    stress: NDArray[Any], order: int, family: int, theta: FloatArray
) -> NDArray[Any]:
    """Cartesian stress (s, p, 6) from rr, θθ, zz, rθ, θz, rz of one term."""
    along, across = (f[:, None, None] for f in family_factors(order, family, theta))
    shear = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    same = along * turned(stress * (1.0 - shear), theta)
    return np.asarray(same + across * turned(stress * shear, theta))


def places(points_m: FloatArray, theta: FloatArray) -> FloatArray:
    """Return points of a meridian (p, 2) or of a sector (p, 3) at some angles, (s, p, 3)."""
    if points_m.shape[1] == 2:
        z, r = points_m.T
        points_m = np.column_stack([r, np.zeros(len(r)), z])
    return turned(points_m, theta)


def _tetrahedra(points: FieldPoints) -> tuple[tuple[int, IntArray], ...]:
    cells = points.cells[:, _VTK_TETRAHEDRON]
    copies = [cells + k * len(points.points_m) for k in range(points.copies)]
    return ((_QUADRATIC_TETRAHEDRON, np.concatenate(copies)),)


def _wedges(points: FieldPoints, sectors: int) -> tuple[tuple[int, IntArray], ...]:
    """Linear wedges between half planes; on the axis pyramids and tetrahedra.

    A point on the axis is that of the first half plane in all cells beside it.
    """
    z, r = points.points_m.T
    axis = r <= _ON_AXIS * r.max()
    triangles = np.concatenate([points.cells[:, list(part)] for part in _PARTS])
    area = doubled_areas(points.points_m[triangles])
    triangles[area < 0.0] = triangles[area < 0.0][:, [0, 2, 1]]
    on = axis[triangles].sum(axis=1)
    count, number = len(z), np.arange(sectors)[:, None]
    here, there = number * count, (number + 1) % sectors * count

    def turned(nodes: IntArray, start: IntArray) -> IntArray:
        return np.where(axis[nodes], nodes, nodes + start)

    def cells(chosen: IntArray, nodes: Sequence[tuple[int, bool]]) -> IntArray:
        rows = [turned(chosen[:, k], there if far else here) for k, far in nodes]
        return np.stack(rows, axis=2).reshape(-1, len(rows))

    one = _axis_first(triangles[on == 1], axis)
    two = _axis_last(triangles[on == 2], axis)
    wedge = [(0, False), (1, False), (2, False), (0, True), (1, True), (2, True)]
    found = (
        (_WEDGE, cells(triangles[on == 0], wedge)),
        (_PYRAMID, cells(one, [(1, False), (1, True), (2, True), (2, False), (0, False)])),
        (_TETRAHEDRON, cells(two, [(0, False), (1, False), (2, False), (0, True)])),
    )
    return tuple((kind, rows) for kind, rows in found if len(rows))


def _axis_first(triangles: IntArray, axis: BoolArray) -> IntArray:
    """Triangles with one corner on the axis, turned so that it is the first."""
    at = axis[triangles].argmax(axis=1)
    return np.asarray(np.take_along_axis(triangles, (at[:, None] + np.arange(3)) % 3, axis=1))


def _axis_last(triangles: IntArray, axis: BoolArray) -> IntArray:
    """Triangles with two corners on the axis, turned so that they are the last."""
    at = (~axis[triangles]).argmax(axis=1)
    return np.asarray(np.take_along_axis(triangles, (at[:, None] + np.arange(3)) % 3, axis=1))
