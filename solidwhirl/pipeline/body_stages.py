"""Bodies of a run from geometry to superelement: meshes, reductions and rounds of the dial."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

from solidwhirl.bodies import reduction
from solidwhirl.bodies.refinement import (
    Judgement,
    Refinement,
    Round,
    next_discretisations,
    rounds_of,
)
from solidwhirl.core.reduction_work import ReductionWork
from solidwhirl.core.stages import Progress, Stage, StageName
from solidwhirl.cost.forecast import refuse_made_mesh, shortage_of
from solidwhirl.estimates.comparators import is_compared
from solidwhirl.geometry import Body
from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import MeshedBody
from solidwhirl.model.mesh_bodies import described
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.system_parts import engine_of
from solidwhirl.pipeline.cached_stages import StageCache, engine_part
from solidwhirl.rotordyn import AssembledSystem, Superelement
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import scene_hash


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """What all stages of a run need."""

    scene: Scene
    plan: Plan
    comm: Any
    clock: reduction.Clock
    #: Where stages come from and are kept; on rank 0 only
    stage_cache: StageCache
    # the last engine, with the elements that it was made of
    _last: list[tuple[Mapping[str, Superelement], AssembledSystem]] = field(
        default_factory=list, init=False
    )

    def engine_of(self, elements: Mapping[str, Superelement]) -> AssembledSystem:
        """Assemble the engine, once of the same elements: what judges bodies is also reported."""
        for known, system in self._last:
            if list(known) == list(elements) and all(known[n] is elements[n] for n in known):
                return system
        system = engine_of(self.scene, self.plan, elements)
        self._last[:] = [(dict(elements), system)]
        return system

    @property
    def progress(self) -> Progress:
        """Told each stage that begins, and remarks."""
        return self.stage_cache.progress


def reduced_bodies(
    job: Job, bodies: Mapping[str, Body | MeshedBody], simple: Mapping[str, Superelement]
) -> tuple[dict[str, reduction.BodyResult], tuple[Round, ...]]:
    """Reduce the bodies until the estimated error is within the accuracy, or can't get there.

    The refinement begins where that of the same bodies with other supports ended, if it is kept.
    """
    scene, stage_cache = job.scene, job.stage_cache
    if job.comm.size > 1:
        # the solvers talk to all ranks when they start, but some bodies are reduced by one
        with job.clock.stage("import_solvers"):
            import solidwhirl.reduction  # noqa: F401
    first = {name: reduction.first_discretisation(scene, job.plan, name) for name in bodies}
    if not bodies or scene.model.estimates == "off":  # nothing is refined
        return _refined_bodies(job, bodies, simple, first)
    keys = _refinement_keys(job, bodies, simple)
    found = _refinement_kept(job, keys)
    # cases of a batch that begin together: one refines the bodies, the others begin where it ended
    alone = nullcontext() if any(found) else stage_cache.alone(keys[1])
    with alone:
        kept, other = found if any(found) else _refinement_kept(job, keys)
        stage_cache.say("refinement", "computed" if kept is None else "kept")
        if kept is not None:
            again = {n: _reduce(job, bodies[n], c, None) for n, c in kept.discretisations.items()}
            return {n: r for n, r in again.items() if r is not None}, kept.rounds
        if other is not None:
            modes = {n: max(first[n].modes, c.modes) for n, c in other.discretisations.items()}
            first = {n: replace(c, modes=modes[n]) for n, c in other.discretisations.items()}
        reduced, rounds = _refined_bodies(job, bodies, simple, first)
        if rounds:  # on rank 0
            rounds = (replace(rounds[0], from_other=other is not None), *rounds[1:])
            chosen = {n: r.discretisation for n, r in reduced.items()}
            # one that lacked memory goes on where it ended
            for key in keys[1:] if rounds[-1].lacked_memory else keys:
                ended = Refinement(discretisations=chosen, rounds=rounds)
                stage_cache.keep(key, "refinement", ended)
    return reduced, rounds


def _refinement_kept(
    job: Job, keys: tuple[str, str]
) -> tuple[Refinement | None, Refinement | None]:
    """The refinement for this engine, and the last one of these bodies, where they are kept."""
    first, second = job.comm.bcast([job.stage_cache.find(key) for key in keys])
    return first, second


def _refined_bodies(
    job: Job,
    bodies: Mapping[str, Body | MeshedBody],
    simple: Mapping[str, Superelement],
    first: Mapping[str, reduction.Discretisation],
) -> tuple[dict[str, reduction.BodyResult], tuple[Round, ...]]:
    scene, plan = job.scene, job.plan

    def reduce_one(
        name: str, chosen: reduction.Discretisation, before: reduction.BodyResult | None
    ) -> reduction.BodyResult | None:
        return _reduce(job, bodies[name], chosen, before)

    def judge(
        reduced: Mapping[str, reduction.BodyResult], number: int, multiple: float
    ) -> Judgement | None:
        if scene.model.estimates == "off":
            return None
        accuracy = multiple * scene.model.accuracy
        key = _judgement_key(job, reduced, simple, accuracy)

        def compute() -> Judgement:
            system = job.engine_of(elements_of(reduced, simple))
            return next_discretisations(scene, plan, reduced, system, accuracy)

        with job.clock.stage("error_estimate"):
            done, todo = job.stage_cache.stage(f"judgement of round {number}", key, compute)
        if multiple > 1.0:
            job.progress(f"too much for the memory; the next round aims at {accuracy:.1e}")
            return done, todo
        later = [name for name, body in bodies.items() if is_compared(body, plan.bodies[name])]
        left_out = f", the mesh of {', '.join(later)} not yet in it" if later else ""
        job.progress(f"estimated error {done.estimate:.1e} after round {number}{left_out}")
        return done, todo

    def without_indicators(result: reduction.BodyResult) -> reduction.BodyResult:
        return replace(result, work=replace(result.work, indicators=None))

    shortage = shortage_of(scene, plan, bodies, job.progress)
    most = scene.model.rounds
    return rounds_of(first, reduce_one, judge, job.comm, most, shortage, without_indicators)


def bodies_asked(job: Job, bodies: Mapping[str, Body | MeshedBody]) -> tuple[Any, ...]:
    """Return all that the reduction of bodies sees but their meshes, and a little more."""
    scene, plan = job.scene, job.plan
    solids = scene.finite_element_bodies()
    return (
        [_content(body) for body in bodies.values()],
        [plan.bodies[name] for name in bodies],
        [(effect.name, effect.on) for effect in plan.effects],
        scene.model,
        scene.effects,
        [solids[name].model_dump(exclude={"file"}) for name in bodies],
    )


def _refinement_keys(
    job: Job, bodies: Mapping[str, Body | MeshedBody], simple: Mapping[str, Superelement]
) -> tuple[str, str]:
    """Keys of the refinement for this engine, and of that for the last one with these bodies."""
    asked = bodies_asked(job, bodies)
    own = (engine_part(job.scene), job.plan.speeds_rad_s, simple)
    return job.stage_cache.key("refinement", asked, own), job.stage_cache.key("refined", asked)


def elements_of(
    reduced: Mapping[str, reduction.BodyResult], simple: Mapping[str, Superelement]
) -> dict[str, Superelement]:
    """Elements of all bodies by name."""
    return {name: result.element for name, result in reduced.items()} | dict(simple)


def _judgement_key(
    job: Job,
    reduced: Mapping[str, reduction.BodyResult],
    simple: Mapping[str, Superelement],
    accuracy: float,
) -> str:
    asked = (engine_part(job.scene), job.plan.bodies, job.plan.speeds_rad_s, accuracy)
    found = [(_content(r.body), r.discretisation, r.mesh, r.element) for r in reduced.values()]
    return job.stage_cache.key("judgement", asked, found, simple)


def _reduce(
    job: Job,
    body: Body | MeshedBody,
    chosen: reduction.Discretisation,
    before: reduction.BodyResult | None,
) -> reduction.BodyResult | None:
    """Mesh and reduce one body; None on ranks that have no part in the result."""
    from mpi4py import MPI

    plan = job.plan.bodies[body.name]
    level = plan.level
    # a mesh that follows its errors is small, and rank 0 judges them; layers are of one process
    alone = level == "harmonic" or not chosen.mesh_fixed
    alone = alone or bool(body.joints)
    if alone and job.comm.rank != 0:
        return None
    team = MPI.COMM_SELF if alone else job.comm
    mesh = _mesh(job, body, level, chosen, before) if job.comm.rank == 0 else None
    if isinstance(body, MeshedBody):
        told = described(body, mesh) if mesh is not None else None
        body = team.bcast(told)
    key = "" if mesh is None else _reduction_key(job, body, mesh, chosen, team)
    with job.stage_cache.alone(key) if key else nullcontext():
        kept: tuple[Superelement, ReductionWork, bool] | None = None
        if mesh is not None:
            kept = job.stage_cache.find(key)
            job.stage_cache.say(f"reduction {body.name}", "computed" if kept is None else "kept")
        if team.bcast(kept is not None):
            if mesh is None or kept is None:
                return None
            return _restored(job, body, mesh, chosen, *kept)
        if mesh is not None and team.size == 1:
            refuse_made_mesh(job.scene, job.plan, body, chosen, mesh)
        with job.clock.stage("import_solvers"):
            import solidwhirl.reduction  # noqa: F401
        why = reduction.solver_text(plan, mesh, team)
        job.progress(Stage(name=StageName.REDUCTION, body=body.name, detail=why))
        with job.clock.stage("reduction"):
            result = reduction.reduce_meshed(job.scene, job.plan, body, mesh, chosen, team)
        if result is not None:
            if result.work.solver == "iterative" and not why:
                job.progress(f"{body.name}: solved iteratively, MUMPS needs more memory")
            work = replace(result.work, indicators=None)
            kept = (result.element, work, result.work.indicators is not None)
            job.stage_cache.keep(key, f"reduction {body.name}", kept)
    return result


def _mesh(
    job: Job,
    body: Body | MeshedBody,
    level: str,
    chosen: reduction.Discretisation,
    before: reduction.BodyResult | None,
) -> Mesh:
    """The mesh of a body, the last one again where the sizes are still the same."""
    if before is not None and job.stage_cache.same(before.discretisation.local, chosen.local):
        return before.mesh
    key = job.stage_cache.key("mesh", _content(body), level, chosen.size, chosen.local)

    def compute() -> Mesh:
        job.progress(Stage(name=StageName.MESHING, body=body.name, detail=f" ({level})"))
        return reduction.mesh_body(body, level, chosen)

    with job.clock.stage("meshing"):
        found: Mesh = job.stage_cache.stage(f"mesh {body.name}", key, compute)
    return found


def _content(body: Body | MeshedBody) -> Body | MeshedBody:
    """A body without the folder that its file lies in; the content has a digest."""
    if isinstance(body, MeshedBody):
        return replace(body, request=replace(body.request, path=""))
    return body


def _reduction_key(
    job: Job, body: Body | MeshedBody, mesh: Mesh, chosen: reduction.Discretisation, team: Any
) -> str:
    """All that a body's reduction sees, and a little more."""
    asked = bodies_asked(job, {body.name: body})
    return job.stage_cache.key("reduction", asked, mesh, chosen, team.size)


def _restored(
    job: Job,
    body: Body | MeshedBody,
    mesh: Mesh,
    chosen: reduction.Discretisation,
    element: Superelement,
    work: ReductionWork,
    has_indicators: bool,
) -> reduction.BodyResult:
    """A body as its reduction left it, with the scene of this run in its provenance."""
    from mpi4py import MPI

    @cache
    def again() -> tuple[Any, ...]:
        why = " again, for where its error arises"
        job.progress(Stage(name=StageName.REDUCTION, body=body.name, detail=why))
        result = reduction.reduce_meshed(job.scene, job.plan, body, mesh, chosen, MPI.COMM_SELF)
        assert result is not None and result.work.indicators is not None
        return result.work.indicators()

    scene = job.scene
    provenance = {
        **element.provenance,
        "scene": scene.name,
        "scene_sha256": scene_hash(scene),
        "effects": scene.effects.model_dump(),
    }
    return reduction.BodyResult(
        body=body,
        discretisation=chosen,
        mesh=mesh,
        element=replace(element, provenance=provenance),
        properties=reduction.closed_form(body),
        work=replace(work, indicators=again if has_indicators else None),
    )
