"""Bearings whose stiffness and damping depend on the speed: polynomial factors and tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import NamedTuple, Protocol

import numpy as np

from solidwhirl.rotordyn.assembly.law_pieces import BearingCoefficients, LawPieces
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix, freeze_arrays
from solidwhirl.rotordyn.core.errors import AssemblyError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

# Units of the argument of a polynomial, per rad/s.
ARGUMENT_UNITS: Mapping[str, float] = MappingProxyType(
    {"rad/s": 1.0, "rpm": RPM_PER_RAD_S, "Hz": 0.5 / np.pi}
)
INTERPOLATIONS = ("linear", "monotone", "cubic")


# What couples tilts with lateral motion below this part of both is rounding.
_ROUNDED = 1e-9
# Rows of a table nearer to each other than this fraction of the highest speed are one speed.
_ONE_SPEED = 1e-12


class SpeedLaw(Protocol):
    """How the coefficients of a bearing on (ux, uy) depend on the spin speed of its first side.

    A law either scales the bearing's own coefficients, so that its values are proportional to them,
    or replaces them, and then they must be zero. It has a value at any speed, also beyond its
    range; `bearing_notes.bearing_notes` tells where it is used there.

    A law may also have a method `pieces` with the arguments of `coefficients` but the speed, that
    returns a `LawPieces`. Where it has none nothing is known of its structure, and every analysis
    takes the most general way; undamped critical speeds are then not searched for.
    """

    @property
    def name(self) -> str:
        """What the law is called in messages and pictures."""

    @property
    def speed_range_rad_s(self) -> tuple[float, float]:
        """Lowest and highest spin speed the law was made for, rad/s."""

    def coefficients(
        self, speed_rad_s: float, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
    ) -> BearingCoefficients:
        """Return the coefficients at a spin speed from the bearing's own ones on (ux, uy), (2, 2).

        `speed_rad_s`: not negative. Raises AssemblyError if the law can do nothing with the
        bearing's own ones.
        """


class _LawOfPieces:
    """Base of the laws that are polynomials of the spin speed, piece by piece."""

    __slots__ = ()

    def coefficients(
        self, speed_rad_s: float, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
    ) -> BearingCoefficients:
        """Return the coefficients at a spin speed, see `SpeedLaw`."""
        return self.pieces(stiffness_n_per_m, damping_n_s_per_m).at(speed_rad_s)

    def pieces(self, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray) -> LawPieces:
        """Return the coefficients as polynomials, from the bearing's own ones."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True, slots=True)
