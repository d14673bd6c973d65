"""Modes of the cyclic indices of a body over the speed, backward and forward apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.nodal_diameters.matrices import CyclicBody, CyclicMatrices

Direction = Literal["standing", "backward", "forward"]
HZ_PER_RAD_S = 0.5 / np.pi


@dataclass(frozen=True, kw_only=True, eq=False)
class IndexSpectrum(ReadOnlyArrays):
    """Modes of one index and direction at one speed, by rising frequency."""

    #: (n,) ω > 0 of backward and standing, ω < 0 of forward modes
    rates_rad_s: FloatArray
    #: (n, n) columns, φᴴ M φ = 1
    vectors: Matrix


def index_spectrum(
    matrices: CyclicMatrices, speed_rad_s: float, direction: Direction
) -> IndexSpectrum:
    """Return all modes of an index at a speed.

    Raises AnalysisError: the body has lost its stiffness at that speed, or moves freely.
    """
    mass, coriolis = matrices.mass, matrices.coriolis
    stiffness = matrices.stiffness + speed_rad_s**2 * matrices.centrifugal
    sign, size = -1.0 if direction == "forward" else 1.0, len(mass)
    try:
        if speed_rad_s == 0.0 or not coriolis.any():
            squared, vectors = la.eigh(stiffness, mass)
            if not size or squared[0] <= 0.0:
                raise la.LinAlgError
            return IndexSpectrum(rates_rad_s=sign * np.sqrt(squared), vectors=vectors)
        # K z1 = ω (M ωz1 - 2Ω iC z1) with a definite matrix at the left: 1/ω are real
        energy = la.block_diag(stiffness, mass)
        crossed = np.block([[-2.0 * speed_rad_s * coriolis, mass], [mass, np.zeros_like(mass)]])
        inverse, states = la.eigh(crossed, energy)
    except la.LinAlgError:
        raise AnalysisError(
            f"nodal diameter {matrices.index} has no stiffness left at "
            f"{speed_rad_s * RPM_PER_RAD_S:.6g} rpm of the body; hold it, or stay below that speed"
        ) from None
    # as many are positive as negative; the lowest frequencies are at the ends
    chosen = np.arange(size) if sign < 0.0 else np.arange(2 * size)[::-1][:size]
    vectors = states[:size, chosen]
    vectors = vectors / np.sqrt(np.einsum("in,ij,jn->n", vectors.conj(), mass, vectors).real)
    return IndexSpectrum(rates_rad_s=1.0 / inverse[chosen], vectors=vectors)


def mode_errors(
    matrices: CyclicMatrices, speed_rad_s: float, modes: IndexSpectrum, count: int
) -> FloatArray:
    """Return the estimated relative errors of the lowest frequencies, (count,); nan: not known.

    The residual r of a mode in the full problem moves its frequency by rᴴ K⁻¹ r over the
    derivative of φᴴ A(ω) φ by ω, to first order (the quotient of Rayleigh and its next term).
    """
    rates, vectors = modes.rates_rad_s[:count], modes.vectors[:, :count]
    if not matrices.omitted:
        return np.full(count, np.nan)
    factors = np.array(
        [np.ones_like(rates), -(rates**2), 2.0 * rates * speed_rad_s, speed_rad_s**2 + 0.0 * rates]
    )
    terms = (factors[:, None, :] * vectors).reshape(-1, len(rates))
    turned = np.einsum("in,ij,jn->n", vectors.conj(), matrices.coriolis, vectors).real
    slope = np.abs(2.0 * rates - 2.0 * speed_rad_s * turned)
    total = np.zeros(len(rates))
    for part in matrices.omitted:
        energy = np.einsum("in,ij,jn->n", terms.conj(), part.gram, terms).real
        near = 1.0 - (rates / part.cutoff_rad_s) ** 2
        magnified = np.where(near > 0.0, 1.0 / np.maximum(near, 1e-12), np.nan)
        total += part.safety * magnified * np.maximum(energy, 0.0) / (slope * np.abs(rates))
    return np.pad(total, (0, count - len(rates)), constant_values=np.nan)


@dataclass(frozen=True, kw_only=True, eq=False)
class Family(ReadOnlyArrays):
    """Branches of one index and direction, numbered by their order at the first speed."""

    index: int
    direction: Direction
    #: (s, m) in the frame that turns with the body
    frequency_hz: FloatArray
    #: (s, m) estimated, relative; nan: not known
    error: FloatArray
    #: (s, n, m) φᴴ M φ = 1
    vectors: Matrix


@dataclass(frozen=True, kw_only=True, eq=False)
class NodalDiameterModes:
    """Branches of all indices of a body over its speed."""

    body: CyclicBody
    #: (s,) of the body itself, not negative
    speeds_rad_s: FloatArray
    #: Of each index: standing, or backward and forward
    families: tuple[Family, ...]

    def family(self, index: int, direction: Direction) -> Family:
        """Return the family of an index; a standing one has both directions."""
        wanted = "standing" if self.body.is_standing(index) else direction
        return next(f for f in self.families if (f.index, f.direction) == (index, wanted))


def directions_of(body: CyclicBody, index: int) -> tuple[Direction, ...]:
    """Return the directions that an index has apart."""
    return ("standing",) if body.is_standing(index) else ("backward", "forward")


def nodal_diameter_modes(
    body: CyclicBody, speeds_rad_s: FloatArray, count: int
) -> NodalDiameterModes:
    """Follow the lowest modes of every index over the speed.

    `speeds_rad_s`: (s,) of the body, rising from 0 or above. `count`: modes of each index and
    direction. Raises AnalysisError: see `index_spectrum`.
    """
    return NodalDiameterModes(
        body=body,
        speeds_rad_s=speeds_rad_s,
        families=tuple(
            _followed(matrices, speeds_rad_s, direction, count)
            for matrices in body.indices
            for direction in directions_of(body, matrices.index)
        ),
    )


def _followed(
    matrices: CyclicMatrices, speeds: FloatArray, direction: Direction, count: int
) -> Family:
    count = min(count, len(matrices.mass))
    hertz: list[FloatArray] = []
    errors: list[FloatArray] = []
    vectors: list[Matrix] = []
    for speed in speeds:
        modes = index_spectrum(matrices, float(speed), direction)
        order = np.arange(count)
        if vectors:
            like = likeness(matrices, vectors[-1], modes.vectors)
            order = scipy.optimize.linear_sum_assignment(-like)[1]
        ordered = IndexSpectrum(
            rates_rad_s=modes.rates_rad_s[order], vectors=modes.vectors[:, order]
        )
        hertz.append(np.abs(ordered.rates_rad_s) * HZ_PER_RAD_S)
        errors.append(mode_errors(matrices, float(speed), ordered, count))
        vectors.append(ordered.vectors)
    return Family(
        index=matrices.index,
        direction=direction,
        frequency_hz=np.array(hertz),
        error=np.array(errors),
        vectors=np.array(vectors),
    )


def likeness(matrices: CyclicMatrices, left: Matrix, right: Matrix) -> FloatArray:
    """Return the modal assurance |φᴴ M ψ|² / (φᴴ M φ · ψᴴ M ψ) of columns, shape (l, r)."""
    mass = matrices.mass
    crossed = np.abs(left.conj().T @ mass @ right) ** 2
    sizes = [np.einsum("in,ij,jn->n", v.conj(), mass, v).real for v in (left, right)]
    return np.asarray(crossed / np.outer(*sizes))


def fixed_frame_hz(frequency_hz: FloatArray, speed_rad_s: FloatArray, order: int) -> FloatArray:
    """Return |ω - mΩ| / 2π, what a probe that stands still sees of a circumferential order m.

    A mode of index h has the orders m = h + kN, k = ..., -1, 0, 1, ...: a backward one of
    frequency f and a forward one of -f. `speed_rad_s`: of the body, shaped like the frequencies.
    """
    return np.asarray(np.abs(frequency_hz - order * speed_rad_s * HZ_PER_RAD_S))
