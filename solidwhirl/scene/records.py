"""The scene file: what a user asks for, as checked records.

Every number carries its unit in its key. Unknown keys are errors. `read_scene` turns a TOML file
into a `Scene`; `solidwhirl.model.bodies` turns a scene's bodies into geometry.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePath
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from solidwhirl.analyses.base import OperatingSpec
from solidwhirl.analyses.registry import AnalysisSpec
from solidwhirl.core.displays import counted, heading, indented, table, titled
from solidwhirl.core.fields import (
    MOST,
    AutoSwitch,
    Count,
    FileName,
    Finite,
    Name,
    Note,
    NotNegative,
    Positive,
    Radii,
    Record,
    Title,
    alike_in_files,
)
from solidwhirl.rotordyn.modes.damping import DampingRule
from solidwhirl.rotordyn.standards.api617_lateral import CRITICALLY_DAMPED
from solidwhirl.scene.body_joints import JointSpec
from solidwhirl.scene.features import (
    BladeSpec,
    CutSpec,
    FlatSpec,
    HoleSpec,
    KeywaySpec,
    SlotSpec,
    StageBladesSpec,
)
from solidwhirl.scene.imports import ImportedSpec
from solidwhirl.scene.joints import (
    BeamSpec,
    Bearings,
    BearingSpec,
    GearSpec,
    InternalDampingSpec,
    RigidBodySpec,
    SpeedLawSpec,
)
from solidwhirl.scene.meshes import MeshBodySpec, RigidDiskSpec
from solidwhirl.scene.sweep import SweepSpec


class MaterialSpec(Record):
    """An isotropic material."""

    density_kg_per_m3: Positive
    youngs_modulus_pa: Positive
    poissons_ratio: Annotated[float, Field(gt=-1, lt=0.5, strict=True)]


class SectionSpec(Record):
    """A piece of the meridian between two planes z = const, radii linear in between."""

    name: Name
    start_m: Finite
    end_m: Finite
    outer_radius_m: Radii
    inner_radius_m: Radii = (0.0, 0.0)
    material: Name | None = None


class WebSpec(Record):
    """A radial disk of constant thickness between the shaft and a stage's ring."""

    stage: Count
    thickness_m: Positive
    shaft_radius_m: Positive
    position: Literal["centre", "front", "back"] = "centre"


class ConeSpec(Record):
    """A conical shell between a foot ring on the shaft and the free face of an end stage."""

    stage: Count
    thickness_m: Positive
    shaft_radius_m: Positive
    foot_start_m: Finite
    foot_end_m: Finite


