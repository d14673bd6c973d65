"""The engine of a run: modes, diagram, critical speeds, their errors, and the analyses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

from solidwhirl.analyses import base as analyses
from solidwhirl.analyses.base import Stability
from solidwhirl.analyses.kinds.level_comparison import LevelResults
from solidwhirl.analyses.stability_summary import intervals_up_to, stability_of
from solidwhirl.beams.scene_bodies import BeamBodies
from solidwhirl.bodies.couplings import places_looked_at
from solidwhirl.bodies.reduction import BodyResult, request_of
from solidwhirl.core.outcome import Outcome
from solidwhirl.core.stages import Stage, StageName
from solidwhirl.estimates.comparators import (
    Comparison,
    OtherBodies,
    beam_comparison,
    coupling_comparison,
    step_comparisons,
)
from solidwhirl.estimates.margins import with_margin_estimates
from solidwhirl.estimates.peaks import with_peak_estimates
from solidwhirl.estimates.results import BeamVariants, Estimates, estimate_errors
from solidwhirl.geometry import Body
from solidwhirl.model.balance_grades import with_moments
from solidwhirl.model.drawn_masses import masses_beyond_kg
from solidwhirl.model.system_parts import engine_of, rotating_engine_of, with_speed_laws
from solidwhirl.pipeline.asymmetry import (
    Asymmetry,
    asymmetry_of,
    critical_records,
    damping_in_frame,
    diagram_in_fixed_axes,
    frame_estimates,
    stability_in_ranges,
)
from solidwhirl.pipeline.body_stages import Job, bodies_asked
from solidwhirl.pipeline.cached_stages import engine_part
from solidwhirl.pipeline.cyclic_bodies import cyclic_source
from solidwhirl.rotordyn import (
    AnalysisError,
    AssembledSystem,
    AssemblyError,
    Campbell,
    CriticalSpeed,
    Modes,
    Superelement,
    campbell,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.asymmetric import RotatingSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.modes.whirl import Excitation, excitation_by
from solidwhirl.rotordyn.stability.intervals import StabilityChart, stability_chart
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import places_of_joints
from solidwhirl.scene_checks.operating import operating_speeds, running_speeds
from solidwhirl.scene_checks.speeds_asked import range_top_rpm

#: Makes the results of an engine, and of the one with its bodies on another level.
Levels = Callable[[str], tuple[LevelResults, LevelResults]]


@dataclass(frozen=True, kw_only=True, eq=False)
class ExcitedCriticalSpeed:
    """A critical speed of the reference shaft and what excites it."""

    #: Shafts that turn as often as it vibrates
    shafts: tuple[str, ...]
    #: What of these shafts excites it
    excitation: Excitation
    critical: CriticalSpeed

    @property
    def excited_by(self) -> tuple[str, ...]:
        """Shafts whose unbalance excites it."""
        return self.excitation.bodies


@dataclass(frozen=True, kw_only=True, eq=False)
class Engine:
    """The assembled engine of a run."""

    job: Job
    reduced: Mapping[str, BodyResult]
    elements: Mapping[str, Superelement]
    beams: BeamBodies
    #: At rest where bodies are asymmetric
    system: AssembledSystem
    #: In the frame of these; None without one
    rotating: RotatingSystem | None
    digest: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagram:
    """What every run computes of its engine."""

    at_rest: Modes
    campbell: Campbell
    #: Within the scene's speed range, by excitation
    critical_speeds: tuple[ExcitedCriticalSpeed, ...]
    #: What the frame of asymmetric bodies shows; None without one
    asymmetry: Asymmetry | None = None


def assembled_engine(
    job: Job,
    reduced: Mapping[str, BodyResult],
    elements: Mapping[str, Superelement],
    beams: BeamBodies,
) -> Engine:
    """Assemble the engine of a run from its elements."""
    job.progress(Stage(name=StageName.ASSEMBLY))
    with job.clock.stage("assembly"):
        system = job.engine_of(elements)
        rotating = rotating_engine_of(job.scene, job.plan, elements)
        asked = (engine_part(job.scene), job.plan.speeds_rad_s)
        digest = job.stage_cache.digest((asked, elements))
    return Engine(
        job=job,
        reduced=reduced,
        elements=elements,
        beams=beams,
        system=system,
        rotating=rotating,
        digest=digest,
    )


def diagram_of(engine: Engine) -> Diagram:
    """Compute modes at rest, Campbell diagram and critical speeds of an engine."""
    job, system = engine.job, engine.system
    scene, speeds, stage_cache = job.scene, job.plan.speeds_rad_s, job.stage_cache
    if engine.rotating is not None:
        return _rotating_diagram(engine, engine.rotating)
    job.progress(Stage(name=StageName.CAMPBELL, detail=f" at {len(speeds)} speeds"))
    with job.clock.stage("campbell"):
        at_rest, diagram = stage_cache.stage(
            "Campbell diagram",
            stage_cache.key("modes and Campbell diagram", engine.digest),
            lambda: (modes_at_speed(system, 0.0), _campbell(engine)),
        )
    job.progress(Stage(name=StageName.CRITICAL_SPEEDS))
    with job.clock.stage("critical_speeds"):
        found = stage_cache.stage(
            "critical speeds",
            stage_cache.key("critical speeds", engine.digest),
            lambda: _critical_speeds(scene, system, float(speeds.max())),
        )
    return Diagram(at_rest=at_rest, campbell=diagram, critical_speeds=_excited(system, found))


def campbell_of(engine: Engine) -> Campbell:
    """Compute the Campbell diagram alone."""
    return _campbell(engine) if engine.rotating is None else diagram_of(engine).campbell


def critical_speeds_of(engine: Engine) -> tuple[ExcitedCriticalSpeed, ...]:
    """Compute the critical speeds alone."""
    if engine.rotating is not None:
        return diagram_of(engine).critical_speeds
    top = float(engine.job.plan.speeds_rad_s.max())
    found = _critical_speeds(engine.job.scene, engine.system, top)
    return _excited(engine.system, found)


def _campbell(engine: Engine) -> Campbell:
    job = engine.job
    return campbell(engine.system, job.plan.speeds_rad_s, **_branches(job.scene))


def _excited(
    system: AssembledSystem, found: tuple[tuple[tuple[str, ...], CriticalSpeed], ...]
) -> tuple[ExcitedCriticalSpeed, ...]:
    return tuple(
        ExcitedCriticalSpeed(
            shafts=names, excitation=excitation_by(system, c.shape, names), critical=c
        )
        for names, c in found
    )


def _rotating_diagram(engine: Engine, rotating: RotatingSystem) -> Diagram:
    """The same of an engine with asymmetric bodies, from the frame that turns with them."""
    job = engine.job
    speeds, branches = job.plan.speeds_rad_s, job.scene.campbell.branches
    top = range_top_rpm(job.scene) * RAD_S_PER_RPM
    job.progress(Stage(name=StageName.CAMPBELL, detail=f" at {len(speeds)} speeds, in two frames"))
    with job.clock.stage("campbell"):
        found: Asymmetry = job.stage_cache.stage(
            "Campbell diagram",
            job.stage_cache.key("asymmetry", engine.digest, top),
            lambda: asymmetry_of(rotating, speeds, top, branches),
        )
    return Diagram(
        at_rest=modes_at_speed(engine.system, 0.0),
        campbell=diagram_in_fixed_axes(found),
        critical_speeds=tuple(
            ExcitedCriticalSpeed(
                shafts=found.excited_by,
                excitation=Excitation(
                    ("unbalance",), found.excited_by, "an asymmetric body whirls both ways at once"
                ),
                critical=c,
            )
            for c in critical_records(found)
        ),
        asymmetry=found,
    )


def stability_of_engine(engine: Engine, asymmetry: Asymmetry | None) -> Stability:
    """Look for instability over the range of speeds of a scene, and at its operating speeds."""
    return _stability_up_to(engine, asymmetry, range_top_rpm(engine.job.scene))


def _stability_up_to(engine: Engine, asymmetry: Asymmetry | None, top: float) -> Stability:
    """The same up to a speed of the reference shaft, rpm."""
    scene, stage_cache = engine.job.scene, engine.job.stage_cache
    operating = analyses.given_speeds(operating_speeds(scene))
    if asymmetry is not None and engine.rotating is not None:
        branches = scene.campbell.branches
        return stability_in_ranges(asymmetry, engine.rotating, top, operating, branches)
    intervals = stage_cache.stage(
        "stability",
        stage_cache.key("unstable intervals", engine.digest, top),
        lambda: intervals_up_to(engine.system, top),
    )
    return stability_of(engine.system, top, operating, tuple(intervals))


def _damping(engine: Engine, speeds_rad_s: FloatArray, highest_hz: float) -> StabilityChart:
    """Damping over the speed of the reference shaft, see `analyses.base.Engine`."""
    if engine.rotating is None:
        return stability_chart(engine.system, speeds_rad_s, highest_hz)
    branches = engine.job.scene.campbell.branches
    return damping_in_frame(engine.rotating, speeds_rad_s, highest_hz, branches)


def estimates_of(engine: Engine, diagram: Diagram) -> Estimates | None:
    """Estimate the errors of a diagram; None where the scene has its estimates off."""
    job = engine.job
    rule = job.scene.criteria.rule
    if job.scene.model.estimates == "off":
        return None
    job.progress(Stage(name=StageName.ERROR_ESTIMATES))
    if diagram.asymmetry is not None:
        return frame_estimates(
            diagram.asymmetry, engine.system, engine.elements, diagram.at_rest, rule
        )
    with job.clock.stage("error_estimate"):
        comparisons = _comparisons(engine)
        beams = (engine.beams.variants, engine.beams.finer)
        key = job.stage_cache.key("error estimates", engine.digest, _seen(comparisons), beams)
        rest, branches, speeds, free = job.stage_cache.stage(
            "error estimates", key, lambda: _estimated(engine, diagram, comparisons)
        )
    return Estimates(
        at_rest=rest,
        campbell=branches,
        critical_speeds=speeds,
        free_frequencies=free,
        comparisons=comparisons,
        critical=tuple(c.critical for c in diagram.critical_speeds),
        rule=rule,
    )


def analyses_of(
    engine: Engine, diagram: Diagram, estimates: Estimates | None, levels: Levels
) -> dict[str, Outcome]:
    """Run the analyses of the scene.

    `estimates`: errors of the diagram, or None. `levels`: see `analyses.base.Engine`. Raises
    AnalysisError: one has no answer; the message names it.
    """
    job = engine.job
    scene = with_moments(job.scene, {n: e.mass_kg for n, e in engine.elements.items()})
    # peaks of asymmetric bodies have no estimate
    estimated = estimates is not None and engine.rotating is None
    pairs = estimates.comparisons if estimates and estimated else None
    seen = job.stage_cache.digest(None if pairs is None else _seen(pairs))
    seen_by_analyses = analyses.Engine(
        system=engine.system,
        rotating=engine.rotating,
        diagram=diagram.campbell,
        title=scene.title or scene.name,
        speed_ratios=scene.speed_ratios(),
        operating=operating_speeds(scene),
        running=partial(running_speeds, scene),
        damping_rule=scene.criteria.rule,
        campbell_max_hz=scene.campbell.frequency_max_hz,
        analyses={a.label: a for a in scene.analyses},
        recoveries=_recoveries_of(job, engine.reduced),
        with_laws=partial(_with_laws, engine),
        masses_beyond=partial(masses_beyond_kg, scene),
        cyclic=partial(cyclic_source, job, engine.reduced),
        damping=partial(_damping, engine),
        stability=partial(_stability_up_to, engine, diagram.asymmetry),
        levels=levels,
    )
    outcomes: dict[str, Outcome] = {}
    for k, spec in enumerate(scene.analyses):

        def compute(spec: analyses.Analysis = spec) -> Outcome:
            outcome = with_margin_estimates(spec.run(seen_by_analyses), estimates)
            if pairs is None:
                return outcome
            return with_peak_estimates(outcome, spec, engine.system, pairs)

        job.progress(Stage(name=StageName.ANALYSIS, body=spec.label, detail=f" ({spec.kind})"))
        named = [a for a in scene.analyses if a.label in getattr(spec, "refers_to", ())]
        operating = [tuple(o) for o in seen_by_analyses.operating if spec.sees_operating]
        key = job.stage_cache.key("analysis", engine.digest, spec, seen, named, operating)
        picture = partial(job.stage_cache.picture_of, key, scene.title or scene.name)
        with job.clock.stage(f"analysis {spec.label}"):
            try:
                outcome = job.stage_cache.analysis(spec.label, key, compute)
            except AnalysisError as error:
                raise AnalysisError(f"analyses[{k}] ({spec.label}): {error}") from error
        outcomes[spec.label] = spec.told(outcome, seen_by_analyses, picture)
    return outcomes


def _with_laws(engine: Engine, laws: Mapping[str, str]) -> AssembledSystem:
    """The same engine with other speed laws at some bearings."""
    scene = with_speed_laws(engine.job.scene, laws)
    try:
        return engine_of(scene, engine.job.plan, engine.elements)
    except AssemblyError as error:
        raise AnalysisError(f"with the laws {dict(laws)}: {error}") from error


def _recoveries_of(job: Job, reduced: Mapping[str, BodyResult]) -> Callable[[str], Any]:
    """A function that makes the recovery of a body by its name, once for each."""

    @cache
    def recovery(name: str) -> Any:
        from solidwhirl.reduction.recovery.fields import body_fields
        from solidwhirl.reduction.recovery.stresses import StressRecovery

        found = reduced[name]
        request = request_of(job.scene, job.plan, found.body, found.discretisation)
        why = " again, for its fields"
        job.progress(Stage(name=StageName.REDUCTION, body=name, detail=why))
        return StressRecovery(body_fields(found.body, found.mesh, request, found.element))

    return recovery


def _estimated(
    engine: Engine, diagram: Diagram, comparisons: tuple[Comparison, ...]
) -> tuple[Any, ...]:
    found = estimate_errors(
        engine.system,
        engine.elements,
        diagram.at_rest,
        diagram.campbell,
        [c.critical for c in diagram.critical_speeds],
        comparisons,
        _beam_variants(engine),
    )
    return found.at_rest, found.campbell, found.critical_speeds, dict(found.free_frequencies)


def _beam_variants(engine: Engine) -> BeamVariants | None:
    """The engine with the other choices of beam theory."""
    job, variants = engine.job, engine.beams.variants
    if not variants:
        return None
    made = (engine_of(job.scene, job.plan, {**engine.elements, **own}) for own in variants)
    return BeamVariants(systems=tuple(made), elements=variants)


def _comparisons(engine: Engine) -> tuple[Comparison, ...]:
    """Other models whose results tell parts of the error."""
    job = engine.job
    found = beam_comparison(engine.beams.finer)
    if engine.reduced:  # beams are compared in milliseconds
        bodies = bodies_asked(job, {n: r.body for n, r in engine.reduced.items()})
        chosen = [r.discretisation for r in engine.reduced.values()]
        places = [sorted(p(job.scene)) for p in (places_of_joints, places_looked_at)]
        key = job.stage_cache.key("comparisons", bodies, chosen, places, job.scene.campbell)
        found += job.stage_cache.stage("comparisons", key, partial(_compared, engine))
    return tuple(_assembled(engine, other) for other in found)


def _compared(engine: Engine) -> tuple[OtherBodies, ...]:
    scene = engine.job.scene
    found = step_comparisons(scene, engine.job.plan, engine.reduced)
    if scene.model.compare_coupling == "on":
        drawn = {n: r.body for n, r in engine.reduced.items() if isinstance(r.body, Body)}
        found += coupling_comparison(scene, drawn)
    return found


def _assembled(engine: Engine, other: OtherBodies) -> Comparison:
    """Two models of the engine with other bodies in it."""

    def made(own: Mapping[str, Superelement]) -> AssembledSystem:
        return engine_of(engine.job.scene, engine.job.plan, {**engine.elements, **own})

    first = other.first
    return Comparison(
        part=other.part,
        first=None if first is None else made(first),
        second=made(other.second),
        first_elements={n: engine.elements[n] for n in other.second} if first is None else first,
        second_elements=other.second,
        safety=other.safety,
    )


def _seen(pairs: tuple[Comparison, ...]) -> list[Any]:
    """What results depend on in comparisons."""
    return [(p.part, p.first is None, p.first_elements, p.second_elements, p.safety) for p in pairs]


def _branches(scene: Scene) -> dict[str, Any]:
    if scene.campbell.frequency_max_hz is not None:
        return {"frequency_max_hz": scene.campbell.frequency_max_hz}
    return {"branch_count": scene.campbell.branches}


def _critical_speeds(
    scene: Scene, system: AssembledSystem, top: float
) -> tuple[tuple[tuple[str, ...], CriticalSpeed], ...]:
    """Critical speeds up to the top speed, for the unbalance of every body that turns."""
    if top == 0.0:
        return ()
    exciters: dict[float, list[str]] = {}
    for name, ratio in scene.speed_ratios().items():
        if ratio != 0.0:
            exciters.setdefault(abs(ratio), []).append(name)
    found = [
        (tuple(names), c)
        for ratio, names in exciters.items()
        for c in critical_speeds(system, excitation_ratio=ratio, speed_max_rad_s=top)
    ]
    return tuple(sorted(found, key=lambda f: f[1].speed_rad_s))
