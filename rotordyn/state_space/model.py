"""State-space models of an engine between forces and motions at its interfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray, freeze_arrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.state_space.channels import Channels, ForceInput, Output, channels_at_speed


class StateMatrices(NamedTuple):
    """A (2n, 2n), B (2n, m), C (p, 2n) and D (p, m) at one speed: x' = A x + B u, y = C x + D u."""

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StateSpace:
    """Hold x' = A(Ω) x + B(Ω) u, y = C(Ω) x + D(Ω) u over a range of speeds.

    `form`: "polynomial": A(Ω) = A[0] + Ω A[1] + Ω² A[2], likewise B, C, D, exact at every speed.
    "table": A[k] at speeds_rad_s[k], linear between, with an error of second order in the distance
    of the speeds. `speeds_rad_s`: lowest and highest Ω for a polynomial, shape (2,); rising speeds
    of a table, shape (s,). `a`, `b`, `c`, `d`: shapes (k, 2n, 2n), (k, 2n, m), (k, p, 2n) and (k,
    p, m), k = 3 or s. `state_scale`: the state is x = (q, q') / state_scale with q in the
    independent coordinates of the system, shape (2n,); powers of two. `input_names`,
    `input_units`, `output_names`, `output_units`: of u and y, m and p texts.
    """

    form: Literal["polynomial", "table"]
    speeds_rad_s: FloatArray
    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray
    state_scale: FloatArray
    input_names: tuple[str, ...]
    input_units: tuple[str, ...]
    output_names: tuple[str, ...]
    output_units: tuple[str, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "speeds_rad_s", "a", "b", "c", "d", "state_scale")
        _check(self)

    @property
    def state_count(self) -> int:
        """Number of states 2n."""
        return int(self.state_scale.size)

    def at_speed(self, speed_rad_s: float) -> StateMatrices:
        """Return the matrices at one speed.

        `speed_rad_s`: Ω, rad/s. Returns A, B, C, D. Raises AnalysisError if the speed lies outside
        the range of the model.
        """
        low, high = float(self.speeds_rad_s[0]), float(self.speeds_rad_s[-1])
        if not low <= speed_rad_s <= high:
            raise AnalysisError(
                f"speed_rad_s is {speed_rad_s}; the model holds from {low:.6g} to {high:.6g} rad/s"
            )
        weights = self._weights(speed_rad_s)
        parts = (np.tensordot(weights, term, 1) for term in (self.a, self.b, self.c, self.d))
        return StateMatrices(*parts)

    def _weights(self, speed: float) -> FloatArray:
        """Return the factor of each stored matrix."""
        if self.form == "polynomial":
            return np.array([1.0, speed, speed**2])
        return np.array([np.interp(speed, self.speeds_rad_s, row) for row in np.eye(len(self.a))])


def state_space(
    assembled: AssembledSystem,
    inputs: Sequence[ForceInput],
    outputs: Sequence[Output],
    speed_range_rad_s: tuple[float, float],
) -> StateSpace:
    """Build the state-space model of a system with constant bearings, exact at every speed.

    `assembled`: the system; for a small model, `modal_truncation.truncated_system` of it.
    `inputs`, `outputs`: forces, motions and bearing forces; `speed_range_rad_s`:
    lowest and highest Ω. The result is of the form "polynomial". Raises AnalysisError if a bearing
    depends on the speed, the range is empty or not finite, or an input or output does not exist.

    A = [[0, 1], [−M⁻¹(K + ΩN + Ω²K2), −M⁻¹(C + ΩG)]], a polynomial in Ω. The state is scaled by
    powers of two that balance the rows and columns of the sum of |A| over the range, one scale for
    all speeds, so the polynomial stays one.
    """
    low, high = (float(v) for v in speed_range_rad_s)
    if not (np.isfinite([low, high]).all() and low < high):
        raise AnalysisError(f"speed_range_rad_s is {speed_range_rad_s}; needed is low < high")
    if not assembled.has_constant_bearings:
        raise AnalysisError(
            "a bearing depends on the speed, so the model is no polynomial in Ω; use "
            "tabulated_state_space"
        )
    channels = channels_at_speed(assembled, inputs, outputs, 0.0)
    none = np.zeros_like(assembled.mass)
    terms = [
        _term(assembled, channels, assembled.stiffness, assembled.damping),
        _rate_term(assembled, channels, assembled.circulatory_stiffness, assembled.gyroscopic),
        _rate_term(assembled, channels, assembled.centrifugal_stiffness, none),
    ]
    fastest = max(abs(low), abs(high))
    size = sum(fastest**power * np.abs(term.a) for power, term in enumerate(terms))
    return _scaled("polynomial", np.array([low, high]), terms, np.asarray(size), (inputs, outputs))


