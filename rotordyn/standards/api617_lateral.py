"""Unbalance, amplification, separation margins and clearances of the lateral analysis of API 617.

API 617 (Axial and Centrifugal Compressors), 8th edition 2014, part 1, 4.8.2; 9th edition 2022,
6.8.2; API TR 684-1 (2019), SP6.8.2. "legacy" is the 6th edition of API 617.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.errors import AnalysisError

Edition = Literal["8th", "9th", "legacy"]
Position = Literal["below", "above", "inside"]

#: Below this amplification factor a response is critically damped: no critical speed.
CRITICALLY_DAMPED = 2.5
#: Largest factor on an analysis amplitude on its way to the limit of vibration.
LARGEST_SCALE = 6.0
#: Part of a diametral running clearance that a scaled amplitude, peak to peak, may take.
CLEARANCE_PART = 0.75
# Residual unbalance: 6350 W/N g mm, and W/3.937 from this speed on.
_UNBALANCE, _FAST_RPM, _FAST_UNBALANCE = 6350.0, 25_000.0, 1.0 / 3.937
_KG_M_PER_G_MM = 1e-6
# Limit of vibration, peak to peak, up to a speed; then it falls with the root of the speed.
_VIBRATION_M, _VIBRATION_RPM = 25.4e-6, 12_000.0
# Margins asked for at most, and by the 6th edition up to an amplification factor.
_MOST_BELOW, _MORE_ABOVE = 0.16, 0.10
_LEGACY_FACTOR, _LEGACY_BELOW = 3.55, 0.05


class ActualMargin(NamedTuple):
    """Distance of a critical speed from operating speeds.

    `position`: of the critical speed; `reference`: the end of the range it is compared with;
    `margin`: (N_c − N) / N of that end, negative below, 0 inside.
    """

    position: Position
    reference: float
    margin: float


def residual_unbalance_kg_m(load_kg: float, speed_max_rpm: float) -> float:
    """Return the largest residual unbalance U_r of a load, kg m.

    `load_kg`: static load of a journal, or of all, as a mass; `speed_max_rpm`: maximum continuous
    speed. 6350 W/N g mm, W/3.937 from 25 000 rpm on.
    """
    fast = speed_max_rpm >= _FAST_RPM
    return _KG_M_PER_G_MM * load_kg * (_FAST_UNBALANCE if fast else _UNBALANCE / speed_max_rpm)


def vibration_limit_m(speed_max_rpm: float) -> float:
    """Return the limit of vibration A_vl, peak to peak, m: 25.4 µm √(12000/N), 25.4 µm at most."""
    return _VIBRATION_M * min(1.0, float(np.sqrt(_VIBRATION_RPM / speed_max_rpm)))


def required_margin(
    amplification_factor: float, position: Position, edition: Edition = "9th"
) -> float:
    """Return the separation margin that is asked for, as a fraction of the operating speed.

    `amplification_factor`: AF; negative for an unstable mode, inf without damping. Returns inf if
    no margin is enough. Raises AnalysisError if the position is none.

    None below AF = 2.5. Else 17 (1 − 1/(AF − 1.5)) % below, 16 % at most, and 10 % more above. The
    6th edition asks for 5 % up to AF = 3.55, then 16 − 6/(AF − 3) %, 16 % at most, and 10 % more
    above.
    """
    if position not in ("below", "above", "inside"):
        raise AnalysisError(f"position is {position!r}; use 'below', 'above' or 'inside'")
    if amplification_factor < 0:
        return float("inf")
    if amplification_factor < CRITICALLY_DAMPED:
        return 0.0
    if position == "inside":
        return float("inf")
    damped = 0.17 * (1.0 - 1.0 / (amplification_factor - 1.5))
    if edition == "legacy":
        damped = _LEGACY_BELOW
        if amplification_factor > _LEGACY_FACTOR:
            damped = _MOST_BELOW - 0.06 / (amplification_factor - 3.0)
    below = min(_MOST_BELOW, damped)
    return below if position == "below" else _MORE_ABOVE + below


def largest_required_margin(position: Position) -> float:
    """Return the margin that is enough whatever the amplification, as a fraction; inf inside."""
    return required_margin(float("inf"), position)


def actual_margin(speed: float, low: float, high: float) -> ActualMargin:
    """Return the margin of a critical speed from operating speeds, all in one unit.

    `low`, `high`: ends of the operating speeds, such as minimum allowable and maximum continuous.
    """
    if speed < low:
        return ActualMargin("below", low, (speed - low) / low)
    if speed > high:
        return ActualMargin("above", high, (speed - high) / high)
    return ActualMargin("inside", min((low, high), key=lambda end: abs(end - speed)), 0.0)


def scale_factor(limit_m: float, largest_m: float) -> float:
    """Return S_cc, by which analysis amplitudes are scaled for the check of clearances.

    `limit_m`: of `vibration_limit_m`; `largest_m`: largest amplitude at the probes within the
    operating speeds, peak to peak. 6 at most.
    """
    return min(limit_m / largest_m, LARGEST_SCALE) if largest_m > 0.0 else LARGEST_SCALE
