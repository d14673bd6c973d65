"""Error estimates of the resonance peaks of a response: where they are and how high."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    SpeedMatrices,
    at_rate,
    matrices_at_speed,
    speed_derivative,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, freeze_arrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.estimates.eigenvalue_errors import (
    bodies_without_forms,
    body_forms,
    frozen_parts,
    sum_of_parts,
)
from solidwhirl.rotordyn.modes.nearby import balance_of
from solidwhirl.rotordyn.perturbation.left_vectors import dynamic_stiffness
from solidwhirl.rotordyn.response.unbalance import (
    Unbalance,
    frequency_ratio,
    spins_at,
    unbalance_loads,
)
from solidwhirl.rotordyn.response.unbalance_peaks import SUMMIT, ResonancePeak, summit
from solidwhirl.rotordyn.superelement.residual_energy import form_products, form_weight

# Where a peak has no half-power points, its summit is sought within this (relative).
_NARROW = 0.01
# Where a summit is tried, as fractions of the interval it is sought in.
_PROBES = np.array([-1.0, -1e-2, -SUMMIT, SUMMIT, 1e-2, 1.0])
# Two unbalances excite at one frequency if their ratios differ by less than this fraction.
_SAME_RATIO = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PeakErrors:
    """Hold relative error estimates of resonance peaks.

    `position_rad_s`: speed or frequency of the summits, found again between the samples, rad/s,
    shape (k,); `position`, `height`: relative errors of the speed or frequency of each peak, and of
    its height, by name of the part, shape (k,) each; heights are nan for a system without damping.
    "mode_truncation" holds the share of "speed_interpolation"; "eigen_solver" is that of the linear
    solution; "sampling" is how far a peak as it was given lies from the summit.
    `bodies_without_estimate`: bodies whose errors are not in the numbers.
    """

    position_rad_s: FloatArray
    position: Mapping[str, FloatArray]
    height: Mapping[str, FloatArray]
    bodies_without_estimate: tuple[str, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "position_rad_s")
        object.__setattr__(self, "position", frozen_parts(self.position))
        object.__setattr__(self, "height", frozen_parts(self.height))

    @property
    def position_total(self) -> FloatArray:
        """Sum of all parts of the position but "interface_coupling", shape (k,)."""
        return sum_of_parts(self.position)

    @property
    def height_total(self) -> FloatArray:
        """Sum of all parts of the height but "interface_coupling", shape (k,)."""
        return sum_of_parts(self.height)


class _Point(NamedTuple):
    """A place p on the way of a sweep: Ω, ω, the load (n,), and dD/dp as a function of s."""

    speed: float
    omega: float
    load: ComplexArray
    slope: Callable[[SpeedMatrices], ComplexArray]


class _Sweep(NamedTuple):
    """How Ω, ω and load depend on the place p, and the rows (r, n) whose Σ |row u| is drawn.

    At the knots it may have corners.
    """

    at: Callable[[float], _Point]
    rows: ComplexArray
    knots: tuple[float, ...] = ()


class _Solved(NamedTuple):
    """Solution u, adjoint z of the amplitude, the amplitude, matrices and the point."""

    motion: ComplexArray
    adjoint: ComplexArray
    amplitude: float
    matrices: SpeedMatrices
    point: _Point


def unbalance_peak_errors(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    peaks: Sequence[ResonancePeak],
    spin_rad_s: float | None = None,
) -> PeakErrors:
    """Estimate the errors of speed and height of the peaks of an unbalance response.

    `unbalances`: all that turn at one frequency, as in an `ExciterResponse`; `peaks`: of the major
    half axis of the orbit of `node` over the speed Ω; `spin_rad_s`: as for `unbalance_response`.
    Raises AnalysisError if the unbalances turn at different frequencies, or there is none,
    AssemblyError if the node does not exist or lacks ux or uy.

    With z of Dᵀz = l, l the gradient of the amplitude, the pole moves by
    zᵀ(E − Ω²ΔK2)u / (zᵀ(dD/dΩ)u), dD/dΩ along ω = αΩ, and the summit changes by Re zᵀ(E − Ω²ΔK2)u.
    """
    return _over_speed(assembled, unbalances, _circles(assembled, node), peaks, spin_rad_s)


def probe_peak_errors(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    direction_rad: float,
    peaks: Sequence[ResonancePeak],
) -> PeakErrors:
    """Estimate the errors of the peaks that a probe sees, as `unbalance_peak_errors`.

    `direction_rad`: in which the probe looks, from +x towards +y; `peaks`: of the amplitude along
    it over the speed Ω.
    """
    return _over_speed(assembled, unbalances, _probe(assembled, node, direction_rad), peaks)


def amplitude_error(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    direction_rad: float | None,
    speed_rad_s: float,
) -> float:
    """Estimate the relative error of the amplitude of an unbalance response at one speed Ω.

    `unbalances`, `node`: as of `unbalance_peak_errors`; `direction_rad`: of a probe, None for the
    major half axis of the orbit. Bodies without error forms add nothing.
    """
    rows = (
        _circles(assembled, node)
        if direction_rad is None
        else _probe(assembled, node, direction_rad)
    )
    solved = _solved(assembled, _unbalance_sweep(assembled, unbalances, rows), speed_rad_s)
    changes, solver = _changes(assembled, solved)
    sizes = {part: np.abs(change.real) for part, change in changes.items()}
    return float(sum_of_parts(sizes) + solver) / solved.amplitude


def _circles(assembled: AssembledSystem, node: End) -> ComplexArray:
    """Rows whose Σ |row u| is the major half axis of an orbit."""
    x, y = (interface_row(assembled, node.body, node.interface, c) for c in ("ux", "uy"))
    return np.asarray(np.stack((0.5 * (x + 1j * y), 0.5 * (x - 1j * y))), dtype=complex)


def _probe(assembled: AssembledSystem, node: End, direction_rad: float) -> ComplexArray:
    """Row of the motion along a direction."""
    x, y = (interface_row(assembled, node.body, node.interface, c) for c in ("ux", "uy"))
    seen = np.cos(direction_rad) * x + np.sin(direction_rad) * y
    return np.asarray(seen[None], dtype=complex)


def _over_speed(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    rows: ComplexArray,
    peaks: Sequence[ResonancePeak],
    spin_rad_s: float | None = None,
) -> PeakErrors:
    """Errors of peaks of Σ |row u| over the speed, rows (r, n)."""
    sweep = _unbalance_sweep(assembled, unbalances, rows, spin_rad_s)
    return _peak_errors(assembled, sweep, peaks)


def _unbalance_sweep(
    assembled: AssembledSystem,
    unbalances: Sequence[Unbalance],
    rows: ComplexArray,
    spin_rad_s: float | None = None,
) -> _Sweep:
    """The sweep of an unbalance response over the speed."""
    ratios = [frequency_ratio(assembled, unbalance) for unbalance in unbalances]
    if not ratios or max(ratios) - min(ratios) > _SAME_RATIO * max(ratios):
        raise AnalysisError(
            f"unbalances turn at {ratios} times the speed; one or more of one ratio are allowed"
        )
    ratio = ratios[0]
    pattern = unbalance_loads(assembled, unbalances)

    def at(speed: float) -> _Point:
        derivative, omega = speed_derivative(assembled, speed), ratio * speed

        def slope(matrices: SpeedMatrices) -> ComplexArray:
            along = _rate_derivative(matrices, 1j * omega)
            return derivative.at_rate(1j * omega) + 1j * ratio * along

        return _Point(speed, omega, omega**2 * pattern, slope)

    def at_spin(speed: float) -> _Point:
        omega, spin = ratio * speed, float(spins_at(np.array([speed]), spin_rad_s)[0])

        def slope(matrices: SpeedMatrices) -> ComplexArray:
            return 1j * ratio * _rate_derivative(matrices, 1j * omega)

        return _Point(spin, omega, omega**2 * pattern, slope)

    if spin_rad_s is not None:
        return _Sweep(at_spin, rows, ())
    return _Sweep(at, rows, tuple(assembled.knots_rad_s))


def harmonic_peak_errors(
    assembled: AssembledSystem,
    speed_rad_s: float,
    load: npt.ArrayLike,
    row: npt.ArrayLike,
    peaks: Sequence[ResonancePeak],
) -> PeakErrors:
    """Estimate the errors of the peaks of a harmonic response over the frequency.

    `load`: complex amplitudes f in the independent coordinates, the same at all frequencies, (n,);
    `row`: the motion that was looked at, per independent coordinate, shape (n,); `peaks`: of |row ·
    q| over the frequency ω. The result is of the frequencies and heights of the peaks. Raises
    AnalysisError if load or row have another length than the system has coordinates.
    """
    force, seen = (np.asarray(a, dtype=complex) for a in (load, row))
    if force.shape != (assembled.size,) or seen.shape != (assembled.size,):
        raise AnalysisError(
            f"load and row have shapes {force.shape} and {seen.shape}; allowed is "
            f"({assembled.size},)"
        )

    def at(omega: float) -> _Point:
        def slope(matrices: SpeedMatrices) -> ComplexArray:
            return 1j * _rate_derivative(matrices, 1j * omega)

        return _Point(float(speed_rad_s), omega, force, slope)

    return _peak_errors(assembled, _Sweep(at, seen[None]), peaks)


def _rate_derivative(matrices: SpeedMatrices, rate: complex) -> ComplexArray:
    """Return D'(s) = C + ΩG + 2 s M."""
    return np.asarray(matrices.damping + matrices.gyroscopic + 2.0 * rate * matrices.mass)


