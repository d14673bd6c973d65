"""Speeds at which engine orders meet modes, directly, and where modes of one index veer.

On an engine order the frequency is ω = ±E·Ω, so that the speed is the only unknown:

    K φ = Ω² (E² M - (Kσ - S_c) ∓ 2E iC) φ,

a Hermitian problem that is linear in 1/Ω².
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.nodal_diameters.interference import excited_index
from solidwhirl.rotordyn.nodal_diameters.matrices import CyclicMatrices
from solidwhirl.rotordyn.nodal_diameters.modes import (
    HZ_PER_RAD_S,
    Direction,
    Family,
    NodalDiameterModes,
    index_spectrum,
    likeness,
    mode_errors,
)

# Frequencies that come nearer than this (relative) meet.
_MEETS = 1e-7
# Nearest approach (relative) up to which two modes are looked at.
_NEAR = 0.05
# Half widths of a veering at which shapes are compared, and the change that counts.
_WIDTHS, _EXCHANGED = 6.0, 0.5


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """An engine order that meets a mode."""

    engine_order: int
    index: int
    direction: Direction
    #: Branch, from 0
    mode: int
    #: Of the body
    speed_rad_s: float
    #: In the frame that turns with the body
    frequency_hz: float
    #: Estimated, relative, of speed and frequency alike; nan: not known
    error: float


@dataclass(frozen=True, kw_only=True)
class Veering:
    """Two modes of one index that come close."""

    index: int
    direction: Direction
    #: Lower and upper one, counted from the lowest frequency at this speed, from 0
    modes: tuple[int, int]
    speed_rad_s: float
    frequency_hz: float
    #: Smallest distance of the frequencies; 0 where they cross
    gap_hz: float
    #: Modal assurance of the lower one before with the upper one behind it: 1 if shapes change over
    exchanged: float

    @property
    def kind(self) -> str:
        """Return "crossing" of modes that do not see each other, else "veering"."""
        return "crossing" if self.gap_hz == 0.0 else "veering"


def engine_order_crossings(
    modes: NodalDiameterModes, engine_orders: Sequence[int]
) -> tuple[Crossing, ...]:
    """Return where engine orders meet the branches within the range of speeds, by rising speed.

    `engine_orders`: whole numbers from 1 on. Raises AnalysisError: an order that is none.
    """
    if any(order < 1 for order in engine_orders):
        raise AnalysisError("engine orders are whole numbers from 1 on")
    matrices = {m.index: m for m in modes.body.indices}
    found: list[Crossing] = []
    for order in sorted(set(engine_orders)):
        index, direction = excited_index(order, modes.body.sectors)
        if index in matrices:
            family = modes.family(index, direction)
            found += _crossings(matrices[index], family, order, modes.speeds_rad_s)
    return tuple(sorted(found, key=lambda c: (c.speed_rad_s, c.engine_order)))


def _crossings(
    matrices: CyclicMatrices, family: Family, order: int, speeds: FloatArray
) -> Iterator[Crossing]:
    """Where one engine order meets the branches of a family."""
    turned = -2.0 * order if family.direction == "forward" else 2.0 * order
    dynamic = order**2 * matrices.mass - matrices.centrifugal - turned * matrices.coriolis
    inverse = la.eigh(dynamic, matrices.stiffness, eigvals_only=True)
    inverse = inverse[inverse > 1.0 / speeds[-1] ** 2 * (1.0 - 1e-12)]
    for speed in (1.0 / np.sqrt(inverse[::-1])).tolist():
        if speed < speeds[0]:
            continue
        found = index_spectrum(matrices, speed, family.direction)
        rates = np.abs(found.rates_rad_s)
        own = int(np.abs(rates - order * speed).argmin())
        near = int(np.abs(speeds - speed).argmin())
        like = likeness(matrices, found.vectors, family.vectors[near])
        branch = int(like[own].argmax())
        if like[:, branch].argmax() != own:
            continue  # of a higher mode than those that are followed
        relative = mode_errors(matrices, speed, found, own + 1)[own]
        yield Crossing(
            engine_order=order,
            index=family.index,
            direction=family.direction,
            mode=branch,
            speed_rad_s=speed,
            frequency_hz=order * speed * HZ_PER_RAD_S,
            error=float(relative),
        )


def veerings(modes: NodalDiameterModes) -> tuple[Veering, ...]:
    """Return the pairs of neighbours of one index that come within 5 % inside the range."""
    matrices = {m.index: m for m in modes.body.indices}
    return tuple(
        veering
        for family in modes.families
        for lower in range(family.frequency_hz.shape[1] - 1)
        for veering in _veerings(matrices[family.index], family, modes.speeds_rad_s, lower)
    )


def _veerings(
    matrices: CyclicMatrices, family: Family, speeds: FloatArray, lower: int
) -> Iterator[Veering]:
    """Nearest approaches of a mode and the next one, both counted from the lowest."""

    def gap(speed: float) -> float:
        rates = np.abs(index_spectrum(matrices, speed, family.direction).rates_rad_s)
        return float(rates[lower + 1] - rates[lower])

    ordered = np.sort(family.frequency_hz, axis=1) / HZ_PER_RAD_S
    apart = ordered[:, lower + 1] - ordered[:, lower]
    inner = np.flatnonzero((apart[1:-1] < apart[:-2]) & (apart[1:-1] <= apart[2:])) + 1
    for k in inner:
        low, high = float(speeds[k - 1]), float(speeds[k + 1])
        best = scipy.optimize.minimize_scalar(
            gap, bounds=(low, high), method="bounded", options={"xatol": 1e-9 * high}
        )
        at, smallest = float(best.x), float(best.fun)
        middle = index_spectrum(matrices, at, family.direction)
        height = float(np.abs(middle.rates_rad_s[lower]))
        if smallest > _NEAR * height:
            continue
        # gap² = smallest² + (slope (Ω - at))²
        slope = max(
            np.sqrt(max(float(apart[j]) ** 2 - smallest**2, 0.0)) / abs(float(speeds[j]) - at)
            for j in (k - 1, k + 1)
        )
        aside = max(_WIDTHS * smallest / max(slope, 1e-300), 1e-6 * high)
        ends = np.clip([at - aside, at + aside], speeds[0], speeds[-1]).tolist()
        before, behind = (index_spectrum(matrices, s, family.direction).vectors for s in ends)
        like = likeness(matrices, before[:, [lower]], behind[:, [lower + 1]])
        if like[0, 0] < _EXCHANGED:
            continue
        yield Veering(
            index=family.index,
            direction=family.direction,
            modes=(lower, lower + 1),
            speed_rad_s=at,
            frequency_hz=(height + 0.5 * smallest) * HZ_PER_RAD_S,
            gap_hz=0.0 if smallest < _MEETS * height else smallest * HZ_PER_RAD_S,
            exchanged=float(like[0, 0]),
        )


def margin(speed: float, low: float, high: float) -> float:
    """Return (speed - operating) / operating to the nearer end of a range; 0 inside of it."""
    if low <= speed <= high:
        return 0.0
    nearer = low if speed < low else high
    return (speed - nearer) / nearer
