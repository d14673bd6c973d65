"""Bodies of a run as analyses of their nodal diameters see them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from solidwhirl.analyses.nodal_diameters.results import CyclicSource
from solidwhirl.bodies.reduction import BodyResult, mesh_body
from solidwhirl.core.stages import Stage, StageName
from solidwhirl.geometry import Body
from solidwhirl.meshing import Mesh
from solidwhirl.pipeline.body_stages import Job
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.nodal_diameters import CyclicBody

# Modes of the basis beyond those that are asked for, whose errors they keep small.
_SPARE = 4


def cyclic_source(job: Job, reduced: Mapping[str, BodyResult], name: str) -> CyclicSource:
    """Return what the cyclic indices of a body are reduced from: its last mesh.

    A body of revolution whose mesh is a solid one gets a meridian. Raises AnalysisError: a mesh of
    a whole that is given, or stages without a common sector.
    """
    found = reduced[name]
    mesh = found.mesh
    if mesh.parts is not None:
        counts = sorted({sector.count for sector in mesh.parts.sectors})
        raise AnalysisError(
            f"body {name!r} is made of parts with {', '.join(map(str, counts))} sectors; nodal "
            "diameters need one count: make a body of one stage and the drum beside it"
        )
    if mesh.dimension == 3 and mesh.sector is None:
        if not isinstance(found.body, Body) or found.body.features:
            raise AnalysisError(
                f"body {name!r} is meshed as a whole; nodal diameters need a body of sections, or "
                "a sector of equal ones"
            )
        mesh = mesh_body(found.body, "harmonic", replace(found.discretisation, local=None))

    def reduce(held: Sequence[str], indices: Sequence[int], modes: int) -> tuple[CyclicBody, Any]:
        return _reduced(job, found, mesh, (held, indices, modes))

    return CyclicSource(
        sectors=mesh.sector.count if mesh.sector else None,
        rigid_disks=tuple((disk.name, disk.interface) for disk in found.body.rigid_disks),
        reduce=reduce,
    )


def _reduced(
    job: Job, found: BodyResult, mesh: Mesh, asked: tuple[Sequence[str], Sequence[int], int]
) -> tuple[CyclicBody, Any]:
    """Reduce on this process alone."""
    from mpi4py import MPI

    from solidwhirl.reduction.body.cyclic_indices import CyclicRequest, reduce_indices

    held, indices, modes = asked
    own, used = job.plan.bodies[found.body.name], found.discretisation
    level = "harmonic" if mesh.dimension == 2 else "solid"
    request = CyclicRequest(
        level=level,
        indices=tuple(indices),
        held=tuple(held),
        degree=used.degree,
        modes=modes + _SPARE,
        maximum_speed_rad_s=own.maximum_speed_rad_s,
        estimates=("mode_truncation", "mesh") if job.scene.model.estimates == "on" else (),
        solver=own.solver,
    )

    def begins(index: int) -> None:
        detail = f", nodal diameter {index} of {min(indices)} to {max(indices)}"
        job.progress(Stage(name=StageName.NODAL_DIAMETER, body=found.body.name, detail=detail))

    return reduce_indices(found.body, mesh, MPI.COMM_SELF, request, begins)
