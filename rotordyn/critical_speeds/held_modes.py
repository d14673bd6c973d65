"""Roots of D(Ω) = K(Ω) − Ω² N next to those with the bearings held, all of them together.

In the modes with Wᴴ K W = 1 and Wᴴ N W = ν at one speed, D/Ω² is 1/Ω² − ν and what the few bearings
with a law have changed by, Uᴴ (Δk/Ω²) U with U their motion in each mode.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.linalg as nla
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.law_pieces import LawPieces
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.ledger import solved

# Stiffness that is added to the held one, as a part of the largest.
_SOFT = 1e-12
# Modes of which 1/Ω² − ν may be next to zero, and how far (relative) beside Ω it is taken.
_NEAR, _BESIDE = 6, 1e-13
# Iterations at most, and relative change of a speed that is at rest.
_ITERATIONS, _AT_REST = 12, 1e-14
# After a step of an iteration that converges cubically by less than this the next one is nothing.
_CUBED = 1e-6
# A vector of which D leaves more than this (relative) is sought once more.
_ROUGH = 1e-9


class SpeedMatrix(NamedTuple):
    """K without the bearings with a law, and N, (n, n); motions of these, (2 b, n), and pieces."""

    stiffness: Matrix
    inertia: Matrix
    motions: Matrix
    laws: tuple[LawPieces, ...]

    def bearings_at(self, speeds: FloatArray) -> FloatArray:
        """Return the symmetric part of k of all bearings at speeds (s,), shape (s, 2 b, 2 b)."""
        joined = np.zeros((speeds.size, len(self.motions), len(self.motions)))
        for at, pieces in enumerate(self.laws):
            k, own = pieces.along(speeds).stiffness_n_per_m, slice(2 * at, 2 * at + 2)
            joined[:, own, own] = 0.5 * (k + k.swapaxes(1, 2))
        return joined

    def stiffened(self, bearings: FloatArray) -> Matrix:
        """Return K with the k of all bearings (2 b, 2 b)."""
        return np.asarray(self.stiffness + self.motions.conj().T @ (bearings @ self.motions))

    def quotient_roots(self, speeds: FloatArray, vectors: Matrix) -> FloatArray:
        """Return where vᴴ D(Ω) v is zero next to each speed, nan where Newton's method fails."""
        strain, inertia = (
            (vectors.conj() * (matrix @ vectors)).sum(axis=0).real
            for matrix in (self.stiffness, self.inertia)
        )
        held = [
            pieces.of_motions(self.motions[2 * at : 2 * at + 2] @ vectors)
            for at, pieces in enumerate(self.laws)
        ]
        here, step = speeds**-2, np.full(speeds.size, np.inf)
        with np.errstate(invalid="ignore", divide="ignore"):
            for _ in range(_ITERATIONS):
                speeds = here**-0.5
                values = [law.at(speeds) for law in held]
                stiffness = strain + sum(value for value, _ in values)
                fall = stiffness - 0.5 * speeds * sum(slope for _, slope in values)
                step = (inertia - stiffness * here) / fall
                here = here + step
                here[~((here > 0) & (here < np.inf))] = np.nan
                if not (np.abs(step) > _AT_REST * here).any():
                    break
            return np.where(np.abs(step) <= _AT_REST * here, here**-0.5, np.nan)


