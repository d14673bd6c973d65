"""Doubts about units: numbers a thousand times off from what rotors have, as millimetres give.

Nothing here refuses a scene. The limits lie beyond a dental drill of 1 mm and a steam turbine
train of 300 t and 60 m.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from solidwhirl.geometry import Body
from solidwhirl.imported_bodies import imported_element
from solidwhirl.interface_documents import cut_doubts
from solidwhirl.plausibility_records import Doubt
from solidwhirl.plausibility_shapes import (
    RigidMass,
    Shape,
    beam_shapes,
    body_shapes,
    mesh_shapes,
)
from solidwhirl.plausibility_speeds import SPEED_RPM, fast_bodies, operating_doubts
from solidwhirl.rotordyn import Superelement
from solidwhirl.scene import Scene
from solidwhirl.scene_joints import BearingSpec, RigidBodySpec
from solidwhirl.speeds_asked import top_speed

# Usual ranges: size and mass of a body, and its material.
_LENGTH_M = (5e-4, 100.0)
_RADIUS_M = (2e-5, 10.0)
_MASS_KG = (1e-6, 5e6)
_DENSITY = (300.0, 25_000.0)
_MODULUS_PA = (5e8, 1.3e12)
# A shaft without mass of its own, as closed forms have it, beside disks that carry the mass.
_MASSLESS_DENSITY, _MASSLESS_SHARE = (1e-6, 2.0), 0.1
# Radius of gyration of a rigid mass over the largest dimension of what it sits on.
_GYRATION = 3.0
# The same of a casing over the distance of its interfaces.
_CASING_GYRATION = 10.0
# Diametral over polar inertia: a rigid mass of a hundred times is a needle of 25 diameters.
_NEEDLE = 100.0
# Density of a rigid mass in the volume that its inertias leave it.
_RIGID_DENSITY = (5.0, 25_000.0)
# Bearings: stiffest contact, softest spring, and how far a body sags on all of its own.
_STIFFNESS = (10.0, 1e12)
_SAG_M = 2e-3
_GRAVITY = 9.81
# Lowest elastic frequency of a body alone.
_LOWEST_HZ = (0.05, 1e6)
# Speed at the rim, and speed over the first bending frequency of a bare shaft.
_RIM_M_PER_S = 1500.0
_SPEED_RATIO = 500.0
# Displacement of the centre of gravity by an unbalance over the size of the body.
_ECCENTRICITY = 0.03


def implausible(scene: Scene, bodies: Mapping[str, Body]) -> tuple[Doubt, ...]:
    """Return the numbers of a scene that look as if they were in another unit.

    Parameters
    ----------
    scene
        The scene.
    bodies
        Its geometry (see `solidwhirl.bodies.build_bodies`).

    Returns
    -------
    tuple of Doubt
        In the order of the scene; empty for every rotor between a dental drill and a steam turbine.

    Notes
    -----
    One number alone tells little where the usual range is wide: stiffnesses of bearings between
    10 and 1e12 N/m are questioned only if the body would sag by more than 2 mm on them.
    """
    shapes = [*body_shapes(scene, bodies), *mesh_shapes(scene), *beam_shapes(scene)]
    found: list[Doubt] = [*_material_doubts(scene, shapes)]
    for shape in shapes:
        found += _size_doubts(shape)
        for rigid in shape.rigid:
            found += _rigid_doubts(rigid, shape.size_m)
        found += _speed_doubts(scene, shape)
    for name, body in scene.rigid_bodies.items():
        found += _rigid_body_doubts(name, body)
    imported = {name: imported_element(name, spec) for name, spec in scene.imported.items()}
    for name, element in imported.items():
        found += _imported_doubts(name, element)
    for k, bearing in enumerate(scene.bearings):
        found += _stiffness_doubts(f"bearings[{k}]", bearing)
    masses = {s.name: s.mass_kg for s in shapes}
    masses |= {name: body.mass_kg for name, body in scene.rigid_bodies.items()}
    # a body that is fixed to the ground does not hang on its bearings
    masses |= {n: e.mass_kg for n, e in imported.items() if e.rigid_body_present[:2].any()}
    found += _sag_doubts(scene, masses)
    found += _unbalance_doubts(scene, {s.name: s for s in shapes})
    found += fast_bodies(scene, [s.name for s in shapes])
    found += operating_doubts(scene)
    found += cut_doubts(scene)
    return tuple(found)


def _beyond(value: float, limits: tuple[float, float]) -> bool:
    return not limits[0] <= value <= limits[1]


def _range(limits: tuple[float, float], unit: str) -> str:
    return f"{limits[0]:g} to {limits[1]:g} {unit}"


def _material_doubts(scene: Scene, shapes: list[Shape]) -> Iterator[Doubt]:
    """Density and modulus of the scene's own materials, where bodies use them."""
    for name in scene.materials:
        users = [s for s in shapes if name in (m.name for m in s.materials)]
        for material in [m for s in users[:1] for m in s.materials if m.name == name]:
            density, modulus = material.density_kg_per_m3, material.youngs_modulus_pa
            massless = not _beyond(density, _MASSLESS_DENSITY) and all(
                s.own_mass_kg < _MASSLESS_SHARE * s.mass_kg for s in users
            )
            if _beyond(density, _DENSITY) and not massless:
                yield Doubt(
                    key=f"materials.{name}.density_kg_per_m3",
                    found=f"{density:g} kg/m³",
                    usual=_range(_DENSITY, "kg/m³") + " (steel 7800)",
                    mistake="kg/m³ expected; is this in g/cm³ or t/mm³?",
                )
            if _beyond(modulus, _MODULUS_PA):
                yield Doubt(
                    key=f"materials.{name}.youngs_modulus_pa",
                    found=f"{modulus:g} Pa",
                    usual=_range(_MODULUS_PA, "Pa") + " (steel 2e11)",
                    mistake="Pa expected; is this in MPa (N/mm²) or GPa?",
                )


