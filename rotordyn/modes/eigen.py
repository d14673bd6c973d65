"""Modes of an assembled system at one speed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, SpeedMatrices, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import (
    ComplexArray,
    FloatArray,
    IntArray,
    ReadOnlyArrays,
    real_times,
)
from solidwhirl.rotordyn.core.dense import (
    Scaled,
    Spectrum,
    scale_by_stiffness,
    solve_general,
    solve_gyroscopic,
    solve_standing,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.kept import Kept
from solidwhirl.rotordyn.core.reprs import hertz
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.damping import damping_ratio, log_decrement
from solidwhirl.rotordyn.modes.split_spectrum import plane_spectrum, split_spectrum
from solidwhirl.rotordyn.modes.whirl import separated_whirl
from solidwhirl.rotordyn.modes.with_laws import modes_with_laws

# Frequencies closer than this (relative) are one group, which is never cut in two.
_EQUAL = 1e-6
# Modes computed beyond those asked for, to see where the last group ends.
_SPARE = 4
# Of so few coordinates all modes are computed, which takes hardly longer: others will ask for them.
_FEW = 128
# Room for modes that are asked for again: by the diagram, its errors, searches, studies.
_ROOM_BYTES = 128_000_000
# Matrices of a system.
_MATRICES = 6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Modes(ReadOnlyArrays):
    """Hold the oscillatory modes q = φ e^{λt} of a system at one speed.

    Attributes
    ----------
    speed_rad_s
        Ω, rad/s.
    eigenvalues
        λ in 1/s with Im λ > 0, by rising frequency, shape (m,). Each stands for itself and its
        conjugate.
    shapes
        φ in the independent coordinates of the system, shape (n, m), complex, scaled to
        φᴴMφ = 1 with the largest entry of each column real and positive; real for a system at
        rest without damping.
    real_eigenvalues
        Non-oscillatory eigenvalues other than zeros (overdamped motion, or divergence if
        positive), in 1/s, rising.
    zero_count
        Number of zero eigenvalues among the 2n: motions of free bodies that cost no energy.
    negative_stiffness_count
        Number of negative eigenvalues of the symmetric part of K + Ω²K2. Not zero for a support
        with negative stiffness, and for disk modes above their critical speed.
    family
        1 for whirl with +z, −1 against it, 0 for axial motion and torsion, shape (m,): modes of
        different families never mix. None where the system tells no families apart.
    index
        1, or −1 for a root that a law over the frequency makes by rising more steeply than a
        passive support can: shown, but no verdict rests on it; shape (m,). None where all are 1.
    """

    speed_rad_s: float
    eigenvalues: ComplexArray
    shapes: ComplexArray
    real_eigenvalues: FloatArray
    zero_count: int
    negative_stiffness_count: int
    family: IntArray | None = None
    index: IntArray | None = None

    def __repr__(self) -> str:
        unstable = int((self.log_decrement < 0).sum())
        warned = f", {unstable} of them unstable" if unstable else ""
        rpm, count = self.speed_rad_s * RPM_PER_RAD_S, self.eigenvalues.size
        return f"Modes at {rpm:.6g} rpm: {count}{warned}\n  {hertz(self.frequency_hz)}"

    @property
    def frequency_hz(self) -> FloatArray:
        """Damped natural frequencies Im λ / 2π, Hz, shape (m,)."""
        return np.asarray(self.eigenvalues.imag / (2.0 * np.pi))

    @property
    def damping_ratio(self) -> FloatArray:
        """Fractions of critical damping −Re λ / |λ|, shape (m,)."""
        return damping_ratio(self.eigenvalues)

    @property
    def log_decrement(self) -> FloatArray:
        """Logarithmic decrements −2π Re λ / |Im λ|, shape (m,); negative is unstable."""
        return log_decrement(self.eigenvalues)


def modes_at_speed(
    assembled: AssembledSystem, speed_rad_s: float, count: int | None = None
) -> Modes:
    """Compute the lowest oscillatory modes of a system at one speed.

    `speed_rad_s`: Ω, rad/s; `count`: number of modes; None for all. Modes of equal frequency stay
    together: where the last one has partners beyond the count, they are returned as well. Zero and
    real eigenvalues are counted, not listed among the modes. Raises AnalysisError if the speed is
    not finite, `count` is not positive, or M is not positive definite.

    Without damping and with K symmetric and positive (semi)definite the problem is solved as a
    Hermitian one and λ is exactly imaginary; otherwise as a general one. See `spectrum`.

    Where the force of bearings depends on the frequency, each mode is one of the system with the
    bearings as they are at its own frequency; none is missing (`with_laws.modes_with_laws`).

    Any combination of equal modes is a mode: in a turning system those that whirl forward and
    backward the most are returned, see `whirl.separated_whirl`.
    """
    if not np.isfinite(speed_rad_s):
        raise AnalysisError(f"speed_rad_s is {speed_rad_s}; it must be finite")
    if count is not None and count < 1:
        raise AnalysisError(f"count is {count}; it must be 1 or more, or None for all")
    place = assembled, float(speed_rad_s)
    known = _known.get(place)
    if known is None or not known.has(count):
        asked = None if assembled.size <= _FEW else count
        known = _Known(_computed(*place, asked), asked)
        _known.keep(place, known, known.modes.shapes.nbytes)
        # the system stays in memory with its modes: it counts once, and leaves after them
        of_system = _MATRICES * assembled.mass.nbytes + assembled.transformation.nbytes
        _known.keep(assembled, None, of_system)
    return known.lowest(count)


class _Known(NamedTuple):
    """Modes at a speed, and for how many they were asked, None for all."""

    modes: Modes
    asked: int | None

    def has(self, count: int | None) -> bool:
        """Whether so many lowest ones are among them."""
        return self.asked is None or (count is not None and count <= self.asked)

    def lowest(self, count: int | None) -> Modes:
        """Return the lowest of them, none of equal frequency cut off."""
        if count is None or count >= self.modes.eigenvalues.size:
            return self.modes
        kept = whole_group_count(self.modes.eigenvalues, count)
        return mode_columns(self.modes, np.arange(kept))


# by system and speed; None by system
_known = Kept[_Known | None](_ROOM_BYTES)


def _computed(assembled: AssembledSystem, speed_rad_s: float, count: int | None) -> Modes:
    """Compute the lowest modes."""
    matrices = matrices_at_speed(assembled, speed_rad_s)
    n = assembled.size
    wanted = n if count is None else min(count, n)
    solved = min(wanted + _SPARE, n)
    modes = _lowest_modes(assembled, matrices, speed_rad_s, solved)
    kept = whole_group_count(modes.eigenvalues, wanted)
    if kept == solved < n:
        modes = _lowest_modes(assembled, matrices, speed_rad_s, n)
        kept = whole_group_count(modes.eigenvalues, wanted)
    if count is None:  # controllers have modes besides those of the n coordinates
        kept = modes.eigenvalues.size
    shapes = modes.shapes[:, :kept]
    if speed_rad_s != 0 and modes.family is None:
        shapes = separated_whirl(assembled, modes.eigenvalues[:kept], shapes)
    return replace(
        modes,
        eigenvalues=modes.eigenvalues[:kept],
        shapes=normalised(shapes, matrices.mass),
        family=None if modes.family is None else modes.family[:kept],
        index=None if modes.index is None else modes.index[:kept],
    )


def mode_columns(modes: Modes, columns: IntArray) -> Modes:
    """Return some of the modes of a set."""
    return replace(
        modes,
        eigenvalues=modes.eigenvalues[columns],
        shapes=modes.shapes[:, columns],
        family=None if modes.family is None else modes.family[columns],
        index=None if modes.index is None else modes.index[columns],
    )


def whole_group_count(eigenvalues: ComplexArray, count: int) -> int:
    """Return the number of lowest modes that holds a given number and cuts no equal ones apart.

    `eigenvalues`: λ by rising Im λ, shape (m,); `count`: number wanted, 1 or more. Returns `count`,
    or more if the frequencies of the next modes are equal to 1e-6; at most m.
    """
    omega = eigenvalues.imag
    kept = min(count, omega.size)
    while 0 < kept < omega.size and omega[kept] - omega[kept - 1] <= _EQUAL * omega[kept]:
        kept += 1
    return kept


def _lowest_modes(
    assembled: AssembledSystem, matrices: SpeedMatrices, speed_rad_s: float, count: int
) -> Modes:
    """Return the lowest modes with the solver that fits the system."""
    if assembled.depends_on_frequency:
        return _dependent_modes(assembled, speed_rad_s)
    split = None
    if speed_rad_s != 0.0 or not assembled.is_conservative:
        split = split_spectrum(assembled, matrices, speed_rad_s, count)
    if split is None and matrices.gyroscopic.any():
        split = plane_spectrum(assembled, matrices, count)
    if split is not None:
        return Modes(
            speed_rad_s=speed_rad_s,
            eigenvalues=split.spectrum.eigenvalues,
            shapes=split.spectrum.shapes,
            real_eigenvalues=split.spectrum.real_eigenvalues,
            zero_count=split.zero_count,
            negative_stiffness_count=0,
            family=split.family,
        )
    scaled = scaled_stiffness(assembled, matrices)
    # Where zeros are possible they are counted by what is missing, so all modes are needed.
    solved = count if scaled.is_definite else assembled.size
    spectrum = _spectrum(assembled, matrices, scaled, solved)
    found = 2 * spectrum.eigenvalues.size + spectrum.real_eigenvalues.size
    return Modes(
        speed_rad_s=speed_rad_s,
        eigenvalues=spectrum.eigenvalues[:count],
        shapes=spectrum.shapes[:, :count],
        real_eigenvalues=spectrum.real_eigenvalues,
        zero_count=0 if scaled.is_definite else 2 * assembled.size - found,
        negative_stiffness_count=scaled.negative_count,
    )


def _dependent_modes(assembled: AssembledSystem, speed_rad_s: float) -> Modes:
    """Return all modes of a system whose bearings depend on the frequency."""
    found = modes_with_laws(assembled, speed_rad_s)
    return Modes(
        speed_rad_s=speed_rad_s,
        eigenvalues=found.values,
        shapes=found.shapes,
        real_eigenvalues=found.real_values,
        zero_count=found.zero_count,
        negative_stiffness_count=found.negative_count,
        index=found.signs,
    )


def scaled_stiffness(assembled: AssembledSystem, matrices: SpeedMatrices) -> Scaled:
    """Return the symmetric part of K and M at a speed by `scale_by_stiffness`."""
    symmetric = 0.5 * (matrices.stiffness + matrices.stiffness.T)
    return scale_by_stiffness(symmetric, matrices.mass, assembled.body_rate)


def _spectrum(
    assembled: AssembledSystem, matrices: SpeedMatrices, scaled: Scaled, count: int
) -> Spectrum:
    """Choose the solver that keeps the structure of the problem."""
    if not assembled.is_conservative or scaled.negative_count:
        velocity = matrices.damping + matrices.gyroscopic
        return solve_general(scaled, matrices.stiffness, velocity, count)
    if matrices.gyroscopic.any():
        return solve_gyroscopic(scaled, matrices.gyroscopic, count)
    omega, shapes = solve_standing(scaled)
    return Spectrum(1j * omega, shapes.astype(complex), np.empty(0))


def normalised(shapes: ComplexArray, mass: FloatArray) -> ComplexArray:
    """Scale to unit modal mass and turn the largest entry of each column real."""
    size = np.sqrt((shapes.conj() * real_times(mass, shapes)).sum(axis=0).real)
    scaled = shapes / size
    largest = scaled[np.abs(scaled).argmax(axis=0), np.arange(scaled.shape[1])]
    return np.asarray(scaled * (np.abs(largest) / largest))
