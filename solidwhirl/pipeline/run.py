"""The pipeline from a scene to its results: geometry, mesh, reduction, assembly, analyses."""

from __future__ import annotations

import resource
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from solidwhirl.analyses.kinds.level_comparison import LevelResults
from solidwhirl.beams.scene_bodies import BeamBodies, beam_bodies
from solidwhirl.bodies.reduction import BodyResult, Clock
from solidwhirl.bodies.refinement import Round
from solidwhirl.cache.files import StageStore
from solidwhirl.core.check_report import failed, failure_lines
from solidwhirl.core.stages import Progress, silent
from solidwhirl.core.warnings import Doubt
from solidwhirl.cost.forecast import Forecast, forecast, refuse_too_large
from solidwhirl.estimates.results import Estimates
from solidwhirl.geometry import Body
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.model.at_level import alone_at_level
from solidwhirl.model.bearing_validity import validity_notes
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.model.mesh_bodies import build_mesh_bodies
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.system_parts import simple_elements
from solidwhirl.pipeline import engine_stages as stages
from solidwhirl.pipeline.body_stages import Job, elements_of, reduced_bodies
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.pipeline.checks import analysis_result_checks, run_checks
from solidwhirl.pipeline.engine_stages import ExcitedCriticalSpeed
from solidwhirl.pipeline.level import key_of_beams, level_of
from solidwhirl.pipeline.results import Results
from solidwhirl.plausibility.units import implausible, refuse_bursting
from solidwhirl.rotordyn import Superelement, bearing_notes
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.speeds_asked import top_speed
from solidwhirl.scene_reading.weight import refuse_unsupported

__all__ = [
    "ExcitedCriticalSpeed",
    "Reduced",
    "ReducedBodies",
    "Results",
    "reduced",
    "run_for_page",
    "run_scene",
]


def run_scene(
    scene: Scene,
    *,
    comm: Any = None,
    progress: Progress = silent,
    foreseen: Callable[[Plan, Forecast], None] = lambda plan, expected: None,
    store: StageStore | None = None,
) -> Results | None:
    """Run a scene from geometry to Campbell diagram; None on ranks other than 0.

    Parameters
    ----------
    comm
        mpi4py communicator; None for this process alone. Solid bodies are reduced on all of its
        ranks, everything else on rank 0.
    progress
        Told each stage that begins, warnings about the scene, and remarks.
    foreseen
        Called once with what will be computed and what it will cost, before the long work.
    store
        Where completed stages are kept and taken from; None: nowhere. Only rank 0 uses it.

    Raises
    ------
    GeometryError, MeshingError, ReductionError, AssemblyError
        Each with one message.
    """
    found = reduced(scene, comm=comm, progress=progress, foreseen=foreseen, store=store)
    if found is None:
        return None
    engine = stages.assembled_engine(found.job, found.bodies, found.elements, found.beams)
    results = partial(
        Results,
        geometry=found.geometry,
        doubts=found.doubts,
        rounds=found.rounds,
        forecast=found.forecast,
    )
    return _analysed(engine, results)


def run_for_page(
    scene: Scene, *, progress: Progress = silent, store: StageStore | None = None
) -> Results:
    """Run a scene in this process for a page that is to be published.

    Arguments and errors as of `run_scene`. Raises RuntimeError: a check of the run failed, so that
    its numbers can't be trusted.
    """
    results = run_scene(scene, progress=progress, store=store)
    assert results is not None  # one process alone
    if failed(results.checks):
        raise RuntimeError("\n".join((f"scene {scene.name!r}", *failure_lines(results.checks))))
    return results


@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedBodies:
    """The bodies of a scene after their reduction, before they are assembled."""

    job: Job
    #: Bodies from profiles by name, as they were built from the scene
    geometry: Mapping[str, Body]
    bodies: Mapping[str, BodyResult]
    elements: Mapping[str, Superelement]
    beams: BeamBodies


@dataclass(frozen=True, kw_only=True, eq=False)
class Reduced(ReducedBodies):
    """The same, with what results tell of how they came about."""

    doubts: tuple[Doubt, ...]
    rounds: tuple[Round, ...]
    forecast: Forecast