def _peak_errors(
    assembled: AssembledSystem, sweep: _Sweep, peaks: Sequence[ResonancePeak]
) -> PeakErrors:
    damped = not assembled.is_conservative
    count = len(peaks)
    position, height = ({"eigen_solver": np.zeros(count)} for _ in range(2))
    places = np.zeros(count)
    for index, peak in enumerate(peaks):
        found = _found_again(assembled, sweep, peak) if damped else None
        places[index] = found[0] if found else peak.position_rad_s
        solved = _solved(assembled, sweep, places[index])
        turn = solved.adjoint @ (solved.point.slope(solved.matrices) @ solved.motion)
        changes, solver = _changes(assembled, solved)
        moved = {part: abs(float((change / turn).real)) for part, change in changes.items()}
        higher = {part: abs(change.real) for part, change in changes.items()}
        moved["eigen_solver"], higher["eigen_solver"] = solver / float(abs(turn)), solver
        if found:
            moved["sampling"], higher["sampling"] = found[1:]
        for part in moved:
            position.setdefault(part, np.zeros(count))[index] = moved[part] / places[index]
            relative = higher[part] / solved.amplitude if damped else np.nan
            height.setdefault(part, np.zeros(count))[index] = relative
    return PeakErrors(
        position_rad_s=places,
        position=position,
        height=height,
        bodies_without_estimate=bodies_without_forms(assembled),
    )


