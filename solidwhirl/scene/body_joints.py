"""Joints between the sections of a body of a scene."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from solidwhirl.core.fields import Finite, GroupName, NotNegative, Positive, Record


class JointSpec(Record):
    """A layer of springs on the common face of two sections, or solids."""

    between: tuple[GroupName, GroupName]
    stiffness_n_per_m3: tuple[Positive, NotNegative] | None = None
    interference_m: Positive | None = None
    pressure_pa: Positive | None = None
    over_m: tuple[Finite, Finite] | None = None
    temperature_difference_k: Finite = 0.0
    expansion_per_k: NotNegative = 0.0
    friction: Annotated[float, Field(ge=0, le=2, strict=True)] = 0.12
    yield_pa: Positive | None = None
