"""Solids of a STEP file in gmsh's CAD kernel: cut along boxes, cut into a sector, made periodic.

The kernel works in millimetres of the file's own coordinates.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import gmsh
import numpy as np
import scipy

from solidwhirl.geometry import GeometryError, Joint
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.groups import as_written, names_text
from solidwhirl.meshing.imported.records import MeshRequest, axis_turn
from solidwhirl.meshing.imported.turning import angles_taken
from solidwhirl.meshing.records import FloatArray

#: Unit that geometry is worked on in, whatever the file's: gmsh's kernel takes points nearer than
#: 1e-7 for one.
UNIT, UNIT_M = "MM", 1e-3
Entity = tuple[int, int]
# Places on every curve that tell where a geometry lies.
_ALONG = 25
# Middles, areas and second moments of faces that are the same, over the size of the body.
_SAME = 1e-5
# A wedge reaches this much farther than the body.
_BEYOND = 1.2
# Angle of a cut through the axis, where no seam of a surface lies.
_ASIDE = 0.618
# Fits are thinner than this part of their radius: no metal stays elastic at half of it. Those drawn
# at several places are one within a part of their depth, and chamfers end at 5 degrees or more.
_THIN, _SAME_FIT, _CHAMFER = 0.01, 1e-3, 12.0


def imprint(volumes: list[int], request: MeshRequest) -> list[int]:
    """Cut the solids along the boxes of interfaces; gives the solids that come of it.

    Of a body of sectors copies of a box cut as well: what they select is the same in all sectors.
    """
    for interface in request.interfaces:
        if interface.box_m is None:
            continue
        low, high = (np.array(corner) / UNIT_M for corner in interface.box_m)
        for k in _turns_of_box(low, high, request):
            # one by one: boxes that overlap need not be cut along each other outside
            box = (3, gmsh.model.occ.addBox(*low, *(high - low)))
            _put_on_axis(box, request, 2.0 * np.pi * k / (request.sectors or 1))
            volumes = _only(fragment([(3, tag) for tag in volumes], [box])[0])
    return volumes


def _turns_of_box(low: FloatArray, high: FloatArray, request: MeshRequest) -> range:
    """Turns of a box by 2π/N that are wanted: one of a box that goes around the whole body."""
    reach = np.hypot(*_places(request)[:, :2].T).max() if request.sectors else 0.0
    around = (low[:2] <= -reach).all() and (high[:2] >= reach).all()
    return range(1 if around else request.sectors or 1)


def join(request: MeshRequest) -> tuple[Joint, ...]:
    """Give solids that touch common faces; what two of one material have in common counts once.

    What two solids of a joint have in common is an interference fit as drawn, and the first of them
    keeps it. Result: the joints with what is drawn. Raises MeshingError: solids overlap that are of
    unlike material, or by less than an element; a joint between solids that the file has not, or
    that nothing tells of.
    """
    assert request.step is not None
    joints = tuple(_fitted(joint, request) for joint in request.joints)
    solids = gmsh.model.getEntities(3)
    names = [label(*entity) for entity in solids]
    shown = [repr(name) if name else f"solid {k + 1} of the file" for k, name in enumerate(names)]
    materials = [dict(request.materials).get(name, request.material) for name in names]
    pieces = _pieces(solids, [])[: len(solids)]
    for a, b in itertools.combinations(range(len(solids)), 2):
        common = [e for e in set(pieces[a]) & set(pieces[b]) if e[0] == 3]
        volume = sum(gmsh.model.occ.getMass(*entity) for entity in common)
        if not volume > 0.0:
            continue
        faces = {f for _, tag in common for f in gmsh.model.getAdjacencies(3, tag)[1]}
        # of a thin layer with faces on both sides
        depth = 2.0 * volume / sum(gmsh.model.occ.getMass(2, tag) for tag in faces)
        unlike = materials[a] != materials[b]
        if not unlike and depth * UNIT_M >= request.step.smallest_m:
            continue
        of = (m.name if m else "no material" for m in (materials[a], materials[b]))
        centre = gmsh.model.occ.getCenterOfMass(*common[0])
        place = ", ".join(f"{round(v, 6) + 0.0:.4g}" for v in centre)
        said = f"they are of {' and '.join(of)}" if unlike else "that is less than an element"
        raise MeshingError(
            f"{shown[a]} and {shown[b]} overlap by {depth:.3g} mm, in {volume:.4g} mm³ about "
            f"({place}) mm, and {said}: whose the common part is, the file does not say. "
            "Cut it off one of them, so that they touch and are joined; of an interference fit say "
            f'joints = [{{ between = ["{names[a] or "label"}", "{names[b] or "label"}"] }}]'
        )
    return joints


def _fitted(joint: Joint, request: MeshRequest) -> Joint:
    """Cut what two solids of a joint have in common off the second; gives it with what is drawn."""
    names = [label(*entity) for entity in gmsh.model.getEntities(3)]
    first, second = (as_written(name, names) for name in joint.between)
    for name in (first, second):
        if name not in names:
            raise MeshingError(
                f"{joint.where}: the file has no solid {name!r}; it has "
                f"{names_text([n for n in names if n])}"
            )
    drawn = set[float]()
    for inner in [e for e in gmsh.model.getEntities(3) if label(*e) == first]:
        for outer in [e for e in gmsh.model.getEntities(3) if label(*e) == second]:
            cut, made = _pieces([outer], gmsh.model.occ.copy([inner]))
            common = {entity for entity in set(cut) & set(made) if entity[0] == 3}
            drawn |= {_sleeve_m(tag, joint, request) for _, tag in common}
            gmsh.model.occ.remove(made, recursive=True)
            gmsh.model.occ.synchronize()
    return _told(replace(joint, between=(first, second)), sorted(drawn))


def _told(joint: Joint, drawn_m: list[float]) -> Joint:
    """A joint with the interference that is drawn."""
    if not drawn_m:
        try:
            joint.refuse_untold()
        except GeometryError as error:
            raise MeshingError(f"{error}; or draw the solids with their interference") from error
        return joint
    low, high = drawn_m[0], drawn_m[-1]
    if high - low > _SAME_FIT * high:
        raise MeshingError(
            f"{joint.where}: the solids overlap by {low:.6g} m at one place and by {high:.6g} m at "
            "another; draw one interference, or a solid for each"
        )
    given = joint.interference_m
    if joint.pressure_pa is not None or abs((given or high) - high) > _SAME_FIT * high:
        key = "pressure_pa" if given is None else "interference_m"
        raise MeshingError(
            f"{joint.where}: {key} is given, and the solids are drawn with an interference of "
            f"{high:.6g} m; leave {key} out, or draw solids that touch"
        )
    return replace(joint, interference_m=high)


def _sleeve_m(tag: int, joint: Joint, request: MeshRequest) -> float:
    """Thickness of the sleeve that two solids have in common.

    Raises MeshingError: it is no thin one around a cylinder.
    """
    faces = gmsh.model.getAdjacencies(3, tag)[1]
    curves = {c for face in faces for c in gmsh.model.getAdjacencies(2, face)[1]}
    places = np.vstack([_on_curve(c, request) for c in curves])
    r, z = np.hypot(places[:, 0], places[:, 1]), places[:, 2]
    depth, length = float(np.ptp(r)), float(np.ptp(z))
    volume, ring = gmsh.model.occ.getMass(3, tag), np.pi * (r.max() ** 2 - r.min() ** 2) * length
    # ends that chamfers cut off have this part of it
    ends = _CHAMFER * depth / max(length, depth)
    if depth > _THIN * r.max() or abs(volume / ring - 1.0) > ends + _SAME:
        raise MeshingError(
            f"{joint.where}: the solids overlap in {volume:.4g} mm³, z from {z.min():.6g} to "
            f"{z.max():.6g} mm, r from {r.min():.6g} to {r.max():.6g} mm: that is no fit on a "
            f"cylinder about the axis, all around and thinner than {_THIN:g} of its radius. Cones "
            "and faces clamped by bolts are drawn touching, with stiffness_n_per_m3 or pressure_pa"
            "; or check axis"
        )
    return depth * UNIT_M


def fragment(solids: list[Entity], tools: list[Entity]) -> tuple[set[Entity], set[Entity]]:
    """Cut solids along each other and along tools; gives the pieces of both, with labels."""
    pieces = _pieces(solids, tools)
    return (
        {entity for made in pieces[: len(solids)] for entity in made},
        {entity for made in pieces[len(solids) :] for entity in made},
    )


def _pieces(solids: list[Entity], tools: list[Entity]) -> list[list[Entity]]:
    """What becomes of every solid and every tool."""
    faces = list(dict.fromkeys(gmsh.model.getBoundary(solids, combined=False, oriented=False)))
    given = [*solids, *faces]
    labels = [label(*entity) for entity in given]
    _, came_from = gmsh.model.occ.fragment(solids, [*faces, *tools])
    gmsh.model.occ.synchronize()
    for (dimension, _), name, made in zip(given, labels, came_from, strict=False):
        for entity in made:
            if name and entity[0] == dimension:
                gmsh.model.setEntityName(*entity, name)
    return [*came_from[: len(solids)], *came_from[len(given) :]]


def label(dimension: int, tag: int) -> str:
    """Last part of an entity's label; STEP files put assemblies before it."""
    return str(gmsh.model.getEntityName(dimension, tag)).rsplit("/", 1)[-1].strip()


