"""From a body of revolution to a second-order mesh of its meridian or of the whole solid."""

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.files import write_gmsh, write_vtu
from solidwhirl.meshing.meridian import MINIMUM_SCALED_JACOBIAN, mesh_meridian
from solidwhirl.meshing.prediction import predict_unknowns
from solidwhirl.meshing.quality import scaled_jacobians, straighten
from solidwhirl.meshing.records import (
    FloatArray,
    IntArray,
    LocalSize,
    Mesh,
    MeshQuality,
    MeshSize,
)
from solidwhirl.meshing.refinement import CORNER_RATE, refined_size
from solidwhirl.meshing.solid import mesh_solid

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
    "mesh_meridian",
    "mesh_solid",
    "predict_unknowns",
    "refined_size",
    "scaled_jacobians",
    "straighten",
    "write_gmsh",
    "write_vtu",
]
