"""Reduced matrices of the cyclic indices of one body, in the frame that turns with it.

A field of index h of a body of N equal sectors, α = 2π/N, is u = Re[c Φ] with Φ(R x) = R e^{ihα}
Φ(x). In the turning frame, with C = ∫ρ v·(e_z×u) at unit speed and the Hermitian matrix iC,

    M c'' + 2Ω C c' + (K + Ω² (Kσ - S_c)) c = 0,

so that c = φ e^{iωt} has (K + Ω² (Kσ - S_c) + 2ωΩ iC - ω² M) φ = 0 with real ω. For 0 < h < N/2 the
pattern runs against the spin (backward) where ω is positive, with it (forward) where it is
negative; for h = 0 and h = N/2 both are the same standing motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import Matrix, freeze_arrays
from solidwhirl.rotordyn.core.errors import AnalysisError

# Relative departure from a Hermitian matrix that is more than rounding.
_ROUNDING = 1e-8
_MATRICES = ("mass", "stiffness", "coriolis", "centrifugal")


@dataclass(frozen=True, kw_only=True, eq=False)
class OmittedEnergy:
    """What a reduced model leaves out, as the energy of its residual in the inverse stiffness."""

    part: str
    #: (4 n, 4 n) Hermitian, blocks in the order K, M, iC, Kσ - S_c
    gram: Matrix
    #: Factor on the energy that covers what it can not see
    safety: float
    #: Lowest angular frequency of what is left out; inf: far away
    cutoff_rad_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class CyclicMatrices:
    """One cyclic index h; all matrices are Hermitian, (n, n). Raises AnalysisError: one is not."""

    index: int
    mass: Matrix
    stiffness: Matrix
    #: iC at unit speed
    coriolis: Matrix
    #: Kσ - S_c at unit speed
    centrifugal: Matrix
    omitted: tuple[OmittedEnergy, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self, *_MATRICES)
        for name in _MATRICES:
            matrix = getattr(self, name)
            if matrix.shape != self.mass.shape or la.norm(matrix - matrix.conj().T) > (
                _ROUNDING * max(la.norm(matrix), np.finfo(float).tiny)
            ):
                raise AnalysisError(f"nodal diameter {self.index}: {name} is not Hermitian")


@dataclass(frozen=True, kw_only=True, eq=False)
class CyclicBody:
    """The cyclic indices of one body."""

    name: str
    #: N; None is a body of revolution, where h is the circumferential order
    sectors: int | None
    indices: tuple[CyclicMatrices, ...]

    def is_standing(self, index: int) -> bool:
        """Whether forward and backward waves of an index are one motion."""
        return index == 0 or 2 * index == self.sectors


def rotating_matrices(
    index: int,
    turn: int | None,
    inertial: tuple[Matrix, Matrix, Matrix, Matrix],
    omitted: tuple[OmittedEnergy, ...] = (),
) -> CyclicMatrices:
    """Return the matrices of an index from those in inertial coordinates, c e^{-ipΩt}.

    `turn`: p, by which the amplitudes were turned: N = pM - iC and S = S_c + p² M - 2p iC; None for
    real fields, G = 2C and S = S_c. `inertial`: M, K, N (or G) and Kσ - S, each (n, n). `omitted`:
    with blocks in the order K, M, N (or G), Kσ - S.
    """
    mass, stiffness, spin, difference = inertial
    # rows: K, M, iC and Kσ - S_c of the inertial K, M, N (or G), Kσ - S
    parts = np.eye(4, dtype=complex)
    if turn is None:
        parts[2] = 0.0, 0.0, 0.5j, 0.0
    else:
        parts[2] = 0.0, turn, -1.0, 0.0
        parts[3] = 0.0, -(turn**2), 2.0 * turn, 1.0
    of_basis = np.array([stiffness, mass, spin, difference])
    k, m, coriolis, centrifugal = np.tensordot(parts, of_basis, axes=1)
    mix = np.kron(parts.T, np.eye(len(mass)))
    return CyclicMatrices(
        index=index,
        mass=_hermitian(m),
        stiffness=_hermitian(k),
        coriolis=_hermitian(coriolis),
        centrifugal=_hermitian(centrifugal),
        omitted=tuple(
            OmittedEnergy(
                part=o.part,
                gram=_hermitian(mix.conj().T @ o.gram @ mix),
                safety=o.safety,
                cutoff_rad_s=o.cutoff_rad_s,
            )
            for o in omitted
        ),
    )


def _hermitian(square: Matrix) -> Matrix:
    """Return the Hermitian part (removes round-off), real where nothing is imaginary."""
    out = 0.5 * (square + square.conj().T)
    return out if np.abs(out.imag).max(initial=0.0) > 0.0 else out.real
