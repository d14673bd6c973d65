"""Bodies, meshes and reductions that the cases of single bodies share."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from reduced import reduced_to
from shapes import STEEL, section
from shapes import body as body_of

from solidwhirl.geometry import Body, Interface, Material
from solidwhirl.meshing import Mesh, MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.reduction import ReductionWork
from solidwhirl.rotordyn import Superelement

FloatArray = NDArray[np.float64]


def tube(
    length_m: float,
    inner_m: float,
    outer_m: float,
    *planes: Interface,
    material: Material = STEEL,
) -> Body:
    """Body of one section that starts at z = 0; a rod, a tube, a ring or a disk."""
    return body_of(section("part", 0.0, length_m, inner_m, outer_m, material), interfaces=planes)


def even(size_m: float, around: int = 16) -> MeshSize:
    """One element size everywhere."""
    return MeshSize(size_m=size_m, corner_size_m=size_m, around=around)


def meshed(body: Body, level: str, size: MeshSize) -> Mesh:
    """Mesh of a level."""
    if level == "harmonic":
        return mesh_meridian(body, size)
    # as fine along the meridian as `around` is along the circumference
    edge = 2.0 * np.pi * max(max(s.outer_radius_m) for s in body.sections) / size.around
    corner = min(size.corner_size_m, edge)
    return mesh_revolved(body, replace(size, size_m=min(size.size_m, edge), corner_size_m=corner))


def reduced(
    body: Body, level: str, size: MeshSize, **request: Any
) -> tuple[Superelement, ReductionWork]:
    """Mesh and reduce a body; lateral motion at rest unless the request says otherwise."""
    return reduced_to(body, level, size, **({"modes": 4} | request))


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
