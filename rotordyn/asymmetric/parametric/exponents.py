"""Exponents of a periodic system over the speed, from the steps of one period, in few coordinates.

With the angle τ = Ωt the period 2π/g is the same at all speeds: dz/dτ = A(τ, Ω)/Ω z of the state z
= (p, p'/s), q = B p. Each motion is z = x(τ) e^{λt} with a periodic x; λ and λ + igΩ are the same
one, and the λ held is that of the x whose mean harmonic is the zeroth. Of left vectors y and right
ones y_i(τ) x_j(τ) = 1 for i = j, 0 else.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import Side
from solidwhirl.rotordyn.asymmetric.parametric.basis import fastest_rate, search_basis
from solidwhirl.rotordyn.asymmetric.parametric.block_paths import Spectral, Stretch, paired
from solidwhirl.rotordyn.asymmetric.parametric.floquet import (
    exponentials,
    state_rates,
    with_angle,
)
from solidwhirl.rotordyn.asymmetric.parametric.hill_roots import Root
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.dense import eigensolver_rounding
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.magnus import GAUSS, magnus_exponent
from solidwhirl.rotordyn.modes.damping import NEUTRAL

# Places of a period at which vectors are held: motions that meet by more than half as many strides
# do not drive each other.
_PLACES = 32
# Steps of a period for each radian of the fastest motion of the basis.
_PER_RADIAN = 0.5
# Steps that are taken at once.
_TOGETHER = 256
# What is left of a motion after a period below which it is lost in the rounding of the others.
_DEAD = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Exponents(Spectral):
    """Hold the m slowest of the 2r exponents of r coordinates at one speed.

    At equal parts of a period: `right`: x (places, 2r, m); `left`: y (places, m, 2r); `rates`: A/Ω
    (places, 2r, 2r).
    """

    right: ComplexArray
    left: ComplexArray
    rates: FloatArray


class PeriodicMotions:
    """Motions of a periodic system in the coordinates p of a basis B (n, r) of unit mass.

    `fastest_1_s`: rate of the fastest motion that is followed.
    """

    def __init__(self, system: PeriodicSystem, basis: FloatArray, fastest_1_s: float) -> None:
        self.basis = basis
        self._system, self._fastest = system, fastest_1_s
        self._angles = 2.0 * np.pi / system.stride * np.arange(_PLACES) / _PLACES
        squared = np.abs(la.eigvalsh(basis.T @ system.stiffness_at_rest() @ basis))
        self._scale = max(fastest_1_s, float(np.sqrt(squared.max())))
        # some more than count, which come and go
        self._followed = 2 * int((squared <= fastest_1_s**2).sum()) + 4

    def solve(self, speed_rad_s: float) -> Exponents:
        """Return all exponents at a speed; slopes are zero until they are asked for."""
        beat = self._system.stride * speed_rad_s
        period = 2.0 * np.pi / beat
        parts = self._parts(speed_rad_s)
        steps = self._steps(parts, speed_rad_s)
        whole = reduce(lambda before, step: step @ before, steps)
        factors, left, right = la.eig(whole, left=True, right=True)
        remains = np.maximum(np.abs(factors), np.finfo(float).tiny)
        values = (np.log(remains) + 1j * np.angle(factors)) / period
        x, y = _carried(steps, right, left.conj().T, np.exp(-values * period / _PLACES))
        rounding = eigensolver_rounding(float(la.norm(whole)), y[0], x[0]) / remains / period
        strides = np.round((self._mean_rate(x) - values).imag / beat)
        values = values + 1j * beat * strides
        kept = np.argsort(np.abs(values), kind="stable")[: self._followed]
        turn = np.exp(-1j * self._system.stride * np.outer(self._angles, strides[kept]))
        x, y = x[:, :, kept] * turn[:, None, :], y[:, kept] * turn.conj()[:, :, None]
        values, remains, rounding = values[kept], remains[kept], rounding[kept]
        rates = with_angle(parts, self._angles) / speed_rad_s
        change = with_angle(self._slopes(speed_rad_s), self._angles) - rates
        return Exponents(
            speed_rad_s=speed_rad_s,
            values=values,
            slopes=values / speed_rad_s
            + (y * np.swapaxes(change @ x, 1, 2)).sum(axis=(0, 2)) / _PLACES,
            tolerance=np.maximum(NEUTRAL * np.maximum(np.abs(values), beat), rounding),
            counted=(remains > _DEAD) & (np.abs(values) <= self._fastest),
            stride=self._system.stride,
            right=x,
            left=y,
            rates=rates,
        )

    def with_slopes(self, spectral: Exponents, side: Side) -> Exponents:
        """Return the exponents as they are: they have their slopes, the same on both sides."""
        return spectral

    def stretch_between(self, first: Exponents, second: Exponents) -> Stretch:
        """Pair the exponents of two speeds by the MAC of their vectors, at its best stride."""
        mac, strides = self.alike(first, second)
        partner = paired(first, second, mac, strides)
        rows = np.arange(partner.size)
        return Stretch(
            first=first,
            second=second,
            partner=partner,
            mac=mac[rows, partner],
            lifted=strides[rows, partner],
            couplings=_Couplings(first, second, partner, strides[rows, partner]),
        )

    def alike(self, first: Exponents, second: Exponents) -> tuple[FloatArray, IntArray]:
        """Return the MAC of all motions at two speeds, and the strides at which it is so.

        Both (m, m); λ of the second is raised by the strides. What does not count is like nothing.
        """
        there, back = _harmonics(first.left @ second.right), _harmonics(second.left @ first.right)
        mac = np.abs(there * np.swapaxes(back[-np.arange(_PLACES)], 1, 2))
        mac = np.where(np.outer(first.counted, second.counted), np.minimum(mac, 1.0), 0.0)
        best = mac.argmax(axis=0)
        return mac.max(axis=0), np.where(best < _PLACES // 2, best, best - _PLACES)

    def root(self, spectral: Exponents, index: int, order: int) -> Root:
        """Return a motion in the basis by its harmonics −order to order, for Hill's method."""
        size = self.basis.shape[1]
        places = np.arange(-order, order + 1)
        right, left = (
            _harmonics(parts)[at]
            for parts, at in (
                (spectral.right[:, :size, index], places),
                (spectral.left[:, index, size:], -places),
            )
        )
        return Root(complex(spectral.values[index]), spectral.speed_rad_s, right, left)

    def _within(self, parts: dict[int, Matrix]) -> dict[int, Matrix]:
        return {h: self.basis.T @ part @ self.basis for h, part in parts.items()}

    def _parts(self, speed: float) -> dict[int, Matrix]:
        """Harmonics of A."""
        velocity, stiffness = (self._within(part) for part in self._system.at(speed))
        parts = state_rates(velocity, stiffness, self._scale, self.basis.shape[1])
        size = self.basis.shape[1]
        parts[0][:size, size:] = self._scale * np.eye(size)
        return parts

    def _slopes(self, speed: float) -> dict[int, Matrix]:
        """Harmonics of dA/dΩ."""
        velocity, stiffness = (self._within(part) for part in self._system.slopes(speed))
        return state_rates(velocity, stiffness, self._scale, self.basis.shape[1])

    def _steps(self, parts: dict[int, Matrix], speed: float) -> FloatArray:
        """Matrices from each place of a period to the next, (places, m, m)."""
        turn = 2.0 * np.pi / self._system.stride
        wanted = _PER_RADIAN * self._scale * turn / speed
        doublings = max(0, int(np.ceil(np.log2(wanted / _PLACES))))
        finer = 2**doublings
        count = _PLACES * finer
        step = turn / count / speed
        out = []
        # as many places together as steps fit into memory well
        for first in range(0, _PLACES, max(1, _TOGETHER // finer)):
            places = np.arange(first, min(first + max(1, _TOGETHER // finer), _PLACES))
            angles = turn / count * np.arange(finer * places[0], finer * (places[-1] + 1))
            early, late = (step * with_angle(parts, angles + g * turn / count) for g in GAUSS)
            steps = exponentials(magnus_exponent(early, late))
            for _ in range(doublings):
                steps = steps[1::2] @ steps[::2]
            out.append(steps)
        return np.concatenate(out)

    def _mean_rate(self, right: ComplexArray) -> ComplexArray:
        """λ of the mean harmonic of each motion: p' over p."""
        size = self.basis.shape[1]
        moved, speed = right[:, :size], self._scale * right[:, size:]
        energy = (np.abs(moved) ** 2).sum(axis=(0, 1))
        return np.asarray((moved.conj() * speed).sum(axis=(0, 1)) / energy)


def floquet_exponents(system: PeriodicSystem, speeds_rad_s: npt.ArrayLike) -> list[ComplexArray]:
    """Return the exponents λ of a periodic system at speeds above 0 (s,), 1/s.

    Those up to the rate `fastest_rate`, in the frame of the body; each of the harmonic in which it
    mostly moves. Raises AnalysisError for other speeds and for a system
    that is constant, which has eigenvalues at once.
    """
    speeds = np.atleast_1d(np.asarray(speeds_rad_s, dtype=float))
    if not (speeds.size and np.isfinite(speeds).all() and (speeds > 0).all() and system.stride):
        raise AnalysisError(
            "exponents need speeds above 0 and a system that changes with the angle"
        )
    fastest = fastest_rate(system, float(speeds.max()))
    motions = PeriodicMotions(system, search_basis(system, fastest, float(speeds.max())), fastest)
    return [motions.solve(float(speed)).own for speed in speeds]


class _Couplings:
    """W_ij W_ji of a stretch by strides, see `Stretch`."""

    def __init__(
        self, first: Exponents, second: Exponents, partner: IntArray, lifted: IntArray
    ) -> None:
        self._ends, self._partner, self._lifted = (first, second), partner, lifted

    @cached_property
    def _coupled(self) -> tuple[ComplexArray, ComplexArray]:
        """W by harmonics at both ends."""
        first, second = self._ends
        change = second.rates - first.rates
        own, other = (e.speed_rad_s * (e.left @ change @ e.right) for e in self._ends)
        turn = np.exp(-2j * np.pi / _PLACES * np.outer(np.arange(_PLACES), self._lifted))
        other = other[:, self._partner][:, :, self._partner] * turn[:, None, :]
        return _harmonics(own), _harmonics(other * turn.conj()[:, :, None])

    def __call__(self, strides: int) -> tuple[ComplexArray, ComplexArray]:
        if abs(strides) >= _PLACES // 2:
            none = np.zeros((self._partner.size,) * 2, dtype=complex)
            return none, none
        first, second = (w[strides] * w[-strides].T for w in self._coupled)
        return first, second


def _harmonics(parts: ComplexArray) -> ComplexArray:
    """Mean of what is held at all places times e^{−isτ}, by s (negative ones at the end)."""
    return np.asarray(np.fft.fft(parts, axis=0) / _PLACES)


def _carried(
    steps: FloatArray, right: ComplexArray, left: ComplexArray, fade: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return periodic x and y at all places; `fade`: e^{−λ} of a step.

    Left vectors go backwards, so that what decays fast leaves no rounding in either.
    """
    x, y = np.empty((2, len(steps), *right.shape), dtype=complex)
    x[0] = right
    for k in range(1, len(steps)):
        x[k] = (steps[k - 1] @ x[k - 1]) * fade
    for k in range(len(steps) - 1, -1, -1):
        left = y[k] = fade[:, None] * (left @ steps[k])
    norm = np.einsum("kij,kji->i", y, x) / len(steps)
    return x, y / np.where(norm == 0, 1.0, norm)[:, None]
