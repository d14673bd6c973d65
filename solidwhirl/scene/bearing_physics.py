"""Speed laws of a scene that give absolute coefficients: tables, and bearings by their physics."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, field_validator, model_validator

from solidwhirl.core.fields import MOST, Count, Finite, Motion, NotNegative, Positive, Record
from solidwhirl.rotordyn.bearings.speed_tables import SpeedTable, tabulate
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

if TYPE_CHECKING:  # each kind of bearing is loaded by a scene that has one
    from solidwhirl.rotordyn.bearings.rolling import (
        BearingSet,
        RingLoad,
        RingTable,
        RollingBearing,
    )
    from solidwhirl.rotordyn.bearings.short_film import ShortFilm
    from solidwhirl.rotordyn.bearings.squeeze_film import SqueezeFilmDamper
    from solidwhirl.rotordyn.bearings.validity import Exceeded

_TABLES = 64


class AbsoluteLaw(Record):
    """Base of the laws that replace a bearing's own coefficients."""

    #: Coefficients that the file of a table does not give, and what they are taken as
    _assumed: tuple[str, ...] = PrivateAttr(default=())

    @property
    def assumed(self) -> tuple[str, ...]:
        """What stands for coefficients that the file of a table does not give."""
        return self._assumed

    def assuming(self, assumed: tuple[str, ...]) -> Self:
        """Return the same law with what its reader assumed."""
        made = self.model_copy()
        made._assumed = assumed
        return made

    def table(self) -> SpeedTable:
        """Return the coefficients over the speed."""
        raise NotImplementedError

    @property
    def holds_tilts(self) -> bool:
        """Whether rx and ry are in it."""
        return False

    @property
    def held(self) -> tuple[Motion, ...]:
        """Motions beside ux and uy that it is on."""
        return ("rx", "ry") if self.holds_tilts else ()


class ComputedLaw(AbsoluteLaw):
    """Base of the laws that are computed; what cannot be is refused where the scene is read."""

    @model_validator(mode="after")
    def _possible(self) -> ComputedLaw:
        self.table()
        return self

    def table(self) -> SpeedTable:
        """Return the coefficients over the speed, computed once."""
        return _table_of(self)

    def computed(self) -> SpeedTable:
        """Compute the coefficients over the speed; ValueError says what cannot be."""
        raise NotImplementedError

    def exceeded(self, speed_rad_s: float) -> tuple[Exceeded, ...]:
        """Return where the bearing is beyond its theory at a speed within the table."""
        raise NotImplementedError


@lru_cache(maxsize=_TABLES)
def _table_of(law: ComputedLaw) -> SpeedTable:
    return law.computed()


