"""The exact step of a run-up in modal coordinates, and how long a speed may be frozen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.run_up.modal_basis import ModalBasis
from solidwhirl.rotordyn.run_up.speed_table import tabulate

# Blocks are made for the allowed error of the phase over this, where steps are short enough.
_SPARE = 3.0
# Parts of the speed range in which the rate of change of the system is estimated.
_RATE_PARTS = 16


class Stride(NamedTuple):
    """So many steps of a length at once: `steps`, and `step_s`, h."""

    steps: int
    step_s: float

    @property
    def duration_s(self) -> float:
        """Time from one state to the next."""
        return self.steps * self.step_s


class StrideMatrices(NamedTuple):
    """Operators of m steps at s speeds, for rows x_{k+m} = x_k P + loads Q + constant.

    `propagators`: P, shape (s, 2n, 2n); `load_rows`: Q, shape (s, 2(m + 1)c, 2n): for the values
    at the m + 1 times of the steps, then for h times their rates there. `constant_rows`: for loads
    that do not change, shape (s, d, 2n); `accelerations`: η'' from x, shape (s, n, 2n).
    """

    propagators: FloatArray
    load_rows: FloatArray
    constant_rows: FloatArray
    accelerations: FloatArray


class StrideTable(NamedTuple):
    """The operators of a stride over a range of speeds; `entries`: numbers of those at one."""

    at: Callable[[npt.ArrayLike], StrideMatrices]
    entries: int


def stride_table(
    basis: ModalBasis,
    loads: FloatArray,
    constants: FloatArray,
    stride: Stride,
    acceleration_rad_s2: float,
    speeds_rad_s: tuple[float, float],
    smallest_width_rad_s: float,
) -> StrideTable:
    """Tabulate some steps at once over a range of speeds.

    `loads`: modal columns of the loads that turn, shape (n, c); `constants`: modal columns of the
    loads that stay, shape (n, d); `acceleration_rad_s2`: Ω' in this range; `speeds_rad_s`: both
    ends of the range, in any order, equal for constant speed. The range is cut at the knots of
    tabulated bearings.
    """

    def rows_at(speed: float) -> tuple[FloatArray]:
        return (basis.acceleration_rows(speed, acceleration_rad_s2),)

    def operators_at(speed: float) -> tuple[FloatArray, ...]:
        one = step_operators(basis.scale, *rows_at(speed), loads, constants, stride.step_s)
        return stride_operators(*one, stride.steps)

    edges = _edges(basis.assembled, *sorted(speeds_rad_s))
    # apart: the rows are of a much lower degree
    operators = tabulate(operators_at, edges, smallest_width_rad_s)
    rows = tabulate(rows_at, edges, smallest_width_rad_s)
    return StrideTable(
        lambda speeds: StrideMatrices(*operators(speeds), *rows(speeds)),
        operators.entries + rows.entries,
    )


def stride_operators(
    propagator: FloatArray, load_rows: FloatArray, constant_rows: FloatArray, steps: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return some steps at once, each as `step_operators` gives it.

    The loads are still cubics in each step. Returns Pᵀ to the power m = `steps` (2n, 2n), rows for
    values at the m + 1 times and for h times the rates there (2(m + 1)c, 2n), and (d, 2n).
    """
    if steps == 1:
        return propagator, load_rows, constant_rows
    size, columns = len(propagator), load_rows.shape[0] // 4
    of_step = load_rows.reshape(2, 2, columns, size)
    rows = np.zeros((2, steps + 1, columns, size))
    power, constant = np.eye(size), np.zeros_like(constant_rows)
    for k in range(steps):
        rows = rows @ propagator
        rows[:, k : k + 2] += of_step
        power, constant = power @ propagator, constant @ propagator + constant_rows
    return power, rows.reshape(2 * (steps + 1) * columns, size), constant


