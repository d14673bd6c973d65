"""Scene records of what joins bodies, and of bodies that are no solids."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
    field_validator,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from solidwhirl.core.fields import (
    MOST,
    ZERO_MATRIX,
    BesideScene,
    EndText,
    FileName,
    Finite,
    Matrix,
    Motion,
    Name,
    NotNegative,
    Positive,
    Record,
    TiltMatrix,
    validated_at,
)
from solidwhirl.rotordyn.bearings.speed_tables import SpeedTable
from solidwhirl.scene.bearing_physics import (
    AbsoluteLaw,
    RollingLawSpec,
    ShortBearingLawSpec,
    SqueezeFilmLawSpec,
)
from solidwhirl.scene.magnetic_bearings import MagneticLawSpec

# Rows of a table nearer to each other than this fraction of the highest speed are one speed.
_ONE_SPEED = 1e-12
Coefficients = Annotated[tuple[Finite, ...], Field(min_length=1, max_length=16)]
_Nested = Annotated[
    tuple[Annotated[tuple[TiltMatrix, ...], Field(max_length=MOST)], ...], Field(max_length=MOST)
]
Preset = Literal["lee_isotropic", "lee_anisotropic"]


class InternalDampingSpec(Record):
    """Damping of a body's material, which turns with it."""

    stiffness_coefficient_s: NotNegative = 0.0
    modal_ratio: Annotated[float, Field(ge=0, lt=1, strict=True)] = 0.0


class BeamDiskSpec(Record):
    """A rigid disk on a beam."""

    name: Name
    at_m: Finite
    mass_kg: NotNegative
    polar_inertia_kg_m2: NotNegative
    diametral_inertia_kg_m2: NotNegative

    @model_validator(mode="after")
    def _possible(self) -> BeamDiskSpec:
        if self.polar_inertia_kg_m2 > 2.0 * self.diametral_inertia_kg_m2 * (1.0 + 1e-9):
            raise ValueError("polar_inertia_kg_m2 is above twice diametral_inertia_kg_m2")
        return self


