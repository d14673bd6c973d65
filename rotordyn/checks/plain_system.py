"""The system at one speed straight from its parts: what the checks of results judge by.

Nothing here is shared with the assembly or with any solver. Every body is taken at its own spin,
every bearing with its full matrices, every law at its own speed; no symmetry is looked for or made
use of. Two things come from the assembled system: its parts, and its choice
of coordinates, which `joint_errors` tests.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.bearing_laws import (
    ARGUMENT_UNITS,
    PolynomialLaw,
    RingLaw,
    TableLaw,
)
from solidwhirl.rotordyn.assembly.frequency_laws import FrequencyTableLaw, frequency_law
from solidwhirl.rotordyn.assembly.magnetic_laws import MagneticLaw
from solidwhirl.rotordyn.assembly.parts import Bearing, End, Rotor, System
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.superelement.validation import MOTIONS

_EPS = float(np.finfo(float).eps)
# Constraints that are met to less than this part of their largest entry are met.
_DEPENDENT = 1e-10
# Steps of inverse iteration.
_STEPS = 3


class PlainMatrices(NamedTuple):
    """M, V = C + Ω_i G_i and K of M q'' + V q' + K q = f, and the sizes of their terms, (n, n)."""

    mass: FloatArray
    velocity: FloatArray
    stiffness: FloatArray
    sizes: tuple[FloatArray, FloatArray, FloatArray]

    def dynamic(self, value: complex) -> ComplexArray:
        """Return D(λ) = λ² M + λ V + K."""
        return np.asarray(value**2 * self.mass + value * self.velocity + self.stiffness)

    def size(self, value: complex) -> FloatArray:
        """Return the sizes of the terms of D(λ), what its rounding is relative to."""
        mass, velocity, stiffness = self.sizes
        return np.asarray(abs(value) ** 2 * mass + abs(value) * velocity + stiffness)


class RootError(NamedTuple):
    """How far a number is from an eigenvalue, and what rounding makes of that one, 1/s."""

    distance: float
    rounding: float


