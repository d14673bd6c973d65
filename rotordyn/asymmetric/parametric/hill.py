"""Hill's method: harmonics of a periodic system as one system with constant matrices.

q = e^{λt} Σ_k a_k e^{ikgΩt} with the stride g; with μ_k = λ + ikgΩ the row of a_k is

    μ_k² M a_k + Σ_m [μ_m V_{(k−m)g} + K_{(k−m)g}] a_m = 0,

which is λ² M + λ V + K for all a_k together. λ and λ + igΩ are the same motion, so that every one
appears once for each harmonic, and those at the ends of the expansion are not accurate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from solidwhirl.rotordyn.assembly.system import Side
from solidwhirl.rotordyn.asymmetric.parametric.block_paths import Block, Coefficients
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, Matrix

# Distance of the mean harmonic of a motion from the zeroth up to which it counts: half, and a
# margin for those that have two equal ones.
_CENTRAL = 0.6


def hill_block(system: PeriodicSystem, order: int, basis: FloatArray | None = None) -> Block:
    """Return the motions of a periodic system with the harmonics −order to order.

    A system whose matrices are constant needs none: its order is 0. `basis`: motions (n, r) that
    the system is held to; None leaves it all.
    """
    order = order if system.stride else 0
    shifts = 1j * system.stride * np.arange(-order, order + 1)
    mass = system.mass if basis is None else basis.T @ system.mass @ basis
    laid = partial(_laid, order, system.stride, len(mass))

    def held(parts: Mapping[int, Matrix]) -> Mapping[int, Matrix]:
        return parts if basis is None else {h: basis.T @ a @ basis for h, a in parts.items()}

    def at(speed: float) -> Coefficients:
        velocity, stiffness = (held(part) for part in system.at(speed))
        rate = shifts * speed
        return Coefficients(
            laid(velocity) + _diagonal(2.0 * rate, mass),
            laid(stiffness) + laid(velocity, rate) + _diagonal(rate**2, mass),
        )

    def slopes(speed: float, side: Side) -> Coefficients:
        velocity = held(system.at(speed)[0])
        turn, change = (held(part) for part in system.slopes(speed, side))
        return Coefficients(
            laid(turn) + _diagonal(2.0 * shifts, mass),
            laid(change)
            + laid(turn, shifts * speed)
            + laid(velocity, shifts)
            + _diagonal(2.0 * shifts**2 * speed, mass),
        )

    def counted(right: ComplexArray) -> BoolArray:
        """Motions whose middle harmonic is the zeroth: of every motion one, or two at a tie."""
        parts = right.reshape(2 * order + 1, len(mass), -1)
        energy = np.einsum("kim,ij,kjm->km", parts.conj(), mass, parts).real
        middle = np.arange(-order, order + 1) @ energy / energy.sum(axis=0)
        return np.asarray(np.abs(middle) <= _CENTRAL)

    block = Block(mass=_diagonal(np.ones(len(shifts)), mass), at=at, slopes=slopes)
    return replace(block, counted=counted) if order else block


def _laid(
    order: int,
    stride: int,
    size: int,
    parts: Mapping[int, Matrix],
    factors: ComplexArray | None = None,
) -> Matrix:
    """Blocks A_{(k−m)g} of rows k and columns m, the columns times factors."""
    count = 2 * order + 1
    out: Matrix = np.zeros((count * size, count * size))
    for harmonic, matrix in parts.items():
        shifted = np.eye(count, k=-(harmonic // stride if stride else 0))
        out = out + np.kron(shifted if factors is None else shifted * factors, matrix)
    return out


def _diagonal(factors: Matrix, matrix: Matrix) -> Matrix:
    return np.kron(np.diag(factors), matrix)
