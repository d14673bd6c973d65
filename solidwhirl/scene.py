"""The scene file: what a user asks for, as checked records.

Every number carries its unit in its key. Unknown keys are errors. `read_scene` turns a TOML file
into a `Scene`; `solidwhirl.bodies` turns a scene's bodies into geometry.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

# strict: whole numbers stand for floats, but texts and true or false for no number
# far beyond every rotor, and far from where products of a few numbers overflow
_LARGEST = 1e30
Positive = Annotated[float, Field(gt=0, le=_LARGEST, allow_inf_nan=False, strict=True)]
NotNegative = Annotated[float, Field(ge=0, le=_LARGEST, allow_inf_nan=False, strict=True)]
Finite = Annotated[float, Field(ge=-_LARGEST, le=_LARGEST, allow_inf_nan=False, strict=True)]
Count = Annotated[int, Field(ge=1, strict=True)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")]
Switch = Literal["auto", "on", "off"]


def _switch(value: Any) -> Any:
    """TOML's true and false are accepted for on and off."""
    return {True: "on", False: "off"}.get(value, value) if isinstance(value, bool) else value


def _pair(value: Any) -> Any:
    """A number stands for the same value at both ends."""
    return (value, value) if isinstance(value, int | float) else value


def _matrix(value: Any) -> Any:
    """A number k is k·I, a pair (kx, ky) is diagonal, a 2×2 list stands for itself."""
    if isinstance(value, int | float):
        return ((value, 0.0), (0.0, value))
    if isinstance(value, list) and len(value) == 2 and not isinstance(value[0], list):
        return ((value[0], 0.0), (0.0, value[1]))
    return value


AutoSwitch = Annotated[Switch, BeforeValidator(_switch)]
Radii = Annotated[tuple[NotNegative, NotNegative], BeforeValidator(_pair)]
Matrix = Annotated[tuple[tuple[Finite, Finite], tuple[Finite, Finite]], BeforeValidator(_matrix)]
_ZERO = ((0.0, 0.0), (0.0, 0.0))


class Record(BaseModel):
    """Base of all scene records: frozen, no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


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
    webs: tuple[WebSpec, ...] = ()
    cones: tuple[ConeSpec, ...] = ()


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


class RigidDiskSpec(Record):
    """A rigid disk fixed to an interface's master node."""

    name: Name
    interface: Name
    mass_kg: NotNegative
    polar_inertia_kg_m2: NotNegative
    diametral_inertia_kg_m2: NotNegative
    offset_m: Finite = 0.0


class BodySpec(Record):
    """One rotor."""

    speed_ratio: Finite = 1.0
    material: Name | None = None
    fillet_radius_m: NotNegative = 0.0
    sections: tuple[SectionSpec, ...] = ()
    stage_groups: tuple[StageGroupSpec, ...] = ()
    interfaces: tuple[InterfaceSpec, ...] = ()
    rigid_disks: tuple[RigidDiskSpec, ...] = ()


class BearingSpec(Record):
    """A linear bearing between two interfaces, or an interface and the ground."""

    name: Name
    first: str
    second: str = "ground"
    stiffness_n_per_m: Matrix = _ZERO
    damping_n_s_per_m: Matrix = _ZERO
    tilt_stiffness_n_m_per_rad: Matrix = _ZERO
    tilt_damping_n_m_s_per_rad: Matrix = _ZERO
    axial_stiffness_n_per_m: NotNegative = 0.0
    axial_damping_n_s_per_m: NotNegative = 0.0
    torsion_stiffness_n_m_per_rad: NotNegative = 0.0
    torsion_damping_n_m_s_per_rad: NotNegative = 0.0
    rigid: tuple[Literal["ux", "uy", "uz", "rx", "ry", "rz"], ...] = ()


class SpeedSpec(Record):
    """Speeds of the reference shaft (speed ratio 1)."""

    from_rpm: NotNegative = 0.0
    to_rpm: NotNegative = 0.0
    count: Annotated[Count, Field(le=2001)] = 1
    list_rpm: tuple[NotNegative, ...] | None = None

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

    level: Literal["auto", "harmonic", "solid"] = "auto"
    accuracy: Annotated[float, Field(ge=1e-5, le=0.1, strict=True)] = 1e-3
    order: Annotated[int, Field(ge=2, le=4, strict=True)] | None = None
    modes: Annotated[Count, Field(le=500)] = 12
    size_m: Positive | None = None
    corner_size_m: Positive | None = None
    growth: Positive | None = None

    @model_validator(mode="after")
    def _fitting(self) -> ModelSpec:
        if self.level == "solid" and self.order not in (None, 2):
            raise ValueError(f"order = {self.order} with level 'solid', which has order 2 only")
        if self.size_m and self.corner_size_m and self.corner_size_m > self.size_m:
            raise ValueError(
                f"corner_size_m = {self.corner_size_m:g} is above size_m = {self.size_m:g}, the "
                "largest element size"
            )
        return self


class Scene(Record):
    """A whole scene."""

    name: Name
    title: str = ""
    notes: tuple[str, ...] = ()
    materials: dict[Name, MaterialSpec] = {}
    bodies: Annotated[dict[Name, BodySpec], Field(min_length=1)]
    bearings: tuple[BearingSpec, ...] = ()
    speeds: SpeedSpec = SpeedSpec()
    campbell: CampbellSpec = CampbellSpec()
    effects: EffectsSpec = EffectsSpec()
    model: ModelSpec = ModelSpec()
