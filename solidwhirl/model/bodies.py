"""From the bodies of a scene to geometry."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations, permutations

from solidwhirl import geometry as geo
from solidwhirl.core.errors import choice, clean
from solidwhirl.scene.records import BodySpec, InterfaceSpec, Scene, StageGroupSpec


def build_bodies(scene: Scene) -> dict[str, geo.Body]:
    """Make the geometry of every body of a scene.

    Raises GeometryError: unknown material, a profile that is none, interfaces that move as one,
    features that leave no drum or are on a level that has no place for them; the message begins
    with the key.
    """
    materials = scene_materials(scene)
    bodies = {}
    for name, spec in scene.bodies.items():
        try:
            bodies[name] = _build_body(name, spec, materials)
            # milliseconds: what does not fit is refused before anything is meshed
            _refuse_dependent_interfaces(
                bodies[name], geo.merge_fillets(geo.subdivide(bodies[name]))
            )
            if geo.symmetry(bodies[name]) == "staged":
                geo.layout_of(bodies[name])
        except geo.GeometryError as error:
            raise geo.GeometryError(clean(f"bodies.{name}: {error}")) from error
    _refuse_features_on(scene.model.level, scene.model.order, bodies)
    _refuse_joints_beside_features(bodies)
    return bodies


def _refuse_features_on(level: str, order: int | None, bodies: Mapping[str, geo.Body]) -> None:
    """A meridian holds no features, and neither does a beam; tetrahedra about them have order 2."""
    for name, body in bodies.items():
        if body.features and level == "solid" and order not in (None, 2):
            raise geo.GeometryError(
                f"model.order: {order}, but the elements of body {name!r} have order 2, as of all "
                f"with {body.features[0].kind}; allowed is 2, or leave it out"
            )
        if body.features and level in ("beam", "harmonic"):
            first = body.features[0]
            raise geo.GeometryError(
                f"model.level: {level!r} is of bodies of revolution, and body {name!r} has "
                f"{first.kind} {first.name!r}; allowed with {first.kind} are 'auto' and 'solid'"
            )


def _refuse_joints_beside_features(bodies: Mapping[str, geo.Body]) -> None:
    """Faces are parted on meridians, and what presses them is found there."""
    for name, body in bodies.items():
        if body.joints and body.features:
            raise geo.GeometryError(
                f"bodies.{name}: joints are of bodies of revolution, and this one has "
                f"{body.features[0].kind} {body.features[0].name!r}; leave out one of the two"
            )


def _refuse_dependent_interfaces(body: geo.Body, subdivision: geo.Subdivision) -> None:
    """Interfaces of one surface, or inside a rigid one, have the same motion: one is enough."""
    surfaces = {name: set(curves) for name, curves in subdivision.interfaces.items()}
    for first, second in combinations(body.interfaces, 2):
        if surfaces[first.name] == surfaces[second.name]:
            raise geo.GeometryError(
                f"interfaces {first.name!r} and {second.name!r} are the same surface; keep one of "
                "them, any number of bearings and rigid disks may use it"
            )
    for outer, inner in permutations(body.interfaces, 2):
        if outer.coupling == "rigid" and surfaces[inner.name] <= surfaces[outer.name]:
            raise geo.GeometryError(
                f"interface {inner.name!r} lies inside the rigid interface {outer.name!r} and "
                f"moves with it; bearings and rigid disks may use {outer.name!r} instead"
            )


def scene_materials(scene: Scene) -> dict[str, geo.Material]:
    """Materials that a scene can name: its own before those of the program."""
    own = {
        name: geo.Material(
            name=name,
            density_kg_per_m3=spec.density_kg_per_m3,
            youngs_modulus_pa=spec.youngs_modulus_pa,
            poissons_ratio=spec.poissons_ratio,
        )
        for name, spec in scene.materials.items()
    }
    return {**geo.MATERIALS, **own}


def known_material(
    materials: Mapping[str, geo.Material], name: str | None, where: str
) -> geo.Material:
    """Return a material by its name; GeometryError names the place of one that is not there."""
    if name is None:
        raise geo.GeometryError(f"{where}: no material; give it or the body one")
    if name not in materials:
        raise geo.GeometryError(
            f"{where}: unknown material {name!r}; {choice(name, sorted(materials))}"
        )
    return materials[name]


def _build_body(name: str, spec: BodySpec, materials: dict[str, geo.Material]) -> geo.Body:
    sections: list[geo.Section] = []
    for s in spec.sections:
        material = known_material(materials, s.material or spec.material, f"sections {s.name!r}")
        sections.append(geo.Section(**s.model_dump(exclude={"material"}), material=material))
    for group in spec.stage_groups:
        material = known_material(
            materials, group.material or spec.material, f"stages {group.name!r}"
        )
        sections += _stages(group, material)
    return geo.Body(
        name=name,
        sections=tuple(sections),
        interfaces=tuple(_interface(i) for i in spec.interfaces),
        rigid_disks=tuple(geo.RigidDisk(**d.model_dump()) for d in spec.rigid_disks),
        fillet_radius_m=spec.fillet_radius_m,
        features=_features(spec, materials),
        joints=tuple(geo.Joint(**j.model_dump()) for j in spec.joints),
    )


def _features(spec: BodySpec, materials: Mapping[str, geo.Material]) -> tuple[geo.Feature, ...]:
    """Blades, of stages too, and all other features of a body."""
    features: list[geo.Feature] = []
    for blade in spec.blades:
        name = blade.material or spec.material
        material = known_material(materials, name, f"blades {blade.name!r}")
        features.append(geo.Blade(**blade.model_dump(exclude={"material"}), material=material))
    for group in spec.stage_groups:
        if group.blades is not None:
            name = group.blades.material or group.material or spec.material
            material = known_material(materials, name, f"stages {group.name!r}")
            features += geo.stage_group_blades(
                geo.TABLE_7[group.table],
                geo.StageBlades(**group.blades.model_dump(exclude={"material"})),
                material=material,
                prefix=group.name,
            )
    features += [geo.Hole(**hole.model_dump()) for hole in spec.holes]
    features += [geo.Slot(**slot.model_dump()) for slot in spec.slots]
    features += [geo.Keyway(**keyway.model_dump()) for keyway in spec.keyways]
    features += [geo.Flat(**flat.model_dump()) for flat in spec.flats]
    features += [geo.RingCut(**cut.model_dump()) for cut in spec.cuts]
    return tuple(features)


def _stages(group: StageGroupSpec, material: geo.Material) -> tuple[geo.Section, ...]:
    webs = [
        geo.Web(
            stage=w.stage,
            thickness_m=w.thickness_m,
            inner_radius_m=w.shaft_radius_m,
            position=w.position,
        )
        for w in group.webs
    ]
    cones = [geo.Cone(**c.model_dump()) for c in group.cones]
    return geo.stage_group_sections(
        geo.TABLE_7[group.table],
        start_m=group.start_m,
        direction=group.direction,
        material=material,
        spacer_thickness_m=group.spacer_thickness_m,
        web=(*webs, *cones),
        prefix=group.name,
    )


def _interface(spec: InterfaceSpec) -> geo.Interface:
    start = spec.at_m if spec.at_m is not None else spec.start_m
    end = spec.at_m if spec.at_m is not None else spec.end_m
    assert start is not None
    assert end is not None
    return geo.Interface(
        name=spec.name,
        kind=spec.kind,
        coupling=spec.coupling,
        start_m=start,
        end_m=end,
        radius_m=spec.radius_m,
    )
