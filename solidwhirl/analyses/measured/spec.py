"""What a scene says of a hammer test: places, directions, and files of what was measured."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from solidwhirl.analyses.measured.records import MOST_BYTES
from solidwhirl.core.fields import (
    MOST,
    BesideScene,
    Count,
    Finite,
    Name,
    Place,
    Positive,
    Record,
)
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.foreign import ForeignError, regular_bytes

Direction = Literal["x", "y", "z", "-x", "-y", "-z"]


class MeasuringPointSpec(Record):
    """Where a hammer hits or a sensor sits, and in which direction."""

    name: Name
    at: Place | None = None
    body: Name | None = None
    at_m: Finite | None = None
    direction: Direction
    node: Count | None = None

    @model_validator(mode="after")
    def _one_place(self) -> MeasuringPointSpec:
        along = (self.body is not None, self.at_m is not None)
        if (self.at is not None and any(along)) or (self.at is None and not all(along)):
            raise ValueError("give at, an interface, or body and at_m, a place along its axis")
        if self.at is None and self.is_axial:
            raise ValueError("direction: axial motion is known at interfaces alone; give at")
        return self

    @property
    def is_axial(self) -> bool:
        """Whether its direction is along the axis."""
        return self.direction.endswith("z")

    @property
    def vector(self) -> FloatArray:
        """Its direction along x, y and z, (3,)."""
        sign = -1.0 if self.direction.startswith("-") else 1.0
        return np.asarray(sign * np.eye(3)["xyz".index(self.direction[-1])])


class MeasuredSpec(Record):
    """Files of what was measured, or frequencies alone."""

    functions: BesideScene | None = None
    modes: BesideScene | None = None
    frequencies_hz: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=MOST)] | None = (
        None
    )
    units: Literal["m_n", "mm_mn", "mm_n", "in_lbf", "ft_lbf"] | None = None
    quantity: Literal["receptance", "mobility", "accelerance"] | None = None
    directions: tuple[Direction, Direction] = ("x", "y")
    sha256: dict[Name, str] = Field(default_factory=dict, max_length=2)

    @model_validator(mode="after")
    def _known_by_content(self) -> MeasuredSpec:
        """Keep the digests of the files, so that results are known by their content."""
        if self.functions is None and self.modes is None and self.frequencies_hz is None:
            raise ValueError("nothing is measured; give functions, modes or frequencies_hz")
        if self.modes is not None and self.frequencies_hz is not None:
            raise ValueError("give modes or frequencies_hz, not both")
        if self.directions[0][-1] == self.directions[1][-1]:
            raise ValueError("directions: the two must lie along two axes of the file")
        found = {key: _digest(key, Path(file)) for key, file in self.files.items()}
        changed = [key for key, digest in self.sha256.items() if found.get(key, digest) != digest]
        if changed:
            raise ValueError(f"{changed[0]}: the file has changed; its digest in sha256 is another")
        return self.model_copy(update={"sha256": found})

    @property
    def files(self) -> dict[str, str]:
        """Files by their keys."""
        named = {"functions": self.functions, "modes": self.modes}
        return {key: file for key, file in named.items() if file is not None}


def _digest(key: str, path: Path) -> str:
    try:
        return hashlib.sha256(regular_bytes(path, MOST_BYTES)).hexdigest()
    except ForeignError as error:
        raise ValueError(f"{key}: {path.name}: {error}") from error


def point_problems(
    key: str, points: Sequence[MeasuringPointSpec], ends_m: Mapping[str, tuple[float, float]]
) -> Iterator[str]:
    """Yield what is wrong with hammers or sensors: names given twice, places off the body.

    `ends_m`: lowest and highest place of bodies that are drawn.
    """
    names = [point.name for point in points]
    for k, point in enumerate(points):
        if names.index(point.name) < k:
            yield f"{key}[{k}].name: {point.name!r} is there twice; names differ"
        if point.body is not None and point.at_m is not None and point.body in ends_m:
            low, high = ends_m[point.body]
            if not low <= point.at_m <= high:
                yield (
                    f"{key}[{k}].at_m: {point.at_m:g} lies off {point.body!r}; allowed is "
                    f"{low:g} to {high:g}"
                )