def _only(kept: set[Entity]) -> list[int]:
    """Remove all other solids; gives the tags of those that are left."""
    others = [entity for entity in gmsh.model.getEntities(3) if entity not in kept]
    gmsh.model.occ.remove(others, recursive=True)
    gmsh.model.occ.synchronize()
    return [tag for _, tag in gmsh.model.getEntities(3)]


def extents_m(request: MeshRequest) -> tuple[FloatArray, FloatArray]:
    """Corners (3,) of the box around the whole body of sectors, z along its axis [m]."""
    places = UNIT_M * _places(request)
    reach = float(np.hypot(places[:, 0], places[:, 1]).max())
    low, high = places[:, 2].min(), places[:, 2].max()
    return np.array([-reach, -reach, low]), np.array([reach, reach, high])


def sector_solids(volumes: list[int], request: MeshRequest) -> list[int]:
    """Cut one of N sectors out of the solids if they are the whole; gives those of the sector.

    The cuts are planes through the axis where they meet least. What a plane takes off a blade that
    hangs over is put back on the other side. Raises MeshingError: the cut fails.
    """
    assert request.sectors is not None
    places = _places(request)
    angle = 2.0 * np.pi / request.sectors
    if angles_taken(places[np.hypot(*places[:, :2].T) > 1e-6 * np.abs(places).max()]) <= 0.5 * (
        angle + 2.0 * np.pi
    ):
        return volumes
    before = sum(gmsh.model.occ.getMass(3, tag) for tag in volumes)
    wedge = _wedge(places, _clear_angle(request), angle)
    _put_on_axis(wedge, request, 0.0)
    pieces, inside = fragment([(3, tag) for tag in volumes], [wedge])
    kept = _only(pieces & inside)
    if not kept:
        raise MeshingError(f"sectors = {request.sectors}: no part of the solids is in a sector")
    after = request.sectors * sum(gmsh.model.occ.getMass(3, tag) for tag in kept)
    if abs(after - before) > _SAME * before:
        raise MeshingError(
            f"sectors = {request.sectors}: the file holds the whole, of {before * UNIT_M**3:.6g} "
            f"m³, but {request.sectors} sectors cut out of it have {after * UNIT_M**3:.6g} m³: it "
            "does not consist of equal sectors"
        )
    return _with_overhang(kept, request)


