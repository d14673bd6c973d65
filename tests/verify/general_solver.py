"""An independent solver of rigid rotors on bearings: numpy and scipy alone, every root at once.

It reads the content of a scene file (a dict) and shares nothing with the program: bodies in six
motions about their centres of gravity, in the inertial frame, rigid joints by a null space, laws
by `numpy.interp`, `PchipInterpolator` and `polyval`, eigenvalues by the full state matrix.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import scipy.linalg as la
from scipy.interpolate import PchipInterpolator
from scipy.optimize import linear_sum_assignment

RPM = np.pi / 30.0
EPS = np.finfo(float).eps
MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
# Signs of (ux ... rz) pairs in a mirror that turns y round.
MIRROR = np.ones((6, 6))
MIRROR[0, 1] = MIRROR[1, 0] = MIRROR[3, 4] = MIRROR[4, 3] = -1.0
# Roots slower than this part of the fastest are zeros of rigid motion with their rounding.
ZERO = 3e-7
# Growth below this part of |λ| is neutral.
NEUTRAL = 1e-8


@dataclass(frozen=True, kw_only=True, eq=False)
class Law:
    """A speed-dependent 2 × 2 pair: rows of motion (2, n), speed ratio, and its coefficients."""

    motion: np.ndarray
    ratio: float
    pair: object
    knots_rad_s: tuple[float, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class General:
    """M, C, G, K (n, n) at unit speed of the reference shaft, the terms of K, and the laws."""

    mass: np.ndarray
    damping: np.ndarray
    gyroscopic: np.ndarray
    stiffness: np.ndarray
    terms: np.ndarray
    laws: tuple[Law, ...]
    seats: dict = field(default_factory=dict)
    ratios: dict = field(default_factory=dict)

    @property
    def knots_rad_s(self):
        found = {k / abs(w.ratio) for w in self.laws if w.ratio for k in w.knots_rad_s}
        return np.array(sorted(found))

    def at(self, speed):
        """M, C + ΩG and K at a speed [rad/s]."""
        damping, stiffness = self.damping + speed * self.gyroscopic, self.stiffness.copy()
        for law in self.laws:
            k, c = law.pair(abs(law.ratio * speed))
            stiffness = stiffness + law.motion.T @ k @ law.motion
            damping = damping + law.motion.T @ c @ law.motion
        return self.mass, damping, stiffness

    def cancelled(self, speed):
        """Sizes of the terms that K at a speed is the sum of, which its rounding goes by."""
        return self.terms + sum(
            np.abs(w.motion).T @ np.abs(w.pair(abs(w.ratio * speed))[0]) @ np.abs(w.motion)
            for w in self.laws
        )


class Spectrum(NamedTuple):
    """Eigenvalues (2n,) and bounds of what rounding makes of each."""

    values: np.ndarray
    rounding: np.ndarray


def general(scene) -> General:
    """The system of a scene of rigid bodies, as the content of its file."""
    bodies = scene["rigid_bodies"]
    start = {name: 6 * k for k, name in enumerate(bodies)}
    n = 6 * len(bodies)
    mass, gyroscopic = np.zeros((n, n)), np.zeros((n, n))
    seats = {}
    for name, body in bodies.items():
        at = slice(start[name], start[name] + 6)
        mass[at, at] = np.diag([body["mass_kg"]] * 3 + list(body["inertia_kg_m2"]))
        rx, ry = start[name] + 3, start[name] + 4
        polar = body.get("speed_ratio", 0.0) * body["inertia_kg_m2"][2]
        gyroscopic[rx, ry], gyroscopic[ry, rx] = polar, -polar
        for place, z in body["interfaces"].items():
            rows = np.zeros((6, n))
            rows[:, at] = np.eye(6)
            arm = z - body["center_of_gravity_m"][2]
            rows[0, ry], rows[1, rx] = arm, -arm  # u = t + θ × z
            seats[f"{name}.{place}"] = rows
    ratios = {name: body.get("speed_ratio", 0.0) for name, body in bodies.items()}
    damping, stiffness, terms = (np.zeros((n, n)) for _ in range(3))
    laws, held = [], []
    for bearing in scene.get("bearings", ()):
        rows = seats[bearing["first"]]
        if bearing.get("second", "ground") != "ground":
            rows = rows - seats[bearing["second"]]
        held += [rows[MOTIONS.index(c)] for c in bearing.get("rigid", ())]
        ratio = ratios[bearing["first"].split(".")[0]]
        k, c = _constant(bearing)
        backward = _is_mirrored(scene, bearing, ratios)
        k, c = (m * MIRROR if backward else m for m in (k, c))
        if "speed_law" in bearing:
            law = scene["speed_laws"][bearing["speed_law"]]
            knots = tuple(np.array(law.get("speed_rpm", ())) * RPM)
            pair = _pair(law, k[:2, :2].copy(), c[:2, :2].copy(), backward)
            laws.append(Law(motion=rows[:2], ratio=ratio, pair=pair, knots_rad_s=knots))
            k[:2, :2] = c[:2, :2] = 0.0
        stiffness += rows.T @ k @ rows
        terms += np.abs(rows).T @ np.abs(k) @ np.abs(rows)
        damping += rows.T @ c @ rows
    for gear in scene.get("gears", ()):
        teeth = seats[gear["first"]][5] - seats[gear["second"]][5] / gear["ratio"]
        if "mesh_stiffness_n_per_m" in gear:
            teeth = teeth * gear["base_radius_first_m"]
            stiffness += gear["mesh_stiffness_n_per_m"] * np.outer(teeth, teeth)
            terms += gear["mesh_stiffness_n_per_m"] * np.abs(np.outer(teeth, teeth))
            damping += gear.get("mesh_damping_n_s_per_m", 0.0) * np.outer(teeth, teeth)
        else:
            held.append(teeth)
    basis = la.null_space(np.array(held)) if held else np.eye(n)
    basis = basis[:, np.abs(basis).max(axis=0) > 0]
    inside = lambda a: basis.T @ a @ basis  # noqa: E731
    laws = tuple(
        Law(motion=w.motion @ basis, ratio=w.ratio, pair=w.pair, knots_rad_s=w.knots_rad_s)
        for w in laws
    )
    return General(
        mass=inside(mass),
        damping=inside(damping),
        gyroscopic=inside(gyroscopic),
        stiffness=inside(stiffness),
        terms=np.abs(basis).T @ terms @ np.abs(basis),
        laws=laws,
        seats={key: rows @ basis for key, rows in seats.items()},
        ratios=ratios,
    )


def _is_mirrored(scene, bearing, ratios):
    """Whether rotation makes cross terms of a bearing, and its shaft turns backward."""
    if bearing.get("cross_coupling", "with_spin") == "as_given":
        return False
    ends = (bearing["first"], bearing.get("second", "ground"))
    spins = [ratios[e.split(".")[0]] for e in ends if e != "ground"]
    if next((s for s in spins if s), 0.0) >= 0.0:
        return False
    matrices = list(_constant(bearing))
    law = scene.get("speed_laws", {}).get(bearing.get("speed_law"), {})
    for key in ("stiffness_n_per_m", "damping_n_s_per_m"):
        matrices += [np.array(row) for row in law.get(key, ())]
    return any(not np.array_equal(m, m.T) for m in matrices)


def _constant(bearing):
    """Stiffness and damping of a bearing, each (6, 6)."""
    found = []
    for axial, tilt in (("stiffness", "stiffness"), ("damping", "damping")):
        unit, turn = ("n", "n_m") if axial == "stiffness" else ("n_s", "n_m_s")
        matrix = np.zeros((6, 6))
        matrix[:2, :2] = bearing.get(f"{axial}_{unit}_per_m", np.zeros((2, 2)))
        matrix[3:5, 3:5] = bearing.get(f"tilt_{tilt}_{turn}_per_rad", np.zeros((2, 2)))
        matrix[2, 2] = bearing.get(f"axial_{axial}_{unit}_per_m", 0.0)
        matrix[5, 5] = bearing.get(f"torsion_{axial}_{turn}_per_rad", 0.0)
        found.append(matrix)
    return found


def _pair(law, own_k, own_c, backward):
    """The function from a spin speed [rad/s] to stiffness and damping, each (2, 2)."""
    if law["kind"] == "polynomial":
        unit = {"rad/s": 1.0, "rpm": 1.0 / RPM, "Hz": 0.5 / np.pi}[law["argument_unit"]]

        def polynomial(speed):
            x = unit * speed
            factor = {
                key: np.polynomial.polynomial.polyval(x, law.get(key, (1.0,)))
                for key in ("stiffness_x", "stiffness_y", "damping_x", "damping_y")
            }
            k = np.diag([own_k[0, 0] * factor["stiffness_x"], own_k[1, 1] * factor["stiffness_y"]])
            c = np.diag([own_c[0, 0] * factor["damping_x"], own_c[1, 1] * factor["damping_y"]])
            return k, c

        return polynomial
    speeds = np.array(law["speed_rpm"], dtype=float) * RPM
    values = np.hstack(
        [
            np.array(law[f"{key}"], dtype=float).reshape(speeds.size, 4)
            for key in ("stiffness_n_per_m", "damping_n_s_per_m")
        ]
    )
    smooth = PchipInterpolator(speeds, values) if law.get("interpolation") != "linear" else None

    def table(speed):
        if smooth is None:
            found = np.array([np.interp(speed, speeds, column) for column in values.T])
        else:
            found = smooth(np.clip(speed, speeds[0], speeds[-1]))
        sign = MIRROR[:2, :2] if backward else 1.0
        return sign * found[:4].reshape(2, 2), sign * found[4:].reshape(2, 2)

    return table


def state_matrix(system: General, speed):
    """First-order form in coordinates of unit mass, shape (2n, 2n)."""
    mass, damping, stiffness = system.at(speed)
    lower = la.cholesky(mass, lower=True)
    k, c = (_congruent(lower, a) for a in (stiffness, damping))
    scale = max(np.sqrt(la.norm(k)), la.norm(c) * 1e-3, 1e-30)
    n = len(mass)
    return np.block([[np.zeros((n, n)), np.eye(n) * scale], [-k / scale, -c]])


def spectrum(system: General, speed) -> Spectrum:
    """All eigenvalues at a speed [1/s] and the size of their rounding."""
    state = state_matrix(system, speed)
    values, left, right = la.eig(state, left=True, right=True)
    along = np.abs(np.einsum("ij,ij->j", left.conj(), right))
    condition = la.norm(left, axis=0) * la.norm(right, axis=0) / np.maximum(along, 1e-300)
    # the entries of K are rounded before the state matrix is made of them
    n = len(system.mass)
    lower = np.abs(la.inv(la.cholesky(system.mass, lower=True)))
    terms = lower @ system.cancelled(speed) @ lower.T / state[0, n]
    moved = np.einsum("ij,ij->j", np.abs(left[n:]), terms @ np.abs(right[:n]))
    bound = la.norm(state, 2) * condition + moved / np.maximum(along, 1e-300)
    return Spectrum(values, 8.0 * EPS * bound)


def _congruent(lower, matrix):
    inner = la.solve_triangular(lower, matrix, lower=True)
    return la.solve_triangular(lower, inner.T, lower=True).T


def motions(found: Spectrum):
    """Which eigenvalues are no zeros of rigid motion."""
    size = np.abs(found.values)
    return size > np.maximum(ZERO * size.max(), 3.0 * np.minimum(found.rounding, size.max()))


def grid(system: General, top, count=400):
    """Speeds from rest to the top with every knot and its neighbours [rad/s]."""
    knots = system.knots_rad_s
    knots = knots[(knots > 0) & (knots < top)]
    between = 0.5 * (knots[1:] + knots[:-1])
    return np.unique(np.concatenate((np.linspace(0.0, top, count + 1), knots, between)))


def _above(system, ratio, speed):
    """Eigenvalues with Im λ above the line of an excitation: changed by crossings alone."""
    return int(np.count_nonzero(la.eigvals(state_matrix(system, speed)).imag > ratio * speed))


def critical_speeds(system: General, ratio, top, count=400):
    """Speeds [rad/s] where some eigenvalue has Im λ = ratio · Ω, and that eigenvalue.

    Net changes of the number above the line in every interval of a dense grid are bracketed; two
    crossings within one interval that cancel are not seen.
    """
    speeds = grid(system, top, count)[1:]
    counts = [_above(system, ratio, s) for s in speeds]
    found = []
    for low, high, first, last in zip(speeds, speeds[1:], counts, counts[1:], strict=False):
        if first != last:
            found += _isolated(system, ratio, low, high, first, last)
    return found


def _isolated(system, ratio, low, high, first, last):
    middle = 0.5 * (low + high)
    if high - low <= 1e-13 * high or middle in (low, high):
        found = spectrum(system, middle)
        order = np.argsort(np.abs(found.values.imag - ratio * middle))[: abs(first - last)]
        return [(middle, complex(found.values[k]), float(found.rounding[k])) for k in order]
    there = _above(system, ratio, middle)
    out = _isolated(system, ratio, low, middle, first, there) if there != first else []
    return out + (_isolated(system, ratio, middle, high, there, last) if there != last else [])


def unstable_intervals(system: General, top, count=2000):
    """Intervals [rad/s] where a motion grows, by dense sampling and bisection of the ends."""
    speeds = grid(system, top, count)
    grows = [is_unstable(system, s) for s in speeds]
    out, begin = [], speeds[0] if grows[0] else None
    for low, high, first, last in zip(speeds, speeds[1:], grows, grows[1:], strict=False):
        if first != last:
            end = _changed(system, low, high, first)
            if last:
                begin = end
            else:
                out.append((begin, end))
    return [*out, (begin, speeds[-1])] if grows[-1] else out


def _changed(system, low, high, first):
    while high - low > 1e-11 * high:
        middle = 0.5 * (low + high)
        if is_unstable(system, middle) == first:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def is_unstable(system, speed):
    """Whether a motion grows by more than rounding and 1e-8 of its frequency."""
    values = la.eigvals(state_matrix(system, speed))
    size = np.abs(values).max(initial=0.0)
    rate = values.real.max(initial=0.0)
    if rate <= 1e-14 * size:
        return False
    if rate > 1e-3 * size:
        return True
    found = spectrum(system, speed)
    allowed = 30.0 * found.rounding + NEUTRAL * np.abs(found.values) + 1e-14 * size
    return bool((found.values.real > allowed).any())


def growth(system, speed):
    """Whether some motion grows beyond doubt, and whether one may: (bool, bool).

    Doubt is what rounding may add or take, and a factor of ten in what counts as neutral, as
    intervals may be open down to where nothing grows at all.
    """
    found = spectrum(system, speed)
    doubt = 30.0 * found.rounding + 1e-14 * np.abs(found.values).max(initial=0.0)
    rate, neutral = found.values.real, NEUTRAL * np.abs(found.values)
    possibly = (rate > 0.1 * neutral - doubt) & motions(found)
    return bool((rate > 10.0 * neutral + doubt).any()), bool(possibly.any())


def response(system: General, unbalances, speeds):
    """Amplitudes (s, n) and bounds of their rounding (s,) by |speed ratio| of the unbalances."""
    groups = {}
    for item in unbalances:
        ratio = system.ratios[item["at"].split(".")[0]]
        groups.setdefault(abs(ratio), []).append((item, 1.0 if ratio > 0 else -1.0))
    out = {}
    for ratio, own in groups.items():
        found, bounds = [], []
        for speed in speeds:
            omega = ratio * speed
            load = np.zeros(len(system.mass), dtype=complex)
            for item, sense in own:
                phase = np.radians(item.get("phase_deg", 0.0))
                force = item["moment_kg_m"] * omega**2 * np.exp(1j * sense * phase)
                rows = system.seats[item["at"]]
                load += force * (rows[0] - 1j * sense * rows[1])
            mass, damping, stiffness = system.at(speed)
            dynamic = stiffness + 1j * omega * damping - omega**2 * mass
            scale = 1.0 / np.sqrt(
                np.maximum(np.abs(np.diag(stiffness)), 0) + omega**2 * np.diag(mass) + 1e-300
            )
            even = scale[:, None] * dynamic * scale
            found.append(scale * la.lstsq(even, scale * load)[0] if omega else 0.0 * load)
            bounds.append(EPS * np.linalg.cond(even))
        out[ratio] = (np.array(found), np.array(bounds))
    return out


def matched(first, second):
    """Pair two lists of numbers of least total distance: indices into both."""
    cost = np.abs(np.subtract.outer(first, second)) / np.abs(first)[:, None]
    return linear_sum_assignment(np.log(cost + 1e-18))
