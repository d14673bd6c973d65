"""Events on paths of eigenvalues, solved on the operator itself: a root there, or none at all."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.core.second_order import SecondOrder, Triple
from solidwhirl.rotordyn.core.spectrum import residuals_of, rounding_of
from solidwhirl.rotordyn.core.tolerances import AT_REST, EVENT

# Steps of Newton's method for an event, and of inverse iteration for a root.
_STEPS, _ITERATIONS = 20, 3
# The shift lies beside the number by the first of these parts at which no pivot is zero.
_BESIDE = (1e-12, 1e-9, 1e-6)


class Refined(NamedTuple):
    """Roots (m,), right and left vectors (n, m) each, yᴴ P'(s) x = 1 with the laws frozen."""

    values: ComplexArray
    right: ComplexArray
    left: ComplexArray


class Located(NamedTuple):
    """Where a function of a root is zero: speed, root, right vector, residual in the operator.

    `rate`: how fast the function changes with the speed along the path.
    """

    speed: float
    value: complex
    right: ComplexArray
    residual: float
    rate: float


def refined(triple: Triple, near: complex, count: int = 1) -> Refined:
    """Return the roots of frozen matrices that are nearest to a number, equal ones with it.

    Inverse iteration with P(s) and P'(s) of one vector more than roots are asked for: a double root
    has right vectors in one plane and left ones in the other, whose product is zero, if one vector
    alone is iterated.
    """
    n = len(triple.mass)
    # by the terms and not by their sum, which vanishes where a coordinate moves alone
    size = abs(near)
    terms = (np.abs(triple.mass) * size + np.abs(triple.velocity)) * size + np.abs(triple.stiffness)
    scale = 1.0 / np.sqrt(terms.max(axis=1) + np.finfo(float).tiny)[:, None]
    for beside in _BESIDE:
        solved("factorisations")
        dynamic = scale * triple.value(near * (1.0 + beside)) * scale.T
        *factors, singular = la.lapack.zgetrf(dynamic)
        if not singular:
            break
    else:
        raise AnalysisError(f"the system is singular at and around {near:.6g} 1/s")
    right = left = np.random.default_rng(0).standard_normal((n, min(count + 1, n))) + 0j
    pencil = scale * triple.slope(near) * scale.T
    for _ in range(_ITERATIONS):
        right = la.qr(la.lu_solve(tuple(factors), pencil @ right), mode="economic")[0]
        left = la.qr(la.lu_solve(tuple(factors), pencil.conj().T @ left, trans=2), mode="economic")[
            0
        ]
    right, left = scale * right, scale * left
    inner = left.conj().T @ triple.value(near) @ right
    slope = left.conj().T @ triple.slope(near) @ right
    steps, turn_left, turn_right = la.eig(inner, slope, left=True)
    at = np.argsort(np.abs(steps), kind="stable")[:count]
    right, left = right @ turn_right[:, at], left @ turn_left[:, at]
    product = np.einsum("ij,ij->j", left.conj(), triple.slope(near) @ right)
    # a defective root has none
    product = np.where(product == 0, np.inf, product)
    return Refined(near - steps[at], right, left / product.conj())


def located(
    operator: SecondOrder,
    speed: float,
    value: complex,
    function: Callable[[float, complex], float],
    derivative: Callable[[complex], float],
    *,
    whirl_ratio: float = 0.0,
    frequency: float = 0.0,
) -> Located | None:
    """Return the speed at which a real function of a root is zero, by Newton's method.

    `speed`, `value`: where the cubic of a path has it; `function`: of speed and root; `derivative`:
    of it along the path, from ds/dΩ; laws over the frequency are read at `frequency`, or at
    `whirl_ratio` times the speed if that is not 0. None if there is no such place nearby: cubics
    also make zeros that are none.
    """
    ratio = abs(whirl_ratio)
    for _ in range(_STEPS):
        if abs(value) <= np.finfo(float).tiny:  # a free motion
            return None
        triple = operator.at(speed, ratio * abs(speed) if ratio else frequency)
        values, rights, lefts = refined(triple, value)
        value, right, left = complex(values[0]), rights[:, 0], lefts[:, 0]
        if not np.isfinite(value):
            return None
        miss = function(speed, value)
        change = operator.along(speed, ratio) if ratio else operator.by_speed(speed, frequency)
        slope = -complex(left.conj() @ change.value(value) @ right)
        rate = derivative(slope)
        if miss == 0.0:
            break
        if rate == 0.0 or not np.isfinite(rate):
            return None
        step = -miss / rate
        speed, value = speed + step, value + slope * step
        if abs(step) <= AT_REST * abs(speed):
            break
    rounding = rounding_of(triple, np.array([value]), right[:, None], left[:, None])[0]
    if abs(miss) > max(EVENT * abs(value), float(rounding)):
        return None
    triple = operator.at(speed, ratio * abs(speed) if ratio else frequency)
    residual = residuals_of(triple, np.array([value]), right[:, None])[0]
    return Located(float(speed), value, right, float(residual), rate)


def met(
    operator: SecondOrder, speed: float, value: complex, whirl_ratio: float = 1.0
) -> Located | None:
    """Return where Im s = whirl_ratio · Ω, a critical speed; laws at that frequency, exactly."""
    return located(
        operator,
        speed,
        value,
        lambda at, root: root.imag - whirl_ratio * at,
        lambda slope: slope.imag - whirl_ratio,
        whirl_ratio=whirl_ratio,
    )


def neutral(operator: SecondOrder, speed: float, value: complex) -> Located | None:
    """Return where Re s = 0 for an operator without laws over the frequency: onset or end."""
    return located(operator, speed, value, lambda _, root: root.real, lambda slope: slope.real)
