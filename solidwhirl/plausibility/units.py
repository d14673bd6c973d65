"""Doubts about units: numbers a thousand times off from what rotors have, as millimetres give.

They are warnings; refused are radii that no material holds at the speeds asked. The limits lie
beyond a dental drill of 1 mm and a steam turbine train of 300 t and 60 m.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.core.warnings import Doubt
from solidwhirl.geometry import Body, GeometryError
from solidwhirl.model.bodies import scene_materials
from solidwhirl.model.imported_bodies import imported_element
from solidwhirl.model.interface_documents import mesh_doubts
from solidwhirl.plausibility.shapes import Disk, Shape, shapes_of
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.joints import BearingSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.operating import operating_speeds
from solidwhirl.scene_checks.speeds_asked import scene_speeds, top_speed

if TYPE_CHECKING:
    from solidwhirl.rotordyn import Superelement


@dataclass(frozen=True, kw_only=True)
class Usual:
    """A row of usual.toml: the range of a quantity, and what is said of a number beyond it."""

    least: float = -math.inf
    most: float
    unit: str = ""
    found: str
    mistake: str
    usual: str = "{}"

    def fits(self, value: float) -> bool:
        """Whether a number is in the range."""
        return self.least <= value <= self.most

    def doubts(self, key: str, value: float, *more: object) -> Iterator[Doubt]:
        """Yield a doubt about a number that is not, and what else stands in its text."""
        if not self.fits(value):
            usual = self.usual.format(f"{self.least:g} to {self.most:g} {self.unit}")
            found = self.found.format(value, *more)
            yield Doubt(key=key, found=found, usual=usual, mistake=self.mistake)


_TABLE = (resources.files(__package__) / "usual.toml").read_text(encoding="utf-8")
#: What is judged, by name.
USUAL = {name: Usual(**row) for name, row in tomllib.loads(_TABLE).items()}
# A shaft without mass of its own, as closed forms have it, beside disks that carry the mass.
_MASSLESS_DENSITY, _MASSLESS_SHARE = (1e-6, 2.0), 0.1
# Fastest body: a dental drill turns at 5e5 rpm, a spinning sphere in a laboratory at more.
_SPEED_RPM = 3e6
_GRAVITY, _RIM_M_PER_S, _CASING_GYRATION = 9.81, 1500.0, 10.0
# Largest hoop strain of a linear prestress; least radius [m] that may be one in millimetres.
_STRAIN, _MILLIMETRES = 0.05, 1.0


def implausible(scene: Scene, bodies: Mapping[str, Body]) -> tuple[Doubt, ...]:
    """Return the numbers of a scene that look as if they were in another unit, in its order.

    None for any rotor between a dental drill and a steam turbine. One number alone tells
    little where the usual range is wide: stiffnesses of bearings between 10 and 1e12 N/m are
    questioned only if the body would sag by more than 2 mm on them.

    `bodies`: from `build_bodies`.
    """
    shapes = [*shapes_of(scene, bodies)]
    found: list[Doubt] = [*_material_doubts(scene, shapes)]
    for shape in shapes:
        found += _first(
            (USUAL["length"], shape.key, shape.length_m),
            (USUAL["radius"], shape.key, shape.radius_m),
            (USUAL["mass"], shape.key, shape.mass_kg),
        )
        for key, disk in shape.disks.items():
            found += _disk_doubts(key, disk, shape.size_m)
        found += _speed_doubts(scene, shape)
    for name in scene.rigid_bodies:
        found += _casing_doubts(scene, name)
    imported = {name: imported_element(name, spec) for name, spec in scene.imported.items()}
    for name, element in imported.items():
        found += _imported_doubts(f"imported.{name}", element)
    for name, law in scene.speed_laws.items():
        found += _assumed_doubts(name, law.assumed if isinstance(law, AbsoluteLaw) else ())
    for bearing in scene.bearings:
        found += _stiffness_doubts(bearing.key, bearing)
    masses = {s.name: s.mass_kg for s in shapes}
    masses |= {name: body.mass_kg for name, body in scene.rigid_bodies.items()}
    # a body that is fixed to the ground does not hang on its bearings
    masses |= {n: e.mass_kg for n, e in imported.items() if e.rigid_body_present[:2].any()}
    found += _sag_doubts(scene, masses)
    found += _unbalance_doubts(scene, {s.name: s for s in shapes})
    found += _fast_bodies(scene, [s.name for s in shapes])
    found += _operating_doubts(scene)
    found += mesh_doubts(scene)
    return tuple(dict.fromkeys(found))


def refuse_bursting(scene: Scene, bodies: Mapping[str, Body]) -> None:
    """Refuse radii of metres at which a body would burst at the speeds asked.

    Smaller ones are refused with the strain that is computed. At its rim a solid disk is strained
    by (1 − ν)/4 ρ v²/E (Timoshenko and Goodier, article 32), a disk with a bore by more.
    `bodies`: from `build_bodies`. Raises GeometryError.
    """
    radii = [
        (f"bodies.{name}.sections[{k}].outer_radius_m", name, max(own.outer_radius_m))
        for name in bodies
        for k, own in enumerate(scene.bodies[name].sections)
    ]
    radii += [
        (f"beams.{n}.outer_radius_m", n, max(b.outer_radius_m)) for n, b in scene.beams.items()
    ]
    materials = {name: {own.material for own in body.sections} for name, body in bodies.items()}
    known = scene_materials(scene)
    materials |= {n: {known[b.material]} for n, b in scene.beams.items() if b.material in known}
    for key, name, radius_m in radii:
        rpm = abs(scene.speed_ratio(name)) * top_speed(scene) * RPM_PER_RAD_S
        rim = rpm / RPM_PER_RAD_S * radius_m
        squares = [
            4.0 * _STRAIN / (1.0 - m.poissons_ratio) * m.youngs_modulus_pa / m.density_kg_per_m3
            for m in materials.get(name, ())
        ]
        held = math.sqrt(max(squares, default=math.inf))
        if radius_m >= _MILLIMETRES and rim > held:
            of = " or ".join(sorted(m.name for m in materials[name]))
            raise GeometryError(
                f"{key}: {radius_m:g} m, whose rim has {rim:.3g} m/s at {rpm:g} rpm; no body of "
                f"{of} holds more than {held:.3g} m/s. Radii are in metres ({radius_m:g} mm is "
                f"{radius_m / 1e3:g}); is this in millimetres, or the speed too high?"
            )


def _assumed_doubts(law: str, assumed: Sequence[str]) -> Iterator[Doubt]:
    """Tables of one direction that stand for both; without cross terms many are."""
    for said in (text for text in assumed if "yy" in text):
        yield Doubt(
            key=f"speed_laws.{law}.file",
            found=said,
            usual="columns of both directions, and of cross terms",
            mistake="The same in x and y on purpose? Then this is as it should be.",
        )


def _first(*judged: tuple[Usual, str, float]) -> list[Doubt]:
    """The first doubt of several: one mistake shows in many numbers."""
    return [doubt for usual, key, value in judged for doubt in usual.doubts(key, value)][:1]


def _material_doubts(scene: Scene, shapes: list[Shape]) -> Iterator[Doubt]:
    """Density and modulus of the scene's own materials, where bodies use them."""
    for name in scene.materials:
        users = [s for s in shapes if name in (m.name for m in s.materials)]
        for material in [m for s in users[:1] for m in s.materials if m.name == name]:
            low, high = _MASSLESS_DENSITY
            massless = low <= material.density_kg_per_m3 <= high and all(
                s.own_mass_kg < _MASSLESS_SHARE * s.mass_kg for s in users
            )
            for key in ("density_kg_per_m3", "youngs_modulus_pa")[massless:]:
                yield from USUAL[key].doubts(f"materials.{name}.{key}", getattr(material, key))


