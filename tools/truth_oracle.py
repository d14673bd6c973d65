"""Whether a number is a root of the dynamic stiffness D(s, Ω), and all roots of it, from numbers.

Nothing of the program is used: D is put together from stored matrices and the laws as told by
`truth_machines`, each evaluated here by its own formula. A root is where D, with its rows and
columns scaled to one, has a singular value of rounding.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la
from scipy.interpolate import PchipInterpolator
from scipy.optimize import linear_sum_assignment
from scipy.signal import tf2ss

EPS = np.finfo(float).eps
Array = np.ndarray
# A singular value below this is zero; a root misses by no more than this, beside its rounding.
ZERO, ROOT = 1e-11, 1e-8
# Growth below this part of the root was always taken for neutral.
NEUTRAL = 1e-8
# Times the top speed beyond which a controlled machine has the roots of its filters.
FAST = 30.0
# Steps of a period beyond which growth is not looked at.
MANY = 3000


class Settled(NamedTuple):
    """Where Newton's method led: whether the start was a root, the root, how sure, how often."""

    is_root: bool
    root: complex
    unsure: float
    multiplicity: int
    residual: float

    def __str__(self) -> str:
        return f"residual {self.residual:.1e}, nearest root {self.root:.12g} (to {self.unsure:.0e})"


def settled(matrix: Callable[[complex], Array], start: complex, size: float) -> Settled:
    """Follow a start to the nearest root of a matrix of two real numbers, told as x + iy.

    `matrix`: D with rows and columns scaled to about one. `size`: what errors are relative to. D
    may depend on x and y in any way (|Im s|, speed and damping), so that the derivatives by both
    are taken apart: trace(W⁻¹ F) = 0 in the null vectors of D, all those of one root.
    """
    place, step, residual = complex(start), 2e-8 * size, np.nan
    noise, count = np.inf, 0
    for turn in range(25):
        d = matrix(place)
        if not np.isfinite(d).all():
            break
        left, values, right = la.svd(d)
        residual = float(values[-1]) if turn == 0 else residual
        count = max(1, int(np.sum((values <= 30.0 * values[-1]) & (values < 1e-5))))
        for own in (count, 1):
            y, x = left[:, -own:].conj().T, right[-own:].conj().T
            by_x = y @ (matrix(place + step) - matrix(place - step)) @ x / (2.0 * step)
            by_y = y @ (matrix(place + 1j * step) - matrix(place - 1j * step)) @ x / (2.0 * step)
            inner = float(la.svdvals(by_x)[-1])
            if inner * size > 1e-9:
                break
        if inner == 0.0:
            break
        f, turned = (np.trace(la.solve(by_x, m)) / own for m in (y @ d @ x, by_y))
        if abs(turned.imag) < 1e-12 * abs(turned) or not np.isfinite(f):
            break
        along = -f.imag / turned.imag
        move = complex(-f.real - turned.real * along, along)
        noise = 30.0 * EPS * len(d) / inner * max(1.0, abs(turned / turned.imag))
        place += move if abs(move) < 0.1 * size else 0.1 * size * move / abs(move)
        if abs(move) <= 0.3 * noise + 1e-15 * size:
            break
    values = la.svdvals(matrix(place))
    unsure = noise + 1e-14 * size
    count = max(1, int(np.sum(values <= 1e3 * max(values[-1], EPS * len(values)))))
    is_there = values[-1] < ZERO and abs(place - start) <= ROOT * size + 10.0 * unsure
    is_root = bool(is_there or residual <= 4.0 * EPS * len(values))
    return Settled(is_root, place, float(unsure), count, residual)


