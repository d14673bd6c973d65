"""The outer surface of a body and its displacement per coordinate, for pictures of modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix, real_times
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.superelement.validation import finite_array

GROUP = "surface"
KINDS = ("meridian", "solid", "sector")
# Circumferential orders are small; more would only be a damaged number.
_HIGHEST_ORDER = 1000
# Copies of a sector are points and faces in memory.
_MOST_COPIES = 10_000
# Mirror image of a vector in the plane y = 0.
_MIRROR = np.array([1.0, -1.0, 1.0])
# A point of a meridian lies on the axis below this part of the largest radius.
_ON_AXIS = 1e-9


class Faces(NamedTuple):
    """Points (p, 3) of a surface, its quadrangles (c, 4) and its triangles (c, 3)."""

    points_m: FloatArray
    quadrangles: IntArray
    triangles: IntArray


@dataclass(frozen=True, kw_only=True)
class Copies:
    """How a solid is made of its sector: `count` N of copies, each turned by 2π/N about z.

    `mirrored`: what is copied is half a sector and its mirror image in the plane y = 0.
    `angle_rad`: what the first copy is turned by.
    """

    count: int
    mirrored: bool
    angle_rad: float = 0.0

    @property
    def theta_rad(self) -> FloatArray:
        """What the copies are turned by."""
        return self.angle_rad + angles(self.count)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Surface:
    """Hold points of a body's surface and how they move with its coordinates.

    The displacement is a sum of t terms, each with the amplitude of one coordinate. On a meridian
    a term of order n moves the ring of a point by, for the family 0,
    (a cos nθ, b sin nθ, c cos nθ) along r, θ, z, for the family 1 (a sin nθ, −b cos nθ, c sin nθ);
    for n = 0 by (a, b, c). So the surface is known at every θ. Of a solid the terms are
    displacements along x, y, z. Of a sector they are complex fields Φ of the cyclic index h along
    x, y, z, which move the copy k, turned by θ = 2πk/N and the angle of the first one, by
    R(θ) Re[e^{ihθ} Φ] in the family 0, by R(θ) Im[e^{ihθ} Φ] in the family 1; for h = 0 by R(θ)
    (Re Φ + Im Φ). On the mirror image of half a sector Φ is the mirror image of its conjugate.

    Raises SuperelementError if shapes disagree, a number is not finite, or a number points to
    nothing.

    `points_m`: (z, r) of a meridian, shape (p, 2), or (x, y, z) of a solid, shape (p, 3), m.
    `cells`: edges of a meridian's outline, shape (c, 2), or triangles of a solid, shape (c, 3).
    `amplitudes`: a, b, c, or ux, uy, uz, of the points per unit coordinate, shape (p, 3, t),
    complex of a sector; those of a solid and of a sector are rounded to single precision.
    `coordinate`: coordinate of every term, shape (t,).
    `order`, `family`: n or h, and 0 or 1, of every term, shape (t,); zeros for a solid.
    `size`: number of coordinates of the body.
    `copies`: of a sector; None of a meridian and of a whole solid.
    """

    points_m: FloatArray
    cells: IntArray
    amplitudes: Matrix
    coordinate: IntArray
    order: IntArray
    family: IntArray
    size: int
    copies: Copies | None = None

    def __post_init__(self) -> None:
        dimension = np.shape(self.points_m)[1] if np.ndim(self.points_m) == 2 else 2
        if dimension not in (2, 3) or (dimension == 2 and self.copies is not None):
            allowed = "2 (meridian) or 3 (solid)" if self.copies is None else "3 (sector)"
            raise SuperelementError(
                f"surface: points_m has {dimension} columns; {allowed} are allowed"
            )
        if self.copies is not None and not 0 < self.copies.count <= _MOST_COPIES:
            raise SuperelementError(
                f"surface: copies are {self.copies.count}; 1 to {_MOST_COPIES} are allowed"
            )
        if self.copies is not None and not np.isfinite(self.copies.angle_rad):
            raise SuperelementError(f"surface: the angle of copies is {self.copies.angle_rad}")
        points = finite_array(GROUP, "points_m", self.points_m, (None, dimension))
        if dimension == 2 and (points[:, 1] < 0.0).any():
            raise SuperelementError("surface: points_m has a negative radius")
        coordinate = _wholes("coordinate", self.coordinate, (None,), self.size)
        terms = len(coordinate)
        shape = (len(points), 3, terms)
        moved: Matrix = _finite_parts(self.amplitudes, shape, dimension == 3, self.copies)
        object.__setattr__(self, "points_m", points)
        object.__setattr__(self, "amplitudes", moved)
        object.__setattr__(self, "coordinate", coordinate)
        cells = _wholes("cells", self.cells, (None, dimension), len(points))
        object.__setattr__(self, "cells", cells)
        highest = 1 if self.kind == "solid" else _HIGHEST_ORDER
        object.__setattr__(self, "order", _wholes("order", self.order, (terms,), highest))
        object.__setattr__(self, "family", _wholes("family", self.family, (terms,), 2))

    @property
    def kind(self) -> str:
        """What the points are of: "meridian", "solid" or "sector"."""
        if self.copies is not None:
            return "sector"
        return "meridian" if self.points_m.shape[1] == 2 else "solid"

    def of_coordinates(self, kept: npt.ArrayLike) -> Surface:
        """Return the surface in other coordinates: of each the one here, or −1 (moves nothing)."""
        own: IntArray = np.asarray(kept, dtype=np.int64)
        place = np.full(self.size, -1)
        place[own[own >= 0]] = np.flatnonzero(own >= 0)
        there = place[self.coordinate] >= 0
        return replace(
            self,
            amplitudes=self.amplitudes[:, :, there],
            coordinate=place[self.coordinate[there]],
            order=self.order[there],
            family=self.family[there],
            size=len(own),
        )

    def faces(self, sectors: int) -> Faces:
        """Return the surface in space.

        `sectors`: points around the circumference of a meridian; of no effect on others. Points of
        a meridian by angle, then as in `points_m`; those on the axis stand once for every angle,
        the faces beside them are triangles. Points of a sector by copy, then as in `points_m`,
        then those of its mirror image; points that two copies share stand twice.
        """
        none = np.empty((0, 4), dtype=np.int64)
        if self.kind == "solid":
            return Faces(self.points_m, none, self.cells)
        if self.copies is not None:
            whole, cells = _all_copies(self.points_m, self.cells, self.copies)
            return Faces(whole, none, cells)
        z, r = self.points_m.T
        theta = angles(sectors)
        around = (np.outer(np.cos(theta), r), np.outer(np.sin(theta), r))
        points = np.stack([*around, np.broadcast_to(z, around[0].shape)], axis=2)
        count, number = len(z), np.arange(sectors)[:, None]
        here, there = number * count, (number + 1) % sectors * count
        on_axis = r <= _ON_AXIS * float(r.max(initial=0.0))
        first, second = self.cells.T
        quads = np.stack([here + first, here + second, there + second, there + first], axis=2)
        sort = on_axis[first].astype(int) + 2 * on_axis[second]
        triangles = [quads[:, sort == 1][..., [1, 2, 0]], quads[:, sort == 2][..., [3, 0, 1]]]
        return Faces(
            points.reshape(-1, 3),
            quads[:, sort == 0].reshape(-1, 4),
            np.concatenate([t.reshape(-1, 3) for t in triangles]),
        )

    def displacement(self, motion: npt.ArrayLike, sectors: int) -> Matrix:
        """Return the displacement of the points of `faces`, (p, 3), complex as the motion (n,)."""
        q = np.asarray(motion)[self.coordinate]
        if self.kind == "solid":
            return moved_by(self.amplitudes, q)
        around = sectors if self.copies is None else self.copies.count * (1 + self.copies.mirrored)
        total: Any = 0.0
        for order in np.unique(self.order):
            for family in (0, 1):
                own = (self.order == order) & (self.family == family) & (q != 0.0)
                if not own.any():
                    continue
                kept = self.amplitudes[:, :, own]
                if self.copies is None:
                    moved = around_axis(kept @ q[own], int(order), family, angles(sectors))
                else:
                    parts = kept.real @ q[own], kept.imag @ q[own]
                    moved = around_sectors(parts, int(order), family, self.copies)
                total = total + moved
        if np.ndim(total) == 0:
            return np.zeros((around * len(self.points_m), 3), dtype=q.dtype)
        return np.asarray(total.reshape(-1, 3))

    def as_solid(self, points: IntArray, cells: IntArray) -> Surface:
        """Return some points of `faces` as the surface of a whole solid, from that of a sector.

        `points`: which of them, shape (p,); `cells`: triangles between those, shape (c, 3).
        """
        copies = self.copies
        assert copies is not None
        copy, rest = np.divmod(points, len(self.points_m) * (1 + copies.mirrored))
        image, own = np.divmod(rest, len(self.points_m))
        turn, amplitudes = copies.theta_rad[copy], self.amplitudes[own]
        is_image = (image == 1)[:, None, None]
        real = amplitudes.real * np.where(is_image, _MIRROR[:, None], 1.0)
        imaginary = amplitudes.imag * np.where(is_image, -_MIRROR[:, None], 1.0)
        moving = np.unique(self.coordinate)
        fields = np.zeros((len(points), 3, len(moving)))
        for order, family in {*zip(self.order.tolist(), self.family.tolist(), strict=True)}:
            terms = np.flatnonzero((self.order == order) & (self.family == family))
            parts = real[:, :, terms], imaginary[:, :, terms]
            moved = _of_copies(parts, order, family, (copies, turn[:, None, None]))
            fields += moved @ (self.coordinate[terms][:, None] == moving).astype(float)
        none = np.zeros(len(moving), dtype=np.int64)
        return Surface(
            points_m=self.faces(0).points_m[points],
            cells=cells,
            amplitudes=turns(turn) @ fields,
            coordinate=moving,
            order=none,
            family=none,
            size=self.size,
        )


def moved_by(amplitudes: Matrix, motion: Matrix) -> Matrix:
    """Return the sum of real fields (p, 3, t) times a motion (t,), complex as that."""
    if np.iscomplexobj(amplitudes) or not np.iscomplexobj(motion):
        return np.asarray(amplitudes @ motion)
    return real_times(amplitudes.reshape(-1, motion.size), motion[:, None]).reshape(-1, 3)


def angles(sectors: int) -> FloatArray:
    """Return θ of evenly spaced half planes, from 0."""
    return np.asarray(2.0 * np.pi * np.arange(sectors) / sectors)


def around_axis(amplitudes: Matrix, order: int, family: int, theta: FloatArray) -> Matrix:
    """Return the Cartesian displacement of rings from their amplitudes.

    `amplitudes`: (a, b, c) of the points of a meridian, shape (p, 3), real or complex; `order`,
    `family`: circumferential order, and 0 for the cos or 1 for the sin family. Returns shape (s, p,
    3).
    """
    along, across = family_factors(order, family, theta)
    a, b, c = (amplitudes[None, :, k] for k in range(3))
    radial, tangential = along[:, None] * a, across[:, None] * b
    cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
    moved = [radial * cos - tangential * sin, radial * sin + tangential * cos]
    return np.stack([*moved, along[:, None] * c], axis=2)


def around_sectors(parts: tuple[Matrix, Matrix], index: int, family: int, copies: Copies) -> Matrix:
    """Return the Cartesian displacement of all copies of a sector from a field on it.

    `parts`: Σ q Re Φ and Σ q Im Φ of the points of the sector, each (p, 3), real or complex;
    `index`: cyclic index h; `family`: 0 or 1. Returns shape (copies, p, 3), p twice with mirror
    images (Thomas 1979, Int. J. Numer. Methods Eng. 14, 81-102).
    """
    real, imaginary = parts
    if copies.mirrored:
        real = np.concatenate([real, real * _MIRROR])
        imaginary = np.concatenate([imaginary, -imaginary * _MIRROR])
    turn = copies.theta_rad
    moved = _of_copies((real, imaginary), index, family, (copies, turn[:, None, None]))
    return np.asarray(np.einsum("kij,kpj->kpi", turns(turn), moved))


def _of_copies(
    parts: tuple[Matrix, Matrix], index: int, family: int, at: tuple[Copies, FloatArray]
) -> Matrix:
    """Return a field in the axes of copies, before these are turned.

    `parts`, `index`, `family`: as of `around_sectors`, mirrored already; `at`: the copies, and the
    angle of each.
    """
    (real, imaginary), (copies, turn) = parts, at
    cos, sin = np.cos(index * turn), np.sin(index * turn)
    if 2 * index % copies.count == 0:  # the field is real
        return np.asarray(cos * (real + imaginary))
    if family == 0:
        return np.asarray(cos * real - sin * imaginary)
    return np.asarray(sin * real + cos * imaginary)


def turns(angle: FloatArray) -> FloatArray:
    """Return turns about z by some angles (k,), shape (k, 3, 3)."""
    cos, sin, zero, one = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    rows = [[cos, -sin, zero], [sin, cos, zero], [zero, zero, one]]
    return np.moveaxis(np.array(rows), 2, 0)


def _all_copies(points: FloatArray, cells: IntArray, copies: Copies) -> tuple[FloatArray, IntArray]:
    """Points and triangles of a whole solid from those of a sector, or of half of one."""
    if copies.mirrored:  # a mirror image turns normals inward
        cells = np.concatenate([cells, cells[:, ::-1] + len(points)])
        points = np.concatenate([points, points * _MIRROR])
    around = np.einsum("kij,pj->kpi", turns(copies.theta_rad), points)
    number = np.arange(copies.count)[:, None, None] * len(points)
    return around.reshape(-1, 3), (number + cells).reshape(-1, 3)


def family_factors(order: int, family: int, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factors of what is along r and z, and of what is along θ, at some angles."""
    if order == 0:
        return np.ones_like(theta), np.ones_like(theta)
    cos, sin = np.cos(order * theta), np.sin(order * theta)
    return (cos, sin) if family == 0 else (sin, -cos)


