"""The exact step of a run-up in modal coordinates, tabulated over the speed, and runs of it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
from scipy.linalg.blas import dgemv

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.modal_truncation import rest_modes
from solidwhirl.rotordyn.run_up.loads import TurningLoads
from solidwhirl.rotordyn.run_up.record import MotionState
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile


class ModalBasis(NamedTuple):
    """All n modes at rest without damping: q = Φ η with ΦᵀMΦ = 1.

    The state is x = (σ η, η'), σ the natural frequency, so that its square is twice the energy
    and stiff coordinates do not spoil the scale. Rigid-body modes get the lowest other σ.

    `shapes`: Φ, shape (n, n); `scale`: σ in rad/s, shape (n,); `rest_stiffness`: diagonal of ΦᵀKΦ
    at rest, ±σ² and 0 for rigid-body modes, shape (n,).
    """

    assembled: AssembledSystem
    shapes: FloatArray
    scale: FloatArray
    rest_stiffness: FloatArray

    @property
    def size(self) -> int:
        """Number of coordinates n; the state has 2n entries."""
        return int(self.scale.size)

    @property
    def displacement(self) -> FloatArray:
        """Map from σ η to q, shape (n, n)."""
        return np.asarray(self.shapes / self.scale)

    def state(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        """Return x of a displacement and velocity in the independent coordinates, (2n,)."""
        momentum = self.shapes.T @ self.assembled.mass
        return np.concatenate((self.scale * (momentum @ displacement), momentum @ velocity))

    def motion(self, state: FloatArray) -> MotionState:
        """Return displacement and velocity in the independent coordinates of x, (n,) each."""
        return MotionState(
            displacement=self.displacement @ state[: self.size],
            velocity=self.shapes @ state[self.size :],
        )

    def acceleration_rows(self, speed_rad_s: float, acceleration_rad_s2: float) -> FloatArray:
        """Return the map from x to η'' without loads, shape (n, 2n).

        `speed_rad_s`, `acceleration_rad_s2`: Ω and Ω'. Returns −Φᵀ[K(Ω) + ½Ω'G]Φ/σ beside −Φᵀ[C(Ω)
        + ΩG]Φ.
        """
        matrices = matrices_at_speed(self.assembled, speed_rad_s)
        rest = matrices_at_speed(self.assembled, 0.0).stiffness
        # K at rest is diagonal in its modes; only the change is projected, to keep low modes exact.
        change = matrices.stiffness - 0.5 * (rest + rest.T)
        change = change + 0.5 * acceleration_rad_s2 * self.assembled.gyroscopic
        stiffness = np.diag(self.rest_stiffness) + self.shapes.T @ change @ self.shapes
        velocity = self.shapes.T @ (matrices.damping + matrices.gyroscopic) @ self.shapes
        return np.hstack((-stiffness / self.scale, -velocity))


def modal_basis(assembled: AssembledSystem) -> ModalBasis:
    """Return the modes at rest of a system, the rigid ones among them.

    The basis is complete, nothing is truncated. Raises AnalysisError if M is not positive definite.
    """
    squared, shapes = rest_modes(assembled)
    frequencies = np.sqrt(np.abs(squared))
    elastic = frequencies[frequencies > 0]
    floor = float(elastic.min()) if elastic.size else 1.0
    return ModalBasis(assembled, shapes, np.maximum(frequencies, floor), squared)


# Interpolation error over the largest entry of each matrix; far below that of freezing the speed.
_TOLERANCE = 1e-11
# Polynomial degrees tried, each on the nodes of the one before; then the range is halved.
_DEGREES = (2, 4, 8, 16)

Sample = Callable[[float], tuple[FloatArray, ...]]


class _SpeedPiece(NamedTuple):
    """Coefficients of the Chebyshev polynomials on one range, shape (degree + 1, entries)."""

    low: float
    high: float
    coefficients: FloatArray


class SpeedTable(NamedTuple):
    """Matrices as functions of the speed.

    `pieces`: ranges without gaps, rising.
    """

    pieces: tuple[_SpeedPiece, ...]
    shapes: tuple[tuple[int, ...], ...]

    def __call__(self, speed_rad_s: float) -> tuple[FloatArray, ...]:
        """Return the matrices at a speed in the range, to 1e-11 of the largest entry of each."""
        starts = [piece.low for piece in self.pieces]
        piece = self.pieces[max(0, bisect_right(starts, speed_rad_s) - 1)]
        width = piece.high - piece.low
        x = 0.0 if width == 0 else (2.0 * speed_rad_s - piece.low - piece.high) / width
        degrees = np.arange(piece.coefficients.shape[0])
        flat = np.cos(degrees * np.arccos(min(1.0, max(-1.0, x)))) @ piece.coefficients
        return _split(flat, self.shapes)


def tabulate(sample: Sample, edges: Sequence[float], smallest_width: float) -> SpeedTable:
    """Tabulate matrices over a range of speeds.

    `smallest_width`: ranges of this width are not halved any more, wherever a kink hides. `sample`:
    gives the matrices at a speed; their shapes do not change. `edges`: speeds, strictly rising,
    between which the function is smooth. A single one tabulates that speed alone. The
    interpolation of the table has been compared with the function between the nodes.

    Chebyshev interpolation in the extreme points, which converges geometrically for analytic
    functions (Trefethen 2019, Approximation Theory and Approximation Practice, chapters 4 and 8).
    """
    first = sample(edges[0])
    shapes = tuple(matrix.shape for matrix in first)
    if len(edges) == 1:
        return SpeedTable((_SpeedPiece(edges[0], edges[0], _joined(first)[None]),), shapes)
    pieces: list[_SpeedPiece] = []
    waiting = list(pairwise(edges))[::-1]
    while waiting:
        low, high = waiting.pop()
        piece, converged = _fitted(sample, low, high)
        if converged or high - low <= smallest_width:
            pieces.append(piece)
            continue
        middle = 0.5 * (low + high)
        waiting += [(middle, high), (low, middle)]
    return SpeedTable(tuple(pieces), shapes)


def _fitted(sample: Sample, low: float, high: float) -> tuple[_SpeedPiece, bool]:
    """Return the interpolant of the first degree that predicts the nodes of the next one."""
    values: dict[float, FloatArray] = {}
    sizes: list[int] = []
    coefficients = np.empty((0, 0))
    for degree in _DEGREES:
        # rounded, so that nodes of a degree are recognised among those of the next
        nodes = np.round(np.cos(np.pi * np.arange(degree + 1) / degree), 14)
        new = [float(x) for x in nodes if float(x) not in values]
        for x in new:
            matrices = sample(0.5 * (low + high) + 0.5 * (high - low) * x)
            sizes = [matrix.size for matrix in matrices]
            values[x] = _joined(matrices)
        if coefficients.size:
            known = np.array([values[x] for x in new])
            basis = np.cos(np.outer(np.arccos(new), np.arange(coefficients.shape[0])))
            if _agree(basis @ coefficients, known, sizes):
                return _SpeedPiece(low, high, _trimmed(coefficients, sizes)), True
        coefficients = _chebyshev(np.array([values[float(x)] for x in nodes]))
    trimmed = _trimmed(coefficients, sizes)
    # nothing finer to compare with: the last coefficients must have faded
    return _SpeedPiece(low, high, trimmed), trimmed.shape[0] <= _DEGREES[-1] - 2


def _chebyshev(values: FloatArray) -> FloatArray:
    """Return the coefficients of the interpolant of values at cos(jπ/N), j = 0 … N."""
    count = values.shape[0] - 1
    index = np.arange(count + 1)
    weight = np.where((index == 0) | (index == count), 0.5, 1.0)
    transform = np.cos(np.pi * np.outer(index, index) / count) * weight * weight[:, None]
    return np.asarray(2.0 / count * transform @ values)


def _agree(guess: FloatArray, known: FloatArray, sizes: Sequence[int]) -> bool:
    """Whether two rows of matrices agree, each matrix measured by its largest entry."""
    start = 0
    for size in sizes:
        part = slice(start, start + size)
        largest = np.abs(known[:, part]).max(initial=0.0)
        if np.abs(guess[:, part] - known[:, part]).max(initial=0.0) > _TOLERANCE * largest:
            return False
        start += size
    return True


def _trimmed(coefficients: FloatArray, sizes: Sequence[int]) -> FloatArray:
    """Drop the highest degrees that add less than a tenth of the tolerance to any matrix."""
    degree = coefficients.shape[0] - 1
    while degree > 0 and _agree(
        10.0 * coefficients[degree:] + coefficients[:1], coefficients[:1], sizes
    ):
        degree -= 1
    return np.ascontiguousarray(coefficients[: degree + 1])


def _joined(matrices: tuple[FloatArray, ...]) -> FloatArray:
    return np.concatenate([matrix.ravel() for matrix in matrices])


def _split(flat: FloatArray, shapes: Sequence[tuple[int, ...]]) -> tuple[FloatArray, ...]:
    ends = np.cumsum([np.prod(shape, dtype=int) for shape in shapes])
    parts = np.split(flat, ends[:-1])
    return tuple(part.reshape(shape) for part, shape in zip(parts, shapes, strict=True))


# Parts of the speed range in which the rate of change of the system is estimated.
_RATE_PARTS = 16


class StepMatrices(NamedTuple):
    """Operators at one speed, for x_{k+1} = P x_k + loads_k Q + constant.

    `propagator`: P, shape (2n, 2n), Fortran order. `load_rows`: Q, shape (4c, 2n): for values at
    the start and end of the step and for h times their rates there. `constant_rows`: for loads that
    do not change, shape (d, 2n); `acceleration`: η'' from x, shape (n, 2n).
    """

    propagator: FloatArray
    load_rows: FloatArray
    constant_rows: FloatArray
    acceleration: FloatArray


def step_table(
    basis: ModalBasis,
    loads: FloatArray,
    constants: FloatArray,
    step_s: float,
    acceleration_rad_s2: float,
    speeds_rad_s: tuple[float, float],
    smallest_width_rad_s: float,
) -> Callable[[float], StepMatrices]:
    """Tabulate the step over a range of speeds.

    `loads`: modal columns of the loads that turn, shape (n, c); `constants`: modal columns of the
    loads that stay, shape (n, d); `acceleration_rad_s2`: Ω' in this range; `speeds_rad_s`: both
    ends of the range, in any order, equal for constant speed. The range is cut at the knots of
    tabulated bearings.
    """

    def sample(speed: float) -> tuple[FloatArray, ...]:
        rows = basis.acceleration_rows(speed, acceleration_rad_s2)
        return (*step_operators(basis.scale, rows, loads, constants, step_s), rows)

    table = tabulate(sample, _edges(basis.assembled, *sorted(speeds_rad_s)), smallest_width_rad_s)

    def at(speed: float) -> StepMatrices:
        transposed, *rest = table(speed)
        return StepMatrices(transposed.T, *rest)

    return at


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


def frequency_rates(basis: ModalBasis, low_rad_s: float, high_rad_s: float) -> FrequencyRates:
    """Bound the change of natural frequencies with the speed.

    `low_rad_s`, `high_rad_s`: range of speeds. Returns ½ ‖σ^-½ dK̃ σ^-½‖₂ + ‖dD̃‖₂ per dΩ of modal
    stiffness K̃ and velocity matrix D̃, from differences over parts of the range: the first order
    change of eigenvalues of modes that stiffness governs, and of tilting ones that only the
    gyroscopic moment governs.
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

    `speeds_rad_s`: both ends of a piece of the profile; `acceleration_rad_s2`: Ω' there;
    `phase_error_rad`: allowed error of the phase of a free vibration within a block. Returns a
    whole number, or inf. Raises AnalysisError if one step is too many.

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