@dataclass(frozen=True)
class Dynamic:
    """D(s, Ω) of a machine from its stored numbers; `padé`: delays as the series, not exact."""

    stored: dict[str, Array]
    is_series: bool = False

    def of(self, name: str) -> Any:
        """A stored number."""
        return self.stored[name]

    @cached_property
    def matrices(self) -> dict[str, Array]:
        """M, C, G, K, K2 and N by the first letters of their names."""
        names = (
            "mass",
            "damping",
            "gyroscopic",
            "stiffness",
            "centrifugal_stiffness",
            "circulatory_stiffness",
        )
        return {name[:4]: np.asarray(self.of(f"matrices/{name}")) for name in names}

    @cached_property
    def laws(self) -> list[tuple[Array, dict[str, Any]]]:
        """Motion and numbers of every law."""
        found: dict[str, dict[str, Any]] = {}
        for key, value in self.stored.items():
            if key.startswith("laws/"):
                _, name, part = key.split("/", 2)
                found.setdefault(name, {})[part] = value
        out = []
        for name, numbers in found.items():
            own = {k: v for k, v in numbers.items() if not k.startswith(("x/", "y/"))}
            own["kind"], chains = str(own["kind"]), json.loads(str(own.pop("json")))
            out.append((self.of(f"matrices/motions/{name}"), {**own, **chains}))
        return out

    @property
    def fastest(self) -> float:
        """Beyond this roots are those of filters and delays, not motions of the machine."""
        own = [law for _, law in self.laws if law["kind"] == "controller"]
        chains = [law[axis]["filters"] for law in own for axis in "xy" if axis in law]
        delays = [item[1] for chain in chains for item in chain if item[0] == "delay"]
        fastest = FAST * float(self.of("kinds/top")) if own else np.inf
        return min([fastest, *(0.5 / time for time in delays)])

    @property
    def depends_on_frequency(self) -> bool:
        """Whether a law is a table over the frequency or has a controller."""
        return any(law["kind"] in ("frequency", "controller") for _, law in self.laws)

    @property
    def knots(self) -> Array:
        """Frequencies at which a law is not smooth."""
        rows = [law["frequencies"] for _, law in self.laws if law["kind"] == "frequency"]
        return np.unique(np.concatenate([[0.0], *rows]))

    def constant(self, speed: float) -> tuple[Array, Array, Array]:
        """M, V and K at a speed with the laws over the speed, but none over the frequency."""
        m = self.matrices
        velocity = m["damp"] + speed * m["gyro"]
        stiffness = m["stif"] + speed**2 * m["cent"] + speed * m["circ"]
        for motion, law in self.laws:
            if law["kind"] in ("speed", "polynomial"):
                k, c = _over_speed(law, abs(law["ratio"] * speed))
                stiffness = stiffness + motion.T @ k @ motion
                velocity = velocity + motion.T @ c @ motion
        return m["mass"], velocity, stiffness

    def frozen(self, speed: float, frequency: float) -> tuple[Array, Array, Array]:
        """M, V and K with tables over the frequency as they are at one; controllers left out."""
        mass, velocity, stiffness = self.constant(speed)
        for motion, law in self.laws:
            if law["kind"] == "frequency":
                k, c, m = _over_frequency(law, abs(law["ratio"] * speed), frequency)
                mass = mass + motion.T @ m @ motion
                velocity = velocity + motion.T @ c @ motion
                stiffness = stiffness + motion.T @ k @ motion
        return mass, velocity, stiffness

    def at(self, s: complex, speed: float) -> tuple[Array, Array]:
        """D and the sizes of what it is the sum of, on the diagonal."""
        mass, velocity, stiffness = self.frozen(speed, abs(complex(s).imag))
        d = s**2 * mass + s * velocity + stiffness
        parts = np.abs(np.diag(mass)) * abs(s) ** 2 + np.abs(np.diag(velocity)) * abs(s)
        size = parts + np.abs(np.diag(stiffness))
        for motion, law in self.laws:
            if law["kind"] == "controller":
                magnets, sensors = motion[:2], motion[-2:]
                gain = law["ki"] * _controller(law, s, self.is_series)
                d = d + magnets.T @ gain @ sensors - law["ks"] * magnets.T @ magnets
                size = size + np.diag(np.abs(magnets).T @ np.abs(gain) @ np.abs(magnets))
        return d, size

    def scaled(self, s: complex, speed: float, by: Array) -> Array:
        """D in given units."""
        return self.at(s, speed)[0] / np.outer(by, by)

    def units(self, s: complex, speed: float) -> Array:
        """What rows and columns are divided by, which is kept while a root is followed."""
        return np.sqrt(np.maximum(self.at(s, speed)[1], 1e-300))

    def root(self, s: complex, speed: float) -> Settled:
        """Whether s is a root at a speed."""
        by = self.units(s, speed)
        return settled(lambda z: self.scaled(z, speed, by), s, max(abs(s), 1e-3))

    def critical(self, speed: float, growth: float, ratio: float) -> Settled:
        """Whether growth + i·ratio·speed is a root at a speed; told as growth + i·speed."""
        by = self.units(complex(growth, ratio * speed), speed)
        return settled(
            lambda p: self.scaled(complex(p.real, ratio * p.imag), p.imag, by),
            complex(growth, speed),
            speed,
        )

    def roots(self, speed: float, fastest: float | None = None) -> tuple[Array, Array]:
        """All roots with Im s ≥ 0 at a speed and how far rounding may move each.

        Controllers are states; tables over the frequency are scanned between their knots.
        """
        if self.knots.size > 1:
            starts = self._scanned(speed)
        else:
            starts = _quadratic_roots(*self._with_states(*self.constant(speed)))
            starts = starts[starts.imag >= -1e-9 * np.abs(starts)]
        if not self.depends_on_frequency:
            return starts, np.array([self._rounding(s, speed) for s in starts])
        found: list[complex] = []
        unsure = []
        for start in starts[np.abs(starts) < (self.fastest if fastest is None else fastest)]:
            own = self.root(start, speed)
            moved = abs(own.root - start) < 0.05 * abs(start)
            if own.residual == own.residual and moved and own.unsure < 1e-3 * abs(start):
                alike = sum(abs(own.root - r) < 1e-8 * abs(r) + 10.0 * own.unsure for r in found)
                if alike < own.multiplicity:
                    found.append(own.root)
                    unsure.append(own.unsure)
        return np.array(found, dtype=complex), np.array(unsure)

    def _rounding(self, s: complex, speed: float) -> float:
        by = self.units(s, speed)
        left, _, right = la.svd(self.scaled(s, speed, by))
        mass, velocity, _ = self.constant(speed)
        slope = (
            left[:, -1].conj() @ ((2.0 * s * mass + velocity) / np.outer(by, by)) @ right[-1].conj()
        )
        return float(10.0 * EPS * len(by) / max(abs(slope), 1e-300))

    def _with_states(self, mass: Array, velocity: Array, stiffness: Array) -> tuple[Array, ...]:
        """M, V and K of the coordinates and the states of the controllers, delays as a series."""
        force, states, seen = [], [], []
        for motion, law in self.laws:
            if law["kind"] != "controller":
                continue
            magnets, sensors = motion[:2], motion[-2:]
            stiffness = stiffness - law["ks"] * magnets.T @ magnets
            for a, b, c, d, rate, rows in _state_spaces(law):
                stiffness = stiffness + law["ki"] * magnets[rows].T @ d @ sensors[rows]
                velocity = velocity + law["ki"] * rate * magnets[rows].T @ sensors[rows]
                force.append(law["ki"] * magnets[rows].T @ c)
                states.append(a)
                seen.append(b @ sensors[rows])
        if not states:
            return mass, velocity, stiffness
        a = la.block_diag(*states)
        none = np.zeros_like(a)
        whole = np.block([[stiffness, np.hstack(force)], [-np.vstack(seen), -a]])
        return la.block_diag(mass, none), la.block_diag(velocity, np.eye(len(a))), whole

    def _scanned(self, speed: float) -> Array:
        """Starts: where roots of the problem frozen at a frequency come to it."""
        real = _quadratic_roots(*self.frozen(speed, 0.0))
        starts = list(real[np.abs(real.imag) < 1e-9 * np.abs(real)].real)
        ends = self.knots
        last = _quadratic_roots(*self.frozen(speed, 2.0 * ends[-1]))
        starts += list(last[last.imag >= ends[-1] * (1.0 - 1e-6)])
        for low, high in pairwise(ends):
            grid = np.linspace(low, high, 13)
            before = _quadratic_roots(*self.frozen(speed, low))
            for w0, w1 in pairwise(grid):
                after = _quadratic_roots(*self.frozen(speed, w1))
                before, after = _paired(before, after)
                first, then = before.imag - w0, after.imag - w1
                near = np.minimum(np.abs(first), np.abs(then)) < 0.6 * np.abs(
                    first - then
                ) + 0.02 * (w1 - w0)
                for j in np.flatnonzero((first * then <= 0.0) | near):
                    part = np.clip(first[j] / (first[j] - then[j] or 1.0), 0.0, 1.0)
                    starts.append(before[j] + part * (after[j] - before[j]))
                before = after
        return np.array(starts, dtype=complex)

    def index(self, s: complex, speed: float) -> int:
        """Of a root under tables over the frequency: −1 where its path overtakes its frequency."""
        if self.knots.size < 2 or s.imag <= 0.0:
            return 1
        by, step = self.units(s, speed), 1e-7 * abs(s)
        left, _, right = la.svd(self.scaled(s, speed, by))
        y, x = left[:, -1].conj() / by, right[-1].conj() / by
        frozen = [m + 0j for m in self.frozen(speed, s.imag)]
        ahead, behind = (self.frozen(speed, s.imag + side * step) for side in (1.0, -1.0))
        bent = sum(
            s**p * (a - b) / (2.0 * step) for p, a, b in zip((2, 1, 0), ahead, behind, strict=True)
        )
        own = y @ (2.0 * s * frozen[0] + frozen[1]) @ x
        return int(np.sign(1.0 + (y @ bent @ x / own).imag)) or 1

    def growth(self, speed: float) -> tuple[float, float, float]:
        """The largest growth beyond rounding, what may be one, and that of index −1."""
        values, unsure = self.roots(speed, np.inf)
        sure = values.real > 3.0 * unsure + 1e-12 * np.abs(values).max(initial=0.0)
        neutral = values.real <= NEUTRAL * np.abs(values)
        index = np.array([self.index(s, speed) if s.real > 0 else 1 for s in values], dtype=int)
        possible = (index > 0) & (values.real > 0.1 * NEUTRAL * np.abs(values))
        kinds = (sure & ~neutral & (index > 0), possible, sure & (index < 0))
        grows, possibly, turned = (float(values.real[k].max(initial=0.0)) for k in kinds)
        return grows, possibly, turned

    def response(self, speed: float, at: str, moment: float, phase: float) -> tuple[Array, float]:
        """Motion of all coordinates to an unbalance, and the part of it that may be rounding."""
        ratio = float(self.of(f"matrices/ratios/{at.split('.')[0]}"))
        omega, sense = abs(ratio) * speed, np.sign(ratio)
        rows = self.of(f"matrices/seats/{at}")
        force = moment * omega**2 * np.exp(1j * sense * phase) * (rows[0] - 1j * sense * rows[1])
        by = self.units(1j * omega, speed)
        d = self.scaled(1j * omega, speed, by)
        return la.solve(d, force / by) / by, float(EPS * np.linalg.cond(d))