def _size_doubts(shape: Shape) -> Iterator[Doubt]:
    for value, limits, what in (
        (shape.length_m, _LENGTH_M, "long"),
        (shape.radius_m, _RADIUS_M, "in radius"),
    ):
        if _beyond(value, limits):
            yield Doubt(
                key=shape.key,
                found=f"{value:g} m {what}",
                usual=_range(limits, "m"),
                mistake="metres expected; are these millimetres?",
            )
            return
    if _beyond(shape.mass_kg, _MASS_KG):
        yield Doubt(
            key=shape.key,
            found=f"{shape.mass_kg:g} kg with its disks, from sizes and density",
            usual=_range(_MASS_KG, "kg"),
            mistake="metres and kg/m³ expected; are lengths in millimetres, or the density in "
            "another unit?",
        )


def _rigid_doubts(rigid: RigidMass, size_m: float) -> Iterator[Doubt]:
    """Whether mass and inertias of a rigid mass fit each other and the body."""
    mass, polar, diametral = rigid.mass_kg, rigid.polar_kg_m2, rigid.diametral_kg_m2
    if mass <= 0.0 or max(polar, diametral) <= 0.0:
        return
    gyration = math.sqrt(max(polar, diametral) / mass)
    if gyration > _GYRATION * size_m:
        yield Doubt(
            key=rigid.key,
            found=f"a radius of gyration of {gyration:g} m on a body of {size_m:g} m",
            usual=f"at most {_GYRATION:g} times the body's size",
            mistake="kg, kg m² and m expected; are masses in t, inertias in kg mm² or g m², or "
            "lengths in millimetres?",
        )
        return
    if polar > 0.0 and diametral > _NEEDLE * polar:
        yield Doubt(
            key=rigid.key,
            found=f"a diametral inertia {diametral / polar:.3g} times the polar one",
            usual=f"0.5 to {_NEEDLE:g} times",
            mistake="kg m² expected for both; is one of them in another unit?",
        )
        return
    density = _rigid_density(mass, polar, diametral)
    if density is not None and _beyond(density, _RIGID_DENSITY):
        yield Doubt(
            key=rigid.key,
            found=f"mass and inertias of a disk of {density:.2g} kg/m³",
            usual=_range(_RIGID_DENSITY, "kg/m³"),
            mistake="kg and kg m² expected; is the mass in t or g, or an inertia in another unit?",
        )


