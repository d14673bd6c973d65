"""Other models of the same engine, whose results differ from its own by an error to be estimated.

Meridians and sectors carry error forms and need none of these. A whole mesh made of a STEP file is
held against a coarser one; beams against other beams of the same profile; and how interfaces are
coupled, which is a choice of the model, against the other choice.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from solidwhirl.bodies.couplings import couplings_compared
from solidwhirl.bodies.reduction import (
    BodyResult,
    Discretisation,
    first_discretisation,
    mesh_body,
    reduce_meshed,
)
from solidwhirl.geometry import Body, GeometryError
from solidwhirl.meshing import MeshingError
from solidwhirl.meshing.imported.records import MeshedBody
from solidwhirl.model.mesh_bodies import described, made_mesh
from solidwhirl.model.plan_records import BodyPlan, Plan
from solidwhirl.rotordyn import AssembledSystem, Superelement
from solidwhirl.scene.records import Scene

# Elements of the coarser mesh of a STEP file over those of the own, and the slowest rate at which
# errors of frequencies fall with them: re-entrant edges, and rings of few elements.
_COARSER, _RATE = 1.5, 0.8
_FEWEST = 4


@dataclass(frozen=True, kw_only=True)
class OtherBodies:
    """Bodies of two models that differ by one part of the error, without the engine around them.

    `first` None: the scene's own bodies. `safety`: factor on the difference.
    """

    part: str
    first: Mapping[str, Superelement] | None = None
    second: Mapping[str, Superelement]
    safety: float = 1.0


class Comparison(NamedTuple):
    """Two models whose results differ by one part of the error; `first` None for the scene's own.

    The elements are those that differ from the scene's own; `safety` is a factor on the difference.
    """

    part: str
    first: AssembledSystem | None
    second: AssembledSystem
    first_elements: Mapping[str, Superelement]
    second_elements: Mapping[str, Superelement]
    safety: float = 1.0


def beam_comparison(finer: Mapping[str, Superelement]) -> tuple[OtherBodies, ...]:
    """Compare beams with ones half as long.

    `finer`: bodies made of beams, with beams half as long; the error of frequencies falls with the
    square of the length, so 4/3 of the difference is the error.
    """
    return (OtherBodies(part="mesh", second=finer, safety=4.0 / 3.0),) if finer else ()


def coupling_comparison(scene: Scene, bodies: Mapping[str, Body]) -> tuple[OtherBodies, ...]:
    """Compare rigid with distributing coupling of the interfaces that joints act on.

    Part "interface_coupling", on the harmonic level, on coarse meshes and without blades, holes and
    slots; empty where no joint acts on a meshed body, or the other coupling can not be had
    (surfaces that touch).
    """
    pair = couplings_compared(scene, bodies)
    if pair is None:
        return ()
    from solidwhirl.reduction import ReductionError

    first, second = {}, {}
    for name, body in pair.flipped.items():
        chosen = first_discretisation(pair.scene, pair.plan, name)
        try:
            second[name] = _unestimated(pair.scene, pair.plan, body, chosen)
            first[name] = _unestimated(pair.scene, pair.plan, pair.as_is[name], chosen)
        except (ReductionError, GeometryError, MeshingError):
            second.pop(name, None)  # the other coupling is impossible there: nothing to compare
    if not second:
        return ()
    return (OtherBodies(part="interface_coupling", first=first, second=second),)


def _unestimated(scene: Scene, plan: Plan, body: Body, chosen: Discretisation) -> Superelement:
    """The element of a body without an error estimate of its own."""
    from mpi4py import MPI

    mesh = mesh_body(body, plan.bodies[body.name].level, chosen)
    result = reduce_meshed(_without_estimates(scene), plan, body, mesh, chosen, MPI.COMM_SELF)
    assert result is not None
    return result.element


def _without_estimates(scene: Scene) -> Scene:
    model = scene.model.model_copy(update={"estimates": "off"})
    return scene.model_copy(update={"model": model})


def step_comparisons(
    scene: Scene, plan: Plan, results: Mapping[str, BodyResult]
) -> tuple[OtherBodies, ...]:
    """Compare whole meshes of STEP files with coarser ones of the same body: part "mesh".

    Empty where there is none, or no coarser mesh can be had.

    With e ~ h^r the error of the own mesh is the difference over 1.5^r - 1 (Richardson); r is taken
    as that of the worst places, so that it is over- rather than underestimated.
    """
    coarser = {}
    for name, result in results.items():
        body = result.body
        if not is_compared(body, plan.bodies[name]):
            continue
        assert isinstance(body, MeshedBody)
        element = _coarser(scene, plan, body, result)
        if element is not None:
            coarser[name] = element
    if not coarser:
        return ()
    return (OtherBodies(part="mesh", second=coarser, safety=1.0 / (_COARSER**_RATE - 1.0)),)


def is_compared(body: Body | MeshedBody, plan: BodyPlan) -> bool:
    """Whether the error of a body's mesh is found by comparison, after the last round."""
    if not isinstance(body, MeshedBody) or body.request.step is None:
        return False
    return None in plan.solved_orders and body.request.shape != "asymmetric"


def _coarser(scene: Scene, plan: Plan, body: MeshedBody, result: BodyResult) -> Superelement | None:
    """The body on a coarser mesh; None where it can't be had."""
    from mpi4py import MPI

    from solidwhirl.reduction import ReductionError

    size = body.request.step
    assert size is not None
    step = replace(
        size,
        size_m=_COARSER * size.size_m,
        smallest_m=_COARSER * size.smallest_m,
        around=max(round(size.around / _COARSER), _FEWEST),
    )
    asked = replace(body, request=replace(body.request, step=step), mass=None, roundness=None)
    silent, chosen = _without_estimates(scene), result.discretisation
    try:
        mesh = made_mesh(asked)
        found = reduce_meshed(silent, plan, described(asked, mesh), mesh, chosen, MPI.COMM_SELF)
    except (MeshingError, ReductionError):
        return None
    assert found is not None
    return found.element
