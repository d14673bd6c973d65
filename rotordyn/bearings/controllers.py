"""Linear controllers in continuous time: PID, filters, delays, and their series."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, factorial

import numpy as np
import scipy  # its linear algebra is loaded when it is used

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError

# A pole below this part of the largest is at 0; how slow a motion is beside the other poles.
_AT_ZERO, _SLOW = 1e-13, 1e-9


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Controller(ReadOnlyArrays):
    """H(s) = C (s − A)⁻¹ B + D + s R, from p signals to m.

    `a`: shape (n, n); `b`: (n, p); `c`: (m, n); `d`, `rate`: (m, p), `rate` being the gain of an
    ideal derivative, zero if left out. Raises AnalysisError if shapes do not fit or numbers are not
    finite.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray
    rate: FloatArray | None = None

    def __post_init__(self) -> None:
        if self.rate is None:
            object.__setattr__(self, "rate", np.zeros(np.shape(self.d)))
        ReadOnlyArrays.__post_init__(self)
        n, (m, p) = len(self.a), self.d.shape
        shapes = {"a": (n, n), "b": (n, p), "c": (m, n), "d": (m, p), "rate": (m, p)}
        for name, shape in shapes.items():
            found = getattr(self, name)
            if found.shape != shape or not np.isfinite(found).all():
                raise AnalysisError(
                    f"controller: {name} has shape {found.shape}; finite numbers of shape {shape} "
                    "are needed"
                )

    @property
    def gain_of_rate(self) -> FloatArray:
        """R, shape (m, p)."""
        return np.zeros(self.d.shape) if self.rate is None else self.rate

    def response(self, eigenvalue: complex) -> ComplexArray:
        """Return H at a complex frequency, shape (m, p)."""
        inner = np.linalg.solve(eigenvalue * np.eye(len(self.a)) - self.a, self.b)
        return np.asarray(self.c @ inner + self.d + eigenvalue * self.gain_of_rate)

    @property
    def integrates(self) -> bool:
        """Whether it has a pole at 0."""
        at_zero, _ = self._pole_sizes()
        return at_zero.size > 0

    def _pole_sizes(self) -> tuple[FloatArray, FloatArray]:
        """Return the absolute values of the poles at 0, and of the others."""
        sizes = np.abs(np.linalg.eigvals(self.a))
        at_zero = sizes <= _AT_ZERO * sizes.max(initial=0.0)
        return sizes[at_zero], sizes[~at_zero]

    def slow_gain(self) -> tuple[FloatArray, FloatArray]:
        """Return H(0) and H'(0), shape (m, p) each.

        A controller that integrates has none: then H of a real s that is slow beside its other
        poles, or beside 1 1/s where it has none, and no derivative.
        """
        at_zero, others = self._pole_sizes()
        if at_zero.size:
            slow = _SLOW * float(others.min() if others.size else 1.0)
            return self.response(slow).real, np.zeros(self.d.shape)
        inner = np.linalg.solve(self.a, self.b)
        slope = self.gain_of_rate - self.c @ np.linalg.solve(self.a, inner)
        return self.d - self.c @ inner, slope


def transfer(numerator: tuple[float, ...], denominator: tuple[float, ...]) -> Controller:
    """Return a quotient of polynomials, highest power first, the numerator of no higher order."""
    top, below = np.trim_zeros(numerator, "f"), np.trim_zeros(denominator, "f")
    if len(below) == 0 or len(top) > len(below):
        raise AnalysisError("controller: the numerator's order must not be above the denominator's")
    n = len(below) - 1
    under = np.array(below[1:], dtype=float) / below[0]
    over = np.concatenate((np.zeros(n + 1 - len(top)), np.array(top, dtype=float))) / below[0]
    a = np.zeros((n, n))
    a[1:, :-1] = np.eye(max(n - 1, 0))
    if n:
        a[0] = -under
    b = np.eye(n, 1)
    c = (over[1:] - over[0] * under)[None]
    # states of like size
    if n:
        a, (scale, _) = scipy.linalg.matrix_balance(a, permute=False, separate=True)
        b, c = b / scale[:, None], c * scale
    return Controller(a=a, b=b, c=c, d=np.array([[over[0]]]))


