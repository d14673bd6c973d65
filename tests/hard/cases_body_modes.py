"""Modes of a coarse solid, double modes, free bodies."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from builders_body import STEEL, even, meshed, plane, reduced, tube
from references_body import timoshenko_free_hz

from solidwhirl.geometry import Body, Interface
from solidwhirl.meshing import MeshSize
from solidwhirl.rotordyn import Rotor, assemble, modes_at_speed

SIZES = {"harmonic": even(0.02), "solid": even(0.1, 8)}
LATERAL = ("ux", "uy")


def _rod(*planes: Interface, length_m: float = 0.4) -> Body:
    return tube(length_m, 0.0, 0.02, *planes)


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


def _many_of_a_solid() -> float:
    """6 pairs of a solid: modes of dense eigenvalues that are not found, of order 1."""
    body = _rod(plane("a", 0.0), plane("b", 0.2), length_m=0.2)
    size = even(0.2, 4)
    found = reduced(body, "solid", size, modes=6)[0].fixed_interface_frequencies_hz
    dense = _held_dense(body, "solid", size, 3 * len(found))
    return max(float(np.abs(dense / f - 1.0).min()) for f in found)


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
