"""Mass, centre of gravity and inertia of bodies as they are drawn, free of discretisation error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solidwhirl.geometry.feature_shapes import feature_volume, gauss_rule
from solidwhirl.geometry.features import Blade, Feature, offsets_rad
from solidwhirl.geometry.materials import Material
from solidwhirl.geometry.meridian.contact import refuse_overlaps
from solidwhirl.geometry.meridian.fillets import Fillet
from solidwhirl.geometry.meridian.snapping import scale_of, snap_body
from solidwhirl.geometry.meridian.subdivision import planned_fillets
from solidwhirl.geometry.profile import Body, RigidDisk, Section
from solidwhirl.rotordyn.core.arrays import FloatArray

# Radii vary linearly, so the integrands are polynomials of degree 4 at most: three Gauss points
# (exact to degree 5) give the closed form.
_NODES, _WEIGHTS = gauss_rule(3)
# Along an arc the integrands are entire functions of an angle below pi: 24 points reach round-off.
_ARC_NODES, _ARC_WEIGHTS = gauss_rule(24)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MassProperties:
    """Hold mass, centre of gravity and inertia of a body."""

    mass_kg: float
    center_of_gravity_m: FloatArray  #: (3,) Centre of gravity (x, y, z) [m], read-only
    inertia_kg_m2: FloatArray  #: (3, 3) Inertia tensor about the centre [kg m^2], read-only

    def __post_init__(self) -> None:
        self.center_of_gravity_m.setflags(write=False)
        self.inertia_kg_m2.setflags(write=False)

    @property
    def polar_inertia_kg_m2(self) -> float:
        """Moment of inertia about the line through the centre of gravity along z."""
        return float(self.inertia_kg_m2[2, 2])

    @property
    def diametral_inertia_kg_m2(self) -> float:
        """Mean of the moments of inertia about x and y through the centre of gravity."""
        return 0.5 * float(self.inertia_kg_m2[0, 0] + self.inertia_kg_m2[1, 1])


def section_mass_properties(section: Section) -> MassProperties:
    """Return the mass properties of one section of revolution in closed form.

    Result: exact to round-off, for thin walls too.
    """
    inner_0, inner_1 = section.inner_radius_m
    outer_0, outer_1 = section.outer_radius_m
    inner = inner_0 + _NODES * (inner_1 - inner_0)
    outer = outer_0 + _NODES * (outer_1 - outer_0)
    width = section.end_m - section.start_m
    # Factored differences of powers keep the digits of a thin wall.
    ring = math.pi * (outer - inner) * (outer + inner)
    mass = section.material.density_kg_per_m3 * width * _WEIGHTS * ring
    return _gather(
        mass=mass, axial=section.start_m + width * _NODES, square_radius=0.5 * (outer**2 + inner**2)
    )


def mass_properties(body: Body) -> MassProperties:
    """Return the mass properties of a body: sections, fillets, features and rigid disks.

    Closed form for the sections, Gauss quadrature to round-off for fillets and features. Raises
    GeometryError if sections overlap; with fillets or features, whatever `subdivide` refuses.
    """
    parts = _meshed_parts(body)
    masters = {interface.name: interface.position_m[2] for interface in body.interfaces}
    disks = (_disk_mass_properties(disk, masters[disk.interface]) for disk in body.rigid_disks)
    return _combine([*(part for _, part in parts), *disks])


def masses_beyond_kg(body: Body, low_m: float, high_m: float) -> tuple[float, float]:
    """Return the masses of a body below one place along the axis and above another, kg.

    `low_m`, `high_m`: where sections are cut; fillets, features and rigid disks count where their
    centre of gravity is. Raises GeometryError as `mass_properties`.
    """
    masters = {interface.name: interface.position_m[2] for interface in body.interfaces}
    whole = [part for _, part in _meshed_parts(body)[len(body.sections) :]]
    whole += [_disk_mass_properties(disk, masters[disk.interface]) for disk in body.rigid_disks]
    lumps = [(part.mass_kg, float(part.center_of_gravity_m[2])) for part in whole]
    below, above = sections_beyond_kg(body.sections, low_m, high_m)
    return (
        below + math.fsum(mass for mass, place in lumps if place < low_m),
        above + math.fsum(mass for mass, place in lumps if place > high_m),
    )


def sections_beyond_kg(
    sections: Sequence[Section], low_m: float, high_m: float
) -> tuple[float, float]:
    """Return the masses of sections below one place along the axis and above another, kg."""
    below, above = (
        [section_mass_properties(part).mass_kg for s in sections for part in _between(s, *ends)]
        for ends in ((-math.inf, low_m), (high_m, math.inf))
    )
    return math.fsum(below), math.fsum(above)


def _between(section: Section, low_m: float, high_m: float) -> tuple[Section, ...]:
    """The part of a section between two places; nothing if there is none."""
    start, end = max(section.start_m, low_m), min(section.end_m, high_m)
    if end <= start:
        return ()
    (inner_0, outer_0), (inner_1, outer_1) = section.radii_at(start), section.radii_at(end)
    return (
        replace(
            section,
            start_m=start,
            end_m=end,
            inner_radius_m=(inner_0, inner_1),
            outer_radius_m=(outer_0, outer_1),
        ),
    )


def mass_by_material_kg(body: Body) -> dict[str, float]:
    """Return the mass of sections, fillets and features of a body by material, without rigid disks.

    In the order of the sections, then of the features. Raises GeometryError as `mass_properties`.
    """
    found: dict[str, list[float]] = {}
    for name, part in _meshed_parts(body):
        found.setdefault(name, []).append(part.mass_kg)
    return {name: math.fsum(masses) for name, masses in found.items()}


def _meshed_parts(body: Body) -> list[tuple[str, MassProperties]]:
    """Sections, fillets and features of a body, by the names of their materials."""
    tolerance = scale_of(body).tolerance_m
    refuse_overlaps(snap_body(body, tolerance), tolerance)
    parts = [(s.material.name, section_mass_properties(s)) for s in body.sections]
    for fillet in planned_fillets(body) if body.fillet_radius_m > 0.0 or body.features else ():
        own = body.sections[fillet.section].material
        parts.append((own.name, fillet_mass_properties(fillet, own.density_kg_per_m3)))
    sections = {section.name: section for section in body.sections}
    for feature in body.features:
        section = sections[feature.section]
        own = feature_material(feature, section)
        parts.append((own.name, feature_mass_properties(feature, section)))
    return parts


def feature_material(feature: Feature, section: Section) -> Material:
    """Return the material that a set of features adds or takes away."""
    return feature.material if isinstance(feature, Blade) else section.material


def feature_mass_properties(feature: Feature, section: Section) -> MassProperties:
    """Return the mass properties of all features of a set.

    Those of holes and recesses, which take away, have a negative mass.
    """
    found = feature_volume(feature, section)
    sign = 1.0 if isinstance(feature, Blade) else -1.0
    mass = sign * feature_material(feature, section).density_kg_per_m3 * found.volume_m3
    total = float(mass.sum())
    centre = mass @ found.points_m / total
    arms = found.points_m - centre
    second = arms.T @ (mass[:, None] * arms)
    height = np.array([0.0, 0.0, centre[2]])
    second += total * np.outer(centre - height, centre - height)
    return _repeated(total, centre, second, feature)


def _repeated(
    mass: float, centre: FloatArray, second: FloatArray, feature: Feature
) -> MassProperties:
    """Return the properties of all features of a set from those of the one at θ = 0.

    `second`: ∫ρ x xᵀ dV (3, 3) about the axis, at the height of the centre. Equal turns leave only
    some of the components: what they take is left out, so that round-off can't bring it back.
    """
    waves = np.exp(1j * offsets_rad(feature))
    turn = np.exp(1j * math.radians(feature.angle_deg))
    # x + iy goes round with the angle, its square twice as fast
    first = complex(centre[0], centre[1]) * waves.mean() * turn
    tilt = complex(second[0, 2], second[1, 2]) * waves.mean() * turn
    across = complex(second[0, 0] - second[1, 1], 2.0 * second[0, 1])
    across *= (waves**2).mean() * turn**2
    if feature.count > 1:
        first = tilt = 0.0j
    if feature.count > 2:
        across = 0.0j
    polar = second[0, 0] + second[1, 1]
    number = feature.count * len(waves)
    spread = 0.5 * np.array(
        [
            [polar + across.real, across.imag, 2.0 * tilt.real],
            [across.imag, polar - across.real, 2.0 * tilt.imag],
            [2.0 * tilt.real, 2.0 * tilt.imag, 2.0 * second[2, 2]],
        ]
    )
    middle = np.array([first.real, first.imag, 0.0])
    spread -= mass * np.outer(middle, middle)
    return MassProperties(
        mass_kg=number * mass,
        center_of_gravity_m=middle + np.array([0.0, 0.0, centre[2]]),
        inertia_kg_m2=number * _inertia(spread),
    )


def _inertia(second: FloatArray) -> FloatArray:
    """Inertia tensor (3, 3) of the second moments ∫ρ x xᵀ dV."""
    return np.asarray(np.trace(second) * np.eye(3) - second)


def _combine(parts: Sequence[MassProperties]) -> MassProperties:
    """Return the mass properties of several parts, by the parallel axis theorem."""
    mass = math.fsum(part.mass_kg for part in parts)
    moments = [part.mass_kg * part.center_of_gravity_m for part in parts]
    centre = _sum(moments) / mass
    arms = [part.center_of_gravity_m - centre for part in parts]
    shifted = [
        part.inertia_kg_m2 + _inertia(part.mass_kg * np.outer(arm, arm))
        for part, arm in zip(parts, arms, strict=True)
    ]
    return MassProperties(mass_kg=mass, center_of_gravity_m=centre, inertia_kg_m2=_sum(shifted))


def _sum(arrays: Sequence[FloatArray]) -> FloatArray:
    """Sum of arrays of one shape without rounding in between."""
    columns = np.array(arrays).reshape(len(arrays), -1).T
    return np.array([math.fsum(column) for column in columns]).reshape(arrays[0].shape)


def _gather(mass: FloatArray, axial: FloatArray, square_radius: FloatArray) -> MassProperties:
    """Return the properties of coaxial rings: mass [kg], position [m], mean square radius [m^2]."""
    total = float(mass.sum())
    centre = float(mass @ axial) / total
    polar = float(mass @ square_radius)
    diametral = 0.5 * polar + float(mass @ (axial - centre) ** 2)
    return _round(total, centre, polar, diametral)


def _round(mass: float, axial_m: float, polar: float, diametral: float) -> MassProperties:
    """Return the properties of what is symmetric about z."""
    return MassProperties(
        mass_kg=mass,
        center_of_gravity_m=np.array([0.0, 0.0, axial_m]),
        inertia_kg_m2=np.diag([diametral, diametral, polar]),
    )


def fillet_mass_properties(fillet: Fillet, density_kg_per_m3: float) -> MassProperties:
    """Return the mass properties of a fillet, swept by the segments from its corner to its arc.

    A point is corner + s (arc(t) - corner) with 0 <= s <= 1; the area element is
    s |(arc - corner) x d arc/dt| ds dt.
    """
    spokes = fillet.tangent_points_m - fillet.centre_m
    cross = float(spokes[0, 0] * spokes[1, 1] - spokes[0, 1] * spokes[1, 0])
    sweep = math.atan2(cross, float(spokes[0] @ spokes[1]))
    angle = math.atan2(spokes[0, 1], spokes[0, 0]) + sweep * _ARC_NODES
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    arm = fillet.centre_m + fillet.radius_m * radial - fillet.vertex_m
    # d arc/dt = radius (-sin t, cos t), so arm x d arc/dt = radius (arm . radial).
    area_rate = np.abs(np.einsum("ij,ij->i", arm, radial)) * fillet.radius_m
    weights = abs(sweep) * _ARC_WEIGHTS * area_rate
    areas = np.outer(_WEIGHTS * _NODES, weights).ravel()
    places = fillet.vertex_m + _NODES[:, None, None] * arm
    axial, radius = places[..., 0].ravel(), places[..., 1].ravel()
    return _gather(
        mass=2.0 * math.pi * density_kg_per_m3 * radius * areas,
        axial=axial,
        square_radius=radius**2,
    )


def _disk_mass_properties(disk: RigidDisk, master_m: float) -> MassProperties:
    return _round(
        disk.mass_kg,
        master_m + disk.offset_m,
        disk.polar_inertia_kg_m2,
        disk.diametral_inertia_kg_m2,
    )