def _wedge(places: FloatArray, start: float, angle: float) -> Entity:
    """A wedge about z that is larger than the body."""
    made = gmsh.model.occ.revolve([_half_plane(places, start)], 0, 0, 0, 0, 0, 1, angle)
    return next((d, t) for d, t in made if d == 3)


def _half_plane(places: FloatArray, angle: float) -> Entity:
    """A rectangle that begins at z and is larger than half of the body."""
    reach = _BEYOND * float(np.hypot(places[:, 0], places[:, 1]).max())
    low, high = places[:, 2].min(), places[:, 2].max()
    more = (_BEYOND - 1.0) * max(high - low, reach)
    occ = gmsh.model.occ
    face = (2, occ.addRectangle(0.0, low - more, 0.0, reach, high - low + 2.0 * more))
    occ.rotate([face], 0, 0, 0, 1, 0, 0, 0.5 * np.pi)
    occ.rotate([face], 0, 0, 0, 0, 0, 1, angle)
    return face


def meridian(volumes: list[int], request: MeshRequest) -> list[int]:
    """Cut solids of revolution through their axis, and keep one side of the cut.

    Result: its faces, with the labels of the solids; its curves have those of their faces. Raises
    MeshingError: a solid that is not of revolution about the axis.
    """
    places, volume = _places(request), dict[str, float]()
    for tag in volumes:
        name = label(3, tag)
        volume[name] = volume.get(name, 0.0) + gmsh.model.occ.getMass(3, tag)
    cuts = [_half_plane(places, angle) for angle in (_ASIDE, _ASIDE + np.pi)]
    for cut in cuts:
        _put_on_axis(cut, request, 0.0)
    sides = _pieces([(3, tag) for tag in volumes], cuts)[-2:]
    back, labels = np.linalg.inv(_frame(request)), dict[Entity, str]()
    for side in sides:
        inside = {f: set(gmsh.model.getAdjacencies(*f)[0]) for f in side}
        kept = {f: label(3, own.pop()) for f, own in inside.items() if own}
        swept = dict.fromkeys(volume, 0.0)
        for face, name in kept.items():
            centre = back @ np.append(gmsh.model.occ.getCenterOfMass(*face), 1.0)
            swept[name] += 2.0 * np.pi * np.hypot(*centre[:2]) * gmsh.model.occ.getMass(*face)
        for name, one in volume.items():
            if abs(swept[name] / one - 1.0) > _SAME:
                raise MeshingError(
                    f"joints are of bodies of revolution, and solid {name!r} is none about this "
                    f"axis: it has {one:.7g} mm³, its meridian revolved {swept[name]:.7g} mm³; "
                    "leave out keyways, holes and blades, or check axis"
                )
        labels = labels or dict(kept)
    faces = list(labels)
    for tag in {c for face in faces for c in gmsh.model.getAdjacencies(*face)[1]}:
        named = [label(2, f) for f in gmsh.model.getAdjacencies(1, tag)[0] if (2, f) not in labels]
        labels[1, tag] = next(filter(None, named), "")
    gmsh.model.occ.remove(gmsh.model.getEntities(3))
    others = [entity for entity in gmsh.model.getEntities(2) if entity not in labels]
    gmsh.model.occ.remove(others, recursive=True)
    gmsh.model.occ.synchronize()
    for entity, name in labels.items():
        gmsh.model.setEntityName(*entity, name)
    return [tag for _, tag in faces]


