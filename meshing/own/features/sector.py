"""Second-order tetrahedra of a body with blades, holes, slots and the like: a sector or the whole.

A sector is the revolved meridian with its features cut out or joined on. With a mirror plane it is
the half of a sector, from one mirror plane to the next; else both cut faces get the same nodes.
The whole of a body with less than three sectors is laid together from copies of such a part.
"""

from __future__ import annotations

from dataclasses import replace

import gmsh
import numpy as np

from solidwhirl.geometry import (
    Blade,
    Body,
    Material,
    Subdivision,
    merge_fillets,
    places_rad,
    subdivide,
)
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own import drawing as drawn
from solidwhirl.meshing.own.features.cut import Cut, angles_of, choose_cut
from solidwhirl.meshing.own.features.sizes import set_sizes
from solidwhirl.meshing.own.features.solids import DimTags, Solids, feature_solid
from solidwhirl.meshing.own.meridian import (
    TETRAHEDRON10,
    TRIANGLE6,
    checked_quality,
    compact,
    element_blocks,
    node_table,
)
from solidwhirl.meshing.own.solid import distance_to_curve
from solidwhirl.meshing.own.whole import cut_partners, turned, whole_mesh
from solidwhirl.meshing.records import (
    FloatArray,
    IntArray,
    LocalSize,
    Mesh,
    MeshQuality,
    MeshSize,
    Sector,
)

# What lies nearer to a plane or a line than this part of the body's size lies on it.
_ON = 1e-7
# Angles that differ by less are equal [rad].
_SAME_ANGLE = 1e-9


def mesh_sector(body: Body, size: MeshSize, local: LocalSize | None = None) -> Mesh:
    """Mesh one sector of a body with features with second-order tetrahedra.

    `body`: its symmetry is "cyclic". `local`: element sizes over an earlier mesh of the sector, in
    place of those that corners, thicknesses and features ask for. Returned: points (x, y, z) [m],
    the body turned such that the sector begins at θ = 0. Blades stand among the sections by their
    names; their part inside a section belongs to the section. Raises GeometryError: an invalid
    body, or one without features. Raises MeshingError: gmsh failed, the cut faces do not match, or
    elements stay folded.
    """
    return _mesh_part(body, size, local, choose_cut(body))


def mesh_whole_body(body: Body, size: MeshSize, local: LocalSize | None = None) -> Mesh:
    """Mesh the whole of a body with features with second-order tetrahedra.

    `body`: its symmetry is "asymmetric". `local`: element sizes over an earlier mesh of the whole,
    as of `mesh_sector`. Returned: points (x, y, z) [m] in the axes of the body, from whose x the
    angles of features count. What the features leave unchanged, mirroring in a plane through the
    axis or half a turn, leaves the mesh unchanged. Raises what `mesh_sector` raises.
    """
    cut = choose_cut(body)
    if local is not None:
        local = replace(local, points=turned(local.points, -cut.angle_rad))
    part = _mesh_part(body, size, local, cut)
    whole = part if part.sector is None else whole_mesh(part)[0]
    return replace(whole, points=turned(whole.points, cut.angle_rad))


def _mesh_part(body: Body, size: MeshSize, local: LocalSize | None, cut: Cut) -> Mesh:
    """Mesh what a cut leaves, turned such that it begins at θ = 0."""
    subdivision = merge_fillets(subdivide(body))
    unit_m = drawn.drawing_unit_m(subdivision)
    with drawn.gmsh_session():
        solids = _draw(body, subdivision, cut, unit_m)
        faces = _cut_faces(cut)
        if not (cut.mirrored or cut.whole):
            _match(faces, cut)
        set_sizes(body, subdivision, size, local, solids, cut, unit_m)
        _generate()
        numbering, points = node_table(unit_m)
        volumes = [*solids.face, *solids.blade]
        cells, owner = element_blocks(volumes, TETRAHEDRON10, numbering)
        sides = tuple(element_blocks(tags, TRIANGLE6, numbering)[0] for tags in faces)
        facets = _facets_of_curves(subdivision, numbering, points)
    cells, points, used = compact(points, cells)
    sides = (used[sides[0]], used[sides[1]])
    points, quality = _mended(_snapped(points, sides, cut), cells, cut)
    sections, materials = _names(body, subdivision)
    what = [_what(body, subdivision, solids, tag) for tag in volumes]
    return Mesh(
        points=points,
        cells=cells,
        cell_section=np.array([sections.index(name) for name, _ in what])[owner],
        cell_material=np.array([materials.index(material) for _, material in what])[owner],
        materials=materials,
        section_names=sections,
        interfaces={
            name: used[np.vstack([facets[c] for c in indices])]
            for name, indices in subdivision.interfaces.items()
        },
        outline=_outline(points, sides[0]),
        size=size,
        quality=quality,
        sector=None
        if cut.whole
        else Sector(count=cut.count, mirrored=cut.mirrored, angle_rad=cut.angle_rad),
    )