def _rigid_density(mass: float, polar: float, diametral: float) -> float | None:
    """Density of the solid disk with these inertias; of a thin one the least it can have."""
    if polar <= 0.0:
        return None
    radius = math.sqrt(2.0 * polar / mass)
    thick = math.sqrt(max(12.0 * (diametral - 0.5 * polar), 0.0) / mass)
    density = mass / (math.pi * radius**2 * max(thick, radius))
    if thick < 0.1 * radius and density < _RIGID_DENSITY[0]:
        return None  # a thin ring may have any volume below that
    return density


def _rigid_body_doubts(name: str, body: RigidBodySpec) -> Iterator[Doubt]:
    """A casing: its inertia against its mass and its interfaces."""
    key = f"rigid_bodies.{name}"
    places = [*body.interfaces.values(), body.center_of_gravity_m[2]]
    span = max(places) - min(places)
    for value, limits, unit, mistake in (
        (body.mass_kg, _MASS_KG, "kg", "kg expected; is this in t or g?"),
        (span or 1.0, _LENGTH_M, "m long", "metres expected; are these millimetres?"),
    ):
        if _beyond(value, limits):
            usual = _range(limits, unit)
            yield Doubt(key=key, found=f"{value:g} {unit}", usual=usual, mistake=mistake)
            return
    gyration = math.sqrt(max(body.inertia_kg_m2) / body.mass_kg)
    radius = math.sqrt(2.5) * gyration  # of the solid sphere
    density = body.mass_kg / (4.0 / 3.0 * math.pi * radius**3)
    if (span and gyration > _CASING_GYRATION * span) or density > _RIGID_DENSITY[1]:
        yield Doubt(
            key=key,
            found=f"a radius of gyration of {gyration:g} m with {body.mass_kg:g} kg and "
            f"interfaces over {span:g} m",
            usual="about the size of the body, with a density below that of metals",
            mistake="kg, kg m² and m expected; is one of them in t, kg mm² or millimetres?",
        )


def _imported_doubts(name: str, element: Superelement) -> Iterator[Doubt]:
    """Matrices from elsewhere: mass, distances, and the frequencies of the body alone."""
    key = f"imported.{name}"
    places = np.array([node.position_m for node in element.interfaces])
    span = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    gyration = math.sqrt(float(element.inertia_kg_m2.diagonal().max()) / element.mass_kg)
    lowest = float(element.free_frequencies_hz[0]) if element.free_frequencies_hz.size else None
    units = "are length_unit and mass_unit those of the file?"
    checks = [
        (element.mass_kg, _MASS_KG, "kg", units),
        (span or 1.0, _LENGTH_M, "m between its interfaces", units),
        (lowest or 1.0, _LOWEST_HZ, "Hz, its lowest elastic frequency", f"{units} Seconds?"),
    ]
    for value, limits, unit, mistake in checks:
        if _beyond(value, limits):
            usual = _range(limits, unit.partition(" ")[0].rstrip(","))
            yield Doubt(key=key, found=f"{value:g} {unit}", usual=usual, mistake=mistake)
            return
    if span and gyration > _CASING_GYRATION * span:
        yield Doubt(
            key=key,
            found=f"a radius of gyration of {gyration:g} m and interfaces over {span:g} m",
            usual="about the size of the body",
            mistake=f"places and matrices may be in different units; {units}",
        )