def _paired(before: Array, after: Array) -> tuple[Array, Array]:
    if before.size != after.size:  # a mass that is none: the nearest of the fewer
        few = min(before.size, after.size)
        before, after = (v[np.argsort(np.abs(v))[:few]] for v in (before, after))
    own, order = linear_sum_assignment(np.abs(before[:, None] - after[None]))
    return before[own], after[order]


def _quadratic_roots(mass: Array, velocity: Array, stiffness: Array) -> Array:
    """All finite roots of s²M + sV + K, inverted about a real place so that M may be singular."""
    n = len(mass)
    rates = np.sqrt(
        np.abs(np.diag(stiffness)[np.diag(mass) > 0] / np.diag(mass)[np.diag(mass) > 0])
    )
    shift = 1.37 * max(float(np.median(rates)), 1.0)
    here = shift**2 * mass + shift * velocity + stiffness
    rows, columns = np.ones(n), np.ones(n)
    for _ in range(3):
        rows = rows / np.abs(rows[:, None] * here * columns).max(axis=1)
        columns = columns / np.abs(rows[:, None] * here * columns).max(axis=0)
    held = la.lu_factor(rows[:, None] * here * columns)
    solve = lambda m: la.lu_solve(held, rows[:, None] * m * columns)  # noqa: E731
    # s = shift + 1/μ: (here μ² + (2 shift M + V) μ + M) x = 0
    state = np.block(
        [[-solve(2.0 * shift * mass + velocity), -solve(mass)], [np.eye(n), np.zeros((n, n))]]
    )
    inverse = la.eigvals(state)
    inverse = inverse[np.abs(inverse) > 1e-14 * np.abs(inverse).max()]
    values = shift + 1.0 / inverse
    return values[np.abs(values) < 1e12]


