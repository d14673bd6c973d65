"""Compile the finite element kernels that scenes need, into the compiler's own cache."""

from dataclasses import replace

import numpy as np
from mpi4py import MPI

from solidwhirl.geometry import MATERIALS, Body, Interface, Joint, Section
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.reduction import ReductionRequest, reduce_body
from solidwhirl.reduction.recovery.fields import body_fields
from solidwhirl.reduction.recovery.stresses import StressRecovery
from solidwhirl.reduction.residuals.indicators import MotionSample, element_errors


def warm(level: str, degree: int) -> None:
    """Reduce a small body, which compiles every form of a level and element order."""
    section = Section(
        name="tube",
        start_m=0.0,
        end_m=0.1,
        inner_radius_m=(0.03, 0.03),
        outer_radius_m=(0.05, 0.05),
        material=MATERIALS["steel"],
    )
    ends = tuple(
        Interface(name=name, kind="section", coupling="distributing", start_m=z, end_m=z)
        for name, z in (("a", 0.0), ("b", 0.1))
    )
    body = Body(name="tube", sections=(section,), interfaces=ends)
    if level == "harmonic":
        around = {"inner_radius_m": (0.05, 0.05), "outer_radius_m": (0.07, 0.07)}
        ring = replace(section, name="ring", **around)
        fit = Joint(between=("tube", "ring"), interference_m=1e-4)
        body = replace(body, sections=(section, ring), joints=(fit,))
    size = MeshSize(size_m=0.05, corner_size_m=0.05)
    request = ReductionRequest(
        level=level,
        orders=(1, 0),
        components=("ux", "uy", "uz", "rx", "ry", "rz"),
        degree=degree,
        modes=2,
        maximum_speed_rad_s=100.0,
        gyroscopic=True,
        centrifugal=True,
        estimates=("mode_truncation", "mesh"),
    )
    mesh = (mesh_meridian if level == "harmonic" else mesh_revolved)(body, size)
    element, work = reduce_body(body, mesh, MPI.COMM_SELF, request, {})
    fields = body_fields(body, mesh, request, element)
    StressRecovery(fields).recover(np.ones(element.size), 100.0)
    motion = np.ones(element.size, dtype=complex)
    sample = MotionSample(coordinates=motion, s=100j, speed_rad_s=100.0, weight=1.0)
    for indicators in work.indicators() if work.indicators is not None else ():
        element_errors(indicators, (sample,))


if __name__ == "__main__":
    for order in (2, 3, 4):
        warm("harmonic", order)
    warm("solid", 2)
