"""How many modes: one, a double one that must not be cut, 500, more than there are; free bodies."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import scipy.linalg
from builders_body import STEEL, even, meshed, plane, reduced, section, tube
from references_body import timoshenko_free_hz

from solidwhirl.geometry import Body, Interface
from solidwhirl.meshing import MeshSize
from solidwhirl.reduction import ReductionError
from solidwhirl.rotordyn import Rotor, assemble, modes_at_speed

SIZES = {"harmonic": even(0.02), "solid": even(0.1, 8)}
LATERAL = ("ux", "uy")


def _rod(*planes: Interface, length_m: float = 0.4) -> Body:
    return tube(length_m, 0.0, 0.02, *planes)


def _one_mode(level: str) -> float:
    """Free bending frequency with one pair of modes against 12 pairs."""
    body = _rod(plane("a", 0.0), plane("b", 0.4))
    found = [reduced(body, level, SIZES[level], modes=n)[0].free_frequencies_hz for n in (1, 12)]
    return abs(float(found[0][0] / found[1][0]) - 1.0)


def _cut_pairs(level: str) -> float:
    """Double modes of which one member is missing, over one to six modes."""
    body = _rod(plane("a", 0.0), plane("b", 0.4))
    cut = 0
    for modes in (1, 2, 4) if level == "solid" else (1, 2, 3, 4, 5, 6):
        found = reduced(body, level, SIZES[level], modes=modes)[0].fixed_interface_frequencies_hz
        first, second = found[0::2], found[1::2]
        if len(first) != len(second) or len(found) != 2 * modes:
            cut += 1
        else:
            cut += int(np.sum(np.abs(second / first - 1.0) > 1e-8))
    return float(cut)


def _held_dense(body: Body, level: str, size: MeshSize, count: int) -> np.ndarray:
    """Fixed-interface frequencies from dense matrices, one family or all odd orders [Hz]."""
    from mpi4py import MPI

    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
    from solidwhirl.reduction.solvers.vectors import apply

    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=False,
        components={i.name: LATERAL for i in body.interfaces},
        lateral_only=True,
    )
    order = 1 if level == "harmonic" else None
    operators = build_operators(
        body, meshed(body, level, size), MPI.COMM_SELF, order=order, degree=2, effects=effects
    )
    held = scipy.linalg.null_space(operators.coupling.rows.T)
    one = np.eye(len(held))
    k, m = (held.T @ apply(a, one) @ held for a in (operators.stiffness, operators.mass))
    values = scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=[0, count - 1])
    return np.asarray(np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi))


def _five_hundred() -> float:
    """500 pairs of modes of a mesh with 600 against dense eigenvalues."""
    body = _rod(plane("a", 0.0), plane("b", 0.4))
    size = even(0.02)
    found = reduced(body, "harmonic", size, modes=500)[0].fixed_interface_frequencies_hz[::2]
    dense = _held_dense(body, "harmonic", size, 500)
    return float(np.abs(found / dense - 1.0).max()) if len(found) == 500 else np.inf


def _many_of_a_solid() -> float:
    """6 pairs of a solid: modes of dense eigenvalues that are not found, of order 1."""
    body = _rod(plane("a", 0.0), plane("b", 0.2), length_m=0.2)
    size = even(0.2, 4)
    found = reduced(body, "solid", size, modes=6)[0].fixed_interface_frequencies_hz
    dense = _held_dense(body, "solid", size, 3 * len(found))
    return max(float(np.abs(dense / f - 1.0).min()) for f in found)


def _too_many(level: str) -> float:
    """Requests for more modes than the mesh has that are not refused with that number."""
    body = tube(0.05, 0.0, 0.05, plane("a", 0.0))
    size = even(0.2) if level == "harmonic" else even(0.4, 4)
    wrong = 0
    for modes in (2000, 5000):
        try:
            reduced(body, level, size, modes=modes)
            wrong += 1
        except ReductionError as error:
            found = re.search(r"the body can have (\d+) on this mesh", str(error))
            wrong += found is None
    return float(wrong)


def _rigid_pairs(level: str) -> float:
    """Stiffness of rigid motions over the first elastic one: no, one, two interfaces."""
    worst = 0.0
    for planes in ((), (plane("a", 0.1),), (plane("a", 0.1), plane("b", 0.3))):
        element = reduced(_rod(*planes), level, SIZES[level], components=LATERAL, modes=2)[0]
        if not element.rigid_body_present[[0, 1, 3, 4]].all():
            return np.inf
        values = scipy.linalg.eigvalsh(element.stiffness, element.mass)
        order = np.sort(np.abs(values))
        worst = max(worst, float(order[3] / order[4]))
    return worst


def _split_pairs(level: str) -> float:
    """Largest relative split of double free frequencies."""
    found = reduced(_rod(), level, SIZES[level], components=(), modes=3)[0].free_frequencies_hz
    return float(np.abs(found[1::2] / found[0::2] - 1.0).max())


def _free_beam(level: str) -> float:
    """A free body without interfaces against Timoshenko's beam, L/D = 20."""
    element = reduced(_rod(length_m=0.8), level, SIZES[level], components=(), modes=2)[0]
    return abs(float(element.free_frequencies_hz[0]) / timoshenko_free_hz(0.8, 0.02, STEEL) - 1.0)


def _free_spin(level: str) -> float:
    """Nutation of a free spinning rod, Ω Ip / Id; the body is stiff beside it."""
    spin = {"maximum_speed_rad_s": 300.0, "centrifugal": True, "gyroscopic": True}
    element = reduced(_rod(), level, SIZES[level], components=(), modes=2, **spin)[0]
    system = assemble({"rod": Rotor(element=element, speed_ratio=1.0)}, ())
    modes = modes_at_speed(system, 300.0)
    nutation = element.inertia_kg_m2[2, 2] / element.inertia_kg_m2[0, 0] * 300.0 / (2.0 * np.pi)
    return abs(float(modes.frequency_hz[0] / nutation) - 1.0)


def _twins() -> Body:
    """Two equal disks on a shaft that is held in its middle: modes in fours."""
    steel = replace(STEEL, name="steel")
    return Body(
        name="twins",
        sections=(
            section("left", -0.02, 0.0, 0.0, 0.1, steel),
            section("shaft", 0.0, 0.4, 0.0, 0.02, steel),
            section("right", 0.4, 0.42, 0.0, 0.1, steel),
        ),
        interfaces=(plane("middle", 0.2, "rigid"),),
    )


def _equal_units(level: str) -> float:
    """Fixed-interface modes in fours: largest split of a four, or a four that is cut."""
    size = (
        MeshSize(size_m=0.02, corner_size_m=0.005, growth=0.8)
        if level == "harmonic"
        else MeshSize(size_m=0.1, corner_size_m=0.03, growth=1.0, around=8)
    )
    request = {"components": ("ux", "uy", "rx", "ry"), "modes": 2}
    found = reduced(_twins(), level, size, **request)[0].fixed_interface_frequencies_hz
    if len(found) < 4:
        return np.inf
    return float(np.abs(found[:4] / found[0] - 1.0).max())
