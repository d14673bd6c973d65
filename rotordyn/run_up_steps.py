"""One-step operators of the state equation with frozen speed: exponential integrator."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.run_up_basis import ModalBasis
from solidwhirl.rotordyn.run_up_table import SpeedTable, tabulate
from solidwhirl.rotordyn.system import AssembledSystem

# Parts of the speed range in which the rate of change of the system is estimated.
_RATE_PARTS = 16


class StepMatrices(NamedTuple):
    """Operators at one speed, for x_{k+1} = P x_k + loads_k Q + constant.

    Attributes
    ----------
    propagator
        P, shape (2n, 2n), Fortran order.
    load_rows
        Q, shape (4c, 2n): for values at the start and end of the step and for h times their rates
        there.
    constant_rows
        For loads that do not change, shape (d, 2n).
    acceleration
        η'' from x, shape (n, 2n).
    """

    propagator: FloatArray
    load_rows: FloatArray
    constant_rows: FloatArray
    acceleration: FloatArray


class StepTable(NamedTuple):
    """Step matrices as a function of the speed, for one step size and acceleration."""

    table: SpeedTable

    def at(self, speed_rad_s: float) -> StepMatrices:
        """Return the matrices at a speed of the range."""
        transposed, loads, constants, acceleration = self.table(speed_rad_s)
        return StepMatrices(transposed.T, loads, constants, acceleration)


def step_table(
    basis: ModalBasis,
    loads: FloatArray,
    constants: FloatArray,
    step_s: float,
    acceleration_rad_s2: float,
    speeds_rad_s: tuple[float, float],
    smallest_width_rad_s: float,
) -> StepTable:
    """Tabulate the step over a range of speeds.

    Parameters
    ----------
    basis
        Of the state.
    loads
        Modal columns of the loads that turn, shape (n, c).
    constants
        Modal columns of the loads that stay, shape (n, d).
    step_s
        h.
    acceleration_rad_s2
        Ω' in this range.
    speeds_rad_s
        Both ends of the range, in any order, equal for constant speed.
    smallest_width_rad_s
        See `tabulate`.

    Returns
    -------
    StepTable
        The range is cut at the knots of tabulated bearings.
    """

    def sample(speed: float) -> tuple[FloatArray, ...]:
        rows = basis.acceleration_rows(speed, acceleration_rad_s2)
        return (*step_operators(basis.scale, rows, loads, constants, step_s), rows)

    edges = _edges(basis.assembled, *sorted(speeds_rad_s))
    return StepTable(tabulate(sample, edges, smallest_width_rad_s))


def step_operators(
    scale: FloatArray,
    acceleration: FloatArray,
    loads: FloatArray,
    constants: FloatArray,
    step_s: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the exact step of x' = A x + B a(t) for a(t) a cubic in each step.

    Parameters
    ----------
    scale
        σ, shape (n,).
    acceleration
        Lower half of A, shape (n, 2n); the upper half is (0, diag σ).
    loads
        Lower half of B for loads given by values and rates at both ends, shape (n, c).
    constants
        Lower half of B for constant loads, shape (n, d).
    step_s
        h.

    Returns
    -------
    propagator, load_rows, constant_rows : ndarray
        Pᵀ (2n, 2n); (4c, 2n) and (d, 2n) as in `StepMatrices`.

    Notes
    -----
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

    Attributes
    ----------
    edges_rad_s
        Shape (p + 1,).
    rates
        Bound of |dω/dΩ| in each part, shape (p,).
    """

    edges_rad_s: FloatArray
    rates: FloatArray

    def largest(self, first_rad_s: float, last_rad_s: float) -> float:
        """Return the largest rate between two speeds."""
        low, high = sorted((first_rad_s, last_rad_s))
        touched = (self.edges_rad_s[:-1] <= high) & (self.edges_rad_s[1:] >= low)
        return float(self.rates[touched].max(initial=0.0))


def frequency_rates(basis: ModalBasis, low_rad_s: float, high_rad_s: float) -> FrequencyRates:
    """Bound the change of natural frequencies with the speed.

    Parameters
    ----------
    basis
        Of the state.
    low_rad_s, high_rad_s
        Range of speeds.

    Returns
    -------
    FrequencyRates
        ½ ‖σ^-½ dK̃ σ^-½‖₂ + ‖dD̃‖₂ per dΩ of modal stiffness K̃ and velocity matrix D̃, from
        differences over parts of the range: the first order change of eigenvalues of modes that
        stiffness governs, and of tilting ones that only the gyroscopic moment governs.
    """
    if low_rad_s == high_rad_s:
        return FrequencyRates(np.array([low_rad_s, high_rad_s]), np.zeros(1))
    edges = np.linspace(low_rad_s, high_rad_s, _RATE_PARTS + 1)
    edges = np.unique(np.concatenate((edges, _edges(basis.assembled, low_rad_s, high_rad_s))))
    rows = [basis.acceleration_rows(float(speed), 0.0) for speed in edges]
    n, root = basis.size, np.sqrt(basis.scale)
    rates = []
    for i in range(edges.size - 1):
        change = (rows[i + 1] - rows[i]) / (edges[i + 1] - edges[i])
        # columns of K̃ are already divided by σ
        stiffness = change[:, :n] * root / root[:, None]
        rates.append(0.5 * la.norm(stiffness, 2) + la.norm(change[:, n:], 2))
    return FrequencyRates(edges, np.array(rates))


def block_length(
    rates: FrequencyRates,
    speeds_rad_s: tuple[float, float],
    acceleration_rad_s2: float,
    step_s: float,
    phase_error_rad: float,
) -> float:
    """Return how many steps may share one frozen speed; inf at constant speed.

    Parameters
    ----------
    rates
        Of the system.
    speeds_rad_s
        Both ends of a piece of the profile.
    acceleration_rad_s2
        Ω' there.
    step_s
        h.
    phase_error_rad
        Allowed error of the phase of a free vibration within a block.

    Returns
    -------
    float
        A whole number, or inf.

    Raises
    ------
    AnalysisError
        If one step is too many.

    Notes
    -----
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
    return float(np.floor(longest / step_s * (1.0 + 1e-12)))


def _edges(assembled: AssembledSystem, low: float, high: float) -> list[float]:
    """Return the ends of a range and the speeds inside where a bearing's law has a knot."""
    inside = set()
    for joint in assembled.law_joints:
        inside |= {sign * knot for knot in (0.0, *joint.knots_rad_s) for sign in (-1.0, 1.0)}
    gap = 1e-9 * max(abs(low), abs(high))
    return sorted({low, high} | {k for k in inside if low + gap < k < high - gap})