def tabulated_state_space(
    assembled: AssembledSystem,
    inputs: Sequence[ForceInput],
    outputs: Sequence[Output],
    speeds_rad_s: npt.ArrayLike,
) -> StateSpace:
    """Build the state-space model of any system at a number of speeds.

    `assembled`: the system, with bearings of any kind; `inputs`, `outputs`: forces, ground
    motions, motions and bearing forces; `speeds_rad_s`: Ω, rising, two or more, shape (s,). The
    result is of the form "table": exact at these speeds. Raises AnalysisError if the speeds do not
    rise, or an input or output does not exist.
    """
    speeds = np.array(speeds_rad_s, dtype=float)
    rising = speeds.ndim == 1 and speeds.size > 1 and bool((np.diff(speeds) > 0).all())
    if not rising or not np.isfinite(speeds).all():
        raise AnalysisError(f"speeds_rad_s needs two or more rising speeds; found {speeds.shape}")
    terms = []
    for speed in speeds:
        matrices = matrices_at_speed(assembled, float(speed))
        channels = channels_at_speed(assembled, inputs, outputs, float(speed))
        velocity = matrices.damping + matrices.gyroscopic
        terms.append(_term(assembled, channels, matrices.stiffness, velocity))
    size = np.max([np.abs(term.a) for term in terms], axis=0)
    return _scaled("table", speeds, terms, size, (inputs, outputs))


def _term(
    assembled: AssembledSystem, channels: Channels, stiffness: FloatArray, velocity: FloatArray
) -> StateMatrices:
    """Return the unscaled matrices for one K and C + ΩG."""
    rate = _rate_term(assembled, channels, stiffness, velocity)
    n = assembled.size
    a, b, c = rate.a.copy(), rate.b.copy(), rate.c.copy()
    a[:n, n:] = np.eye(n)
    b[n:] = la.solve(assembled.mass, channels.load, assume_a="pos")
    c[:, :n] += channels.displacement
    c[:, n:] += channels.velocity
    return StateMatrices(a, b, c, channels.acceleration @ b[n:])


def _rate_term(
    assembled: AssembledSystem, channels: Channels, stiffness: FloatArray, velocity: FloatArray
) -> StateMatrices:
    """Return what a part of K and C + ΩG adds to the accelerations, and to outputs of them."""
    n, m, p = assembled.size, channels.load.shape[1], len(channels.acceleration)
    a = np.zeros((2 * n, 2 * n))
    a[n:] = -la.solve(assembled.mass, np.hstack((stiffness, velocity)), assume_a="pos")
    return StateMatrices(a, np.zeros((2 * n, m)), channels.acceleration @ a[n:], np.zeros((p, m)))


def _scaled(
    form: Literal["polynomial", "table"],
    speeds: FloatArray,
    terms: Sequence[StateMatrices],
    size: FloatArray,
    ends: tuple[Sequence[ForceInput], Sequence[Output]],
) -> StateSpace:
    """Return the record with states that balance `size`, the entries of |A|."""
    _, (scale, _) = la.matrix_balance(size, permute=False, separate=True)
    (inputs, input_units), (outputs, output_units) = (
        zip(*(item.name_and_unit for item in end), strict=True) for end in ends
    )
    return StateSpace(
        form=form,
        speeds_rad_s=speeds,
        a=np.array([term.a * scale / scale[:, None] for term in terms]),
        b=np.array([term.b / scale[:, None] for term in terms]),
        c=np.array([term.c * scale for term in terms]),
        d=np.array([term.d for term in terms]),
        state_scale=scale,
        input_names=inputs,
        input_units=input_units,
        output_names=outputs,
        output_units=output_units,
    )


def _check(model: StateSpace) -> None:
    """Refuse shapes that do not belong together."""
    size, m, p = model.state_scale.size, len(model.input_names), len(model.output_names)
    count = 3 if model.form == "polynomial" else model.speeds_rad_s.size
    wanted = {
        "speeds_rad_s": (2 if model.form == "polynomial" else count,),
        "a": (count, size, size),
        "b": (count, size, m),
        "c": (count, p, size),
        "d": (count, p, m),
        "state_scale": (size,),
    }
    for name, shape in wanted.items():
        found = getattr(model, name)
        if found.shape != shape or not np.isfinite(found).all():
            raise AnalysisError(
                f"state space: {name} has shape {found.shape}, needed are {shape} finite numbers"
            )
    if (len(model.input_units), len(model.output_units)) != (m, p):
        raise AnalysisError("state space: every input and output needs one unit")