def _disk_doubts(key: str, disk: Disk, size_m: float) -> list[Doubt]:
    """Whether mass and inertias of a rigid disk fit each other and the body."""
    mass, polar = disk.mass_kg, disk.polar_inertia_kg_m2
    diametral = disk.diametral_inertia_kg_m2
    if mass <= 0.0 or max(polar, diametral) <= 0.0:
        return []
    gyration = math.sqrt(max(polar, diametral) / mass)
    found = [*USUAL["gyration"].doubts(key, gyration / size_m, gyration, size_m)]
    if polar > 0.0:
        found += USUAL["needle"].doubts(key, diametral / polar)
        found += _density_doubts(key, mass, polar, diametral)
    return found[:1]


def _density_doubts(key: str, mass: float, polar: float, diametral: float) -> Iterator[Doubt]:
    """Density of the solid disk with these inertias; of a thin one the least it can have."""
    usual, radius = USUAL["rigid density"], math.sqrt(2.0 * polar / mass)
    thick = math.sqrt(max(12.0 * (diametral - 0.5 * polar), 0.0) / mass)
    density = mass / (math.pi * radius**2 * max(thick, radius))
    if thick < 0.1 * radius and density < usual.least:
        return  # a thin ring may have any volume below that
    yield from usual.doubts(key, density)