def _draw(body: Body, subdivision: Subdivision, cut: Cut, unit_m: float) -> Solids:
    """Draw the part: the meridian revolved, what features take away, and what they add."""
    occ = gmsh.model.occ
    drawing = drawn.draw(subdivision, unit_m)
    swept = occ.revolve([(2, f) for f in drawing.faces], 0, 0, 0, 0, 0, 1, cut.swept_rad)
    rings = [pair for pair in swept if pair[0] == 3]
    count = len(drawing.faces)
    if len(rings) != count:
        raise MeshingError(f"{count} faces swept to {len(rings)} volumes")
    if cut.whole:
        others = occ.copy(rings)
        occ.rotate(others, 0, 0, 0, 0, 0, 1, np.pi)
        rings += others
    solids, owners = [], []
    for k in range(len(body.features)):
        for part in _copies(k, body, cut, unit_m):
            solids.append(part)
            owners.append(k)
    parts = occ.fragment(rings, solids)[1]
    face = {tag: k % count for k in range(len(rings)) for _, tag in parts[k]}
    blade: dict[int, int] = {}
    removed = set()
    for k, pieces in zip(owners, parts[len(rings) :], strict=True):
        feature = body.features[k]
        for _, tag in pieces:
            if isinstance(feature, Blade):
                if tag not in face:
                    blade[tag] = k
            elif (
                tag not in face
                or subdivision.section_names[subdivision.faces[face[tag]].section] == feature.within
            ):
                removed.add(tag)
    occ.remove([(3, tag) for tag in removed], recursive=True)
    occ.synchronize()
    return Solids(
        face={tag: k for tag, k in face.items() if tag not in removed},
        blade={tag: k for tag, k in blade.items() if tag not in removed},
    )


def _copies(index: int, body: Body, cut: Cut, unit_m: float) -> DimTags:
    """Solids of all features of one set that the part has a part of."""
    feature, width = body.features[index], cut.width_rad
    taken, edges = angles_of(feature, body)
    turns = (places_rad(feature, cut.angle_rad) + np.pi) % (2.0 * np.pi) - np.pi
    # as near to the part as can be, on either side of it
    turns[turns < 0.5 * width - np.pi - _SAME_ANGLE] += 2.0 * np.pi
    if not isinstance(feature, Blade):
        near = [a for a in turns if a + taken[1] > 0.0 and a + taken[0] < width]
        return [pair for a in near for pair in feature_solid(feature, body, a, unit_m)]
    last = width + _SAME_ANGLE if cut.mirrored else width - _SAME_ANGLE
    own = turns if cut.whole else turns[(turns > -_SAME_ANGLE) & (turns < last)]
    solids = [feature_solid(feature, body, a, unit_m)[0] for a in own]
    is_cut = own.min() + taken[0] < 0.0 or own.max() + taken[1] > width
    if cut.whole or not (cut.mirrored or is_cut):
        return solids  # no root is cut: every sector has its own blades, wherever their tips are
    spans = [(a + edges.min(), a + edges.max()) for a in own]
    return [p for s, span in zip(solids, spans, strict=True) for p in _parts(s, span, cut)]


