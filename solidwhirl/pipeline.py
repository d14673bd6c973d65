"""The road from a scene to its results: geometry, mesh, reduction, assembly, analyses."""

from __future__ import annotations

import resource
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from solidwhirl.alarms import Alarm, alarms_of
from solidwhirl.beam_bodies import BeamBodies, beam_bodies
from solidwhirl.bodies import build_bodies
from solidwhirl.body_reduction import BodyResult, Clock, Progress
from solidwhirl.body_stages import Job, elements_of, reduced_bodies
from solidwhirl.dial import Round
from solidwhirl.displays_results import results_html, results_text
from solidwhirl.engine_stages import (
    ExcitedCriticalSpeed,
    analyses_of,
    assembled_engine,
    diagram_of,
    estimates_of,
    stability_of_engine,
)
from solidwhirl.estimates import Estimates
from solidwhirl.forecast import Forecast, forecast, refuse_too_large
from solidwhirl.geometry import Body
from solidwhirl.levels import chosen_level
from solidwhirl.mesh_bodies import build_mesh_bodies
from solidwhirl.operating import operating_speeds
from solidwhirl.outcome import Outcome
from solidwhirl.plan import make_plan
from solidwhirl.plan_records import Plan
from solidwhirl.recovery_references import meshes_for
from solidwhirl.result_checks import analysis_result_checks
from solidwhirl.rotordyn import (
    AssembledSystem,
    BearingNote,
    Campbell,
    Invariant,
    Modes,
    Superelement,
    bearing_notes,
)
from solidwhirl.run_checks import run_checks
from solidwhirl.scene import Scene
from solidwhirl.speeds_asked import top_speed
from solidwhirl.stability_documents import Stability
from solidwhirl.store import StageStore
from solidwhirl.store_stages import Keeper, engine_part
from solidwhirl.system_parts import simple_elements