# Steps of a block at constant speed; bounds memory only.
_LONGEST = 1024
# A breakpoint may miss a step by this fraction of it, and a step may be an angle up to this.
_ON_STEP = 1e-6
_LARGEST_ANGLE = 1.0


class RunPlan(NamedTuple):
    """All that a run needs.

    `profile`: Ω(t); `turning`: unbalance; `steady`: load that never changes on the stacked
    coordinates, shape (N,); `torsion`: load per unit Ω' on the stacked coordinates, shape (N,);
    `phase_error_rad`: see `run_up_steps.block_length`.
    """

    basis: ModalBasis
    profile: SpeedProfile
    turning: TurningLoads
    steady: FloatArray
    torsion: FloatArray
    step_s: float
    phase_error_rad: float

    def modal(self, columns: FloatArray) -> FloatArray:
        """Return stacked loads on the modes, (n, ...) from (N, ...)."""
        transformation = self.basis.assembled.transformation
        return np.asarray(self.basis.shapes.T @ (transformation.T @ columns))


class Block(NamedTuple):
    """K steps with one frozen speed.

    `first_step`: number of the step at which it begins; `frozen_speed_rad_s`,
    `acceleration_rad_s2`: Ω in its middle, and Ω'; `speeds_rad_s`: Ω at its K + 1 times; `states`:
    x at its K + 1 times, shape (K + 1, 2n); `amplitudes`: factors of the unbalance columns, shape
    (K + 1, c); `constant`: loads that stay, on the stacked coordinates, shape (N,);
    `modal_constant`: the same on the modes, shape (n,); `rates`: η'' from x without loads, shape
    (n, 2n).
    """

    first_step: int
    frozen_speed_rad_s: float
    acceleration_rad_s2: float
    speeds_rad_s: FloatArray
    states: FloatArray
    amplitudes: FloatArray
    constant: FloatArray
    modal_constant: FloatArray
    rates: FloatArray

    def until(self, steps: int) -> Block:
        """Return its first steps."""
        some = slice(steps + 1)
        return self._replace(
            speeds_rad_s=self.speeds_rad_s[some],
            states=self.states[some],
            amplitudes=self.amplitudes[some],
        )