def _speed_doubts(scene: Scene, shape: Shape) -> Iterator[Doubt]:
    speed = abs(scene.speed_ratio(shape.name)) * top_speed(scene)
    if speed == 0.0:
        return
    rpm, rim = speed * 30.0 / math.pi, speed * shape.radius_m
    if rpm > SPEED_RPM or rim > _RIM_M_PER_S:
        yield Doubt(
            key=shape.key,
            found=f"{rpm:g} rpm, {rim:.3g} m/s at the rim",
            usual=f"up to {SPEED_RPM:g} rpm and {_RIM_M_PER_S:g} m/s",
            mistake="rpm and metres expected; is the speed too high, or are lengths in "
            "millimetres?",
        )
        return
    if not shape.materials:
        return
    # first bending of a pinned solid shaft of this size (Euler-Bernoulli)
    material = shape.materials[0]
    wave = math.sqrt(material.youngs_modulus_pa / max(material.density_kg_per_m3, _DENSITY[0]))
    bending = 0.25 * math.pi * wave * shape.radius_m / shape.size_m**2
    ratio = speed / (2.0 * math.pi) / bending
    if ratio > _SPEED_RATIO:
        yield Doubt(
            key=shape.key,
            found=f"{rpm:g} rpm, {ratio:.2g} times the first bending frequency of a bare shaft of "
            f"this size, about {bending:.2g} Hz",
            usual=f"at most {_SPEED_RATIO:g} times",
            mistake="metres, Pa, kg/m³ and rpm expected; is one of them in another unit?",
        )


def _stiffness_doubts(key: str, bearing: BearingSpec) -> Iterator[Doubt]:
    """Stiffnesses that neither a contact nor a spring has."""
    given = {
        "stiffness_n_per_m": [k for row in bearing.stiffness_n_per_m for k in row],
        "axial_stiffness_n_per_m": [bearing.axial_stiffness_n_per_m],
    }
    for name, values in given.items():
        odd = [k for k in values if k > 0.0 and _beyond(k, _STIFFNESS)]
        if odd:
            yield Doubt(
                key=f"{key}.{name}",
                found=f"{odd[0]:g} N/m",
                usual=_range(_STIFFNESS, "N/m"),
                mistake='N/m expected; a rigid support is written rigid = ["ux", "uy"]',
            )


def _sag_doubts(scene: Scene, masses: Mapping[str, float]) -> Iterator[Doubt]:
    """How far a body would hang down on its own springs."""
    for name, mass in masses.items():
        joints = [
            (k, b)
            for k, b in enumerate(scene.bearings)
            if name in (b.first.partition(".")[0], b.second.partition(".")[0])
        ]
        free = any({"ux", "uy"} & set(b.rigid) or b.speed_law in _tables(scene) for _, b in joints)
        total = sum(max(b.stiffness_n_per_m[0][0], b.stiffness_n_per_m[1][1]) for _, b in joints)
        if free or total <= 0.0 or mass * _GRAVITY <= _SAG_M * total:
            continue
        yield Doubt(
            key=f"bearings[{joints[0][0]}].stiffness_n_per_m",
            found=f"{total:g} N/m hold {name!r}, {mass:g} kg: it would sag by "
            f"{mass * _GRAVITY / total:.2g} m under its weight",
            usual=f"less than {_SAG_M:g} m",
            mistake="N/m and kg expected; are stiffnesses in N/mm, masses in g, or lengths in "
            "millimetres?",
        )


def _tables(scene: Scene) -> set[str | None]:
    return {name for name, law in scene.speed_laws.items() if law.kind == "table"}


def _unbalance_doubts(scene: Scene, shapes: Mapping[str, Shape]) -> Iterator[Doubt]:
    for k, analysis in enumerate(scene.analyses):
        given = [(u.at, u.moment_kg_m, f".unbalances[{j}]") for j, u in
                 enumerate(getattr(analysis, "unbalances", ()))]  # fmt: skip
        moment = getattr(analysis, "moment_kg_m", None)
        place = getattr(analysis, "excite", None) or next(iter(getattr(analysis, "places", ())), "")
        given += [(place, moment, "")] if moment is not None else []
        for at, value, where in given:
            shape = shapes.get(at.partition(".")[0])
            if shape is None or value <= _ECCENTRICITY * shape.size_m * shape.mass_kg:
                continue
            yield Doubt(
                key=f"analyses[{k}]{where}.moment_kg_m",
                found=f"{value:g} kg m, which moves the centre of gravity of {shape.name!r} by "
                f"{value / shape.mass_kg:.2g} m",
                usual=f"less than {_ECCENTRICITY:g} of the body's size, {shape.size_m:g} m",
                mistake="kg m expected; is this in g mm?",
            )
