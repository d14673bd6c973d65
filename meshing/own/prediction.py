"""How many elements and unknowns a mesh will have, before it is made.

The element size that is asked of a mesh is a function h(z, r) of the meridian: a bound on every
section, and h_k + g ρ at a distance ρ from every graded place. Triangles of edge h fill √3/4 h²,
tetrahedra √2/12 h³, so their number is an integral over the meridian; it is computed on pieces
small enough that h hardly changes within one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, product
from typing import Literal

import numpy as np

from solidwhirl.geometry import (
    Blade,
    Body,
    Flat,
    Hole,
    Recess,
    Section,
    Slot,
    Subdivision,
    merge_fillets,
    mirror_angle,
    places_rad,
    sector_count,
    subdivide,
    symmetry,
)
from solidwhirl.geometry.feature_shapes import bottom_distance, hole_range, largest_radius
from solidwhirl.geometry.parts import layout_of, part_bodies
from solidwhirl.meshing.own.grading import (
    AROUND,
    edge_at_hole,
    face_bounds,
    face_edges,
    graded_places,
)
from solidwhirl.meshing.own.quality import doubled_areas
from solidwhirl.meshing.records import FloatArray, IntArray, LocalSize, MeshSize
from solidwhirl.rotordyn.core.arrays import BoolArray

# Equilateral triangle and regular tetrahedron of edge 1.
_TRIANGLE, _TETRAHEDRON = np.sqrt(3.0) / 4.0, np.sqrt(2.0) / 12.0
# All the following was measured on gmsh's meshes. Tetrahedra for each regular one, and what every
# triangle on the skins adds.
_TETRAHEDRA, _BY_SKIN = 0.65, 1.1
# Where the size grows by g per length, edges are shorter than asked for by 1 + 0.7 g.
_STEEPER = 0.7
# Triangles for every edge of a strip's outline: gmsh puts a row of vertices into its middle.
_STRIP = 2.0
# Vertices of a mesh of tetrahedra: per tetrahedron inside, and what each surface triangle adds.
_PER_TETRAHEDRON, _PER_SURFACE = 1.0 / 5.6, 0.23
# A piece is small enough when h changes by less than this fraction across it.
_CHANGE = 0.7
# Parts into which every edge of a triangle with local sizes is divided to add up its elements.
_PARTS = 8
# Points are in a cut plane up to this part of the size.
_IN_PLANE = 1e-9
# No piece is divided more often: a corner 2^-40 as large as the body is no corner.
_DIVISIONS = 40
# Corners of the four triangles that the middles of its edges make of one, and of the halves of a
# line.
_QUARTERS = 0.5 * np.array(
    [
        *((2, 0, 0), (1, 1, 0), (1, 0, 1)),
        *((1, 1, 0), (0, 2, 0), (0, 1, 1)),
        *((1, 0, 1), (0, 1, 1), (0, 0, 2)),
        *((1, 1, 0), (0, 1, 1), (1, 0, 1)),
    ]
)
_HALVES = 0.5 * np.array([(2, 0), (1, 1), (1, 1), (0, 2)])
#: Meridian, revolved meridian, or tetrahedra of a mesher.
MeshKind = Literal["harmonic", "revolved", "solid"]
_Density = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, kw_only=True)
class PredictedMesh:
    """Numbers of a mesh that has not been made."""

    dimension: int  #: 2 (meridian, triangles) or 3 (solid, tetrahedra)
    cells: int
    #: Of the cells; facets are the triangles of a solid mesh, 0 on a meridian
    vertices: int
    edges: int
    facets: int
    #: Places that the element size is graded to; each costs the mesher time at every vertex
    graded_places: int
    #: Of half a sector: the mesh of each of its two cut faces
    cut_face: PredictedMesh | None = None
    #: Of a meridian: edges along the faces of joints that are pressed together
    pressed_edges: int = 0

    def unknowns(self, degree: int) -> int:
        """Three displacements at every node of continuous elements of an order.

        Half a sector has the two parts of its fields, on a cut face half of each.

        `degree`: polynomial degree p of the displacement, 1 or more.
        """
        if self.cut_face is None:
            return 3 * self._nodes(degree)
        return 6 * (self._nodes(degree) - self.cut_face._nodes(degree))

    def times(self, factor: float) -> PredictedMesh:
        """Return the numbers of a mesh so many times as large."""
        counts = {
            key: round(factor * getattr(self, key))
            for key in ("cells", "vertices", "edges", "facets")
        }
        face = self.cut_face
        # a face grows with the square of what the solid grows with the cube of
        cut = None if face is None else face.times(factor ** (2.0 / 3.0))
        pressed = round(factor**0.5 * self.pressed_edges)
        return replace(self, **counts, cut_face=cut, pressed_edges=pressed)

    def _nodes(self, degree: int) -> int:
        """Add p - 1 nodes in an edge, (p-1)(p-2)/2 in a triangle, (p-1)(p-2)(p-3)/6 in a cell."""
        p, solid = degree, self.dimension == 3
        triangles = self.facets if solid else self.cells
        nodes = self.vertices + self.edges * (p - 1) + triangles * (p - 1) * (p - 2) // 2
        if solid:
            nodes += self.cells * (p - 1) * (p - 2) * (p - 3) // 6
        return nodes


@lru_cache(maxsize=64)
def predict_mesh(body: Body, size: MeshSize, kind: MeshKind) -> PredictedMesh:
    """Predict the numbers of a mesh: a meridian, revolved or not, within a factor 1.5.

    `kind`: "solid" is a sector of a body whose features have one, sectors of drum and stages that
    have unlike ones, else the whole. Raises GeometryError: an invalid body.

    Where a section is thinner than its elements are long, the edges (triangles) of its outline
    count instead. Vertices, edges and facets are related by Euler's formula.
    """
    if kind == "revolved":
        return predict_revolved(predict_mesh(body, size, "harmonic"))
    if kind == "solid" and symmetry(body) == "staged":
        return _joined(body, size)
    subdivision = merge_fillets(subdivide(body))
    places = np.array(graded_places(body, subdivision, size)).reshape(-1, 3)
    bounds = face_bounds(body, subdivision, size, 3 if kind == "solid" else 2)
    joined = zip(subdivision.joints, body.joints, strict=True)
    pressed = [curve for face, joint in joined if joint.is_pressed for curve in face.seat]
    meridian = _meridian(subdivision, places, size.growth, bounds, pressed)
    if kind == "harmonic":
        return meridian
    return _solid(body, size, (subdivision, places, bounds), meridian)


def predict_revolved(meridian: PredictedMesh) -> PredictedMesh:
    """Predict the numbers of half a sector from those of its meridian.

    Triangles become prisms of three tetrahedra; that the axis does not move is left out.
    """
    return PredictedMesh(
        dimension=3,
        cells=3 * meridian.cells,
        vertices=2 * meridian.vertices,
        edges=3 * meridian.edges + meridian.vertices,
        facets=4 * meridian.cells + 2 * meridian.edges,
        graded_places=meridian.graded_places,
        cut_face=meridian,
    )


def _joined(body: Body, size: MeshSize) -> PredictedMesh:
    """Numbers of the drum, revolved by a sector, and of one sector of every stage, together.

    What of the drum is copied for estimates is left out.
    """
    parts = part_bodies(body, layout_of(body))
    halves = [not part.features or mirror_angle(part) is not None for part in parts]
    found = [predict_mesh(p, size, "solid" if p.features else "revolved") for p in parts]
    if not all(halves):
        found = [m.times(2.0) if half else m for m, half in zip(found, halves, strict=True)]
    faces = [mesh.cut_face for mesh in found if mesh.cut_face is not None]
    return replace(_together(found), cut_face=_together(faces))


def _together(meshes: Sequence[PredictedMesh]) -> PredictedMesh:
    """Numbers of meshes that have nothing in common."""
    total = {
        key: sum(getattr(mesh, key) for mesh in meshes)
        for key in ("cells", "vertices", "edges", "facets", "graded_places")
    }
    return PredictedMesh(dimension=meshes[0].dimension, **total)


def predict_refined(local: LocalSize, *, whole: bool = False) -> PredictedMesh:
    """Predict the numbers of a mesh with local sizes, within a factor 1.5.

    `local`: sizes that will be asked of the mesh, of a meridian or a solid. `whole`: of a solid
    that it is no sector, so that it has no cut faces.
    """
    if local.points.shape[1] == 3:
        return _refined_solid(local, whole)
    weights = _centroids()
    corners = local.points[local.cells]
    area = 0.5 * np.abs(doubled_areas(corners))
    size = local.size_m[local.cells] @ weights.T
    at = np.einsum("ck,mkd->mcd", weights, corners)
    for z, r, h in local.places:
        away = np.hypot(at[:, :, 0] - z, at[:, :, 1] - r)
        size = np.minimum(size, h + local.growth * away)
    cells = round(float((area[:, None] / (_TRIANGLE * size**2)).sum() / len(weights)))
    return PredictedMesh(
        dimension=2,
        cells=cells,
        vertices=max(cells // 2, 3),
        edges=max(3 * cells // 2, 3),
        facets=0,
        graded_places=len(local.places),
    )


def _refined_solid(local: LocalSize, whole: bool) -> PredictedMesh:
    """Numbers of a mesh of tetrahedra with local sizes."""
    corners = local.points[local.cells]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    regular = _over_simplices(local, local.cells, volume, lambda h: 1.0 / (_TETRAHEDRON * h**3))
    facets = np.sort(local.cells[:, np.array(list(combinations(range(4), 3)))].reshape(-1, 3))
    facets, count = np.unique(facets, axis=0, return_counts=True)
    outer, near = facets[count == 1], _IN_PLANE * np.abs(local.points).max()
    surface = _triangles(local, outer)
    if whole:
        # parts that are laid together have elements on both sides of the planes between them
        between = _triangles(local, _through_axis(local, facets[count == 2], near))
        cells = _TETRAHEDRA * regular + _BY_SKIN * (surface + 2.0 * between)
        return _tetrahedra(cells, surface, 0, None)
    cells = _TETRAHEDRA * regular + _BY_SKIN * surface
    across = _triangles(local, outer[(np.abs(local.points[outer, 1]) < near).all(axis=1)])
    face = PredictedMesh(
        dimension=2,
        cells=round(across),
        vertices=max(round(0.5 * across), 3),
        edges=max(round(1.5 * across), 3),
        facets=0,
        graded_places=0,
    )
    return _tetrahedra(cells, surface, 0, face)


def _through_axis(local: LocalSize, facets: IntArray, near: float) -> IntArray:
    """Facets in planes through the axis."""
    x, y = (local.points[facets, k] for k in range(2))
    first = np.hypot(x, y).argmax(axis=1)[:, None]
    a, b = (np.take_along_axis(v, first, axis=1) for v in (x, y))
    off = np.abs(a * y - b * x) / np.hypot(a, b)
    return np.asarray(facets[(off < near).all(axis=1)])


def _tetrahedra(
    cells: float, surface: float, places: int, cut_face: PredictedMesh | None
) -> PredictedMesh:
    """Numbers of so many tetrahedra with so many triangles around them, by Euler's formula."""
    vertices = max(_PER_TETRAHEDRON * cells + _PER_SURFACE * surface, 4.0)
    return PredictedMesh(
        dimension=3,
        cells=round(cells),
        vertices=round(vertices),
        edges=round(vertices + cells + 0.5 * surface),
        facets=round(2.0 * cells + 0.5 * surface),
        graded_places=places,
        cut_face=cut_face,
    )


