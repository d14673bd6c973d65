"""What a body of revolution carries or lacks around its circumference: blades, holes, slots, ...

Every feature is a set of equal ones, `count` of them at equal angles about the axis z. Angles are
counted from x towards y. What is said here is checked value by value; whether features fit on their
body is found by `solidwhirl.geometry.meridian.feature_fit`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from solidwhirl.geometry.errors import GeometryError, require_finite, require_name
from solidwhirl.geometry.materials import Material
from solidwhirl.rotordyn.core.arrays import FloatArray

#: Fewest equal sectors of a body that bends alike in all planes.
FEWEST = 3
#: Most features of one set.
MOST = 10_000
#: Most slots of one group.
MOST_PER_GROUP = 100


@dataclass(frozen=True, kw_only=True, slots=True)
class Blade:
    """Describe a row of blades on the outer surface of a section.

    A blade is a plate of rectangular cross-section about a radial line, straight between root and
    tip, with a flat tip: at the distance x along its radial line it is |s| <= chord / 2 and
    |t| <= thickness / 2, where s = z cos γ + y sin γ runs along the chord, t = y cos γ - z sin γ
    across it, y is the tangential coordinate of the first blade and γ its stagger. Where the
    surface lies below its largest radius the blade goes on down to it, by the same linear change; a
    root that is longer than the section hangs over, and ends where the surface would be, continued
    in a straight line.

    Raises GeometryError for no name, a bad count, length or stagger.
    """

    kind: ClassVar[str] = "blades"

    name: str  #: Unique among the features of its body
    on: str  #: Section whose outer surface carries the blades
    count: int
    length_m: float  #: From the largest radius of the section to the flat tip
    #: At the root (where the length begins) and at the tip, with linear change between them
    chord_m: tuple[float, float]
    thickness_m: tuple[float, float]
    #: Angle of the chord to the axis, towards the direction of rotation [°], |stagger| <= 180;
    #: 90 lies in the plane of rotation
    stagger_deg: tuple[float, float] = (0.0, 0.0)
    #: Axial place of the radial line [m]; None: the middle of the section
    at_m: float | None = None
    angle_deg: float = 0.0  #: Of the first blade's radial line
    material: Material

    def __post_init__(self) -> None:
        where = _check_set(self)
        _require_positive(where, length=self.length_m)
        for end, chord, thickness, stagger in zip(
            ("root", "tip"), self.chord_m, self.thickness_m, self.stagger_deg, strict=True
        ):
            _require_positive(where, **{f"chord at the {end}": chord})
            _require_positive(where, **{f"thickness at the {end}": thickness})
            if not abs(stagger) <= 180.0:
                raise GeometryError(
                    f"{where}: stagger at the {end} is {stagger:.9g} deg, must lie between -180 "
                    "and 180 deg; 0 is along the axis, 90 in the plane of rotation"
                )
        require_finite(where, 0.0 if self.at_m is None else self.at_m)

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.on


@dataclass(frozen=True, kw_only=True, slots=True)
class Hole:
    """Describe axial holes of one section, as of a bolt circle, through it or blind.

    Raises GeometryError for no name, a bad count, a length that is not positive, no axial range.
    """

    kind: ClassVar[str] = "holes"

    name: str  #: Unique among the features of its body
    within: str  #: Section that the holes are in
    count: int
    pitch_radius_m: float  #: Of the circle of their centres
    diameter_m: float
    #: Axial range [m], within the section; None: from its start, to its end
    start_m: float | None = None
    end_m: float | None = None
    angle_deg: float = 0.0  #: Of the first hole's centre

    def __post_init__(self) -> None:
        where = _check_set(self)
        _require_positive(where, diameter=self.diameter_m, **{"pitch radius": self.pitch_radius_m})
        if self.start_m is not None and self.end_m is not None:
            _require_range(where, self.start_m, self.end_m)
        else:
            require_finite(where, self.start_m or 0.0, self.end_m or 0.0)

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.within


@dataclass(frozen=True, kw_only=True, slots=True)
class Slot:
    """Describe radial slots with parallel walls and a flat bottom in the surface of one section.

    Slots may stand in groups, `per_group` of them `pitch_deg` apart and centred on each of the
    `count` places, as those of a rotor with two poles.

    Raises GeometryError for no name, a bad count, a length that is not positive, no axial range,
    round ends that do not fit into it, groups without a pitch.
    """

    kind: ClassVar[str] = "slots"

    name: str  #: Unique among the features of its body
    within: str  #: Section in whose outer surface they are
    count: int
    width_m: float  #: Tangential distance of the walls
    depth_m: float  #: From the largest radius of the section to the flat bottom
    #: Axial range [m], within the section
    start_m: float
    end_m: float
    angle_deg: float = 0.0  #: Of the middle of the first slot, or of the first group
    per_group: int = 1
    pitch_deg: float | None = None  #: Angle between neighbours of a group
    #: Flat walls, or the half circles of an end mill
    ends: Literal["round", "square"] = "square"

    def __post_init__(self) -> None:
        where = _check_set(self)
        _require_positive(where, width=self.width_m, depth=self.depth_m)
        _require_range(where, self.start_m, self.end_m)
        length = self.end_m - self.start_m
        if self.ends == "round" and length <= self.width_m:
            raise GeometryError(
                f"{where}: they are {length:.9g} m long and {self.width_m:.9g} m wide; with round "
                "ends they must be longer than wide: make them narrower, or the ends square"
            )
        _check_groups(where, self)

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.within


@dataclass(frozen=True, kw_only=True, slots=True)
class Keyway(Slot):
    """Describe keyways: slots that are milled one by one, with round ends unless said otherwise.

    Raises GeometryError as `Slot`.
    """

    kind: ClassVar[str] = "keyways"

    count: int = 1
    ends: Literal["round", "square"] = "round"


@dataclass(frozen=True, kw_only=True, slots=True)
class Flat:
    """Describe flats: what lies beyond planes parallel to the axis is cut off one section.

    Raises GeometryError for no name, a bad count, a length that is not positive, no axial range.
    """

    kind: ClassVar[str] = "flats"

    name: str  #: Unique among the features of its body
    within: str  #: Section in whose outer surface they are
    count: int = 1
    distance_m: float  #: Of the plane from the axis
    #: Axial range [m], within the section
    start_m: float
    end_m: float
    angle_deg: float = 0.0  #: Of the normal of the first one

    def __post_init__(self) -> None:
        where = _check_set(self)
        _require_positive(where, distance=self.distance_m)
        _require_range(where, self.start_m, self.end_m)

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.within


@dataclass(frozen=True, kw_only=True, slots=True)
class RingCut:
    """Describe ring sectors cut out of the outer part of one section, with radial walls.

    Raises GeometryError for no name, a bad count, a length that is not positive, a width that is
    none, no axial range.
    """

    kind: ClassVar[str] = "cuts"

    name: str  #: Unique among the features of its body
    within: str  #: Section in whose outer surface they are
    count: int = 1
    width_deg: float  #: Between the radial walls, below 360
    depth_m: float  #: From the largest radius of the section to the cylindrical bottom
    #: Axial range [m], within the section
    start_m: float
    end_m: float
    angle_deg: float = 0.0  #: Of the first one's middle

    def __post_init__(self) -> None:
        where = _check_set(self)
        _require_positive(where, depth=self.depth_m)
        _require_range(where, self.start_m, self.end_m)
        if not 0.0 < self.width_deg < 360.0:
            raise GeometryError(
                f"{where}: width is {self.width_deg:.9g} deg, must lie between 0 and 360 deg (both "
                "excluded)"
            )

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.within


#: What is cut into the outer surface of a section.
Recess = Slot | Flat | RingCut
Feature = Blade | Hole | Recess


def offsets_rad(feature: Feature) -> FloatArray:
    """Angles [rad] of the features of a group from its place; (0,) of what stands alone."""
    if not isinstance(feature, Slot) or feature.pitch_deg is None:
        return np.zeros(1)
    steps = np.arange(feature.per_group) - 0.5 * (feature.per_group - 1)
    return np.asarray(np.radians(feature.pitch_deg) * steps)


def places_rad(feature: Feature, origin_rad: float = 0.0) -> FloatArray:
    """Angles [rad] of the middles of all features of a set from an origin, place by place."""
    first = np.radians(feature.angle_deg) - origin_rad
    places = first + 2.0 * np.pi * np.arange(feature.count) / feature.count
    return np.asarray(np.add.outer(places, offsets_rad(feature)).ravel())


def sector_count(features: tuple[Feature, ...]) -> int:
    """Return the number of equal sectors that features leave a body: the divisor of all counts.

    Raises GeometryError: no features.
    """
    if not features:
        raise GeometryError("no features; a body of revolution has any number of sectors")
    return math.gcd(*(feature.count for feature in features))


def _check_set(feature: Feature) -> str:
    """Check what all features have, and return what messages call this one."""
    require_name(f"set of {feature.kind}", feature.name)
    where = f"{feature.kind} '{feature.name}'"
    require_finite(where, feature.angle_deg)
    if not 1 <= feature.count <= MOST:
        raise GeometryError(f"{where}: count is {feature.count}, must be 1 to {MOST}")
    return where


def _check_groups(where: str, slot: Slot) -> None:
    most = min(MOST_PER_GROUP, MOST // slot.count)
    if not 1 <= slot.per_group <= most:
        raise GeometryError(f"{where}: per_group is {slot.per_group}, must be 1 to {most}")
    if (slot.per_group > 1) != (slot.pitch_deg is not None):
        raise GeometryError(
            f"{where}: per_group is {slot.per_group} and pitch_deg is "
            f"{'not given' if slot.pitch_deg is None else f'{slot.pitch_deg:.9g}'}; groups of two "
            "or more need a pitch, and slots without groups have none"
        )
    if slot.pitch_deg is not None and not 0.0 < slot.pitch_deg < 360.0:
        raise GeometryError(
            f"{where}: pitch is {slot.pitch_deg:.9g} deg, must lie between 0 and 360 deg (both "
            "excluded)"
        )


def _require_range(where: str, start_m: float, end_m: float) -> None:
    require_finite(where, start_m, end_m)
    if end_m <= start_m:
        raise GeometryError(
            f"{where}: they start at z = {start_m:.9g} m and end at z = {end_m:.9g} m; the end "
            "must lie beyond the start"
        )


def _require_positive(where: str, **lengths_m: float) -> None:
    for label, value in lengths_m.items():
        if not (math.isfinite(value) and value > 0.0):
            raise GeometryError(f"{where}: {label} is {value} m, must be finite and positive")