def pid(
    proportional: float, integral: float, derivative: float, roll_off_rad_s: float | None = None
) -> Controller:
    """Return P + I/s + D s / (1 + s / roll_off); without a roll-off the derivative is ideal."""
    parts = [_constant(proportional)]
    if integral:
        parts.append(transfer((integral,), (1.0, 0.0)))
    if derivative and roll_off_rad_s is None:
        zero = np.zeros((1, 1))
        parts.append(Controller(**_empty(), d=zero, rate=np.array([[derivative]])))
    elif derivative:
        parts.append(transfer((derivative, 0.0), (1.0 / float(roll_off_rad_s or 0), 1.0)))
    return Controller(
        a=scipy.linalg.block_diag(*(p.a for p in parts)),
        b=np.concatenate([p.b for p in parts]),
        c=np.concatenate([p.c for p in parts], axis=1),
        d=np.asarray(sum(p.d for p in parts)),
        rate=np.asarray(sum(p.gain_of_rate for p in parts)),
    )


def low_pass(cut_off_rad_s: float, damping_ratio: float | None = None) -> Controller:
    """Return a low-pass filter of first order, or of second order with a damping ratio."""
    if damping_ratio is None:
        return transfer((1.0,), (1.0 / cut_off_rad_s, 1.0))
    return transfer((1.0,), (cut_off_rad_s**-2, 2.0 * damping_ratio / cut_off_rad_s, 1.0))


def notch(centre_rad_s: float, depth_ratio: float, width_ratio: float) -> Controller:
    """Return (s² + 2 depth ω s + ω²) / (s² + 2 width ω s + ω²)."""
    own = (1.0, 2.0 * depth_ratio * centre_rad_s, centre_rad_s**2)
    return transfer(own, (1.0, 2.0 * width_ratio * centre_rad_s, centre_rad_s**2))


def delay(time_s: float, order: int = 3) -> Controller:
    """Return a delay by its Padé approximation, numerator and denominator of the same order.

    Its amplitude is exactly 1; with order 3 the phase misses by 1e-5 rad at 1/time, 8e-8 at half.
    """
    powers = [
        comb(order, k) * factorial(2 * order - k) / factorial(2 * order) * time_s**k
        for k in range(order, -1, -1)
    ]
    signs = [(-1.0) ** k for k in range(order, -1, -1)]
    return transfer(tuple(s * v for s, v in zip(signs, powers, strict=True)), tuple(powers))


def series(first: Controller, *then: Controller) -> Controller:
    """Return controllers one after the other."""
    whole = first
    for following in then:
        whole = _after(whole, following)
    return whole


def side_by_side(*parts: Controller) -> Controller:
    """Return controllers each with its own signals, such as those of the axes x and y."""
    names = ("a", "b", "c", "d", "gain_of_rate")
    blocks = [scipy.linalg.block_diag(*(getattr(p, name) for p in parts)) for name in names]
    a, b, c, d, rate = blocks
    return Controller(a=a, b=b, c=c, d=d, rate=rate)


def _after(first: Controller, then: Controller) -> Controller:
    if then.gain_of_rate.any() and (first.gain_of_rate.any() or first.d.any()):
        raise AnalysisError(
            "controller: an ideal derivative after a part without roll-off; put it first"
        )
    b_rate = then.b @ first.gain_of_rate
    zero = np.zeros((len(first.a), len(then.a)))
    # s R drives the second: its state is shifted by b_rate times the signal
    return Controller(
        a=np.block([[first.a, zero], [then.b @ first.c, then.a]]),
        b=np.concatenate((first.b, then.b @ first.d + then.a @ b_rate)),
        c=np.concatenate(
            (then.d @ first.c + then.gain_of_rate @ first.c @ first.a, then.c), axis=1
        ),
        d=then.d @ first.d + then.c @ b_rate + then.gain_of_rate @ first.c @ first.b,
        rate=then.d @ first.gain_of_rate,
    )


def _constant(gain: float) -> Controller:
    return Controller(**_empty(), d=np.array([[gain]]))


def _empty() -> dict[str, FloatArray]:
    """Return the matrices of no states with one signal in and out."""
    return {"a": np.zeros((0, 0)), "b": np.zeros((0, 1)), "c": np.zeros((1, 0))}