class BeamSpec(Record):
    """A rotor as a stepped Timoshenko beam with rigid disks."""

    speed_ratio: Finite = 1.0
    material: Name
    stations_m: Annotated[tuple[Finite, ...], Field(min_length=2, max_length=MOST)]
    outer_radius_m: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=MOST)]
    inner_radius_m: Annotated[tuple[NotNegative, ...], Field(max_length=MOST)] = (0.0,)
    interfaces: Annotated[dict[Name, Finite], Field(min_length=1, max_length=MOST)]
    disks: Annotated[tuple[BeamDiskSpec, ...], Field(max_length=MOST)] = ()
    internal_damping: InternalDampingSpec | None = None

    @model_validator(mode="after")
    def _lengths(self) -> BeamSpec:
        sections = len(self.stations_m) - 1
        if list(self.stations_m) != sorted(set(self.stations_m)):
            raise ValueError("stations_m must be increasing")
        for key in ("outer_radius_m", "inner_radius_m"):
            found = len(getattr(self, key))
            if found not in (1, sections):
                raise ValueError(f"{key} has {found} values; 1 or {sections}, one per section")
        return self

    @property
    def section_radii_m(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Outer and inner radii, one of each per section."""
        sections = len(self.stations_m) - 1
        outer, inner = (
            radii if len(radii) == sections else sections * radii
            for radii in (self.outer_radius_m, self.inner_radius_m)
        )
        return outer, inner


class RigidBodySpec(Record):
    """A rigid body such as a casing; it does not turn unless speed_ratio says so."""

    speed_ratio: Finite = 0.0
    mass_kg: Positive
    center_of_gravity_m: tuple[Finite, Finite, Finite]
    inertia_kg_m2: tuple[Positive, Positive, Positive]
    interfaces: Annotated[dict[Name, Finite], Field(min_length=1, max_length=MOST)]

    @model_validator(mode="after")
    def _possible(self) -> RigidBodySpec:
        largest = max(self.inertia_kg_m2)
        others = sum(self.inertia_kg_m2) - largest
        if largest > others * (1.0 + 1e-9):
            raise ValueError(
                f"inertia_kg_m2 has {largest:.12g}, which is above the sum of the other two, "
                f"{others:.12g}; no body is like that"
            )
        return self

    @model_validator(mode="after")
    def _turning(self) -> RigidBodySpec:
        x, y, _ = self.center_of_gravity_m
        round_body = x == y == 0.0 and self.inertia_kg_m2[0] == self.inertia_kg_m2[1]
        if self.speed_ratio != 0.0 and not round_body:
            raise ValueError(
                "a body that turns needs its centre of gravity on the axis and equal inertia about "
                "x and y; put an unbalance on it for what is off the axis"
            )
        return self


_ENDS = ("first", "second", "sensor")
_OnePlace = {"type": "string", "maxLength": 129}
#: An end of a bearing; a list in a file, where an entry stands for one bearing at each place.
BearingEnd = Annotated[
    EndText,
    WithJsonSchema({"anyOf": [_OnePlace, {"type": "array", "items": _OnePlace, "minItems": 1}]}),
]


class BearingSpec(Record):
    """A linear bearing between two interfaces, or an interface and the ground."""

    name: Name
    first: BearingEnd
    second: BearingEnd = "ground"
    stiffness_n_per_m: Matrix = ZERO_MATRIX
    damping_n_s_per_m: Matrix = ZERO_MATRIX
    tilt_stiffness_n_m_per_rad: Matrix = ZERO_MATRIX
    tilt_damping_n_m_s_per_rad: Matrix = ZERO_MATRIX
    axial_stiffness_n_per_m: NotNegative = 0.0
    axial_damping_n_s_per_m: NotNegative = 0.0
    torsion_stiffness_n_m_per_rad: NotNegative = 0.0
    torsion_damping_n_m_s_per_rad: NotNegative = 0.0
    rigid: Annotated[tuple[Motion, ...], Field(max_length=MOST)] = ()
    speed_law: Name | None = None
    sensor: BearingEnd | None = None
    cross_coupling: Literal["with_spin", "as_given"] = "with_spin"
    _entry: int = PrivateAttr(default=0)

    @property
    def key(self) -> str:
        """Its entry in the scene file, which may stand for bearings at several places."""
        return f"bearings[{self._entry}]"


def _at_places(value: Any, handler: ValidatorFunctionWrapHandler) -> tuple[BearingSpec, ...]:
    """Put a bearing at each place of the entries that name several.

    Each is called NAME_INTERFACE, by its place in the longest list; NAME_BODY_INTERFACE where
    interfaces of several bodies have one name.
    """
    if not isinstance(value, list | tuple):
        return handler(value)  # type: ignore[no-any-return]
    given = [(k, one) for k, entry in enumerate(value) for one in _spread(k, entry)]
    written = [k for k, _ in given]

    def in_file(keys: tuple[int | str, ...]) -> tuple[int | str, ...]:
        return (written[int(keys[0])], *keys[1:]) if keys else ()

    found = validated_at(handler, [one for _, one in given], in_file)
    for spec, entry in zip(found, written, strict=True):
        spec._entry = entry
    return tuple(found)


def _spread(number: int, entry: Any) -> list[Any]:
    """The bearings of an entry as tables with one place at each end."""
    lists = {key: entry[key] for key in _ENDS if isinstance(entry, dict) and key in entry}
    lists = {key: places for key, places in lists.items() if isinstance(places, list)}
    if not lists:
        return [entry]
    counts = {key: len(places) for key, places in lists.items()}
    if len({*counts.values()}) > 1 or 0 in counts.values():
        said = " and ".join(f"{key} has {count}" for key, count in counts.items())
        problem = PydanticCustomError(
            "places",
            "{said} places; allowed is one place, or as many as the others have",
            {"said": said},
        )
        details = InitErrorDetails(type=problem, loc=(number,), input={})
        raise ValidationError.from_exception_data("bearings", [details])
    places = next(iter(lists.values()))
    named = [str(place).partition(".")[2] for place in places]
    if len(set(named)) < len(named):
        named = [str(place).replace(".", "_") for place in places]
    return [
        entry
        | {key: own[k] for key, own in lists.items()}
        | ({"name": f"{entry['name']}_{named[k]}"} if isinstance(entry.get("name"), str) else {})
        for k in range(len(places))
    ]


Bearings = Annotated[tuple[BearingSpec, ...], Field(max_length=MOST), WrapValidator(_at_places)]


class GearSpec(Record):
    """A gear between two bodies; rz of `second` is ratio times rz of `first`."""

    name: Name
    first: EndText
    second: EndText
    ratio: Finite
    mesh_stiffness_n_per_m: Positive | None = None
    mesh_damping_n_s_per_m: NotNegative = 0.0
    base_radius_first_m: Positive | None = None
    line_of_action_deg: Finite | None = None

    @model_validator(mode="after")
    def _complete(self) -> GearSpec:
        if self.ratio == 0.0:
            raise ValueError("ratio is 0; a gear needs another one")
        elastic = self.mesh_stiffness_n_per_m is not None or self.line_of_action_deg is not None
        if elastic and self.base_radius_first_m is None:
            raise ValueError(
                "base_radius_first_m is needed with mesh_stiffness_n_per_m or line_of_action_deg"
            )
        if self.mesh_damping_n_s_per_m and self.mesh_stiffness_n_per_m is None:
            raise ValueError("a rigid mesh has no damping; give mesh_stiffness_n_per_m too")
        return self


class PolynomialLawSpec(Record):
    """Factors of a bearing's coefficients as polynomials of the speed, lowest order first."""

    kind: Literal["polynomial"]
    argument_unit: Literal["rad/s", "rpm", "Hz"]
    argument_range: tuple[NotNegative, Positive]
    stiffness_x: Coefficients
    stiffness_y: Coefficients
    damping_x: Coefficients = (1.0,)
    damping_y: Coefficients = (1.0,)

    @model_validator(mode="after")
    def _rising(self) -> PolynomialLawSpec:
        low, high = self.argument_range
        if high <= low:
            raise ValueError(f"argument_range has ({low:g}, {high:g}); the second must be higher")
        return self


class TableLawSpec(AbsoluteLaw):
    """Coefficients of a bearing at given speeds of its rotor."""

    kind: Literal["table"]
    interpolation: Literal["linear", "monotone"] = "monotone"
    speed_rpm: Annotated[tuple[NotNegative, ...], Field(min_length=2, max_length=MOST)]
    stiffness_n_per_m: Annotated[tuple[Matrix, ...], Field(max_length=MOST)]
    damping_n_s_per_m: Annotated[tuple[Matrix, ...], Field(max_length=MOST)]

    @model_validator(mode="after")
    def _lengths(self) -> TableLawSpec:
        count = len(self.speed_rpm)
        for key in ("stiffness_n_per_m", "damping_n_s_per_m"):
            if len(getattr(self, key)) != count:
                found = len(getattr(self, key))
                raise ValueError(f"{key} has {found} entries for {count} speeds")
        if list(self.speed_rpm) != sorted(set(self.speed_rpm)):
            raise ValueError("speed_rpm must be increasing")
        for low, high in pairwise(self.speed_rpm):
            if high - low <= _ONE_SPEED * self.speed_rpm[-1]:
                raise ValueError(
                    f"speed_rpm has {low:g} and {high:g}, which are one speed beside the highest, "
                    f"{self.speed_rpm[-1]:g}; allowed is more than {_ONE_SPEED:g} of it between two"
                )
        return self

    def table(self) -> SpeedTable:
        """Return the rows."""
        return SpeedTable(
            np.array(self.speed_rpm) * np.pi / 30.0,
            np.array(self.stiffness_n_per_m, dtype=float),
            np.array(self.damping_n_s_per_m, dtype=float),
            self.interpolation,
        )


class FrequencyTableLawSpec(AbsoluteLaw):
    """Coefficients of a bearing over the speed and the frequency of the motion, with added mass.

    Nested [speed][frequency]; without frequencies [speed].
    """

    kind: Literal["frequency_table"]
    interpolation: Literal["linear", "monotone"] = "monotone"
    speed_rpm: Annotated[tuple[NotNegative, ...], Field(min_length=2, max_length=MOST)]
    frequency_hz: Annotated[tuple[NotNegative, ...], Field(max_length=MOST)] = ()
    stiffness_n_per_m: _Nested
    damping_n_s_per_m: _Nested
    added_mass_kg: _Nested = ()

    @field_validator("stiffness_n_per_m", "damping_n_s_per_m", "added_mass_kg", mode="before")
    @classmethod
    def _one_frequency(cls, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, list | tuple) and not info.data.get("frequency_hz"):
            return [[row] for row in value]
        return value

    @model_validator(mode="after")
    def _lengths(self) -> FrequencyTableLawSpec:
        if len(self.frequency_hz) == 1:
            raise ValueError("frequency_hz has one value; two or more are needed, or none")
        for name in ("speed_rpm", "frequency_hz"):
            axis = getattr(self, name)
            for low, high in pairwise(axis):
                if high - low <= _ONE_SPEED * axis[-1]:
                    raise ValueError(f"{name} must be increasing; it has {low:g}, then {high:g}")
        across = max(1, len(self.frequency_hz))
        sizes = set()
        for key in ("stiffness_n_per_m", "damping_n_s_per_m", "added_mass_kg"):
            rows = getattr(self, key)
            if key == "added_mass_kg" and not rows:
                continue
            if len(rows) != len(self.speed_rpm):
                raise ValueError(f"{key} has {len(rows)} entries for {len(self.speed_rpm)} speeds")
            for place, row in enumerate(rows):
                if len(row) != across:
                    raise ValueError(
                        f"{key}[{place}] has {len(row)} entries for {across} frequencies"
                    )
                sizes |= {len(matrix) for matrix in row}
        if len(sizes) > 1:
            raise ValueError("matrices are on ux and uy in one place, with tilts in another")
        return self

    def table(self) -> SpeedTable:
        """Return the rows of the lowest frequency on ux and uy, with the damping of any."""
        stiffness, damping = (
            np.array(rows, dtype=float)[..., :2, :2]
            for rows in (self.stiffness_n_per_m, self.damping_n_s_per_m)
        )
        speeds = np.array(self.speed_rpm) * np.pi / 30.0
        return SpeedTable(speeds, stiffness[:, 0], damping.max(axis=1), self.interpolation)

    @property
    def holds_tilts(self) -> bool:
        """Whether rx and ry are in it."""
        return len(self.stiffness_n_per_m[0][0]) == 4


class LoadTableLawSpec(AbsoluteLaw):
    """Tables of a bearing at several loads, read at those that a static analysis finds."""

    kind: Literal["load_table"]
    load_from: FileName = "static"
    load_n: Annotated[tuple[NotNegative, ...], Field(min_length=2, max_length=MOST)]
    tables: Annotated[
        tuple[Annotated[TableLawSpec | FrequencyTableLawSpec, Field(discriminator="kind")], ...],
        Field(max_length=MOST),
    ]

    @model_validator(mode="after")
    def _alike(self) -> LoadTableLawSpec:
        if len(self.tables) != len(self.load_n):
            raise ValueError(f"tables has {len(self.tables)} entries for {len(self.load_n)} loads")
        if list(self.load_n) != sorted(set(self.load_n)):
            raise ValueError("load_n must be increasing")
        axes = {
            (t.kind, t.speed_rpm, getattr(t, "frequency_hz", ()), t.holds_tilts)
            for t in self.tables
        }
        if len(axes) > 1:
            raise ValueError(
                "tables differ in kind, speed_rpm, frequency_hz or size of matrices; allowed is one"
            )
        return self

    def table(self) -> SpeedTable:
        """Return the rows of the highest load."""
        return self.tables[-1].table()

    @property
    def holds_tilts(self) -> bool:
        """Whether rx and ry are in its tables."""
        return self.tables[-1].holds_tilts


class PresetLawSpec(Record):
    """A law that comes with the program."""

    kind: Literal["preset"]
    preset: Preset


class FileLawSpec(Record):
    """A table in a file of the bearing's maker; a scene that is read has the table in its place."""

    kind: Literal["file"]
    file: BesideScene
    tag: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    axis: Literal["speed", "frequency"] | None = None
    load_n: NotNegative | None = None
    load_from: FileName | None = None
    maker_spin: Literal["x_to_y", "y_to_x"] = "x_to_y"
    turned_deg: Finite = 0.0
    interpolation: Literal["linear", "monotone"] = "monotone"

    @model_validator(mode="after")
    def _one_load(self) -> FileLawSpec:
        if self.load_n is not None and self.load_from is not None:
            raise ValueError("load_n gives the load and load_from takes it; give one of the two")
        return self


SpeedLawSpec = Annotated[
    PolynomialLawSpec
    | TableLawSpec
    | FrequencyTableLawSpec
    | LoadTableLawSpec
    | FileLawSpec
    | PresetLawSpec
    | RollingLawSpec
    | ShortBearingLawSpec
    | SqueezeFilmLawSpec
    | MagneticLawSpec,
    Field(discriminator="kind"),
]