__all__ = ["ExcitedCriticalSpeed", "Results", "run_scene"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Results:
    """All results of a scene, as arrays (units in the records that hold them).

    Attributes
    ----------
    scene, plan
        What was asked and what was decided.
    bodies
        Solids by name.
    rounds
        What the accuracy dial did; empty without estimates.
    forecast
        Cost that was predicted.
    elements
        Superelements of all bodies by name.
    system
        The assembled system.
    bearing_notes
        Bearings used beyond the range of their law, or that feed energy.
    at_rest
        Modes at zero speed.
    campbell
        Tracked branches over the speeds of the scene.
    critical_speeds
        Within the scene's speed range, by excitation.
    estimates
        Errors of these; None where the scene has estimates = "off".
    analyses
        The other analyses of the scene by name.
    timings_s
        Wall time by stage.
    peak_memory_gib
        Largest resident set of this process.
    stability
        Unstable intervals of the whole range of speeds, and damping at the operating speeds.
    checks
        What must hold for bodies, system and modes, and whether it does.
    stages
        "computed" or "kept" by stage; empty where nothing is kept.
    """

    scene: Scene
    plan: Plan
    bodies: Mapping[str, BodyResult]
    rounds: tuple[Round, ...]
    forecast: Forecast
    elements: Mapping[str, Superelement]
    system: AssembledSystem
    bearing_notes: tuple[BearingNote, ...]
    at_rest: Modes
    campbell: Campbell
    critical_speeds: tuple[ExcitedCriticalSpeed, ...]
    estimates: Estimates | None
    analyses: Mapping[str, Outcome]
    timings_s: Mapping[str, float]
    peak_memory_gib: float
    stability: Stability
    checks: tuple[Invariant, ...] = ()
    stages: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return results_text(self)

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Instability, and what operates or was computed where the system is unstable."""
        documents = {name: {"kind": o.kind, **o.document} for name, o in self.analyses.items()}
        return alarms_of(self.stability, operating_speeds(self.scene), documents)

    def _repr_html_(self) -> str:
        return results_html(self)


def run_scene(
    scene: Scene,
    *,
    comm: Any = None,
    progress: Progress = lambda text: None,
    foreseen: Callable[[Plan, Forecast], None] = lambda plan, expected: None,
    store: StageStore | None = None,
) -> Results | None:
    """Run a scene from geometry to Campbell diagram.

    Parameters
    ----------
    scene
        The scene (see `solidwhirl.scene_file`).
    comm
        mpi4py communicator; None for this process alone. Solid bodies are reduced on all of its
        ranks, everything else on rank 0.
    progress
        Called with one line per stage.
    foreseen
        Called once with what will be computed and what it will cost, before the long work.
    store
        Where completed stages are kept and taken from (see `solidwhirl.store_stages.open_store`);
        None: nowhere. Only rank 0 uses it.

    Returns
    -------
    Results, or None on ranks other than 0.

    Raises
    ------
    ValueError
        `GeometryError`, `MeshingError`, `ReductionError`, `AssemblyError`, each with one message.
    """
    from mpi4py import MPI

    comm = MPI.COMM_SELF if comm is None else comm
    keeper = Keeper(store=store if comm.rank == 0 else None, progress=progress)
    bodies, meshes = build_bodies(scene), build_mesh_bodies(scene)
    level, keep_level = _level(scene, bodies, comm, keeper)
    plan = make_plan(scene, bodies, level)
    simple = simple_elements(scene, plan)  # milliseconds, and refused before the long work
    expected = forecast(scene, plan, {**bodies, **meshes})
    refuse_too_large(scene, plan, {**bodies, **meshes}, expected)
    progress(
        f"level {level}: about {expected.seconds:.2g} s of one core without analyses and "
        f"pictures, {expected.peak_memory_gib:.2g} GiB, {expected.unknowns} unknowns"
    )
    foreseen(plan, expected)
    keep_level()  # not before: what is refused leaves nothing behind
    job = Job(
        scene=scene,
        plan=plan,
        comm=comm,
        progress=progress,
        clock=Clock(),
        keeper=keeper,
    )
    beams = _beams(job, {n: b for n, b in bodies.items() if plan.bodies[n].level == "beam"})
    simple |= beams.elements
    meshed = {n: b for n, b in bodies.items() if n not in beams.elements}
    reduced, rounds = reduced_bodies(job, {**meshed, **meshes}, simple)
    if comm.rank != 0:
        return None
    return _analyse(job, reduced, rounds, simple, beams, expected)


def _level(
    scene: Scene, bodies: Mapping[str, Body], comm: Any, keeper: Keeper
) -> tuple[str, Callable[[], None]]:
    """The level of the bodies, and a function that keeps it; looking for it takes a second."""
    if scene.model.level != "auto":
        return scene.model.level, lambda: None
    if meshes_for(scene):  # beams have no stress in a solid
        return "harmonic", lambda: None
    name = "choice of the level"
    key = keeper.key("level", engine_part(scene), scene.analyses, bodies)
    kept: str | None = comm.bcast(keeper.find(key))
    if kept is not None:
        keeper.say(name, "kept")
        return kept, lambda: None
    level = chosen_level(scene, bodies)
    keeper.say(name, "computed")
    return level, lambda: keeper.keep(key, name, level)


def _beams(job: Job, bodies: Mapping[str, Body]) -> BeamBodies:
    """Bodies of the beam level, their variants where errors are estimated."""
    scene, plan, keeper = job.scene, job.plan, job.keeper
    estimated = scene.model.estimates == "on"
    if not bodies:
        return BeamBodies(elements={}, variants=(), finer={})
    effects = [(effect.name, effect.on) for effect in plan.effects]
    key = keeper.key("beams", engine_part(scene), plan.bodies, effects, bodies)
    found: BeamBodies = keeper.stage(
        "beams", key, lambda: beam_bodies(scene, plan, bodies, estimated=estimated)
    )
    return found


def _analyse(
    job: Job,
    reduced: Mapping[str, BodyResult],
    rounds: tuple[Round, ...],
    simple: Mapping[str, Superelement],
    beams: BeamBodies,
    expected: Forecast,
) -> Results:
    """Assemble the engine and run everything that the scene asks for."""
    engine = assembled_engine(job, reduced, elements_of(reduced, simple), beams)
    diagram = diagram_of(engine)
    estimates = estimates_of(engine, diagram)
    with job.clock.stage("checks"):
        checks = run_checks(job.scene, job.plan, reduced, engine.elements, engine.system, diagram)
    with job.clock.stage("stability"):
        stability = stability_of_engine(engine)
    outcomes = analyses_of(engine, diagram.campbell, estimates)
    found = [excited.critical for excited in diagram.critical_speeds]
    with job.clock.stage("checks of the analyses"):
        checks += analysis_result_checks(engine.system, found, outcomes)
    return Results(
        scene=job.scene,
        plan=job.plan,
        bodies=reduced,
        rounds=rounds,
        forecast=expected,
        elements=engine.elements,
        system=engine.system,
        bearing_notes=bearing_notes(engine.system, np.array([0.0, top_speed(job.scene)])),
        at_rest=diagram.at_rest,
        campbell=diagram.campbell,
        critical_speeds=diagram.critical_speeds,
        estimates=estimates,
        analyses=outcomes,
        timings_s=job.clock.seconds,
        peak_memory_gib=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2,
        stability=stability,
        checks=checks,
        stages=job.keeper.origins,
    )