def reduced(
    scene: Scene,
    *,
    comm: Any = None,
    progress: Progress = silent,
    foreseen: Callable[[Plan, Forecast], None] = lambda plan, expected: None,
    store: StageStore | None = None,
) -> Reduced | None:
    """Reduce the bodies of a scene; arguments, errors and other ranks as of `run_scene`."""
    from mpi4py import MPI

    comm = MPI.COMM_SELF if comm is None else comm
    stage_cache = StageCache(store=store if comm.rank == 0 else None, progress=progress)
    bodies = build_bodies(scene)
    refuse_bursting(scene, bodies)
    doubts = implausible(scene, bodies) if comm.rank == 0 else ()
    for doubt in doubts:
        progress(f"warning: {doubt.message}")
    level, keep_level = level_of(scene, bodies, comm, stage_cache)
    plan = make_plan(scene, bodies, level)
    simple = simple_elements(scene, plan)  # milliseconds, and refused before the long work
    solids: dict[str, AnyBody] = {**bodies, **build_mesh_bodies(scene)}
    expected = forecast(scene, plan, solids)
    refuse_too_large(scene, plan, solids, expected)
    levels = " and ".join(dict.fromkeys(own.level for own in plan.bodies.values())) or level
    progress(
        f"level {levels}: about {expected.seconds:.2g} s of one core, "
        f"{expected.peak_memory_gib:.2g} GiB, {expected.unknowns} unknowns"
    )
    foreseen(plan, expected)
    keep_level()  # not before: what is refused leaves nothing behind
    job = Job(scene=scene, plan=plan, comm=comm, clock=Clock(), stage_cache=stage_cache)
    beams = _beams(job, {n: b for n, b in bodies.items() if plan.bodies[n].level == "beam"})
    simple |= beams.elements
    meshed = {name: body for name, body in solids.items() if name not in beams.elements}
    in_rounds, rounds = reduced_bodies(job, meshed, simple)
    if comm.rank != 0:
        return None
    return Reduced(
        job=job,
        geometry=bodies,
        bodies=in_rounds,
        elements=elements_of(in_rounds, simple),
        beams=beams,
        doubts=doubts,
        rounds=rounds,
        forecast=expected,
    )


def _beams(job: Job, bodies: Mapping[str, Body]) -> BeamBodies:
    """Bodies of the beam level, their variants where errors are estimated."""
    scene, plan, stage_cache = job.scene, job.plan, job.stage_cache
    if not bodies:
        return BeamBodies(elements={}, variants=(), finer={})
    estimated = scene.model.estimates == "on"
    found: BeamBodies = stage_cache.stage(
        "beams",
        key_of_beams(stage_cache, scene, plan, bodies),
        lambda: beam_bodies(scene, plan, bodies, estimated=estimated),
    )
    return found


def _analysed(engine: stages.Engine, results: Callable[..., Results]) -> Results:
    """Results with everything that the scene asks of the engine."""
    job, system = engine.job, engine.system
    refuse_unsupported(job.scene, system)
    diagram = stages.diagram_of(engine)
    estimates = stages.estimates_of(engine, diagram)
    with job.clock.stage("checks"):
        checks = run_checks(engine, diagram)
    with job.clock.stage("stability"):
        stability = stages.stability_of_engine(engine, diagram.asymmetry)
    levels = partial(_levels, engine, diagram, estimates)
    outcomes = stages.analyses_of(engine, diagram, estimates, levels)
    critical = [excited.critical for excited in diagram.critical_speeds]
    with job.clock.stage("checks of the analyses"):
        if engine.rotating is None:
            checks += analysis_result_checks(system, critical, outcomes)
    return results(
        scene=job.scene,
        plan=job.plan,
        bodies=engine.reduced,
        elements=engine.elements,
        system=system,
        bearing_notes=(
            *bearing_notes(system, np.array([0.0, top_speed(job.scene)])),
            *validity_notes(job.scene, top_speed(job.scene)),
        ),
        at_rest=diagram.at_rest,
        campbell=diagram.campbell,
        critical_speeds=diagram.critical_speeds,
        estimates=estimates,
        analyses=outcomes,
        timings_s=job.clock.seconds,
        dense_problems=job.clock.solved,
        body_problems=job.clock.of_bodies,
        peak_memory_gib=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2,
        stability=stability,
        asymmetry=diagram.asymmetry,
        checks=checks,
        stages=job.stage_cache.origins,
    )


def _levels(
    engine: stages.Engine, diagram: stages.Diagram, estimates: Estimates | None, level: str
) -> tuple[LevelResults, LevelResults]:
    """What is compared of an engine, and of the one with its bodies on another level."""
    job = engine.job
    found = reduced(alone_at_level(job.scene, level), store=job.stage_cache.store)
    assert found is not None  # one process alone
    other = stages.assembled_engine(found.job, found.bodies, found.elements, found.beams)
    seen = stages.diagram_of(other)
    return (
        _level_results(engine, diagram, estimates),
        _level_results(other, seen, stages.estimates_of(other, seen)),
    )


def _level_results(
    engine: stages.Engine, diagram: stages.Diagram, estimates: Estimates | None
) -> LevelResults:
    hertz, found = diagram.at_rest.frequency_hz, diagram.critical_speeds
    count = np.flatnonzero(hertz > 0.0)[: diagram.campbell.frequency_hz.shape[0]]
    nothing = np.full(max(hertz.size, len(found)), np.nan)
    errors = nothing if estimates is None else estimates.at_rest.total
    critical_errors = nothing if estimates is None else estimates.critical_speeds.total
    return LevelResults(
        levels={name: own.level for name, own in engine.job.plan.bodies.items()},
        unknowns={name: e.full_dofs for name, e in engine.elements.items()},
        frequency_hz=hertz[count],
        frequency_error=errors[count],
        critical_rad_s=np.array([c.critical.speed_rad_s for c in found]),
        critical_error=critical_errors[: len(found)],
        excited_by=tuple(", ".join(c.excited_by) or None for c in found),
    )