@dataclass(frozen=True, kw_only=True, eq=False)
class PlainSystem:
    """A system and its coordinates.

    `transformation`: coordinates of all bodies, one after the other, from the independent ones,
    shape (N, n).
    """

    system: System
    transformation: FloatArray

    @classmethod
    @lru_cache(maxsize=8)  # a system is a record that never changes
    def of(cls, assembled: AssembledSystem) -> PlainSystem:
        """Return the parts and coordinates of an assembled system."""
        return cls(system=assembled.system, transformation=np.array(assembled.transformation))

    @property
    def knots_rad_s(self) -> tuple[float, ...]:
        """Speeds Ω > 0 of the reference shaft at the rows of all tables, rising."""
        found = set()
        for bearing in self.system.bearings:
            ratio = abs(self.system.rotors[bearing.first.body].speed_ratio)
            if ratio and isinstance(bearing.speed_law, TableLaw | FrequencyTableLaw | RingLaw):
                found |= {float(row) / ratio for row in bearing.speed_law.speeds_rad_s if row > 0}
        return tuple(sorted(found))

    def bodies(self) -> Iterator[tuple[str, Rotor, FloatArray]]:
        """Yield each body with its name and its rows of the transformation, shape (n_body, n)."""
        start = 0
        for name, rotor in self.system.rotors.items():
            yield name, rotor, self.transformation[start : start + rotor.element.size]
            start += rotor.element.size

    @property
    def depends_on_frequency(self) -> bool:
        """Whether the force of a bearing depends on the frequency of the motion."""
        laws = (bearing.speed_law for bearing in self.system.bearings)
        return any(getattr(law, "depends_on_frequency", False) for law in laws)

    def at(self, speed_rad_s: float, rate: complex | None = None) -> PlainMatrices:
        """Return the matrices at a speed of the reference shaft.

        `rate`: s of the motion, at which bearings that depend on the frequency are taken, the added
        mass of tables with the mass; None takes the frequency of the spin.
        """
        n = self.transformation.shape[1]
        sums = [np.zeros((n, n)) for _ in range(3)]
        sizes = [np.zeros((n, n)) for _ in range(3)]
        for (place, power), (total, size) in self._powers.items():
            sums[place] += speed_rad_s**power * total
            sizes[place] += abs(speed_rad_s) ** power * size
        for bearing, terms, part in self._with_laws:
            stiffness, damping, mass = self.coefficients(bearing, speed_rad_s, rate)
            for place, matrix in enumerate((mass, damping, stiffness)):
                part.add(sums[place], sizes[place], matrix)
            if bearing.sensor is not None:
                self._add_sensed(bearing, speed_rad_s, rate, (sums, sizes))
            if terms is not None:
                spin = abs(self.system.rotors[terms.first.body].speed_ratio * speed_rad_s)
                cancelled = np.zeros((2, 6, 6))
                cancelled[:, :2, :2] = _law_values(terms, spin, 1j * spin)[:2]
                part.add(None, sizes[2], cancelled[0])
                part.add(None, sizes[1], cancelled[1])
        return PlainMatrices(sums[0], sums[1], sums[2], (sizes[0], sizes[1], sizes[2]))

    @cached_property
    def _powers(self) -> dict[tuple[int, int], tuple[FloatArray, FloatArray]]:
        """What no law changes: by place in M, V, K and power of Ω its sum, and their sizes."""
        n = self.transformation.shape[1]
        found: dict[tuple[int, int], tuple[FloatArray, FloatArray]] = {}

        def add(place: int, power: int, rows: FloatArray, term: FloatArray) -> None:
            totals = found.setdefault((place, power), (np.zeros((n, n)), np.zeros((n, n))))
            _Part.of(rows).add(*totals, term)

        for _, rotor, rows in self.bodies():
            for place, power, term in _body(rotor):
                add(place, power, rows, term)
        for bearing in self.system.bearings:
            if bearing.speed_law is None:
                stiffness, damping, _ = self.coefficients(bearing, 0.0)
                rows = self.relative_motion(bearing)
                add(1, 0, rows, damping)
                add(2, 0, rows, stiffness)
        for gear in self.system.gears:
            if gear.mesh_stiffness_n_per_m is not None:
                first, second = gear.tooth_motion()
                rows = (first @ self.seat(gear.first) + second @ self.seat(gear.second))[None]
                add(1, 0, rows, np.array([[gear.mesh_damping_n_s_per_m]]))
                add(2, 0, rows, np.array([[gear.mesh_stiffness_n_per_m]]))
        return found

    @cached_property
    def _with_laws(self) -> list[tuple[Bearing, Bearing | None, _Part]]:
        """Bearings that change with the speed, `_law_terms` of each, and their relative motion."""
        own = [bearing for bearing in self.system.bearings if bearing.speed_law is not None]
        return [(b, _law_terms(b), _Part.of(self.relative_motion(b))) for b in own]

    def gyroscopic(self) -> FloatArray:
        """Return G of all bodies per unit speed of the reference shaft, shape (n, n)."""
        n = self.transformation.shape[1]
        total, size = np.zeros((n, n)), np.zeros((n, n))
        for _, rotor, rows in self.bodies():
            _Part.of(rows).add(total, size, rotor.speed_ratio * rotor.element.gyroscopic)
        return total

    def seat(self, end: End) -> FloatArray:
        """Return ux to rz of an interface per coordinate, shape (6, n); zero where it has none."""
        motion = np.zeros((len(MOTIONS), self.transformation.shape[1]))
        for name, rotor, rows in self.bodies():
            if name == end.body:
                for coordinate, row in zip(rotor.element.coordinates, rows, strict=True):
                    if coordinate.kind == "interface" and coordinate.interface == end.interface:
                        motion[MOTIONS.index(coordinate.component)] = row
        return motion

    def relative_motion(self, bearing: Bearing) -> FloatArray:
        """Return the motion of the first side of a bearing less that of the second, (6, n)."""
        first = self.seat(bearing.first)
        return first if bearing.second is None else first - self.seat(bearing.second)

    def _add_sensed(
        self,
        bearing: Bearing,
        speed_rad_s: float,
        rate: complex | None,
        totals: tuple[list[FloatArray], list[FloatArray]],
    ) -> None:
        """Move what a controller does to where its sensors look, in place."""
        assert isinstance(bearing.speed_law, MagneticLaw) and bearing.sensor is not None
        magnetic, (sums, sizes) = bearing.speed_law.bearing, totals
        s = 1j * abs(speed_rad_s) if rate is None else rate
        if s.imag == 0.0:
            stiffness, damping = magnetic.slow_stiffness()
        else:
            gain = magnetic.current_stiffness_n_per_a * magnetic.controller.response(s)
            damping = gain.imag / s.imag
            stiffness = gain.real - s.real * damping
        at = self.relative_motion(bearing)[:2]
        apart = self.seat(bearing.sensor)[:2] - self.seat(bearing.first)[:2]
        for place, matrix in ((1, damping), (2, stiffness)):
            sums[place] += at.T @ matrix @ apart
            sizes[place] += np.abs(at).T @ np.abs(matrix) @ np.abs(apart)

    def coefficients(
        self, bearing: Bearing, speed_rad_s: float, rate: complex | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return stiffness, damping and mass of a bearing on (ux ... rz) at Ω and s, (6, 6)."""
        stiffness, damping, mass = np.zeros((3, 6, 6))
        stiffness[:2, :2], damping[:2, :2] = bearing.stiffness_n_per_m, bearing.damping_n_s_per_m
        stiffness[2, 2] = bearing.axial_stiffness_n_per_m
        damping[2, 2] = bearing.axial_damping_n_s_per_m
        stiffness[3:5, 3:5] = bearing.tilt_stiffness_n_m_per_rad
        damping[3:5, 3:5] = bearing.tilt_damping_n_m_s_per_rad
        stiffness[5, 5] = bearing.torsion_stiffness_n_m_per_rad
        damping[5, 5] = bearing.torsion_damping_n_m_s_per_rad
        if bearing.speed_law is not None:
            ratio = self.system.rotors[bearing.first.body].speed_ratio
            ratio = ratio if getattr(bearing.speed_law, "follows_spin", True) else 1.0
            spin = abs(ratio * speed_rad_s)
            stiffness[:2, :2] = damping[:2, :2] = 0.0
            values = _law_values(bearing, spin, 1j * spin if rate is None else rate)
            places = list(range(6)) if len(values[0]) == 6 else [0, 1, 3, 4][: len(values[0])]
            at = np.ix_(places, places)
            for matrix, value in zip((stiffness, damping, mass), values, strict=True):
                matrix[at] += value
        return stiffness, damping, mass


def _law_terms(bearing: Bearing) -> Bearing | None:
    """Return a bearing with all terms of its polynomial law positive; None of another law.

    They may cancel, what their rounding is relative to does not.
    """
    law = bearing.speed_law
    if not isinstance(law, PolynomialLaw):
        return None
    parts = ("stiffness_x", "stiffness_y", "damping_x", "damping_y")
    sizes: dict[str, Any] = {part: tuple(np.abs(getattr(law, part))) for part in parts}
    return dataclasses.replace(bearing, speed_law=dataclasses.replace(law, **sizes))


class _Part(NamedTuple):
    """A part in the coordinates that move it: its rows there, and their places in a matrix."""

    rows: FloatArray
    at: tuple[IntArray, ...]

    @classmethod
    def of(cls, rows: FloatArray) -> _Part:
        """Return a part that moves by rows of all coordinates."""
        moved = np.flatnonzero(rows.any(axis=0))  # most coordinates are of other parts
        return cls(rows[:, moved], np.ix_(moved, moved))

    def add(self, total: FloatArray | None, size: FloatArray, term: FloatArray) -> None:
        """Add a term and its size, in place."""
        if not term.any():
            return
        if total is not None:
            total[self.at] += self.rows.T @ term @ self.rows
        size[self.at] += np.abs(self.rows).T @ np.abs(term) @ np.abs(self.rows)


def _body(rotor: Rotor) -> Iterator[tuple[int, int, FloatArray]]:
    """Yield the terms of a body: place in M, V and K, power of Ω, matrix."""
    element, ratio = rotor.element, rotor.speed_ratio
    rigid = element.rigid_body_modes[:, element.rigid_body_present]
    # a free body has no elastic nor centrifugal force in rigid motion, but for rounding
    free = np.eye(element.size)
    if rigid.size:
        momentum = element.mass @ rigid
        free = free - rigid @ la.solve(rigid.T @ momentum, momentum.T)
    elastic = free.T @ element.stiffness @ free
    geometric = free.T @ (element.stress_stiffening - element.spin_softening) @ free
    yield 0, 0, np.asarray(element.mass)
    yield 1, 1, ratio * element.gyroscopic
    yield 2, 0, elastic
    yield 2, 2, ratio**2 * geometric
    wanted = rotor.internal_damping
    if wanted is not None:
        damping = wanted.stiffness_coefficient_s * elastic
        if wanted.modal_ratio:
            squares, shapes = la.eigh(0.5 * (elastic + elastic.T), element.mass)
            rate = 2.0 * wanted.modal_ratio * np.sqrt(np.maximum(squares, 0.0))
            pushed = element.mass @ shapes
            modal = (pushed * rate) @ pushed.T
            # rigid motions have the root of a rounding as their frequency
            damping = damping + free.T @ modal @ free
        yield 1, 0, damping
        if element.spin_generator is not None:
            yield 2, 1, -ratio * damping @ element.spin_generator


def _law_values(
    bearing: Bearing, spin_rad_s: float, rate: complex
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return stiffness, damping and mass on (ux, uy), or with tilts, at a spin speed and a rate."""
    law, own = bearing.speed_law, (bearing.stiffness_n_per_m, bearing.damping_n_s_per_m)
    none = np.zeros((2, 2))
    if isinstance(law, RingLaw):
        whole = np.zeros((3, 6, 6))
        for rows, part in law.parts:
            own_part = dataclasses.replace(bearing, speed_law=part)
            values = _law_values(own_part, spin_rad_s, rate)
            for total, value in zip(whole, values, strict=True):
                total += rows.T @ value @ rows
        return whole[0], whole[1], whole[2]
    if isinstance(law, TableLaw):
        speeds = law.speeds_rad_s
        at = float(np.clip(spin_rad_s, speeds[0], speeds[-1]))
        tables = (law.stiffness_n_per_m, law.damping_n_s_per_m)
        if law.interpolation == "linear":
            found = [
                np.array([np.interp(at, speeds, t[:, i, j]) for i in (0, 1) for j in (0, 1)])
                for t in tables
            ]
        else:
            from scipy.interpolate import (
                CubicSpline,
                PchipInterpolator,
            )  # takes a tenth of a second

            made = CubicSpline if law.interpolation == "cubic" else PchipInterpolator
            found = [made(speeds, t.reshape(-1, 4))(at) for t in tables]
        return found[0].reshape(2, 2), found[1].reshape(2, 2), none
    if isinstance(law, PolynomialLaw):
        x = ARGUMENT_UNITS[law.argument_unit] * spin_rad_s
        factors = [(law.stiffness_x, law.stiffness_y), (law.damping_x, law.damping_y)]
        k, c = (
            np.diag([m[a, a] * float(np.polyval(f[a][::-1], x)) for a in (0, 1)])
            for m, f in zip(own, factors, strict=True)
        )
        return k, c, none
    if isinstance(law, FrequencyTableLaw):
        k, c, m = _tabulated(law, spin_rad_s, abs(rate.imag))
        return k, c, m
    assert law is not None
    if frequency_law(law) is not None:
        law = law.at_rate(rate)  # type: ignore[attr-defined]
    other = law.coefficients(spin_rad_s, *own)
    return other.stiffness_n_per_m, other.damping_n_s_per_m, np.zeros_like(other.stiffness_n_per_m)


def _tabulated(law: FrequencyTableLaw, spin_rad_s: float, frequency_rad_s: float) -> FloatArray:
    """Return K, C and M as the table has them at a spin speed and a frequency, (3, d, d)."""
    from scipy.interpolate import PchipInterpolator  # takes a tenth of a second

    speeds, frequencies = law.speeds_rad_s, law.frequencies_rad_s
    at = float(np.clip(spin_rad_s, speeds[0], speeds[-1]))
    found = []
    for table in (law.stiffness_n_per_m, law.damping_n_s_per_m, law.mass_kg):
        rows = table.reshape(speeds.size, -1)
        if law.interpolation == "linear":
            values = np.array([np.interp(at, speeds, column) for column in rows.T])
        else:
            values = PchipInterpolator(speeds, rows)(at)
        if frequencies.size:
            by_frequency = values.reshape(frequencies.size, -1).T
            values = np.array([np.interp(frequency_rad_s, frequencies, v) for v in by_frequency])
        found.append(values.reshape(law.size, law.size))
    return np.array(found)


def joint_errors(plain: PlainSystem) -> tuple[float, int]:
    """Return by how much exact joints are broken, and how many motions too many are held.

    `plain`: the system in the coordinates to test. Returns largest entry of what rigid components,
    rigid bodies and rigid gears forbid, per unit coordinate; the number of independent motions less
    that of the coordinates.
    """
    whole = PlainSystem(system=plain.system, transformation=np.eye(len(plain.transformation)))
    held = [
        whole.relative_motion(bearing)[[MOTIONS.index(c) for c in bearing.rigid]]
        for bearing in plain.system.bearings
    ]
    for _, rotor, rows in whole.bodies():
        if rotor.element.constraint is not None:
            held.append(la.null_space(rotor.element.constraint.T).T @ rows)
    for gear in plain.system.gears:
        if gear.mesh_stiffness_n_per_m is None:
            first, second = gear.tooth_motion()
            teeth = first @ whole.seat(gear.first) + second @ whole.seat(gear.second)
            held.append(teeth[None] / np.abs(teeth).max())
    forbidden = np.vstack([np.zeros((1, len(plain.transformation))), *held])
    broken = float(np.abs(forbidden @ plain.transformation).max(initial=0.0))
    rank = int(np.linalg.matrix_rank(forbidden, tol=_DEPENDENT))
    largest = float(np.abs(plain.transformation).max())
    kept = int(np.linalg.matrix_rank(plain.transformation, tol=_DEPENDENT * largest))
    return broken / largest, len(plain.transformation) - rank - kept


def root_error(
    matrices: PlainMatrices, value: complex, slope: ComplexArray | None = None
) -> RootError:
    """Return how far a number is from an eigenvalue.

    `slope`: D'(λ) where matrices depend on λ themselves; None: 2 λ M + V.

    Returns |yᴴ D(λ) x / yᴴ D'(λ) x| with left and right vectors of inverse iteration: the step of
    Newton's method to the eigenvalue, right to first order. Its rounding is the change that errors
    of one unit in the last place of every term may cause.
    """
    dynamic, size = matrices.dynamic(value), matrices.size(value)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(size), np.finfo(float).tiny))
    even = scale[:, None] * dynamic * scale
    factors = la.lapack.zgetrf(even)
    if factors[2] > 0:
        return RootError(0.0, 0.0)
    solve = la.lapack.zgetrs
    norm, right = np.linalg.norm, _any_vector(len(scale))
    for _ in range(_STEPS):
        right = solve(factors[0], factors[1], right / norm(right))[0]
    left = right
    for _ in range(_STEPS):
        left = solve(factors[0], factors[1], left / norm(left), trans=2)[0]
    x, y = scale * right / norm(right), scale * left / norm(left)
    change = 2.0 * value * matrices.mass + matrices.velocity if slope is None else slope
    rate = abs(y.conj() @ change @ x)
    if rate == 0.0:
        return RootError(np.inf, np.inf)
    distance = abs(y.conj() @ (dynamic @ x)) / rate
    rounding = _EPS * float(np.abs(y) @ size @ np.abs(x)) / rate
    return RootError(float(distance), float(rounding))


@cache
def _any_vector(size: int) -> ComplexArray:
    """Where inverse iteration begins."""
    return np.random.default_rng(size).standard_normal(size).astype(complex)