class RollingLawSpec(ComputedLaw):
    """A ball or cylindrical roller bearing, or a set of angular contact bearings, by its load."""

    kind: Literal["rolling"]
    elements: Literal["balls", "rollers"] = "balls"
    count: Count
    element_diameter_m: Positive
    pitch_diameter_m: Positive
    roller_length_m: Positive | None = None
    contact_angle_deg: NotNegative = 0.0
    radial_clearance_m: Finite = 0.0
    inner_groove: Positive = 0.52
    outer_groove: Positive = 0.53
    arrangement: Annotated[str, Field(pattern=r"^(DB|DF|DT|[<>]{1,12})$")] = "<"
    spacing_m: Annotated[tuple[Positive, ...], Field(max_length=MOST)] = ()
    load_n: tuple[Finite, Finite, Finite]
    preload_n: NotNegative = 0.0
    preload: Literal["spring", "rigid"] = "spring"
    motions: Annotated[tuple[Motion, ...], Field(max_length=6)] = ("ux", "uy", "uz", "rx", "ry")
    highest_rpm: Positive
    damping_n_s_per_m: NotNegative = 0.0

    @field_validator("spacing_m", mode="before")
    @classmethod
    def several(cls, value: Any) -> Any:
        """One distance, or a list of them."""
        return (value,) if isinstance(value, int | float) else value

    @property
    def held(self) -> tuple[Motion, ...]:
        """Motions beside ux and uy that it is on; rollers carry nothing along the axis."""
        return tuple(m for m in self.motions[2:] if m != "uz" or self.elements == "balls")

    def bearing(self) -> BearingSet:
        """Return the bearing or set; ValueError names what is wrong."""
        from solidwhirl.rotordyn.bearings.rolling import BearingSet

        if self.motions not in _RING_MOTIONS:
            allowed = ", ".join(str(list(own)) for own in _RING_MOTIONS)
            raise ValueError(f"motions is {list(self.motions)}; allowed is one of {allowed}")
        rows = {"DB": "<>", "DF": "><", "DT": "<<"}.get(self.arrangement, self.arrangement)
        count, one = len(rows), self.contact_angle_deg == 0.0
        if one and rows != "<":
            raise ValueError(
                f"arrangement {self.arrangement!r} is of angular contact bearings, and "
                "contact_angle_deg is 0"
            )
        if len(self.spacing_m) not in ((1, count - 1) if count > 1 else (0,)):
            needed = "none" if count == 1 else f"1, or {count - 1}"
            raise ValueError(
                f"spacing_m has {len(self.spacing_m)} distances; arrangement "
                f"{self.arrangement!r} of {count} rows needs {needed}"
            )
        steps = self.spacing_m * (count - 1) if len(self.spacing_m) == 1 else self.spacing_m
        places = np.concatenate(([0.0], np.cumsum(steps)))
        return BearingSet(
            row=self._row(),
            facing=tuple(1 if way == "<" else -1 for way in rows),
            places_m=tuple((places - 0.5 * (places[0] + places[-1])).tolist()),
        )

    def _row(self) -> RollingBearing:
        from solidwhirl.rotordyn.bearings.balls import BallBearing
        from solidwhirl.rotordyn.bearings.rollers import RollerBearing

        sizes: dict[str, Any] = {
            "pitch_diameter_m": self.pitch_diameter_m,
            "radial_clearance_m": self.radial_clearance_m,
        }
        if self.elements == "rollers":
            if self.roller_length_m is None:
                raise ValueError("rollers need roller_length_m")
            if self.contact_angle_deg:
                raise ValueError(
                    "contact_angle_deg is of balls; tapered rollers are not modelled, give their "
                    "stiffness as a table"
                )
            return RollerBearing(
                roller_count=self.count,
                roller_diameter_m=self.element_diameter_m,
                effective_length_m=self.roller_length_m,
                **sizes,
            )
        if self.roller_length_m is not None:
            raise ValueError("balls have no roller_length_m")
        return BallBearing(
            ball_count=self.count,
            ball_diameter_m=self.element_diameter_m,
            inner_groove=self.inner_groove,
            outer_groove=self.outer_groove,
            contact_angle_rad=float(np.radians(self.contact_angle_deg)),
            **sizes,
        )

    def load(self) -> RingLoad:
        """Return what presses it."""
        from solidwhirl.rotordyn.bearings.rolling import RingLoad

        return RingLoad(load_n=self.load_n, preload_n=self.preload_n, preload=self.preload)

    @model_validator(mode="after")
    def _possible(self) -> RollingLawSpec:
        self.ring_table()
        return self

    def ring_table(self) -> RingTable:
        """Return the stiffness on ux, uy, uz, rx, ry over the speed, computed once."""
        return _ring_table_of(self)

    def computed(self) -> SpeedTable:
        """Return stiffness and damping on ux and uy over the speed."""
        found = self.ring_table()
        stiffness = found.stiffness[:, :2, :2]
        damping = np.broadcast_to(self.damping_n_s_per_m * np.eye(2), stiffness.shape)
        return SpeedTable(found.speeds_rad_s, stiffness, damping, "cubic")

    def exceeded(self, speed_rad_s: float) -> tuple[Exceeded, ...]:
        """Return whether contact pressure or speed are too high."""
        from solidwhirl.rotordyn.bearings import rolling

        bearings, load = self.bearing(), self.load()
        states = rolling.ring_states(bearings, load, np.array([speed_rad_s]), np.zeros(1))
        return rolling.exceeded(bearings.row, states, speed_rad_s)


_RING_MOTIONS = (
    ("ux", "uy", "uz", "rx", "ry"),
    ("ux", "uy", "rx", "ry"),
    ("ux", "uy", "uz"),
    ("ux", "uy"),
)


