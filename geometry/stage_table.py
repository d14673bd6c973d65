"""The parametrised engine's stage rule and its table of stage groups."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.plane_graph import FloatArray


def stage_values(origin: float, factor: float, count: int) -> FloatArray:
    """Return a dimension of consecutive stages: value = origin * factor**(stage - 1).

    Parameters
    ----------
    origin : float
        Value of stage 1, in any unit.
    factor : float
        Ratio of consecutive stages [-].
    count : int
        Number of stages.

    Returns
    -------
    (count,) float array
        In the unit of `origin`, read-only.

    Raises
    ------
    GeometryError
        If origin or factor is not finite and positive, or there is no stage.

    Notes
    -----
    Rule of Appendix C of Müller and Hennings, rotor dynamics of an ultra-high bypass ratio engine.
    """
    for label, value in (("origin", origin), ("factor", factor)):
        if not (math.isfinite(value) and value > 0.0):
            raise GeometryError(f"stage rule: {label} is {value}, must be finite and positive")
    if count < 1:
        raise GeometryError(f"stage rule: {count} stages asked for, needs at least one")
    values: FloatArray = origin * factor ** np.arange(count, dtype=np.float64)
    values.setflags(write=False)
    return values


@dataclass(frozen=True, kw_only=True, slots=True)
class StageGroup:
    """Hold the first stage's dimensions of a group and their ratios from stage to stage.

    Attributes
    ----------
    name : str
        Name used in messages.
    count : int
        Number of stages.
    inner_radius_m, outer_radius_m, width_m, second_width_m : float
        Values of stage 1 [m]. `width_m` is the axial width of the disk or drum ring; for
        `second_width_m` see `TABLE_7`.
    inner_factor, outer_factor, width_factor, second_width_factor : float
        Ratio of consecutive stages [-].

    Raises
    ------
    GeometryError
        If a value is not finite and positive, or a ring's inner radius reaches its outer one.
    """

    name: str
    count: int
    inner_radius_m: float
    inner_factor: float
    outer_radius_m: float
    outer_factor: float
    width_m: float
    width_factor: float
    second_width_m: float
    second_width_factor: float

    def __post_init__(self) -> None:
        try:
            inner, outer = self.inner_radii_m, self.outer_radii_m
            _ = self.widths_m, self.second_widths_m
        except GeometryError as error:
            raise GeometryError(f"stage group '{self.name}': {error}") from None
        for stage, (low, high) in enumerate(zip(inner, outer, strict=True), start=1):
            if low >= high:
                raise GeometryError(
                    f"stage group '{self.name}': stage {stage} has the inner radius {low:.6g} m, "
                    f"which must be below its outer radius {high:.6g} m"
                )

    @property
    def inner_radii_m(self) -> FloatArray:
        """Inner radius of every stage, (count,) [m]."""
        return stage_values(self.inner_radius_m, self.inner_factor, self.count)

    @property
    def outer_radii_m(self) -> FloatArray:
        """Outer radius of every stage, (count,) [m]."""
        return stage_values(self.outer_radius_m, self.outer_factor, self.count)

    @property
    def widths_m(self) -> FloatArray:
        """Axial width of every stage's ring, (count,) [m]."""
        return stage_values(self.width_m, self.width_factor, self.count)

    @property
    def second_widths_m(self) -> FloatArray:
        """Second width of every stage, (count,) [m]; the last one is not used by the layout."""
        return stage_values(self.second_width_m, self.second_width_factor, self.count)


TABLE_7: Mapping[str, StageGroup] = MappingProxyType(
    {
        "lp_compressor": StageGroup(
            name="lp_compressor",
            count=3,
            inner_radius_m=0.46,
            inner_factor=0.99,
            outer_radius_m=0.56,
            outer_factor=0.96,
            width_m=0.035,
            width_factor=0.7,
            second_width_m=0.029,
            second_width_factor=0.71,
        ),
        "lp_turbine": StageGroup(
            name="lp_turbine",
            count=4,
            inner_radius_m=0.21,
            inner_factor=1.05,
            outer_radius_m=0.216,
            outer_factor=1.05,
            width_m=0.011,
            width_factor=1.3,
            second_width_m=0.011,
            second_width_factor=1.3,
        ),
        "hp_compressor": StageGroup(
            name="hp_compressor",
            count=8,
            inner_radius_m=0.062,
            inner_factor=0.922,
            outer_radius_m=0.1,
            outer_factor=1.09,
            width_m=0.059,
            width_factor=0.72,
            second_width_m=0.05,
            second_width_factor=0.72,
        ),
        "hp_turbine": StageGroup(
            name="hp_turbine",
            count=2,
            inner_radius_m=0.052,
            inner_factor=1.08,
            outer_radius_m=0.19,
            outer_factor=0.99,
            width_m=0.0122,
            width_factor=1.4,
            second_width_m=0.012,
            second_width_factor=1.42,
        ),
    }
)
"""Table 7 of Müller and Hennings: the four stage groups of the engine (read-only).

The table has two rows of widths per group and does not say what the second one is. ASSUMPTION of
this program: the first row is the axial width of the stage's disk or drum ring, the second row the
axial width of the spacer behind it, between stage k and stage k + 1; the last stage has no spacer.
"""
