"""Bearings whose force depends on the frequency of the motion: tables with added mass, and others.

A bearing pushes back with −Z(Ω, s) u for a motion u e^{st} of its two sides. What can't wait for s
takes such a law as one of the speed: at a frequency in proportion to the speed, which is exact for
unbalance and at critical speeds, or at one rate s, at which it is exact for one mode.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from solidwhirl.rotordyn.assembly.bearing_laws import (
    INTERPOLATIONS,
    OfAnotherLaw,
    SpeedLaw,
    axis_problems,
    cubic_pieces,
    mirrored,
    refuse_own,
)
from solidwhirl.rotordyn.assembly.law_pieces import BearingCoefficients, LawPieces
from solidwhirl.rotordyn.bearings.dynamic import DynamicStiffness
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, freeze_arrays
from solidwhirl.rotordyn.core.errors import AssemblyError

# Frequencies nearer to a knot than this fraction are at it.
_ROUNDING = 1e-13


class Coefficients(NamedTuple):
    """Stiffness, damping and added mass at one speed and one frequency, each (d, d)."""

    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray
    mass_kg: FloatArray


class FrequencyLaw(SpeedLaw, DynamicStiffness, Protocol):
    """How the force of a bearing depends on the speed and on the rate of the motion.

    As a `SpeedLaw` it is taken at the frequency of the spin. `AnyFrequencyLaw` has all of it for a
    law that only knows its dynamic stiffness.
    """

    @property
    def size(self) -> int:
        """2 for (ux, uy), 4 for (ux, uy, rx, ry)."""

    @property
    def depends_on_frequency(self) -> bool:
        """Whether Z is anything but K(Ω) + s C(Ω)."""

    @property
    def depends_on_growth(self) -> bool:
        """Whether Z is anything but K(Ω, |Im s|) + s C(Ω, |Im s|)."""

    @property
    def is_table(self) -> bool:
        """Whether Z is linear in the frequency between knots, and constant beyond them."""

    @property
    def knots_of_frequency(self) -> tuple[float, ...]:
        """Frequencies at which Z is not smooth, rising; it is constant before and beyond them."""

    @property
    def knots_of_speed(self) -> tuple[float, ...]:
        """Spin speeds at which Z is not smooth, rising."""

    def at_frequency(self, speed_rad_s: float, frequency_rad_s: float) -> Coefficients:
        """Return K, C and M at a speed and a frequency, Z(iω) = K + iωC − ω²M."""

    def at_whirl_ratio(self, ratio: float) -> SpeedLaw:
        """Return the law for motions whose frequency is a multiple of the spin speed."""

    def at_rate(self, rate: complex) -> SpeedLaw:
        """Return a law of K and C, K + sC = Z(Ω, s) at one rate s."""


@dataclass(frozen=True, kw_only=True)
class FrozenLaw(OfAnotherLaw):
    """A frequency law at one rate, or at a frequency in proportion to the speed.

    Exactly one of `ratio` and `rate` is given.
    """

    law: FrequencyLaw
    ratio: float | None = None
    rate: complex | None = None

    @property
    def size(self) -> int:
        """Number of motions."""
        return self.law.size

    def coefficients(
        self, speed_rad_s: float, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
    ) -> BearingCoefficients:
        """Return K and C at a spin speed, see `SpeedLaw`; the bearing has none of its own."""
        refuse_own(self.name, stiffness_n_per_m, damping_n_s_per_m)
        rate = self.rate if self.rate is not None else 1j * (self.ratio or 0.0) * speed_rad_s
        if rate.imag == 0.0:
            k, c, m = self.law.at_frequency(speed_rad_s, 0.0)
            return BearingCoefficients(k + rate.real**2 * m, c)
        z = self.law.dynamic_stiffness(speed_rad_s, rate)
        damping = z.imag / rate.imag
        return BearingCoefficients(z.real - rate.real * damping, damping)


@dataclass(frozen=True, kw_only=True)
class FrozenTable(FrozenLaw):
    """A table of (ux, uy) frozen, which is piecewise a polynomial of the speed."""

    def pieces(self, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray) -> LawPieces:
        """Return stiffness and damping as polynomials of the spin speed."""
        refuse_own(self.name, stiffness_n_per_m, damping_n_s_per_m)
        assert isinstance(self.law, FrequencyTableLaw)
        if self.rate is not None:
            return self.law.pieces_at_rate(self.rate)
        return self.law.pieces_at_ratio(self.ratio or 0.0)


class AnyFrequencyLaw:
    """Base of frequency laws: all from the dynamic stiffness."""

    __slots__ = ()
    size = 2
    depends_on_frequency = True
    depends_on_growth = True
    is_table = False
    knots_of_frequency: tuple[float, ...] = ()
    knots_of_speed: tuple[float, ...] = ()

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z(Ω, s), see `FrequencyLaw`."""
        raise NotImplementedError

    def at_frequency(self, speed_rad_s: float, frequency_rad_s: float) -> Coefficients:
        """Return K and C at a speed and a frequency; at rest the limits, from a slow motion."""
        slow = 1e-6 * max(abs(speed_rad_s), 1.0)
        rate = 1j * max(abs(frequency_rad_s), slow)
        z = self.dynamic_stiffness(speed_rad_s, rate)
        return Coefficients(z.real.copy(), z.imag / rate.imag, np.zeros(z.shape))

    def at_whirl_ratio(self, ratio: float) -> SpeedLaw:
        """Return the law at a multiple of the spin speed."""
        return self._frozen(ratio=abs(ratio))

    def at_rate(self, rate: complex) -> SpeedLaw:
        """Return the law at one rate."""
        return self._frozen(rate=complex(rate))

    def _frozen(self, ratio: float | None = None, rate: complex | None = None) -> FrozenLaw:
        return FrozenLaw(law=self, ratio=ratio, rate=rate)  # type: ignore[arg-type]

    def mirrored(self) -> SpeedLaw:
        """Return the law under a shaft that turns the other way: seen in a mirror."""
        return MirroredFrequencyLaw(law=self)  # type: ignore[arg-type]

    def coefficients(
        self, speed_rad_s: float, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
    ) -> BearingCoefficients:
        """Return the coefficients at the frequency of the spin."""
        frozen = self.at_whirl_ratio(1.0)
        return frozen.coefficients(speed_rad_s, stiffness_n_per_m, damping_n_s_per_m)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class FrequencyTableLaw(AnyFrequencyLaw):
    """Interpolate stiffness, damping and added mass over the speed and the frequency.

    Z(Ω, s) = K(Ω, |Im s|) + s C(Ω, |Im s|) + s² M(Ω, |Im s|): over the speed as in a `TableLaw`, at
    each frequency; between frequencies linear. Beyond the table the nearest end value holds. The
    values are absolute: the bearing's own coefficients must be zero.

    `speeds_rad_s`: spin speeds, rising, not negative, shape (s,), s ≥ 2; `frequencies_rad_s`: of
    the motion, likewise, shape (f,), f ≥ 2, or empty: the coefficients do not depend on it.
    `stiffness_n_per_m`, `damping_n_s_per_m`, `mass_kg`: shape (s, f, d, d), or (s, d, d) without
    frequencies; on (ux, uy), d = 2, or (ux, uy, rx, ry), d = 4, then with N, N m and kg m in the
    blocks that join both. `interpolation`: over the speed, "monotone" or "linear".
    `static_loads_n`: as of a `TableLaw`. Raises AssemblyError if shapes do not fit, numbers are not
    finite, or an axis does not rise.
    """

    name: str
    speeds_rad_s: FloatArray
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray
    mass_kg: FloatArray
    frequencies_rad_s: FloatArray = field(default_factory=lambda: np.zeros(0))
    interpolation: str = "monotone"
    static_loads_n: FloatArray | None = None
    is_table = True
    # polynomials of the speed at each frequency, (f, pieces, 4, K C M, d, d), and their starts
    _starts: tuple[float, ...] = field(init=False, repr=False)
    _rows: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        names = ("speeds_rad_s", "frequencies_rad_s", *_MATRICES)
        freeze_arrays(self, *names)
        problems = _problems(self)
        if problems:
            raise AssemblyError(tuple(f"law {self.name!r}: {text}" for text in problems))
        values = np.stack([np.asarray(getattr(self, name), dtype=float) for name in _MATRICES])
        if not self.frequencies_rad_s.size:
            values = values[:, :, None]
        values = values.transpose(1, 2, 0, 3, 4)
        found = [
            cubic_pieces(self.speeds_rad_s, values[:, place], self.interpolation)
            for place in range(values.shape[1])
        ]
        object.__setattr__(self, "_starts", found[0][0])
        object.__setattr__(self, "_rows", np.stack([rows for _, rows in found]))

    @property
    def size(self) -> int:  # type: ignore[override]
        """Number of motions, 2 or 4."""
        return int(self.stiffness_n_per_m.shape[-1])

    @property
    def speed_range_rad_s(self) -> tuple[float, float]:
        """Lowest and highest tabulated spin speed, rad/s."""
        return float(self.speeds_rad_s[0]), float(self.speeds_rad_s[-1])

    @property
    def depends_on_frequency(self) -> bool:  # type: ignore[override]
        """Whether there are frequencies or added mass."""
        return bool(self.frequencies_rad_s.size) or bool(self.mass_kg.any())

    @property
    def follows_spin(self) -> bool:
        """Whether rows of different speeds differ."""
        return any((m != m[:1]).any() for m in (getattr(self, name) for name in _MATRICES))

    @property
    def depends_on_growth(self) -> bool:  # type: ignore[override]
        """Whether there is added mass."""
        return bool(self.mass_kg.any())

    @property
    def knots_of_frequency(self) -> tuple[float, ...]:  # type: ignore[override]
        """The tabulated frequencies."""
        return tuple(float(v) for v in self.frequencies_rad_s)

    @property
    def knots_of_speed(self) -> tuple[float, ...]:  # type: ignore[override]
        """The tabulated speeds, none if all rows are alike."""
        return tuple(float(v) for v in self.speeds_rad_s) if self.follows_spin else ()

    def at_frequency(self, speed_rad_s: float, frequency_rad_s: float) -> Coefficients:
        """Return K, C and M at a speed and a frequency."""
        place, part = self._place(abs(frequency_rad_s))
        piece = max(0, int(np.searchsorted(self._starts, speed_rad_s, side="right")) - 1)
        beyond = speed_rad_s - self._starts[piece]
        values = np.zeros(self._rows.shape[3:])
        for row in self._blended(place, part)[piece, ::-1]:
            values = values * beyond + row
        return Coefficients(*values)

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z(Ω, s)."""
        k, c, m = self.at_frequency(speed_rad_s, abs(rate.imag))
        return np.asarray(k + rate * c + rate**2 * m)

    @property
    def is_symmetric(self) -> bool:
        """Whether xy = yx in all coefficients."""
        matrices = [getattr(self, name) for name in _MATRICES]
        return all(np.array_equal(m, m.swapaxes(-1, -2)) for m in matrices)

    def mirrored(self) -> SpeedLaw:
        """Return the table under a shaft that turns the other way."""
        changed: dict[str, Any] = {name: mirrored(getattr(self, name)) for name in _MATRICES}
        return replace(self, **changed)

    def _frozen(self, ratio: float | None = None, rate: complex | None = None) -> FrozenLaw:
        kind = FrozenTable if self.size == 2 else FrozenLaw
        return kind(law=self, ratio=ratio, rate=rate)

    def pieces_at_rate(self, rate: complex) -> LawPieces:
        """Return K − |s|²M and C + 2 Re(s) M over the speed at a rate s: K + sC is Z there."""
        rows = self._blended(*self._place(abs(rate.imag)))
        k, c, m = np.moveaxis(rows, 2, 0)
        square = rate.real**2 if rate.imag == 0.0 else -(abs(rate) ** 2)
        both = np.stack((k + square * m, c + (2.0 * rate.real * m if rate.imag else 0.0 * m)), 2)
        return LawPieces(starts_rad_s=self._starts, polynomials=both)

    def pieces_at_ratio(self, ratio: float) -> LawPieces:
        """Return K − ω²M and C over the speed Ω at ω = ratio · Ω."""
        crossed = [float(v) / ratio for v in self.frequencies_rad_s] if ratio else []
        starts = np.unique([0.0, *self._starts, *crossed])
        kept = np.concatenate(([True], np.diff(starts) > _ROUNDING * starts[1:]))
        starts = starts[kept]
        inside = 0.5 * (starts + np.append(starts[1:], 2.0 * starts[-1] + 2.0))
        rows = np.stack(
            [
                self._piece_at_ratio(float(start), float(within), ratio)
                for start, within in zip(starts, inside, strict=True)
            ]
        )
        return LawPieces(starts_rad_s=tuple(starts.tolist()), polynomials=rows)

    def _piece_at_ratio(self, start: float, inside: float, ratio: float) -> FloatArray:
        """Return the polynomials of K and C beyond a start of a piece, (7, 2, d, d)."""
        known = np.asarray(self._starts)
        piece = max(0, int(np.searchsorted(known, inside, side="right")) - 1)
        rows = _shifted(self._rows[:, piece], start - known[piece])
        place, part = self._place(ratio * inside)
        if part is None:
            values = rows[place]
        else:
            low, high = self.frequencies_rad_s[place : place + 2]
            along = np.array([ratio * start - low, ratio]) / (high - low)
            one = np.array([1.0, 0.0])
            values = _times(rows[place], one - along) + _times(rows[place + 1], along)
        square = ratio**2 * np.array([start**2, 2.0 * start, 1.0])
        inertia = _times(values[:, 2:], square)
        out = np.zeros((7, 2, self.size, self.size))
        out[: len(values)] = values[:, :2]
        out[: len(inertia), 0] -= inertia[:, 0]
        return out

    def _place(self, frequency: float) -> tuple[int, float | None]:
        """Return the lower of two frequencies and the part of the way; None at an end or knot."""
        known = self.frequencies_rad_s
        if not known.size or frequency <= known[0]:
            return 0, None
        if frequency >= known[-1]:
            return known.size - 1, None
        place = int(np.searchsorted(known, frequency, side="right")) - 1
        return place, float((frequency - known[place]) / (known[place + 1] - known[place]))

    def _blended(self, place: int, part: float | None) -> FloatArray:
        if part is None:
            return np.asarray(self._rows[place])
        return np.asarray((1.0 - part) * self._rows[place] + part * self._rows[place + 1])


_MATRICES = ("stiffness_n_per_m", "damping_n_s_per_m", "mass_kg")


@dataclass(frozen=True, kw_only=True, slots=True)
class MirroredFrequencyLaw(OfAnotherLaw, AnyFrequencyLaw):
    """A frequency law under a shaft that turns the other way: seen in a mirror."""

    law: FrequencyLaw

    @property
    def size(self) -> int:  # type: ignore[override]
        """Number of motions."""
        return self.law.size

    @property
    def is_table(self) -> bool:  # type: ignore[override]
        """Whether the law is a table."""
        return self.law.is_table

    @property
    def knots_of_frequency(self) -> tuple[float, ...]:  # type: ignore[override]
        """Frequencies at which the law is not smooth."""
        return self.law.knots_of_frequency

    @property
    def knots_of_speed(self) -> tuple[float, ...]:  # type: ignore[override]
        """Spin speeds at which the law is not smooth."""
        return self.law.knots_of_speed

    def dynamic_stiffness(self, speed_rad_s: float, rate: complex) -> ComplexArray:
        """Return Z(Ω, s) in the mirror."""
        return np.asarray(mirrored(self.law.dynamic_stiffness(speed_rad_s, rate)))

    def at_frequency(self, speed_rad_s: float, frequency_rad_s: float) -> Coefficients:
        """Return K, C and M in the mirror."""
        return Coefficients(*map(mirrored, self.law.at_frequency(speed_rad_s, frequency_rad_s)))


def frequency_law(law: SpeedLaw | None) -> FrequencyLaw | None:
    """Return a law if it depends on the frequency, else None."""
    return law if getattr(law, "depends_on_frequency", False) else None  # type: ignore[return-value]


def _shifted(rows: FloatArray, by: float) -> FloatArray:
    """Return polynomials (f, 4, ...) in x + by as polynomials in x."""
    out = rows.copy()
    count = rows.shape[1]
    for first in range(count - 1):  # Horner's scheme, synthetic division
        for order in range(count - 2, first - 1, -1):
            out[:, order] += by * out[:, order + 1]
    return out


def _times(rows: FloatArray, factor: FloatArray) -> FloatArray:
    """Return polynomials (orders, ...) times a polynomial of numbers."""
    out = np.zeros((rows.shape[0] + factor.size - 1, *rows.shape[1:]))
    for order, value in enumerate(factor):
        out[order : order + rows.shape[0]] += value * rows
    return out


def _problems(law: FrequencyTableLaw) -> list[str]:
    problems = axis_problems("speeds_rad_s", law.speeds_rad_s)
    axes: tuple[int, ...] = (law.speeds_rad_s.size,)
    if law.frequencies_rad_s.size:
        problems += axis_problems("frequencies_rad_s", law.frequencies_rad_s)
        axes = (*axes, law.frequencies_rad_s.size)
    if problems:
        return problems
    for name in _MATRICES:
        values = getattr(law, name)
        if values.shape not in ((*axes, 2, 2), (*axes, 4, 4)):
            allowed = f"{(*axes, 2, 2)} or {(*axes, 4, 4)}"
            problems.append(f"{name} has shape {values.shape}, allowed is {allowed}")
        elif values.shape != law.stiffness_n_per_m.shape:
            problems.append(f"{name} has shape {values.shape}, the stiffness another")
        elif not np.isfinite(values).all():
            problems.append(f"{name} has entries that are not finite")
    if law.interpolation not in INTERPOLATIONS:
        problems.append(f"interpolation {law.interpolation!r}; use {list(INTERPOLATIONS)}")
    return problems
