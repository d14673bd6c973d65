"""From the joints and simple bodies of a scene to the parts of the assembled system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from solidwhirl.analyses.unbalances import end_of
from solidwhirl.model.bodies import known_material, scene_materials
from solidwhirl.model.imported_bodies import imported_elements
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.static_loads import Loads, at_static_loads, load_case
from solidwhirl.rotordyn import (
    LEE_ANISOTROPIC,
    LEE_ISOTROPIC,
    AssembledSystem,
    AssemblyError,
    Bearing,
    Disk,
    FrequencyTableLaw,
    Gear,
    InternalDamping,
    PolynomialLaw,
    Rotor,
    SpeedLaw,
    Superelement,
    TableLaw,
    assemble,
    beam_superelement,
    rigid_superelement,
)
from solidwhirl.rotordyn.assembly.bearing_laws import RingLaw
from solidwhirl.rotordyn.assembly.load_laws import LoadTable
from solidwhirl.rotordyn.assembly.magnetic_laws import MagneticLaw
from solidwhirl.rotordyn.asymmetric import RotatingSystem, assemble_rotating, at_rest
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.validation import MOTIONS
from solidwhirl.scene.bearing_physics import AbsoluteLaw, RollingLawSpec, SqueezeFilmLawSpec
from solidwhirl.scene.joints import (
    BeamSpec,
    BearingSpec,
    FileLawSpec,
    FrequencyTableLawSpec,
    GearSpec,
    LoadTableLawSpec,
    PolynomialLawSpec,
    SpeedLawSpec,
)
from solidwhirl.scene.magnetic_bearings import MagneticLawSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import LATERAL, is_off_axis

_PRESETS: dict[str, SpeedLaw] = {"lee_isotropic": LEE_ISOTROPIC, "lee_anisotropic": LEE_ANISOTROPIC}
# A frequency and a speed beyond all others, rad/s.
_QUICK = 1e6
# Keys of a bearing that are no coefficients.
_NO_NUMBERS = ("name", "first", "second", "rigid", "speed_law", "sensor", "cross_coupling")
# What belongs to an effect: a part of the keys of a bearing, and rigid motions.
_OF_EFFECT = {
    "bearing_damping": ("damping", ()),
    "tilt": ("tilt", ("rx", "ry")),
    "axial": ("axial", ("uz",)),
    "torsion": ("torsion", ("rz",)),
}


def engine_of(scene: Scene, plan: Plan, elements: Mapping[str, Superelement]) -> AssembledSystem:
    """Assemble bodies, bearings and gears of a scene; asymmetric ones as they are at rest.

    Raises AnalysisError: tables of bearings over their load do not reach to it.
    """
    parts, geared = at_rest(rotors(scene, plan, elements)), gears(scene, plan)

    def assembled(loads: Loads) -> AssembledSystem:
        return assemble(parts, bearings(scene, plan, loads), gears=geared)

    case = load_case(scene)
    return assembled({}) if case is None else at_static_loads(scene, case, assembled)


def with_speed_laws(scene: Scene, laws: Mapping[str, str]) -> Scene:
    """Return a scene with other speed laws, by the names of bearings and of laws."""
    bearings = (
        spec.model_copy(update={"speed_law": laws.get(spec.name, spec.speed_law)})
        for spec in scene.bearings
    )
    return scene.model_copy(update={"bearings": tuple(bearings)})


def rotating_engine_of(
    scene: Scene, plan: Plan, elements: Mapping[str, Superelement]
) -> RotatingSystem | None:
    """Assemble a scene in the frame of its asymmetric bodies; None without such a body.

    Raises AssemblyError: two of them at different speeds, or joints that can not be.
    """
    if all(element.frame == "inertial" for element in elements.values()):
        return None
    parts = rotors(scene, plan, elements)
    return assemble_rotating(parts, bearings(scene, plan), gears=gears(scene, plan))


def simple_elements(scene: Scene, plan: Plan) -> dict[str, Superelement]:
    """Superelements of the beams, rigid and imported bodies of a scene.

    Raises SuperelementError, GeometryError: a beam, rigid or imported body that can not be.
    """
    elements = {name: _beam(scene, plan, name, spec) for name, spec in scene.beams.items()}
    still = not plan.on("gyroscopic")
    unused = {m for m, effect in (("uz", "axial"), ("rz", "torsion")) if not plan.on(effect)}
    for name, body in scene.rigid_bodies.items():
        # off the axis, lateral and tilting motion drag uz and rz along
        held = set() if is_off_axis(body) else unused
        elements[name] = rigid_superelement(
            name,
            body.mass_kg,
            body.center_of_gravity_m,
            body.inertia_kg_m2,
            body.interfaces,
            components=tuple(m for m in MOTIONS if m not in held),
        )
    if still:
        elements = {k: replace(e, gyroscopic=np.zeros((e.size,) * 2)) for k, e in elements.items()}
    return elements | imported_elements(scene, plan)


def _beam(scene: Scene, plan: Plan, name: str, spec: BeamSpec) -> Superelement:
    material = known_material(scene_materials(scene), spec.material, f"beams.{name}")
    carried = {m for place in spec.interfaces for m in plan.carried[f"{name}.{place}"]}
    return beam_superelement(
        name,
        spec.stations_m,
        *spec.section_radii_m,
        (material.youngs_modulus_pa, material.poissons_ratio, material.density_kg_per_m3),
        spec.interfaces,
        [
            Disk(
                name=d.name,
                position_m=d.at_m,
                mass_kg=d.mass_kg,
                polar_kg_m2=d.polar_inertia_kg_m2,
                diametral_kg_m2=d.diametral_inertia_kg_m2,
            )
            for d in spec.disks
        ],
        components=tuple(m for m in MOTIONS if m in {"ux", "uy", "rx", "ry", *carried}),
    )


def rotors(scene: Scene, plan: Plan, elements: Mapping[str, Superelement]) -> dict[str, Rotor]:
    """Bodies with their speed ratios and, if the plan has it on, their internal damping."""
    damped = scene.internal_damping() if plan.on("internal_damping") else {}
    out = {}
    for name, ratio in scene.speed_ratios().items():
        damping = InternalDamping(**damped[name].model_dump()) if name in damped else None
        out[name] = Rotor(element=elements[name], speed_ratio=ratio, internal_damping=damping)
    return out


def bearings(scene: Scene, plan: Plan, loads: Loads | None = None) -> tuple[Bearing, ...]:
    """Bearings of a scene without what belongs to effects that the plan has off.

    `loads`: of the bearings with a table over it.
    """
    off = tuple(name for name in _OF_EFFECT if not plan.on(name))
    # one for all bearings that share it
    law_of = cache(partial(_law_of, scene, plan.on("bearing_damping"), off))
    found = []
    for spec in scene.bearings:
        law = law_of(spec.speed_law, scene.speed_ratio_at(spec.first) != 0.0)
        if isinstance(law, LoadTable):
            law = law.at((loads or {})[spec.name])
        found.append(_bearing(spec, off, law))
    return tuple(found) if plan.on("speed_dependent_bearings") else tuple(map(_at_rest, found))


def _law_of(
    scene: Scene, damped: bool, off: tuple[str, ...], name: str | None, turns: bool
) -> SpeedLaw | LoadTable | None:
    """Return a speed law for a first end that turns or stands still; None without a name."""
    if name is None:
        return None
    law = scene.speed_laws[name]
    if isinstance(law, LoadTableLawSpec):
        return _load_table(name, law, damped)
    if isinstance(law, SqueezeFilmLawSpec) and not turns:
        return _film_of_a_still_ring(name, law, float(damped))
    if isinstance(law, RollingLawSpec):
        fixed = {motion for effect in off for motion in _OF_EFFECT[effect][1]}
        held = (*LATERAL, *(motion for motion in law.held if motion not in fixed))
        table = law.ring_table()
        return RingLaw(
            name=name,
            speeds_rad_s=table.speeds_rad_s,
            stiffness=table.stiffness,
            least=table.least,
            most=table.most,
            damping_n_s_per_m=law.damping_n_s_per_m * float(damped),
            motions=tuple(MOTIONS.index(motion) for motion in held),
        )
    return _law(name, law, damped)


def _at_rest(bearing: Bearing) -> Bearing:
    """The bearing with the values of its table at rest, as the table has no others."""
    if isinstance(bearing.speed_law, RingLaw):
        return replace(bearing, speed_law=bearing.speed_law.at_rest())
    if not isinstance(bearing.speed_law, TableLaw | FrequencyTableLaw | MagneticLaw):
        return replace(bearing, speed_law=None)
    zero = np.zeros((2, 2))
    k, c = bearing.speed_law.coefficients(0.0, zero, zero)
    if len(k) == 4 and (k[:2, 2:].any() or k[2:, :2].any() or c[:2, 2:].any() or c[2:, :2].any()):
        return bearing  # constant, but more than a bearing's own coefficients can say
    own: dict[str, Any] = {"stiffness_n_per_m": k[:2, :2], "damping_n_s_per_m": c[:2, :2]}
    if len(k) == 4:
        own["tilt_stiffness_n_m_per_rad"] = bearing.tilt_stiffness_n_m_per_rad + k[2:, 2:]
        own["tilt_damping_n_m_s_per_rad"] = bearing.tilt_damping_n_m_s_per_rad + c[2:, 2:]
    return replace(bearing, speed_law=None, sensor=None, **own)


def _frequency_law(name: str, spec: FrequencyTableLawSpec, damped: float) -> FrequencyTableLaw:
    frequencies = np.array(spec.frequency_hz) * 2.0 * np.pi

    def values(rows: Any) -> FloatArray:
        found = np.array(rows, dtype=float)
        return found if frequencies.size else found[:, 0]

    stiffness = values(spec.stiffness_n_per_m)
    return FrequencyTableLaw(
        name=name,
        speeds_rad_s=np.array(spec.speed_rpm) * np.pi / 30.0,
        frequencies_rad_s=frequencies,
        stiffness_n_per_m=stiffness,
        damping_n_s_per_m=values(spec.damping_n_s_per_m) * damped,
        mass_kg=values(spec.added_mass_kg) if spec.added_mass_kg else np.zeros(stiffness.shape),
        interpolation=spec.interpolation,
    )


def _load_table(name: str, spec: LoadTableLawSpec, damped: bool) -> LoadTable:
    laws: tuple[Any, ...] = tuple(_law(name, table, damped) for table in spec.tables)
    return LoadTable(loads_n=np.array(spec.load_n), laws=laws)


def _law(name: str, spec: SpeedLawSpec, damped: bool) -> SpeedLaw:
    if isinstance(spec, PolynomialLawSpec):
        return PolynomialLaw(name=name, **spec.model_dump(exclude={"kind"}))
    if isinstance(spec, FrequencyTableLawSpec):
        return _frequency_law(name, spec, float(damped))
    if isinstance(spec, MagneticLawSpec) and damped:
        return MagneticLaw(name=name, bearing=spec.bearing())
    if isinstance(spec, FileLawSpec):
        raise AssemblyError((f"law {name!r}: its file {spec.file!r} was not read with the scene",))
    if isinstance(spec, AbsoluteLaw):
        rows = spec.table()
        undamped = np.zeros_like(rows.damping_n_s_per_m)
        rows = rows if damped else rows._replace(damping_n_s_per_m=undamped)
        return TableLaw(name=name, **rows._asdict())
    return _PRESETS[spec.preset]


def _film_of_a_still_ring(name: str, spec: SqueezeFilmLawSpec, damped: float) -> FrequencyTableLaw:
    """Return a damper around a ring that stands still, over the frequency of the motion alone.

    Its stiffness is proportional to that, so that two frequencies say all.
    """
    ends = np.array([0.0, _QUICK])
    rows = spec.over_whirl(ends)
    stiffness, damping = (np.array([part, part]) for part in rows[1:3])
    return FrequencyTableLaw(
        name=name,
        speeds_rad_s=ends,
        frequencies_rad_s=ends,
        stiffness_n_per_m=stiffness,
        damping_n_s_per_m=damped * damping,
        mass_kg=np.zeros(stiffness.shape),
        interpolation="linear",
    )


def _bearing(spec: BearingSpec, off: tuple[str, ...], law: SpeedLaw | None) -> Bearing:
    values: dict[str, FloatArray | float] = {}
    fixed = {c for name in off for c in _OF_EFFECT[name][1]}
    for key in BearingSpec.model_fields:
        if key in _NO_NUMBERS:
            continue
        if any(_OF_EFFECT[n][0] in key for n in off):
            continue
        value = getattr(spec, key)
        values[key] = value if isinstance(value, float) else np.array(value, dtype=float)
    sensor = spec.sensor if isinstance(law, MagneticLaw) else None
    return Bearing(
        name=spec.name,
        first=end_of(spec.first),
        second=None if spec.second == "ground" else end_of(spec.second),
        rigid=tuple(c for c in spec.rigid if c not in fixed),
        speed_law=law,
        sensor=None if sensor is None else end_of(sensor),
        cross_coupling=spec.cross_coupling,
        **values,  # type: ignore[arg-type]
    )


def gears(scene: Scene, plan: Plan) -> tuple[Gear, ...]:
    """Gears of a scene; none where the plan has torsion off."""
    if not plan.on("torsion"):
        return ()
    damped = plan.on("bearing_damping")
    return tuple(_gear(spec, damped) for spec in scene.gears)


def _gear(spec: GearSpec, damped: bool) -> Gear:
    angle = spec.line_of_action_deg
    return Gear(
        name=spec.name,
        first=end_of(spec.first),
        second=end_of(spec.second),
        ratio=spec.ratio,
        mesh_stiffness_n_per_m=spec.mesh_stiffness_n_per_m,
        mesh_damping_n_s_per_m=spec.mesh_damping_n_s_per_m * float(damped),
        base_radius_first_m=spec.base_radius_first_m,
        line_of_action_rad=None if angle is None else float(np.radians(angle)),
    )
