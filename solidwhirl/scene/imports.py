"""Bodies of a scene that come as matrices from files."""

from __future__ import annotations

from pathlib import PurePath
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from solidwhirl.core.fields import MOST, BesideScene, Finite, Name, Record

NATIVE = ".h5"
SUFFIXES = (".npz", ".json", ".pch", ".dmig", ".bdf", ".dat", ".op4", NATIVE)
_LONGEST_NODE = 200
_LARGEST_NODE = 10**9
_ONLY_FOREIGN = (
    "nodes",
    "length_unit",
    "mass_unit",
    "axes",
    "mass",
    "stiffness",
    "gyroscopic",
    "stress_stiffening",
    "spin_softening",
)


def _node(value: Any) -> Any:
    """Number or name of a node."""
    whole = isinstance(value, int) and not isinstance(value, bool)
    if whole and 1 <= value <= _LARGEST_NODE:
        return value
    if isinstance(value, str) and 0 < len(value) <= _LONGEST_NODE and value.isprintable():
        return value
    raise ValueError("a node is a whole number from 1, or a name of the file")


NodeName = Annotated[Any, AfterValidator(_node)]
MatrixName = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]{1,64}$")]
Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class ImportedSpec(Record):
    """A body from a file: matrices of another program, or a superelement of this one."""

    file: BesideScene
    nodes: BesideScene | None = None
    sha256: Digest | None = None
    speed_ratio: Finite = 0.0
    interfaces: Annotated[dict[Name, NodeName], Field(max_length=MOST)] = Field(
        default_factory=dict
    )
    length_unit: Literal["m", "mm"] | None = None
    mass_unit: Literal["kg", "t"] | None = None
    axes: Literal["xyz", "yzx", "zxy"] = "xyz"
    origin_m: Finite = 0.0
    mass: MatrixName | None = None
    stiffness: MatrixName | None = None
    gyroscopic: MatrixName | None = None
    stress_stiffening: MatrixName | None = None
    spin_softening: MatrixName | None = None

    @model_validator(mode="after")
    def _format(self) -> ImportedSpec:
        suffix = PurePath(self.file).suffix.lower()
        if suffix not in SUFFIXES:
            raise ValueError(f"file ends in {suffix[:20]!r}; known are {', '.join(SUFFIXES)}")
        if suffix == NATIVE:
            given = [key for key in _ONLY_FOREIGN if key in self.model_fields_set]
            given = [key for key in given if getattr(self, key) not in (None, "xyz")]
            if given:
                raise ValueError(f"{given[0]} is not for a superelement file, which says it itself")
        return self