def _found_again(
    assembled: AssembledSystem, sweep: _Sweep, peak: ResonancePeak
) -> tuple[float, float, float]:
    """Find a summit between the half-power points by the general solver.

    Returns its place, how far the given peak lies from it, and how far from its height.
    """
    middle = peak.position_rad_s
    low, high = peak.half_power_low_rad_s, peak.half_power_high_rad_s
    low = low if np.isfinite(low) else (1.0 - _NARROW) * middle
    high = high if np.isfinite(high) else (1.0 + _NARROW) * middle

    def curve(place: float) -> float:
        return _solved(assembled, sweep, place).amplitude

    tried = [summit(curve, low, high, sweep.knots), middle]
    place = max(tried, key=curve)
    probes = np.clip(place + (high - low) * _PROBES, low, high)
    heights = np.array([curve(probe) for probe in probes])
    top = curve(place)
    # What the search may have left: higher places, and the fall within its accuracy.
    missed = max(float(heights.max()) - top, 0.0)
    fall = float(np.abs(heights[np.abs(_PROBES) == SUMMIT] - top).max())
    shift = abs(place - middle) + SUMMIT * (high - low)
    return place, shift, abs(top - peak.amplitude) + missed + fall


def _solved(assembled: AssembledSystem, sweep: _Sweep, place: float) -> _Solved:
    """Solve for the motion and for the adjoint of the amplitude Σ |row u|."""
    point = sweep.at(float(place))
    matrices = matrices_at_speed(at_rate(assembled, 1j * point.omega), point.speed)
    balance = balance_of(matrices, 1j * point.omega)
    dynamic = dynamic_stiffness(matrices, 1j * point.omega)
    factors = la.lu_factor(balance[:, None] * dynamic * balance)
    motion = balance * la.lu_solve(factors, balance * point.load)
    seen = sweep.rows @ motion
    size = np.abs(seen)
    phase = np.where(size > 0, seen.conj() / np.where(size > 0, size, 1.0), 0.0)
    adjoint = balance * la.lu_solve(factors, balance * (phase @ sweep.rows), trans=1)
    return _Solved(motion, adjoint, float(size.sum()), matrices, point)


def _changes(assembled: AssembledSystem, solved: _Solved) -> tuple[dict[str, complex], float]:
    """Return zᵀ(E − Ω²ΔK2)u by part, weighted, and what the solution itself may have lost."""
    motion, adjoint, _, matrices, point = solved
    rate = np.array([1j * point.omega])
    changes: dict[str, complex] = {}
    for rows, ratio, form in body_forms(assembled):
        left, right = (rows @ adjoint)[:, None], (rows @ motion)[:, None]
        found = form_products(form, rate, ratio * point.speed, left, right)
        weighted = complex((form_weight(form, rate) * found)[0])
        changes[form.part] = changes.get(form.part, 0.0) + weighted
    residual = abs(adjoint @ (point.load - dynamic_stiffness(matrices, rate[0]) @ motion))
    rounding = np.abs(adjoint) @ (np.abs(matrices.stiffness) @ np.abs(motion))
    return changes, float(residual + np.finfo(float).eps * rounding)