class ProfilePiece(NamedTuple):
    """A linear piece of the profile in whole steps: Ω at both ends, Ω', and ∫Ω dt before it."""

    first_step: int
    last_step: int
    speeds: tuple[float, float]
    acceleration: float
    start_angle: float


def blocks(plan: RunPlan, state: FloatArray) -> Iterator[Block]:
    """Run through the profile.

    `state`: x at time 0, shape (2n,). The result is in order, the last state of one being the first
    of the next. Raises AnalysisError if the step does not fit the profile, the unbalance or the
    acceleration.
    """
    pieces = profile_pieces(plan.profile, plan.step_s, plan.turning.ratios)
    speeds = plan.profile.speeds_rad_s
    rates = frequency_rates(plan.basis, float(speeds.min()), float(speeds.max()))
    loads = plan.modal(plan.turning.columns)
    for piece in pieces:
        for block in _piece_blocks(plan, piece, rates, loads, state):
            yield block
            state = block.states[-1]


def profile_pieces(
    profile: SpeedProfile, step_s: float, ratios: npt.ArrayLike
) -> list[ProfilePiece]:
    """Cut a profile into linear pieces of whole steps.

    `ratios`: speeds of what must turn by no more than a radian in a step, over that of the profile.
    Raises AnalysisError if the step does not fit.
    """
    h = step_s
    if not (np.isfinite(h) and h > 0):
        raise AnalysisError(f"step_s is {h}; it must be positive")
    steps = profile.times_s / h
    whole = np.rint(steps).astype(int)
    missed = np.abs(steps - whole)
    if (missed > _ON_STEP).any() or (np.diff(whole) < 1).any():
        at = float(profile.times_s[int(missed.argmax())])
        raise AnalysisError(
            f"step_s is {h:.9g}, but the breakpoint of the profile at {at:.9g} s is not a whole "
            "number of steps; change one of them"
        )
    fastest = float(np.abs(profile.speeds_rad_s).max())
    fastest *= float(np.abs(ratios).max(initial=0.0))
    if fastest * h > _LARGEST_ANGLE:
        raise AnalysisError(
            f"step_s is {h:.6g}, in which a body with unbalance turns by {fastest * h:.3g} rad; "
            f"take a step of at most {_LARGEST_ANGLE / fastest:.3g} s"
        )
    speeds = profile.speeds_rad_s.tolist()
    angles = profile.angle_rad(profile.times_s).tolist()
    slopes = profile.accelerations_rad_s2.tolist()
    return [
        ProfilePiece(
            int(whole[i]), int(whole[i + 1]), (speeds[i], speeds[i + 1]), slopes[i], angles[i]
        )
        for i in range(len(slopes))
    ]


