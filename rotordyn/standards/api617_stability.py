"""Cross-coupling and screening of the stability analysis of API 617.

API 617 8th edition, part 1, 4.8.5 and 4.8.6; 9th edition, 6.8.4; API TR 684-1, SP6.8.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

StageKind = Literal["radial", "axial"]

#: Logarithmic decrement that is asked for.
LEAST_DECREMENT = 0.1
#: Applied cross-coupling goes up to this many times the expected one.
MOST_TIMES = 10.0
#: Of the cross-coupling at which stability is lost to the expected one, below which a detailed
#: analysis is asked for.
LEAST_TIMES = 2.0
# Factors of stages, and of the torque P/Ω = 9.55 P/N, rounded as the standard prints it.
_FACTOR = {"radial": 3.0, "axial": 1.5}
_TORQUE = 9.55
# Region B: above a line over the mean density, kg/m³, and at the right of its end.
_LEVEL, _FALLS_FROM, _AT_ZERO, _SLOPE, _END = 2.5, 16.53, 2.69, 0.0115, 60.0


@dataclass(frozen=True, kw_only=True)
class Screening:
    """Say whether the simple analysis of stability suffices.

    `detailed`: whether the detailed one (level II) is asked for, and `why`. `region_b`: whether
    density and critical speed ratio lie in region B; None where they are not looked at.
    """

    detailed: bool
    why: str
    region_b: bool | None


def stage_cross_coupling_n_per_m(
    kind: StageKind,
    power_w: float,
    diameter_m: float,
    height_m: float,
    speed_rpm: float,
    density_ratio: float = 1.0,
) -> float:
    """Return the expected cross-coupled stiffness q_A of a stage, N/m.

    `diameter_m`: of a radial impeller, pitch diameter of axial blades; `height_m`: the smaller
    width of diffuser and impeller exit, height of the blades; `density_ratio`: discharge over
    suction, of a radial stage alone.
    """
    torque = _TORQUE * power_w / speed_rpm
    ratio = density_ratio if kind == "radial" else 1.0
    return _FACTOR[kind] * torque * ratio / (diameter_m * height_m)


def is_in_region_b(density_kg_per_m3: float, critical_speed_ratio: float) -> bool:
    """Tell whether a machine lies in region B of the screening figure, its border included.

    `density_kg_per_m3`: mean of suction and discharge; `critical_speed_ratio`: maximum continuous
    speed over the first undamped critical speed on rigid supports.
    """
    return density_kg_per_m3 >= _END or critical_speed_ratio >= region_border(density_kg_per_m3)


def region_border(density_kg_per_m3: float) -> float:
    """Return the critical speed ratio at the border of region B, for densities up to 60 kg/m³."""
    if density_kg_per_m3 <= _FALLS_FROM:
        return _LEVEL
    return _AT_ZERO - _SLOPE * min(density_kg_per_m3, _END)


def screened(
    kind: StageKind,
    times: float,
    decrement: float,
    density_kg_per_m3: float | None,
    critical_speed_ratio: float,
) -> Screening:
    """Judge the simple analysis (level I) of a machine.

    `kind`: "radial" if any stage is; `times`: Q_0/Q_A; `decrement`: δ_A at Q_A;
    `density_kg_per_m3`: mean density, needed between 2 and 10 times; unknown is as in region B.
    """
    if decrement < LEAST_DECREMENT:
        return Screening(
            detailed=True, why=f"log decrement {decrement:.3g} < {LEAST_DECREMENT:g}", region_b=None
        )
    if kind == "axial":
        return Screening(
            detailed=False, why=f"log decrement {decrement:.3g} is enough", region_b=None
        )
    if times < LEAST_TIMES:
        why = f"Q0/QA = {times:.3g} < {LEAST_TIMES:g}"
        return Screening(detailed=True, why=why, region_b=None)
    if times >= MOST_TIMES:
        why = f"Q0/QA = {times:.3g} ≥ {MOST_TIMES:g}"
        return Screening(detailed=False, why=why, region_b=None)
    if density_kg_per_m3 is None:
        why = f"Q0/QA = {times:.3g} < {MOST_TIMES:g}, and no density tells region A from B"
        return Screening(detailed=True, why=why, region_b=None)
    is_b = is_in_region_b(density_kg_per_m3, critical_speed_ratio)
    why = (
        f"Q0/QA = {times:.3g} is between {LEAST_TIMES:g} and {MOST_TIMES:g}, in region "
        f"{'B' if is_b else 'A'}"
    )
    return Screening(detailed=is_b, why=why, region_b=is_b)
