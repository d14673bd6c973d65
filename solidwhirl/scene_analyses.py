"""Scene records of the analyses beyond the Campbell diagram; each entry of [[analyses]] is one."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from solidwhirl.scene_base import (
    MOST,
    Count,
    FileName,
    Finite,
    Name,
    NotNegative,
    Place,
    Positive,
    Record,
)
from solidwhirl.scene_recovery import RecoverySpec

Points = Annotated[Count, Field(ge=2, le=20001)]
Places = Annotated[tuple[Place, ...], Field(min_length=1, max_length=MOST)]
Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST)]


class UnbalanceSpec(Record):
    """An unbalance at an interface of a body that turns, by its moment or a grade of ISO 21940."""

    at: Place
    moment_kg_m: Positive = 0.0  # stays 0 where there is a grade, until masses are known
    phase_deg: Finite = 0.0
    grade: Positive | None = None
    at_rpm: Positive | None = None
    share: Annotated[float, Field(gt=0, le=1, strict=True)] = 1.0

    @model_validator(mode="after")
    def _one_size(self) -> UnbalanceSpec:
        by_moment = self.moment_kg_m > 0.0
        graded = {"grade": self.grade, "at_rpm": self.at_rpm}
        given = [key for key, value in graded.items() if value is not None]
        given += ["share"] if "share" in self.model_fields_set else []
        if by_moment and given:
            raise ValueError(f"has moment_kg_m and {given[0]}; one of them says how large it is")
        if not by_moment and None in graded.values():
            raise ValueError("needs moment_kg_m, or both grade and at_rpm")
        return self

    @model_serializer(mode="wrap")
    def _as_given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Without the keys of the other way to say it."""
        absent = ("moment_kg_m",) if self.grade else ("grade", "at_rpm", "share")
        return {key: value for key, value in handler(self).items() if key not in absent}


# Files and folders of a run that are no analysis.
_TAKEN = (
    *("campbell", "campbell_errors", "critical_speeds", "report", "results", "bodies", "meshes"),
    "verdict",
)
# Speeds at which shapes are drawn.
_MOST_SPEEDS = 200


# Frequencies of a stiffness study around the operating speed.
_FEWEST_IN_BAND = 5
# Points of a map, steps of a run-up.
_MOST_POINTS = 2e6
_MOST_STEPS = 5e7
# Models whose curves can be told apart beside the full one.
_MOST_MODELS = 6
# Numbers of steps must be whole to this.
_WHOLE = 1e-6


class _Analysis(Record):
    """What all analyses share: a name for results and pictures, the kind if there is none."""

    name: FileName | None = None

    @field_validator("name")
    @classmethod
    def _free(cls, value: str | None) -> str | None:
        if value is not None and value.lower() in _TAKEN:
            raise ValueError(f"{value!r} is the name of a file of every run; choose another")
        return value

    @property
    def label(self) -> str:
        """Name in results and file names."""
        return self.name or str(self.kind)  # type: ignore[attr-defined]


class _Sweep(_Analysis):
    """Speeds of the reference shaft."""

    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    count: Points = 201

    @model_validator(mode="after")
    def _rising(self) -> _Sweep:
        _refuse_falling(self.from_rpm, self.to_rpm)
        return self


def _refuse_falling(from_rpm: float, to_rpm: float) -> None:
    if to_rpm <= from_rpm:
        raise ValueError(f"to_rpm = {to_rpm:g} is not above from_rpm = {from_rpm:g}")


class _Frequencies(_Analysis):
    """Excitation frequencies from one step above zero to the highest."""

    frequency_max_hz: Positive
    frequency_count: Points = 500


def _refuse_large(what: str, rows: int, columns: int) -> None:
    if rows * columns > _MOST_POINTS:
        raise ValueError(
            f"{what} is {rows} x {columns} = {rows * columns}; a map has at most {_MOST_POINTS:.0f}"
        )


class _Stiffnesses(_Analysis):
    """Support stiffnesses, evenly spaced in their logarithm."""

    bearings: Names
    stiffness_from_n_per_m: Positive
    stiffness_to_n_per_m: Positive
    stiffness_count: Points = 31

    @model_validator(mode="after")
    def _rising(self) -> _Stiffnesses:
        if self.stiffness_to_n_per_m <= self.stiffness_from_n_per_m:
            raise ValueError("stiffness_to_n_per_m is not above stiffness_from_n_per_m")
        return self


class UnbalanceResponseSpec(_Sweep):
    """Response to unbalances over the speed: amplitude, phase, orbits and bearing forces."""

    kind: Literal["unbalance_response"]
    count: Annotated[Count, Field(ge=4, le=20001)] = 201
    unbalances: Annotated[tuple[UnbalanceSpec, ...], Field(min_length=1, max_length=MOST)]
    observe: Places
    orbits_at_rpm: Annotated[tuple[Positive, ...], Field(max_length=64)] = ()