class PolynomialLaw(_LawOfPieces):
    """Scale the bearing's own diagonal coefficients by polynomials in the speed.

    k_xx(Ω) = k_xx p(Ω), and so on. Beyond its range the polynomial is evaluated as it is.

    `argument_unit`: what the polynomials take: "rad/s", "rpm" or "Hz"; `argument_range`: lowest
    and highest argument they were made for, in that unit; `stiffness_x`, `stiffness_y`,
    `damping_x`, `damping_y`: coefficients of the factors, lowest order first. Raises AssemblyError
    if the unit is unknown, the range is empty or a polynomial has no finite coefficients.
    """

    name: str
    argument_unit: str
    argument_range: tuple[float, float]
    stiffness_x: tuple[float, ...]
    stiffness_y: tuple[float, ...]
    damping_x: tuple[float, ...]
    damping_y: tuple[float, ...]

    def __post_init__(self) -> None:
        problems = []
        if self.argument_unit not in ARGUMENT_UNITS:
            problems.append(f"argument_unit {self.argument_unit!r}; use {list(ARGUMENT_UNITS)}")
        low, high = self.argument_range
        if not (0 <= low < high and np.isfinite(high)):
            problems.append(f"argument_range is ({low}, {high}); needed is 0 <= low < high, finite")
        for part in ("stiffness_x", "stiffness_y", "damping_x", "damping_y"):
            values = tuple(float(value) for value in getattr(self, part))
            if not values or not np.isfinite(values).all():
                problems.append(f"{part} is {values}; one or more finite coefficients are needed")
            object.__setattr__(self, part, values)
        if problems:
            raise AssemblyError(tuple(f"law {self.name!r}: {text}" for text in problems))

    @property
    def speed_range_rad_s(self) -> tuple[float, float]:
        """Lowest and highest spin speed the polynomials were made for, rad/s."""
        scale = ARGUMENT_UNITS[self.argument_unit]
        return self.argument_range[0] / scale, self.argument_range[1] / scale

    def pieces(self, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray) -> LawPieces:
        """Return the scaled coefficients as one polynomial of the spin speed.

        Raises AssemblyError if the bearing has cross terms, which this law does not scale.
        """
        k_xx, k_yy = _diagonal(self.name, "stiffness_n_per_m", stiffness_n_per_m)
        d_xx, d_yy = _diagonal(self.name, "damping_n_s_per_m", damping_n_s_per_m)
        factors = (self.stiffness_x, self.stiffness_y, self.damping_x, self.damping_y)
        count = max(len(factor) for factor in factors)
        scale = ARGUMENT_UNITS[self.argument_unit] ** np.arange(count)
        rows = np.zeros((1, count, 2, 2, 2))
        for place, (own, factor) in enumerate(zip((k_xx, k_yy, d_xx, d_yy), factors, strict=True)):
            which, axis = divmod(place, 2)
            rows[0, : len(factor), which, axis, axis] = own * np.array(factor)
        rows *= scale.reshape(-1, 1, 1, 1)
        return LawPieces(starts_rad_s=(0.0,), polynomials=rows)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class TableLaw(_LawOfPieces):
    """Interpolate full coefficient matrices between tabulated speeds.

    The values are absolute: the bearing's own coefficients must be zero. Beyond the table the
    nearest end value holds.

    `speeds_rad_s`: spin speeds, rising, not negative, shape (s,), s ≥ 2; `stiffness_n_per_m`,
    `damping_n_s_per_m`: on (ux, uy), shape (s, 2, 2); `interpolation`: "monotone" (piecewise cubic
    after Fritsch and Carlson, no overshoot between the values), "linear", or "cubic" (a spline, of
    values that are smooth), entry by entry;
    `static_loads_n`: the load of the bearing that each row is of, shape (s,), where it is known.
    Raises AssemblyError if shapes do not fit, numbers are not finite, or speeds do not rise or are
    one speed but for rounding.
    """

    name: str
    speeds_rad_s: FloatArray
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray
    interpolation: str = "monotone"
    static_loads_n: FloatArray | None = None
    _pieces: LawPieces = field(init=False, repr=False)

    def __post_init__(self) -> None:
        freeze_arrays(self, "speeds_rad_s", "stiffness_n_per_m", "damping_n_s_per_m")
        problems = _table_problems(self)
        if problems:
            raise AssemblyError(tuple(f"law {self.name!r}: {text}" for text in problems))
        values = np.stack((self.stiffness_n_per_m, self.damping_n_s_per_m), axis=1).astype(float)
        starts, rows = cubic_pieces(self.speeds_rad_s, values, self.interpolation)
        object.__setattr__(self, "_pieces", LawPieces(starts_rad_s=starts, polynomials=rows))

    @property
    def speed_range_rad_s(self) -> tuple[float, float]:
        """Lowest and highest tabulated spin speed, rad/s."""
        return float(self.speeds_rad_s[0]), float(self.speeds_rad_s[-1])

    def pieces(self, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray) -> LawPieces:
        """Return the interpolated coefficients as polynomials between the tabulated speeds.

        Raises AssemblyError if the bearing has coefficients of its own, which a table replaces.
        """
        refuse_own(self.name, stiffness_n_per_m, damping_n_s_per_m)
        return self._pieces