def _parts(solid: tuple[int, int], span: tuple[float, float], cut: Cut) -> DimTags:
    """What copies of a blade leave in the sector: its parts in all sectors, turned to this one.

    `span`: range of angles that the blade is in. Of the mirrored half of a sector it is the part in
    it.
    """
    occ = gmsh.model.occ
    width = cut.width_rad
    numbers = np.arange(np.ceil(span[0] / width), np.floor(span[1] / width) + 1.0)
    x0, y0, z0, x1, y1, z1 = occ.getBoundingBox(*solid)
    reach = 2.0 * max(abs(v) for v in (x0, y0, x1, y1))
    planes = []
    for number in numbers:
        plane = occ.addRectangle(0.0, z0 - reach, 0.0, reach, z1 - z0 + 2.0 * reach)
        occ.rotate([(2, plane)], 0, 0, 0, 1, 0, 0, 0.5 * np.pi)
        occ.rotate([(2, plane)], 0, 0, 0, 0, 0, 1, number * width)
        planes.append((2, plane))
    if not planes:
        return [solid]
    pieces = occ.fragment([solid], planes)
    occ.remove([pair for pair in pieces[0] if pair[0] == 2], recursive=True)
    out = []
    for pair in pieces[1][0]:
        x, y, _ = occ.getCenterOfMass(*pair)
        sector = np.floor(np.arctan2(y, x) / width)
        if not cut.mirrored:
            occ.rotate([pair], 0, 0, 0, 0, 0, 1, -sector * width)
        elif sector != 0.0:
            occ.remove([pair], recursive=True)
            continue
        out.append(pair)
    return out


def _cut_faces(cut: Cut) -> tuple[list[int], list[int]]:
    """Faces in the first and in the last cut plane, or where the halves of a whole meet."""
    scale = float(np.abs(gmsh.model.getBoundingBox(-1, -1)).max())
    out: tuple[list[int], list[int]] = ([], [])
    for _, tag in gmsh.model.getEntities(2):
        corners = gmsh.model.getBoundary([(2, tag)], recursive=True)
        points = [gmsh.model.getValue(0, t, []) for _, t in corners]
        points.append(gmsh.model.occ.getCenterOfMass(2, tag))
        x = np.array(points)
        for side, angle in zip(out, (0.0, cut.swept_rad), strict=True):
            along = x[:, 0] * np.cos(angle) + x[:, 1] * np.sin(angle)
            off = x[:, 1] * np.cos(angle) - x[:, 0] * np.sin(angle)
            if np.abs(off).max() < _ON * scale and along.min() > -_ON * scale:
                side.append(tag)
    return out


def _match(faces: tuple[list[int], list[int]], cut: Cut) -> None:
    """Tell gmsh that the last cut is the first one, turned by a sector."""
    c, s = np.cos(cut.width_rad), np.sin(cut.width_rad)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    centres = [np.array([gmsh.model.occ.getCenterOfMass(2, t) for t in side]) for side in faces]
    areas = [np.array([gmsh.model.occ.getMass(2, t) for t in side]) for side in faces]
    scale = float(np.abs(centres[0]).max())
    targets = []
    for centre, area in zip(centres[0], areas[0], strict=True):
        near = np.linalg.norm(centres[1] - turn @ centre, axis=1) < 1e-6 * scale
        found = np.flatnonzero(near & (np.abs(areas[1] - area) < 1e-4 * area))
        if len(found) != 1:
            raise MeshingError(
                f"cut face at z = {centre[2]:.6g}, r = {np.hypot(*centre[:2]):.6g} (drawn) has "
                f"{len(found)} counterparts"
            )
        targets.append(faces[1][found[0]])
    if len(set(targets)) != len(faces[1]):
        raise MeshingError(f"cut faces do not match: {len(faces[0])} and {len(faces[1])} faces")
    affine = np.eye(4)
    affine[:3, :3] = turn
    gmsh.model.mesh.setPeriodic(2, targets, faces[0], affine.ravel().tolist())


def _generate() -> None:
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.Algorithm3D", 1)
    gmsh.option.setNumber("Mesh.Optimize", 1)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)


