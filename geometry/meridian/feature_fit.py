"""Refusals of features that do not fit on their section, or meet each other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.feature_shapes import (
    angular_range,
    blade_place,
    blade_root,
    blade_section,
    bottom_distance,
    hole_range,
    largest_radius,
    surface_radius,
)
from solidwhirl.geometry.features import (
    Blade,
    Feature,
    Hole,
    Recess,
    Slot,
    offsets_rad,
    places_rad,
)
from solidwhirl.geometry.meridian.fillets import Fillet
from solidwhirl.geometry.meridian.snapping import Scale
from solidwhirl.geometry.profile import Body, Section
from solidwhirl.rotordyn.core.arrays import FloatArray

# Circles (z, r) looked at in each direction; every round looks closer about the worst of the last.
_SAMPLES, _ROUNDS = 33, 3
_SAME_ANGLE = 1e-9

_Radii = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
_Measure = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class _Placed:
    """Hold a feature, its section, what is beside it, and what its messages begin with."""

    feature: Feature
    section: Section
    #: Other sections, and fillets as the rings that they fit in
    beside: tuple[Section, ...]
    features: tuple[Feature, ...]  #: Of the body
    scale: Scale
    where: str


def refuse_misfits(body: Body, fillets: Sequence[Fillet], scale: Scale) -> None:
    """Refuse features that do not fit.

    Blades stand on their section with the middle of the root, and reach into nothing else; holes
    are open where they reach an end of their section and leave rim and bore whole; slots, keyways,
    flats and cuts are open towards the outside, and do not reach the bore; nothing meets its
    neighbours. Touching, and a distance below
    `scale.detail_m`, is meeting. Raises GeometryError naming the feature, what was found and what
    is allowed.
    """
    rings = tuple(_ring(fillet, body) for fillet in fillets)
    placed = [
        _Placed(
            feature=feature,
            section=next(s for s in body.sections if s.name == feature.section),
            beside=tuple(s for s in body.sections if s.name != feature.section) + rings,
            features=body.features,
            scale=scale,
            where=f"body '{body.name}': {feature.kind} '{feature.name}'",
        )
        for feature in body.features
    ]
    for item in placed:
        if isinstance(item.feature, Blade):
            _check_blade(item, item.feature)
        elif isinstance(item.feature, Hole):
            _check_hole(item, item.feature)
        else:
            _check_recess(item, item.feature)
        _refuse_crowding(item)
    for first, second in combinations(placed, 2):
        _refuse_meeting(first, second)


def _ring(fillet: Fillet, body: Body) -> Section:
    """Smallest ring of constant radii around a fillet."""
    points = np.vstack([fillet.vertex_m, fillet.tangent_points_m])
    (start, inner), (end, outer) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return Section(
        name=f"fillet at {fillet.place}",
        start_m=start,
        end_m=end,
        inner_radius_m=(inner, inner),
        outer_radius_m=(outer, outer),
        material=body.sections[fillet.section].material,
    )


def _check_hole(item: _Placed, hole: Hole) -> None:
    section, detail = item.section, item.scale.detail_m
    low, high = hole.pitch_radius_m - hole.diameter_m / 2, hole.pitch_radius_m + hole.diameter_m / 2
    bore, rim = max(section.inner_radius_m), min(section.outer_radius_m)
    if low < bore + detail or high > rim - detail:
        raise GeometryError(
            f"{item.where}: they reach from r = {low:.6g} m to {high:.6g} m, must stay clear of "
            f"bore and rim of section '{section.name}', r = {bore:.6g} m and {rim:.6g} m"
        )
    for mouth in _mouths(item, hole):
        for other in item.beside:
            off = max(other.start_m - mouth, mouth - other.end_m)
            inner, outer = _radii_at(other, np.array(mouth))
            if off > item.scale.tolerance_m or inner > high + detail or outer < low - detail:
                continue
            if not any(_continues(f, item, hole, (other, mouth)) for f in item.features):
                raise GeometryError(
                    f"{item.where}: '{other.name}' closes them at z = {mouth:.6g} m, where it "
                    f"reaches from r = {float(inner):.6g} m to {float(outer):.6g} m; holes are "
                    "open where they leave their section: give it equal holes, or move them"
                )


def _mouths(item: _Placed, hole: Hole) -> list[float]:
    """Ends of its section that a hole reaches; a blind one reaches one of them."""
    section, tolerance = item.section, item.scale.tolerance_m
    _check_axial_range(item, hole_range(hole, section))
    ends = zip(hole_range(hole, section), (section.start_m, section.end_m), strict=True)
    mouths = [end for own, end in ends if abs(own - end) <= tolerance]
    if not mouths:
        start, end = hole_range(hole, section)
        raise GeometryError(
            f"{item.where}: they reach from z = {start:.6g} m to {end:.6g} m and are closed at "
            f"both ends; a hole begins at an end of section '{section.name}', z = "
            f"{section.start_m:.6g} m or {section.end_m:.6g} m"
        )
    return mouths


def _check_axial_range(item: _Placed, range_m: tuple[float, float]) -> None:
    section, tolerance = item.section, item.scale.tolerance_m
    if range_m[0] < section.start_m - tolerance or range_m[1] > section.end_m + tolerance:
        raise GeometryError(
            f"{item.where}: they reach from z = {range_m[0]:.6g} m to {range_m[1]:.6g} m, must "
            f"stay within section '{section.name}', z = {section.start_m:.6g} m to "
            f"{section.end_m:.6g} m"
        )
    if range_m[1] - range_m[0] < item.scale.detail_m:
        raise GeometryError(
            f"{item.where}: they end at z = {range_m[1]:.6g} m, where or before they start"
        )


def _continues(found: Feature, item: _Placed, hole: Hole, at: tuple[Section, float]) -> bool:
    """Whether a feature is the same holes in another section, from the place z of a mouth on."""
    section, mouth = at
    if not isinstance(found, Hole) or found.within != section.name or found.count != hole.count:
        return False
    pitch = 2.0 * math.pi / hole.count
    turn = math.radians(found.angle_deg - hole.angle_deg)
    same = math.isclose(found.pitch_radius_m, hole.pitch_radius_m, rel_tol=1e-9)
    same = same and math.isclose(found.diameter_m, hole.diameter_m, rel_tol=1e-9)
    off = min(abs(end - mouth) for end in hole_range(found, section))
    same = same and off <= item.scale.tolerance_m
    return same and abs(math.remainder(turn, pitch)) < _SAME_ANGLE


def _check_recess(item: _Placed, recess: Recess) -> None:
    section, tolerance, detail = item.section, item.scale.tolerance_m, item.scale.detail_m
    _check_axial_range(item, (recess.start_m, recess.end_m))
    z = np.linspace(recess.start_m, recess.end_m, _SAMPLES)
    bottom = bottom_distance(recess, section)
    bore, surface = float(_radii_at(section, z)[0].max()), surface_radius(section, z)
    if bottom < bore + detail:
        raise GeometryError(
            f"{item.where}: their bottom is at r = {bottom:.6g} m, must be beyond the bore of "
            f"section '{section.name}', r = {bore:.6g} m"
        )
    lowest = float(surface.min())
    half = 0.5 * recess.width_m if isinstance(recess, Slot) else 0.0
    edge = math.sqrt(max(lowest**2 - half**2, 0.0))
    if edge < bottom + detail:
        walls = " at their walls" if half else ""
        raise GeometryError(
            f"{item.where}: their bottom is {bottom:.6g} m from the axis, the surface of section "
            f"'{section.name}'{walls} only {edge:.6g} m; they are open towards the outside all "
            "along: make them deeper, narrower or shorter"
        )
    for other in item.beside:
        start, end = max(other.start_m, recess.start_m), min(other.end_m, recess.end_m)
        z = np.linspace(start, end, _SAMPLES)
        inner, outer = _radii_at(other, z)
        surface = surface_radius(section, z)
        covered = (inner < surface + tolerance) & (outer > surface + tolerance)
        if end - start > tolerance and covered.any():
            raise GeometryError(
                f"{item.where}: '{other.name}' covers them at z = "
                f"{float(z[np.argmax(covered)]):.6g} m; they are open towards the outside"
            )


def _check_blade(item: _Placed, blade: Blade) -> None:
    section, tolerance = item.section, item.scale.tolerance_m
    place = blade_place(blade, section)
    if not section.start_m < place < section.end_m:
        raise GeometryError(
            f"{item.where}: their radial line is at z = {place:.6g} m, must stand on section "
            f"'{section.name}', between z = {section.start_m:.6g} m and {section.end_m:.6g} m"
        )
    if _lowest(blade, section) <= 0.0:
        raise GeometryError(
            f"{item.where}: the root is wider than the surface r = {largest_radius(section):.6g} m "
            f"of section '{section.name}' that it stands on; allowed is a smaller chord or stagger"
        )
    first, last = _axial_range(blade, section)
    for other in item.beside:
        start, end = max(other.start_m, first), min(other.end_m, last)
        if end - start <= tolerance:
            continue

        def radii(z_m: FloatArray, other: Section = other) -> tuple[FloatArray, FloatArray]:
            low, high = _radial_range(blade, section, z_m)
            inner, outer = _radii_at(other, z_m)
            return np.maximum(low, inner) + tolerance, np.minimum(high, outer) - tolerance

        def width(z_m: FloatArray, r_m: FloatArray) -> FloatArray:
            angles = angular_range(blade, section, z_m, r_m)
            return (angles[1] - angles[0]) * r_m

        found, z_m, r_m = _worst((start, end), radii, width)
        if found > tolerance:
            raise GeometryError(
                f"{item.where}: they reach into '{other.name}' at z = {z_m:.6g} m, "
                f"r = {r_m:.6g} m; allowed is what stays clear of everything but section "
                f"'{section.name}'"
            )


def _refuse_crowding(item: _Placed) -> None:
    """Refuse features of one set that meet."""
    feature, section = item.feature, item.section
    places = np.sort(places_rad(feature) % (2.0 * math.pi))
    pitch = float(np.diff(places, append=places[0] + 2.0 * math.pi).min())

    def overlap(z_m: FloatArray, r_m: FloatArray) -> FloatArray:
        first, last = angular_range(feature, section, z_m, r_m)
        return (last - first - pitch) * r_m

    found, z, r = _worst(
        _axial_range(feature, section), lambda z_m: _radial_range(feature, section, z_m), overlap
    )
    if found > -item.scale.detail_m:
        raise GeometryError(
            f"{item.where}: neighbours meet at z = {z:.6g} m, r = {r:.6g} m, where one takes "
            f"{found + pitch * r:.6g} m of the circumference and {len(places)} of them leave "
            f"{pitch * r:.6g} m to each; allowed are fewer or smaller ones"
        )


def _refuse_meeting(one: _Placed, other: _Placed) -> None:
    """Refuse features of two sets that meet.

    All but blades are cut into their own sections, where two of them that meet at the ends go on in
    each other.
    """
    blades = any(isinstance(item.feature, Blade) for item in (one, other))
    if not blades and one.section.name != other.section.name:
        return
    pair = [(item.feature, item.section) for item in (one, other)]
    ranges = [_axial_range(*item) for item in pair]
    start, end = max(r[0] for r in ranges), min(r[1] for r in ranges)
    if end < start - one.scale.tolerance_m:
        return
    pitch = 2.0 * math.pi / math.lcm(*(feature.count for feature, _ in pair))
    turn = math.radians(one.feature.angle_deg - other.feature.angle_deg)
    turns = turn + np.subtract.outer(*(offsets_rad(feature) for feature, _ in pair)).ravel()

    def radii(z_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        (low, high), (low_2, high_2) = (_radial_range(*item, z_m) for item in pair)
        return np.maximum(low, low_2), np.minimum(high, high_2)

    def overlap(z_m: FloatArray, r_m: FloatArray) -> FloatArray:
        (first, last), (first_2, last_2) = (angular_range(*item, z_m, r_m) for item in pair)
        # the middles are nearest to each other in one of the places that both counts allow
        middles = np.add.outer(turns, 0.5 * (first + last - first_2 - last_2))
        nearest = np.abs((middles + 0.5 * pitch) % pitch - 0.5 * pitch).min(axis=0)
        widths = last - first, last_2 - first_2
        common = np.minimum(0.5 * (widths[0] + widths[1]) - nearest, np.minimum(*widths))
        return common * r_m

    found, z, r = _worst((start, end), radii, overlap)
    if found > -one.scale.detail_m:
        raise GeometryError(
            f"{one.where} and {other.feature.kind} '{other.feature.name}' meet at z = {z:.6g} m, "
            f"r = {r:.6g} m; features must stay clear of each other"
        )


def _worst(
    axial_m: tuple[float, float], radii: _Radii, measure: _Measure
) -> tuple[float, float, float]:
    """Return the largest value of a measure in a region of the meridian, and the place (z, r).

    `radii`: between which the region lies at axial places; where they are in wrong order there is
    no region.
    """
    window = np.array([[0.0, 1.0], [0.0, 1.0]])
    best = (-math.inf, axial_m[0], 0.0)
    for _ in range(_ROUNDS):
        across, up = np.linspace(window[:, 0], window[:, 1], _SAMPLES, axis=1)
        z = (axial_m[0] + across * (axial_m[1] - axial_m[0]))[:, None]
        low, high = radii(z)
        r = low + up * (high - low)
        # round-off where two regions touch
        valid = np.broadcast_to(high - low >= -1e-12 * np.abs(high), r.shape)
        values = np.where(valid, measure(np.broadcast_to(z, r.shape), r), -math.inf)
        k, m = np.unravel_index(int(np.argmax(values)), values.shape)
        best = max(best, (float(values[k, m]), float(z[k, 0]), float(r[k, m])))
        steps = (window[:, 1] - window[:, 0]) / (_SAMPLES - 1)
        centre = np.array([across[k], up[m]])
        window = np.clip(np.column_stack([centre - 2 * steps, centre + 2 * steps]), 0.0, 1.0)
    return best


def _radii_at(section: Section, axial_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Inner and outer radius [m] of a section, of its nearer end beyond it."""
    ends = (section.start_m, section.end_m)
    inner, outer = section.inner_radius_m, section.outer_radius_m
    return np.interp(axial_m, ends, inner), np.interp(axial_m, ends, outer)