def _triangles(local: LocalSize, facets: IntArray) -> float:
    """How many triangles facets (f, 3) will be divided into."""
    a, b, c = (local.points[facets[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return _over_simplices(local, facets, area, lambda h: 1.0 / (_TRIANGLE * h**2))


def _over_simplices(
    local: LocalSize,
    cells: IntArray,
    measure: FloatArray,
    density: Callable[[FloatArray], FloatArray],
) -> float:
    """Integral of density(h) over simplices with these measures, by points spread over each."""
    corners = cells.shape[1]
    share = [s for s in product(range(_PARTS), repeat=corners) if sum(s) == _PARTS - 1]
    weights = (np.array(share) + 1.0 / corners) / _PARTS
    size = local.size_m[cells] @ weights.T
    return float((measure[:, None] * density(size)).sum() / len(weights))


def _centroids() -> FloatArray:
    """Barycentric coordinates of the middles of the parts of a triangle, (_PARTS², 3)."""
    up = [(i + 1 / 3, j + 1 / 3) for i in range(_PARTS) for j in range(_PARTS - i)]
    down = [(i + 2 / 3, j + 2 / 3) for i in range(_PARTS) for j in range(_PARTS - 1 - i)]
    first, second = np.array([*up, *down]).T / _PARTS
    return np.column_stack([first, second, 1.0 - first - second])


def _meridian(
    subdivision: Subdivision,
    places: FloatArray,
    growth: float,
    bounds: list[float],
    pressed: list[int],
) -> PredictedMesh:
    """Triangles, and by Euler's formula their edges and vertices; `pressed`: curves of joints."""
    cells = 0.0
    densities: list[_Density] = [lambda x, h: 1.0 / h] * len(subdivision.curves)
    edges = _along_curves(subdivision, places, growth, bounds, densities)
    edges = np.maximum(edges, 1.0)
    own = _over_faces(subdivision, places, growth, bounds, lambda x, h: 1.0 / (_TRIANGLE * h**2))
    for face, inside in zip(subdivision.faces, own.tolist(), strict=True):
        outline = sum(edges[c] for c, _ in face.loop)
        cells += max(inside, _STRIP * outline - 2.0, 1.0)
    rim = sum(edges[c] for c in (*subdivision.boundary, *subdivision.axis))
    lines = 0.5 * (3.0 * cells + rim)
    return PredictedMesh(
        dimension=2,
        cells=round(cells),
        vertices=max(round(1.0 + lines - cells), 3),
        edges=round(lines),
        facets=0,
        graded_places=len(places),
        pressed_edges=round(sum(edges[c] for c in pressed)),
    )


def _solid(
    body: Body,
    size: MeshSize,
    drawn: tuple[Subdivision, FloatArray, list[float]],
    meridian: PredictedMesh,
) -> PredictedMesh:
    """Tetrahedra of the swept faces and of blades, triangles of the surface, Euler's formula.

    What holes and recesses take away is left out. `drawn`: subdivision, graded places and bounds of
    its faces.
    """
    subdivision, places, bounds = drawn
    share, parts = _share_of_circle(body), _parts_of_whole(body)
    width = 2.0 * np.pi * share

    def around(x: FloatArray, h: FloatArray) -> FloatArray:
        return np.asarray(width * x[:, 1] / (_TRIANGLE * h**2))

    def bent(x: FloatArray, h: FloatArray) -> FloatArray:
        most = 2.0 * np.pi * x[:, 1] / AROUND
        return around(x, np.minimum(h, np.maximum(most, 0.1 * size.corner_size_m)))

    def filled(x: FloatArray, h: FloatArray) -> FloatArray:
        return np.asarray(width * x[:, 1] / (_TETRAHEDRON * h**3))

    regular = float(_over_faces(subdivision, places, size.growth, bounds, filled).sum())
    z, curves = subdivision.points[:, 0], subdivision.curves
    outer = subdivision.boundary if body.features else ()
    curved = {c for c in outer if z[curves[c].start] != z[curves[c].end]}
    densities = [bent if c in curved else around for c in range(len(curves))]
    swept = _along_curves(subdivision, places, size.growth, bounds, densities)
    volumes, skins = (share * own for own in _of_features(body, size))
    # cut faces: of one part they are surface, between those of a whole they are inside
    skins += 0.0 if parts else 2.0 * meridian.cells
    walls = swept.sum() + skins + 2.0 * parts * meridian.cells
    cells = _TETRAHEDRA * (regular + volumes) + _BY_SKIN * walls
    surface = sum(swept[c] for c in subdivision.boundary) + skins
    return _tetrahedra(cells, surface, len(places), None if parts else meridian)


def _share_of_circle(body: Body) -> float:
    """Part of the circle that a mesh holds."""
    if _parts_of_whole(body):
        return 1.0
    count = sector_count(body.features)
    return (0.5 if mirror_angle(body) is not None else 1.0) / count


def _parts_of_whole(body: Body) -> int:
    """Number of the parts that the mesh of a whole is laid together from; 0 of a sector."""
    kind = symmetry(body)
    if kind == "round":
        return 4
    if kind != "asymmetric":
        return 0
    return 2 * sector_count(body.features) if mirror_angle(body) is not None else 2


def _of_features(body: Body, size: MeshSize) -> tuple[float, float]:
    """Regular tetrahedra in blades, at roots, holes and recesses, triangles of their surfaces."""
    sections, volumes, skins = {s.name: s for s in body.sections}, 0.0, 0.0
    for feature in body.features:
        if isinstance(feature, Blade):
            own = _of_blade(feature, size)
        elif isinstance(feature, Hole):
            start, end = hole_range(feature, sections[feature.within])
            own = _of_hole(feature, end - start, size)
        else:
            own = _of_recess(feature, sections[feature.within], size), 0.0
        number = len(places_rad(feature))
        volumes += number * own[0]
        skins += number * own[1]
    return volumes, skins


def _of_blade(blade: Blade, size: MeshSize) -> tuple[float, float]:
    """Regular tetrahedra and triangles of one blade; its root is graded to the half space below."""
    thick, chord = (0.5 * sum(ends) for ends in (blade.thickness_m, blade.chord_m))
    thin = min(thick, chord, blade.length_m)
    h = min(size.size_m, 1.5 * thin / size.through_thickness)
    inside = blade.length_m * chord * thick / h**3
    # ∫ π ρ dρ / (e + g ρ)³ along the root
    root = np.pi * (chord + thick) / (size.growth**2 * min(size.corner_size_m, h))
    surface = 2.0 * blade.length_m * (chord + thick) / h**2
    return (inside + root) / _TETRAHEDRON, surface / _TRIANGLE


def _of_hole(hole: Hole, depth_m: float, size: MeshSize) -> tuple[float, float]:
    """Regular tetrahedra about one hole, whose size grows from its wall, and triangles of it."""
    edge, radius = edge_at_hole(hole, size), 0.5 * hole.diameter_m
    # ∫ 2π ρ dρ / (e + g (ρ - R))³ from the wall on
    about = np.pi * (radius / edge**2 + 1.0 / (size.growth * edge)) / size.growth
    return depth_m * about / _TETRAHEDRON, 2.0 * np.pi * radius * depth_m / edge**2 / _TRIANGLE


def _of_recess(recess: Recess, section: Section, size: MeshSize) -> float:
    """Regular tetrahedra that the re-entrant edges of one recess add, in 3/4 of the circle."""
    length = recess.end_m - recess.start_m
    bottom, outer = bottom_distance(recess, section), largest_radius(section)
    walls = sum((recess.start_m > section.start_m, recess.end_m < section.end_m))
    if isinstance(recess, Flat):
        edges = walls * 2.0 * np.sqrt(outer**2 - bottom**2)
    else:
        if isinstance(recess, Slot):
            across = recess.width_m
        else:
            across = bottom * float(np.radians(recess.width_deg))
        edges = 2.0 * length + walls * (across + 2.0 * recess.depth_m)
    # 3/2 π ∫ [1 / (e + g ρ)³ - 1 / h³] ρ dρ along the edges, to where the sizes are equal
    finer = (1.0 - size.corner_size_m / size.size_m) ** 3
    along = 0.75 * np.pi * edges * finer / (size.growth**2 * size.corner_size_m)
    return float(along / _TETRAHEDRON)


@dataclass(frozen=True, kw_only=True, eq=False)
class _ElementSize:
    """The element size h(z, r) on faces or curves."""

    places: FloatArray  #: (p, 3) z, r and the size there
    growth: float
    bounds: FloatArray  #: (f,) of every face or curve
    counts: BoolArray  #: (f, p) whether a place is near enough to matter

    @staticmethod
    def on(
        corners: Sequence[FloatArray], places: FloatArray, growth: float, bounds: list[float]
    ) -> _ElementSize:
        """Sizes within the bounding boxes of the corners (n, 2) of faces or curves."""
        low, high = (np.array([end(c, axis=0) for c in corners]) for end in (np.min, np.max))
        at = places[None, :, :2]
        outside = np.maximum(np.maximum(low[:, None] - at, at - high[:, None]), 0.0)
        away = np.hypot(outside[..., 0], outside[..., 1])
        least = (places[:, 2] + growth * away) / (1.0 + _STEEPER * growth)
        largest = np.array(bounds)
        return _ElementSize(
            places=places, growth=growth, bounds=largest, counts=least < largest[:, None]
        )

    def graded(self, x: FloatArray, owner: IntArray) -> FloatArray:
        """Without the bound, at points (n, 2) of faces or curves by their numbers (n,)."""
        out = np.full(len(x), np.inf)
        # pairs of a point and a place that matters to its face, sorted by points
        which = np.nonzero(self.counts)[1]
        many = self.counts.sum(axis=1)
        first, count = (np.cumsum(many) - many)[owner], many[owner]
        point = np.repeat(np.arange(len(x)), count)
        begin = np.cumsum(count) - count
        place = self.places[which[np.arange(len(point)) + (first - begin).repeat(count)]]
        size = place[:, 2] + self.growth * np.hypot(*(x[point] - place[:, :2]).T)
        some = count > 0
        if some.any():
            out[some] = np.minimum.reduceat(size, begin[some])
        return np.asarray(out / (1.0 + _STEEPER * self.growth))


def _over_faces(
    subdivision: Subdivision,
    places: FloatArray,
    growth: float,
    bounds: list[float],
    density: _Density,
) -> FloatArray:
    """Integral of density(x, h(x)) over every face, by triangles from its first corner."""
    corners = [face_edges(subdivision, face)[0] for face in subdivision.faces]
    size = _ElementSize.on(corners, places, growth, bounds)
    fan = np.concatenate(
        [np.stack([np.broadcast_to(p[0], p[2:].shape), p[1:-1], p[2:]], axis=1) for p in corners]
    )
    owner = np.repeat(np.arange(len(corners)), [len(p) - 2 for p in corners])
    flat = doubled_areas(fan) == 0.0
    fan, owner = fan[~flat], owner[~flat]
    return np.abs(_added_up((fan, owner), size, density, _QUARTERS))


def _along_curves(
    subdivision: Subdivision,
    places: FloatArray,
    growth: float,
    bounds: list[float],
    densities: Sequence[_Density],
) -> FloatArray:
    """Integral of a density(x, h(x)) along every curve (arcs: chords).

    h is that of the finer face beside it.
    """
    largest = np.full(len(subdivision.curves), np.inf)
    for face, bound in zip(subdivision.faces, bounds, strict=True):
        loop: IntArray = np.array([c for c, _ in face.loop])
        largest[loop] = np.minimum(largest[loop], bound)
    lines = subdivision.points[np.array([(c.start, c.end) for c in subdivision.curves])]
    size = _ElementSize.on(lines, places, growth, largest.tolist())
    found = np.zeros(len(largest))
    for density in dict.fromkeys(densities):
        own = np.array([c for c, other in enumerate(densities) if other is density])
        found += _added_up((lines[own], own), size, density, _HALVES)
    return found


def _added_up(
    pieces: tuple[FloatArray, IntArray],
    size: _ElementSize,
    density: _Density,
    divided: FloatArray,
) -> FloatArray:
    """Integral of density(x, h(x)) over every face or curve, in pieces on which h hardly changes.

    `pieces`: corners (n, c, 2) and the numbers (n,) of the faces or curves that they are of;
    `divided`: corners of k equal parts of every piece, half as long, by its own, (k c, c).
    """
    corners, owner = pieces
    count = len(divided) // corners.shape[1]
    total = np.zeros(len(size.bounds))
    sides = corners - np.roll(corners, 1, axis=1)
    length = np.hypot(sides[..., 0], sides[..., 1]).max(axis=1)
    measure = 0.5 * doubled_areas(corners) if corners.shape[1] == 3 else length
    for _ in range(_DIVISIONS):
        if not len(corners):
            break
        middle, bound = corners.sum(axis=1) / corners.shape[1], size.bounds[owner]
        graded, change = size.graded(middle, owner), size.growth * length
        done = (change <= _CHANGE * graded) | (graded - change >= bound)
        found = measure[done] * density(middle[done], np.minimum(graded, bound)[done])
        total += np.bincount(owner[done], found, minlength=len(total))
        left = ~done
        corners = (divided @ corners[left]).reshape(-1, *corners.shape[1:])
        owner, length, measure = (
            v[left].repeat(count) for v in (owner, 0.5 * length, measure / count)
        )
    return total