def beam_surface(
    nodes_m: FloatArray,
    outer_radius_m: FloatArray,
    inner_radius_m: FloatArray,
    planes: tuple[FloatArray, FloatArray],
    axial: FloatArray | None = None,
    torsion: FloatArray | None = None,
) -> Surface:
    """Return the surface of a shaft whose cross-sections stay plane and round.

    `nodes_m`: places along the axis, rising, shape (N,), m; `outer_radius_m`, `inner_radius_m`: of
    the elements between them, shape (N − 1,), m. `planes`: deflection and slope w1, θ1, w2, ... of
    the nodes in the planes of x and of y per unit coordinate, each (2N, n); (w, θ) = (ux, ry) and
    (uy, −rx). `axial`, `torsion`: uz and rz of the nodes per unit coordinate, shape (N, n); None:
    zero. A meridian; terms that move nothing are left out.
    """
    corner, edges = _sections(outer_radius_m, inner_radius_m)
    node = corner[:, 0].astype(np.int64)
    return plane_sections(
        np.column_stack([nodes_m[node], corner[:, 1]]),
        edges,
        [(plane[0::2][node], plane[1::2][node]) for plane in planes],
        None if axial is None else axial[node],
        None if torsion is None else torsion[node],
    )


def plane_sections(
    points_m: FloatArray,
    edges: IntArray,
    planes: Sequence[tuple[FloatArray, FloatArray]],
    axial: FloatArray | None = None,
    torsion: FloatArray | None = None,
) -> Surface:
    """Return a meridian whose cross-sections stay plane and square to a bent axis.

    `points_m`: (z, r), shape (p, 2), m; `edges`: of the outline, shape (c, 2); `planes`: deflection
    and slope of the axis at the place of each point in the planes of x and of y per unit
    coordinate, each (p, n); (w, θ) = (ux, ry) and (uy, −rx); `axial`, `torsion`: uz and rz there,
    shape (p, n); None: zero.
    """
    radius = points_m[:, 1, None]
    still = np.zeros((len(points_m), planes[0][0].shape[1]))
    terms: list[tuple[int, int, int]] = []
    columns: list[FloatArray] = []
    for family, (w, slope) in enumerate(planes):
        # plane sections: a slope lowers the side that the deflection points to
        _add_terms(terms, columns, 1, family, [w, -w, -radius * slope])
    around = still if torsion is None else radius * torsion
    _add_terms(terms, columns, 0, 0, [still, around, still if axial is None else axial])
    coordinate, order, family_of = np.array(terms, dtype=np.int64).reshape(-1, 3).T
    return Surface(
        points_m=points_m,
        cells=edges,
        amplitudes=np.stack(columns, axis=2) if columns else np.empty((*still.shape[:1], 3, 0)),
        coordinate=coordinate,
        order=order,
        family=family_of,
        size=still.shape[1],
    )