def _clear_angle(request: MeshRequest) -> float:
    """Angle of a plane through the axis that is farthest from all curves, but for rings."""
    assert request.sectors is not None
    sector = 2.0 * np.pi / request.sectors
    found = [np.zeros(1)]
    for _, tag in gmsh.model.getEntities(1):
        curve = _on_curve(tag, request)
        curve = curve[np.hypot(curve[:, 0], curve[:, 1]) > 1e-6 * np.abs(curve).max()]
        if len(curve) and angles_taken(curve) < sector:
            angle = np.arctan2(curve[:, 1], curve[:, 0])
            # all between the ends too
            turn = np.unwrap(angle)
            found.append(np.linspace(turn.min(), turn.max(), _ALONG))
    angle = np.sort(np.concatenate(found[1:] or found) % sector)
    gaps = np.diff(np.append(angle, angle[0] + sector))
    widest = int(gaps.argmax())
    return float(angle[widest] + 0.5 * gaps[widest])


def _with_overhang(volumes: list[int], request: MeshRequest) -> list[int]:
    """Put parts that are not joined to the largest one sector on or back."""
    assert request.sectors is not None
    parts = _joined_parts(volumes)
    if len(parts) == 1:
        return volumes
    mass = {tag: gmsh.model.occ.getMass(3, tag) for tag in volumes}
    parts.sort(key=lambda part: -sum(mass[tag] for tag in part))
    middle = _mean_angle(parts[0], request)
    turn = 2.0 * np.pi / request.sectors
    for part in parts[1:]:
        away = (_mean_angle(part, request) - middle + np.pi) % (2.0 * np.pi) - np.pi
        gmsh.model.occ.rotate(
            [(3, tag) for tag in part],
            *_frame(request)[:3, 3],
            *_frame(request)[:3, 2],
            -np.copysign(turn, away),
        )
    gmsh.model.occ.synchronize()
    fragment([(3, tag) for tag in volumes], [])
    return [tag for _, tag in gmsh.model.getEntities(3)]


def _joined_parts(volumes: list[int]) -> list[list[int]]:
    """Solids that hang together by faces."""
    faces = {tag: set(gmsh.model.getAdjacencies(3, tag)[1]) for tag in volumes}
    parts: list[list[int]] = []
    left = list(volumes)
    while left:
        part = [left.pop(0)]
        for tag in part:
            beside = [other for other in left if faces[tag] & faces[other]]
            part += beside
            left = [other for other in left if other not in beside]
        parts.append(part)
    return parts