class LawPart(NamedTuple):
    """A law on two motions: its rows over ux to rz, (2, 6), and the law."""

    rows: FloatArray
    law: SpeedLaw


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RingLaw:
    """The stiffness of a rolling bearing or a set of them on ux, uy, uz, rx, ry over the speed.

    Made of laws on two motions each, added: on (ux, uy) and (rx, ry); on both at once, as at a
    point of the axis at a distance, what couples them; on uz. Each keeps a positive stiffness
    where the whole has one. What couples uz with the others is left out.

    `speeds_rad_s`: rising, (s,); `stiffness`: symmetric, (s, 5, 5); `damping_n_s_per_m`: in x and
    y; `motions`: those of ux, uy, uz, rx, ry that it is on, by number, the first two and others;
    `least`, `most`: of the diagonal over the positions of the balls, (s, 5), where they are known;
    `parts`: what it is made of.
    """

    name: str
    speeds_rad_s: FloatArray
    stiffness: FloatArray
    damping_n_s_per_m: float = 0.0
    motions: tuple[int, ...] = (0, 1, 2, 3, 4)
    least: FloatArray | None = None
    most: FloatArray | None = None
    parts: tuple[LawPart, ...] = ()
    # nothing of it comes from the sense of the spin
    is_symmetric = True

    def __post_init__(self) -> None:
        freeze_arrays(self, "speeds_rad_s", "stiffness")
        if not self.parts:
            object.__setattr__(self, "parts", tuple(_ring_parts(self)))

    @property
    def speed_range_rad_s(self) -> tuple[float, float]:
        """Lowest and highest tabulated spin speed, rad/s."""
        return float(self.speeds_rad_s[0]), float(self.speeds_rad_s[-1])

    def coefficients(
        self, speed_rad_s: float, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
    ) -> BearingCoefficients:
        """Return the coefficients on `motions`, shape (d, d) each, see `SpeedLaw`."""
        whole = np.zeros((2, 6, 6))
        for rows, law in self.parts:
            found = law.coefficients(speed_rad_s, stiffness_n_per_m, damping_n_s_per_m)
            whole += rows.T @ np.array(found) @ rows
        at = np.ix_(self.motions, self.motions)
        return BearingCoefficients(whole[0][at], whole[1][at])

    def mirrored(self) -> RingLaw:
        """Return the law as seen in a mirror that turns y round."""
        turned = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
        return replace(self, parts=tuple(LawPart(rows * turned, law) for rows, law in self.parts))

    def at_rest(self) -> RingLaw:
        """Return the law with the values at rest at all speeds."""
        return replace(self, stiffness=0.0 * self.stiffness + self.stiffness[0], parts=())


def _ring_parts(law: RingLaw) -> Iterator[LawPart]:
    """Yield the laws on two motions that a ring law is made of."""
    k, every = law.stiffness, np.eye(6)
    lateral, tilt, coupling = k[:, :2, :2], k[:, 3:, 3:], k[:, :2, 3:]
    cross = np.array([[0.0, 1.0], [-1.0, 0.0]])
    # at a distance a of the axis the point moves by u + a J r; S there couples by a S J
    seen = coupling @ cross.T
    seen = 0.5 * (seen + seen.swapaxes(1, 2))
    distance = 0.0
    if 3 in law.motions:
        sizes = [np.trace(part, axis1=1, axis2=2) for part in (lateral, tilt, seen)]
        with np.errstate(divide="ignore", invalid="ignore"):
            low = np.nanmax(np.abs(sizes[2]) / sizes[0], initial=0.0)
            high = np.nanmin(sizes[1] / np.abs(sizes[2]), initial=np.inf)
        if np.abs(seen).max() > _ROUNDED * np.sqrt(sizes[0] * sizes[1]).max():
            sign = np.sign(sizes[2][np.argmax(np.abs(sizes[2]))]) or 1.0
            distance = sign * np.sqrt(low * high)

    def part(rows: FloatArray, stiffness: FloatArray, damping: float = 0.0) -> LawPart:
        table = TableLaw(
            name=law.name,
            speeds_rad_s=law.speeds_rad_s,
            stiffness_n_per_m=stiffness,
            damping_n_s_per_m=np.broadcast_to(damping * np.eye(2), stiffness.shape),
            interpolation="cubic",
        )
        return LawPart(rows, table)

    apart = seen / distance if distance else 0.0 * seen
    yield part(every[:2], lateral - apart, law.damping_n_s_per_m)
    if 3 in law.motions:
        yield part(every[3:5], tilt - distance**2 * (cross.T @ apart @ cross))
        if distance:
            yield part(every[:2] + distance * cross @ every[3:5], apart)
    if 2 in law.motions:
        # half of it on each of two equal rows is alike in all directions, as the others may be
        axial = k[:, 2, 2, None, None] * np.eye(2)
        yield part(np.sqrt(0.5) * np.vstack((every[2], every[2])), axial)


def law_parts(law: SpeedLaw) -> tuple[tuple[FloatArray, SpeedLaw], ...]:
    """Return what a law is made of, each with its rows over ux to rz; itself if it is one."""
    if isinstance(law, RingLaw):
        return law.parts
    return ((np.eye(6)[list(law_motions(law))], law),)


class OfAnotherLaw:
    """Base of laws made of another one, their `law`: its name and range."""

    __slots__ = ()
    law: SpeedLaw

    @property
    def name(self) -> str:
        """What the law is called."""
        return self.law.name

    @property
    def speed_range_rad_s(self) -> tuple[float, float]:
        """Lowest and highest spin speed the law was made for, rad/s."""
        return self.law.speed_range_rad_s


