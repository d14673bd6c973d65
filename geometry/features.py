"""What a body of revolution carries or lacks around its circumference: blades, holes, slots.

Every feature is a set of equal ones, `count` of them at equal angles about the axis z. Angles are
counted from x towards y. What is said here is checked value by value; whether features fit on their
body is found by `solidwhirl.geometry.meridian.feature_fit`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from solidwhirl.geometry.errors import GeometryError, require_finite, require_name
from solidwhirl.geometry.materials import Material

#: Fewest features of one set that a turn about the axis leaves in place as bending needs it.
FEWEST = 3
#: Most features of one set.
MOST = 10_000


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
    #: Angle of the chord to the axis, towards the direction of rotation [°], |stagger| < 90
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
            if not abs(stagger) < 90.0:
                raise GeometryError(
                    f"{where}: stagger at the {end} is {stagger:.9g} deg, must lie between -90 and "
                    "90 deg (both excluded)"
                )
        require_finite(where, 0.0 if self.at_m is None else self.at_m)

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.on


@dataclass(frozen=True, kw_only=True, slots=True)
class Hole:
    """Describe axial through holes of one section, as of a bolt circle.

    Raises GeometryError for no name, a bad count or a length that is not positive.
    """

    kind: ClassVar[str] = "holes"

    name: str  #: Unique among the features of its body
    within: str  #: Section that the holes go through, from its start to its end
    count: int
    pitch_radius_m: float  #: Of the circle of their centres
    diameter_m: float
    angle_deg: float = 0.0  #: Of the first hole's centre

    def __post_init__(self) -> None:
        where = _check_set(self)
        _require_positive(where, diameter=self.diameter_m, **{"pitch radius": self.pitch_radius_m})

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.within


@dataclass(frozen=True, kw_only=True, slots=True)
class Slot:
    """Describe radial slots with parallel walls in the outer surface of one section.

    Raises GeometryError for no name, a bad count, a length that is not positive, no axial range.
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
    angle_deg: float = 0.0  #: Of the first slot's middle

    def __post_init__(self) -> None:
        where = _check_set(self)
        _require_positive(where, width=self.width_m, depth=self.depth_m)
        require_finite(where, self.start_m, self.end_m)
        if self.end_m <= self.start_m:
            raise GeometryError(
                f"{where}: they start at z = {self.start_m:.9g} m and end at z = {self.end_m:.9g} "
                "m; the end must lie beyond the start"
            )

    @property
    def section(self) -> str:
        """Section that the feature belongs to."""
        return self.within


Feature = Blade | Hole | Slot


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
    if not FEWEST <= feature.count <= MOST:
        few = (
            "; a body with one or two of them bends more easily in one plane than in another, and "
            "has no equal sectors to be meshed: spread their mass over a ring or a rigid disk"
        )
        raise GeometryError(
            f"{where}: count is {feature.count}, must be {FEWEST} to {MOST}"
            + (few if 0 < feature.count < FEWEST else "")
        )
    return where


def _require_positive(where: str, **lengths_m: float) -> None:
    for label, value in lengths_m.items():
        if not (math.isfinite(value) and value > 0.0):
            raise GeometryError(f"{where}: {label} is {value} m, must be finite and positive")