def _facets_of_curves(
    subdivision: Subdivision, numbering: IntArray, points: FloatArray
) -> dict[int, IntArray]:
    """Triangles on the surface swept by every curve that an interface needs."""
    wanted = sorted({c for curves in subdivision.interfaces.values() for c in curves})
    scale = float(np.abs(subdivision.points).max())
    found: dict[int, list[IntArray]] = {c: [] for c in wanted}
    for _, tag in gmsh.model.getEntities(2) if wanted else ():
        triangles, _ = element_blocks([tag], TRIANGLE6, numbering)
        x = points[np.unique(triangles)]
        meridian = np.column_stack([x[:, 2], np.hypot(x[:, 0], x[:, 1])])
        for c in wanted:
            if distance_to_curve(subdivision, c, meridian) < _ON * scale:
                found[c].append(triangles)
    for c, blocks in found.items():
        if not blocks:
            z, r = subdivision.points[subdivision.curves[c].start]
            raise MeshingError(
                f"no facets on the interface at z = {z:.6g}, r = {r:.6g} m; a feature takes all of "
                "its surface"
            )
    return {c: np.vstack(blocks) for c, blocks in found.items()}


def _snapped(points: FloatArray, sides: tuple[IntArray, IntArray], cut: Cut) -> FloatArray:
    """Points with those of the cut faces exactly on them, and those of the axis on it.

    Without mirror planes the points of the last cut are those of the first, turned. Raises
    MeshingError: they do not match.
    """
    out = points.copy()
    first, last = (np.unique(side) for side in sides)
    out[first, 1] = 0.0
    axis = np.intersect1d(first, last)
    out[axis, :2] = 0.0
    c, s = np.cos(cut.swept_rad), np.sin(cut.swept_rad)
    along = out[last, 0] * c + out[last, 1] * s
    if cut.mirrored or cut.whole:
        out[last, :2] = np.column_stack([along * c, along * s])
    else:
        source, target = cut_partners(out, cut.count, within=_ON)
        if not np.array_equal(np.unique(target), np.setdiff1d(last, axis)):
            raise MeshingError(
                f"cut faces do not match: {len(last) - len(axis)} nodes, of which {len(target)} "
                "have a partner"
            )
        out[target] = turned(out[source], cut.width_rad)
    out[axis, :2] = 0.0
    return out


def _mended(points: FloatArray, cells: IntArray, cut: Cut) -> tuple[FloatArray, MeshQuality]:
    """Points without folded elements, and the quality; what is mended on one cut is on both."""
    straight, quality = checked_quality(points, cells, "sector")
    if cut.mirrored or cut.whole or not quality.straightened_elements:
        return straight, quality
    first, last = cut_partners(points, cut.count)
    moved = np.any(straight[last] != points[last], axis=1)
    straight[first[moved]] = turned(straight[last[moved]], -cut.width_rad)
    straight, quality = checked_quality(straight, cells, "sector")
    straight[last] = turned(straight[first], cut.width_rad)
    return straight, quality


def _names(body: Body, subdivision: Subdivision) -> tuple[tuple[str, ...], tuple[Material, ...]]:
    """Names of sections and blades, and all materials."""
    blades = [f for f in body.features if isinstance(f, Blade)]
    more = [b.material for b in blades if b.material not in subdivision.materials]
    return (
        (*subdivision.section_names, *(b.name for b in blades)),
        (*subdivision.materials, *dict.fromkeys(more)),
    )


def _what(body: Body, subdivision: Subdivision, solids: Solids, tag: int) -> tuple[str, Material]:
    """Section or blade, and material, of a volume."""
    if tag in solids.blade:
        feature = body.features[solids.blade[tag]]
        assert isinstance(feature, Blade)
        return feature.name, feature.material
    face = subdivision.faces[solids.face[tag]]
    return subdivision.section_names[face.section], subdivision.materials[face.material]


def _outline(points: FloatArray, side: IntArray) -> IntArray:
    """Nodes on the edges of the cut at θ = 0, without those on the axis."""
    edges = np.vstack([side[:, [a, b, m]] for a, b, m in ((0, 1, 3), (1, 2, 4), (2, 0, 5))])
    middle, count = np.unique(edges[:, 2], return_counts=True)
    outer = edges[np.isin(edges[:, 2], middle[count == 1])]
    on_axis = np.all(points[outer[:, 2], :2] == 0.0, axis=1)
    return np.asarray(np.unique(outer[~on_axis]))
