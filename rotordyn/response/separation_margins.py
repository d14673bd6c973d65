"""Distance of critical speeds from operating speeds, in the manner of API 617.

A guide for design. The formulas are those of the standard; a check against them here is no claim
of compliance, which asks for much more (models, test stand, stability).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed
from solidwhirl.rotordyn.modes.whirl import Excitation
from solidwhirl.rotordyn.standards.api617_lateral import actual_margin, required_margin

# API 617 asks this distance of torsional natural frequencies from any excitation, here from the
# speed of the shaft.
_TORSIONAL = 0.1


@dataclass(frozen=True, kw_only=True)
class OperatingRange:
    """Give the speeds at which a shaft may run for long.

    `speed_low_rad_s`, `speed_high_rad_s`: lowest and highest speed of the shaft itself (not of the
    reference shaft), positive, rad/s; equal for one operating point.
    """

    shaft: str
    speed_low_rad_s: float
    speed_high_rad_s: float

    def __post_init__(self) -> None:
        low, high = self.speed_low_rad_s, self.speed_high_rad_s
        if not (0 < low <= high and np.isfinite(high)):
            raise AnalysisError(
                f"operating range of {self.shaft!r} is {low} to {high} rad/s; allowed is "
                "0 < low <= high, finite"
            )


@dataclass(frozen=True, kw_only=True)
class Resonance:
    """Hold a resonance of a shaft's own excitation.

    `speed_rad_s`: speed of the shaft itself, rad/s. `amplification_factor`: AF: height of the
    resonance over its width; inf without damping, negative if unstable. `whirl`: direction of the
    orbits, or the kind of motion; `kind`: that; both empty if it comes from a response. `exciters`,
    `why`: what of the shaft can excite it, "unbalance" or "torque", and why an unbalance can or can
    not; what nothing excites is not judged.
    """

    speed_rad_s: float
    amplification_factor: float
    whirl: str = ""
    kind: str = ""
    exciters: tuple[str, ...] = ("unbalance",)
    why: str = ""

    @property
    def excited(self) -> bool:
        """Whether an unbalance of the shaft excites it."""
        return "unbalance" in self.exciters


@dataclass(frozen=True, kw_only=True)
class SeparationMargin:
    """Hold the distance of one resonance from one operating range.

    `operating_speed_rad_s`: the end of the operating range N_op it is compared with: the nearer
    one; `position`: "below" or "above" the operating range, or "inside" it. `margin`: (N_c − N_op)
    / N_op, negative below; 0 inside. `required_api_617`: |margin| asked for by the formulas of API
    617, as a fraction; inf for an unstable mode and for a resonance inside that is not critically
    damped; 0.1 of what a torque excites, as the standard asks of torsion. `verdict_api_617`,
    `verdict_15_percent`, `verdict_20_percent`: "ok", "inside margin" or "unstable", by those
    formulas and by a fixed margin.
    """

    shaft: str
    resonance: Resonance
    operating_speed_rad_s: float
    position: str
    margin: float
    required_api_617: float
    verdict_api_617: str
    verdict_15_percent: str
    verdict_20_percent: str


def resonances_of_modes(
    critical_speeds: Sequence[CriticalSpeed],
    excitations: Sequence[Excitation] | None = None,
) -> tuple[Resonance, ...]:
    """Turn critical speeds into resonances of the shaft that excites them.

    `critical_speeds`: found with the speed ratio of that shaft as the excitation ratio.
    `excitations`: what of the shaft excites each, from `whirl.excitation_by`; None: unbalance
    excites all. The result is at the shaft's own speed |α|Ω, with AF from the logarithmic
    decrement.
    """
    by_default = [Excitation(("unbalance",), (), "")] * len(critical_speeds)
    return tuple(
        Resonance(
            speed_rad_s=2.0 * np.pi * critical.frequency_hz,
            amplification_factor=critical.amplification_factor,
            whirl=critical.whirl,
            kind=critical.kind,
            exciters=own.exciters,
            why=own.why,
        )
        for critical, own in zip(critical_speeds, excitations or by_default, strict=True)
    )


def separation_margins(
    operating: OperatingRange, resonances: Sequence[Resonance]
) -> tuple[SeparationMargin, ...]:
    """Compare the resonances of one shaft with its operating range.

    `operating`: speeds at which the shaft runs. Call once for each shaft. `resonances`: of the
    excitation by that shaft, at its own speed. The result is by rising speed of the resonance.

    By `standards.api617_lateral.required_margin`, and by fixed margins of 15 and 20 %, which do not
    look at the damping.
    """
    ordered = sorted(resonances, key=lambda resonance: resonance.speed_rad_s)
    return tuple(_margin(operating, resonance) for resonance in ordered)


def _margin(operating: OperatingRange, resonance: Resonance) -> SeparationMargin:
    position, reference, margin = actual_margin(
        resonance.speed_rad_s, operating.speed_low_rad_s, operating.speed_high_rad_s
    )
    factor = resonance.amplification_factor
    required = _asked(resonance, position, required_margin(factor, position))
    return SeparationMargin(
        shaft=operating.shaft,
        resonance=resonance,
        operating_speed_rad_s=reference,
        position=position,
        margin=margin,
        required_api_617=required,
        verdict_api_617=_verdict(factor, margin, required),
        verdict_15_percent=_verdict(factor, margin, _asked(resonance, position, 0.15)),
        verdict_20_percent=_verdict(factor, margin, _asked(resonance, position, 0.20)),
    )


def _asked(resonance: Resonance, position: str, of_unbalance: float) -> float:
    """Return the |margin| asked for: that for unbalance, of torsion a tenth, the larger of both."""
    if "torque" not in resonance.exciters:
        return of_unbalance
    of_torque = np.inf if position == "inside" else _TORSIONAL
    return max(of_torque, of_unbalance) if resonance.excited else of_torque


@dataclass(frozen=True, kw_only=True)
class MarginMethod:
    """Say by what margins are judged.

    `kind`: "api617": the margin that the amplification factor asks for; "percent": a fixed one.
    `percent`: that one.
    """

    kind: Literal["api617", "percent"] = "api617"
    percent: float = 15.0

    @property
    def text(self) -> str:
        """What a headline says."""
        return "API 617" if self.kind == "api617" else f"{self.percent:g} %"

    def required(self, margin: SeparationMargin) -> float:
        """Return the |margin| that is asked for, as a fraction; inf if none is enough."""
        if self.kind == "api617" or margin.resonance.amplification_factor < 0:
            return margin.required_api_617
        fixed = np.inf if margin.position == "inside" else 0.01 * self.percent
        return _asked(margin.resonance, margin.position, fixed)


@dataclass(frozen=True, kw_only=True)
class MarginVerdict:
    """Hold what margins come to by one method.

    `passed`: whether every resonance that is excited keeps its margin; `missed`: those that do
    not. `worst`: the excited resonance with the least margin beyond the one asked for; None
    without any. `why`: one sentence.
    """

    passed: bool
    missed: tuple[SeparationMargin, ...]
    worst: SeparationMargin | None
    why: str


def margin_verdict(margins: Sequence[SeparationMargin], method: MarginMethod) -> MarginVerdict:
    """Judge margins by a method.

    `margins`: of any number of shafts; what neither unbalance nor a torque excites is not judged.
    """
    judged = [m for m in margins if m.resonance.exciters]
    missed = tuple(m for m in judged if abs(m.margin) < method.required(m))
    if not judged:
        return MarginVerdict(
            passed=True,
            missed=(),
            worst=None,
            why="no critical speed that unbalance or a torque excites",
        )
    worst = min(judged, key=lambda m: (abs(m.margin) - method.required(m), abs(m.margin)))
    return MarginVerdict(
        passed=not missed, missed=missed, worst=worst, why=_why(worst, method, len(judged))
    )


def _why(worst: SeparationMargin, method: MarginMethod, count: int) -> str:
    factor = worst.resonance.amplification_factor
    required = method.required(worst)
    whirl = f" {worst.resonance.whirl}" if worst.resonance.whirl else ""
    where = f"{100 * abs(worst.margin):.1f} % {worst.position} the operating speeds of"
    if worst.position == "inside":
        where = "inside the operating speeds of"
    asked = f"{100 * required:.1f} % asked" if np.isfinite(required) else "no margin is enough"
    height = "unstable" if factor < 0 else f"amplification factor {factor:.3g}"
    return (
        f"worst of {count}:{whirl} {worst.resonance.speed_rad_s * RPM_PER_RAD_S:.0f} rpm "
        f"({height}) is {where} {worst.shaft}, {asked}"
    )


def _verdict(amplification: float, margin: float, required: float) -> str:
    if amplification < 0:
        return "unstable"
    return "ok" if abs(margin) >= required else "inside margin"
