"""What a scene says of a machine beside its rotor: probes, clearances, stages, seals."""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from pydantic import Field, model_validator

from solidwhirl.analyses.base import Names
from solidwhirl.core.fields import MOST, Finite, Name, Place, Positive, Record, Title
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM


class ProbeSpec(Record):
    """Probes that look at an interface."""

    at: Place
    angle_deg: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=8)] = (45.0, 135.0)


class ClearanceSpec(Record):
    """A place with a close running clearance."""

    at: Place
    diametral_m: Positive
    floating_ring: bool = False


class StageSpec(Record):
    """A stage whose work may destabilise the rotor."""

    at: Place
    kind: Literal["radial", "axial"] = "radial"
    power_w: Positive
    diameter_m: Positive
    height_m: Positive
    speed_rpm: Positive | None = None
    density_ratio: Positive | None = None
    suction_density_kg_per_m3: Positive | None = None
    discharge_density_kg_per_m3: Positive | None = None

    @model_validator(mode="after")
    def _densities(self) -> StageSpec:
        ends = (self.suction_density_kg_per_m3, self.discharge_density_kg_per_m3)
        if (ends[0] is None) != (ends[1] is None):
            raise ValueError(
                "has one of suction_density_kg_per_m3 and discharge_density_kg_per_m3; give both"
            )
        if ends[0] is not None and self.density_ratio is not None:
            raise ValueError("has density_ratio and densities; one of them says the ratio")
        if self.kind == "radial" and self.ratio is None:
            raise ValueError("a radial stage needs density_ratio, or both densities")
        return self

    @property
    def ratio(self) -> float | None:
        """Discharge density over suction density."""
        suction, discharge = self.suction_density_kg_per_m3, self.discharge_density_kg_per_m3
        if suction is None or discharge is None:
            return self.density_ratio
        return discharge / suction


class CrossCouplingSpec(Record):
    """Cross-coupled stiffness at a place, k_xy = −k_yx."""

    at: Place
    stiffness_n_per_m: Finite


class SourceSpec(Record):
    """A group of parts that level II of the stability analysis adds to the base rotor."""

    name: Title
    bearings: Names | None = None
    stages: Annotated[tuple[Place, ...], Field(max_length=MOST)] = ()
    cross_couplings: Annotated[tuple[CrossCouplingSpec, ...], Field(max_length=MOST)] = ()

    @model_validator(mode="after")
    def _something(self) -> SourceSpec:
        if not (self.bearings or self.stages or self.cross_couplings):
            raise ValueError("names nothing; give bearings, stages or cross_couplings")
        return self


class BearingCaseSpec(Record):
    """Other speed laws of bearings, such as those of the largest clearance and the hottest oil."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_ -]{0,63}$")]
    laws: Annotated[dict[Name, Name], Field(min_length=1, max_length=MOST)]

    @property
    def file_part(self) -> str:
        """Its name as part of the names of files."""
        return self.name.replace(" ", "_")


class OverhangSpec(Record):
    """Mass beyond an outermost journal."""

    bearing: Name
    mass_kg: Positive


class Machine(NamedTuple):
    """A shaft and its speeds, rpm of the shaft itself, and its |ratio| to the reference."""

    shaft: str
    low_rpm: float
    high_rpm: float
    trip_rpm: float
    ratio: float

    def reference_rad_s(self, rpm: float) -> float:
        """Return the speed Ω of the reference shaft at a speed of the shaft, rad/s."""
        return rpm * RAD_S_PER_RPM / self.ratio