def _add_terms(
    terms: list[tuple[int, int, int]],
    columns: list[FloatArray],
    order: int,
    family: int,
    field: list[FloatArray],
) -> None:
    """Add the coordinates that move something in one order and family."""
    moved = np.stack(field, axis=1)
    for k in np.flatnonzero(moved.any(axis=(0, 1))):
        terms.append((int(k), order, family))
        columns.append(moved[:, :, k])


def _sections(outer: FloatArray, inner: FloatArray) -> tuple[Any, IntArray]:
    """Corners (node, radius) and edges of a stepped shaft, the outside to their right."""
    corners: list[tuple[float, float]] = []
    edges: list[tuple[int, int]] = []

    def line(start: tuple[float, float], end: tuple[float, float]) -> None:
        if start == end:
            return
        for corner in (start, end):
            if corner not in corners:
                corners.append(corner)
        edges.append((corners.index(start), corners.index(end)))

    last = len(outer) - 1
    for k, (high, low) in enumerate(zip(outer.tolist(), inner.tolist(), strict=True)):
        before = (float(outer[k - 1]), float(inner[k - 1])) if k else (low, low)
        line((k, high), (k, before[0]))
        if low > 0.0 or before[1] > 0.0:
            line((k, before[1]), (k, low))
            if low > 0.0:
                line((k, low), (k + 1, low))
        line((k + 1, high), (k, high))
        if k == last:
            line((k + 1, low), (k + 1, high))
    return np.array(corners), np.array(edges, dtype=np.int64)


