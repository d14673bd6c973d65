"""Rotors and systems that the hard cases of assembled systems share."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial

import numpy as np
from reduced import reduced_to
from scipy.linalg import eigh
from shapes import body as body_of
from shapes import plane, section

from solidwhirl.meshing import MeshSize
from solidwhirl.rotordyn import (
    AssembledSystem,
    Bearing,
    Disk,
    End,
    Rotor,
    Superelement,
    assemble,
    beam_superelement,
    rigid_superelement,
)
from solidwhirl.rotordyn.stability.intervals import unstable_intervals

LATERAL = ("ux", "uy", "rx", "ry")
STEEL = (2e11, 0.3, 7800.0)


def ground(body, interface, kx, ky=None, cx=0.0, cy=None, **options) -> Bearing:
    """Bearing to the ground, diagonal in x and y."""
    return Bearing(
        name=f"{body}.{interface}",
        first=End(body=body, interface=interface),
        stiffness_n_per_m=np.diag([kx, kx if ky is None else ky]),
        damping_n_s_per_m=np.diag([cx, cx if cy is None else cy]),
        **options,
    )


def joint(first, second, stiffness=0.0, **options) -> Bearing:
    """Bearing between two ends given as (body, interface)."""
    return Bearing(
        name=f"{'.'.join(first)}-{'.'.join(second)}",
        first=End(body=first[0], interface=first[1]),
        second=End(body=second[0], interface=second[1]),
        stiffness_n_per_m=stiffness * np.eye(2),
        **options,
    )


def pinned(body, interface, motions=("ux", "uy")) -> Bearing:
    """Exact support of some motions."""
    return Bearing(
        name=f"{body}.{interface}", first=End(body=body, interface=interface), rigid=motions
    )


def engine(bodies: Mapping[str, Superelement], bearings, ratios=None) -> AssembledSystem:
    """Assemble bodies, all at the speed Ω unless their ratio is given."""
    ratios = ratios or {}
    rotors = {
        name: Rotor(element=e, speed_ratio=ratios.get(name, 1.0)) for name, e in bodies.items()
    }
    return assemble(rotors, tuple(bearings))


def hub(mass_kg=10.0, polar_kg_m2=0.1, diametral_kg_m2=0.05, name="disk") -> Superelement:
    """Rigid disk at z = 0 with ux, uy, rx, ry at the interface "hub"."""
    inertia = [diametral_kg_m2, diametral_kg_m2, polar_kg_m2]
    return rigid_superelement(name, mass_kg, np.zeros(3), inertia, {"hub": 0.0}, LATERAL)


@cache
def shaft(name="shaft", elements=6, length_m=0.6, radius_m=0.02) -> Superelement:
    """Steel shaft with two bearing planes "a", "b" at its ends and a disk at a third of it."""
    disk = Disk(
        name="disk", position_m=length_m / 3, mass_kg=12.0, diametral_kg_m2=0.07, polar_kg_m2=0.13
    )
    stations = np.linspace(0.0, length_m, elements + 1)
    ends = {"a": 0.0, "b": length_m}
    return beam_superelement(name, stations, radius_m, 0.0, STEEL, ends, [disk])


@cache
def reduced_body(level: str) -> Superelement:
    """Steel shaft with a wheel, reduced from a coarse mesh with spin effects to 3000 rad/s."""
    return _reduced(level, "rotor", LATERAL, (1,), 3000.0, wheel=True)


@cache
def reduced_rod(level: str) -> Superelement:
    """Slender steel rod with axial motion and torsion, to 13 000 rad/s, past its torsion."""
    return _reduced(level, "rod", (*LATERAL, "uz", "rz"), (0, 1), 13_000.0, wheel=False)


# Bodies by their names in cases.csv, made when they are asked for.
BODIES = {
    "shaft": shaft,
    **{f"{level}-body": partial(reduced_body, level) for level in ("harmonic", "solid")},
    **{f"{level}-rod": partial(reduced_rod, level) for level in ("harmonic", "solid")},
}


def _reduced(level, name, components, orders, speed_rad_s, wheel) -> Superelement:
    length = 0.4 if wheel else 1.0
    sections = [section("shaft", 0.0, length, 0.0, 0.02)]
    if wheel:
        sections.append(section("wheel", 0.145, 0.175, 0.02, 0.12))
    body = body_of(*sections, interfaces=(plane("a", 0.0), plane("b", length)), name=name)
    # around = 8 is the coarsest at which all modes of the wheel's basis come in pairs
    size = MeshSize(size_m=0.1, corner_size_m=0.05, growth=2.0, around=8 if wheel else 4)
    spin = {"maximum_speed_rad_s": speed_rad_s, "gyroscopic": True, "centrifugal": True}
    return reduced_to(body, level, size, orders=orders, components=components, modes=6, **spin)[0]


def free_rad_s(element: Superelement) -> np.ndarray:
    """Return the elastic frequencies of a free body at rest, rad/s, rising."""
    values = eigh(element.stiffness, element.mass, eigvals_only=True)
    return np.sqrt(values[int(element.rigid_body_present.sum()) :])


def first_window(system, speed_max_rad_s):
    """The unstable interval that begins first above rest, None if nothing grows."""
    return next(iter(unstable_intervals(system, 0.0, speed_max_rad_s)), None)


def refused(attempts) -> int:
    """Number of settings that are NOT refused with one of the project's own errors."""
    from solidwhirl.rotordyn import AnalysisError, AssemblyError, SuperelementError

    accepted = 0
    for attempt in attempts:
        try:
            attempt()
        except (AnalysisError, AssemblyError, SuperelementError):
            continue
        accepted += 1
    return accepted
