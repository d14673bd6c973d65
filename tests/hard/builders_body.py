"""Bodies, meshes and reductions that the cases of single bodies share."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.geometry import Body, Interface, Material, Section
from solidwhirl.meshing import Mesh, MeshSize, mesh_meridian, mesh_solid
from solidwhirl.reduction import ReductionRequest, ReductionWork, reduce_body
from solidwhirl.rotordyn import Superelement

FloatArray = NDArray[np.float64]

STEEL = Material(
    name="steel", density_kg_per_m3=7800.0, youngs_modulus_pa=2.0e11, poissons_ratio=0.3
)


def section(
    name: str, start_m: float, end_m: float, inner_m: float, outer_m: float, material: Material
) -> Section:
    """Section of constant radii."""
    return Section(
        name=name,
        start_m=start_m,
        end_m=end_m,
        inner_radius_m=(inner_m, inner_m),
        outer_radius_m=(outer_m, outer_m),
        material=material,
    )


def plane(name: str, z_m: float, coupling: str = "distributing") -> Interface:
    """Cross-section that becomes an interface."""
    return Interface(
        name=name,
        kind="section",
        coupling=coupling,  # type: ignore[arg-type]
        start_m=z_m,
        end_m=z_m,
    )


def tube(
    length_m: float,
    inner_m: float,
    outer_m: float,
    *planes: Interface,
    material: Material = STEEL,
) -> Body:
    """Body of one section that starts at z = 0; a rod, a tube, a ring or a disk."""
    part = section("part", 0.0, length_m, inner_m, outer_m, material)
    return Body(name="body", sections=(part,), interfaces=planes)


def even(size_m: float, around: int = 16) -> MeshSize:
    """One element size everywhere."""
    return MeshSize(size_m=size_m, corner_size_m=size_m, around=around)


def meshed(body: Body, level: str, size: MeshSize) -> Mesh:
    """Mesh of a level."""
    return mesh_meridian(body, size) if level == "harmonic" else mesh_solid(body, size)


def reduced(
    body: Body, level: str, size: MeshSize, **request: Any
) -> tuple[Superelement, ReductionWork]:
    """Mesh and reduce a body; lateral motion at rest unless the request says otherwise."""
    from mpi4py import MPI

    given = {
        "orders": (1,),
        "components": ("ux", "uy"),
        "degree": 2,
        "modes": 4,
        "maximum_speed_rad_s": 0.0,
        "gyroscopic": False,
        "centrifugal": False,
    }
    asked = ReductionRequest(level=level, **(given | request))
    return reduce_body(body, meshed(body, level, size), MPI.COMM_SELF, asked, {})


def nearest_error(found_hz: FloatArray, expected_hz: FloatArray) -> float:
    """Largest relative distance of an expected frequency from the nearest one found."""
    return max(
        float(np.abs(np.asarray(found_hz) / f - 1.0).min()) for f in np.atleast_1d(expected_hz)
    )


def held_hz(body: Body, level: str, size: MeshSize, **request: Any) -> FloatArray:
    """Fixed-interface frequencies."""
    return np.asarray(reduced(body, level, size, **request)[0].fixed_interface_frequencies_hz)


def free_hz(body: Body, level: str, size: MeshSize, **request: Any) -> FloatArray:
    """Lateral elastic frequencies of the free body, pairs once."""
    return np.asarray(reduced(body, level, size, **request)[0].free_frequencies_hz)[::2]