def _casing_doubts(scene: Scene, name: str) -> Iterator[Doubt]:
    """A casing: its inertia against its mass and its interfaces."""
    key, body = f"rigid_bodies.{name}", scene.rigid_bodies[name]
    places = [*body.interfaces.values(), body.center_of_gravity_m[2]]
    span = max(places) - min(places)
    sizes = ((USUAL["casing mass"], key, body.mass_kg), (USUAL["casing span"], key, span or 1.0))
    if doubts := _first(*sizes):
        yield from doubts
        return
    gyration = math.sqrt(max(body.inertia_kg_m2) / body.mass_kg)
    radius = math.sqrt(2.5) * gyration  # of the solid sphere
    density = body.mass_kg / (4.0 / 3.0 * math.pi * radius**3)
    if (span and gyration > _CASING_GYRATION * span) or density > USUAL["rigid density"].most:
        yield Doubt(
            key=key,
            found=f"a radius of gyration of {gyration:g} m with {body.mass_kg:g} kg and "
            f"interfaces over {span:g} m",
            usual="about the size of the body, with a density below that of metals",
            mistake="kg, kg m² and m expected; is one of them in t, kg mm² or millimetres?",
        )


def _imported_doubts(key: str, element: Superelement) -> list[Doubt]:
    """Matrices from elsewhere: mass, distances, and the frequencies of the body alone."""
    places = np.array([node.position_m for node in element.interfaces])
    span = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    gyration = math.sqrt(float(element.inertia_kg_m2.diagonal().max()) / element.mass_kg)
    lowest = float(element.free_frequencies_hz[0]) if element.free_frequencies_hz.size else 0.0
    found = _first(
        (USUAL["imported mass"], key, element.mass_kg),
        (USUAL["imported span"], key, span or 1.0),
        (USUAL["imported frequency"], key, lowest or 1.0),
    )
    if span:
        found += USUAL["imported gyration"].doubts(key, gyration / span, gyration, span)
    return found[:1]


def _speed_doubts(scene: Scene, shape: Shape) -> Iterator[Doubt]:
    speed = abs(scene.speed_ratio(shape.name)) * top_speed(scene)
    rpm, rim = speed * RPM_PER_RAD_S, speed * shape.radius_m
    if rpm > _SPEED_RPM or rim > _RIM_M_PER_S:
        yield Doubt(
            key=shape.key,
            found=f"{rpm:g} rpm, {rim:.3g} m/s at the rim",
            usual=f"up to {_SPEED_RPM:g} rpm and {_RIM_M_PER_S:g} m/s",
            mistake="rpm and metres expected; is the speed too high, or are lengths in "
            "millimetres?",
        )
        return
    if speed == 0.0 or not shape.materials:
        return
    # first bending of a pinned solid shaft of this size (Euler-Bernoulli)
    material, least = shape.materials[0], USUAL["density_kg_per_m3"].least
    wave = math.sqrt(material.youngs_modulus_pa / max(material.density_kg_per_m3, least))
    bending = 0.25 * math.pi * wave * shape.radius_m / shape.size_m**2
    ratio = speed / (2.0 * math.pi) / bending
    yield from USUAL["bending"].doubts(shape.key, ratio, rpm, bending)


def _stiffness_doubts(key: str, bearing: BearingSpec) -> Iterator[Doubt]:
    """Stiffnesses that neither a contact nor a spring has."""
    given = {
        "stiffness_n_per_m": [k for row in bearing.stiffness_n_per_m for k in row],
        "axial_stiffness_n_per_m": [bearing.axial_stiffness_n_per_m],
    }
    for name, values in given.items():
        odd = [k for k in values if k > 0.0 and not USUAL["stiffness"].fits(k)]
        for value in odd[:1]:
            yield from USUAL["stiffness"].doubts(f"{key}.{name}", value)


