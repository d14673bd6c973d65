"""Scene records of bodies that come from a mesh or a geometry file."""

from __future__ import annotations

import errno
import hashlib
from pathlib import Path, PurePath
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from solidwhirl.core.fields import (
    MOST,
    BesideScene,
    Count,
    Finite,
    GroupName,
    Name,
    NotNegative,
    Positive,
    Record,
)
from solidwhirl.rotordyn.core.foreign import ForeignError, refuse_irregular
from solidwhirl.scene.body_joints import JointSpec
from solidwhirl.scene.joints import InternalDampingSpec

Direction = tuple[Finite, Finite, Finite]
#: Lengths of the units that a mesh may be in [m].
UNITS_M = {"m": 1.0, "mm": 1e-3, "in": 0.0254}
#: Units that the masses of a mesh may be in [kg].
MASSES_KG = {"kg": 1.0, "t": 1e3, "g": 1e-3, "lb": 0.45359237, "lbf_s2_per_in": 175.1268352464764}
_MESHES = (".msh", ".inp", ".bdf", ".nas", ".dat", ".vtu")
_GEOMETRIES = (".step", ".stp")
_MOST_SECTORS = 10_000


def _enough_sectors(value: object) -> object:
    """Say of too few sectors what can be done instead."""
    if value == 1:
        raise ValueError(
            "1 sector is the whole; leave sectors out: a body that turns is then one of "
            "revolution, one that stands (speed_ratio = 0) may have any shape"
        )
    if value == 2:
        raise ValueError(
            "2 sectors make an asymmetric body, so that seen from outside its "
            "matrices change with the angle; 3 or more do not. Give a body that stands "
            "(speed_ratio = 0) as a whole without sectors, or two blades as rigid_disks"
        )
    return value


Sectors = Annotated[Count, Field(ge=3, le=_MOST_SECTORS), BeforeValidator(_enough_sectors)]


class RigidDiskSpec(Record):
    """A rigid disk fixed to an interface's master node."""

    name: Name
    interface: Name
    mass_kg: NotNegative
    polar_inertia_kg_m2: NotNegative
    diametral_inertia_kg_m2: NotNegative
    offset_m: Finite = 0.0


class AxisSpec(Record):
    """The axis of a body in the coordinates of its file; it becomes z, its origin z = 0."""

    origin: Direction = (0.0, 0.0, 0.0)
    direction: Direction = (0.0, 0.0, 1.0)
    x_direction: Direction | None = None

    @model_validator(mode="after")
    def _directions(self) -> AxisSpec:
        for key in ("direction", "x_direction"):
            value = getattr(self, key)
            if value is not None and not any(value):
                raise ValueError(f"{key} has no length")
        return self


class MeshInterfaceSpec(Record):
    """A surface of a mesh where bearings, gears or disks attach."""

    name: Name
    coupling: Literal["distributing", "rigid"] = "distributing"
    group: GroupName | None = None
    box_m: tuple[Direction, Direction] | None = None
    node: Literal["axis", "centroid"] = "axis"
    node_m: Direction | None = None

    @model_validator(mode="after")
    def _one_of(self) -> MeshInterfaceSpec:
        if (self.group is None) == (self.box_m is None):
            raise ValueError("give group or box_m, one of them")
        if self.box_m is not None:
            low, high = self.box_m
            if any(b < a for a, b in zip(low, high, strict=True)):
                raise ValueError("box_m is its lowest and its highest corner, in this order")
        if self.node_m is not None and "node" in self.model_fields_set:
            raise ValueError("give node or node_m, not both")
        return self