def outline_chains(cells: IntArray) -> list[IntArray]:
    """Return the points of an outline, edges (c, 2), in order: loops close, open pieces do not."""
    after: dict[int, list[int]] = {}
    arrives: dict[int, int] = {}
    for first, second in cells.tolist():
        after.setdefault(first, []).append(second)
        arrives[second] = arrives.get(second, 0) + 1
    chains = []
    # open pieces begin where nothing arrives
    starts = [p for p in after if p not in arrives] + list(after)
    for start in starts:
        while after.get(start):
            chain = [start]
            while after.get(chain[-1]):
                chain.append(after[chain[-1]].pop())
                if chain[-1] == start:
                    break
            chains.append(np.array(chain))
    return chains


def _finite_parts(
    values: npt.ArrayLike, shape: tuple[int, ...], single: bool, copies: Copies | None
) -> Matrix:
    """Read-only amplitudes, complex of a sector, in double precision with the digits of single."""
    given = np.asarray(values)
    if copies is None and np.iscomplexobj(given):
        raise SuperelementError("surface: amplitudes are complex; those of a sector alone may be")
    parts = [given] if copies is None else [given.real, given.imag]
    checked = []
    for part in parts:
        found = finite_array(GROUP, "amplitudes", part, shape)
        if single:
            with np.errstate(over="ignore"):
                found = finite_array(GROUP, "amplitudes", found.astype(np.float32), shape)
        checked.append(found)
    if copies is None:
        return checked[0]
    joined = checked[0] + 1j * checked[1]
    joined.setflags(write=False)
    return joined


def _wholes(name: str, value: Any, shape: tuple[int | None, ...], limit: int) -> IntArray:
    """A read-only array of whole numbers from 0 to below a limit."""
    array = finite_array(GROUP, name, value, shape)
    if ((array != np.floor(array)) | (array < 0) | (array >= limit)).any():
        raise SuperelementError(
            f"surface: {name} has numbers that are not whole or not from 0 to {limit - 1}"
        )
    whole: IntArray = array.astype(np.int64)
    whole.setflags(write=False)
    return whole