@lru_cache(maxsize=_TABLES)
def _ring_table_of(law: RollingLawSpec) -> RingTable:
    from solidwhirl.rotordyn.bearings.rolling import ring_table

    # a ring that does not take part in axial motion slides where springs push it
    floats = "uz" not in law.held and law.preload == "spring"
    top = law.highest_rpm / RPM_PER_RAD_S
    return ring_table(law.bearing(), law.load(), top, floats=floats)


class _FilmSpec(ComputedLaw):
    """Base of the laws of short films."""

    diameter_m: Positive
    length_m: Positive
    radial_clearance_m: Positive
    viscosity_pa_s: Positive
    film: Literal["pi", "2pi"] = "pi"
    lands: Count = 1

    def short_film(self) -> ShortFilm:
        """Return the film; ValueError names what is wrong."""
        from solidwhirl.rotordyn.bearings.short_film import ShortFilm

        return ShortFilm(**{key: getattr(self, key) for key in _FilmSpec.model_fields})


class ShortBearingLawSpec(_FilmSpec):
    """A short plain journal bearing under a load."""

    kind: Literal["short_bearing"]
    load_n: tuple[Finite, Finite]
    speed_rpm: tuple[Positive, Positive]

    def computed(self) -> SpeedTable:
        """Compute stiffness and damping over the speed."""
        from solidwhirl.rotordyn.bearings.short_bearing import journal_state

        film, (low, high) = self.short_film(), self.speed_rpm
        if high <= low:
            raise ValueError(f"speed_rpm has ({low:g}, {high:g}); the second must be higher")

        def at(speed: float) -> tuple[FloatArray, FloatArray]:
            found = journal_state(film, self.load_n, speed)
            return found.stiffness_n_per_m, found.damping_n_s_per_m

        return tabulate(at, low / RPM_PER_RAD_S, high / RPM_PER_RAD_S)

    def exceeded(self, speed_rad_s: float) -> tuple[Exceeded, ...]:
        """Return whether the bearing is too long or the journal too far out."""
        from solidwhirl.rotordyn.bearings import short_bearing

        film = self.short_film()
        state = short_bearing.journal_state(film, self.load_n, speed_rad_s)
        return short_bearing.exceeded(film, state)


class SqueezeFilmLawSpec(_FilmSpec):
    """A squeeze film damper on a centred circular orbit."""

    kind: Literal["squeeze_film"]
    ends: Literal["open", "sealed"] = "open"
    orbit_ratio: Annotated[float, Field(ge=0, lt=1, strict=True)]
    whirl_ratio: Finite = 1.0
    highest_rpm: Positive
    density_kg_per_m3: Positive | None = None
    supply_pressure_pa: NotNegative | None = None

    def damper(self) -> SqueezeFilmDamper:
        """Return the damper; ValueError names what is wrong."""
        from solidwhirl.rotordyn.bearings.squeeze_film import SqueezeFilmDamper

        return SqueezeFilmDamper(
            film=self.short_film(),
            orbit_ratio=self.orbit_ratio,
            ends=self.ends,
            whirl_ratio=self.whirl_ratio,
        )

    def computed(self) -> SpeedTable:
        """Compute stiffness, proportional to the speed, and damping."""
        ends = np.array([0.0, self.highest_rpm / RPM_PER_RAD_S])
        return self.over_whirl(ends, self.whirl_ratio)

    def over_whirl(self, speeds_rad_s: FloatArray, ratio: float = 1.0) -> SpeedTable:
        """Return the coefficients at speeds whose whirl is a multiple of them, (s,)."""
        damper = self.damper()
        found = np.array([damper.coefficients(ratio * float(speed)) for speed in speeds_rad_s])
        both = found[:, :, None, None] * np.eye(2)
        return SpeedTable(speeds_rad_s, both[:, 0], both[:, 1], "linear")

    def exceeded(self, speed_rad_s: float) -> tuple[Exceeded, ...]:
        """Return whether the film is too long, the orbit too wide, or the oil does otherwise."""
        whirl = self.whirl_ratio * speed_rad_s
        return self.damper().exceeded(whirl, self.density_kg_per_m3, self.supply_pressure_pa)
