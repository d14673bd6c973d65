"""Speeds at which a load that keeps step with the turn meets a motion of the system.

A load e^{ihθ} in the frame of the body (h = 0: unbalance, bow; h = ±1: weight) excites without
limit where D(Ω) = λ²M + λV(Ω) + K(Ω) of Hill's expansion at λ = ihΩ is singular. Constant bearings
make D a quadratic polynomial of Ω, whose roots are all found at once; with damping they are
complex.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.errors import dynamic_change
from solidwhirl.rotordyn.asymmetric.parametric.basis import fastest_rate, held_to, search_basis
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics, PeriodicSystem
from solidwhirl.rotordyn.asymmetric.response import dynamic_stiffness, held_where_free, seen
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.estimates.eigenvalue_errors import without_forms
from solidwhirl.rotordyn.modes.kinds import family_energy, kinds, moves_laterally, shares_of
from solidwhirl.rotordyn.superelement.families import FAMILIES

# Harmonics on either side to begin with, and at most.
_FIRST, _MOST = 3, 12
# Answers of fast motions that roots are sought with.
_ANSWER = 3e-4
# Roots that move less when a harmonic is added have settled; steps of the iteration.
_SETTLED, _STEPS = 1e-9, 30
# Roots with more damping than this are no resonance.
_DAMPED = 0.5
# Of the speed: step of a difference, a step that has lost its root, and one that has found it.
_FAR, _LOST, _EXACT = 1e-6, 0.2, 1e-13
# Part of the motion in loads of the kind asked for, from which on they excite a root.
_EXCITED = 1e-6
# Smallest singular value over the largest that is rounding.
_SINGULAR = 1e-15
# Parts that the speeds between two knots of a table are cut into.
_PARTS = 4


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Resonance(ReadOnlyArrays):
    """Hold a speed at which a load that keeps step with the turn is in resonance.

    `speed_rad_s`: of the frame. `damping_ratio`: −Im Ω / |Ω| of the complex root; 0: the motion
    grows without limit. `multiple`: of the speed, with its sign (1: forward at the speed, 2: twice,
    −1: backward), that most of the motion of interfaces is seen with in fixed axes; `share`: its
    part of it. `shares`: of the kinetic energy by family, lateral, torsional, axial and disk,
    shape (4,). `errors`: relative error estimates by part: what bodies left out ("mesh",
    "mode_truncation"), and how far the last harmonic moved it ("harmonics").
    """

    speed_rad_s: float
    damping_ratio: float
    shares: FloatArray
    multiple: int
    share: float
    errors: Mapping[str, float]

    @property
    def motion(self) -> str:
        """The family with most of the energy."""
        return FAMILIES[int(self.shares.argmax())]

    @property
    def kind(self) -> str:
        """Lateral, torsional, axial, disk or coupled."""
        return str(kinds(self.shares))

    @property
    def moves_laterally(self) -> bool:
        """Whether it is lateral, or coupled with lateral motion."""
        return bool(moves_laterally(self.shares))

    @property
    def error(self) -> float:
        """Sum of the error estimates, relative."""
        return float(sum(self.errors.values()))

    @property
    def is_estimated(self) -> bool:
        """Whether the bodies tell what they left out."""
        return bool(self.errors.keys() - {"harmonics"})


def critical_speeds(rotating: RotatingSystem, low: float, high: float) -> tuple[Resonance, ...]:
    """Return the speeds at which loads fixed to the body, as unbalance, are in resonance."""
    n = rotating.periodic.size
    rows = [rotating.seat(end) for end in rotating.turning_ends()]
    loads = [{0: sum(part[:2] for part in seat.values())} for seat in rows]
    given = np.vstack([load[0].real for load in loads]) if loads else np.zeros((0, n))
    return resonances(rotating, {0: given.T}, (low, high))


def gravity_critical_speeds(
    rotating: RotatingSystem, low: float, high: float
) -> tuple[Resonance, ...]:
    """Return the speeds at which the weight, which turns backward in the body, is in resonance.

    About half of the critical speeds of the mean of both planes.
    """
    loads: Harmonics = {}
    for name, rotor in rotating.system.rotors.items():
        rows = rotating.transformation[rotating.body_slices[name]]
        if name in rotating.turned:
            element = rotor.element
            momentum = rows.T @ element.mass @ element.rigid_body_modes[:, :2]
            for h, side in ((1, 1j), (-1, -1j)):
                loads[h] = loads.get(h, 0.0) + momentum @ np.array([[1.0], [side]])
    return resonances(rotating, loads, (low, high))


def resonances(
    rotating: RotatingSystem, loads: Harmonics, speeds_rad_s: tuple[float, float]
) -> tuple[Resonance, ...]:
    """Return the resonances of loads of one parity, rising.

    `loads`: (n, k) by harmonic. `speeds_rad_s`: lowest and highest speed of the frame, above 0.
    """
    low, high = speeds_rad_s
    periodic = held_where_free(rotating, high)
    rotating = replace(rotating, periodic=periodic)
    stride = periodic.stride
    few = periodic
    if stride:
        few = held_to(periodic, search_basis(periodic, fastest_rate(periodic, high), high, _ANSWER))
    offsets = sorted({h % stride for h in loads}) if stride else sorted(loads)
    found: list[Resonance] = []
    for offset in offsets:
        given = {h: f for h, f in loads.items() if (h - offset) % stride == 0} if stride else {
            offset: loads[offset]
        }  # fmt: skip
        order = _FIRST + int(stride == 1) if stride else 0
        for root in _roots(few, offset, order, (low, high)):
            settled = _settled(few, offset, order, root)
            one = settled and _resonance(rotating, given, offset, settled)
            if one is not None and low <= one.speed_rad_s <= high:
                found.append(one)
    return _distinct(found)


def _roots(
    periodic: PeriodicSystem, offset: int, order: int, speeds: tuple[float, float]
) -> list[complex]:
    """Roots of D(Ω) in a range; between knots of tables those of its quadratic interpolation."""
    low, high = speeds
    ends = [low, high]
    if periodic.laws:
        knots = {k for joint, _ in periodic.laws for k in joint.knots_rad_s if low < k < high}
        cut = sorted({low, high, *knots})
        ends = sorted({*np.concatenate([np.linspace(a, b, _PARTS + 1) for a, b in pairwise(cut)])})
    found: list[complex] = []
    for start, end in pairwise(ends):
        middle, half = 0.5 * (start + end), 0.5 * (end - start)
        below, here, above = (
            dynamic_stiffness(periodic, p, offset, order) for p in (start, middle, end)
        )
        slope, bend = 0.5 * (above - below), 0.5 * (above + below) - here
        for x in _quadratic_roots(here, slope, bend):
            root = middle + half * x
            inside = start - 0.1 * half <= root.real <= end + 0.1 * half
            if inside and abs(root.imag) <= _DAMPED * abs(root):
                found.append(complex(root))
    return found


def _quadratic_roots(here: ComplexArray, slope: ComplexArray, bend: ComplexArray) -> ComplexArray:
    """Roots x of A + xB + x²C, as reciprocals of eigenvalues.

    A is singular where it is so at every speed: what nothing holds has no steady motion under the
    load, and no resonance.
    """
    n = len(here)
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(here)), np.abs(here).max(axis=1)))
    here, slope, bend = (scale[:, None] * a * scale for a in (here, slope, bend))
    if np.linalg.cond(here) * _SINGULAR > 1.0:
        return np.zeros(0, dtype=complex)
    companion = np.zeros((2 * n, 2 * n), dtype=complex)
    companion[:n] = -la.solve(here, np.hstack((slope, bend)))
    companion[n:, :n] = np.eye(n)
    inverse = la.eigvals(companion)
    inverse = inverse[np.abs(inverse) > 1e-3]
    return np.asarray(1.0 / inverse)


class _Settled(NamedTuple):
    """A root in few coordinates: with `order` harmonics on either side, and what more change.

    `moved`: by the last of them, relative.
    """

    root: complex
    order: int
    change: complex
    moved: float


def _settled(periodic: PeriodicSystem, offset: int, order: int, root: complex) -> _Settled | None:
    """A root followed while harmonics are added; None: it goes away."""
    if not periodic.stride:
        return _Settled(root, 0, 0.0, 0.0)
    before = first = root
    for more in range(order, _MOST + 1):
        polished = _newton(periodic, offset, more, before)
        if polished is None:
            return None
        moved = abs(polished[0] - before) / abs(before)
        before = polished[0]
        first = before if more == order else first
        if more > order and moved <= _SETTLED:
            return _Settled(first, order, before - first, float(moved))
    return None


def _resonance(
    rotating: RotatingSystem, loads: Harmonics, offset: int, settled: _Settled
) -> Resonance | None:
    """A root in all coordinates; None: it is not there, or no load excites it."""
    periodic, order = rotating.periodic, settled.order
    polished = _newton(periodic, offset, order, settled.root)
    if polished is None:
        return None
    now, right, left, slope = polished
    now = now + settled.change
    harmonics = [offset + k * periodic.stride for k in range(-order, order + 1)]
    parts, dual = (
        dict(zip(harmonics, a.reshape(len(harmonics), -1), strict=True)) for a in (right, left)
    )
    pushed = [np.abs(dual[h].conj() @ f) for h, f in loads.items() if h in dual]
    size = max((float(np.abs(f).max()) for f in loads.values()), default=0.0)
    reach = float(np.abs(left).max()) * size
    if not pushed or max(float(p.max(initial=0.0)) for p in pushed) <= _EXCITED * reach:
        return None
    errors: dict[str, float] = {}
    if not without_forms(rotating.system.rotors):
        change = dynamic_change(rotating, 0.0, float(now.real), dual, parts)
        errors = {part: float(abs(c / slope / now)) for part, c in change.items()}
    if periodic.stride:
        errors["harmonics"] = settled.moved
    multiple, share = _most_seen(rotating, parts)
    return Resonance(
        speed_rad_s=float(now.real),
        damping_ratio=max(0.0, float(abs(now.imag) / abs(now))),
        shares=shares_of(family_energy(rotating, np.stack([*parts.values()], axis=1)).sum(axis=0)),
        multiple=multiple,
        share=share,
        errors=errors,
    )


def _newton(
    periodic: PeriodicSystem, offset: int, order: int, root: complex
) -> tuple[complex, ComplexArray, ComplexArray, complex] | None:
    """Root of D(Ω), its vector x, its left vector y, and yᴴD'x, by inverse iteration on both."""
    size = periodic.size * (2 * order + 1 if periodic.stride else 1)
    right = np.random.default_rng(size).standard_normal(size).astype(complex)
    left, slope = right.copy(), 1.0 + 0j
    for step in range(_STEPS):
        matrix = dynamic_stiffness(periodic, root, offset, order)
        scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.abs(matrix).max(axis=1)))
        factor = la.lu_factor(scale[:, None] * matrix * scale, check_finite=False)
        if not np.diag(factor[0]).all():
            # hit exactly: beside it the vectors are the same
            root = root * (1.0 + _EXACT)
            continue
        for _ in range(2 if step == 0 else 1):
            right = scale * la.lu_solve(factor, right / scale)
            left = scale * la.lu_solve(factor, left / scale, trans=2)
            right, left = right / la.norm(right), left / la.norm(left)
        far = _FAR * abs(root)
        ahead, behind = (dynamic_stiffness(periodic, root + d, offset, order) for d in (far, -far))
        slope = left.conj() @ ((ahead - behind) @ right) / (2.0 * far)
        change = -(left.conj() @ (matrix @ right)) / slope if slope else np.inf
        if not np.isfinite(change) or abs(change) > _LOST * abs(root):
            return None
        root = root + change
        if abs(change) <= _EXACT * abs(root):
            break
    return complex(root), right, left, complex(slope)


def _most_seen(rotating: RotatingSystem, motion: Harmonics) -> tuple[int, float]:
    """The multiple of the speed that turning interfaces move with most, and its part."""
    sizes: dict[int, float] = {}
    for end in rotating.turning_ends():
        for h, u in seen(rotating.seat(end), motion).items():
            # forward and backward circles of ux + i uy
            for multiple, circle in ((h, u[0] + 1j * u[1]), (-h, np.conj(u[0] - 1j * u[1]))):
                size = abs(circle) ** 2
                sizes[multiple] = sizes.get(multiple, 0.0) + size
    total = sum(sizes.values())
    if not total:
        return 0, 0.0
    best = max(sizes, key=lambda m: sizes[m])
    return best * rotating.sense, sizes[best] / total


def _distinct(found: Sequence[Resonance]) -> tuple[Resonance, ...]:
    """Resonances by rising speed; those that two expansions both found once."""
    out: list[Resonance] = []
    for one in sorted(found, key=lambda r: r.speed_rad_s):
        if out and abs(one.speed_rad_s - out[-1].speed_rad_s) <= 1e-7 * one.speed_rad_s:
            continue
        out.append(one)
    return tuple(out)
