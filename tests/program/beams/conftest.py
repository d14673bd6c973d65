"""Bodies for the tests of the beam level, and their frequencies on the harmonic level."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from solidwhirl.meshing import MeshSize, mesh_meridian


def body_of(*pieces, planes, fillet=0.0, disks=()):
    """A body of (name, start, end, inner, outer[, material]) with section interfaces."""
    interfaces = [
        shapes.interface(f"p{k}", "section", z, None, *rest) for k, (z, *rest) in enumerate(planes)
    ]
    sections = (shapes.section(*piece) for piece in pieces)
    return shapes.body(*sections, interfaces=interfaces, fillet=fillet, disks=disks)


def disk_body(width, radius, *, shaft=0.02, length=0.4, at=0.16):
    return body_of(
        ("shaft", 0.0, length, 0.0, shaft),
        ("disk", at - width / 2, at + width / 2, shaft, radius),
        planes=[(0.0,), (length,)],
    )


def uniform(radius, length, inner=0.0):
    return body_of(("shaft", 0.0, length, inner, radius), planes=[(0.0,), (length,)])


BODIES = {
    "reference": disk_body(0.03, 0.15, at=0.16),
    "thin disk": disk_body(0.008, 0.15),
    "thick disk": disk_body(0.06, 0.15),
    "small disk": disk_body(0.02, 0.06),
    "collar": disk_body(0.06, 0.06),
    "slender": disk_body(0.02, 0.1, shaft=0.01, length=1.0, at=0.4),
    "overhung": disk_body(0.02, 0.12, at=0.39),
    "uniform": uniform(0.02, 0.6),
    "stubby": uniform(0.04, 0.4),
    "step": body_of(
        ("a", 0.0, 0.15, 0.0, 0.02),
        ("b", 0.15, 0.3, 0.0, 0.025),
        ("c", 0.3, 0.4, 0.0, 0.02),
        planes=[(0.0,), (0.4,)],
    ),
    "large step": body_of(
        ("a", 0.0, 0.25, 0.0, 0.015), ("b", 0.25, 0.5, 0.0, 0.045), planes=[(0.0,), (0.5,)]
    ),
    "hollow step": body_of(
        ("a", 0.0, 0.2, 0.015, 0.02),
        ("b", 0.2, 0.3, 0.015, 0.03),
        ("c", 0.3, 0.5, 0.015, 0.02),
        planes=[(0.0,), (0.5,)],
    ),
    "taper": body_of(("a", 0.0, 0.5, 0.0, (0.015, 0.03)), planes=[(0.0,), (0.5,)]),
    "tube": uniform(0.05, 0.5, inner=0.048),
    "cone": body_of(
        ("a", 0.0, 0.1, 0.027, 0.03),
        ("b", 0.1, 0.3, (0.027, 0.077), (0.03, 0.08)),
        ("c", 0.3, 0.5, 0.077, 0.08),
        planes=[(0.0,), (0.5,)],
    ),
    "drum": body_of(
        ("shaft", 0.0, 0.6, 0.0, 0.02),
        ("web1", 0.2, 0.208, 0.02, 0.1),
        ("web2", 0.392, 0.4, 0.02, 0.1),
        ("drum", 0.2, 0.4, 0.1, 0.105),
        planes=[(0.0,), (0.6,)],
    ),
    "rim": body_of(
        ("shaft", 0.0, 0.4, 0.0, 0.02),
        ("hub", 0.13, 0.19, 0.02, 0.04),
        ("web", 0.152, 0.168, 0.04, 0.13),
        ("rim", 0.135, 0.185, 0.13, 0.15),
        planes=[(0.0,), (0.4,)],
    ),
}


def harmonic_element(body, *, top=0.0, modes=6, orders=(1,), components=("ux", "uy")):
    """The body on the harmonic level, converged to about 5e-4."""
    from mpi4py import MPI

    from solidwhirl.reduction import ReductionRequest, reduce_body

    thin = min(
        min(s.end_m - s.start_m, np.subtract(s.outer_radius_m, s.inner_radius_m).max())
        for s in body.sections
    )
    length = max(s.end_m for s in body.sections) - min(s.start_m for s in body.sections)
    size = MeshSize(size_m=0.25 * length, corner_size_m=0.05 * thin, growth=0.8, around=12)
    request = ReductionRequest(
        level="harmonic",
        orders=orders,
        components=components,
        degree=3,
        modes=modes,
        maximum_speed_rad_s=top,
        gyroscopic=top > 0.0,
        centrifugal=top > 0.0,
    )
    return reduce_body(body, mesh_meridian(body, size), MPI.COMM_SELF, request, {})[0]


@pytest.fixture(scope="session", name="body_of")
def _body_of():
    return body_of


@pytest.fixture(scope="session", name="beam_bodies")
def _beam_bodies():
    return BODIES


@pytest.fixture(scope="session", name="harmonic")
def _harmonic():
    """Superelements of the harmonic level by name and largest speed, each made once."""
    made = {}

    def element(name, top=0.0):
        if (name, top) not in made:
            made[name, top] = harmonic_element(BODIES[name], top=top)
        return made[name, top]

    return element


@pytest.fixture(scope="session", name="harmonic_element")
def _harmonic_element():
    return harmonic_element
