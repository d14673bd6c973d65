"""The road from a scene to its results: geometry, mesh, reduction, assembly, analyses."""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from solidwhirl.analyses import run_analysis
from solidwhirl.bodies import build_bodies
from solidwhirl.geometry import Body, MassProperties, mass_properties
from solidwhirl.meshing import (
    Mesh,
    MeshingError,
    mesh_meridian,
    mesh_solid,
    predict_unknowns,
)
from solidwhirl.outcome import Outcome
from solidwhirl.plan import BodyPlan, Plan, make_plan, top_speed
from solidwhirl.rotordyn import (
    AnalysisError,
    AssembledSystem,
    BearingNote,
    Campbell,
    CriticalSpeed,
    Modes,
    Superelement,
    assemble,
    bearing_notes,
    campbell,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.scene import Scene
from solidwhirl.scene_file import scene_hash
from solidwhirl.system_parts import bearings, gears, rotors, simple_elements
from solidwhirl.versions import package_versions

Progress = Callable[[str], None]
# PETSC_ERR_USER_INPUT: more eigenvalues are asked for than the matrix has.
_WRONG_REQUEST = 95


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyResult:
    """One body after its reduction.

    Attributes
    ----------
    body
        Geometry.
    mesh
        Its mesh.
    element
        Its superelement.
    properties
        Mass properties in closed form, rigid disks included.
    work
        `solidwhirl.reduction.ReductionWork`: what was assembled and solved.
    """

    body: Body
    mesh: Mesh
    element: Superelement
    properties: MassProperties
    work: Any


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
    elements: Mapping[str, Superelement]
    system: AssembledSystem
    bearing_notes: tuple[BearingNote, ...]
    at_rest: Modes
    campbell: Campbell
    critical_speeds: tuple[ExcitedCriticalSpeed, ...]
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
    clock = _Clock()
    bodies = build_bodies(scene)
    plan = make_plan(scene, bodies)
    simple = simple_elements(scene, plan)  # milliseconds, and refused before the long work
    reduced = {}
    _refuse_what_does_not_fit(bodies, plan)
    for name, body in bodies.items():
        result = _reduce(scene, body, plan, comm, progress, clock)
        if result is not None:
            reduced[name] = result
    if comm.rank != 0:
        return None
    return _analyse(scene, plan, reduced, simple, progress, clock)


def _analyse(
    scene: Scene,
    plan: Plan,
    reduced: Mapping[str, BodyResult],
    simple: Mapping[str, Superelement],
    progress: Progress,
    clock: _Clock,
) -> Results:
    """Assemble the engine and run everything that the scene asks for."""
    progress("assemble the system")
    with clock.stage("assembly"):
        elements = {name: result.element for name, result in reduced.items()}
        elements |= simple
        system = assemble(
            rotors(scene, plan, elements), bearings(scene, plan), gears=gears(scene, plan)
        )
    top = top_speed(scene)
    progress(f"Campbell diagram at {len(plan.speeds_rad_s)} speeds")
    with clock.stage("campbell"):
        at_rest = modes_at_speed(system, 0.0)
        diagram = campbell(system, plan.speeds_rad_s, **_branches(scene))
    progress("critical speeds")
    with clock.stage("critical_speeds"):
        critical = _critical_speeds(scene, system, float(plan.speeds_rad_s.max()))
    outcomes = {}
    for k, spec in enumerate(scene.analyses):
        progress(f"{spec.label} ({spec.kind})")
        with clock.stage(f"analysis {spec.label}"):
            try:
                outcomes[spec.label] = run_analysis(spec, scene, system, diagram)
            except AnalysisError as error:
                raise AnalysisError(f"analyses[{k}] ({spec.label}): {error}") from error
    return Results(
        scene=scene,
        plan=plan,
        bodies=reduced,
        elements=elements,
        system=system,
        bearing_notes=bearing_notes(system, np.array([0.0, top])),
        at_rest=at_rest,
        campbell=diagram,
        critical_speeds=critical,
        analyses=outcomes,
        timings_s=clock.seconds,
        peak_memory_gib=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2,
    )


def predicted_memory_gib(unknowns: int) -> float:
    """Memory of a solid reduction: 2.0 GiB at 1e5 unknowns, growing with the power 1.15.

    Fitted to 48e3 to 210e3 unknowns (1.04 to 4.2 GiB).
    """
    return float(2.0 * (unknowns / 1e5) ** 1.15)


def _refuse_what_does_not_fit(bodies: Mapping[str, Body], plan: Plan) -> None:
    """Refuse a solid mesh that this machine's memory can't hold, before it is made."""
    present = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1024.0**3
    for name, body in bodies.items():
        if plan.bodies[name].level != "solid":
            continue
        unknowns = predict_unknowns(body, plan.bodies[name].fineness.size)
        needed = predicted_memory_gib(unknowns)
        if needed > present:
            raise MeshingError(
                f"bodies.{name}: level solid would have about {unknowns:.2g} unknowns and need "
                f"about {needed:.3g} GiB, this machine has {present:.3g}; choose level harmonic, "
                "a lower accuracy, or larger size_m and corner_size_m in [model]"
            )


class _Clock:
    """Wall time by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def stage(self, name: str) -> _Clock:
        self._name = name
        return self

    def __enter__(self) -> None:
        self._start = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        spent = time.perf_counter() - self._start
        self.seconds[self._name] = self.seconds.get(self._name, 0.0) + spent


def _reduce(
    scene: Scene, body: Body, plan: Plan, comm: Any, progress: Progress, clock: _Clock
) -> BodyResult | None:
    """Mesh and reduce one body; None on ranks that have no part in the result."""
    from mpi4py import MPI

    own = plan.bodies[body.name]
    if own.level == "harmonic" and comm.rank != 0:
        return None
    mesh = None
    if comm.rank == 0:
        progress(f"mesh {body.name} ({own.level})")
        with clock.stage("meshing"):
            make = mesh_solid if own.level == "solid" else mesh_meridian
            mesh = make(body, own.fineness.size)
    with clock.stage("import_solvers"):
        from solidwhirl.reduction import ReductionError, ReductionRequest, reduce_body
    progress(f"reduce {body.name}")
    request = ReductionRequest(
        level=own.level,
        orders=own.orders,
        components=own.components,
        interface_components=own.interface_components,
        degree=own.fineness.degree,
        modes=scene.bodies[body.name].modes or scene.model.modes,
        maximum_speed_rad_s=own.maximum_speed_rad_s,
        gyroscopic=plan.on("gyroscopic"),
        centrifugal=plan.on("stress_stiffening"),
    )
    team = comm if own.level == "solid" else MPI.COMM_SELF
    record = team.bcast(_provenance(scene, own, request.modes, mesh) if mesh is not None else None)
    with clock.stage("reduction"):
        try:
            element, work = reduce_body(body, mesh, team, request, record)
        except RuntimeError as error:
            if getattr(error, "ierr", None) != _WRONG_REQUEST:
                raise
            raise ReductionError(
                f"bodies.{body.name}.modes: {request.modes} (its own, or that of [model]) are more "
                "than the eigenvalue solver can find on its mesh; choose fewer, or a finer mesh"
            ) from error
    if mesh is None:
        return None
    return BodyResult(
        body=body, mesh=mesh, element=element, properties=mass_properties(body), work=work
    )


def _provenance(scene: Scene, own: BodyPlan, modes: int, mesh: Mesh) -> dict[str, Any]:
    """How a superelement was made."""
    return {
        "scene": scene.name,
        "scene_sha256": scene_hash(scene),
        "level": own.level,
        "orders": list(own.orders),
        "mesh": {
            "points": len(mesh.points),
            "cells": len(mesh.cells),
            "size_m": mesh.size.size_m,
            "corner_size_m": mesh.size.corner_size_m,
            "growth": mesh.size.growth,
            "minimum_scaled_jacobian": mesh.quality.minimum_scaled_jacobian,
        },
        "element_order": own.fineness.degree,
        "expected_relative_error": own.fineness.expected_error,
        "modes": modes,
        "effects": scene.effects.model_dump(),
        "packages": package_versions(),
    }


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