# --- laws -----------------------------------------------------------------------------------------


def _mirrored(matrix: Array, law: dict[str, Any]) -> Array:
    if not law["mirrored"]:
        return matrix
    sides = np.array([1.0, -1.0, -1.0, 1.0])[: matrix.shape[-1]]
    return matrix * np.outer(sides, sides)


def _interpolated(speeds: Array, values: Array, how: str, speed: float) -> Array:
    at = float(np.clip(speed, speeds[0], speeds[-1]))
    if str(how) == "monotone":
        return np.asarray(PchipInterpolator(speeds, values, axis=0)(at))
    k = int(np.clip(np.searchsorted(speeds, at, side="right") - 1, 0, speeds.size - 2))
    part = (at - speeds[k]) / (speeds[k + 1] - speeds[k])
    return (1.0 - part) * values[k] + part * values[k + 1]


def _over_speed(law: dict[str, Any], speed: float) -> list[Array]:
    known = law.setdefault("kept", {})
    if speed not in known:
        if len(known) > 20:
            known.clear()
        known[speed] = _of_speed(law, speed)
    return known[speed]


def _of_speed(law: dict[str, Any], speed: float) -> list[Array]:
    if law["kind"] == "polynomial":
        at = partial(np.polynomial.polynomial.polyval, speed)
        return [
            float(law[own]) * np.diag([at(_factor(law, f"{part}_{axis}")) for axis in "xy"])
            for own, part in (("k", "stiffness"), ("c", "damping"))
        ]
    rows = (_interpolated(law["speeds"], law[m], law["interpolation"], speed) for m in "kc")
    return [_mirrored(row, law) for row in rows]