def _mean_angle(volumes: list[int], request: MeshRequest) -> float:
    frame = np.linalg.inv(_frame(request))
    mass = [gmsh.model.occ.getMass(3, tag) for tag in volumes]
    centre = np.average([gmsh.model.occ.getCenterOfMass(3, t) for t in volumes], 0, mass)
    x, y, _, _ = frame @ np.append(centre, 1.0)
    return float(np.arctan2(y, x))


def make_periodic(request: MeshRequest) -> None:
    """Ask for the same mesh on faces that, turned by 2π/N, lie on others.

    Raises MeshingError: there are none, or gmsh finds that they are not the same.
    """
    assert request.sectors is not None
    angle = 2.0 * np.pi / request.sectors
    affine = _turn_about_axis(request, angle)
    tags = [tag for _, tag in gmsh.model.getEntities(2)]
    area = np.array([gmsh.model.occ.getMass(2, tag) for tag in tags])
    centre = np.array([gmsh.model.occ.getCenterOfMass(2, tag) for tag in tags])
    second = np.array([gmsh.model.occ.getMatrixOfInertia(2, tag) for tag in tags]).reshape(-1, 3, 3)
    turn, size = affine[:3, :3], float(np.ptp(_places(request), axis=0).max())
    matched = 0
    for k, tag in enumerate(tags):
        off = np.linalg.norm(centre - affine[:3] @ np.append(centre[k], 1.0), axis=1) / size
        off = np.maximum(off, np.abs(area / area[k] - 1.0))
        bent = np.abs(second - turn @ second[k] @ turn.T).max(axis=(1, 2))
        off = np.maximum(off, bent / np.abs(second[k]).max())
        if off.min() > _SAME or tags[int(off.argmin())] == tag:
            continue
        try:
            gmsh.model.mesh.setPeriodic(2, [tags[int(off.argmin())]], [tag], affine.ravel())
        except Exception as error:  # gmsh raises bare Exception
            raise MeshingError(
                f"sectors = {request.sectors}: faces that lie on each other when turned by "
                f"{np.degrees(angle):.6g}° can not be meshed alike: {error}"
            ) from error
        matched += 1
    if not matched:
        taken = np.degrees(angles_taken(_places(request)))
        raise MeshingError(
            f"sectors = {request.sectors}: no face of the solids, turned by "
            f"{np.degrees(angle):.6g}° about the axis, is another; they take about {taken:.3g}° "
            "around. Is another number of sectors meant, or another axis?"
        )


def _turn_about_axis(request: MeshRequest, angle: float) -> FloatArray:
    """Turn (4, 4) about the axis of a request in the kernel's coordinates."""
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    frame = _frame(request)
    return np.asarray(frame @ turn @ np.linalg.inv(frame))


def _frame(request: MeshRequest) -> FloatArray:
    """Affine map (4, 4) from coordinates on the axis to those of the kernel, both in its unit."""
    frame = np.eye(4)
    frame[:3, :3] = axis_turn(request).T
    frame[:3, 3] = np.array(request.origin) * request.unit_m / UNIT_M
    return frame


def _put_on_axis(entity: Entity, request: MeshRequest, angle: float) -> None:
    """Take what was drawn along z to the axis, turned about it."""
    rotation = scipy.spatial.transform.Rotation
    turn = rotation.from_matrix(axis_turn(request).T) * rotation.from_rotvec([0.0, 0.0, angle])
    # affineTransform would make splines of planes and cylinders
    if turn.magnitude() > 0.0:
        gmsh.model.occ.rotate([entity], 0, 0, 0, *turn.as_rotvec(), turn.magnitude())
    gmsh.model.occ.translate([entity], *_frame(request)[:3, 3])


def _places(request: MeshRequest) -> FloatArray:
    """Places (n, 3) along all curves, on the axis, in the kernel's unit."""
    return np.vstack([_on_curve(tag, request) for _, tag in gmsh.model.getEntities(1)])


def _on_curve(tag: int, request: MeshRequest) -> FloatArray:
    low, high = gmsh.model.getParametrizationBounds(1, tag)
    along = np.linspace(low[0], high[0], _ALONG)
    places = np.array(gmsh.model.getValue(1, tag, along)).reshape(-1, 3)
    back = np.linalg.inv(_frame(request))
    return np.asarray(places @ back[:3, :3].T + back[:3, 3])