class PlaceMapSpec(_Frequencies):
    """Response to one unbalance at each place in turn, over its frequency."""

    kind: Literal["place_map"]
    frequency_count: Annotated[Count, Field(ge=3, le=20001)] = 500
    places: Places
    moment_kg_m: Positive
    observe: Place | None = None


class WaterfallSpec(_Frequencies):
    """Response to harmonic motion of the ground over frequency and speed."""

    kind: Literal["waterfall"]
    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    speed_count: Points = 51
    amplitude_m: Positive = 1e-6
    direction: Literal["x", "y"] = "x"
    observe: Place

    @model_validator(mode="after")
    def _range(self) -> WaterfallSpec:
        _refuse_falling(self.from_rpm, self.to_rpm)
        _refuse_large("speed_count x frequency_count", self.speed_count, self.frequency_count)
        return self


class CriticalSpeedMapSpec(_Stiffnesses):
    """Critical speeds over the stiffness of supports."""

    kind: Literal["critical_speed_map"]
    excited_by: Name
    branches: Annotated[Count, Field(le=50)] = 6
    search_to_rpm: Positive
    operating_speed_rpm: Positive | None = None


class StiffnessStudySpec(_Stiffnesses):
    """Response over excitation frequency and support stiffness, and the stiffness to choose."""

    kind: Literal["stiffness_study"]
    excite: Place
    observe: Place
    moment_kg_m: Positive
    frequency_max_hz: Positive
    frequency_count: Points = 500
    speed_rpm: NotNegative | None = None
    operating_speed_rpm: Positive
    margin: Annotated[float, Field(gt=0, lt=1, strict=True)] = 0.2

    @model_validator(mode="after")
    def _covered(self) -> StiffnessStudySpec:
        count, highest = self.frequency_count, self.frequency_max_hz
        _refuse_large("stiffness_count x frequency_count", self.stiffness_count, count)
        low, high = ((1.0 + s * self.margin) * self.operating_speed_rpm / 60.0 for s in (-1, 1))
        step = highest / count
        inside = math.floor(high / step) - math.ceil(low / step) + 1
        if low < step or high > highest or inside < _FEWEST_IN_BAND:
            raise ValueError(
                f"the band of margin around operating_speed_rpm is {low:.6g} to {high:.6g} Hz; the "
                f"frequencies of the map, {step:.6g} to {highest:.6g} Hz in {count} steps, must "
                f"cover it with {_FEWEST_IN_BAND} or more inside"
            )
        return self


class RotatingCampbellSpec(_Analysis):
    """The Campbell diagram in the frames of bodies."""

    kind: Literal["rotating_campbell"]
    bodies: Names


class ModeShapesSpec(_Analysis):
    """Shapes of the lowest modes and which bodies and joints take part in them."""

    kind: Literal["mode_shapes"]
    speeds_rpm: Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=_MOST_SPEEDS)]
    modes: Annotated[Count, Field(le=60)] = 8
    bodies: Annotated[tuple[Name, ...], Field(max_length=MOST)] = ()


def speed_text(rpm: float) -> str:
    """A speed as in the names of files: to 1e-6 rpm, without zeros at the end."""
    return f"{rpm:.6f}".rstrip("0").rstrip(".")


class OperatingSpec(Record):
    """Operating speeds of one shaft itself."""

    shaft: Name
    from_rpm: Positive
    to_rpm: Positive

    @model_validator(mode="after")
    def _rising(self) -> OperatingSpec:
        if self.to_rpm < self.from_rpm:
            raise ValueError(f"to_rpm = {self.to_rpm:g} is below from_rpm = {self.from_rpm:g}")
        return self


class SeparationMarginsSpec(_Analysis):
    """Distance of critical speeds from operating speeds, sought up to a multiple of these."""

    kind: Literal["separation_margins"]
    operating: Annotated[tuple[OperatingSpec, ...], Field(max_length=MOST)] = ()
    search_factor: Annotated[float, Field(ge=1, le=10, strict=True)] = 1.3
    method: Literal["api617", "percent"] = "api617"
    percent: Annotated[float, Field(gt=0, lt=100, strict=True)] = 15.0

    @model_validator(mode="after")
    def _one_method(self) -> SeparationMarginsSpec:
        if self.method != "percent" and "percent" in self.model_fields_set:
            raise ValueError(f'percent is given with method {self.method!r}; use method "percent"')
        return self