def _factor(law: dict[str, Any], name: str) -> Array:
    return np.asarray(law[name], dtype=float)


def _rows_at(law: dict[str, Any], speed: float) -> list[Array]:
    """K, C and M at one speed and all frequencies of a table; of the last few speeds kept."""
    known = law.setdefault("kept", {})
    if speed not in known:
        if len(known) > 20:
            known.clear()
        rows = (_interpolated(law["speeds"], law[m], law["interpolation"], speed) for m in "kcm")
        known[speed] = [_mirrored(row, law) for row in rows]
    return known[speed]


def _over_frequency(law: dict[str, Any], speed: float, frequency: float) -> list[Array]:
    known = law["frequencies"]
    at = float(np.clip(frequency, known[0], known[-1]))
    k = int(np.clip(np.searchsorted(known, at, side="right") - 1, 0, known.size - 2))
    part = (at - known[k]) / (known[k + 1] - known[k])
    return [(1.0 - part) * m[k] + part * m[k + 1] for m in _rows_at(law, speed)]


def _controller(law: dict[str, Any], s: complex, is_series: bool) -> Array:
    """H(s), (2, 2), its factors one by one."""
    if "a" in law:
        return law["d"] + law["c"] @ la.solve(s * np.eye(2) - law["a"], law["b"])
    return np.diag([_chain(law[axis], s, is_series) for axis in "xy"])