@dataclass(frozen=True)
class _MirroredLaw(OfAnotherLaw):
    """A law of any kind with the signs of its cross terms changed."""

    law: SpeedLaw

    def coefficients(
        self, speed_rad_s: float, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
    ) -> BearingCoefficients:
        found = self.law.coefficients(speed_rad_s, stiffness_n_per_m, damping_n_s_per_m)
        return BearingCoefficients(*(mirrored(matrix) for matrix in found))


def mirrored(matrices: Matrix) -> Matrix:
    """Return matrices on (x, y) as seen in a mirror that turns y round: cross terms change sign.

    `matrices`: shape (..., 2, 2), or (..., 4, 4) with the tilts rx and ry, of which rx turns round.
    """
    signs = np.array([1.0, -1.0, -1.0, 1.0])[: matrices.shape[-1]]
    return np.asarray(matrices * np.outer(signs, signs) + 0.0)


def mirrored_law(law: SpeedLaw) -> SpeedLaw:
    """Return a law with the signs of its cross terms changed; a polynomial has none."""
    if isinstance(law, PolynomialLaw):
        return law
    own: Callable[[], SpeedLaw] | None = getattr(law, "mirrored", None)
    if own is not None:
        return own()
    if not isinstance(law, TableLaw):
        return _MirroredLaw(law)
    stiffness, damping = mirrored(law.stiffness_n_per_m), mirrored(law.damping_n_s_per_m)
    return replace(law, stiffness_n_per_m=stiffness, damping_n_s_per_m=damping)


def is_turned_by_spin(law: SpeedLaw) -> bool:
    """Tell whether cross terms of a law are unequal at some speed, as rotation makes them.

    `law`: one that is neither a polynomial nor a table may have such terms.
    """
    if isinstance(law, TableLaw):
        return not law.pieces(np.zeros((2, 2)), np.zeros((2, 2))).is_symmetric
    return not (isinstance(law, PolynomialLaw) or getattr(law, "is_symmetric", False))


def follows_spin(law: SpeedLaw) -> bool:
    """Tell whether a law changes with the spin of the bearing's first side.

    One that does not, as of a magnetic bearing or a damper, may depend on the frequency alone.
    """
    return bool(getattr(law, "follows_spin", True))


def law_motions(law: SpeedLaw) -> tuple[int, ...]:
    """Return which of ux, uy, uz, rx, ry, rz a law is on: the first two, tilts, all but rz."""
    return getattr(law, "motions", (0, 1, 3, 4)[: getattr(law, "size", 2)])


def law_pieces(
    law: SpeedLaw, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray
) -> LawPieces | None:
    """Return the polynomials of a law, None of a law that does not tell them.

    `stiffness_n_per_m`, `damping_n_s_per_m`: the bearing's own coefficients, shape (2, 2).
    """
    pieces = getattr(law, "pieces", None)
    return None if pieces is None else pieces(stiffness_n_per_m, damping_n_s_per_m)


def refuse_own(law: str, stiffness_n_per_m: FloatArray, damping_n_s_per_m: FloatArray) -> None:
    """Refuse a bearing's own coefficients, which a table replaces.

    `law`: its name. Raises AssemblyError if one is not zero.
    """
    own = {"stiffness_n_per_m": stiffness_n_per_m, "damping_n_s_per_m": damping_n_s_per_m}
    for name, matrix in own.items():
        if matrix.any():
            text = (
                f"law {law!r} is a table of absolute values, but the bearing has {name} "
                f"= {matrix.tolist()} of its own; leave them out"
            )
            raise AssemblyError((text,))


def cubic_pieces(
    speeds: FloatArray, values: FloatArray, interpolation: str
) -> tuple[tuple[float, ...], FloatArray]:
    """Return tabulated values as polynomials: constant below and beyond the rows of the table.

    `speeds`: rising, shape (s,); `values`: shape (s, ...). Returns the speeds at which the pieces
    begin, the first 0, and the coefficients, lowest order first, shape (pieces, 4, ...).
    """
    speeds = np.asarray(speeds, dtype=float)
    rows = np.zeros((speeds.size, 4, *values.shape[1:]))
    rows[:, 0] = values
    if interpolation != "linear":
        # imported here as it takes a tenth of a second
        from scipy.interpolate import CubicSpline, PchipInterpolator

        made = PchipInterpolator if interpolation == "monotone" else CubicSpline
        rows[:-1] = made(speeds, values).c[::-1].swapaxes(0, 1)
    else:
        steps = np.diff(speeds).reshape(-1, *[1] * (values.ndim - 1))
        rows[:-1, 1] = np.diff(values, axis=0) / steps
    starts = tuple(speeds.tolist())
    if starts[0] > 0:
        below = np.zeros_like(rows[:1])
        below[0, 0] = values[0]
        starts, rows = (0.0, *starts), np.concatenate((below, rows))
    return starts, rows


