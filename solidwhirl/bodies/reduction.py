"""One body from its geometry to its superelement, with one discretisation."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.core.displays import indented
from solidwhirl.core.errors import MemoryShortageError
from solidwhirl.core.reduction_work import BODIES, ReductionWork
from solidwhirl.core.versions import package_versions
from solidwhirl.geometry import Body, MassProperties, mass_properties, symmetry
from solidwhirl.meshing import LocalSize, Mesh, MeshSize
from solidwhirl.meshing.imported.records import MeshedBody
from solidwhirl.model.mesh_bodies import made_mesh
from solidwhirl.model.plan_records import BodyPlan, Plan
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.speeds_asked import top_speed_text
from solidwhirl.scene_reading.reader import scene_hash

if TYPE_CHECKING:
    from solidwhirl.reduction import ReductionRequest
    from solidwhirl.rotordyn import Superelement

# Speed of sound along bars of the usual metals [m/s].
_SOUND = 5000.0
# Modes to begin with where the error estimate decides, and where nothing does.
_FIRST_MODES, _MODES_UNSEEN = 4, 12
# Part of the accuracy that one combination of static answers to the spin may be worth, left out.
_SPIN_SHARE = 0.05


class Clock:
    """Wall time by stage, and what was solved in it of the engine and of bodies.

    Threads may share one: bodies that are watched are asked by several.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.solved: dict[str, Counter[str]] = {}
        self.of_bodies: dict[str, Counter[str]] = {}
        self._lock = Lock()

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Charge what follows to a stage."""
        start = time.perf_counter()
        with SYSTEMS.counted() as solved, BODIES.counted() as of_bodies:
            try:
                yield
            finally:
                with self._lock:
                    spent = time.perf_counter() - start
                    self.seconds[name] = self.seconds.get(name, 0.0) + spent
                    for sums, found in ((self.solved, solved), (self.of_bodies, of_bodies)):
                        if found:
                            sums.setdefault(name, Counter()).update(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class Discretisation:
    """How one body is discretised."""

    degree: int
    size: MeshSize
    local: LocalSize | None  #: Sizes by place instead; None: there are none
    modes: int
    #: Speeds between rest and the top that the basis has modes of
    speeds_between_rad_s: tuple[float, ...]
    #: Whether the scene fixes the mesh and the number of modes
    mesh_fixed: bool
    modes_fixed: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyResult:
    """One body after its reduction."""

    body: Body | MeshedBody
    discretisation: Discretisation
    mesh: Mesh
    element: Superelement
    #: Mass properties in closed form, rigid disks included; None of a mesh, whose own are those of
    #: its element
    properties: MassProperties | None
    work: ReductionWork

    @property
    def shown_mesh(self) -> Mesh:
        """The mesh without what lies twice in it."""
        if self.mesh.parts is None:
            return self.mesh
        from solidwhirl.meshing.own.joined import without_copies  # with all that meshes

        return without_copies(self.mesh)

    def __repr__(self) -> str:
        mesh, used = self.shown_mesh, self.discretisation
        line = (
            f"mesh: {len(mesh.points)} points, {len(mesh.cells)} cells; "
            f"element order {used.degree}, {used.modes} modes per family"
        )
        return "\n".join(["BodyResult", *indented([*repr(self.element).split("\n"), line])])


def first_discretisation(scene: Scene, plan: Plan, name: str) -> Discretisation:
    """Where a body begins."""
    own, model = plan.bodies[name], scene.model
    assert own.resolution is not None
    solids = scene.finite_element_bodies()
    given = solids[name].modes or model.modes
    estimated = model.estimates == "on"
    # pairs that the diagram shows, evenly from all bodies, and two to spare
    shown = -(-scene.campbell.branches // (2 * len(solids))) + 2
    shown = max(shown, min(_passed(scene, plan, name) + 2, _MODES_UNSEEN * 4))
    return Discretisation(
        degree=own.resolution.degree,
        size=own.resolution.size,
        local=None,
        modes=given or (max(_FIRST_MODES, shown) if estimated else _MODES_UNSEEN),
        speeds_between_rad_s=(),
        mesh_fixed=not own.resolution.is_adapted,
        modes_fixed=given is not None or not estimated,
    )


def _passed(scene: Scene, plan: Plan, name: str) -> int:
    """About how many pairs of modes of a body have their critical speed in the range.

    Those of a free uniform bar, rigid ones included: ω = c ρ ((k - 1/2) π / L)² with the radius of
    gyration ρ of its sections.
    """
    if name not in scene.bodies or not scene.bodies[name].sections:
        return 0
    parts = scene.bodies[name].sections
    span = [(s.start_m, s.end_m) for s in parts]
    square = [(sum(s.outer_radius_m) ** 2 + sum(s.inner_radius_m) ** 2) / 4.0 for s in parts]
    weight = [end - start for start, end in span]
    gyration = 0.5 * np.sqrt(np.average(square, weights=weight))
    length = max(end for _, end in span) - min(start for start, _ in span)
    ratio = max(abs(r) for r in scene.speed_ratios().values())
    top = ratio * float(plan.speeds_rad_s.max())
    return int(length / np.pi * np.sqrt(top / (_SOUND * gyration)) + 1.5)


def mesh_body(
    body: Body | MeshedBody, level: str, chosen: Discretisation, before: BodyResult | None = None
) -> Mesh:
    """Mesh a body for its level; the last mesh again where the sizes are still the same."""
    from solidwhirl.meshing import mesh_meridian, mesh_revolved
    from solidwhirl.meshing.own.features.sector import mesh_sector, mesh_whole_body
    from solidwhirl.meshing.own.joined import mesh_joined

    if before is not None and before.discretisation.local is chosen.local:
        return before.mesh
    if isinstance(body, MeshedBody):
        return made_mesh(body)
    if level == "harmonic":
        return mesh_meridian(body, chosen.size, chosen.local)
    kind = symmetry(body)
    if kind == "staged":
        return mesh_joined(body, chosen.size)
    own = {"round": mesh_revolved, "cyclic": mesh_sector, "asymmetric": mesh_whole_body}
    return own[kind](body, chosen.size, chosen.local)


def reduce_meshed(
    scene: Scene,
    plan: Plan,
    body: Body | MeshedBody,
    mesh: Mesh | None,
    chosen: Discretisation,
    comm: Any,
) -> BodyResult | None:
    """Reduce a meshed body.

    `mesh`: on rank 0 of the communicator, None elsewhere. `chosen`: the discretisation that the
    mesh was made with. `comm`: communicator; every rank of it must call. Returns BodyResult, or
    None on ranks without a mesh. Raises ReductionError: see `solidwhirl.reduction.reduce_body`.
    """
    from solidwhirl.reduction import ReductionError, reduce_body

    own = plan.bodies[body.name]
    request = request_of(scene, plan, body, chosen)
    record = _provenance(scene, own, chosen, mesh) if mesh is not None else None
    place = f"{'mesh_bodies' if isinstance(body, MeshedBody) else 'bodies'}.{body.name}"
    try:
        element, work = reduce_body(body, mesh, comm, request, comm.bcast(record))
    except ReductionError as error:
        text = f"{place}: {error}{_whose_speed(scene, own, body.name, str(error))}"
        raise type(error)(text) from error
    except MemoryError as error:
        raise MemoryShortageError(
            f"{place}: the memory was not enough for its reduction"
        ) from error
    if mesh is None:
        return None
    return BodyResult(
        body=body,
        discretisation=chosen,
        mesh=mesh,
        element=element,
        properties=closed_form(body),
        work=work,
    )


def _whose_speed(scene: Scene, own: BodyPlan, name: str, message: str) -> str:
    """Where a speed comes from that a body is refused at, if not from the scene's own speeds."""
    if not message.startswith(f"at {own.maximum_speed_rad_s * 30.0 / np.pi:.6g} rpm "):
        return ""
    source = top_speed_text(scene, name)
    return f"; {source}" if source else ""


