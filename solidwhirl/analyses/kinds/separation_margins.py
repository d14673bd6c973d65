"""Distance of critical speeds from operating speeds, and whether it suffices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Field,
    model_validator,
)

from solidwhirl.analyses.base import (
    Analysis,
    Engine,
    OperatingSpec,
)
from solidwhirl.core.fields import (
    MOST,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn import CriticalSpeed, critical_speeds
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.whirl import moves_laterally, unbalance_excitation
from solidwhirl.rotordyn.plots.margins import draw_separation_margins
from solidwhirl.rotordyn.response.separation_margins import (
    MarginMethod,
    OperatingRange,
    SeparationMargin,
    margin_verdict,
    resonances_of_modes,
    separation_margins,
)


class SeparationMarginsSpec(Analysis):
    """Distance of critical speeds from operating speeds, sought up to a multiple of these."""

    kind: Literal["separation_margins"]
    operating: Annotated[tuple[OperatingSpec, ...], Field(max_length=MOST)] = ()
    search_factor: Annotated[float, Field(ge=1, le=10, strict=True)] = 1.3
    method: Literal["api617", "percent"] | None = None
    percent: Annotated[float, Field(gt=0, lt=100, strict=True)] = 15.0

    @model_validator(mode="after")
    def _one_method(self) -> SeparationMarginsSpec:
        if self.method != "percent" and "percent" in self.model_fields_set:
            found = "without a method" if self.method is None else f"with method {self.method!r}"
            raise ValueError(f'percent is given {found}; use method "percent"')
        return self

    def operating_named(self) -> Iterator[OperatingSpec]:
        """Yield its own operating speeds, which stand in for those of the scene."""
        yield from self.operating

    def run(self, engine: Engine) -> Outcome:
        """Margins of every shaft's critical speeds from its operating range, and the verdict."""
        found: list[SeparationMargin] = []
        damped: list[dict[str, Any]] = []
        ranges = self.operating or engine.operating_entries
        for entry in ranges:
            critical = _critical_speeds_of(entry, self.search_factor, engine)
            counts = [c.counts(engine.damping_rule) for c in critical]
            damped += [
                _critically_damped(entry.shaft, c)
                for c, own in zip(critical, counts, strict=True)
                if not own
            ]
            counted = [c for c, own in zip(critical, counts, strict=True) if own]
            shafts = _alike(engine.speed_ratios, entry.shaft)
            excitations = [unbalance_excitation(engine.system, c.shape, shafts) for c in counted]
            operating = OperatingRange(
                shaft=entry.shaft,
                speed_low_rad_s=entry.from_rpm * RAD_S_PER_RPM,
                speed_high_rad_s=entry.to_rpm * RAD_S_PER_RPM,
            )
            found += separation_margins(operating, resonances_of_modes(counted, excitations))
        method = MarginMethod(kind=self.method or "api617", percent=self.percent)
        verdict = margin_verdict(found, method)
        return Outcome(
            kind=self.kind,
            document={
                "note": "in the manner of API 617; no statement of compliance",
                "operating": [entry.model_dump() for entry in ranges],
                "verdict": {
                    "method": method.kind,
                    "chosen": self.method is not None,
                    "percent": self.percent if self.method == "percent" else None,
                    "passed": verdict.passed,
                    "why": verdict.why,
                    "worst": _margin_document(verdict.worst, method) if verdict.worst else None,
                },
                "margins": [_margin_document(m, method) for m in found],
                "critically_damped": damped,
            },
            files={
                f"{self.label}.png": lambda path: draw_separation_margins(found, path, engine.title)
            }
            if found
            else {},
            headline=f"{'pass' if verdict.passed else 'FAIL'} by {method.text}: {verdict.why}",
        )


def _critical_speeds_of(
    entry: OperatingSpec, search_factor: float, engine: Engine
) -> list[CriticalSpeed]:
    """Critical speeds of lateral motion that a shaft may excite up to a multiple of its speed."""
    ratio = abs(engine.speed_ratio(entry.shaft))
    limit = search_factor * entry.to_rpm * RAD_S_PER_RPM / ratio
    found = critical_speeds(engine.system, excitation_ratio=ratio, speed_max_rad_s=limit)
    return [c for c in found if moves_laterally(engine.system, c.shape)]


def _alike(ratios: Mapping[str, float], shaft: str) -> list[str]:
    """Bodies that turn as a shaft does: their unbalance is one with its own."""
    return [name for name, ratio in ratios.items() if ratio == ratios[shaft]]


def _critically_damped(shaft: str, critical: CriticalSpeed) -> dict[str, Any]:
    return {
        "shaft": shaft,
        "critical_speed_rpm": 2.0 * np.pi * critical.frequency_hz * RPM_PER_RAD_S,
        "whirl": critical.whirl,
        "amplification_factor": critical.amplification_factor,
    }


def _margin_document(margin: SeparationMargin, method: MarginMethod) -> dict[str, Any]:
    resonance = margin.resonance
    return {
        "shaft": margin.shaft,
        "critical_speed_rpm": resonance.speed_rad_s * RPM_PER_RAD_S,
        "whirl": resonance.whirl,
        "amplification_factor": resonance.amplification_factor,
        "excited": resonance.excited,
        "excited_why": resonance.why,
        "operating_speed_rpm": margin.operating_speed_rad_s * RPM_PER_RAD_S,
        "position": margin.position,
        "margin": margin.margin,
        "required": method.required(margin),
        "required_api_617": margin.required_api_617,
        "verdict_api_617": margin.verdict_api_617,
        "verdict_15_percent": margin.verdict_15_percent,
        "verdict_20_percent": margin.verdict_20_percent,
    }