def _piece_blocks(
    plan: RunPlan, piece: ProfilePiece, rates: FrequencyRates, loads: FloatArray, state: FloatArray
) -> Iterator[Block]:
    """Run through one linear piece of the profile."""
    h = plan.step_s
    constant = plan.steady + piece.acceleration * plan.torsion
    modal_constant = plan.modal(constant)
    longest = block_length(rates, piece.speeds, piece.acceleration, h, plan.phase_error_rad)
    width = abs(piece.acceleration) * h * min(longest, _LONGEST)
    table = step_table(
        plan.basis, loads, modal_constant[:, None], h, piece.acceleration, piece.speeds, width
    )
    size = int(min(longest, _LONGEST))
    fixed = table(piece.speeds[0])
    for first in range(piece.first_step, piece.last_step, size):
        last = min(first + size, piece.last_step)
        since = h * (np.arange(first, last + 1) - piece.first_step)
        speeds = piece.speeds[0] + piece.acceleration * since
        angles = piece.start_angle + 0.5 * (piece.speeds[0] + speeds) * since
        middle = 0.5 * float(speeds[0] + speeds[-1])
        matrices = fixed if piece.acceleration == 0 else table(middle)
        values, changes = plan.turning.amplitudes(angles, speeds, piece.acceleration)
        states = _stepped(matrices, state, values, h * changes)
        yield Block(
            first_step=first,
            frozen_speed_rad_s=middle,
            acceleration_rad_s2=piece.acceleration,
            speeds_rad_s=speeds,
            states=states,
            amplitudes=values,
            constant=constant,
            modal_constant=modal_constant,
            rates=matrices.acceleration,
        )
        state = states[-1]


def _stepped(
    matrices: StepMatrices, state: FloatArray, values: FloatArray, changes: FloatArray
) -> FloatArray:
    """Return the states of a block from its first one and its loads, (K + 1, 2n)."""
    ends = (values[:-1], values[1:], changes[:-1], changes[1:])
    states = np.empty((values.shape[0], state.size))
    states[0] = state
    states[1:] = np.hstack(ends) @ matrices.load_rows + matrices.constant_rows.sum(axis=0)
    propagate(matrices.propagator, states)
    return states


def propagate(propagator: FloatArray, states: FloatArray) -> None:
    """Replace row k of the states by P · row k−1 + row k, k = 1 … K, in place.

    `propagator`: P, shape (m, m), Fortran order; `states`: start in row 0, the loads of each step
    below, shape (K + 1, m), C order.
    """
    state = states[0]
    for row in states[1:]:
        # y = P x + y in one call of BLAS: alpha, a, x, beta, y, offsets, strides, no transpose,
        # overwrite y
        state = dgemv(1.0, propagator, state, 1.0, row, 0, 1, 0, 1, 0, 1)
