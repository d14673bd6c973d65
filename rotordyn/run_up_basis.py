"""State equation of a system with varying speed in its modes at rest, scaled to energy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.modal_truncation import rest_modes
from solidwhirl.rotordyn.system import AssembledSystem, matrices_at_speed


class ModalBasis(NamedTuple):
    """All n modes at rest without damping: q = Φ η with ΦᵀMΦ = 1.

    The state is x = (σ η, η'), σ the natural frequency, so that its square is twice the energy
    and stiff coordinates do not spoil the scale. Rigid-body modes get the lowest other σ.

    Attributes
    ----------
    assembled
        The system.
    shapes
        Φ, shape (n, n).
    scale
        σ in rad/s, shape (n,).
    rest_stiffness
        Diagonal of ΦᵀKΦ at rest, ±σ² and 0 for rigid-body modes, shape (n,).
    """

    assembled: AssembledSystem
    shapes: FloatArray
    scale: FloatArray
    rest_stiffness: FloatArray

    @property
    def size(self) -> int:
        """Number of coordinates n; the state has 2n entries."""
        return int(self.scale.size)

    @property
    def displacement(self) -> FloatArray:
        """Map from σ η to q, shape (n, n)."""
        return np.asarray(self.shapes / self.scale)

    def state(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        """Return x of a displacement and velocity in the independent coordinates, (2n,)."""
        momentum = self.shapes.T @ self.assembled.mass
        return np.concatenate((self.scale * (momentum @ displacement), momentum @ velocity))

    def acceleration_rows(self, speed_rad_s: float, acceleration_rad_s2: float) -> FloatArray:
        """Return the map from x to η'' without loads, shape (n, 2n).

        Parameters
        ----------
        speed_rad_s, acceleration_rad_s2
            Ω and Ω'.

        Returns
        -------
        ndarray
            −Φᵀ[K(Ω) + ½Ω'G]Φ/σ beside −Φᵀ[C(Ω) + ΩG]Φ.
        """
        matrices = matrices_at_speed(self.assembled, speed_rad_s)
        rest = matrices_at_speed(self.assembled, 0.0)
        # K at rest is diagonal in its modes; only the change is projected, to keep low modes exact.
        change = matrices.stiffness - _symmetric(rest.stiffness)
        change = change + 0.5 * acceleration_rad_s2 * self.assembled.gyroscopic
        stiffness = np.diag(self.rest_stiffness) + self.shapes.T @ change @ self.shapes
        velocity = self.shapes.T @ (matrices.damping + matrices.gyroscopic) @ self.shapes
        return np.hstack((-stiffness / self.scale, -velocity))


def modal_basis(assembled: AssembledSystem) -> ModalBasis:
    """Return the modes at rest of a system, the rigid ones among them.

    Parameters
    ----------
    assembled
        The system.

    Returns
    -------
    ModalBasis
        Complete, nothing is truncated.

    Raises
    ------
    AnalysisError
        If M is not positive definite.
    """
    squared, shapes = rest_modes(assembled)
    frequencies = np.sqrt(np.abs(squared))
    elastic = frequencies[frequencies > 0]
    floor = float(elastic.min()) if elastic.size else 1.0
    return ModalBasis(assembled, shapes, np.maximum(frequencies, floor), squared)


def _symmetric(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (matrix + matrix.T))