def request_of(
    scene: Scene, plan: Plan, body: Body | MeshedBody, chosen: Discretisation
) -> ReductionRequest:
    """Return what is asked of the reduction of a body."""
    from solidwhirl.reduction import ReductionRequest

    own = plan.bodies[body.name]
    other = own.shape in ("round", "any")  # matrices of a whole mesh in fixed axes
    estimates = ("mode_truncation",) if other else ("mode_truncation", "mesh")
    return ReductionRequest(
        level=own.level,
        orders=own.orders,
        components=own.components,
        interface_components=own.interface_components,
        degree=chosen.degree,
        modes=chosen.modes,
        maximum_speed_rad_s=own.maximum_speed_rad_s,
        gyroscopic=plan.on("gyroscopic") and own.shape != "any",
        centrifugal=plan.on("stress_stiffening") and own.shape != "any",
        speeds_between_rad_s=chosen.speeds_between_rad_s,
        estimates=estimates if scene.model.estimates == "on" else (),
        solver=own.solver,
        neighbours=scene.model.stage_joints == "neighbours",
        spin_tolerance=0.0 if chosen.modes_fixed else _SPIN_SHARE * scene.model.accuracy,
        accuracy=scene.model.accuracy,
    )


def solver_text(plan: BodyPlan, mesh: Mesh | None, comm: Any) -> str:
    """Return why a body is solved iteratively, as far as its mesh tells; nothing if it is not.

    `mesh`: on rank 0 of the communicator. `comm`: communicator; every rank of it must call.
    """
    if None not in plan.solved_orders or plan.solver == "direct":
        return ""
    if plan.solver == "iterative":
        return ", iteratively as the scene says"
    from solidwhirl.reduction import expected_factor

    nodes = comm.bcast(0 if mesh is None else len(mesh.points))
    found = expected_factor(3 * nodes, comm)
    if found.fits or found.available_bytes is None:
        return ""
    return (
        f", iteratively: a factor would need about {found.needed_bytes / 2.0**30:.3g} GiB, "
        f"{found.available_bytes / 2.0**30:.3g} GiB are available"
    )


def closed_form(body: Body | MeshedBody) -> MassProperties | None:
    """Mass properties of a profile in closed form; None of a body that has none."""
    return None if isinstance(body, MeshedBody) else mass_properties(body)


def _provenance(
    scene: Scene, own: BodyPlan, chosen: Discretisation, mesh: Mesh
) -> Mapping[str, Any]:
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
            "follows_error_estimate": chosen.local is not None,
            "minimum_scaled_jacobian": mesh.quality.minimum_scaled_jacobian,
            "sectors": None if mesh.sector is None else mesh.sector.count,
        },
        "element_order": chosen.degree,
        "modes": chosen.modes,
        "speeds_between_rad_s": list(chosen.speeds_between_rad_s),
        "effects": scene.effects.model_dump(),
        "packages": package_versions(),
    }
