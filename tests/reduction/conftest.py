"""Helpers of the reduction tests."""

from __future__ import annotations

import pytest

from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_solid
from solidwhirl.reduction import ReductionRequest, reduce_body


@pytest.fixture
def reduce_to():
    """Mesh and reduce a body; returns the superelement and the ledger."""
    from mpi4py import MPI

    def reduce(body, level="harmonic", size=None, **request):
        defaults = {
            "orders": (1,),
            "components": ("ux", "uy"),
            "degree": 2,
            "modes": 8,
            "maximum_speed_rad_s": 0.0,
            "gyroscopic": False,
            "centrifugal": False,
        }
        make = mesh_meridian if level == "harmonic" else mesh_solid
        mesh = make(body, size or MeshSize(size_m=0.02, corner_size_m=0.002, growth=0.8))
        asked = ReductionRequest(level=level, **(defaults | request))
        return reduce_body(body, mesh, MPI.COMM_SELF, asked, {})

    return reduce
