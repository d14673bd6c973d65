"""Motions of a body whose matrices in its own frame are constant: those of one block."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.system import Side
from solidwhirl.rotordyn.asymmetric.parametric.block_paths import BlockSpectral, Stretch, prepared
from solidwhirl.rotordyn.asymmetric.parametric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.parametric.hill_roots import Root
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray


class ConstantMotions:
    """As `PeriodicMotions`, of a system without harmonics."""

    def __init__(self, system: PeriodicSystem, low: float, high: float) -> None:
        rate = float((np.diag(system.stiffness_at_rest()) / np.diag(system.mass)).max())
        self.basis = np.eye(system.size)
        self._block = prepared(hill_block(system, 0), rate, low, high)

    def solve(self, speed_rad_s: float) -> BlockSpectral:
        """Return all eigenvalues at a speed."""
        return self._block.solve(speed_rad_s)

    def with_slopes(self, spectral: BlockSpectral, side: Side) -> BlockSpectral:
        """Return eigenvalues with their slopes over the speed."""
        return self._block.with_slopes(spectral, side)

    def stretch_between(self, first: BlockSpectral, second: BlockSpectral) -> Stretch:
        """Pair the eigenvalues of two speeds."""
        return self._block.stretch_between(first, second)

    def alike(self, first: BlockSpectral, second: BlockSpectral) -> tuple[FloatArray, IntArray]:
        """Return the MAC of all motions at two speeds, and no strides, both (m, m)."""
        return self._block.alike(first, second)

    def root(self, spectral: BlockSpectral, index: int, order: int) -> Root:
        """Return a motion for Hill's method: one harmonic, whatever the order."""
        return Root(
            complex(spectral.values[index]),
            spectral.speed_rad_s,
            spectral.right[None, :, index],
            spectral.left[None, index],
        )