def _chain(chain: dict[str, Any], s: complex, is_series: bool) -> complex:
    p, i, d, roll_off = chain["pid"]
    value = p + (i / s if i else 0.0) + d * s / (1.0 + s / roll_off if roll_off else 1.0)
    for kind, *own in chain["filters"]:
        if kind == "delay" and not is_series:
            value = value * np.exp(-s * own[0])
        else:
            over, under = _quotient(kind, own)
            value = value * np.polyval(over, s) / np.polyval(under, s)
    return complex(value)


def _quotient(kind: str, own: list[float]) -> tuple[list[float], list[float]]:
    """Numerator and denominator of a filter, highest power first."""
    if kind == "low_pass":
        cut, zeta = own
        return [1.0], [cut**-2, 2.0 * zeta / cut, 1.0] if zeta else [1.0 / cut, 1.0]
    if kind == "notch":
        centre, depth, width = own
        return [1.0, 2.0 * depth * centre, centre**2], [1.0, 2.0 * width * centre, centre**2]
    if kind == "lag":
        return [1.0, own[0]], [1.0, own[1]]
    t = own[0]  # of a delay, third order
    return [-(t**3), 12.0 * t**2, -60.0 * t, 120.0], [t**3, 12.0 * t**2, 60.0 * t, 120.0]


def _state_spaces(law: dict[str, Any]) -> list[tuple[Array, Array, Array, Array, float, slice]]:
    """a, b, c, d and the gain of the rate of each axis, good enough to begin from."""
    if "a" in law:
        return [(law["a"], law["b"], law["c"], law["d"], 0.0, slice(0, 2))]
    out = []
    for k, axis in enumerate("xy"):
        p, i, d, roll_off = law[axis]["pid"]
        over, under = np.poly1d([p]), np.poly1d([1.0])
        if i:
            over, under = over * np.poly1d([1.0, 0.0]) + i, under * np.poly1d([1.0, 0.0])
        own = np.poly1d([1.0 / roll_off, 1.0]) if roll_off else np.poly1d([1.0])
        over, under = over * own + under * np.poly1d([d, 0.0]), under * own
        for kind, *numbers in law[axis]["filters"]:
            a, b = _quotient(kind, numbers)
            over, under = over * np.poly1d(a), under * np.poly1d(b)
        rate = 0.0
        if over.order > under.order:
            whole, over = over / under
            rate, over = float(whole.coeffs[0]), over + under * float(whole(0.0))
        if under.order == 0:
            empty = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0))
            out.append((*empty, np.array([[over(0.0) / under(0.0)]]), rate, slice(k, k + 1)))
            continue
        a, b, c, direct = tf2ss(over.coeffs, under.coeffs)
        a, (scale, _) = la.matrix_balance(a, permute=False, separate=True)
        out.append((a, b / scale[:, None], c * scale, direct, rate, slice(k, k + 1)))
    return out