def _diagonal(law: str, name: str, matrix: FloatArray) -> tuple[float, float]:
    """Return the diagonal of a bearing's own coefficients, refusing cross terms."""
    (xx, xy), (yx, yy) = matrix.tolist()
    if xy != 0 or yx != 0:
        raise AssemblyError(
            (
                f"law {law!r} scales diagonal coefficients, but {name} of the bearing has the "
                f"cross terms {xy:g} and {yx:g}; give them in a table",
            )
        )
    return xx, yy


def axis_problems(name: str, values: FloatArray) -> list[str]:
    """Return what is wrong with the speeds or frequencies of a table, rad/s."""
    if values.ndim != 1 or values.size < 2:
        return [f"{name} has shape {values.shape}; two or more are needed"]
    rising = np.isfinite(values).all() and values[0] >= 0 and (np.diff(values) > 0).all()
    if not rising:
        return [f"{name} is {values.tolist()}; allowed is 0 <= first < second < ..."]
    if (np.diff(values) <= _ONE_SPEED * values[-1]).any():
        at = int(np.argmin(np.diff(values)))
        return [
            f"the rows at {values[at]:.6g} and {values[at + 1]:.6g} rad/s are at one speed beside "
            f"the highest, {values[-1]:.6g} rad/s; they must be farther apart than 1e-12 of it"
        ]
    return []


def _table_problems(law: TableLaw) -> list[str]:
    problems, count = axis_problems("speeds_rad_s", law.speeds_rad_s), law.speeds_rad_s.size
    if law.speeds_rad_s.ndim != 1 or count < 2:
        return problems
    for name in ("stiffness_n_per_m", "damping_n_s_per_m"):
        values = getattr(law, name)
        if values.shape != (count, 2, 2):
            problems.append(f"{name} has shape {values.shape}, allowed is ({count}, 2, 2)")
        elif not np.isfinite(values).all():
            problems.append(f"{name} has entries that are not finite")
    if law.interpolation not in INTERPOLATIONS:
        problems.append(f"interpolation {law.interpolation!r}; use {list(INTERPOLATIONS)}")
    return problems


# Müller and Hennings, Appendix A, equations 11 to 14, after Lee (1993), Vibration Analysis of
# Rotors. They print neither a unit for Ω nor a range. Stiffness at the design point over that at
# rest, their table 5 against k_xx at 13690, 18049 and 4346 rpm with Ω in each unit:
#
#            table 5   rad/s      rpm       Hz
#   LP        0.662    0.908    7.03e4   0.491
#   HP        6.32     5.25     2.23e5   0.416
#   fan       8.20     0.328    4.41e2   0.780
#
# rad/s comes near for HP, rad/s and Hz miss LP by a factor of 1.4 either way, and nothing fits the
# fan; the three printed digits of the coefficients leave 0.1 open at most. In rad/s k_yy is
# negative above 2150.7, d_xx above 1106.3 and d_yy above 1380.2 rad/s: the damping is negative at
# the design points of LP and HP.
# The y polynomials carry a factor 1/4, as they are normalised to k_xx and d_xx at rest.
_LEE_STIFFNESS_X = (1.0, -3.52e-3, 7.06e-6, -6.77e-9, 2.46e-12)
_LEE_DAMPING_X = (1.0, -3.6e-3, 5.07e-6, -2.38e-9)

# As printed: both base coefficients of the bearing are the value of x at rest. No range is printed;
# this one holds the design points.
LEE_ANISOTROPIC = PolynomialLaw(
    name="lee_anisotropic",
    argument_unit="rad/s",
    argument_range=(0.0, 2000.0),
    stiffness_x=_LEE_STIFFNESS_X,
    stiffness_y=(0.25, 0.25 * 9.67e-4, -0.25 * 1.31e-6, 0.25 * 1.02e-9, -0.25 * 3.35e-13),
    damping_x=_LEE_DAMPING_X,
    damping_y=(0.25, -0.25 * 2.3e-3, 0.25 * 3.06e-6, -0.25 * 1.39e-9),
)
# The x polynomials in both directions: the paper calls its bearings symmetric and isotropic while
# printing both pairs, and does not say which it used.
LEE_ISOTROPIC = replace(
    LEE_ANISOTROPIC,
    name="lee_isotropic",
    stiffness_y=_LEE_STIFFNESS_X,
    damping_y=_LEE_DAMPING_X,
)
