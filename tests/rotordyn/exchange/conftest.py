"""Bodies that are written in foreign formats, and their modes in the inertial frame."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

# the readers of foreign formats and other helpers beside the tests
sys.path.insert(0, str(Path(__file__).parent))
from shapes import body, plane, section

from solidwhirl.rotordyn import Disk, beam_superelement

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.fixture(scope="session")
def disk_shaft():
    """Steel shaft with a disk off its middle and two interfaces; with axial motion and torsion."""
    return beam_superelement(
        "rotor",
        np.linspace(0.0, 0.4, 5),
        0.02,
        0.0,
        (2.1e11, 0.3, 7850.0),
        {"front": 0.0, "rear": 0.4},
        (Disk(name="disk", position_m=0.15, mass_kg=5.0, polar_kg_m2=0.04, diametral_kg_m2=0.021),),
        components=("ux", "uy", "uz", "rx", "ry", "rz"),
    )


@pytest.fixture(scope="session")
def lateral_shaft():
    """The same kind of shaft, hollow, without axial motion and torsion, the disk at its end."""
    return beam_superelement(
        "overhung",
        np.linspace(0.0, 0.6, 7),
        np.linspace(0.03, 0.02, 6),
        0.01,
        (2.1e11, 0.3, 7850.0),
        {"a": 0.1, "b": 0.4},
        (Disk(name="disk", position_m=0.6, mass_kg=4.0, polar_kg_m2=0.03, diametral_kg_m2=0.016),),
    )


@pytest.fixture(scope="session")
def harmonic_rotor():
    """Small solid rotor reduced from its meridian, orders 0 and 1 (needs DOLFINx)."""
    return reduced_rotor((0, 1), ("ux", "uy", "uz", "rx", "ry", "rz"))


@pytest.fixture(scope="session")
def pinned_rotor():
    """The same rotor for bearings that hold ux and uy alone: no coordinates besides."""
    return reduced_rotor((1,), ("ux", "uy"))


def reduced_rotor(orders, components):
    """Mesh and reduce a shaft with a disk."""
    from mpi4py import MPI

    from solidwhirl.meshing import MeshSize, mesh_meridian
    from solidwhirl.reduction import ReductionRequest, reduce_body

    solid = body(
        section("shaft", 0.0, 0.4, 0.0, 0.02),
        section("disk", 0.145, 0.175, 0.02, 0.12),
        interfaces=(plane("front", 0.0), plane("rear", 0.4)),
        name="solid",
    )
    request = ReductionRequest(
        level="harmonic",
        orders=orders,
        components=components,
        degree=2,
        modes=4,
        maximum_speed_rad_s=1500.0,
        gyroscopic=True,
        centrifugal=True,
    )
    mesh = mesh_meridian(solid, MeshSize(size_m=0.02, corner_size_m=0.006, growth=0.8))
    element, _ = reduce_body(solid, mesh, MPI.COMM_SELF, request, {})
    return element