# --- asymmetric -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Turning:
    """A machine in the frame of its body: terms by harmonic of the angle and power of the speed."""

    stored: dict[str, Array]
    order: int = 8

    @cached_property
    def terms(self) -> dict[str, list[tuple[int, int, Array]]]:
        """Harmonic, power and matrix of the terms of V and K."""
        out: dict[str, list[tuple[int, int, Array]]] = {}
        for part in ("velocity", "stiffness"):
            count = sum(
                k.startswith(f"terms/{part}/") and k.endswith("/power") for k in self.stored
            )
            at = [f"terms/{part}/{k}" for k in range(count)]
            out[part] = [
                (
                    int(self.stored[f"{k}/harmonic"]),
                    int(self.stored[f"{k}/power"]),
                    self.stored[f"{k}/matrix"],
                )
                for k in at
            ]
        return out

    @property
    def stride(self) -> int:
        """Periods in a turn."""
        return int(self.stored["terms/stride"])

    def parts(self, name: str, speed: complex) -> dict[int, Array]:
        """V or K by harmonic at a speed."""
        out: dict[int, Array] = {}
        for h, power, matrix in self.terms[name]:
            out[h] = out.get(h, 0.0) + speed**power * matrix
        return out

    def matrix(self, s: complex, speed: complex, offset: int = 0) -> Array:
        """Hill's matrix of e^{st} Σ q_h e^{ihΩt} over h = offset + stride · k."""
        hs = offset + max(self.stride, 1) * np.arange(-self.order, self.order + 1)
        hs = hs if self.stride else hs[:1] * 0 + offset
        velocity, stiffness = self.parts("velocity", speed), self.parts("stiffness", speed)
        mass = self.stored["terms/mass"]
        zero = np.zeros_like(mass)
        rows = []
        for a in hs:
            row = []
            for b in hs:
                rate = s + 1j * b * speed
                d = rate * velocity.get(a - b, zero) + stiffness.get(a - b, zero)
                row.append(d + rate**2 * mass if a == b else d)
            rows.append(row)
        return np.block(rows)

    def units(self, s: complex, speed: float, offset: int = 0) -> Array:
        """As of `Dynamic`."""
        return np.sqrt(np.abs(self.matrix(s, speed, offset)).max(axis=1))

    def root(self, s: complex, speed: float) -> Settled:
        """Whether s is an exponent at a speed."""
        by = self.units(s, speed)
        return settled(
            lambda z: self.matrix(z, speed) / np.outer(by, by), s, max(abs(s), 1e-3 * speed)
        )

    def critical(self, speed: complex, offset: int) -> Settled:
        """Whether a complex speed makes the matrix of steady motions singular."""
        by = self.units(0.0, speed.real, offset)
        return settled(lambda v: self.matrix(0.0, v, offset) / np.outer(by, by), speed, abs(speed))

    def growth(self, speed: float) -> float:
        """Largest growth from the state over one period by steps of the fourth order.

        Not a number where that takes too many steps.
        """
        mass = la.inv(self.stored["terms/mass"])
        velocity, stiffness = (
            {h: mass @ a for h, a in self.parts(p, speed).items()}
            for p in ("velocity", "stiffness")
        )
        n, period = len(mass), 2.0 * np.pi / max(self.stride, 1)
        fast = np.sqrt(max(la.norm(a, 2) for a in stiffness.values())) + max(
            la.norm(a, 2) for a in velocity.values()
        )
        steps = int(max(np.ceil(period / speed * fast / 0.05), 100))
        if steps > MANY:
            return np.nan

        def rates(angle: float) -> Array:
            k, v = (
                (sum((np.exp(1j * h * angle) * a) for h, a in m.items())).real
                for m in (stiffness, velocity)
            )
            return np.block([[np.zeros((n, n)), np.eye(n)], [-k, -v]]) / speed

        state, step = np.eye(2 * n), period / steps
        root = np.sqrt(3.0) / 6.0
        for j in range(steps):
            first, second = (rates((j + 0.5 + side * root) * step) for side in (-1.0, 1.0))
            mean = 0.5 * step * (first + second)
            turned = np.sqrt(3.0) / 12.0 * step**2 * (second @ first - first @ second)
            state = la.expm(mean + turned) @ state
        largest = np.abs(la.eigvals(state)).max()
        return float(np.log(largest) * speed / period)

    def steady(self, speed: float, load: Array) -> dict[int, Array]:
        """Motion by harmonic to a load that stands still in the frame."""
        n = len(load)
        by = self.units(0.0, speed)
        count = len(by) // n
        force = np.zeros(len(by), dtype=complex)
        force[(count // 2) * n : (count // 2 + 1) * n] = load
        found = la.solve(self.matrix(0.0, speed) / np.outer(by, by), force / by) / by
        hs = max(self.stride, 1) * np.arange(-(count // 2), count // 2 + 1)
        return {int(h): part for h, part in zip(hs, found.reshape(count, n), strict=True)}