class HeldModes(NamedTuple):
    """Modes with the bearings held: ν, shape (n,), W, U, (2 b, n), and k, (2 b, 2 b)."""

    inverse_squares: FloatArray
    vectors: Matrix
    motions: Matrix
    stiffness: FloatArray

    def iterated(self, speeds: FloatArray, stiffness: FloatArray, states: Matrix) -> Matrix:
        """Return (D/Ω²)⁻¹ of amplitudes of the modes, (n, s), one for each speed, of unit length.

        `stiffness`: k at the speeds. Modes that may be singular stay as unknowns beside the forces
        of the bearings, from which all others follow.
        """
        apart = speeds**-2 * (1.0 + _BESIDE) - self.inverse_squares[:, None]
        near = np.argsort(np.abs(apart), axis=0)[:_NEAR]
        active = np.take_along_axis(apart, near, axis=0)
        np.put_along_axis(apart, near, np.inf, axis=0)
        follow = 1.0 / apart
        change = (stiffness - self.stiffness) / speeds[:, None, None] ** 2
        r, own = len(near), self.motions[:, near].transpose(2, 0, 1)
        size = r + len(self.motions)
        border = np.zeros((speeds.size, size, size), dtype=self.motions.dtype)
        border[:, range(size), range(size)] = 1.0
        border[:, range(r), range(r)] = active.T
        border[:, :r, r:] = own.conj().swapaxes(1, 2)
        border[:, r:, :r] = -change @ own
        back = self.motions.conj().T
        border[:, r:, r:] += change @ ((self.motions * follow.T[:, None]) @ back)
        passive = follow * states
        pushed = change @ (self.motions @ passive).T[:, :, None]
        right = np.concatenate((np.take_along_axis(states, near, axis=0).T[:, :, None], pushed), 1)
        amplitude = nla.solve(border, right)[:, :, 0].T
        found = passive - follow * (back @ amplitude[r:])
        np.put_along_axis(found, near, amplitude[:r], axis=0)
        return np.asarray(found / nla.norm(found, axis=0))


def held_modes(matrix: SpeedMatrix, speed: float) -> HeldModes | None:
    """Return the modes with the bearings held as they are at a speed; None if K is negative."""
    bearings = matrix.bearings_at(np.array([speed]))[0]
    stiffness = matrix.stiffened(bearings)
    # what keeps a motion without stiffness from being singular
    soft = _SOFT * np.abs(np.diag(stiffness)).max() * np.eye(len(stiffness))
    solved("eigenproblems")
    try:
        inverse_squares, vectors = la.eigh(matrix.inertia, stiffness + soft)
    except la.LinAlgError:
        return None
    return HeldModes(inverse_squares, vectors, matrix.motions @ vectors, bearings)


def refined_roots(
    matrix: SpeedMatrix, held: HeldModes, modes: IntArray
) -> list[tuple[float, Matrix]]:
    """Return roots and vectors of unit length from some held modes; fewer if some find none.

    By Rayleigh quotient iteration (Parlett 1998, The Symmetric Eigenvalue Problem, section 4.6).
    """
    speeds, states = held.inverse_squares[modes] ** -0.5, np.eye(len(matrix.inertia))[:, modes]
    found: list[tuple[float, Matrix]] = []
    for _ in range(_ITERATIONS):
        if not speeds.size:
            break
        try:
            states = held.iterated(speeds, matrix.bearings_at(speeds), states)
        except la.LinAlgError:
            break
        vectors = held.vectors @ states
        before, speeds = speeds, matrix.quotient_roots(speeds, vectors)
        rests = np.abs(speeds - before) <= _CUBED * speeds
        found += _polished(matrix, speeds[rests], vectors[:, rests])
        going = np.isfinite(speeds) & ~rests
        speeds, states = speeds[going], states[:, going]
    return found


def _polished(
    matrix: SpeedMatrix, speeds: FloatArray, vectors: Matrix
) -> list[tuple[float, Matrix]]:
    """Return roots with vectors of unit length, after one more step where the modes were too rough.

    Those of a free body are, whose rigid motions without stiffness are magnified in them.
    """
    vectors = vectors / nla.norm(vectors, axis=0)
    inertia, bearings = matrix.inertia @ vectors, matrix.bearings_at(speeds)
    pushed = (bearings @ (matrix.motions @ vectors).T[:, :, None])[:, :, 0].T
    strain = (matrix.stiffness @ vectors + matrix.motions.conj().T @ pushed) / speeds**2
    rough = nla.norm(strain - inertia, axis=0) > _ROUGH * nla.norm(inertia, axis=0)
    for at in np.flatnonzero(rough):
        whole = matrix.stiffened(bearings[at]) / speeds[at] ** 2 - matrix.inertia
        solved("factorisations")
        try:
            vectors[:, at] = nla.solve(whole, vectors[:, at])
        except la.LinAlgError:
            continue
        vectors[:, at] /= nla.norm(vectors[:, at])
        speeds[at] = matrix.quotient_roots(speeds[[at]], vectors[:, [at]])[0]
    kept = np.isfinite(speeds)
    return [(float(speed), x) for speed, x in zip(speeds[kept], vectors.T[kept], strict=True)]
