"""Coordinates in which a run-up is integrated: the modes at rest of parts that do not couple."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.modes.modal_truncation import project_system, rest_modes
from solidwhirl.rotordyn.run_up.record import MotionState


class ModalBasis(NamedTuple):
    """All n modes at rest without damping: q = Φ η with ΦᵀMΦ = 1.

    The state is x = (σ η, η'), σ the natural frequency, so that its square is twice the energy
    and stiff coordinates do not spoil the scale. Rigid-body modes get the lowest other σ.

    `shapes`: Φ, shape (n, n); `scale`: σ in rad/s, shape (n,); `rest_stiffness`: diagonal of ΦᵀKΦ
    at rest, ±σ² and 0 for rigid-body modes, shape (n,).
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

    def motion(self, state: FloatArray) -> MotionState:
        """Return displacement and velocity in the independent coordinates of x, (n,) each."""
        return MotionState(
            displacement=self.displacement @ state[: self.size],
            velocity=self.shapes @ state[self.size :],
        )

    def acceleration_rows(self, speed_rad_s: float, acceleration_rad_s2: float) -> FloatArray:
        """Return the map from x to η'' without loads, shape (n, 2n).

        `speed_rad_s`, `acceleration_rad_s2`: Ω and Ω'. Returns −Φᵀ[K(Ω) + ½Ω'G]Φ/σ beside −Φᵀ[C(Ω)
        + ΩG]Φ.
        """
        matrices = matrices_at_speed(self.assembled, speed_rad_s)
        rest = matrices_at_speed(self.assembled, 0.0).stiffness
        # K at rest is diagonal in its modes; only the change is projected, to keep low modes exact.
        change = matrices.stiffness - 0.5 * (rest + rest.T)
        change = change + 0.5 * acceleration_rad_s2 * self.assembled.gyroscopic
        stiffness = np.diag(self.rest_stiffness) + self.shapes.T @ change @ self.shapes
        velocity = self.shapes.T @ (matrices.damping + matrices.gyroscopic) @ self.shapes
        return np.hstack((-stiffness / self.scale, -velocity))


def modal_basis(assembled: AssembledSystem) -> ModalBasis:
    """Return the modes at rest of a system, the rigid ones among them.

    The basis is complete, nothing is truncated. Raises AnalysisError if M is not positive definite.
    """
    squared, shapes = rest_modes(assembled)
    frequencies = np.sqrt(np.abs(squared))
    elastic = frequencies[frequencies > 0]
    floor = float(elastic.min()) if elastic.size else 1.0
    return ModalBasis(assembled, shapes, np.maximum(frequencies, floor), squared)


class ModalPart(NamedTuple):
    """A part of a system that nothing couples to the rest.

    `coordinates`: its independent coordinates, rising, shape (n,); `basis`: its modes, in these
    coordinates.
    """

    coordinates: IntArray
    basis: ModalBasis

    def state(self, motion: MotionState) -> FloatArray:
        """Return x of the part in a motion of the system, shape (2n,)."""
        at = self.coordinates
        return self.basis.state(motion.displacement[at], motion.velocity[at])


def modal_parts(assembled: AssembledSystem, groups: Sequence[IntArray]) -> tuple[ModalPart, ...]:
    """Return parts of a system that move by themselves, each with its modes at rest.

    `groups`: coordinates of each, of `uncoupled_groups`: axial motion and torsion beside lateral
    motion, and shafts that only meet in a casing that is held. Nothing is truncated. Raises
    AnalysisError if M is not positive definite.
    """
    every = np.eye(assembled.size)
    if len(groups) == 1 and groups[0].size == assembled.size:
        return (ModalPart(groups[0], modal_basis(assembled)),)
    return tuple(
        ModalPart(at, modal_basis(project_system(assembled, every[:, at]))) for at in groups
    )
