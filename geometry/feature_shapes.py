"""Where the features of a body are: the angles that they take up, and the volume they add."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from solidwhirl.geometry.features import Blade, Feature, Flat, Hole, Recess, RingCut, Slot
from solidwhirl.geometry.profile import Section
from solidwhirl.rotordyn.core.arrays import FloatArray

# Points of the quadratures: integrands are smooth, these reach round-off on usual shapes.
_ACROSS, _ALONG = 24, 12
# The inclination of a blade's surface is small: each turn gains a digit or more.
_TURNS = 20
# Points along an edge of a blade in a drawing.
_DRAWN = 9
# Staggers with smaller sines are none.
_NO_STAGGER = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Volume:
    """Hold the volume of one feature of a set, whose middle is at θ = 0, as points."""

    volume_m3: FloatArray  #: (n,)
    points_m: FloatArray  #: (n, 3) x, y, z


def gauss_rule(count: int, start: float = 0.0, end: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights (count,) of the Gauss-Legendre rule on an interval."""
    nodes, weights = np.polynomial.legendre.leggauss(count)  # type: ignore[no-untyped-call]
    half = 0.5 * (end - start)
    return start + half * (nodes + 1.0), half * weights


def largest_radius(section: Section) -> float:
    """Largest outer radius [m], from which lengths of blades and depths of slots count."""
    return max(section.outer_radius_m)


def surface_radius(section: Section, axial_m: FloatArray) -> FloatArray:
    """Outer radius [m] at axial places, continued in a straight line beyond the section."""
    first, last = section.outer_radius_m
    share = (axial_m - section.start_m) / (section.end_m - section.start_m)
    return first + share * (last - first)


def blade_place(blade: Blade, section: Section) -> float:
    """Axial place [m] of a blade's radial line."""
    return 0.5 * (section.start_m + section.end_m) if blade.at_m is None else blade.at_m


