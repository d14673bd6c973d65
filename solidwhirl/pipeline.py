"""The road from a scene to its results: geometry, mesh, reduction, assembly, analyses."""

from __future__ import annotations

import resource
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from solidwhirl.analyses import run_analysis
from solidwhirl.beam_bodies import BeamBodies, beam_bodies
from solidwhirl.bodies import build_bodies
from solidwhirl.body_reduction import (
    BodyResult,
    Clock,
    Discretisation,
    Progress,
    first_discretisation,
    is_new_mesh,
    mesh_body,
    reduce_meshed,
)
from solidwhirl.comparators import (
    Comparison,
    beam_comparison,
    coupling_comparison,
    solid_comparisons,
)
from solidwhirl.dial import Judgement, Round, next_discretisations, rounds_of
from solidwhirl.estimates import BeamVariants, Estimates, estimate_errors
from solidwhirl.forecast import Forecast, forecast, refuse_too_large
from solidwhirl.geometry import Body
from solidwhirl.levels import chosen_level
from solidwhirl.outcome import Outcome
from solidwhirl.peak_estimates import with_peak_estimates
from solidwhirl.plan import make_plan, top_speed
from solidwhirl.plan_records import Plan
from solidwhirl.rotordyn import (
    AnalysisError,
    AssembledSystem,
    BearingNote,
    Campbell,
    CriticalSpeed,
    Modes,
    Superelement,
    bearing_notes,
    campbell,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.scene import Scene
from solidwhirl.system_parts import engine_of, simple_elements


@dataclass(frozen=True, kw_only=True, eq=False)
class ExcitedCriticalSpeed:
    """A critical speed of the reference shaft and who excites it.

    Attributes
    ----------
    excited_by
        Bodies whose unbalance turns at this frequency.
    critical
        The critical speed.
    """

    excited_by: tuple[str, ...]
    critical: CriticalSpeed


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


def run_scene(
    scene: Scene, *, comm: Any = None, progress: Progress = lambda text: None
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
    clock = Clock()
    bodies = build_bodies(scene)
    level = chosen_level(scene, bodies)
    plan = make_plan(scene, bodies, level)
    simple = simple_elements(scene, plan)  # milliseconds, and refused before the long work
    expected = forecast(scene, plan, bodies)
    refuse_too_large(scene, plan, bodies, expected)
    progress(
        f"level {level}: about {expected.seconds:.2g} s of one core and "
        f"{expected.peak_memory_gib:.2g} GiB, {expected.unknowns} unknowns"
    )
    meshed = {n: b for n, b in bodies.items() if plan.bodies[n].level != "beam"}
    beams = beam_bodies(
        scene,
        plan,
        {n: b for n, b in bodies.items() if n not in meshed},
        estimated=scene.model.estimates == "on",
    )
    simple |= beams.elements
    reduced, rounds = _reduced(scene, plan, meshed, simple, comm, progress, clock)
    if comm.rank != 0:
        return None
    return _analyse(scene, plan, reduced, rounds, simple, beams, expected, progress, clock)


def _reduced(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body],
    simple: Mapping[str, Superelement],
    comm: Any,
    progress: Progress,
    clock: Clock,
) -> tuple[dict[str, BodyResult], tuple[Round, ...]]:
    """Reduce the bodies until the estimated error is within the accuracy, or can't get there."""

    def reduce_one(
        name: str, chosen: Discretisation, before: BodyResult | None
    ) -> BodyResult | None:
        return _reduce(scene, plan, bodies[name], chosen, before, comm, progress, clock)

    def judge(reduced: Mapping[str, BodyResult], number: int) -> Judgement | None:
        if scene.model.estimates == "off":
            return None
        with clock.stage("error_estimate"):
            system = _system(scene, plan, reduced, simple)
            done, todo = next_discretisations(scene, plan, reduced, system)
        progress(f"estimated error {done.estimate:.1e} after round {number}")
        return done, todo

    first = {name: first_discretisation(scene, plan, name) for name in bodies}
    return rounds_of(first, reduce_one, judge, comm)


def _reduce(
    scene: Scene,
    plan: Plan,
    body: Body,
    chosen: Discretisation,
    before: BodyResult | None,
    comm: Any,
    progress: Progress,
    clock: Clock,
) -> BodyResult | None:
    """Mesh and reduce one body; None on ranks that have no part in the result."""
    from mpi4py import MPI

    level = plan.bodies[body.name].level
    if level == "harmonic" and comm.rank != 0:
        return None
    mesh = None
    if comm.rank == 0:
        if is_new_mesh(chosen, before):
            progress(f"mesh {body.name} ({level})")
        with clock.stage("meshing"):
            mesh = mesh_body(body, level, chosen, before)
    with clock.stage("import_solvers"):
        import solidwhirl.reduction  # noqa: F401
    progress(f"reduce {body.name}")
    team = comm if level == "solid" else MPI.COMM_SELF
    with clock.stage("reduction"):
        return reduce_meshed(scene, plan, body, mesh, chosen, team)


def _system(
    scene: Scene,
    plan: Plan,
    reduced: Mapping[str, BodyResult],
    simple: Mapping[str, Superelement],
) -> AssembledSystem:
    """The engine of reduced and simple bodies."""
    elements = {name: result.element for name, result in reduced.items()} | dict(simple)
    return engine_of(scene, plan, elements)


def _beam_variants(
    scene: Scene, plan: Plan, elements: Mapping[str, Superelement], beams: BeamBodies
) -> BeamVariants | None:
    """The engine with the other choices of beam theory."""
    if not beams.variants:
        return None
    return BeamVariants(
        systems=tuple(engine_of(scene, plan, {**elements, **own}) for own in beams.variants),
        elements=beams.variants,
    )


def _analyse(
    scene: Scene,
    plan: Plan,
    reduced: Mapping[str, BodyResult],
    rounds: tuple[Round, ...],
    simple: Mapping[str, Superelement],
    beams: BeamBodies,
    expected: Forecast,
    progress: Progress,
    clock: Clock,
) -> Results:
    """Assemble the engine and run everything that the scene asks for."""
    progress("assemble the system")
    with clock.stage("assembly"):
        elements = {name: result.element for name, result in reduced.items()} | dict(simple)
        system = _system(scene, plan, reduced, simple)
    top = top_speed(scene)
    progress(f"Campbell diagram at {len(plan.speeds_rad_s)} speeds")
    with clock.stage("campbell"):
        at_rest = modes_at_speed(system, 0.0)
        diagram = campbell(system, plan.speeds_rad_s, **_branches(scene))
    progress("critical speeds")
    with clock.stage("critical_speeds"):
        critical = _critical_speeds(scene, system, float(plan.speeds_rad_s.max()))
    estimates = None
    if scene.model.estimates == "on":
        progress("error estimates")
        with clock.stage("error_estimate"):
            estimates = estimate_errors(
                system,
                elements,
                at_rest,
                diagram,
                [c.critical for c in critical],
                _comparisons(scene, plan, reduced, simple, beams),
                _beam_variants(scene, plan, elements, beams),
            )
    outcomes = {}
    for k, spec in enumerate(scene.analyses):
        progress(f"{spec.label} ({spec.kind})")
        with clock.stage(f"analysis {spec.label}"):
            try:
                outcome = run_analysis(spec, scene, system, diagram)
                if estimates is not None:
                    pairs = estimates.comparisons
                    outcome = with_peak_estimates(outcome, spec, system, pairs)
                outcomes[spec.label] = outcome
            except AnalysisError as error:
                raise AnalysisError(f"analyses[{k}] ({spec.label}): {error}") from error
    return Results(
        scene=scene,
        plan=plan,
        bodies=reduced,
        rounds=rounds,
        forecast=expected,
        elements=elements,
        system=system,
        bearing_notes=bearing_notes(system, np.array([0.0, top])),
        at_rest=at_rest,
        campbell=diagram,
        critical_speeds=critical,
        estimates=estimates,
        analyses=outcomes,
        timings_s=clock.seconds,
        peak_memory_gib=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2,
    )


def _comparisons(
    scene: Scene,
    plan: Plan,
    reduced: Mapping[str, BodyResult],
    simple: Mapping[str, Superelement],
    beams: BeamBodies,
) -> tuple[Comparison, ...]:
    """Other models whose results tell parts of the error."""
    elements = {name: result.element for name, result in reduced.items()} | dict(simple)
    made_of = partial(engine_of, scene, plan)
    solids = {n: r for n, r in reduced.items() if plan.bodies[n].level == "solid"}
    found = solid_comparisons(scene, plan, solids, elements, made_of)
    found += beam_comparison(elements, beams.finer, made_of)
    if scene.model.compare_coupling == "on":
        bodies = {name: result.body for name, result in reduced.items()}
        found += coupling_comparison(scene, bodies, elements, made_of)
    return found


def _branches(scene: Scene) -> dict[str, Any]:
    if scene.campbell.frequency_max_hz is not None:
        return {"frequency_max_hz": scene.campbell.frequency_max_hz}
    return {"branch_count": scene.campbell.branches}


def _critical_speeds(
    scene: Scene, system: AssembledSystem, top: float
) -> tuple[ExcitedCriticalSpeed, ...]:
    """Critical speeds up to the top speed, for the unbalance of every body that turns."""
    if top == 0.0:
        return ()
    exciters: dict[float, list[str]] = {}
    for name, ratio in scene.speed_ratios().items():
        if ratio != 0.0:
            exciters.setdefault(abs(ratio), []).append(name)
    found = [
        ExcitedCriticalSpeed(excited_by=tuple(names), critical=c)
        for ratio, names in exciters.items()
        for c in critical_speeds(system, excitation_ratio=ratio, speed_max_rad_s=top)
    ]
    return tuple(sorted(found, key=lambda f: f.critical.speed_rad_s))