class StabilitySpec(_Sweep):
    """Smallest damping over the speed and where the engine becomes unstable."""

    kind: Literal["stability"]
    count: Points = 61
    frequency_max_hz: Positive | None = None


class BearingLawsSpec(_Analysis):
    """Stiffness and damping of the bearings that depend on the speed."""

    kind: Literal["bearing_laws"]
    to_rpm: Positive


class RunUpSpec(_Analysis):
    """Run-up of the engine: speed linear from rest, then constant."""

    kind: Literal["run_up"]
    ramp_s: Positive
    hold_s: NotNegative = 0.0
    to_rpm: Positive
    sampling_hz: Positive = 20000.0
    record_hz: Positive = 4000.0
    unbalances: Annotated[tuple[UnbalanceSpec, ...], Field(max_length=MOST)] = ()
    gravity_m_per_s2: tuple[Finite, Finite, Finite] | None = None
    drives: Annotated[tuple[Place, ...], Field(max_length=MOST)] = ()
    observe: Annotated[tuple[Place, ...], Field(max_length=MOST)] = ()
    mount: Name
    compare_flexible: Annotated[
        tuple[Annotated[tuple[Name, ...], Field(max_length=MOST)], ...], Field(max_length=MOST)
    ] = ()
    bands_hz: Annotated[tuple[tuple[NotNegative, Positive], ...], Field(max_length=MOST)] = ()

    @model_validator(mode="after")
    def _whole(self) -> RunUpSpec:
        if self.record_hz > self.sampling_hz:
            raise ValueError(
                f"record_hz = {self.record_hz:g} is above sampling_hz = {self.sampling_hz:g}"
            )
        steps = (self.ramp_s + self.hold_s) * self.sampling_hz
        if steps > _MOST_STEPS:
            raise ValueError(
                f"(ramp_s + hold_s) * sampling_hz is {steps:.6g} steps; at most {_MOST_STEPS:g}"
            )
        every = self.sampling_hz / self.record_hz
        if abs(every - round(every)) > _WHOLE * every:
            near = self.sampling_hz / math.floor(every), self.sampling_hz / math.ceil(every)
            raise ValueError(
                f"sampling_hz / record_hz is {every:.9g} and must be whole; the nearest record_hz "
                f"are {near[1]:.9g} and {near[0]:.9g}"
            )
        for key in ("ramp_s", "hold_s"):
            steps = getattr(self, key) * self.sampling_hz
            if abs(steps - round(steps)) > _WHOLE or (key == "ramp_s" and steps < 0.5):
                raise ValueError(
                    f"{key} * sampling_hz is {steps:.12g}; {key} must be a whole number of steps "
                    f"of 1 / sampling_hz = {1.0 / self.sampling_hz:.9g} s"
                )
        return self

    @model_validator(mode="after")
    def _comparable(self) -> RunUpSpec:
        kept = [frozenset(names) for names in self.compare_flexible]
        for k, names in enumerate(kept):
            if names in kept[:k]:
                raise ValueError(
                    f"compare_flexible[{k}] is the same as compare_flexible[{kept.index(names)}]"
                )
            if len(names) < len(self.compare_flexible[k]):
                raise ValueError(f"compare_flexible[{k}] names a body twice")
        if len(kept) > _MOST_MODELS:
            raise ValueError(f"compare_flexible has {len(kept)} models; at most {_MOST_MODELS}")
        if self.compare_flexible and not self.unbalances:
            raise ValueError("compare_flexible needs unbalances, which the responses refer to")
        if self.compare_flexible and not self.bands_hz:
            raise ValueError("compare_flexible needs bands_hz, in which models are compared")
        for low, high in self.bands_hz:
            if high <= low:
                raise ValueError(f"bands_hz has ({low:g}, {high:g}); the second must be higher")
        return self


class StateSpaceSpec(_Analysis):
    """State-space matrices between forces and motions of interfaces."""

    kind: Literal["state_space"]
    inputs: Places
    outputs: Places
    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    speed_count: Annotated[Count, Field(ge=2, le=501)] = 11

    @model_validator(mode="after")
    def _range(self) -> StateSpaceSpec:
        _refuse_falling(self.from_rpm, self.to_rpm)
        return self


AnalysisSpec = Annotated[
    UnbalanceResponseSpec
    | PlaceMapSpec
    | WaterfallSpec
    | CriticalSpeedMapSpec
    | StiffnessStudySpec
    | RotatingCampbellSpec
    | ModeShapesSpec
    | SeparationMarginsSpec
    | StabilitySpec
    | BearingLawsSpec
    | RunUpSpec
    | StateSpaceSpec
    | RecoverySpec,
    Field(discriminator="kind"),
]
