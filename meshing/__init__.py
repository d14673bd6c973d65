"""From a body of revolution to a second-order mesh of its meridian or of the whole solid.

A name is imported when it is first asked for: who needs the records waits for no mesher.
"""

from typing import TYPE_CHECKING

from solidwhirl.rotordyn.core.later import import_later

if TYPE_CHECKING:
    from solidwhirl.meshing.errors import MeshingError
    from solidwhirl.meshing.own.files import write_gmsh
    from solidwhirl.meshing.own.meridian import MINIMUM_SCALED_JACOBIAN, mesh_meridian
    from solidwhirl.meshing.own.quality import scaled_jacobians, straighten
    from solidwhirl.meshing.own.refinement import (
        CORNER_RATE,
        meridian_errors,
        refined_sector,
        refined_size,
    )
    from solidwhirl.meshing.own.revolved import mesh_revolved
    from solidwhirl.meshing.own.solid import mesh_solid
    from solidwhirl.meshing.records import (
        FloatArray,
        IntArray,
        LocalSize,
        Mesh,
        MeshQuality,
        MeshSize,
        Sector,
    )

__all__ = [
    "CORNER_RATE",
    "MINIMUM_SCALED_JACOBIAN",
    "FloatArray",
    "IntArray",
    "LocalSize",
    "Mesh",
    "MeshQuality",
    "MeshSize",
    "MeshingError",
    "Sector",
    "meridian_errors",
    "mesh_meridian",
    "mesh_revolved",
    "mesh_solid",
    "refined_sector",
    "refined_size",
    "scaled_jacobians",
    "straighten",
    "write_gmsh",
]

import_later(__name__)
