"""Where a body with features is cut into sectors.

A plane through the axis in which all features are mirrored halves the sector. Without one, the cut
passes between the features if it can; else it goes through blades where it is farthest from edges.
What has one sector and no mirror plane is not cut, but drawn in two halves.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import gcd

import numpy as np

from solidwhirl.geometry import (
    Blade,
    Body,
    Feature,
    Hole,
    RingCut,
    Section,
    Slot,
    mirror_angle,
    places_rad,
    sector_count,
)
from solidwhirl.geometry.feature_shapes import bottom_distance, largest_radius
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.records import FloatArray

# Smallest part of a sector that a cut between the features leaves on either side of it.
_ROOM = 0.02
# Points along every edge of a root: between its corners the angle may have an extremum.
_ALONG = 9
# Steps to the point where a line of a blade meets the surface: the slopes are small.
_STEPS = 20


@dataclass(frozen=True, kw_only=True)
class Cut:
    """The cut of a body: its sector is angle_rad <= θ <= angle_rad + width_rad."""

    count: int  #: Equal sectors of the whole
    mirrored: bool  #: Whether it is the half of a sector, between two mirror planes
    angle_rad: float  #: Of the plane where it begins

    @property
    def whole(self) -> bool:
        """Whether the whole body is meshed at once."""
        return self.count == 1 and not self.mirrored

    @property
    def width_rad(self) -> float:
        """Angle of what is meshed."""
        return (np.pi if self.mirrored else 2.0 * np.pi) / self.count

    @property
    def swept_rad(self) -> float:
        """Angle between the plane where it begins and the next: where it ends, or that of halves.

        Nothing is swept all around: the surface would meet itself.
        """
        return min(self.width_rad, np.pi)


def choose_cut(body: Body) -> Cut:
    """Choose the cut of a body with features. Raises GeometryError: it has none."""
    count, angle = sector_count(body.features), mirror_angle(body)
    if angle is not None:
        return Cut(count=count, mirrored=True, angle_rad=angle)
    # the halves of a whole meet in two planes, both of which stay clear of edges
    return Cut(count=count, mirrored=False, angle_rad=_free_angle(body, max(count, 2)))


def section_named(body: Body, name: str) -> Section:
    """Section of a body by name. Raises MeshingError: there is none."""
    for section in body.sections:
        if section.name == name:
            return section
    raise MeshingError(f"body {body.name!r} has no section {name!r}")


def blade_corners(blade: Blade, section: Section, x_m: FloatArray | float) -> FloatArray:
    """Corners (..., 4, 2) of a blade's cross-sections at distances from the axis: (y, z) [m].

    In the frame of the blade, whose radial line is x. Chord, thickness and stagger change linearly
    from root to tip, and go on so below the root.
    """
    share = (np.asarray(x_m) - largest_radius(section)) / blade.length_m
    ends = (blade.chord_m, blade.thickness_m, blade.stagger_deg)
    chord, thickness, stagger = ((a + share * (b - a))[..., None] for a, b in ends)
    s = 0.5 * chord * np.array([-1.0, 1.0, 1.0, -1.0])
    t = 0.5 * thickness * np.array([-1.0, -1.0, 1.0, 1.0])
    sine, cosine = np.sin(np.radians(stagger)), np.cos(np.radians(stagger))
    middle = 0.5 * (section.start_m + section.end_m) if blade.at_m is None else blade.at_m
    return np.stack([s * sine + t * cosine, middle + s * cosine - t * sine], axis=-1)


def root_outline(blade: Blade, section: Section) -> FloatArray:
    """Points (n, 3) of the line in which a blade meets the surface: (x, y, z) [m], its frame."""
    (r0, r1), width = section.outer_radius_m, section.end_m - section.start_m
    share = np.tile(np.linspace(0.0, 1.0, _ALONG), 4)[:, None]
    row, corner = np.arange(4 * _ALONG), np.repeat(np.arange(4), _ALONG)
    x = np.full(4 * _ALONG, max(r0, r1))
    for _ in range(_STEPS):
        corners = blade_corners(blade, section, x)
        a, b = corners[row, corner], corners[row, (corner + 1) % 4]
        y, z = (a + share * (b - a)).T
        r = r0 + (r1 - r0) * (z - section.start_m) / width
        if np.any(np.abs(y) >= r):
            raise MeshingError(
                f"blades {blade.name!r}: the root is wider than section {section.name!r}"
            )
        x = np.sqrt(r**2 - y**2)
    return np.column_stack([x, y, z])


def angles_of(feature: Feature, body: Body) -> tuple[FloatArray, FloatArray]:
    """Angles [rad] about the middle of a feature: (first, last) it takes, and those of its edges.

    Of a blade the first are those of its root; the edges are those of root and tip.
    """
    if isinstance(feature, Blade):
        section = section_named(body, feature.on)
        x, y, _ = root_outline(feature, section).T
        root = np.arctan2(y, x)
        tip_radius = largest_radius(section) + feature.length_m
        tip = np.arctan2(blade_corners(feature, section, tip_radius)[:, 0], tip_radius)
        corners = root[::_ALONG]
        return np.array([root.min(), root.max()]), np.concatenate([corners, tip])
    if isinstance(feature, Hole):
        half = np.arcsin(min(0.5 * feature.diameter_m / feature.pitch_radius_m, 1.0))
    elif isinstance(feature, RingCut):
        half = 0.5 * np.radians(feature.width_deg)
    else:
        section = section_named(body, feature.within)
        bottom = bottom_distance(feature, section)
        if isinstance(feature, Slot):
            half = np.arctan2(0.5 * feature.width_m, bottom)
        else:
            half = np.arccos(bottom / largest_radius(section))
    return np.array([-half, half]), np.array([-half, half])


def _free_angle(body: Body, count: int) -> float:
    """Angle of a plane, and all others that turns of 1/count take it to, for the cut."""
    sector = 2.0 * np.pi / count
    taken, edges = [], []
    for feature in body.features:
        (low, high), own = angles_of(feature, body)
        places = places_rad(feature)
        for middle in places[: len(places) // gcd(feature.count, count)]:
            taken.append((middle + low, middle + high))
            edges.extend(middle + own)
    between = _between(np.array(taken), sector)
    if between is not None:
        return between
    angles = np.sort(np.array(edges) % sector)
    gaps = np.diff(np.append(angles, angles[0] + sector))
    return float(angles[gaps.argmax()] + 0.5 * gaps.max())


def _between(taken: FloatArray, sector: float) -> float | None:
    """Middle of the widest range of angles that no feature takes, modulo a sector."""
    low, high = taken.T
    shifted = [(a, b) for a, b in zip(low % sector, low % sector + high - low, strict=True)]
    spans = sorted((a + k * sector, b + k * sector) for (a, b), k in product(shifted, (-1, 0, 1)))
    best, width, end = None, 2.0 * _ROOM * sector, -np.inf
    for a, b in spans:
        if a >= 0.0 and a - end > width and end > -np.inf:
            best, width = 0.5 * (a + end), a - end
        end = max(end, b)
    return best
