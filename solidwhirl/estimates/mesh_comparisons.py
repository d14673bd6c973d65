"""The error of a mesh that was made of a STEP file, from a coarser one of the same geometry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from solidwhirl.bodies.reduction import BodyResult, reduce_meshed
from solidwhirl.estimates.comparators import Assemble, Comparison
from solidwhirl.meshing import MeshingError
from solidwhirl.meshing.imported.records import MeshedBody
from solidwhirl.model.mesh_bodies import described, made_mesh
from solidwhirl.model.plan_records import Plan
from solidwhirl.rotordyn import Superelement
from solidwhirl.scene.records import Scene

# Elements of the coarser mesh over those of the own, and the slowest rate at which errors of
# frequencies fall with them: re-entrant edges, and rings of few elements.
_COARSER, _RATE = 1.5, 0.8
_FEWEST = 4


def step_comparisons(
    scene: Scene,
    plan: Plan,
    results: Mapping[str, BodyResult],
    elements: Mapping[str, Superelement],
    assemble: Assemble,
) -> tuple[Comparison, ...]:
    """Compare bodies from STEP files with coarser meshes of themselves.

    Parameters
    ----------
    scene, plan
        As the run has them.
    results
        Bodies that were reduced.
    elements
        All bodies of the engine.
    assemble
        Makes the engine of elements.

    Returns
    -------
    Part "mesh"; empty where no body is from a STEP file, or no coarser mesh can be had.

    Notes
    -----
    With e ~ h^r the error of the own mesh is the difference over 1.5^r - 1 (Richardson); r is taken
    as that of the worst places, so that it is over- rather than underestimated.
    """
    own, coarser = {}, {}
    for name, result in results.items():
        body = result.body
        if not isinstance(body, MeshedBody) or body.request.step is None:
            continue
        element = _coarser(scene, plan, body, result)
        if element is not None:
            own[name], coarser[name] = result.element, element
    if not coarser:
        return ()
    return (
        Comparison(
            part="mesh",
            first=None,
            second=assemble({**elements, **coarser}),
            first_elements=own,
            second_elements=coarser,
            safety=1.0 / (_COARSER**_RATE - 1.0),
        ),
    )


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
    model = scene.model.model_copy(update={"estimates": "off"})
    silent = scene.model_copy(update={"model": model})
    try:
        mesh = made_mesh(asked)
        found = reduce_meshed(
            silent, plan, described(asked, mesh), mesh, result.discretisation, MPI.COMM_SELF
        )
    except (MeshingError, ReductionError):
        return None
    assert found is not None
    return found.element
