"""Bodies meshed and reduced in one call."""

from __future__ import annotations

import scipy.sparse

from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.imported.body import body_of_mesh
from solidwhirl.meshing.imported.records import MeshInterface, MeshRequest
from solidwhirl.meshing.own.whole import whole_mesh
from solidwhirl.reduction import ReductionRequest, reduce_body


def requested(level="harmonic", **changes):
    """A request for lateral motion at rest, changed."""
    usual = {
        "orders": (1,),
        "components": ("ux", "uy"),
        "degree": 2,
        "modes": 8,
        "maximum_speed_rad_s": 0.0,
        "gyroscopic": False,
        "centrifugal": False,
    }
    return ReductionRequest(level=level, **(usual | changes))


def reduced_to(body, level="harmonic", size=None, mesh=None, comm=None, **request):
    """Superelement of a body and the ledger of its reduction."""
    from mpi4py import MPI

    comm = comm or MPI.COMM_SELF
    if mesh is None and comm.rank == 0:
        make = mesh_meridian if level == "harmonic" else mesh_revolved
        mesh = make(body, size or MeshSize(size_m=0.02, corner_size_m=0.002, growth=0.8))
    return reduce_body(body, mesh, comm, requested(level, **request), {})


def whole_of(body, size):
    """The mesh of all of a body of one material, and the body as one that comes from a file."""
    mesh = whole_mesh(mesh_revolved(body, size))[0]
    request = MeshRequest(
        path="",
        digest="",
        unit_m=1.0,
        origin=(0.0, 0.0, 0.0),
        direction=(0.0, 0.0, 1.0),
        material=mesh.materials[0],
        interfaces=tuple(
            MeshInterface(name=i.name, coupling=i.coupling, group=i.name) for i in body.interfaces
        ),
        shape="round",
    )
    return body_of_mesh(body.name, request, mesh), mesh


def sparse(matrix):
    """PETSc matrix, or operator of a sector, as one of scipy."""
    matrix = matrix.folded() if hasattr(matrix, "folded") else matrix
    indptr, indices, data = matrix.getValuesCSR()
    return scipy.sparse.csr_matrix((data, indices, indptr), shape=matrix.getSize())