def step_operators(
    scale: FloatArray,
    acceleration: FloatArray,
    loads: FloatArray,
    constants: FloatArray,
    step_s: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the exact step of x' = A x + B a(t) for a(t) a cubic in each step.

    `scale`: σ, shape (n,); `loads`: lower half of B for loads given by values and rates at both
    ends, shape (n, c); `constants`: lower half of B for constant loads, shape (n, d).
    `acceleration`: lower half of A, shape (n, 2n); the upper half is (0, diag σ). Returns
    `propagator`, `load_rows`, `constant_rows`: Pᵀ (2n, 2n); (4c, 2n) and (d, 2n) as in
    `StepMatrices`.

    P = exp(hA) and the φ functions of the load come from one exponential of an augmented matrix
    (Al-Mohy and Higham 2011, SIAM J. Sci. Comput. 33, theorem 2.1; Hochbruck and Ostermann 2010,
    Acta Numerica 19, section 2). a(t) is the Hermite cubic of its values and rates, exact to
    (ωh)⁴/384 for a load of frequency ω; modes far above 1/h follow it statically, as they should.
    """
    n, c, d = scale.size, loads.shape[1], constants.shape[1]
    whole = np.zeros((2 * n + 4 * c + d,) * 2)
    whole[:n, n : 2 * n] = step_s * np.diag(scale)
    whole[n : 2 * n, : 2 * n] = step_s * acceleration
    whole[n : 2 * n, 2 * n : 2 * n + c] = step_s * loads
    whole[n : 2 * n, 2 * n + 4 * c :] = step_s * constants
    shift = np.arange(2 * n, 2 * n + 3 * c)
    whole[shift, shift + c] = 1.0
    top = la.expm(whole)[: 2 * n]
    phi = [top[:, 2 * n + k * c : 2 * n + (k + 1) * c].T for k in range(4)]
    # s^j of the cubic integrates to j! φ_{j+1}
    powers = [phi[0], phi[1], 2.0 * phi[2], 6.0 * phi[3]]
    rows = (
        powers[0] - 3.0 * powers[2] + 2.0 * powers[3],
        3.0 * powers[2] - 2.0 * powers[3],
        powers[1] - 2.0 * powers[2] + powers[3],
        powers[3] - powers[2],
    )
    propagator = np.ascontiguousarray(top[:, : 2 * n].T)
    return propagator, np.vstack(rows), np.ascontiguousarray(top[:, 2 * n + 4 * c :].T)


class FrequencyRates(NamedTuple):
    """How fast natural frequencies can change with the speed, in parts of the speed range.

    `edges_rad_s`: shape (p + 1,); `rates`: bound of |dω/dΩ| in each part, shape (p,).
    """

    edges_rad_s: FloatArray
    rates: FloatArray

    def largest(self, first_rad_s: float, last_rad_s: float) -> float:
        """Return the largest rate between two speeds."""
        low, high = sorted((first_rad_s, last_rad_s))
        touched = (self.edges_rad_s[:-1] <= high) & (self.edges_rad_s[1:] >= low)
        return float(self.rates[touched].max(initial=0.0))


def frequency_rates(
    bases: Sequence[ModalBasis], low_rad_s: float, high_rad_s: float
) -> FrequencyRates:
    """Bound the change of natural frequencies of parts of a system with the speed.

    `low_rad_s`, `high_rad_s`: range of speeds. Returns ½ ‖σ^-½ dK̃ σ^-½‖₂ + ‖dD̃‖₂ per dΩ of modal
    stiffness K̃ and velocity matrix D̃, from differences over parts of the range: the first order
    change of eigenvalues of modes that stiffness governs, and of tilting ones that only the
    gyroscopic moment governs.
    """
    if low_rad_s == high_rad_s:
        return FrequencyRates(np.array([low_rad_s, high_rad_s]), np.zeros(1))
    edges = np.linspace(low_rad_s, high_rad_s, _RATE_PARTS + 1)
    knots = [_edges(basis.assembled, low_rad_s, high_rad_s) for basis in bases]
    edges = np.unique(np.concatenate((edges, *knots)))
    rates = [_largest_changes(basis, edges) for basis in bases]
    return FrequencyRates(edges, np.max(rates, axis=0))


def _largest_changes(basis: ModalBasis, edges: FloatArray) -> FloatArray:
    """Return the bound in each part of the range."""
    rows = [basis.acceleration_rows(float(speed), 0.0) for speed in edges]
    n, root = basis.size, np.sqrt(basis.scale)
    rates = []
    for i in range(edges.size - 1):
        change = (rows[i + 1] - rows[i]) / (edges[i + 1] - edges[i])
        # columns of K̃ are already divided by σ
        stiffness = change[:, :n] * root / root[:, None]
        rates.append(0.5 * la.norm(stiffness, 2) + la.norm(change[:, n:], 2))
    return np.array(rates)


def block_length(
    rates: FrequencyRates,
    speeds_rad_s: tuple[float, float],
    acceleration_rad_s2: float,
    step_s: float,
    phase_error_rad: float,
) -> float:
    """Return how many steps may share one frozen speed; inf at constant speed.

    `speeds_rad_s`: both ends of a piece of the profile; `acceleration_rad_s2`: Ω' there;
    `phase_error_rad`: allowed error of the phase of a free vibration within a block. Returns a
    whole number, or inf, for a third of that error, but one step at least. Raises AnalysisError if
    one step is too many.

    With the speed of the middle of a block of duration H, the phase of a free vibration is right
    at its ends and off by at most |dω/dΩ| |Ω'| H²/8 in its middle.
    """
    change = rates.largest(*speeds_rad_s) * abs(acceleration_rad_s2)
    if change == 0:
        return float(np.inf)
    longest = float(np.sqrt(8.0 * phase_error_rad / change))
    if longest < step_s:
        raise AnalysisError(
            f"step_s is {step_s:.6g}: at {acceleration_rad_s2:.6g} rad/s² frequencies change by "
            f"{change:.3g} rad/s², which phase_error_rad {phase_error_rad:g} allows to freeze for "
            f"{longest:.3g} s; take no longer a step, or allow more"
        )
    return float(max(1.0, np.floor(longest / np.sqrt(_SPARE) / step_s * (1.0 + 1e-12))))


def _edges(assembled: AssembledSystem, low: float, high: float) -> list[float]:
    """Return the ends of a range and the speeds inside where a bearing's law has a knot."""
    inside = set()
    for joint in assembled.law_joints:
        inside |= {sign * knot for knot in (0.0, *joint.knots_rad_s) for sign in (-1.0, 1.0)}
    gap = 1e-9 * max(abs(low), abs(high))
    return sorted({low, high} | {k for k in inside if low + gap < k < high - gap})