class StageGroupSpec(Record):
    """Stages by the rule value = origin · factor^(stage - 1) (Appendix C of the source)."""

    name: Name
    table: Literal["lp_compressor", "lp_turbine", "hp_compressor", "hp_turbine"]
    start_m: Finite
    direction: Literal[1, -1] = 1
    spacer_thickness_m: Positive
    material: Name | None = None
    webs: Annotated[tuple[WebSpec, ...], Field(max_length=MOST)] = ()
    cones: Annotated[tuple[ConeSpec, ...], Field(max_length=MOST)] = ()
    blades: StageBladesSpec | None = None

    @model_serializer(mode="wrap")
    def _lean(self, content: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _without_absent(content(self))


class InterfaceSpec(Record):
    """A place where bearings, gears or disks attach."""

    name: Name
    kind: Literal["section", "outer", "inner", "face", "slab"]
    coupling: Literal["distributing", "rigid"] = "distributing"
    at_m: Finite | None = None
    start_m: Finite | None = None
    end_m: Finite | None = None
    radius_m: tuple[NotNegative, NotNegative] | None = None

    @model_validator(mode="after")
    def _placed(self) -> InterfaceSpec:
        plane = self.kind in ("section", "face")
        span = self.start_m is not None and self.end_m is not None
        if plane and (self.at_m is None or self.start_m is not None or self.end_m is not None):
            raise ValueError(f"a {self.kind!r} interface needs at_m, not start_m and end_m")
        if not plane and (not span or self.at_m is not None):
            raise ValueError(f"kind {self.kind!r} of interface needs start_m and end_m, not at_m")
        return self


_FEATURES = ("blades", "holes", "slots", "keyways", "flats", "cuts")
#: Default of `[model] accuracy` with blades, holes, slots and the like, whose solids take a hundred
#: times the unknowns of a meridian.
ACCURACY_WITH_FEATURES = 1e-2


class BodySpec(Record):
    """One rotor."""

    speed_ratio: Finite = 1.0
    material: Name | None = None
    fillet_radius_m: NotNegative = 0.0
    sections: Annotated[tuple[SectionSpec, ...], Field(max_length=MOST)] = ()
    stage_groups: Annotated[tuple[StageGroupSpec, ...], Field(max_length=MOST)] = ()
    interfaces: Annotated[tuple[InterfaceSpec, ...], Field(max_length=MOST)] = ()
    joints: Annotated[tuple[JointSpec, ...], Field(max_length=200)] = ()
    rigid_disks: Annotated[tuple[RigidDiskSpec, ...], Field(max_length=MOST)] = ()
    blades: Annotated[tuple[BladeSpec, ...], Field(max_length=MOST)] = ()
    holes: Annotated[tuple[HoleSpec, ...], Field(max_length=MOST)] = ()
    slots: Annotated[tuple[SlotSpec, ...], Field(max_length=MOST)] = ()
    keyways: Annotated[tuple[KeywaySpec, ...], Field(max_length=MOST)] = ()
    flats: Annotated[tuple[FlatSpec, ...], Field(max_length=MOST)] = ()
    cuts: Annotated[tuple[CutSpec, ...], Field(max_length=MOST)] = ()
    modes: Annotated[Count, Field(le=500)] | None = None
    internal_damping: InternalDampingSpec | None = None

    @property
    def has_features(self) -> bool:
        """Whether anything of it is no part of a body of revolution."""
        return any(getattr(self, name) for name in _FEATURES) or any(
            group.blades for group in self.stage_groups
        )

    @model_serializer(mode="wrap")
    def _lean(self, content: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _without_absent(content(self))


def _without_absent(content: dict[str, Any]) -> dict[str, Any]:
    """Leave out features and joints that are not there, so that other scenes keep their hash."""
    may_lack = (*_FEATURES, "joints")
    return {key: value for key, value in content.items() if value or key not in may_lack}


# Speeds nearer than this part of them are one.
_ONE_SPEED = 1e-12


class SpeedSpec(Record):
    """Speeds of the reference shaft (speed ratio 1)."""

    from_rpm: NotNegative = 0.0
    to_rpm: NotNegative = 0.0
    count: Annotated[Count, Field(le=MOST)] = 1
    list_rpm: Annotated[tuple[NotNegative, ...], Field(max_length=MOST)] | None = None

    @model_validator(mode="after")
    def _range(self) -> SpeedSpec:
        if self.list_rpm is not None:
            range_keys = sorted(self.model_fields_set - {"list_rpm"})
            if range_keys:
                raise ValueError(f"list_rpm stands alone, found {', '.join(range_keys)} beside it")
            if not self.list_rpm or list(self.list_rpm) != sorted(set(self.list_rpm)):
                raise ValueError("list_rpm must be increasing and not empty")
        elif self.to_rpm < self.from_rpm:
            raise ValueError(f"to_rpm = {self.to_rpm:g} is below from_rpm = {self.from_rpm:g}")
        elif self.count == 1 and self.to_rpm != self.from_rpm:
            raise ValueError("count = 1 allows one speed only: from_rpm and to_rpm must be equal")
        elif self.to_rpm - self.from_rpm < (self.count - 1) * _ONE_SPEED * self.to_rpm or (
            self.count > 1 and self.to_rpm == self.from_rpm
        ):
            raise ValueError(
                f"count = {self.count} speeds from from_rpm = {self.from_rpm:g} to to_rpm = "
                f"{self.to_rpm:g} are one; allowed is count = 1 or a larger to_rpm"
            )
        return self


class CampbellSpec(Record):
    """Which branches are followed."""

    branches: Annotated[Count, Field(le=200)] = 8
    frequency_max_hz: Positive | None = None

    @model_validator(mode="after")
    def _one_of(self) -> CampbellSpec:
        if self.frequency_max_hz is not None and "branches" in self.model_fields_set:
            raise ValueError("give branches or frequency_max_hz, not both")
        return self


class EffectsSpec(Record):
    """Effects: auto (as the scene calls for), on or off."""

    gyroscopic: AutoSwitch = "auto"
    stress_stiffening: AutoSwitch = "auto"
    spin_softening: AutoSwitch = "auto"
    bearing_damping: AutoSwitch = "auto"
    internal_damping: AutoSwitch = "auto"
    speed_dependent_bearings: AutoSwitch = "auto"
    tilt: AutoSwitch = "auto"
    axial: AutoSwitch = "auto"
    torsion: AutoSwitch = "auto"

    @model_validator(mode="after")
    def _together(self) -> EffectsSpec:
        pair = (self.stress_stiffening, self.spin_softening)
        if "off" in pair and pair != ("off", "off"):
            raise ValueError(
                f"stress_stiffening is {pair[0]!r} and spin_softening {pair[1]!r}: in the inertial "
                "frame the two cancel for a rigid tilt, and one alone gives a false (negative or "
                "positive) stiffness; switch both off or neither"
            )
        return self


class ModelSpec(Record):
    """How finely the bodies are modelled."""

    level: Literal["auto", "beam", "harmonic", "solid"] = "auto"
    accuracy: Annotated[float, Field(ge=1e-6, le=0.1, strict=True)] = 1e-3
    estimates: Literal["on", "off"] = "on"
    compare_coupling: Literal["on", "off"] = "on"
    solver: Literal["auto", "direct", "iterative"] = "auto"
    stage_joints: Literal["first_order", "neighbours"] = "first_order"
    order: Annotated[int, Field(ge=2, le=4, strict=True)] | None = None
    modes: Annotated[Count, Field(le=500)] | None = None
    size_m: Positive | None = None
    corner_size_m: Positive | None = None
    growth: Positive | None = None
    rounds: Annotated[Count, Field(le=8)] = 8
    memory_gib: Positive | None = None

    @model_validator(mode="after")
    def _fitting(self) -> ModelSpec:
        if self.level == "solid" and self.order not in (None, 2, 3):
            raise ValueError(f"order = {self.order} with level 'solid', which has order 2 or 3")
        if self.size_m and self.corner_size_m and self.corner_size_m > self.size_m:
            raise ValueError(
                f"corner_size_m = {self.corner_size_m:g} is above size_m = {self.size_m:g}, the "
                "largest element size"
            )
        return self


# A number of `results.json`, and the parts of it that hold numbers of the engine.
_PATH = re.compile(r"[A-Za-z][\w-]*(?:\.[A-Za-z][\w-]*|\[\d{1,6}\])+")
COMPARED = ("analyses", "asymmetry", "bodies", "campbell", "critical_speeds", "modes_at_rest")


class ReferenceSpec(Record):
    """A value that somebody else has of a number in the results."""

    quantity: Annotated[str, Field(max_length=200)]
    value: Finite
    source: Annotated[Title, Field(min_length=1)]
    title: Title = ""
    tolerance: Positive | None = None

    @model_validator(mode="after")
    def _path(self) -> ReferenceSpec:
        first = re.split(r"[.\[]", self.quantity, maxsplit=1)[0]
        if not _PATH.fullmatch(self.quantity) or first not in COMPARED:
            raise ValueError(
                f"quantity is {self.quantity!r}; it is the place of a number in results.json, such "
                f"as 'critical_speeds[0].frequency_hz', and begins with {', '.join(COMPARED)}"
            )
        if self.value == 0.0 and self.tolerance is not None:
            raise ValueError("tolerance is relative, and value is 0; leave it out")
        return self


class CriteriaSpec(Record):
    """By which criteria results are judged."""

    amplification_min: NotNegative = CRITICALLY_DAMPED

    @property
    def rule(self) -> DampingRule:
        """Which roots are resonances."""
        return DampingRule(amplification_min=self.amplification_min)


class Scene(Record):
    """A whole scene."""

    name: Name
    title: Title = ""
    notes: Annotated[tuple[Note, ...], Field(max_length=MOST)] = ()
    materials: dict[Name, MaterialSpec] = Field(default_factory=dict, max_length=MOST)
    bodies: dict[FileName, BodySpec] = Field(default_factory=dict, max_length=MOST)
    beams: dict[FileName, BeamSpec] = Field(default_factory=dict, max_length=MOST)
    rigid_bodies: dict[FileName, RigidBodySpec] = Field(default_factory=dict, max_length=MOST)
    imported: dict[FileName, ImportedSpec] = Field(default_factory=dict, max_length=MOST)
    mesh_bodies: dict[FileName, MeshBodySpec] = Field(default_factory=dict, max_length=MOST)
    bearings: Bearings = ()
    speed_laws: dict[Name, SpeedLawSpec] = Field(default_factory=dict, max_length=MOST)
    gears: Annotated[tuple[GearSpec, ...], Field(max_length=MOST)] = ()
    speeds: SpeedSpec = SpeedSpec()
    campbell: CampbellSpec = CampbellSpec()
    operating: Annotated[tuple[OperatingSpec, ...], Field(max_length=MOST)] = ()
    criteria: CriteriaSpec = CriteriaSpec()
    effects: EffectsSpec = EffectsSpec()
    model: ModelSpec = ModelSpec()
    analyses: Annotated[tuple[AnalysisSpec, ...], Field(max_length=MOST)] = ()
    references: Annotated[tuple[ReferenceSpec, ...], Field(max_length=MOST)] = ()
    # how to make cases of the scene, no part of any: neither hashed nor written out
    sweep: SweepSpec | None = Field(default=None, exclude=True)

    @model_validator(mode="after")
    def _has_bodies(self) -> Scene:
        tables = (self.bodies, self.beams, self.rigid_bodies, self.imported, self.mesh_bodies)
        named = [name for table in tables for name in table]
        if not named:
            raise ValueError(
                "a scene needs a body: [bodies.NAME], [beams.NAME], [rigid_bodies.NAME], "
                "[imported.NAME] or [mesh_bodies.NAME]"
            )
        twice = sorted({name for name in named if named.count(name) > 1})
        if twice:
            raise ValueError(f"more than one body is named {', '.join(twice)}")
        alike = alike_in_files(named)
        if alike:
            raise ValueError(
                f"bodies {alike[0]!r} and {alike[1]!r} differ in upper and lower case only, and "
                "each has a file; choose another name for one"
            )
        return self

    @model_validator(mode="after")
    def _with_default_accuracy(self) -> Scene:
        """Let bodies with features have theirs, where the scene gives none."""
        given = "accuracy" in self.model.model_fields_set
        if not given and any(body.has_features for body in self.bodies.values()):
            model = self.model.model_copy(update={"accuracy": ACCURACY_WITH_FEATURES})
            object.__setattr__(self, "model", model)
        return self

    def __repr__(self) -> str:
        return "\n".join([_head(self), *indented([": ".join(line) for line in _about(self)])])

    def __str__(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        return heading(_head(self)) + table((), [*_about(self)])

    def speed_ratio(self, body: str) -> float:
        """Speed of a body over that of the reference shaft."""
        return self.speed_ratios()[body]

    def speed_ratio_at(self, place: str) -> float:
        """Speed of the body of an interface, "body.interface", over that of the reference shaft."""
        return self.speed_ratio(place.partition(".")[0])

    def law_of(self, bearing: BearingSpec) -> SpeedLawSpec | None:
        """Speed law of a bearing; None if it names none, or one that the scene does not have."""
        return self.speed_laws.get(bearing.speed_law or "")

    def speed_ratios(self) -> dict[str, float]:
        """Speed of every body over that of the reference shaft."""
        return {name: body.speed_ratio for name, body in self._every_body().items()}

    def gear_trains(self) -> dict[str, int]:
        """Number of the gear train of every body: those geared together, or of one speed ratio."""
        ratios = self.speed_ratios()
        same = {ratio: name for name, ratio in reversed(ratios.items())}
        trains = {name: list(ratios).index(same[ratio]) for name, ratio in ratios.items()}
        for gear in self.gears:
            ends = (gear.first, gear.second)
            first, second = (trains.get(end.partition(".")[0]) for end in ends)
            if first is None or second is None:
                continue  # refused elsewhere
            trains = {name: first if own == second else own for name, own in trains.items()}
        return trains

    def internal_damping(self) -> dict[str, InternalDampingSpec]:
        """Internal damping of the bodies that have it."""
        tables = (self.bodies, self.beams, self.mesh_bodies)
        found = {n: b.internal_damping for table in tables for n, b in table.items()}
        return {name: damping for name, damping in found.items() if damping is not None}

    def interface_names(self) -> dict[str, tuple[str, ...]]:
        """Interfaces of every body."""
        return {
            name: tuple(i if isinstance(i, str) else i.name for i in body.interfaces)
            for name, body in self._every_body().items()
        }

    def places(self) -> list[str]:
        """Every interface as `body.interface`."""
        return [f"{body}.{i}" for body, names in self.interface_names().items() for i in names]

    def _every_body(self) -> dict[str, Any]:
        tables = (self.bodies, self.beams, self.rigid_bodies, self.imported, self.mesh_bodies)
        return {name: body for table in tables for name, body in table.items()}

    def finite_element_bodies(self) -> dict[str, BodySpec | MeshBodySpec]:
        """Bodies that may become finite elements: those with a profile, and those with a mesh."""
        return {**self.bodies, **self.mesh_bodies}


def without_folders(scene: Scene) -> dict[str, Any]:
    """Return `imported` and `mesh_bodies` of a scene by the names and digests of their files.

    Wherever the files lie, a scene that was read is known by their content.
    """

    def named(spec: Any, *keys: str) -> Any:
        paths = {key: getattr(spec, key) for key in keys}
        return spec.model_copy(update={k: v and PurePath(v).name for k, v in paths.items()})

    return {
        "imported": {n: named(spec, "file", "nodes") for n, spec in scene.imported.items()},
        "mesh_bodies": {n: named(spec, "file") for n, spec in scene.mesh_bodies.items()},
    }


def analyses_without_folders(scene: Scene) -> tuple[AnalysisSpec, ...]:
    """Return the analyses of a scene with the files of measurements by names and digests."""

    def named(spec: AnalysisSpec) -> AnalysisSpec:
        if spec.kind != "impact_test" or spec.measured is None:
            return spec
        files = {key: PurePath(file).name for key, file in spec.measured.files.items()}
        return spec.model_copy(update={"measured": spec.measured.model_copy(update=files)})

    return tuple(map(named, scene.analyses))


def _head(scene: Scene) -> str:
    return f"Scene {scene.name!r}{titled(scene.title)}"


def _about(scene: Scene) -> Iterator[tuple[str, str]]:
    """What a scene holds, in a few lines."""
    names = [f"{name} (speed ratio {ratio:g})" for name, ratio in scene.speed_ratios().items()]
    speeds = scene.speeds
    listed = speeds.list_rpm or (speeds.from_rpm, speeds.to_rpm)
    count = speeds.count if speeds.list_rpm is None else len(speeds.list_rpm)
    yield "bodies", ", ".join(counted(names))
    yield "bearings", ", ".join(counted([b.name for b in scene.bearings])) or "none"
    if scene.gears:
        yield "gears", ", ".join(counted([g.name for g in scene.gears]))
    yield "speeds", f"{count} from {listed[0]:g} to {listed[-1]:g} rpm"
    yield "model", f"level {scene.model.level}, accuracy {scene.model.accuracy:g}"
    if scene.analyses:
        yield "analyses", ", ".join(counted([a.label for a in scene.analyses]))
