"""Blades, holes and slots of the bodies of a scene."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, Field, WithJsonSchema

from solidwhirl.core.fields import (
    MOST,
    Finite,
    Name,
    Positive,
    PositiveEnds,
    Record,
    StaggerEnds,
    several,
)

# Geometry refuses other numbers, with what can be done.
_COUNT = {"type": "integer", "minimum": 3, "maximum": 10_000}
FeatureCount = Annotated[int, Field(strict=True), WithJsonSchema(_COUNT)]


class BladeSpec(Record):
    """A row of equal blades on the outer surface of a section."""

    name: Name
    on: Name
    count: FeatureCount
    length_m: Positive
    chord_m: PositiveEnds
    thickness_m: PositiveEnds
    stagger_deg: StaggerEnds = (0.0, 0.0)
    at_m: Finite | None = None
    angle_deg: Finite = 0.0
    material: Name | None = None


class HoleSpec(Record):
    """Equal axial holes through a section."""

    name: Name
    within: Annotated[Name, Field(alias="in")]
    count: FeatureCount
    pitch_radius_m: Positive
    diameter_m: Positive
    angle_deg: Finite = 0.0


class SlotSpec(Record):
    """Equal radial slots in the outer surface of a section."""

    name: Name
    within: Annotated[Name, Field(alias="in")]
    count: FeatureCount
    width_m: Positive
    depth_m: Positive
    start_m: Finite
    end_m: Finite
    angle_deg: Finite = 0.0


class StageBladesSpec(Record):
    """Blades of all stages of a group."""

    count: Annotated[
        tuple[FeatureCount, ...],
        Field(min_length=1, max_length=MOST),
        BeforeValidator(several),
        WithJsonSchema({"anyOf": [_COUNT, {"type": "array", "items": _COUNT}]}),
    ]
    length_m: Positive
    length_factor: Positive = 1.0
    thickness_m: PositiveEnds
    thickness_factor: Positive = 1.0
    chord_m: PositiveEnds | None = None
    chord_factor: Positive | None = None
    stagger_deg: StaggerEnds = (0.0, 0.0)
    material: Name | None = None
