"""The results of a run as one record, which shows itself as text and in a notebook."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from solidwhirl import rotordyn as rd
from solidwhirl.analyses.base import Operating, Stability
from solidwhirl.bodies.reduction import BodyResult
from solidwhirl.bodies.refinement import Round
from solidwhirl.core.check_report import checks_line, failed
from solidwhirl.core.displays import counted, heading, indented, percent, table, titled
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.warnings import Doubt
from solidwhirl.cost.forecast import Forecast
from solidwhirl.estimates.results import Estimates
from solidwhirl.geometry import Body
from solidwhirl.model.plan_records import Plan
from solidwhirl.pipeline.alarms import Alarm, alarms_of, diagram_alarms, joint_alarms
from solidwhirl.pipeline.asymmetry import Asymmetry
from solidwhirl.pipeline.engine_stages import ExcitedCriticalSpeed
from solidwhirl.plausibility.supports import support_doubts
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.operating import operating_speeds

Critical = tuple[str, str, str, str]


@dataclass(frozen=True, kw_only=True, eq=False)
class Results:
    """All results of a scene, as arrays (units in the records that hold them)."""

    scene: Scene
    plan: Plan
    #: Bodies from profiles by name, as they were built from the scene
    geometry: Mapping[str, Body]
    #: Numbers of the scene that look as if they were in another unit
    doubts: tuple[Doubt, ...] = ()
    bodies: Mapping[str, BodyResult]
    rounds: tuple[Round, ...]
    forecast: Forecast
    elements: Mapping[str, rd.Superelement]
    system: rd.AssembledSystem
    #: Bearings used beyond the range of their law, or that feed energy
    bearing_notes: tuple[rd.BearingNote, ...]
    at_rest: rd.Modes
    campbell: rd.Campbell
    #: Within the scene's speed range, by excitation
    critical_speeds: tuple[ExcitedCriticalSpeed, ...]
    #: Errors of these; None where the scene has estimates = "off"
    estimates: Estimates | None
    analyses: Mapping[str, Outcome]
    timings_s: Mapping[str, float]
    #: Eigenproblems of the engine, and factorisations for a few of its modes, by stage
    dense_problems: Mapping[str, Mapping[str, int]]
    #: Finite element matrices of bodies assembled, factorisations and eigenproblems, by stage
    body_problems: Mapping[str, Mapping[str, int]]
    peak_memory_gib: float
    #: Unstable intervals of the whole range of speeds, and damping at the operating speeds
    stability: Stability
    #: What the frame of asymmetric bodies shows; then `system` is at rest. None without one
    asymmetry: Asymmetry | None = None
    #: What must hold for bodies, system and modes, and whether it does
    checks: tuple[rd.Invariant, ...] = ()
    #: "computed" or "kept" by stage; empty where nothing is kept
    stages: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return _results_text(self)

    @cached_property
    def operating(self) -> tuple[Operating, ...]:
        """Operating speeds of the shafts."""
        return operating_speeds(self.scene)

    @cached_property
    def largest_error(self) -> float:
        """Largest error estimate of what counts, nan without one."""
        return math.nan if self.estimates is None else self.estimates.largest

    @cached_property
    def alarms(self) -> tuple[Alarm, ...]:
        """Instability, what operates or was computed where the system is unstable, and the like."""
        documents = {name: {"kind": o.kind, **o.document} for name, o in self.analyses.items()}
        ratios = self.scene.speed_ratios()
        lifted = (joint_alarms(n, ratios[n], b.work.joints) for n, b in self.bodies.items())
        found = alarms_of(self.stability, self.operating, documents)
        met = diagram_alarms(self.campbell.notes, self.stability)
        return (*found, *met, *(alarm for own in lifted for alarm in own))

    @cached_property
    def support_doubts(self) -> tuple[Doubt, ...]:
        """Bodies that nothing holds laterally; those of a hammer test hang free on purpose."""
        if any(analysis.kind == "impact_test" for analysis in self.scene.analyses):
            return ()
        return support_doubts(self.system)

    def _repr_html_(self) -> str:
        return _results_html(self)


def _results_text(results: Results) -> str:
    """What a run found: accuracy, checks, critical speeds, analyses."""
    rows = _critical_rows(results)
    lines = [": ".join(line) for line in _summary(results)]
    lines.append("critical speeds: " + ("none" if not rows else str(len(rows))))
    lines += indented(counted([f"{s} rpm, {f} Hz, {w}, error {e}" for s, f, w, e in rows]))
    lines += [f"{name}: {o.headline or o.kind}" for name, o in results.analyses.items()]
    return "\n".join([_head(results), *indented(lines)])


def _results_html(results: Results) -> str:
    """The same for a notebook."""
    names = ("critical speed rpm", "Hz", "whirl", "error")
    about = [*_summary(results)]
    about += [(name, o.headline or o.kind) for name, o in results.analyses.items()]
    return heading(_head(results)) + table((), about) + table(names, _critical_rows(results))


def _head(results: Results) -> str:
    return f"Results of {results.scene.name!r}{titled(results.scene.title)}"


def _summary(results: Results) -> Iterator[tuple[str, str]]:
    bodies = ", ".join(counted([f"{n} ({e.level})" for n, e in results.elements.items()]))
    yield "bodies", f"{bodies}; {results.system.size} coordinates"
    if not math.isnan(results.largest_error):
        asked = percent(results.scene.model.accuracy)
        yield "largest error estimate", f"{percent(results.largest_error)}, asked {asked}"
    bad = [check.name for check in failed(results.checks)]
    names = f": {', '.join(counted(bad))}" if bad else ""
    yield "checks", f"{checks_line(results.checks)}{names}"
    rpm = results.campbell.speeds_rad_s * RPM_PER_RAD_S
    branches = len(results.campbell.frequency_hz)
    yield "Campbell diagram", f"{branches} branches, {rpm[0]:.6g} to {rpm[-1]:.6g} rpm"


def _critical_rows(results: Results) -> list[Critical]:
    count = len(results.critical_speeds)
    errors = ["not estimated"] * count
    if results.estimates is not None:
        found = results.estimates.critical_speeds.total[:count]
        errors = ["not estimated" if math.isnan(e) else percent(float(e)) for e in found]
    return [
        (f"{c.speed_rad_s * RPM_PER_RAD_S:.1f}", f"{c.frequency_hz:.2f}", c.whirl, error)
        for c, error in zip((f.critical for f in results.critical_speeds), errors, strict=True)
    ]