def _lowest(blade: Blade, section: Section) -> float:
    """Least distance along the radial line [m] at which a blade leaves the surface."""
    line, ends = np.linspace(-0.5, 0.5, _SAMPLES), np.array([[-0.5], [0.5]])
    return min(
        float(blade_root(blade, section, *pair)[0].min()) for pair in ((line, ends), (ends, line))
    )


def _axial_range(feature: Feature, section: Section) -> tuple[float, float]:
    if isinstance(feature, Hole):
        return hole_range(feature, section)
    if not isinstance(feature, Blade):
        return feature.start_m, feature.end_m
    half = max(axial for axial, _ in _half_widths(feature, section))
    place = blade_place(feature, section)
    return place - half, place + half


def _radial_range(
    feature: Feature, section: Section, axial_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    if isinstance(feature, Hole):
        middle, half = np.full_like(axial_m, feature.pitch_radius_m), 0.5 * feature.diameter_m
        return middle - half, middle + half
    surface = surface_radius(section, axial_m)
    if not isinstance(feature, Blade):
        return np.full_like(axial_m, bottom_distance(feature, section)), surface
    tip = largest_radius(section) + feature.length_m
    sideways = max(tangential for _, tangential in _half_widths(feature, section))
    return surface, np.full_like(surface, math.hypot(tip, sideways))


def _half_widths(blade: Blade, section: Section) -> Iterator[tuple[float, float]]:
    """Half the axial and the tangential width [m] of cross-sections from root to tip."""
    x = np.linspace(_lowest(blade, section), largest_radius(section) + blade.length_m, _SAMPLES)
    chord, thickness, stagger = blade_section(blade, section, x)
    sine, cosine = np.abs(np.sin(stagger)), np.abs(np.cos(stagger))
    axial, tangential = chord * cosine + thickness * sine, chord * sine + thickness * cosine
    return zip((0.5 * axial).tolist(), (0.5 * tangential).tolist(), strict=True)
