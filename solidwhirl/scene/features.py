"""Blades, holes, slots and other features of the bodies of a scene."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
    model_serializer,
)

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
_COUNT = {"type": "integer", "minimum": 1, "maximum": 10_000}
_PER_GROUP = {"type": "integer", "minimum": 1, "maximum": 100}
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
    """Equal axial holes in a section."""

    name: Name
    within: Annotated[Name, Field(alias="in")]
    count: FeatureCount
    pitch_radius_m: Positive
    diameter_m: Positive
    start_m: Finite | None = None
    end_m: Finite | None = None
    angle_deg: Finite = 0.0

    @model_serializer(mode="wrap")
    def _lean(self, content: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _without_unused(content(self), start_m=None, end_m=None)


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
    # geometry refuses other numbers
    per_group: Annotated[int, Field(strict=True), WithJsonSchema(_PER_GROUP)] = 1
    pitch_deg: Positive | None = None

    @model_serializer(mode="wrap")
    def _lean(self, content: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _without_unused(content(self), per_group=1, pitch_deg=None)


class RecessSpec(Record):
    """What is cut out of the outer part of a section, singly or at equal angles."""

    name: Name
    within: Annotated[Name, Field(alias="in")]
    count: FeatureCount = 1
    start_m: Finite
    end_m: Finite
    angle_deg: Finite = 0.0


class KeywaySpec(RecessSpec):
    """Equal keyways in the outer surface of a section."""

    width_m: Positive
    depth_m: Positive
    ends: Literal["round", "square"] = "round"


class FlatSpec(RecessSpec):
    """Equal flats on the outer surface of a section."""

    distance_m: Positive


class CutSpec(RecessSpec):
    """Equal ring sectors that are cut out of the outer part of a section."""

    width_deg: Positive
    depth_m: Positive


def _without_unused(content: dict[str, Any], **unused: object) -> dict[str, Any]:
    """Leave out keys with these values, so that scenes from before they came keep their hash."""
    return {k: v for k, v in content.items() if k not in unused or v != unused[k]}


class StageBladesSpec(Record):
    """Blades of all stages of a group."""

    count: Annotated[
        tuple[FeatureCount, ...],
        Field(min_length=1, max_length=MOST),
        WrapValidator(several),
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