def _sag_doubts(scene: Scene, masses: Mapping[str, float]) -> Iterator[Doubt]:
    """How far a body would hang down on its own springs."""
    tables = {name for name, law in scene.speed_laws.items() if isinstance(law, AbsoluteLaw)}
    for name, mass in masses.items():
        joints = [
            b
            for b in scene.bearings
            if name in (b.first.partition(".")[0], b.second.partition(".")[0])
        ]
        free = any({"ux", "uy"} & set(b.rigid) or b.speed_law in tables for b in joints)
        total = sum(max(b.stiffness_n_per_m[0][0], b.stiffness_n_per_m[1][1]) for b in joints)
        if not free and total > 0.0:
            key = f"{joints[0].key}.stiffness_n_per_m"
            yield from USUAL["sag"].doubts(key, mass * _GRAVITY / total, total, name, mass)


def _unbalance_doubts(scene: Scene, shapes: Mapping[str, Shape]) -> Iterator[Doubt]:
    for k, analysis in enumerate(scene.analyses):
        unbalances = getattr(analysis, "unbalances", ())
        given = [(u.at, u.moment_kg_m, f".unbalances[{j}]") for j, u in enumerate(unbalances)]
        moment = getattr(analysis, "moment_kg_m", None)
        place = getattr(analysis, "excite", None) or next(iter(getattr(analysis, "places", ())), "")
        given += [(place, moment, "")] if moment is not None else []
        for at, value, where in given:
            shape = shapes.get(at.partition(".")[0])
            if shape is None or not shape.mass_kg:
                continue
            key, moved = f"analyses[{k}]{where}.moment_kg_m", value / shape.mass_kg
            for doubt in USUAL["eccentricity"].doubts(
                key, moved / shape.size_m, value, shape.name, moved
            ):
                usual = f"less than 0.03 of the body's size, {shape.size_m:g} m"
                yield replace(doubt, usual=usual)


def _fast_bodies(scene: Scene, judged: Collection[str]) -> Iterator[Doubt]:
    """Yield a doubt where a body would turn faster than any rotor does."""
    others = {n: abs(r) for n, r in scene.speed_ratios().items() if n not in judged}
    if not others:
        return
    name, ratio = max(others.items(), key=lambda pair: pair[1])
    rpm = ratio * top_speed(scene) * RPM_PER_RAD_S
    if rpm > _SPEED_RPM:
        yield Doubt(
            key="speeds",
            found=f"{name!r} at up to {rpm:g} rpm",
            usual=f"up to {_SPEED_RPM:g} rpm",
            mistake="rpm expected; is the speed too high, or a speed_ratio?",
        )


def _operating_doubts(scene: Scene) -> Iterator[Doubt]:
    """Yield a doubt where the speeds of the scene end below all operating speeds of its shafts."""
    top_rpm = float(scene_speeds(scene).max()) * RPM_PER_RAD_S
    ranges = [(o.reference_rpm[0], o) for o in operating_speeds(scene)]
    if top_rpm == 0.0 or not ranges:
        return
    lowest, nearest = min(ranges, key=lambda pair: pair[0])
    if lowest <= top_rpm:
        return
    key = "to_rpm" if scene.speeds.list_rpm is None else "list_rpm"
    ends = dict.fromkeys((nearest.from_rpm, nearest.to_rpm))
    own = " to ".join(f"{rpm:g}" for rpm in ends)
    geared = abs(scene.speed_ratio(nearest.shaft)) != 1.0
    of_reference = f", from {lowest:.6g} rpm of the reference shaft on" if geared else ""
    in_rad_s = top_rpm * RPM_PER_RAD_S
    hint = f"is this in rad/s ({in_rad_s:.6g} rpm)?" if in_rad_s >= lowest else "does it end early?"
    yield Doubt(
        key=f"speeds.{key}",
        found=f"{top_rpm:.6g} rpm, and the operating speeds of {nearest.shaft!r} are "
        f"{own} rpm{of_reference}",
        usual="a diagram up to the operating speeds",
        mistake=f"rpm expected; {hint}",
    )