class MeshBodySpec(Record):
    """A body from a mesh file, or from a STEP file that is meshed."""

    file: BesideScene
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")] | None = None
    length_unit: Literal["m", "mm", "in"]
    mass_unit: Literal["kg", "t", "g", "lb", "lbf_s2_per_in"] | None = None
    axis: AxisSpec = AxisSpec()
    speed_ratio: Finite = 1.0
    sectors: Sectors | None = None
    symmetry: Literal["auto", "revolution", "none"] = "auto"
    material: Name | None = None
    materials: dict[GroupName, Name] = Field(default_factory=dict, max_length=MOST)
    interfaces: Annotated[tuple[MeshInterfaceSpec, ...], Field(max_length=MOST)] = ()
    rigid_disks: Annotated[tuple[RigidDiskSpec, ...], Field(max_length=MOST)] = ()
    modes: Annotated[Count, Field(le=500)] | None = None
    internal_damping: InternalDampingSpec | None = None
    size_m: Positive | None = None
    smallest_m: Positive | None = None
    around: Annotated[Count, Field(ge=4, le=400)] = 16
    joints: Annotated[tuple[JointSpec, ...], Field(max_length=MOST)] = ()

    @property
    def is_geometry(self) -> bool:
        """Whether the file is a geometry that has to be meshed."""
        return PurePath(self.file).suffix.lower() in _GEOMETRIES

    @property
    def may_have_any_shape(self) -> bool:
        """Whether it neither turns nor has to consist of equal sectors."""
        return self.speed_ratio == 0.0 and self.sectors is None and not self.joints

    @model_validator(mode="after")
    def _fitting(self) -> MeshBodySpec:
        suffix = PurePath(self.file).suffix.lower()
        if suffix not in (*_MESHES, *_GEOMETRIES):
            known = ", ".join((*_MESHES, *_GEOMETRIES))
            raise ValueError(f"file has the suffix {suffix!r}; known are {known}")
        sizes = self.model_fields_set & {"size_m", "smallest_m", "around"}
        if self.is_geometry and self.size_m is None:
            raise ValueError("a STEP file needs size_m, the largest element edge")
        if not self.is_geometry and sizes:
            raise ValueError(f"{', '.join(sorted(sizes))} is for STEP files; this one is a mesh")
        if self.size_m and self.smallest_m and self.smallest_m > self.size_m:
            raise ValueError(f"smallest_m = {self.smallest_m:g} is above size_m = {self.size_m:g}")
        if self.joints:
            self._refuse_beside_joints()
        if self.material is None and not self.materials:
            raise ValueError("material is needed, or materials by group")
        if self.symmetry != "auto" and (self.sectors or self.speed_ratio == 0.0):
            said = "sectors says it" if self.sectors else "it does not turn (speed_ratio = 0)"
            raise ValueError(f"symmetry = {self.symmetry!r}, but {said}; leave one of them out")
        if self.internal_damping is not None and self.may_have_any_shape:
            raise ValueError(
                "internal_damping needs to know how the body turns; one that stands still "
                "(speed_ratio = 0) may have any shape and does not say"
            )
        names = [interface.name for interface in self.interfaces]
        for kind, found in (
            ("interfaces", names),
            ("rigid disks", [disk.name for disk in self.rigid_disks]),
        ):
            twice = sorted({n for n in found if found.count(n) > 1})
            if twice:
                raise ValueError(f"two {kind} are called {', '.join(twice)}; names must differ")
        for disk in self.rigid_disks:
            if disk.interface not in names:
                raise ValueError(
                    f"rigid disk {disk.name!r} sits on the interface {disk.interface!r}, which "
                    f"does not exist; known: {', '.join(names) or 'none'}"
                )
        return self

    def _refuse_beside_joints(self) -> None:
        if not self.is_geometry:
            raise ValueError("joints are between the solids of STEP files; this one is a mesh")
        for key, given in (("sectors", self.sectors), ("symmetry", self.symmetry == "none")):
            if given:
                raise ValueError(f"joints are of bodies of revolution; leave out {key}")
        pairs = [frozenset(joint.between) for joint in self.joints]
        if len(set(pairs)) < len(pairs):
            raise ValueError("two joints are between the same solids; keep one of them")
        if any(joint.over_m is not None for joint in self.joints):
            raise ValueError("over_m is for joints of sections; solids carry where they are drawn")


def file_digest(path: Path) -> str:
    """SHA-256 of the content of a file.

    Raises OSError: it can't be read, or is no regular file.
    """
    try:
        refuse_irregular(path)
    except ForeignError as error:
        raise OSError(errno.EINVAL, str(error)) from error
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