def blade_section(
    blade: Blade, section: Section, x_m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Chord [m], thickness [m] and stagger [rad] at distances x from the axis, (...) each."""
    share = (x_m - largest_radius(section)) / blade.length_m
    ends = (blade.chord_m, blade.thickness_m, blade.stagger_deg)
    chord, thickness, stagger = (first + share * (last - first) for first, last in ends)
    return chord, thickness, np.radians(stagger)


def blade_root(
    blade: Blade, section: Section, along: FloatArray, across: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Where lines of a blade meet the surface of its section.

    `along`, `across`: s / chord and t / thickness of the lines, from -1/2 to 1/2. Result: distance
    x along the radial line and axial place z [m].
    """
    x = np.full(np.broadcast_shapes(along.shape, across.shape), largest_radius(section))
    z = x
    for _ in range(_TURNS):
        y, dz = _plate_point(blade, section, x, along, across)
        z = blade_place(blade, section) + dz
        x = np.sqrt(np.maximum(surface_radius(section, z) ** 2 - y**2, 0.0))
    return x, z


def _plate_point(
    blade: Blade, section: Section, x_m: FloatArray, along: FloatArray, across: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Tangential place y and axial distance from the radial line [m] of a point of a blade."""
    chord, thickness, stagger = blade_section(blade, section, x_m)
    s, t = chord * along, thickness * across
    y, dz = s * np.sin(stagger) + t * np.cos(stagger), s * np.cos(stagger) - t * np.sin(stagger)
    return y, dz


def hole_range(hole: Hole, section: Section) -> tuple[float, float]:
    """Axial range [m] of a hole: that of its section where it says none."""
    start = section.start_m if hole.start_m is None else hole.start_m
    return start, section.end_m if hole.end_m is None else hole.end_m


def bottom_distance(recess: Recess, section: Section) -> float:
    """Distance [m] of the bottom of a recess from the axis."""
    if isinstance(recess, Flat):
        return recess.distance_m
    return largest_radius(section) - recess.depth_m


def side_view(feature: Feature, section: Section) -> FloatArray:
    """Outline of a feature in the half-plane (z, r), seen along the circumference, (k, 2) [m].

    Of blades it is what the plate's cross-section reaches along the axis, from the surface to the
    flat tip.
    """
    if isinstance(feature, Hole):
        ends = np.array(hole_range(feature, section))
        low, high = feature.pitch_radius_m + 0.5 * feature.diameter_m * np.array([[-1.0], [1.0]])
        return _between(ends, np.broadcast_to(low, 2), np.broadcast_to(high, 2))
    if not isinstance(feature, Blade):
        ends = np.array([feature.start_m, feature.end_m])
        bottom = np.full(2, bottom_distance(feature, section))
        return _between(ends, bottom, surface_radius(section, ends))
    x = largest_radius(section) + feature.length_m * np.linspace(0.0, 1.0, _DRAWN)
    chord, thickness, stagger = blade_section(feature, section, x)
    half = 0.5 * (chord * np.abs(np.cos(stagger)) + thickness * np.abs(np.sin(stagger)))
    place = blade_place(feature, section)
    root = np.array([place - half[0], place + half[0]])
    back, front = np.column_stack([place + half, x]), np.column_stack([place - half, x])
    foot = np.column_stack([root, surface_radius(section, root)])
    return np.vstack([foot, back, front[::-1]])


def _between(axial_m: FloatArray, low_m: FloatArray, high_m: FloatArray) -> FloatArray:
    """A quadrilateral with radial ends, along its lower and back along its upper side."""
    lower, upper = np.column_stack([axial_m, low_m]), np.column_stack([axial_m, high_m])
    return np.vstack([lower, upper[::-1]])


def angular_range(
    feature: Feature, section: Section, axial_m: FloatArray, radius_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Angles [rad] from the middle of a feature at which it begins and ends, in circles (z, r).

    They are in wrong order, by the more the farther off, where it does not meet the circle. The
    flat tips of blades and the surface of the section, which bound a range of radii, are left out.
    """
    if isinstance(feature, Blade):
        return _blade_angles(feature, section, axial_m, radius_m)
    if isinstance(feature, Hole):
        pitch = feature.pitch_radius_m
        square = radius_m**2 + pitch**2 - 0.25 * feature.diameter_m**2
        half = _arc_cosine(square / (2.0 * radius_m * pitch))
    elif isinstance(feature, RingCut):
        half = np.full(np.broadcast_shapes(axial_m.shape, radius_m.shape), _half_width(feature))
    else:
        half = _arc_cosine(bottom_distance(feature, section) / radius_m)
        if isinstance(feature, Slot):
            half = np.minimum(half, np.arcsin(_unit(_half_across(feature, axial_m) / radius_m)))
    return -half, half


def _half_width(cut: RingCut) -> float:
    """Angle [rad] between the middle of a cut and its walls."""
    return 0.5 * math.radians(cut.width_deg)


def _half_across(slot: Slot, axial_m: FloatArray) -> FloatArray:
    """Half the width [m] of a slot at axial places; less in the half circles of round ends."""
    half = 0.5 * slot.width_m
    if slot.ends == "square":
        return np.full(np.shape(axial_m), half)
    beyond = np.maximum(slot.start_m + half - axial_m, axial_m - slot.end_m + half)
    return np.asarray(np.sqrt(np.maximum(half**2 - np.maximum(beyond, 0.0) ** 2, 0.0)))


def _arc_cosine(value: FloatArray) -> FloatArray:
    """Arc cosine, continued by negative values above 1."""
    found: FloatArray = np.where(value > 1.0, 1.0 - value, np.arccos(_unit(value)))
    return found


def _unit(value: FloatArray) -> FloatArray:
    clipped: FloatArray = np.clip(value, -1.0, 1.0)
    return clipped


def _blade_angles(
    blade: Blade, section: Section, axial_m: FloatArray, radius_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Where the four faces of a plate lie in circles; two bound it there."""
    dz, radius = np.broadcast_arrays(axial_m - blade_place(blade, section), radius_m)

    def bounds(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        x = np.sqrt(np.maximum(radius**2 - y**2, 0.0))
        chord, thickness, stagger = blade_section(blade, section, x)
        sine, cosine = np.sin(stagger), np.cos(stagger)
        sine, cosine = (
            np.where(np.abs(part) < _NO_STAGGER, _NO_STAGGER, part) for part in (sine, cosine)
        )
        flanks = [
            (dz * sine + side * np.sign(cosine) * 0.5 * thickness) / cosine for side in (-1.0, 1.0)
        ]
        edges = [(side * np.sign(sine) * 0.5 * chord - dz * cosine) / sine for side in (-1.0, 1.0)]
        return np.maximum(flanks[0], edges[0]), np.minimum(flanks[1], edges[1])

    first = last = np.zeros(dz.shape)
    for _ in range(_TURNS):
        first, last = bounds(first)[0], bounds(last)[1]
    return np.arcsin(_unit(first / radius)), np.arcsin(_unit(last / radius))


def feature_volume(feature: Feature, section: Section) -> Volume:
    """Volume of one feature that fits its section, as it is drawn, by Gauss quadrature."""
    if isinstance(feature, Blade):
        return _blade_volume(feature, section)
    if isinstance(feature, Hole):
        return _hole_volume(feature, section)
    if isinstance(feature, RingCut):
        return _cut_volume(feature, section)
    return _straight_volume(feature, section)


def _volume(volume: FloatArray, x: FloatArray, y: FloatArray, z: FloatArray) -> Volume:
    """Volume at places; arrays that broadcast together."""
    volume, *places = np.broadcast_arrays(volume, x, y, z)
    return Volume(volume_m3=volume.ravel(), points_m=np.stack(places, axis=-1).reshape(-1, 3))


def _hole_volume(hole: Hole, section: Section) -> Volume:
    """A cylinder: three places along the axis and four in the circle have its moments exactly."""
    radius = 0.5 * hole.diameter_m
    z, weights = gauss_rule(3, *hole_range(hole, section))
    x, y = radius / math.sqrt(2.0) * np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]])
    volume = 0.25 * math.pi * radius**2 * weights
    return _volume(volume, hole.pitch_radius_m + x[:, None], y[:, None], z)


def _cut_volume(cut: RingCut, section: Section) -> Volume:
    """The points of a ring, as radii are linear along the axis, at angles of a Gauss rule."""
    angle, weights = gauss_rule(_ACROSS, -_half_width(cut), _half_width(cut))
    z, weights_z = gauss_rule(_ALONG, cut.start_m, cut.end_m)
    share, weights_r = gauss_rule(_ALONG)
    angle, z = angle[:, None, None], z[:, None]
    bottom = bottom_distance(cut, section)
    height = surface_radius(section, z) - bottom
    r = bottom + height * share
    volume = weights[:, None, None] * weights_z[:, None] * height * weights_r * r
    return _volume(volume, r * np.cos(angle), r * np.sin(angle), z)


def _straight_volume(recess: Slot | Flat, section: Section) -> Volume:
    """Columns along x from the flat bottom to the surface.

    Where the width ends in an arc, of round ends or of a flat's rim, y is the sine of an angle: the
    ends are smooth functions of it.
    """
    sine, weights_t = gauss_rule(_ACROSS, -1.0, 1.0)
    z, weights_z = gauss_rule(_ALONG, recess.start_m, recess.end_m)
    share, weights_x = gauss_rule(_ALONG)
    sine, z = sine[:, None, None], z[:, None]
    volume = weights_t[:, None, None] * weights_z[:, None]
    bottom = bottom_distance(recess, section)
    if isinstance(recess, Slot):
        half: float | FloatArray = 0.5 * recess.width_m
        if recess.ends == "round":
            t = 0.5 * math.pi * sine
            sine, cosine = np.sin(t), np.cos(t)
            shorter = half * (1.0 - cosine)
            length = recess.end_m - recess.start_m
            middle = 0.5 * (recess.start_m + recess.end_m)
            z = middle + (z - middle) * (1.0 - 2.0 * shorter / length)
            volume = volume * 0.5 * math.pi * cosine * (1.0 - 2.0 * shorter / length)
        y = half * sine
    else:
        surface = surface_radius(section, z)
        reach = np.arccos(bottom / surface)
        half = surface * reach * np.cos(reach * sine)
        y = surface * np.sin(reach * sine)
    height = np.sqrt(surface_radius(section, z) ** 2 - y**2) - bottom
    volume = volume * half * height * weights_x
    return _volume(volume, bottom + height * share, y, z)


def _blade_volume(blade: Blade, section: Section) -> Volume:
    along, weights_s = gauss_rule(_ACROSS, -0.5, 0.5)
    across, weights_t = gauss_rule(_ALONG, -0.5, 0.5)
    share, weights_x = gauss_rule(_ALONG)
    along, across = along[:, None, None], across[:, None]
    root, _ = blade_root(blade, section, along, across)
    height = largest_radius(section) + blade.length_m - root
    x = root + height * share
    chord, thickness, _ = blade_section(blade, section, x)
    y, dz = _plate_point(blade, section, x, along, across)
    weights = weights_s[:, None, None] * weights_t[:, None] * weights_x
    return _volume(weights * height * chord * thickness, x, y, blade_place(blade, section) + dz)
